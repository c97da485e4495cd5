"""Sparse direct solvers with the interface of `blocks.BlockTridiagonal`, and the choice among them
all.
"""

import numpy as np
from scipy.sparse import csc_matrix, csr_matrix
from scipy.sparse.linalg import splu

from .blocks import BlockTridiagonal


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
        neighbours = (
            cell,
            np.roll(cell, 1, 1),
            np.roll(cell, -1, 1),
            np.roll(cell, 1, 0),
            np.roll(cell, -1, 0),
        )
        inside = [np.ones(shape, dtype=bool) for _ in neighbours]
        inside[1][:, 0] = inside[2][:, -1] = (
            False  # no neighbour south of the first and north of the last station
        )
        self._kept = np.flatnonzero(np.concatenate([k.ravel() for k in inside]))
        rows = np.concatenate([cell.ravel()] * 5)[self._kept]
        columns = np.concatenate([n.ravel() for n in neighbours])[self._kept]
        self._kind = csr_matrix if by_rows else csc_matrix
        numbered = self._kind(
            (np.arange(1.0, rows.size + 1.0), (rows, columns)), shape=(cell.size, cell.size)
        )
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
        """Solution of Eq. (B1) for right-hand sides of shape (m, n_c, n_a), which are left
        alone.
        """
        columns = right.reshape(right.shape[0], -1).T
        return np.ascontiguousarray(self._factors.solve(np.asfortranarray(columns)).T).reshape(
            right.shape
        )


class Pardiso:
    """Factorisation by PARDISO of the MKL through pypardiso; the ordering is found once, for the
    sparsity never changes.

    One thread, so that a repeated step gives the same bits.

    Parameters
    ----------
    shape : tuple of int
        (n_circumferential, n_axial).

    Raises
    ------
    ImportError
        Without pypardiso or the MKL.
    """

    ANALYSE, FACTORISE, SOLVE, RELEASE = 11, 22, 33, -1

    def __init__(self, shape):
        from pypardiso import PyPardisoSolver

        self._pattern = FivePointPattern(shape, by_rows=True)
        self._solver = PyPardisoSolver(mtype=11)
        self._solver.set_iparm(1, 1)  # the settings below, not the defaults
        self._solver.set_iparm(2, 2)  # nested dissection
        self._solver.set_iparm(10, 13)  # pivots below 1e-13 are perturbed: an M-matrix has none
        self._solver.set_iparm(
            11, 0
        )  # no scaling and no matching, which would need a new analysis for each matrix:
        self._solver.set_iparm(13, 0)  # elimination of an M-matrix is stable without
        self._matrix = self._scale = None

    def factorise(self, stencil, stations=None):
        """Factorise anew, whatever changed."""
        first = self._matrix is None
        self._matrix = self._pattern.matrix(stencil)
        self._scale = stencil[
            0
        ].ravel()  # columns of pressure and of film fraction differ by orders of magnitude
        self._matrix.data /= self._scale[self._matrix.indices]
        for phase in (self.ANALYSE, self.FACTORISE) if first else (self.FACTORISE,):
            self._call(phase, np.zeros((self._matrix.shape[0], 1)))

    def solve(self, right):
        """Solution of Eq. (B1) for right-hand sides of shape (m, n_c, n_a), which are left
        alone.
        """
        columns = np.asfortranarray(right.reshape(right.shape[0], -1).T)
        return (self._call(self.SOLVE, columns).T / self._scale).reshape(right.shape)

    def _call(self, phase, columns):
        before = self._solver.libmkl.MKL_Set_Num_Threads_Local(1)
        try:
            self._solver.set_phase(phase)
            return self._solver._call_pardiso(self._matrix, columns)
        finally:
            self._solver.libmkl.MKL_Set_Num_Threads_Local(before)

    def __del__(self):
        if (
            getattr(self, "_matrix", None) is not None
        ):  # PARDISO's own memory outlives the object otherwise
            self._call(self.RELEASE, np.zeros((self._matrix.shape[0], 1)))


WIDEST_DENSE = (
    192  # cells across up to which dense blocks are faster than PARDISO, tests/bench/ehd_grids.py
)
LARGEST_DENSE = 2e9  # bytes of dense blocks that are still acceptable where there is no PARDISO


def linear_solver(shape):
    """The fastest solver at hand for a grid: dense blocks, else PARDISO if installed, else blocks
    while they fit, else SuperLU.

    Parameters
    ----------
    shape : tuple of int
        (n_circumferential, n_axial).
    """
    if shape[0] <= WIDEST_DENSE:
        return BlockTridiagonal(shape)
    try:
        return Pardiso(shape)
    except ImportError:
        return (
            BlockTridiagonal(shape)
            if 8.0 * shape[0] ** 2 * shape[1] <= LARGEST_DENSE
            else SuperLU(shape)
        )
