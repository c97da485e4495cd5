"""QR decomposition that drops columns which add nothing: the filter of secants and of remembered products."""

import numpy as np


def filtered(columns, limit, rule):
    """QR decomposition of the columns worth keeping, the first ones preferred.

    Parameters
    ----------
    columns : list of ndarray, shape (n,)
    limit : float
    rule : {"QR1", "QR2"}
        QR1 compares what is new in a column with the norm of R so far, QR2 with the column itself.

    Returns
    -------
    chosen : list of int
    q : ndarray, shape (n, m)
    triangle : ndarray, shape (m, m)
    """
    chosen, q, rows = [], [], []
    for k, column in enumerate(columns):
        new, shadow = column.copy(), np.zeros(len(q))
        for _ in range(2):  # a second pass keeps Q orthogonal to round-off
            for i, base in enumerate(q):
                share = base @ new
                shadow[i] += share
                new -= share * base
        size = np.linalg.norm(new)
        reference = np.linalg.norm(column) if rule == "QR2" else np.sqrt(sum(row @ row for row in rows) + shadow @ shadow + size**2)
        if size > limit * reference:
            chosen.append(k)
            q.append(new / size)
            rows.append(np.append(shadow, size))
    triangle = np.zeros((len(q), len(q)))
    for k, row in enumerate(rows):
        triangle[:k + 1, k] = row
    return chosen, np.array(q).T, triangle
