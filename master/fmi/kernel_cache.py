"""numba's store of compiled kernels, by the content of all files that a kernel is made of.

Processes that start together compile each kernel once: the first one that needs a kernel locks it,
and the others wait and load it. A process waits only for callees of what it compiles. No kernel is
recursive, so processes never wait for each other in a circle.
"""

import time
from contextlib import suppress
from functools import cache, cached_property
from hashlib import sha256
from importlib import import_module
from pathlib import Path
from typing import IO, Any

from .cache import try_lock
from .callees import CalleeKept
from .tree import reached

CACHING: Any = import_module("numba.core.caching")
"""Module of numba without types."""

LONGEST_WAIT = 120.0
"""Time after which a process compiles a kernel that another process still holds [s]."""


class KernelCache(CACHING.FunctionCache):
    """numba's cache on disk, stamped with the content of all that a kernel is made of."""

    ending = ""
    _cache_path: Any
    _impl: Any
    _py_func: Any
    _lock: IO[str] | None = None

    def __init__(self, kernel: Any):
        CACHING.FunctionCache.__init__(self, kernel)
        del self._cache_file  # numba's own stamp

    @cached_property
    def _cache_file(self) -> Any:
        """Index of the cached kernels, opened at the first call because its stamp is slow."""
        return CACHING.IndexDataCacheFile(
            self._cache_path,
            self._impl.filename_base + self.ending,
            stamp(self._py_func.__code__.co_filename),
        )

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the cached kernel; None, with the kernel locked, if it must be compiled here.

        If the cached files cannot be read, all of this kernel are removed.
        """
        kernel = self._load(sig, target_context)
        if kernel is None and self._lock is None:
            self._acquire()
            kernel = self._load(sig, target_context)  # another process may have compiled it
            if kernel is not None:
                self._release()
        return kernel

    def _load(self, sig: Any, target_context: Any) -> Any:
        try:
            return CACHING.FunctionCache.load_overload(self, sig, target_context)
        except Exception:  # whatever a damaged pickle raises
            with suppress(OSError):
                self.flush()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Save a kernel if the disk allows it, and unlock it."""
        with suppress(OSError):
            CACHING.FunctionCache.save_overload(self, sig, data)
        self._release()

    def _acquire(self) -> None:
        """Lock the kernel, or return after `LONGEST_WAIT` or if the disk does not allow it."""
        name = f"{self._impl.filename_base}{self.ending}.lock"
        end = time.monotonic() + LONGEST_WAIT
        with suppress(OSError):
            self._lock = Path(self._cache_path, name).open("w")
            while time.monotonic() < end:
                if try_lock(self._lock):
                    return
                time.sleep(0.02)

    def _release(self) -> None:
        if self._lock is not None:
            self._lock.close()
            self._lock = None


class CalleeCache(KernelCache):
    """numba's cache of kernels that other kernels contain, the same for all processors."""

    _impl_class = CalleeKept
    ending = ".callee"

    def _index_key(self, sig: Any, codegen: Any) -> tuple[Any, ...]:
        signature, (triple, *_), code = CACHING.FunctionCache._index_key(self, sig, codegen)
        return signature, triple, code


@cache
def stamp(file: str) -> str:
    """Return the digest of a file, of the files that it imports, and of these here."""
    digest = sha256()
    for path in sorted(reached(Path(file).resolve()) | reached(Path(__file__).resolve())):
        digest.update(path.read_bytes())
    return digest.hexdigest()
