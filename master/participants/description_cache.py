"""Cache of model descriptions, by content of the FMU.

FMPy creates an object for each element of each array. For a film of 40 x 40 cells that takes a
third of a second.
"""

import pickle
from contextlib import suppress
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any

import fmpy

from ..fmi import fields
from ..fmi.cache import cache_folder, write_whole


def cached_description(path: Path) -> tuple[Any, dict[str, fields.Field]] | None:
    """Return the cached description without its variables, and their fields; else None."""
    with suppress(Exception):  # whatever a damaged pickle raises
        return pickle.loads(_cached_path(path).read_bytes())
    return None


def cache_description(path: Path, description: Any, gathered: dict[str, fields.Field]) -> None:
    """Remove the variables from a description, and cache it with the fields if possible."""
    for name in ("modelVariables", "outputs", "derivatives", "initialUnknowns"):
        getattr(description, name).clear()
    with suppress(OSError):
        write_whole(_cached_path(path), pickle.dumps((description, gathered)))


def _cached_path(path):
    """Return the path of the cached description."""
    digest = sha256(Path(path).read_bytes() + _readers()).hexdigest()[:24]
    return cache_folder("descriptions") / f"{Path(path).stem}-{digest}.pickle"


@cache
def _readers():
    """Return the versions of the code that reads descriptions, on which the cache depends."""
    files = (__file__, str(fields.__file__))
    return b"".join([fmpy.__version__.encode(), *(Path(file).read_bytes() for file in files)])
