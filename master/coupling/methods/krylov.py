"""GMRES that remembers: products of the last solves precondition the next one."""

from collections.abc import Callable
from functools import cache
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np

KEPT = 80
"""Pairs kept from one solve to the next. The numerical example with 60 modes a body, 200 steps from
rest: 5600 products with 40 pairs, 3800 with 60 to 80, 4000 with 100, 4800 with 160; after the first
90 steps 12.7 an update with 40, 6.8 with 80, 6.4 with 160.
"""

NOISE = 1e-5
"""Of a product's squared length: what nearly parallel products of different times disagree on
counts as noise.
"""

PER_DIRECTION = 1.3
MORE = 4.0
"""Pairs in use: so many for each direction that they tell apart, and so many more. Products of the
numerical example with rigid bodies (4 directions; 180 steps from rest), `floating_pin` (10; 60 deg)
and `fired_motorcycle` (40; 120 deg) with all of `KEPT`: 504, 331 and 3076; with 2 for each and 2
more 416, 277 and 3001; with these 416, 272 and 2824. With 60 modes a body (70) all are in use.
"""


SMALL = 16
"""Unknowns up to which numpy factorises: such systems need no scipy, which is slow to import."""


Product = Callable[[np.ndarray], np.ndarray]
"""v -> A v."""


class Goal:
    """How small a residual r is to be: |r| <= `size`, or each |r_i| <= `elements`_i.

    `whole` is the 2-norm above which an element must be too large.
    """

    def __init__(self, elements: np.ndarray, size: float = 0.0):
        self.elements = elements
        self.size = size
        self.whole = float(np.linalg.norm(elements))

    def is_reached(self, residual: np.ndarray) -> bool:
        """Whether no element is larger than it may be."""
        return bool((np.abs(residual) <= self.elements).all())


class Solved(NamedTuple):
    """A solution: x = sum of weights times the directions of which products were asked for, in that
    order; without a product the right-hand side, which is within the goal.
    """

    x: np.ndarray
    weights: np.ndarray

    @property
    def products(self) -> int:
        """How many it took."""
        return len(self.weights)


class Arnoldi(NamedTuple):
    """What is known of the products of a solve without another look at them.

    Eq. (Q10):  product_k = sum over i <= k + 1 of  H_ik basis_i

    hessenberg : ndarray, shape (>= count + 1, >= count), H, the basis orthonormal;
    projected : ndarray, shape (>= count + 1, pairs), Z' basis_i.
    """

    hessenberg: np.ndarray
    projected: np.ndarray


class RecycledGmres:
    """GMRES for a sequence of systems A x = b whose matrices change little.

    Eq. (Q7):  P r = r + (V - Z) (Z' Z + n I)^-1 Z' r,   Z = A V,   |z_i| = 1

    V and Z are directions and their products from earlier solves: for small n P is the inverse of
    the A of that time on the space spanned by Z, and the identity elsewhere. GMRES works with A P,
    so a stale P costs products, never accuracy.

    Few directions need few pairs. What is older than these adds nothing but its age: it is left out
    for good, neither fetched nor weighed against what is newer.

    Eq. (Q11):  pairs <= 1.3 d + 4,   d = tr Z' Z (Z' Z + n I)^-1

    d counts the directions in which the pairs differ by more than the noise.

    Parameters
    ----------
    largest_space : int
        Products a solve.

    Attributes
    ----------
    images, differences : ndarray, shape (pairs, n)
        Z and V - Z by rows, as many as are kept at most, 0 where nothing is known yet. In single
        precision round-off would grow to what two solves differ by.
    gram : ndarray, shape (pairs, pairs)
        Z' Z of those in use, 0 elsewhere.
    oldest : int
        The row that is overwritten next; those in use end before it.
    """

    def __init__(self, largest_space: int):
        self.largest_space = largest_space
        self.images = self.differences = np.zeros((0, 0))
        self.gram = np.zeros((0, 0))
        self.oldest = 0

    def solve(self, product: Product, right: np.ndarray, goal: Goal) -> Solved:
        """Solution of A x = right as near as `goal` says, or the best in the largest space.

        The least residual r_k in the space of k products needs no solve: the Hessenberg matrix has
        one vector g with g' H = 0, of which every product gives another element.

        Eq. (Q9):  r_k = |right| / |g|^2 sum_i g_i basis_i,   |r_k| = |right| / |g|,
                   g_0 = 1,   g_k+1 = -sum_i H_ik g_i / H_k+1,k

        Parameters
        ----------
        product : callable
            v -> A v.
        right : ndarray, shape (n,)
        goal : Goal

        Returns
        -------
        Solved
        """
        size = float(np.linalg.norm(right))
        if size <= goal.size or goal.is_reached(right):
            return Solved(right.copy(), np.zeros(0))
        if not self.images.size:
            kept = min(KEPT, right.size)
            self.images, self.differences = np.zeros((2, kept, right.size))
            self.gram = np.zeros((kept, kept))
        rows, factor = self._in_use()
        solved = _by_numpy if right.size <= SMALL else _by_lapack()[1]
        blocks = blocks_of(rows, len(self.images))
        most = self.largest_space
        basis = np.empty((most + 1, right.size))
        directions, images = np.empty((2, most, right.size))
        arnoldi = Arnoldi(np.zeros((most + 1, most)), np.zeros((most + 1, len(self.images))))
        hessenberg, projected = arnoldi
        shares = np.zeros(len(self.images))
        null = np.zeros(most + 1)
        basis[0], null[0], count = right / size, 1.0, 0
        while count < most:
            column = hessenberg[:, count]
            directions[count] = basis[count]
            if blocks:
                self._project(basis[count], blocks, projected[count])
                shares[rows] = solved(factor, projected[count, rows])
                for block in blocks:
                    directions[count] += shares[block] @ self.differences[block]  # Eq. (Q7)
            images[count] = product(directions[count])
            new = orthogonal(images[count], basis[: count + 1], column)
            count += 1
            if column[count] == 0.0:
                break
            basis[count] = new / column[count]
            null[count] = -(column[:count] @ null[:count]) / column[count]  # Eq. (Q9)
            known = null[: count + 1]
            if size <= goal.size * np.linalg.norm(known):
                break
            # no element is larger than it may be only where the whole is not
            if size <= goal.whole * np.linalg.norm(known):
                residual = (size / (known @ known) * known) @ basis[: count + 1]  # Eq. (Q9)
                if goal.is_reached(residual):
                    break
        target = np.zeros(count + 1)
        target[0] = size
        weights = np.linalg.lstsq(hessenberg[: count + 1, :count], target, rcond=None)[0]
        if column[count] != 0.0:
            self._project(basis[count], blocks, projected[count])
        self._learn(directions[:count], images[:count], arnoldi)
        return Solved(weights @ directions[:count], weights)

    def _in_use(self) -> tuple[np.ndarray, np.ndarray]:
        """Rows of the pairs in use, the newest first, and the lower factor of Z' Z + n I in that
        order; what is older than Eq. (Q11) allows is out of use.
        """
        known = int(np.count_nonzero(np.diag(self.gram)))
        rows = (self.oldest - 1 - np.arange(known)) % len(self.images)
        if not known:
            return rows, np.zeros((0, 0))
        ordered = self.gram[rows].T[rows]  # it is symmetric
        small = self.images.shape[1] <= SMALL
        factorise = _factorise_by_numpy if small else _by_lapack()[0]
        factor, inverse = factorise(ordered + NOISE * np.eye(known))
        directions = known - NOISE * np.sum(inverse**2)
        used = min(known, int(np.ceil(PER_DIRECTION * directions + MORE)))  # Eq. (Q11)
        if used < known:
            self.gram[rows[used:]] = self.gram[:, rows[used:]] = 0.0
            rows, factor = rows[:used], np.asfortranarray(factor[:used, :used])
        return rows, factor

    def _project(self, vector: np.ndarray, blocks: list[slice], out: np.ndarray) -> None:
        """Z' vector of the pairs in use into `out`, shape (pairs,)."""
        for block in blocks:
            out[block] = self.images[block] @ vector

    def _learn(self, directions: np.ndarray, images: np.ndarray, arnoldi: Arnoldi) -> None:
        """Put pairs in the place of the oldest. Their inner products need no look at them: what is
        remembered knows its own with the basis, and by Eq. (Q10) images are sums of that.
        """
        count = len(images)
        sizes = np.linalg.norm(images, axis=1)
        newest = np.flatnonzero(sizes)[-len(self.images) :]
        scales = sizes[newest]
        z = images[newest] / scales[:, None]
        places = (self.oldest + np.arange(len(newest))) % len(self.images)
        self.images[places] = z
        self.differences[places] = directions[newest] / scales[:, None] - z
        shares = arnoldi.hessenberg[: count + 1, newest].T / scales[:, None]
        self.gram[places] = shares @ arnoldi.projected[: count + 1]  # Eq. (Q10)
        self.gram[np.ix_(places, places)] = shares @ shares.T  # Eq. (Q10)
        self.gram[:, places] = self.gram[places].T
        self.oldest = int(self.oldest + len(newest)) % len(self.images)


@cache
def _by_lapack() -> tuple[Callable[..., Any], Callable[..., Any]]:
    """Return functions for a lower Cholesky factor with its inverse, and for a solution with it."""
    lapack: Any = import_module("scipy.linalg.lapack")  # slow to import

    def factorise(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        factor, _ = lapack.dpotrf(matrix, lower=1)
        return factor, lapack.dtrtri(factor, lower=1)[0]

    return factorise, lambda factor, right: lapack.dpotrs(factor, right, lower=1)[0]


def _factorise_by_numpy(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return a lower Cholesky factor and its inverse."""
    factor = np.linalg.cholesky(matrix)
    return factor, np.linalg.inv(factor)


def _by_numpy(factor: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Return the solution of a system by its lower Cholesky factor."""
    return np.linalg.solve(factor.T, np.linalg.solve(factor, right))


def blocks_of(rows: np.ndarray, pairs: int) -> list[slice]:
    """The one or two blocks of rows that go down by one, or from 0 to the last."""
    if len(rows) in (0, pairs):
        return [slice(len(rows))] if len(rows) else []
    last, first = int(rows[0]), int(rows[-1])
    if first <= last:
        return [slice(first, last + 1)]
    return [slice(last + 1), slice(first, None)]


def orthogonal(vector: np.ndarray, basis: np.ndarray, column: np.ndarray) -> np.ndarray:
    """What is left of a vector without its shares in an orthonormal basis, shape (m, n).

    The shares are added to `column`, shape (>= m + 1,), what is left of the length behind them.
    """
    for _ in range(2):  # a second pass keeps the basis orthogonal to round-off
        shares = basis @ vector
        column[: len(basis)] += shares
        vector = vector - shares @ basis
    column[len(basis)] = np.linalg.norm(vector)
    return vector
