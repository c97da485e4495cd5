"""numba's store of compiled kernels, by the content of all files that a kernel is made of."""

from contextlib import suppress
from functools import cache, cached_property
from hashlib import sha256
from pathlib import Path

from numba.core.caching import FunctionCache, IndexDataCacheFile

from .callees import CalleeKept
from .tree import reached


class KernelCache(FunctionCache):
    """numba's cache on disk, stamped with the content of all that a kernel is made of."""

    ending = ""

    def __init__(self, kernel):
        super().__init__(kernel)
        del self._cache_file  # numba's own stamp

    @cached_property
    def _cache_file(self):
        """Made when a kernel is first called: the stamp reads many files."""
        return IndexDataCacheFile(
            self._cache_path,
            self._impl.filename_base + self.ending,
            stamp(self._py_func.__code__.co_filename),
        )

    def load_overload(self, signature, target_context):
        """The kept kernel; None, after throwing all kept ones away, if they cannot be read."""
        try:
            return super().load_overload(signature, target_context)
        except Exception:  # whatever a damaged pickle raises
            with suppress(OSError):
                self.flush()
            return None

    def save_overload(self, signature, data):
        """Keep a kernel if the disk allows it."""
        with suppress(OSError):
            super().save_overload(signature, data)


class CalleeCache(KernelCache):
    """The same for kernels in the code of others."""

    _impl_class = CalleeKept
    ending = ".callee"


@cache
def stamp(file: str) -> str:
    """Digest of a source file and of all files of the project that it imports, directly or not."""
    digest = sha256()
    for path in sorted(reached(Path(file).resolve())):
        digest.update(path.read_bytes())
    return digest.hexdigest()
