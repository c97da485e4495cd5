"""GMRES that remembers: products of the last solves precondition the next one."""

from collections.abc import Callable

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


Product = Callable[[np.ndarray], np.ndarray]
"""v -> A v."""


class RecycledGmres:
    """GMRES for a sequence of systems A x = b whose matrices change little.

    Eq. (Q7):  P r = r + (V - Z) (Z' Z + n I)^-1 Z' r,   Z = A V,   |z_i| = 1

    V and Z are directions and their products from earlier solves: for small n P is the inverse of
    the A of that time on the space spanned by Z, and the identity elsewhere. GMRES works with A P,
    so a stale P costs products, never accuracy.

    Parameters
    ----------
    largest_space : int
        Products a solve.

    Attributes
    ----------
    images, differences : ndarray, shape (pairs, n)
        Z and V - Z by rows, as many as are kept at most, 0 where nothing is known yet. In single
        precision they would cost 30 % more products.
    gram : ndarray, shape (pairs, pairs)
        Z' Z.
    oldest : int
        The row that is forgotten next.
    """

    def __init__(self, largest_space: int):
        self.largest_space = largest_space
        self.images = self.differences = np.zeros((0, 0))
        self.gram = np.zeros((0, 0))
        self.oldest = 0

    def solve(
        self, product: Product, right: np.ndarray, tolerance: float
    ) -> tuple[np.ndarray, int]:
        """Solution of A x = right with |right - A x| <= tolerance, or the best in the largest
        space.

        The least residual r_k in the space of k products needs no solve: the Hessenberg matrix has
        one vector g with g' H = 0, of which every product gives another element.

        Eq. (Q9):  |r_k| = |right| / |g|,   g_0 = 1,   g_k+1 = -sum_i H_ik g_i / H_k+1,k

        Parameters
        ----------
        product : callable
            v -> A v.
        right : ndarray, shape (n,)
        tolerance : float
            2-norm.

        Returns
        -------
        x : ndarray, shape (n,)
        products : int
        """
        size = float(np.linalg.norm(right))
        if size <= tolerance:
            return right.copy(), 0
        if not self.images.size:
            kept = min(KEPT, right.size)
            self.images, self.differences = np.zeros((2, kept, right.size))
            self.gram = np.zeros((kept, kept))
        precondition = self._preconditioner()
        most = self.largest_space
        basis = np.empty((most + 1, right.size))
        directions, images = np.empty((2, most, right.size))
        hessenberg = np.zeros((most + 1, most))
        null = np.zeros(most + 1)
        basis[0], null[0], count = right / size, 1.0, 0
        while count < most:
            column = hessenberg[:, count]
            directions[count] = precondition(basis[count])
            images[count] = product(directions[count])
            new = orthogonal(images[count], basis[: count + 1], column)
            count += 1
            if column[count] == 0.0:
                break
            null[count] = -(column[:count] @ null[:count]) / column[count]  # Eq. (Q9)
            if size <= tolerance * np.linalg.norm(null[: count + 1]):
                break
            basis[count] = new / column[count]
        target = np.zeros(count + 1)
        target[0] = size
        weights = np.linalg.lstsq(hessenberg[: count + 1, :count], target, rcond=None)[0]
        x = weights @ directions[:count]
        self._learn(directions[:count], images[:count])
        return x, count

    def _learn(self, directions: np.ndarray, images: np.ndarray) -> None:
        """Put pairs in the place of the oldest."""
        sizes = np.linalg.norm(images, axis=1)
        newest = np.flatnonzero(sizes)[-len(self.images) :]
        z = images[newest] / sizes[newest, None]
        places = (self.oldest + np.arange(len(newest))) % len(self.images)
        self.images[places] = z
        self.differences[places] = directions[newest] / sizes[newest, None] - z
        self.gram[places] = self.images[places] @ self.images.T
        self.gram[:, places] = self.gram[places].T
        self.oldest = int(self.oldest + len(newest)) % len(self.images)

    def _preconditioner(self) -> Product:
        """P as a callable."""
        images, differences = self.images, self.differences
        inverse = np.linalg.inv(self.gram + NOISE * np.eye(len(images)))
        return lambda r: r + (inverse @ (images @ r)) @ differences  # Eq. (Q7)


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
