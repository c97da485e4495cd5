"""Lock of an output file: one process writes it, and the system releases its lock at exit."""

import fcntl
import json
import os
import platform
from contextlib import contextmanager, suppress
from datetime import datetime
from pathlib import Path

from ..fmi.errors import BadInput, file_fault


def lock_path(output):
    """Return the path of the lock of a file, which states the writer and the time."""
    return Path(f"{output}.lock")


@contextmanager
def sole_writer(output):
    """Hold the lock of `output`, and yield the function that removes its file.

    The lock of a dead process is taken over. Folders made for the lock are removed if they are
    empty.

    Raises
    ------
    BadInput
        If another process holds it, with its id and the time.
    """
    path = lock_path(output)
    missing = [folder for folder in path.parents if not folder.exists()]
    handle = _locked_file(path, output)

    def release():
        path.unlink(missing_ok=True)
        with suppress(OSError):  # not empty
            for folder in missing:
                folder.rmdir()

    try:
        yield release
    finally:
        release()
        os.close(handle)


def _locked_file(path, output):
    """Return the handle of the locked lock file."""
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
        os.close(handle)  # its last holder has removed it
    now = datetime.now().isoformat(timespec="seconds")
    words = json.dumps({"process": os.getpid(), "host": platform.node(), "since": now})
    os.ftruncate(handle, 0)
    os.pwrite(handle, words.encode(), 0)
    return handle


def _is_there(path, handle):
    """Return whether the file of the handle is still the one at the path."""
    try:
        return os.path.samestat(os.stat(path), os.fstat(handle))
    except FileNotFoundError:
        return False


def _who(data):
    """Return the part of a sentence that names the holder of a lock."""
    try:
        owner = json.loads(data)
        return f"process {owner['process']} on {owner['host']} since {owner['since']}"
    except (ValueError, KeyError, TypeError):
        return "another process"
