"""How this package's kernels are compiled: division by zero gives inf as in numpy (shorter code, faster to compile), results
kept on disk. No fast mathematics: sums in the order written and no fused multiply-add give the same bits in every process,
whether a kernel has just been compiled or comes from disk, and in whatever kernel it is inlined.
"""

from functools import partial

from numba import njit

compiled = partial(njit, cache=True, error_model="numpy")
