"""How kernels are compiled: cached, division by zero gives inf (a film that is not finite is refused where it is solved), and
no reordering of sums but fused multiply-add alone, so that a repeated step gives the same bits.
"""

from functools import partial

from numba import njit

compiled = partial(njit, cache=True, error_model="numpy", fastmath={"contract"})
