"""Sparse direct solvers for grids that are too wide for dense blocks, with the interface of `blocks.BlockTridiagonal`."""

import numpy as np
from scipy.sparse import csc_matrix, csr_matrix
from scipy.sparse.linalg import splu


class FivePointPattern:
    """Sparsity of Eq. (B1) and the order in which stencil values enter a compressed matrix.

    Parameters
    ----------
    shape : tuple of int
        (n_circumferential, n_axial), at least 3 x 1.
    by_rows : bool
        Compressed rows (CSR) instead of columns (CSC).
    """

    def __init__(self, shape, by_rows):
        cell = np.arange(shape[0] * shape[1]).reshape(shape)
        neighbours = cell, np.roll(cell, 1, 1), np.roll(cell, -1, 1), np.roll(cell, 1, 0), np.roll(cell, -1, 0)
        inside = [np.ones(shape, dtype=bool) for _ in neighbours]
        inside[1][:, 0] = inside[2][:, -1] = False  # no neighbour south of the first and north of the last station
        self._kept = np.flatnonzero(np.concatenate([k.ravel() for k in inside]))
        rows = np.concatenate([cell.ravel()] * 5)[self._kept]
        columns = np.concatenate([n.ravel() for n in neighbours])[self._kept]
        self._kind = csr_matrix if by_rows else csc_matrix
        numbered = self._kind((np.arange(1.0, rows.size + 1.0), (rows, columns)), shape=(cell.size, cell.size))
        numbered.sort_indices()
        self._order = self._kept[numbered.data.astype(np.int64) - 1]
        self._indices, self._indptr, self._size = numbered.indices, numbered.indptr, cell.size

    def matrix(self, stencil):
        """Compressed matrix of a stencil (centre, south, north, west, east)."""
        values = np.concatenate([part.ravel() for part in stencil])[self._order]
        return self._kind((values, self._indices, self._indptr), shape=(self._size, self._size))


class SuperLU:
    """Factorisation by SuperLU of scipy.

    Parameters
    ----------
    shape : tuple of int
        (n_circumferential, n_axial).
    """

    def __init__(self, shape):
        self._pattern = FivePointPattern(shape, by_rows=False)
        self._factors = None

    def factorise(self, stencil, stations=None):
        """Factorise anew, whatever changed."""
        self._factors = splu(self._pattern.matrix(stencil))

    def solve(self, right):
        """Solution of Eq. (B1) for right-hand sides of shape (m, n_c, n_a)."""
        columns = right.reshape(right.shape[0], -1).T
        return np.ascontiguousarray(self._factors.solve(np.asfortranarray(columns)).T).reshape(right.shape)
