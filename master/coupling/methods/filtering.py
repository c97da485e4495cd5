"""QR decomposition that drops columns which add nothing: the filter of secants."""

import numpy as np


def filtered(columns: list[np.ndarray], limit: float) -> tuple[list[int], np.ndarray, np.ndarray]:
    """Return the QR decomposition of the independent columns, the first ones preferred.

    Parameters
    ----------
    columns : list of ndarray, shape (n,)
    limit : float
        A column is dropped if what is new in it is smaller than this share of it, which is QR2 of
        preCICE. Its QR3 keeps the same columns.

    Returns
    -------
    chosen : list of int
    q : ndarray, shape (n, m)
    triangle : ndarray, shape (m, m)
    """
    if not columns:
        return [], np.empty((0, 0)), np.empty((0, 0))
    chosen: list[int] = []
    triangle = np.zeros((len(columns), len(columns)))
    # transposed Q: products with it run along memory
    rows = np.empty((len(columns), columns[0].size))
    for k, column in enumerate(columns):
        m = len(chosen)
        new = column
        for _ in range(2):  # a second pass keeps Q orthogonal to round-off
            share = rows[:m] @ new
            triangle[:m, m] += share
            new = new - share @ rows[:m]
        size = np.linalg.norm(new)
        if size > limit * np.linalg.norm(column):
            triangle[m, m] = size
            rows[m] = new / size
            chosen.append(k)
        else:
            triangle[:m, m] = 0.0
    m = len(chosen)
    return chosen, rows[:m].T, triangle[:m, :m]
