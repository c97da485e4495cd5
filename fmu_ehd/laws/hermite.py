"""Tables of functions on a uniform grid, by cubic Hermite interpolation.

The slope is consistent with the values.
"""

from ...master.fmi.compiled import compiled
from ..common.grid import Array


@compiled(forceinline=True)
def interpolate(table: Array, column: int, end: float, x: float):
    """Return value and slope of a tabulated function, for 0 <= x < end.

    Parameters
    ----------
    table : ndarray, shape (cells + 1, 2 * functions)
        Values and slopes of the functions at x = 0 ... end, side by side.
    column : int
        Column of the function's values. The next column has its slopes.
    end : float
        Last x of the table.
    x : float

    Returns
    -------
    value, slope : float
    """
    step = end / (table.shape[0] - 1)
    k = min(int(x / step), table.shape[0] - 2)
    t = x / step - k
    y0 = table[k, column]
    y1 = table[k + 1, column]
    m0 = table[k, column + 1] * step
    m1 = table[k + 1, column + 1] * step
    c2 = 3.0 * (y1 - y0) - 2.0 * m0 - m1
    c3 = 2.0 * (y0 - y1) + m0 + m1
    value = y0 + t * (m0 + t * (c2 + t * c3))
    slope = (m0 + t * (2.0 * c2 + 3.0 * t * c3)) / step
    return value, slope
