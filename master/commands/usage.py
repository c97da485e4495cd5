"""Faults of a call: errors of the command line, files and folders, as one sentence each."""

import os
from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any, get_args

from cyclopts import CycloptsError
from cyclopts import exceptions as usage

from ..fmi.errors import BadInput, file_fault, unknown


def check_values(words: Sequence[str]) -> None:
    """Raise `BadInput` for an option with an empty value, which would be the current folder."""
    for option, value in pairwise([*words, "none"]):
        name, sign, own = option.partition("=")
        if name.startswith("--") and not (own if sign else value):
            raise BadInput(f"{name}: expected a value, got ''")


KINDS = {int: "a whole number", float: "a number", bool: "true or false", Path: "a path"}
"""Expected value of an option, by its type."""


def faults_of(error: Exception) -> list[str]:
    """Return the sentences of an error that the user can correct."""
    if isinstance(error, BadInput):
        return error.faults
    if isinstance(error, CycloptsError):
        return [_of_call(error)]
    if is_damaged(error):
        return ["files: expected complete results files, got a damaged one; run again"]
    return [file_fault(None, error)]


def is_damaged(error: Exception) -> bool:
    """Return whether an error is that of HDF5 for content that cannot be read."""
    return isinstance(error, OSError) and "synchronously" in str(error)


def _of_call(error: CycloptsError) -> str:
    """Return the fault in the words of a call."""
    match error:
        case usage.UnknownOptionError():
            word = error.token.keyword or error.token.value
            names = (name for one in error.argument_collection for name in one.names)
            return f"{word}: {unknown('option', word, (n for n in names if n.startswith('--')))}"
        case usage.UnknownCommandError():
            word = (error.unused_tokens or [""])[0]
            known = [name for name in error.app or () if not name.startswith("-")]
            return f"{word}: {unknown('command', word, known)}"
        case usage.MissingArgumentError():
            return f"{_name(error)}: expected a value, got nothing"
        case usage.CoercionError():
            if (message := str(error.msg or "")).startswith("expected"):
                return f"{_name(error)}: {message}"  # of `whole`
            value = error.token.value if error.token else ""
            choices = get_args(error.target_type)
            if choices and all(isinstance(one, str) for one in choices):
                return f"{_name(error)}: {unknown('choice', value, choices)}"
            expected = KINDS.get(error.target_type or str, "another value")
            return f"{_name(error)}: expected {expected}, got {value!r}"
        case usage.ValidationError():
            return f"{_name(error)}: {error.exception_message}"
        case usage.RepeatArgumentError():
            return f"{error.token.keyword}: expected one value, got several"
        case usage.RequiresEqualsError():
            return f"{_name(error)}: expected {_name(error)}=VALUE, got no equals sign"
    words = " ".join(error.unused_tokens or []) or "other words"
    return f"arguments: expected the arguments of the command, got {words!r}; see --help"


def _name(error: Any) -> str:
    """Return an argument as the user writes it."""
    name = error.argument.name if error.argument else "arguments"
    return name if name.startswith("-") else name.upper()


def new_file(_type: Any, path: Path | None) -> None:
    """Create the folder of the file `path`; a validator of options.

    Raises `ValueError` if this is impossible, or if `path` is a folder or a results file.
    """
    if path is None:
        return
    if path.is_dir():
        raise ValueError(f"expected a file, got the folder {str(path)!r}")
    if path.suffix == ".h5":
        raise ValueError(f"expected no results file, which only a run writes, got {str(path)!r}")
    new_folder(_type, path.parent)
    path.parent.mkdir(parents=True, exist_ok=True)


def with_suffix(*suffixes: str) -> Callable[[Any, Path | None], None]:
    """Return a validator of options that raises `ValueError` for files with other suffixes."""

    def check(_type: Any, path: Path | None) -> None:
        if path is not None and path.suffix not in suffixes:
            raise ValueError(f"expected a file {', '.join(suffixes)}, got {str(path)!r}")

    return check


def positive(_type: Any, value: float | None) -> None:
    """Raise `ValueError` unless a number is above 0; a validator of options."""
    if value is not None and not value > 0:
        raise ValueError(f"expected a number above 0, got {value}")


def whole(_type: Any, tokens: Sequence[Any]) -> int:
    """Return a whole number; a converter of options that raises `ValueError` for others."""
    try:
        return int(tokens[0].value)
    except ValueError:
        raise ValueError(f"expected a whole number, got {tokens[0].value!r}") from None


def new_folder(_type: Any, path: Path | None) -> None:
    """Raise `ValueError` unless `path` is a folder or can become one; a validator of options."""
    if path is None:
        return
    there = next(one for one in (path, *path.absolute().parents) if one.exists())
    if not there.is_dir():
        raise ValueError(f"expected a folder, got the file {str(there)!r}")
    try:
        with TemporaryFile(dir=there):
            pass
    except OSError as error:
        words = os.strerror(error.errno or 0).lower()
        raise ValueError(
            f"expected a folder that can be written, got {str(there)!r}: {words}"
        ) from None
