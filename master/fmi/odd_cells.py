"""Cells where a field is not its own mirror image about the thrust plane.

This kernel is no part of `symmetry`, because a coupled FMU in Python imports that without kernels.
"""

import numpy as np

from .compiled import compiled

LARGEST_ODD_PART = 1e-6
"""Odd part of an input over its largest value, up to which half a film is computed [-].

Round-off is far below. A skirt of 27 mm that tilts by 1e-7 rad exceeds it in a film of 1 mm.
"""


@compiled
def first_odd(field: np.ndarray, cut: np.ndarray):
    """Return the first cell where a field is not that of its mirror image, and its image.

    The cell is (i, j) and its image (k, j). i is -1 if the odd part, Eq. (I14), is nowhere above
    `LARGEST_ODD_PART` of the largest even part.

    Parameters
    ----------
    field : ndarray, shape (n, a)
        On a ring with an even number of circumferential cells.
    cut : ndarray of bool, shape (n // 2 + 1, a)
        Cells of the half to omit. Without rows there are none.
    """
    n, a = field.shape
    first = n // 4
    even, odd = 0.0, 0.0
    for i in range(first, first + n // 2 + 1):
        k = (2 * first - i) % n  # Eq. (I13)
        for j in range(a):
            if len(cut) == 0 or not cut[i - first, j]:
                # Eq. (I14), twice
                even = max(even, abs(field[i, j] + field[k, j]))
                odd = max(odd, abs(field[i, j] - field[k, j]))
    least = LARGEST_ODD_PART * even
    for i in range(n if odd > least else 0):
        k = (2 * first - i) % n
        own = i if first <= i <= first + n // 2 else k  # in the half
        for j in range(a):
            is_cut = len(cut) > 0 and cut[own - first, j]
            if abs(field[i, j] - field[k, j]) > least and not is_cut:
                return i, j, k
    return -1, 0, 0
