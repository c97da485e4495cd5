"""Errors of the user and of participants: bad input, discarded steps, stopped runs, faults."""

import errno
import os
import re
import tomllib
from collections.abc import Callable, Generator, Iterable
from contextlib import contextmanager
from difflib import get_close_matches
from pathlib import Path
from typing import TypeVar

Item = TypeVar("Item")
Found = TypeVar("Found")


class BadInput(ValueError):
    """Input that cannot be used, with every fault, so that the user can correct all at once.

    Parameters
    ----------
    faults : str or list of str
        One sentence each: "KEY: expected X, got Y; hint".
    """

    def __init__(self, faults: str | Iterable[str]):
        self.faults = [faults] if isinstance(faults, str) else list(faults)
        super().__init__("\n".join(self.faults))


@contextmanager
def collecting(faults: list[str], before: str = "") -> Generator[None, None, None]:
    """Append the faults of a `BadInput` to a list, instead of raising it.

    Each fault gets the prefix `before`, unless it begins with the same key.
    """
    key = before.rstrip(".")
    try:
        yield
    except BadInput as error:
        has_key = key and re.compile(rf"{re.escape(key)}\b").match
        faults += [n if has_key and has_key(n) else f"{before}{n}" for n in error.faults]


def for_all(function: Callable[[Item], Found], items: Iterable[Item]) -> list[Found]:
    """Return the results of a function for all items; raise `BadInput` with the faults of all."""
    results: list[Found] = []
    faults: list[str] = []
    for item in items:
        with collecting(faults):
            results.append(function(item))
    if faults:
        raise BadInput(dict.fromkeys(faults))
    return results


MOST_NAMES = 7
"""Maximum number of names in a sentence."""


def names_of(known: Iterable[str]) -> str:
    """Return names as the expected part of a sentence: "one of a, b, c"."""
    names = [str(name) for name in known]
    if len(names) < 2:
        return names[0] if names else "no name"
    more = ", ..." if len(names) > MOST_NAMES else ""
    return f"one of {', '.join(names[:MOST_NAMES])}{more}"


def near(name: str, known: Iterable[str]) -> str:
    """Return "; did you mean 'name'?", or nothing if no known name is similar.

    Capitals and the hyphens of options do not count.
    """
    names = {str(one).lstrip("-").lower(): str(one) for one in known}
    lower_name = name.lstrip("-").lower()
    close = [names[one] for one in get_close_matches(lower_name, names, 2, 0.6)]
    return f"; did you mean {' or '.join(map(repr, close))}?" if close else ""


def unknown(kind: str, name: object, known: Iterable[str], hint: str = "") -> str:
    """Return "expected one of a, b, got unknown KIND 'name'; did you mean 'a'?".

    If no known name is similar, `hint` replaces the question.

    >>> unknown("method", "nwton", ["newton", "relaxation"])
    "expected one of newton, relaxation, got unknown method 'nwton'; did you mean 'newton'?"
    """
    known = list(known)
    question = near(str(name), known) or (f"; {hint}" if hint else "")
    if not known:
        return f"expected nothing, because there is no {kind}, got {name!r}{question}"
    return f"expected {names_of(known)}, got unknown {kind} {name!r}{question}"


def file_fault(path: Path | str | None, error: Exception) -> str:
    """Return the sentence of a file or folder that cannot be read or written."""
    path = path or getattr(error, "filename", None) or "file"
    parent = Path(str(path)).parent
    if isinstance(error, FileNotFoundError) and not parent.is_dir():
        return f"{path}: expected an existing folder {str(parent)!r}, got no such folder"
    wide = isinstance(error, UnicodeDecodeError) and error.object[:2] in (b"\xff\xfe", b"\xfe\xff")
    if isinstance(error, UnicodeDecodeError) and b"\0" in error.object[:1000] and not wide:
        return f"{path}: expected a text file, got a binary one"
    for kind, sentence in FILE_FAULTS.items():
        if isinstance(error, kind):
            return f"{path}: {sentence}"
    code = getattr(error, "errno", None) or 0
    words = os.strerror(code).lower() if code else "unreadable content"
    return f"{path}: expected {FAULTS_OF_SYSTEM.get(code, 'access')}, got {words}"


FILE_FAULTS: dict[type[Exception], str] = {
    FileNotFoundError: "expected an existing file, got no such file or folder",
    FileExistsError: "expected a new name, got an existing file or folder",
    IsADirectoryError: "expected a file, got a folder",
    NotADirectoryError: "expected a folder, got a file",
    PermissionError: "expected permission to read or write it, got access denied",
    UnicodeDecodeError: "expected a text file in UTF-8, got another encoding; save it as UTF-8",
    tomllib.TOMLDecodeError: "expected a TOML file, got invalid syntax",
}
"""Sentences of the errors that reading and writing raise."""
FAULTS_OF_SYSTEM = {
    errno.ENAMETOOLONG: "a shorter name",
    errno.ENOSPC: "free space on the disk",
    errno.EROFS: "a folder that can be written",
}
"""Expected condition by the error number of the operating system."""


class Discard(RuntimeError):
    """Step that physics or numerics reject.

    The FMU returns fmi2Discard, its state does not change, and the master retries.
    """


class NotFinite(Discard):
    """Step with an output that is NaN or infinite."""

    is_not_finite = True


class Ticked(Discard):
    """Clock that ticks inside a step, at `time` [s].

    The step must be repeated up to there, so that other participants receive the tick.
    """

    def __init__(self, name: str, time: float):
        super().__init__(f"{name}: a clock ticks at t = {time:.6g} s")
        self.name, self.time = name, time

    def __reduce__(self):
        return Ticked, (self.name, self.time)


class Finished(RuntimeError):
    """Participant that ends the simulation inside a step. Accepted steps remain valid."""


class Stopped(RuntimeError):
    """Run that stopped before its end. Accepted steps remain valid; notes explain how to resume.

    Attributes
    ----------
    headline : str
        Headline of all such errors. If empty, the message of the error is the headline.
    """

    headline = ""


class ParticipantFault(Stopped):
    """Fault inside a participant, with its logged traceback, or a process that hung or ended."""

    headline = "an FMU failed"


class CallFailed(ParticipantFault):
    """FMI call that returned a failure.

    Parameters
    ----------
    text : str
        Name of the participant, the call, and what the FMU logged.
    call : str
        The call and its status.
    status : int
        fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending, or an invalid number.
    """

    def __init__(self, text: str, call: str, status: int):
        super().__init__(text, call, status)  # all of them, so that a copy can be sent
        self.call, self.status = call, status

    def __str__(self):
        return self.args[0]


class CallDiscarded(CallFailed, Discard):
    """FMI call that returned fmi2Discard. Inside a step, it discards the step."""
