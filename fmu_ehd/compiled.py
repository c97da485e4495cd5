"""How kernels are compiled: cached, division by zero gives inf (a film that is not finite is refused where it is solved).

No fast mathematics: sums in the order written and no fused multiply-add give the same bits in every process, whether a kernel
has just been compiled or comes from disk, and in whatever kernel it is inlined. Measured, it costs nothing here.
"""

from functools import partial

from numba import njit

compiled = partial(njit, cache=True, error_model="numpy")
