"""The user's cache folder, and atomic writing of files."""

import fcntl
import os
import subprocess
from collections.abc import Generator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO


def cache_folder(kind: str) -> Path:
    """Return the folder of the user's cache for `kind` ("fmus", "unpacked"); create it if missing.

    The root is $PISTON_COSIM_CACHE, else $XDG_CACHE_HOME/piston-cosim, else ~/.cache/piston-cosim.

    Raises
    ------
    OSError
        If the disk does not allow it, or the user has no home.
    """
    if not (root := os.environ.get("PISTON_COSIM_CACHE")):
        try:
            root = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache", "piston-cosim")
        except RuntimeError:
            raise OSError("the user has no home for a cache; set PISTON_COSIM_CACHE") from None
    folder = Path(root).absolute() / kind
    folder.mkdir(parents=True, exist_ok=True)
    return folder


MANY = ("fmus", "unpacked")
"""Kinds to which every change of a case adds a file or folder."""
COSTLY = ("bodies", "code", "native")
"""Kinds that take minutes to make anew."""


@contextmanager
def passing_fmus(folder: Path) -> Generator[None]:
    """Keep the FMUs that this process and its children build in a folder, and delete it at the end.

    A shell deletes it, so it does not remain if this process is killed.
    Everything else, such as compiled code and reduced bodies, is that of the user's cache.
    """
    before = os.environ.get("PISTON_COSIM_CACHE")
    (root,) = {cache_folder(kind).parent for kind in COSTLY}
    folder.mkdir(parents=True, exist_ok=True)
    for own in root.iterdir():
        with suppress(FileExistsError):
            if own.is_dir() and own.name not in MANY:
                (folder / own.name).symlink_to(own)
    delete = ["sh", "-c", 'cat; rm -rf "$0"', folder.absolute()]  # cat ends with this process
    with subprocess.Popen(delete, stdin=subprocess.PIPE, start_new_session=True):
        os.environ["PISTON_COSIM_CACHE"] = str(folder.absolute())
        try:
            yield
        finally:
            del os.environ["PISTON_COSIM_CACHE"]
            if before is not None:
                os.environ["PISTON_COSIM_CACHE"] = before


def try_lock(file: IO[str]) -> bool:
    """Return whether this process could lock an open file, which its closing unlocks."""
    with suppress(BlockingIOError):
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        return True
    return False


def write_whole(path: Path, content: bytes) -> None:
    """Write bytes to a file. Other processes never see it incomplete.

    Raises
    ------
    OSError
        If the disk does not allow it.
    """
    partial = path.with_name(f"{path.name}.{os.getpid()}.part")
    partial.write_bytes(content)
    os.replace(partial, path)
