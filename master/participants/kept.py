"""What was read of an FMU's model description, kept by the file's content: FMPy makes an object of
each element of each array, which for a film of 40 x 40 cells takes a third of a second.
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


def kept_description(path: Path) -> tuple[Any, dict[str, fields.Field]] | None:
    """FMPy's model description without its variables, and the fields gathered from these; None of
    an FMU that is read for the first time, and where what was kept cannot be read.
    """
    with suppress(Exception):  # whatever a damaged pickle raises
        return pickle.loads(_place(path).read_bytes())
    return None


def keep_description(path: Path, description: Any, gathered: dict[str, fields.Field]) -> None:
    """Take the variables out of a description, and keep it with what was gathered from them where
    the disk allows it.
    """
    for name in ("modelVariables", "outputs", "derivatives", "initialUnknowns"):
        getattr(description, name).clear()
    with suppress(OSError):
        write_whole(_place(path), pickle.dumps((description, gathered)))


def _place(path):
    """Where it is kept."""
    digest = sha256(Path(path).read_bytes() + _readers()).hexdigest()[:24]
    return cache_folder("descriptions") / f"{Path(path).stem}-{digest}.pickle"


@cache
def _readers():
    """What reads descriptions: another one may read something else."""
    files = (__file__, str(fields.__file__))
    return b"".join([fmpy.__version__.encode(), *(Path(file).read_bytes() for file in files)])
