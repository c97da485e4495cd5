"""How kernels are compiled, in every part.

Division by zero gives inf as in numpy (a film that is not finite is refused where it is solved);
results are kept on disk. No fast mathematics: sums in the order written and no fused multiply-add
give the same bits in every process, whether a kernel has just been compiled or comes from disk, and
in whatever kernel it is inlined. Measured, it costs nothing here.

numba looks at a kernel's own file to tell whether what it kept is still true. A kernel also holds
what it calls, so here it is the kernel's file and all files of the project that it imports,
directly or not. A kept kernel that cannot be read is made again; where nothing can be kept, kernels
are compiled anew in each process.
"""

from contextlib import suppress
from functools import cache, cached_property, partial
from hashlib import sha256
from pathlib import Path
from typing import Any

from numba import njit
from numba.core.caching import FunctionCache, IndexDataCacheFile

from .tree import reached


def compiled(kernel=None, **options):
    """Compile a kernel: `@compiled`, or `@compiled(inline="always")` with options of
    `numba.njit`.
    """
    if kernel is None:
        return partial(compiled, **options)
    dispatcher: Any = njit(error_model="numpy", **options)(kernel)
    with suppress(RuntimeError):  # there is nowhere to keep it
        dispatcher._cache = KernelCache(kernel)
        FOLDERS.add(Path(dispatcher._cache.cache_path))
    return dispatcher


FOLDERS: set[Path] = set()
"""Where kernels of this process are kept."""


def first_start() -> str:
    """What takes long at a start, for whoever waits; empty where kernels are kept already."""
    if any(next(folder.glob("*.nbi"), None) for folder in FOLDERS):
        return ""
    kept = "kept for the starts to come" if FOLDERS else "again at each start: nothing can be kept"
    return f"compiling the code of this FMU, which takes about a minute; {kept}"


class KernelCache(FunctionCache):
    """numba's cache on disk, stamped with the content of all that a kernel is made of."""

    def __init__(self, kernel):
        super().__init__(kernel)
        del self._cache_file  # numba's own stamp

    @cached_property
    def _cache_file(self):
        """Made when a kernel is first called: the stamp reads many files."""
        return IndexDataCacheFile(
            self._cache_path,
            self._impl.filename_base,
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


@cache
def stamp(file: str) -> str:
    """Digest of a source file and of all files of the project that it imports, directly or not."""
    digest = sha256()
    for path in sorted(reached(Path(file).resolve())):
        digest.update(path.read_bytes())
    return digest.hexdigest()
