"""Eigenvalues of small symmetric matrices, with the same operations in Python and machine code.

References
----------
[Golub2013] G. H. Golub, C. F. Van Loan, Matrix Computations, 4th ed., Johns Hopkins University
Press, 2013.
"""

import numpy as np

from ...master.fmi.compiled import compilable, standing_for

MOST_SWEEPS = 30
"""Maximum number of sweeps. About ten are usual."""


@compilable
def symmetric_eigen(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return eigenvalues, ascending, and eigenvectors of a symmetric matrix, by Jacobi's method.

    Eq. (J54):  t = sign(d)/(|d| + (d^2 + 1)^1/2),   d = (a_qq - a_pp)/(2 a_pq)
                t the tangent of the rotation that makes a_pq zero

    Parameters
    ----------
    matrix : ndarray, shape (n, n)

    Returns
    -------
    ndarray, shape (n,)
    ndarray, shape (n, n)
        One vector in each column.

    References
    ----------
    [Golub2013] section 8.5. Checked against numpy in tests/mfbd/test_pin_shapes.py.
    """
    n = len(matrix)
    a, turned = matrix.copy(), np.eye(n)
    for _ in range(MOST_SWEEPS):
        rotations = 0
        for p in range(n - 1):
            for q in range(p + 1, n):
                if abs(a[p, q]) <= 1e-17 * np.sqrt(abs(a[p, p] * a[q, q])):
                    continue
                rotations += 1
                d = (a[q, q] - a[p, p]) / (2 * a[p, q])
                t = (1.0 if d >= 0.0 else -1.0) / (abs(d) + np.sqrt(d * d + 1))  # Eq. (J54)
                c = 1 / np.sqrt(t * t + 1)
                _rotate(a, turned, p, q, c, t * c)
        if rotations == 0:
            break
    values, vectors = np.empty(n), np.empty((n, n))
    for j in range(n):
        least = 0
        for k in range(n):
            if a[k, k] < a[least, least]:
                least = k
        values[j] = a[least, least]
        for i in range(n):
            vectors[i, j] = turned[i, least]
        a[least, least] = np.inf
    return values, vectors


@compilable
def _rotate_each(a, turned, p, q, c, s):
    for k in range(len(a)):
        x, y = a[k, p], a[k, q]
        a[k, p], a[k, q] = c * x - s * y, s * x + c * y
    for k in range(len(a)):
        x, y = a[p, k], a[q, k]
        a[p, k], a[q, k] = c * x - s * y, s * x + c * y
        x, y = turned[k, p], turned[k, q]
        turned[k, p], turned[k, q] = c * x - s * y, s * x + c * y
    a[p, q], a[q, p] = 0.0, 0.0


@standing_for(_rotate_each)
def _rotate(a, turned, p, q, c, s):
    """Rotate rows and columns p and q; in kernels by loops, which take a quarter of the time."""
    for one in (a.T, a, turned.T):
        one[p], one[q] = c * one[p] - s * one[q], s * one[p] + c * one[q]
    a[p, q], a[q, p] = 0.0, 0.0
