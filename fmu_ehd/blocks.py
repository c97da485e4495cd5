"""Direct solution of five-point systems by block-tridiagonal elimination along the axial direction.

Eq. (B1):  south[i,j] x[i,j-1] + north[i,j] x[i,j+1] + west[i,j] x[i-1,j] + east[i,j] x[i+1,j] + centre[i,j] x[i,j] = b[i,j]
Eq. (B2):  S_j = D_j - diag(south_j) S_{j-1}^-1 diag(north_{j-1})                  D_j: rows and columns of one axial station j
Eq. (B3):  z_j = S_j^-1 (b_j - south_j z_{j-1}),   x_j = z_j - S_j^-1 (north_j x_{j+1})

The matrix of the film balance is a column-dominant M-matrix, for which elimination without pivoting is stable
[Higham2002, section 13.2]. The index i is a ring, so that west of i = 0 is i = n-1; an open grid has zeros there.

References
----------
[Higham2002] N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., SIAM 2002.
"""

import numpy as np
from numba import njit

CONTRACT = {"contract"}  # fused multiply-add alone: no reordering, so a repeated step gives the same bits


@njit(cache=True, fastmath=CONTRACT)
def _eliminate(x, u, k):
    """Subtract from row `u` its share of pivot row `x` (column k)."""
    f = u[k]
    u[k] = 0.0
    for c in range(u.size):
        u[c] -= f * x[c]


@njit(cache=True, fastmath=CONTRACT)
def _eliminate_pair(x, y, u, v, k):
    """Subtract from rows `u`, `v` their shares of pivot rows `x`, `y` (columns k, k+1)."""
    f, g, h, m = u[k], u[k + 1], v[k], v[k + 1]
    u[k] = u[k + 1] = v[k] = v[k + 1] = 0.0
    for c in range(u.size):
        u[c] -= f * x[c] + g * y[c]
        v[c] -= h * x[c] + m * y[c]


@njit(cache=True, fastmath=CONTRACT)
def invert_in_place(a):
    """Invert a matrix by Gauss-Jordan elimination without pivoting, two rows and two pivots at a time.

    Parameters
    ----------
    a : ndarray, shape (n, n)
        Column- or row-dominant M-matrix; overwritten by its inverse.
    """
    n = a.shape[0]
    even = n - n % 2
    for k in range(0, even, 2):
        x, y = a[k], a[k + 1]
        p, q, r, s = x[k], x[k + 1], y[k], y[k + 1]
        d = 1.0 / (p * s - q * r)
        x[k], x[k + 1], y[k], y[k + 1] = 1.0, 0.0, 0.0, 1.0
        for c in range(n):
            first, second = x[c], y[c]
            x[c] = (s * first - q * second) * d
            y[c] = (p * second - r * first) * d
        for row in range(0, even, 2):
            if row != k:
                _eliminate_pair(x, y, a[row], a[row + 1], k)
        if n > even:
            u = a[even]
            f, g = u[k], u[k + 1]
            u[k] = u[k + 1] = 0.0
            for c in range(n):
                u[c] -= f * x[c] + g * y[c]
    if n > even:
        x = a[even]
        d = 1.0 / x[even]
        x[even] = 1.0
        for c in range(n):
            x[c] *= d
        for row in range(even):
            _eliminate(x, a[row], even)


@njit(cache=True, fastmath=CONTRACT)
def factorise(centre, south, north, west, east, first, inverses):
    """Inverses of the Schur complements S_j, from axial station `first` on.

    Parameters
    ----------
    centre, south, north, west, east : ndarray, shape (n_c, n_a)
        Coefficients of Eq. (B1).
    first : int
        Stations before it are taken as factorised already (their columns unchanged).
    inverses : ndarray, shape (n_a, n_c, n_c)
        Overwritten: transpose of S_j^-1 (so that products run along rows).
    """
    n_c, n_a = centre.shape
    for j in range(first, n_a):
        s = inverses[j]
        if j == 0:
            s[:] = 0.0
        else:  # Eq. (B2), transposed
            before = inverses[j - 1]
            for c in range(n_c):
                for r in range(n_c):
                    s[c, r] = -north[c, j - 1] * before[c, r] * south[r, j]
        for i in range(n_c):
            s[i, i] += centre[i, j]
            s[(i - 1) % n_c, i] += west[i, j]
            s[(i + 1) % n_c, i] += east[i, j]
        invert_in_place(s)


@njit(cache=True, fastmath=CONTRACT)
def _multiply(transposed, x, out):
    """out = transposed' x, running along the rows of `transposed`."""
    n = x.size
    out[:] = 0.0
    for c in range(0, n - n % 2, 2):
        u, v, f, g = transposed[c], transposed[c + 1], x[c], x[c + 1]
        for r in range(n):
            out[r] += f * u[r] + g * v[r]
    if n % 2:
        u, f = transposed[n - 1], x[n - 1]
        for r in range(n):
            out[r] += f * u[r]


@njit(cache=True, fastmath=CONTRACT)
def substitute(inverses, south, north, right):
    """Solve Eq. (B1) with the factorisation at hand, Eq. (B3).

    Parameters
    ----------
    inverses : ndarray, shape (n_a, n_c, n_c)
        From `factorise`.
    south, north : ndarray, shape (n_c, n_a)
    right : ndarray, shape (m, n_c, n_a)
        Right-hand sides b.

    Returns
    -------
    ndarray, shape (m, n_c, n_a)
    """
    m, n_c, n_a = right.shape
    x = np.empty((n_a, n_c))
    b = np.empty(n_c)
    y = np.empty(n_c)
    out = np.empty((m, n_c, n_a))
    for k in range(m):
        for j in range(n_a):
            for i in range(n_c):
                b[i] = right[k, i, j]
                if j > 0:
                    b[i] -= south[i, j] * x[j - 1, i]
            _multiply(inverses[j], b, x[j])
        for j in range(n_a - 2, -1, -1):
            for i in range(n_c):
                b[i] = north[i, j] * x[j + 1, i]
            _multiply(inverses[j], b, y)
            for i in range(n_c):
                x[j, i] -= y[i]
        for j in range(n_a):
            for i in range(n_c):
                out[k, i, j] = x[j, i]
    return out


class BlockTridiagonal:
    """Factorisation of one five-point matrix at a time, kept for further right-hand sides.

    Parameters
    ----------
    shape : tuple of int
        (n_circumferential, n_axial). Work grows as n_axial n_circumferential^3.
    """

    def __init__(self, shape):
        self._inverses = np.empty((shape[1], shape[0], shape[0]))
        self._couplings = None

    def factorise(self, stencil, first=0):
        """Factorise; stations before `first` must be unchanged since the last call.

        Parameters
        ----------
        stencil : tuple of ndarray, each shape (n_c, n_a)
            centre, south, north, west, east of Eq. (B1).
        first : int
            First axial station in which a column changed.
        """
        factorise(*stencil, first, self._inverses)
        self._couplings = stencil[1:3]

    def solve(self, right):
        """Solution of Eq. (B1) for right-hand sides of shape (m, n_c, n_a)."""
        return substitute(self._inverses, *self._couplings, right)
