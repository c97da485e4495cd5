"""Cached results of functions whose library takes longer to import than they take to run.

The results depend on the arguments alone, which are texts and numbers.
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
"""Maximum number of results in a file. A file with more of them is replaced."""
PLAIN = (str, int, float)
Asked = TypeVar("Asked", bound=Callable[..., Any])


def cached_results(library: str) -> Callable[[Asked], Asked]:
    """Return a decorator that caches the results of a function in the user's cache.

    The cache is valid until `library` or the source file of the function changes. Exceptions are
    not cached. Arguments are positional. Arguments and results are texts, numbers or bool.
    """

    def decorate(function: Asked) -> Asked:
        @wraps(function)
        def ask(*asked):
            if not all(isinstance(one, PLAIN) for one in asked):
                return function(*asked)
            kept = _results(library, function.__code__.co_filename)
            key = json.dumps([function.__name__, *asked])
            if key not in kept:
                kept[key] = function(*asked)
            return kept[key]

        return cast(Asked, ask)

    return decorate


@cache
def _results(library, source):
    """Return the results of the functions in one file, by question; saved when the process ends."""
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
    """Save the results, merged with those that other processes have saved meanwhile."""
    if len(known) == before:
        return
    together = _read(name) | known
    with suppress(OSError):
        kept = together if len(together) <= MOST else known
        write_whole(cache_folder("answers") / name, json.dumps(kept).encode())
