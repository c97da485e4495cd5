"""Cells without a film: windows, pin holes, where there is no skirt.

They hold the pressure and the film fraction of the lower edge, or of a supply of their own
(`parameters.opening_supply`), up to their edge, and carry no force: what presses on the ground of a
groove is the user's to add. For the film beside them that is an edge, half a cell from its centre,
with its own film alone, Eq. (E3) with g -> inf behind the face; what is given inside an opening is
looked at nowhere. Where oil is not in plenty, what sliding drags in from an opening is bounded as
over an edge, Eq. (E12).
"""

from functools import cached_property
from typing import Any

import numpy as np

from .films import CONDUCTIVITY_A, CONDUCTIVITY_C
from .grid import Array, Cells, Flags
from .reynolds import Faces, Filling

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
        self._size_of_cell = cells.dx, cells.dy
        # 1 where sliding drags oil in from an opening with ascending j, -1 with descending j
        self._inward = -np.diff(open_cells.astype(int), axis=1)

    @cached_property
    def _beside(self) -> tuple[Any, Any]:
        """Indices around and along of the nearest cells with a film."""
        from scipy.ndimage import distance_transform_edt  # slow to import; many films need it not

        around = len(self.open_cells)
        turns = np.concatenate([self.open_cells] * 3)  # the nearest may lie across the first one
        found = distance_transform_edt(
            turns, self._size_of_cell, return_distances=False, return_indices=True
        )
        i, j = np.asarray(found)[:, around : 2 * around]
        return i % around, j

    def filled(self, field: Array) -> Array:
        """A field (..., n_c, n_a) whose openings show the nearest cell with a film."""
        i, j = self._beside
        return np.ascontiguousarray(field[..., i, j])

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

    def starve(self, faces: Faces, limit: Array) -> Flags:
        """Bound what sliding drags in from openings, Eq. (E12); in place.

        Parameters
        ----------
        faces : reynolds.Faces
        limit : ndarray, shape (n_c, n_a + 1)
            S [m3/s], `grid.Edges`.

        Returns
        -------
        ndarray of bool, shape (n_c, n_a + 1)
            Faces where it is bounded.
        """
        wanted = self._inward * faces.transport_a[:, 1:-1]
        bounded = np.pad(wanted > limit[:, 1:-1], ((0, 0), (1, 1)))
        between = bounded[:, 1:-1]
        # Eq. (E12)
        faces.transport_a[bounded] = self._inward[between] * limit[bounded]
        return bounded

    def spilled(self, filling: Filling, faces: Faces) -> Array:
        """Flow into each opening from the films beside it around the circumference, Eq. (E2),
        shape (n_c, n_a) [m3/s]; 0 elsewhere.
        """
        pressure, fraction, _ = filling
        transport = faces.transport_c[:-1]
        # Eq. (E2)
        flow = faces.conductance_c[:-1] * (np.roll(pressure, 1, axis=0) - pressure)
        flow += np.maximum(transport, 0.0) * np.roll(fraction, 1, axis=0)
        flow += np.minimum(transport, 0.0) * fraction
        return np.where(self.open_cells, flow - np.roll(flow, -1, axis=0), 0.0)
