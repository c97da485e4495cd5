"""How this package's kernels are compiled: division by zero gives inf as in numpy (shorter code, faster to compile), results
kept on disk."""

from functools import partial

from numba import njit

compiled = partial(njit, cache=True, error_model="numpy")
compiled_sums = partial(njit, cache=True, error_model="numpy", fastmath=True)
"""Likewise, and sums may be reordered, always in the same way."""
