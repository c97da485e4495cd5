"""Sparse direct solvers with the interface of `blocks.BlockTridiagonal`.

`linear_solver` selects among all solvers.
"""

from typing import Any, Protocol

import numpy as np

from ..common.grid import CENTRE, EAST, NORTH, SOUTH, WEST, Array
from .blocks import BlockTridiagonal


class LinearSolver(Protocol):
    """Solver of Eq. (B1), as a step of the film needs it."""

    def factorise(self, stencil: Array, stations: tuple[int, int] | None = None) -> None:
        """Factorise the stencil, shape (5, n_c, n_a).

        Only columns of the axial stations from the first to the last of `stations` have changed
        since the last call.
        """

    def solve(self, right: Array) -> Array:
        """Return the solution for right-hand sides of shape (m, n_c, n_a).

        The right-hand sides may be overwritten.
        """
        ...


class FivePointPattern:
    """Sparsity of Eq. (B1) and the order in which stencil values enter a compressed matrix.

    Parameters
    ----------
    shape : tuple of int
        (n_circumferential, n_axial), at least 3 x 1.
    by_rows : bool
        Compressed rows (CSR) instead of columns (CSC).
    """

    def __init__(self, shape: tuple[int, int], by_rows: bool):
        from scipy.sparse import csc_matrix, csr_matrix  # slow to import

        cell = np.arange(shape[0] * shape[1]).reshape(shape)
        neighbours = np.empty((5, *shape), dtype=cell.dtype)
        neighbours[CENTRE] = cell
        neighbours[SOUTH] = np.roll(cell, 1, 1)
        neighbours[NORTH] = np.roll(cell, -1, 1)
        neighbours[WEST] = np.roll(cell, 1, 0)
        neighbours[EAST] = np.roll(cell, -1, 0)
        inside = np.ones((5, *shape), dtype=bool)
        inside[SOUTH, :, 0] = False  # no neighbour south of the first station
        inside[NORTH, :, -1] = False  # and none north of the last one
        entries = np.flatnonzero(inside)
        rows = np.broadcast_to(cell, neighbours.shape).ravel()[entries]
        columns = neighbours.ravel()[entries]
        self._kind = csr_matrix if by_rows else csc_matrix
        numbers = np.arange(1.0, rows.size + 1.0)
        numbered = self._kind((numbers, (rows, columns)), shape=(cell.size, cell.size))
        numbered.sort_indices()
        self._order = entries[numbered.data.astype(np.int64) - 1]
        self._indices = numbered.indices
        self._indptr = numbered.indptr
        self._size = cell.size

    def matrix(self, stencil: Array):
        """Return the compressed matrix of a stencil, shape (5, n_c, n_a)."""
        values = np.ravel(stencil)[self._order]  # Eq. (B1)
        return self._kind((values, self._indices, self._indptr), shape=(self._size, self._size))


class SuperLU:
    """Factorisation by SuperLU of scipy.

    Parameters
    ----------
    shape : tuple of int
        (n_circumferential, n_axial).
    """

    def __init__(self, shape: tuple[int, int]):
        self._pattern = FivePointPattern(shape, by_rows=False)
        self._factors: Any = None

    def factorise(self, stencil: Array, stations: tuple[int, int] | None = None) -> None:
        """Factorise the whole stencil."""
        from scipy.sparse.linalg import splu  # slow to import

        self._factors = splu(self._pattern.matrix(stencil))

    def solve(self, right: Array) -> Array:
        """Return the solution of Eq. (B1) for right-hand sides of shape (m, n_c, n_a)."""
        columns = right.reshape(right.shape[0], -1).T
        solution = self._factors.solve(np.asfortranarray(columns))
        return np.ascontiguousarray(solution.T).reshape(right.shape)


class Pardiso:
    """Factorisation by PARDISO of the MKL through pypardiso.

    The ordering is computed once, because the sparsity never changes.

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

    def __init__(self, shape: tuple[int, int]):
        from pypardiso import PyPardisoSolver  # pyright: ignore[reportMissingImports]

        self._pattern = FivePointPattern(shape, by_rows=True)
        self._solver = PyPardisoSolver(mtype=11)
        self._solver.set_iparm(1, 1)  # the settings below, not the defaults
        self._solver.set_iparm(2, 2)  # nested dissection
        self._solver.set_iparm(10, 13)  # pivots below 1e-13 are perturbed: an M-matrix has none
        # no scaling and no matching, which would need a new analysis for each matrix:
        # elimination of an M-matrix is stable without
        self._solver.set_iparm(11, 0)
        self._solver.set_iparm(13, 0)
        self._matrix: Any = None
        self._scale = np.empty(0)

    def factorise(self, stencil: Array, stations: tuple[int, int] | None = None) -> None:
        """Factorise the whole stencil."""
        first = self._matrix is None
        self._matrix = self._pattern.matrix(stencil)
        # columns of pressure and of film fraction differ by orders of magnitude
        self._scale = stencil[CENTRE].ravel()
        self._matrix.data /= self._scale[self._matrix.indices]
        for phase in (self.ANALYSE, self.FACTORISE) if first else (self.FACTORISE,):
            self._call(phase, np.zeros((self._matrix.shape[0], 1)))

    def solve(self, right: Array) -> Array:
        """Return the solution of Eq. (B1) for right-hand sides of shape (m, n_c, n_a)."""
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
        # PARDISO's own memory outlives the object otherwise
        if getattr(self, "_matrix", None) is not None:
            self._call(self.RELEASE, np.zeros((self._matrix.shape[0], 1)))


# cells across up to which dense blocks are faster than PARDISO, tests/bench/ehd_grids.py
WIDEST_DENSE = 192
LARGEST_DENSE = 2e9  # bytes of dense blocks that are still acceptable where there is no PARDISO


def linear_solver(shape: tuple[int, int]) -> LinearSolver:
    """Return the fastest available solver for a grid.

    It is dense blocks, else PARDISO if installed, else blocks while they fit, else SuperLU.

    Parameters
    ----------
    shape : tuple of int
        (n_circumferential, n_axial).
    """
    across, stations = shape
    if across <= WIDEST_DENSE:
        return BlockTridiagonal(shape)
    try:
        return Pardiso(shape)
    except ImportError:
        dense = 8.0 * across**2 * stations <= LARGEST_DENSE
        return BlockTridiagonal(shape) if dense else SuperLU(shape)
