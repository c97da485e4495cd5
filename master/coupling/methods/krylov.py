"""GMRES that remembers: products of the last solves precondition the next one."""

from collections.abc import Callable

import numpy as np

KEPT = 40
"""Pairs kept from one solve to the next: about the number of directions that amplify."""

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
    """

    def __init__(self, largest_space: int):
        self.largest_space = largest_space
        self.pairs: list[tuple[np.ndarray, np.ndarray]] = []

    def solve(
        self, product: Product, right: np.ndarray, tolerance: float
    ) -> tuple[np.ndarray, int]:
        """Solution of A x = right with |right - A x| <= tolerance, or the best in the largest
        space.

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
        precondition = self._preconditioner()
        size = np.linalg.norm(right)
        if size <= tolerance:
            return right.copy(), 0
        basis = [right / size]
        directions: list[np.ndarray] = []
        images: list[np.ndarray] = []
        weights = np.zeros(0)
        hessenberg = np.zeros((self.largest_space + 1, self.largest_space))
        for k in range(self.largest_space):
            directions.append(precondition(basis[k]))
            images.append(product(directions[k]))
            new = images[k].copy()
            orthogonalise(new, basis, hessenberg[:, k])
            target = np.zeros(k + 2)
            target[0] = size
            part = hessenberg[: k + 2, : k + 1]
            weights = np.linalg.lstsq(part, target, rcond=None)[0]
            if np.linalg.norm(target - part @ weights) <= tolerance or hessenberg[k + 1, k] == 0.0:
                break
            basis.append(new / hessenberg[k + 1, k])
        self.pairs = [*reversed(list(zip(directions, images))), *self.pairs][:KEPT]
        return np.sum([w * v for w, v in zip(weights, directions)], axis=0), len(images)

    def _preconditioner(self) -> Product:
        """P as a callable."""
        if not self.pairs:
            return lambda r: r
        from scipy.linalg import cho_factor, cho_solve  # slow to import

        sizes = np.array([np.linalg.norm(z) for _, z in self.pairs])
        v = np.array([direction for direction, _ in self.pairs]) / sizes[:, None]
        z = np.array([image for _, image in self.pairs]) / sizes[:, None]
        matrix = z @ z.T
        matrix[np.diag_indices_from(matrix)] += NOISE
        factor = cho_factor(matrix)
        difference = v - z
        return lambda r: r + cho_solve(factor, z @ r) @ difference  # Eq. (Q7)


def orthogonalise(new: np.ndarray, basis: list[np.ndarray], column: np.ndarray) -> None:
    """Take the basis vectors' shares out of `new`, in place.

    The shares are added to `column`, shape (>= len(basis) + 1,), what is left of the length behind
    them.
    """
    for _ in range(2):  # a second pass keeps the basis orthogonal to round-off
        for i, base in enumerate(basis):
            share = base @ new
            column[i] += share
            new -= share * base
    column[len(basis)] = np.linalg.norm(new)
