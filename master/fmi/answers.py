"""Answers of functions that follow from texts and numbers alone, kept from one process to the next,
for functions whose library takes longer to import than they take to answer.
"""

import atexit
import json
from collections.abc import Callable
from contextlib import suppress
from functools import cache, wraps
from hashlib import sha256
from importlib.util import find_spec
from pathlib import Path
from typing import Any, TypeVar, cast

from .cache import cache_folder, write_whole

MOST = 5000
"""Answers in a file; one that has more begins anew."""
PLAIN = (str, int, float)
Asked = TypeVar("Asked", bound=Callable[..., Any])


def kept_answers(library: str) -> Callable[[Asked], Asked]:
    """Decorator of a function that asks a library. Its answers are kept in the user's cache where
    the disk allows it, until the library is another or the file that the function stands in; what
    it raises is not kept. Arguments, by position, and answers are texts, numbers or bool.
    """

    def decorate(function: Asked) -> Asked:
        @wraps(function)
        def ask(*asked):
            if not all(isinstance(one, PLAIN) for one in asked):
                return function(*asked)
            kept = _answers(library, function.__code__.co_filename)
            key = json.dumps([function.__name__, *asked])
            if key not in kept:
                kept[key] = function(*asked)
            return kept[key]

        return cast(Asked, ask)

    return decorate


@cache
def _answers(library, source):
    """Answers of functions in one file, a dictionary by question that is written at the end of the
    process.
    """
    of = find_spec(library)
    stamp = Path(of.origin).stat() if of and of.origin else None
    of_library = f"{of and of.origin} {stamp and stamp.st_mtime_ns}".encode()
    name = f"answers-{sha256(of_library + Path(source).read_bytes()).hexdigest()[:16]}.json"
    known = _read(name)
    atexit.register(_write, name, known, len(known))
    return known


def _read(name):
    with suppress(OSError, ValueError):
        return json.loads((cache_folder("answers") / name).read_text())
    return {}


def _write(name, known, before):
    """Beside what other processes have added meanwhile."""
    if len(known) == before:
        return
    together = _read(name) | known
    with suppress(OSError):
        kept = together if len(together) <= MOST else known
        write_whole(cache_folder("answers") / name, json.dumps(kept).encode())
