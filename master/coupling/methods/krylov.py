"""GMRES that remembers: products of the last solves precondition the next one."""

import numpy as np
from scipy.linalg import cho_factor, cho_solve

KEPT = 40
"""Pairs kept from one solve to the next: about the number of directions that amplify."""

NOISE = 1e-5
"""Of a product's squared length: what nearly parallel products of different times disagree on
counts as noise.
"""


class RecycledGmres:
    """GMRES for a sequence of systems A x = b whose matrices change little.

    Eq. (K1):  P r = r + (V - Z) (Z' Z + n I)^-1 Z' r,   Z = A V,   |z_i| = 1

    V and Z are directions and their products from earlier solves: for small n P is the inverse of
    the A of that time on the space spanned by Z, and the identity elsewhere. GMRES works with A P,
    so a stale P costs products, never accuracy.

    Parameters
    ----------
    largest_space : int
        Products a solve.
    """

    def __init__(self, largest_space):
        self.largest_space, self.pairs = largest_space, []

    def solve(self, product, right, tolerance):
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
        basis, directions, found = [right / size], [], []
        hessenberg = np.zeros((self.largest_space + 1, self.largest_space))
        for k in range(self.largest_space):
            directions.append(precondition(basis[k]))
            found.append(product(directions[k]))
            new = found[k].copy()
            for _ in range(2):  # a second pass keeps the basis orthogonal to round-off
                for i, base in enumerate(basis):
                    share = base @ new
                    hessenberg[i, k] += share
                    new -= share * base
            hessenberg[k + 1, k] = np.linalg.norm(new)
            target = np.zeros(k + 2)
            target[0] = size
            part = hessenberg[: k + 2, : k + 1]
            weights = np.linalg.lstsq(part, target, rcond=None)[0]
            if np.linalg.norm(target - part @ weights) <= tolerance or hessenberg[k + 1, k] == 0.0:
                break
            basis.append(new / hessenberg[k + 1, k])
        self.pairs = [*reversed(list(zip(directions, found))), *self.pairs][:KEPT]
        return np.sum([w * v for w, v in zip(weights, directions)], axis=0), len(found)

    def _preconditioner(self):
        """P of Eq. (K1) as a callable."""
        if not self.pairs:
            return lambda r: r
        sizes = np.array([np.linalg.norm(z) for _, z in self.pairs])
        v, z = (np.array([pair[k] for pair in self.pairs]) / sizes[:, None] for k in (0, 1))
        matrix = z @ z.T
        matrix[np.diag_indices_from(matrix)] += NOISE
        factor, difference = cho_factor(matrix), v - z
        return lambda r: r + cho_solve(factor, z @ r) @ difference  # Eq. (K1)
