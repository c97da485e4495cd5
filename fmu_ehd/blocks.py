"""Direct solution of five-point systems by block-tridiagonal elimination along the axial direction.

Eq. (B1):  south[i,j] x[i,j-1] + north[i,j] x[i,j+1] + west[i,j] x[i-1,j] + east[i,j] x[i+1,j] + centre[i,j] x[i,j] = b[i,j]
Eq. (B2):  S_j = D_j - diag(back_j) S_{j-1}^-1 diag(ahead_{j-1})                D_j: rows and columns of one axial station j
Eq. (B3):  z_j = S_j^-1 (b_j - back_j z_{j-1}),   x_j = z_j - S_j^-1 (ahead_j x_{j+1})
Eq. (B4):  S = [F 0; G E]  ->  S^-1 = [F^-1 0; -E^-1 G F^-1 E^-1]               E diagonal

The matrix of the film balance is a column-dominant M-matrix, for which elimination without pivoting is stable
[Higham2002, section 13.2]. The index i is a ring, so that west of i = 0 is i = n-1; an open grid has zeros there.

Stations are eliminated downstream (back = south, ahead = north, or the other way round): there the column of a cavitated cell
has nothing but its diagonal, Eq. (B4), and only the m full cells of a station cost m^2 n operations instead of n^3.

References
----------
[Higham2002] N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., SIAM 2002.
"""

import numpy as np
from numba import njit

TOGETHER = 4  # right-hand sides from which matrix products are faster than as many substitutions
CONTRACT = {"contract"}  # fused multiply-add alone: no reordering, so a repeated step gives the same bits


@njit(cache=True, fastmath=CONTRACT, inline="always")
def _single_pivot(a, k):
    """One Gauss-Jordan step of the whole matrix with pivot k."""
    n = a.shape[0]
    x = a[k]
    d = 1.0 / x[k]
    x[k] = 1.0
    for c in range(n):
        x[c] *= d
    for r in range(n):
        if r != k:
            u = a[r]
            f = u[k]
            u[k] = 0.0
            for c in range(n):
                u[c] -= f * x[c]


@njit(cache=True, fastmath=CONTRACT, inline="always")
def _invert_four(pivot):
    """Invert a 4 x 4 matrix in place; loops of constant length, which the compiler unrolls."""
    for q in range(4):
        d = 1.0 / pivot[q, q]
        pivot[q, q] = 1.0
        for c in range(4):
            pivot[q, c] *= d
        for r in range(4):
            if r != q:
                f = pivot[r, q]
                pivot[r, q] = 0.0
                for c in range(4):
                    pivot[r, c] -= f * pivot[q, c]


@njit(cache=True, fastmath=CONTRACT)
def invert_in_place(a):
    """Invert a matrix by Gauss-Jordan elimination without pivoting.

    Four pivots and two rows at a time: each element then costs a load and a store for four operations. Written out in one
    function, because a call a row costs a third of the time.

    Parameters
    ----------
    a : ndarray, shape (n, n)
        Column- or row-dominant M-matrix; overwritten by its inverse.
    """
    n = a.shape[0]
    whole = n - n % 4
    pivot = np.empty((4, 4))
    for k in range(0, whole, 4):
        x0, x1, x2, x3 = a[k], a[k + 1], a[k + 2], a[k + 3]
        for i in range(4):
            for j in range(4):
                pivot[i, j] = a[k + i, k + j]
                a[k + i, k + j] = 1.0 if i == j else 0.0
        _invert_four(pivot)
        p00, p01, p02, p03 = pivot[0, 0], pivot[0, 1], pivot[0, 2], pivot[0, 3]
        p10, p11, p12, p13 = pivot[1, 0], pivot[1, 1], pivot[1, 2], pivot[1, 3]
        p20, p21, p22, p23 = pivot[2, 0], pivot[2, 1], pivot[2, 2], pivot[2, 3]
        p30, p31, p32, p33 = pivot[3, 0], pivot[3, 1], pivot[3, 2], pivot[3, 3]
        for c in range(n):
            y0, y1, y2, y3 = x0[c], x1[c], x2[c], x3[c]
            x0[c] = p00 * y0 + p01 * y1 + p02 * y2 + p03 * y3
            x1[c] = p10 * y0 + p11 * y1 + p12 * y2 + p13 * y3
            x2[c] = p20 * y0 + p21 * y1 + p22 * y2 + p23 * y3
            x3[c] = p30 * y0 + p31 * y1 + p32 * y2 + p33 * y3
        for r in range(0, n - 1, 2):
            if r < k or r > k + 3:
                u, v = a[r], a[r + 1]
                f0, f1, f2, f3 = u[k], u[k + 1], u[k + 2], u[k + 3]
                g0, g1, g2, g3 = v[k], v[k + 1], v[k + 2], v[k + 3]
                for i in range(4):
                    u[k + i] = v[k + i] = 0.0
                for c in range(n):
                    u[c] -= f0 * x0[c] + f1 * x1[c] + f2 * x2[c] + f3 * x3[c]
                    v[c] -= g0 * x0[c] + g1 * x1[c] + g2 * x2[c] + g3 * x3[c]
        if n % 2:
            u = a[n - 1]
            f0, f1, f2, f3 = u[k], u[k + 1], u[k + 2], u[k + 3]
            for i in range(4):
                u[k + i] = 0.0
            for c in range(n):
                u[c] -= f0 * x0[c] + f1 * x1[c] + f2 * x2[c] + f3 * x3[c]
    for k in range(whole, n):
        _single_pivot(a, k)


@njit(cache=True)
def _coupled(ahead, west, east, station, before, columns, alone):
    """Sort the cells of a station: `columns` gets those whose column has more than a diagonal, `alone` the others."""
    n = west.shape[0]
    m = 0
    for c in range(n):
        up = before >= 0 and ahead[c, before] != 0.0
        if up or west[(c + 1) % n, station] != 0.0 or east[(c - 1) % n, station] != 0.0:
            columns[m] = c
            m += 1
        else:
            alone[c - m] = c
    return m


@njit(cache=True, fastmath=CONTRACT)
def _schur(columns, m, centre, west, east, station, ahead, before, back, previous, s):
    """Columns of the coupled cells of S_j, Eq. (B2): row a of `s` is column columns[a], all n cells along it."""
    n = west.shape[0]
    for a in range(m):
        c = columns[a]
        row = s[a]
        if before >= 0 and ahead[c, before] != 0.0:
            u, full = -ahead[c, before], previous[c]
            for r in range(n):
                row[r] = u * full[r] * back[r]
        else:
            row[:] = 0.0
        row[c] += centre[c, station]
        row[(c + 1) % n] += west[(c + 1) % n, station]
        row[(c - 1) % n] += east[(c - 1) % n, station]


@njit(cache=True, fastmath=CONTRACT)
def _inverse_of_parts(s, columns, m, alone, lone, centre, station, out):
    """Eq. (B4): S_j^-1, transposed, into `out` from the columns of its coupled cells."""
    compact = np.empty((m, m))
    for a in range(m):
        for b in range(m):
            compact[a, b] = s[a, columns[b]]
    invert_in_place(compact)
    above = np.empty((m, lone))  # -(E^-1 G)'
    for a in range(m):
        for k in range(lone):
            above[a, k] = -s[a, alone[k]] / centre[alone[k], station]
    part = np.empty(lone)
    for a in range(m):
        row, weights = out[columns[a]], compact[a]
        for b in range(m):
            row[columns[b]] = weights[b]
        part[:] = 0.0
        for b in range(0, m - m % 2, 2):
            f, g, u, v = weights[b], weights[b + 1], above[b], above[b + 1]
            for k in range(lone):
                part[k] += f * u[k] + g * v[k]
        if m % 2:
            f, u = weights[m - 1], above[m - 1]
            for k in range(lone):
                part[k] += f * u[k]
        for k in range(lone):
            row[alone[k]] = part[k]
    for k in range(lone):
        out[alone[k]] = 0.0
        out[alone[k], alone[k]] = 1.0 / centre[alone[k], station]


@njit(cache=True, fastmath=CONTRACT)
def factorise(centre, back, ahead, west, east, ascending, first, inverses):
    """Inverses of the Schur complements S_j, Eqs. (B2), (B4).

    Parameters
    ----------
    centre, back, ahead, west, east : ndarray, shape (n_c, n_a)
        Coefficients of Eq. (B1); back and ahead are south and north if stations are eliminated with ascending j.
    ascending : bool
    first : int
        Number of stations, in the order of elimination, that are taken as factorised already (their columns unchanged).
    inverses : ndarray, shape (n_a, n_c, n_c)
        Overwritten, in the order of elimination: transpose of S_j^-1 (so that products run along rows).
    """
    n, stations = centre.shape
    s = np.empty((n, n))
    columns, alone = np.empty(n, np.int64), np.empty(n, np.int64)
    for k in range(first, stations):
        j = k if ascending else stations - 1 - k
        before = (j - 1 if ascending else j + 1) if k > 0 else -1
        m = _coupled(ahead, west, east, j, before, columns, alone)
        if m == n:
            s = inverses[k]
        _schur(columns, m, centre, west, east, j, ahead, before, back[:, j], inverses[k - 1], s)
        if m == n:
            invert_in_place(s)
            s = np.empty((n, n))
        else:
            _inverse_of_parts(s, columns, m, alone, n - m, centre, j, inverses[k])


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
def substitute(inverses, back, ahead, ascending, right):
    """Solve Eq. (B1) with the factorisation at hand, Eq. (B3).

    Parameters
    ----------
    inverses : ndarray, shape (n_a, n_c, n_c)
        From `factorise`.
    back, ahead : ndarray, shape (n_c, n_a)
    ascending : bool
        As in `factorise`.
    right : ndarray, shape (m, n_c, n_a)
        Right-hand sides b.

    Returns
    -------
    ndarray, shape (m, n_c, n_a)
    """
    m, n, stations = right.shape
    x = np.empty((stations, n))
    b = np.empty(n)
    y = np.empty(n)
    out = np.empty((m, n, stations))
    for q in range(m):
        for k in range(stations):
            j = k if ascending else stations - 1 - k
            for i in range(n):
                b[i] = right[q, i, j]
                if k > 0:
                    b[i] -= back[i, j] * x[k - 1, i]
            _multiply(inverses[k], b, x[k])
        for k in range(stations - 2, -1, -1):
            j = k if ascending else stations - 1 - k
            for i in range(n):
                b[i] = ahead[i, j] * x[k + 1, i]
            _multiply(inverses[k], b, y)
            for i in range(n):
                x[k, i] -= y[i]
        for k in range(stations):
            j = k if ascending else stations - 1 - k
            for i in range(n):
                out[q, i, j] = x[k, i]
    return out


@njit(cache=True, fastmath=CONTRACT)
def substitute_together(inverses, back, ahead, ascending, right):
    """As `substitute`, all right-hand sides through a station at once, by matrix products."""
    m, n, stations = right.shape
    x = np.empty((stations, n, m))
    b = np.empty((n, m))
    for k in range(stations):
        j = k if ascending else stations - 1 - k
        for i in range(n):
            for q in range(m):
                b[i, q] = right[q, i, j]
            if k > 0:
                coupling = back[i, j]
                for q in range(m):
                    b[i, q] -= coupling * x[k - 1, i, q]
        np.dot(inverses[k].T, b, x[k])
    y = np.empty((n, m))
    for k in range(stations - 2, -1, -1):
        j = k if ascending else stations - 1 - k
        for i in range(n):
            coupling = ahead[i, j]
            for q in range(m):
                b[i, q] = coupling * x[k + 1, i, q]
        np.dot(inverses[k].T, b, y)
        x[k] -= y
    out = np.empty((m, n, stations))
    for k in range(stations):
        j = k if ascending else stations - 1 - k
        for i in range(n):
            for q in range(m):
                out[q, i, j] = x[k, i, q]
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
        self._ascending = None

    def factorise(self, stencil, stations=None):
        """Factorise, as far as needed.

        Parameters
        ----------
        stencil : tuple of ndarray, each shape (n_c, n_a)
            centre, south, north, west, east of Eq. (B1).
        stations : tuple of int, optional
            First and last axial station in which a column changed since the last call; None: all of them.
        """
        centre, south, north, west, east = stencil
        ascending = np.count_nonzero(north) <= np.count_nonzero(south)  # downstream: cavitated cells see nothing ahead
        first = 0
        if stations is not None and ascending == self._ascending:
            first = stations[0] if ascending else centre.shape[1] - 1 - stations[1]
        back, ahead = (south, north) if ascending else (north, south)
        factorise(centre, back, ahead, west, east, ascending, first, self._inverses)
        self._couplings, self._ascending = (back, ahead), ascending

    def solve(self, right):
        """Solution of Eq. (B1) for right-hand sides of shape (m, n_c, n_a)."""
        method = substitute if right.shape[0] < TOGETHER else substitute_together
        return method(self._inverses, *self._couplings, self._ascending, right)
