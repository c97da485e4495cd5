"""One writer for one file: whoever writes results holds a lock beside them, which the system gives
back when its process ends, however it ends.
"""

import fcntl
import json
import os
import platform
from contextlib import contextmanager, suppress
from datetime import datetime
from pathlib import Path

from ..fmi.errors import BadInput, file_fault


def lock_path(output):
    """Where the lock of a file lies; what it holds says who writes, and since when."""
    return Path(f"{output}.lock")


@contextmanager
def sole_writer(output):
    """Hold the lock of `output`, and yield the function that removes its file.

    The lock of a dead process is taken over. Folders made for the lock are removed if they are
    empty.

    Raises
    ------
    BadInput
        If another process holds it: which one, and since when.
    """
    path = lock_path(output)
    made = [folder for folder in path.parents if not folder.exists()]
    handle = _held(path, output)

    def release():
        path.unlink(missing_ok=True)
        with suppress(OSError):  # not empty
            for folder in made:
                folder.rmdir()

    try:
        yield release
    finally:
        release()
        os.close(handle)


def _held(path, output):
    """Handle on the lock file, locked."""
    while True:
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
        except OSError as error:
            raise BadInput(f"--output: {file_fault(path, error)}") from None
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            words = _who(os.pread(handle, 4096, 0))
            os.close(handle)
            raise BadInput(
                f"--output: expected a file that no run writes, got {output}, written by {words}; "
                "wait, or give another --output"
            ) from None
        except OSError as error:
            os.close(handle)
            raise BadInput(f"--output: {file_fault(path, error)}") from None
        if _is_there(path, handle):
            break
        os.close(handle)  # its last holder has removed it meanwhile
    now = datetime.now().isoformat(timespec="seconds")
    words = json.dumps({"process": os.getpid(), "host": platform.node(), "since": now})
    os.ftruncate(handle, 0)
    os.pwrite(handle, words.encode(), 0)
    return handle


def _is_there(path, handle):
    """Whether the file behind the handle is still the one at the path."""
    try:
        return os.path.samestat(os.stat(path), os.fstat(handle))
    except FileNotFoundError:
        return False


def _who(data):
    """Sentence part on who holds a lock."""
    try:
        held = json.loads(data)
        return f"process {held['process']} on {held['host']} since {held['since']}"
    except (ValueError, KeyError, TypeError):
        return "another process"
