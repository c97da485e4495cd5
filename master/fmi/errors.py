"""How a user hears of trouble: bad input (all faults at once), a step that cannot be taken, a run
that stops, a bug in a participant.
"""

import os
import tomllib
from collections.abc import Iterable
from difflib import get_close_matches
from pathlib import Path


class BadInput(ValueError):
    """Input that cannot be used. It carries every fault, so that the user can correct all at once.

    Parameters
    ----------
    faults : str or list of str
        One sentence each: "KEY: expected X, got Y; hint".
    """

    def __init__(self, faults):
        self.faults = [faults] if isinstance(faults, str) else list(faults)
        super().__init__("\n".join(self.faults))


MOST_NAMES = 7
"""Names that a sentence lists; of more it lists the first ones."""


def names_of(known: Iterable[str]) -> str:
    """Return names as the expected part of a sentence: "one of a, b, c"."""
    names = [str(name) for name in known]
    if len(names) < 2:
        return names[0] if names else "no name"
    more = ", ..." if len(names) > MOST_NAMES else ""
    return f"one of {', '.join(names[:MOST_NAMES])}{more}"


def near(name: str, known: Iterable[str]) -> str:
    """Return "; did you mean 'name'?", or nothing if no known name is similar."""
    close = get_close_matches(name, [str(one) for one in known], 2, 0.6)
    return f"; did you mean {' or '.join(map(repr, close))}?" if close else ""


def unknown(kind: str, name: object, known: Iterable[str], hint: str = "") -> str:
    """Return "expected one of a, b, got unknown KIND 'name'; did you mean 'a'?"; `hint` replaces
    the question if no known name is similar.
    """
    known = list(known)
    question = near(str(name), known) or (f"; {hint}" if hint else "")
    if not known:
        return f"expected no {kind}, got {name!r}{question}"
    return f"expected {names_of(known)}, got unknown {kind} {name!r}{question}"


def file_fault(path: Path | str | None, error: Exception) -> str:
    """Return the sentence of a file or folder that cannot be read or written."""
    path = path or getattr(error, "filename", None) or "file"
    for kind, sentence in FILE_FAULTS.items():
        if isinstance(error, kind):
            return f"{path}: {sentence}"
    code = getattr(error, "errno", None)
    words = os.strerror(code).lower() if code else "an unreadable file"
    return f"{path}: expected a usable file, got {words}"


FILE_FAULTS: dict[type[Exception], str] = {
    FileNotFoundError: "expected an existing file, got no such file or folder",
    FileExistsError: "expected a new name, got an existing file or folder",
    IsADirectoryError: "expected a file, got a folder",
    NotADirectoryError: "expected a folder, got a file",
    PermissionError: "expected a file with permission, got access denied",
    UnicodeDecodeError: "expected a text file in UTF-8, got other bytes",
    tomllib.TOMLDecodeError: "expected a TOML file, got invalid syntax",
}
"""Sentences of the errors that reading and writing raise."""


class Discard(RuntimeError):
    """A step that physics or numerics refuse: the FMU answers fmi2Discard, its state is untouched,
    the master retries.
    """


class Ticked(Discard):
    """A clock ticks inside a step, at `time` [s]: it is to be taken to there, so that others hear
    of it.
    """

    def __init__(self, name, time):
        super().__init__(f"{name}: a clock ticks at t = {time:.6g} s")
        self.name, self.time = name, time

    def __reduce__(self):
        return Ticked, (self.name, self.time)


class Finished(RuntimeError):
    """A participant asks for the end of the simulation inside a step: what was accepted before
    stands.
    """


class Stopped(RuntimeError):
    """A run that came to an end before its own: what was accepted stands, notes say how to go on.

    Attributes
    ----------
    headline : str
        Of all runs that stop so; "" where what the error says is headline enough.
    """

    headline = ""


class ParticipantFault(Stopped):
    """A bug inside a participant: its traceback, as it logged it; or its process has hung or
    ended.
    """

    headline = "an FMU reports a fault of its own"
