"""Where the user's cache lies, and how a file gets there."""

import os
from pathlib import Path


def cache_folder(kind):
    """Folder of the user's cache for `kind` ("fmus", "unpacked", "bodies"), made if missing.

    The root is $PISTON_COSIM_CACHE, else $XDG_CACHE_HOME/piston-cosim, else ~/.cache/piston-cosim.
    """
    if not (root := os.environ.get("PISTON_COSIM_CACHE")):
        root = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "piston-cosim"
    folder = Path(root).absolute() / kind
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def write_whole(path, content):
    """Write a file so that no other process ever sees a part of it.

    path : Path; content : bytes.

    Raises
    ------
    OSError
        Where the disk does not allow it.
    """
    partial = path.with_name(f"{path.name}.{os.getpid()}.part")
    partial.write_bytes(content)
    os.replace(partial, path)
