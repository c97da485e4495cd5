"""Direct solution of five-point systems by block-tridiagonal elimination along the axial direction.

Eq. (B1):  centre[i,j] x[i,j] + south[i,j] x[i,j-1] + north[i,j] x[i,j+1]
           + west[i,j] x[i-1,j] + east[i,j] x[i+1,j] = b[i,j]

Rows and columns of one axial station j make up D_j:

Eq. (B2):  S_j = D_j - diag(back_j) S_{j-1}^-1 diag(ahead_{j-1})
Eq. (B3):  z_j = S_j^-1 (b_j - back_j z_{j-1}),   x_j = z_j - S_j^-1 (ahead_j x_{j+1})

With E diagonal:

Eq. (B4):  S = [F, 0; G, E]  ->  S^-1 = [F^-1, 0; -E^-1 G F^-1, E^-1]

The matrix of the film balance is a column-dominant M-matrix, for which elimination without pivoting
is stable [Higham2002, section 13.2]. The index i is a ring, so that west of i = 0 is i = n-1; an
open grid has zeros there.

Stations are eliminated downstream: back = south and ahead = north, or the opposite. In this order
the column of a cavitated cell contains only its diagonal, Eq. (B4). A station with m full cells
costs m^2 n operations instead of n^3. Of S_j^-1, the columns of full cells are stored as rows of
length n, and 1/E. Loops use single elements, because numba counts a reference for each view of a
row, which costs more than the row.

References
----------
[Higham2002] N. J. Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., SIAM 2002.
"""

from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...master.fmi.compiled import compilable, compiled
from ..common.grid import CENTRE, EAST, NORTH, SOUTH, WEST, Array


class Factors(NamedTuple):
    """Inverses of the Schur complements S_j, Eqs. (B2), (B4), in the order of elimination.

    columns : ndarray, shape (n_a, n_c, n_c)
        The first m rows of a station are the columns of S_j^-1 of its m coupled cells.
    diagonals : ndarray, shape (n_a, n_c)
        1/E of the other cells, 0 for the coupled ones.
    orders : ndarray of int, shape (n_a, n_c)
        Coupled cells, then the others.
    counts : ndarray of int, shape (n_a,)
        m.
    direction : ndarray, shape (1,)
        1: stations were eliminated with ascending j, -1: with descending j, 0: nothing was yet.
    """

    columns: Annotated[Array, "n_a, n_c, n_c"]
    diagonals: Annotated[Array, "n_a, n_c"]
    orders: Annotated[NDArray[np.int64], "n_a, n_c"]
    counts: Annotated[NDArray[np.int64], "n_a"]
    direction: Annotated[Array, "1"]


@compilable
def no_factors(shape: tuple[int, int]) -> Factors:
    """Return empty factors of a grid (n_c, n_a)."""
    n_c, n_a = shape
    return Factors(
        np.zeros((n_a, n_c, n_c)),
        np.zeros((n_a, n_c)),
        np.zeros((n_a, n_c), np.int64),
        np.zeros(n_a, np.int64),
        np.zeros(1),
    )


@compiled(forceinline=True)
def _single_pivot(a, k, column):
    """Take one Gauss-Jordan step of the whole matrix with the pivot of row k in `column`."""
    d = 1.0 / a[k, column]
    a[k, column] = 1.0
    for c in range(a.shape[1]):
        a[k, c] *= d
    for r in range(a.shape[0]):
        if r != k:
            f = a[r, column]
            a[r, column] = 0.0
            for c in range(a.shape[1]):
                a[r, c] -= f * a[k, c]


@compiled(forceinline=True)
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


@compiled
def invert_in_place(a: Array, pivots: NDArray[np.int64]):
    """Replace [F X] by [F^-1 F^-1 X] with Gauss-Jordan elimination without pivoting.

    Four pivots and two rows at a time: each element then costs a load and a store for four
    operations. Written out in one function, because a call a row costs a third of the time.

    Parameters
    ----------
    a : ndarray, shape (m, n), n >= m
        Overwritten; F is a column- or row-dominant M-matrix.
    pivots : ndarray of int, shape (m,)
        Columns of `a` that are F.
    """
    m, n = a.shape
    whole = m - m % 4
    pivot = np.empty((4, 4))
    for k in range(0, whole, 4):
        for i in range(4):
            for j in range(4):
                pivot[i, j] = a[k + i, pivots[k + j]]
                a[k + i, pivots[k + j]] = 1.0 if i == j else 0.0
        _invert_four(pivot)
        p00, p01, p02, p03 = pivot[0, 0], pivot[0, 1], pivot[0, 2], pivot[0, 3]
        p10, p11, p12, p13 = pivot[1, 0], pivot[1, 1], pivot[1, 2], pivot[1, 3]
        p20, p21, p22, p23 = pivot[2, 0], pivot[2, 1], pivot[2, 2], pivot[2, 3]
        p30, p31, p32, p33 = pivot[3, 0], pivot[3, 1], pivot[3, 2], pivot[3, 3]
        for c in range(n):
            y0, y1, y2, y3 = a[k, c], a[k + 1, c], a[k + 2, c], a[k + 3, c]
            a[k, c] = p00 * y0 + p01 * y1 + p02 * y2 + p03 * y3
            a[k + 1, c] = p10 * y0 + p11 * y1 + p12 * y2 + p13 * y3
            a[k + 2, c] = p20 * y0 + p21 * y1 + p22 * y2 + p23 * y3
            a[k + 3, c] = p30 * y0 + p31 * y1 + p32 * y2 + p33 * y3
        q0, q1, q2, q3 = pivots[k], pivots[k + 1], pivots[k + 2], pivots[k + 3]
        for r in range(0, m - 1, 2):
            if r < k or r > k + 3:
                f0, f1, f2, f3 = a[r, q0], a[r, q1], a[r, q2], a[r, q3]
                g0, g1, g2, g3 = a[r + 1, q0], a[r + 1, q1], a[r + 1, q2], a[r + 1, q3]
                a[r, q0] = a[r, q1] = a[r, q2] = a[r, q3] = 0.0
                a[r + 1, q0] = a[r + 1, q1] = a[r + 1, q2] = a[r + 1, q3] = 0.0
                for c in range(n):
                    y0, y1, y2, y3 = a[k, c], a[k + 1, c], a[k + 2, c], a[k + 3, c]
                    a[r, c] -= f0 * y0 + f1 * y1 + f2 * y2 + f3 * y3
                    a[r + 1, c] -= g0 * y0 + g1 * y1 + g2 * y2 + g3 * y3
        for r in range(m - m % 2, m):
            f0, f1, f2, f3 = a[r, q0], a[r, q1], a[r, q2], a[r, q3]
            a[r, q0] = a[r, q1] = a[r, q2] = a[r, q3] = 0.0
            for c in range(n):
                a[r, c] -= f0 * a[k, c] + f1 * a[k + 1, c] + f2 * a[k + 2, c] + f3 * a[k + 3, c]
    for k in range(whole, m):
        _single_pivot(a, k, pivots[k])


@compiled
def _sort_cells(stencil, ahead, station, before, order):
    """Sort the cells of a station into `order`, coupled cells first; return their number.

    The column of a coupled cell has more than a diagonal.
    """
    n = stencil.shape[1]
    m = 0
    last = n
    for c in range(n):
        east_of_c = (c + 1) % n
        west_of_c = (c - 1) % n
        coupled = (
            (before >= 0 and stencil[ahead, c, before] != 0.0)
            or stencil[WEST, east_of_c, station] != 0.0
            or stencil[EAST, west_of_c, station] != 0.0
        )
        if coupled:
            order[m] = c
            m += 1
        else:
            last -= 1
            order[last] = c
    return m


@compiled
def _schur(stencil, ascending, k, before, factors, row_of, s):
    """Assemble the columns of the coupled cells of S_j, Eq. (B2), at the k-th station.

    Row a of `s` is the column of the a-th coupled cell, followed by [F' -(E^-1 G)'] of Eq. (B4).

    `before` : the station that was eliminated before, -1 for none. `row_of` : row of each cell in
    the stored columns of S_{j-1}^-1, -1 if its column contains only the diagonal.
    """
    columns, diagonals, orders, counts, _ = factors
    n = stencil.shape[1]
    station = k if ascending else stencil.shape[2] - 1 - k
    back = SOUTH if ascending else NORTH
    ahead = NORTH if ascending else SOUTH
    scale = np.empty(n)
    weight = np.empty(n)
    for r in range(n):
        own = diagonals[k, r]
        scale[r] = 1.0 if own == 0.0 else -own
        weight[r] = scale[r] * stencil[back, r, station]
    for a in range(counts[k]):
        c = orders[k, a]
        u = 0.0
        p = -1
        if before >= 0:
            u = -stencil[ahead, c, before]
            p = row_of[c]
        if p >= 0:
            for r in range(n):
                s[a, r] = u * columns[k - 1, p, r] * weight[r]  # Eq. (B2)
        else:
            for r in range(n):
                s[a, r] = 0.0
            s[a, c] = u * diagonals[k - 1, c] * weight[c] if before >= 0 else 0.0
        lower = (c - 1) % n
        upper = (c + 1) % n
        s[a, c] += stencil[CENTRE, c, station]
        s[a, upper] += stencil[WEST, upper, station] * scale[upper]
        s[a, lower] += stencil[EAST, lower, station] * scale[lower]


@compiled
def factorise(stencil: Array, ascending: bool, first: int, factors: Factors):
    """Return the inverses of the Schur complements S_j, Eqs. (B2), (B4), in elimination order.

    Parameters
    ----------
    stencil : ndarray, shape (5, n_c, n_a)
        Coefficients of Eq. (B1), axis as in `grid`.
    ascending : bool
        Stations are eliminated with ascending j: back and ahead are south and north.
    first : int
        Number of stations, in the order of elimination, that are taken as factorised already (their
        columns unchanged).
    factors : Factors
        Overwritten.
    """
    columns, diagonals, orders, counts, _ = factors
    _, n, stations = stencil.shape
    ahead = NORTH if ascending else SOUTH
    row_of = np.empty(n, np.int64)
    for k in range(first, stations):
        j = k if ascending else stations - 1 - k
        before = -1
        if k > 0:
            before = j - 1 if ascending else j + 1
        for a in range(n):
            row_of[orders[k - 1, a]] = a if a < counts[k - 1] else -1
        m = _sort_cells(stencil, ahead, j, before, orders[k])
        counts[k] = m
        for a in range(n):
            c = orders[k, a]
            diagonals[k, c] = 0.0 if a < m else 1.0 / stencil[CENTRE, c, j]
        _schur(stencil, ascending, k, before, factors, row_of, columns[k])
        invert_in_place(columns[k, :m], orders[k])  # Eq. (B4)


@compiled
def factorise_changed(factors: Factors, stencil: Array, lowest: int, highest: int):
    """Factorise, as far as needed.

    Parameters
    ----------
    factors : Factors
        Overwritten.
    stencil : ndarray, shape (5, n_c, n_a)
        Coefficients of Eq. (B1), axis as in `grid`.
    lowest, highest : int
        First and last axial station in which a column changed since the last call.
    """
    ahead = 0
    behind = 0
    for i in range(stencil.shape[1]):
        for j in range(stencil.shape[2]):
            if stencil[NORTH, i, j] != 0.0:
                ahead += 1
            if stencil[SOUTH, i, j] != 0.0:
                behind += 1
    ascending = ahead <= behind  # downstream: cavitated cells see nothing ahead
    direction = 1.0 if ascending else -1.0
    first = 0
    if direction == factors.direction[0]:
        first = lowest if ascending else stencil.shape[2] - 1 - highest
    factorise(stencil, ascending, first, factors)
    factors.direction[0] = direction


@compiled(forceinline=True)
def _multiply(columns, diagonals, orders, m, k, b, out):
    """Compute out = S_j^-1 b at the k-th station, which has m coupled cells."""
    n = b.size
    for r in range(n):
        out[r] = diagonals[k, r] * b[r]
    whole = m - m % 4
    for a in range(0, whole, 4):
        f0, f1, f2, f3 = (
            b[orders[k, a]],
            b[orders[k, a + 1]],
            b[orders[k, a + 2]],
            b[orders[k, a + 3]],
        )
        for r in range(n):
            out[r] += (
                f0 * columns[k, a, r]
                + f1 * columns[k, a + 1, r]
                + f2 * columns[k, a + 2, r]
                + f3 * columns[k, a + 3, r]
            )
    for a in range(whole, m):
        f = b[orders[k, a]]
        for r in range(n):
            out[r] += f * columns[k, a, r]


@compiled
def substitute(factors: Factors, stencil: Array, ascending: bool, right: Array):
    """Solve Eq. (B1) with the factorisation at hand, Eq. (B3).

    Parameters
    ----------
    factors, stencil, ascending
        As in `factorise`.
    right : ndarray, shape (m, n_c, n_a)
        Right-hand sides b, overwritten by the solutions.
    """
    columns, diagonals, orders, counts, _ = factors
    back = stencil[SOUTH] if ascending else stencil[NORTH]
    ahead = stencil[NORTH] if ascending else stencil[SOUTH]
    m, n, stations = right.shape
    x = np.empty((stations, n))
    b = np.empty(n)
    y = np.empty(n)
    for q in range(m):
        for k in range(stations):
            j = k if ascending else stations - 1 - k
            for i in range(n):
                b[i] = right[q, i, j]
                if k > 0:
                    b[i] -= back[i, j] * x[k - 1, i]  # Eq. (B3)
            _multiply(columns, diagonals, orders, counts[k], k, b, y)
            for i in range(n):
                x[k, i] = y[i]
        for k in range(stations - 2, -1, -1):
            j = k if ascending else stations - 1 - k
            for i in range(n):
                b[i] = ahead[i, j] * x[k + 1, i]  # Eq. (B3)
            _multiply(columns, diagonals, orders, counts[k], k, b, y)
            for i in range(n):
                x[k, i] -= y[i]
        for k in range(stations):
            j = k if ascending else stations - 1 - k
            for i in range(n):
                right[q, i, j] = x[k, i]


@compiled
def substitute_one(factors: Factors, stencil: Array, right: Array):
    """Solve for one right-hand side of shape (n_c, n_a), in place."""
    n_c, n_a = right.shape
    substitute(factors, stencil, factors.direction[0] > 0.0, right.reshape((1, n_c, n_a)))
    return right


@compiled
def _multiply_many(factors, k, b, out):
    """Compute out = S_j^-1 b^T as rows, shape (m, n_c), by one matrix product."""
    columns, diagonals, orders, counts, _ = factors
    coupled = np.empty((len(b), counts[k]))
    for q in range(len(b)):
        for a in range(counts[k]):
            coupled[q, a] = b[q, orders[k, a]]
    np.dot(coupled, columns[k, : counts[k]], out)
    for q in range(len(b)):
        for r in range(b.shape[1]):
            out[q, r] += diagonals[k, r] * b[q, r]


@compiled
def _substitute_many(factors, stencil, ascending, right):
    """Do the same as `substitute`, up to round-off, in 0.6 of its time for 130 right-hand sides."""
    many, n, stations = right.shape
    back = stencil[SOUTH] if ascending else stencil[NORTH]
    ahead = stencil[NORTH] if ascending else stencil[SOUTH]
    order = np.arange(stations) if ascending else np.arange(stations)[::-1]
    x = np.empty((stations, many, n))
    b = np.empty((many, n))
    y = np.zeros((many, n))
    weight = np.zeros(n)
    for k in range(stations):
        j = order[k]
        weight[:] = back[:, j]
        for q in range(many):
            for i in range(n):
                b[q, i] = right[q, i, j] - weight[i] * y[q, i]  # Eq. (B3)
        _multiply_many(factors, k, b, y)
        x[k] = y
    for k in range(stations - 2, -1, -1):
        weight[:] = ahead[:, order[k]]
        for q in range(many):
            for i in range(n):
                b[q, i] = weight[i] * x[k + 1, q, i]  # Eq. (B3)
        _multiply_many(factors, k, b, y)
        x[k] -= y
    for q in range(many):
        for k in range(stations):
            for i in range(n):
                right[q, i, order[k]] = x[k, q, i]


class BlockTridiagonal:
    """Factorisation of one five-point matrix at a time, kept for further right-hand sides.

    Parameters
    ----------
    shape : tuple of int
        (n_circumferential, n_axial). Work grows as n_axial n_circumferential^3.
    """

    def __init__(self, shape: tuple[int, int]):
        self.factors = no_factors(shape)
        self.stencil = np.empty((5, *shape))

    def factorise(self, stencil: Array, stations: tuple[int, int] | None = None) -> None:
        """Factorise, as far as needed.

        Parameters
        ----------
        stencil : ndarray, shape (5, n_c, n_a)
            Coefficients of Eq. (B1), axis as in `grid`; kept until the next call.
        stations : tuple of int, optional
            First and last axial station in which a column changed since the last call; None: all of
            them.
        """
        lowest, highest = stations or (0, stencil.shape[-1] - 1)
        factorise_changed(self.factors, stencil, lowest, highest)
        self.stencil = stencil

    def solve(self, right: Array) -> Array:
        """Return the solution of Eq. (B1); overwrite the right-hand sides, (m, n_c, n_a)."""
        solve = substitute if len(right) < 8 else _substitute_many
        solve(self.factors, self.stencil, self.factors.direction[0] > 0.0, right)
        return right
