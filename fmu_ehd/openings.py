"""Cells without a film: windows, pin holes, where there is no skirt.

They hold the pressure and the film fraction of what is around the skirt, up to their edge. For the
film beside them that is an edge, half a cell from its centre, with its own film alone, Eq. (E3)
with g -> inf behind the face; what is given inside an opening is looked at nowhere.
"""

import numpy as np
from scipy.ndimage import distance_transform_edt

from .films import CONDUCTIVITY_A, CONDUCTIVITY_C
from .grid import Array, Cells, Flags
from .reynolds import Faces

FREE = 1e30  # conductivity of an opening: no resistance [m3/(Pa s)]


class Openings:
    """Cells without a film on a ring.

    Parameters
    ----------
    open_cells : ndarray of bool, shape (n_c, n_a)
    cells : grid.Cells
    """

    def __init__(self, open_cells: Flags, cells: Cells):
        self.open_cells = open_cells
        around = len(open_cells)
        turns = np.concatenate([open_cells] * 3)  # the nearest cell may lie across the first one
        found = distance_transform_edt(
            turns, (cells.dx, cells.dy), return_distances=False, return_indices=True
        )
        i, j = np.asarray(found)[:, around : 2 * around]
        self._beside = (..., i % around, j)

    def filled(self, field: Array) -> Array:
        """A field (..., n_c, n_a) whose openings show the nearest cell with a film."""
        return np.ascontiguousarray(field[self._beside])

    def without_resistance(self, film: Array) -> Array:
        """Quantities of `films`, (6, n_c, n_a), with openings that oil runs freely through."""
        film = film.copy()
        for row in (CONDUCTIVITY_C, CONDUCTIVITY_A):
            film[row][self.open_cells] = FREE
        return film

    def close(self, faces: Faces) -> None:
        """Stop the flow of faces that have no film on either side; in place."""
        at = self.open_cells
        across = at & np.roll(at, 1, axis=0)
        for values in (faces.conductance_c, faces.transport_c):
            values[:-1][across] = 0.0
            values[-1] = values[0]
        along = np.pad(at, ((0, 0), (1, 1)), constant_values=True)
        for values in (faces.conductance_a, faces.transport_a):
            values[along[:, 1:] & along[:, :-1]] = 0.0
