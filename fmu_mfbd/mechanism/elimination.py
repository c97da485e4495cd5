"""Elimination for small systems of linear equations.

The model and machine code, which has no LAPACK, run the same operations in the same order.

References
----------
[Golub2013] G. H. Golub, C. F. Van Loan, Matrix Computations, 4th ed., Johns Hopkins University
Press, 2013.
"""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable
from ..geometry.arrays import Matrix, Vector


class LUFactors(NamedTuple):
    """A matrix, factorised (Eq. (N10)).

    Parameters
    ----------
    both : ndarray, shape (n, n)
        U, and below its diagonal L without its ones.
    order : ndarray, shape (n,)
        Row that took the place of each in turn; whole numbers.
    """

    both: Matrix
    order: Vector


@compilable
def factorise(matrix: np.ndarray) -> LUFactors:
    """Factorise a matrix by elimination with exchange of rows.

    Eq. (N10):  P A = L U      |L| <= 1: the largest of its column stands on the diagonal

    Parameters
    ----------
    matrix : ndarray, shape (n, n)
        A. Where it is singular, solutions are not finite.

    Returns
    -------
    LUFactors

    References
    ----------
    [Golub2013] section 3.4. Checked against numpy in tests/mfbd/test_elimination.py.
    """
    n = len(matrix)
    both = matrix.copy()
    order = np.empty(n)
    for k in range(n):
        pivot = k
        for i in range(k + 1, n):
            if abs(both[i, k]) > abs(both[pivot, k]):
                pivot = i
        order[k] = pivot
        if pivot != k:
            for j in range(n):
                value = both[k, j]
                both[k, j] = both[pivot, j]
                both[pivot, j] = value
        for i in range(k + 1, n):
            share = both[i, k] / both[k, k]
            both[i, k] = share
            if share != 0.0:
                for j in range(k + 1, n):
                    both[i, j] -= share * both[k, j]  # Eq. (N10)
    return LUFactors(both, order)


@compilable
def substitute(factors: LUFactors, right: np.ndarray) -> np.ndarray:
    """Return x of A x = b.

    Parameters
    ----------
    factors : LUFactors
        Factors of A.
    right : ndarray, shape (n,)
        b.

    Returns
    -------
    ndarray, shape (n,)
    """
    both = factors.both
    n = len(both)
    x = right.copy()
    for k in range(n):
        pivot = int(factors.order[k])
        value = x[k]
        x[k] = x[pivot]
        x[pivot] = value
    for i in range(n):
        total = x[i]
        for j in range(i):
            total -= both[i, j] * x[j]
        x[i] = total
    for back in range(n):
        i = n - 1 - back
        total = x[i]
        for j in range(i + 1, n):
            total -= both[i, j] * x[j]
        x[i] = total / both[i, i]
    return x
