"""pytest plugin, `-p interpreted`: kernels run as Python, with numba's arithmetic.

Small problems take as long as their kernels take to compile; interpreted they take seconds.
"""

import functools

import numpy as np

from piston_cosim.master.fmi import compiled as module


def as_numba_has_it(value):
    """Return the value with numpy's scalars: division by zero gives inf, as compiled."""
    if type(value) is float:
        return np.float64(value)
    if isinstance(value, tuple):
        inside = [as_numba_has_it(part) for part in value]
        return type(value)(*inside) if hasattr(value, "_fields") else tuple(inside)
    return value


def interpreted(kernel=None, **options):
    """Replace `compiled` and `compilable` by Python.

    A kernel with options, such as inlining, is returned unchanged, because its caller has the
    converted values already.
    """
    if kernel is None:
        return functools.partial(interpreted, **options)
    if options:
        return kernel

    @functools.wraps(kernel)
    def call(*values, **named):
        return kernel(*map(as_numba_has_it, values), **named)

    call.dispatcher = call  # pyright: ignore[reportAttributeAccessIssue]
    return call


module.compiled = module.compilable = interpreted
np.seterr(all="ignore")  # kernels do not warn
