"""numba's store of compiled kernels, by the content of all files that a kernel is made of.

Processes that start together compile each kernel once: the first one that needs a kernel locks it,
and the others wait and load it. A process waits only for callees of what it compiles. No kernel is
recursive, so processes never wait for each other in a circle.
"""

import fcntl
import time
from contextlib import suppress
from functools import cache, cached_property
from hashlib import sha256
from pathlib import Path
from typing import IO

from numba.core.caching import FunctionCache, IndexDataCacheFile

from .callees import CalleeKept
from .tree import reached

LONGEST_WAIT = 120.0
"""Time after which a process compiles a kernel that another process still holds [s]."""


class KernelCache(FunctionCache):
    """numba's cache on disk, stamped with the content of all that a kernel is made of."""

    ending = ""
    _lock: IO | None = None

    def __init__(self, kernel):
        super().__init__(kernel)
        del self._cache_file  # numba's own stamp

    @cached_property
    def _cache_file(self):
        """Index of the cached kernels, opened at the first call because its stamp is slow."""
        return IndexDataCacheFile(
            self._cache_path,
            self._impl.filename_base + self.ending,
            stamp(self._py_func.__code__.co_filename),
        )

    def load_overload(self, signature, target_context):
        """Return the cached kernel; None, with the kernel locked, if it must be compiled here.

        If the cached files cannot be read, all of this kernel are removed.
        """
        kernel = self._load(signature, target_context)
        if kernel is None and self._lock is None:
            self._acquire()
            kernel = self._load(signature, target_context)  # another process may have compiled it
            if kernel is not None:
                self._release()
        return kernel

    def _load(self, signature, target_context):
        try:
            return super().load_overload(signature, target_context)
        except Exception:  # whatever a damaged pickle raises
            with suppress(OSError):
                self.flush()
            return None

    def save_overload(self, signature, data):
        """Save a kernel if the disk allows it, and unlock it."""
        with suppress(OSError):
            super().save_overload(signature, data)
        self._release()

    def _acquire(self):
        """Lock the kernel, or return after `LONGEST_WAIT` or if the disk does not allow it."""
        name = f"{self._impl.filename_base}{self.ending}.lock"
        end = time.monotonic() + LONGEST_WAIT
        with suppress(OSError):
            self._lock = Path(self._cache_path, name).open("w")
            while time.monotonic() < end:
                with suppress(BlockingIOError):
                    return fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                time.sleep(0.02)
        return None

    def _release(self):
        if self._lock is not None:
            self._lock.close()
            self._lock = None


class CalleeCache(KernelCache):
    """numba's cache of kernels that other kernels contain, the same for all processors."""

    _impl_class = CalleeKept
    ending = ".callee"

    def _index_key(self, sig, codegen):
        signature, (triple, *_), code = super()._index_key(sig, codegen)
        return signature, triple, code


@cache
def stamp(file: str) -> str:
    """Return the digest of a source file and of all project files that it reaches by imports."""
    digest = sha256()
    for path in sorted(reached(Path(file).resolve())):
        digest.update(path.read_bytes())
    return digest.hexdigest()
