"""Cells without a film: windows, pin holes, where there is no skirt.

An opening has the pressure and the film fraction of the lower edge, or those of the supply
`parameters.opening_supply`. Its pressure exerts no force on the bodies. If the ground of a groove
is loaded, the user must add that force.

The film next to an opening has an edge there, half a cell from the centre of its last cell. In
Eq. (E3) the conductivity of the opening is infinite, so only the film of that cell counts. Inputs
inside an opening have no effect. If the supply is limited, Eq. (E12) bounds the oil that sliding
drags in from an opening, as for an edge.
"""

import numpy as np

from ...master.fmi.compiled import compiled
from ..common.grid import Array, Cells, Flags, row_at
from ..common.quantities import CONDUCTIVITY_A, CONDUCTIVITY_C
from .flows import Faces

FREE = 1e30  # conductivity of an opening: no resistance [m3/(Pa s)]


@compiled
def nearest(open_cells: Flags, cells: Cells):
    """Return the nearest cell with a film, from centre to centre.

    Of cells at the same distance it is the one with the lower j, then the first one around.

    Parameters
    ----------
    open_cells : ndarray of bool, shape (n_c, n_a)
    cells : grid.Cells
        Cells of a ring or of a mirrored grid.

    Returns
    -------
    ndarray of int, shape (n_c, n_a)
        i n_a + j of that cell; of a cell with a film, and if no cell has a film, its own.
    """
    n_c, n_a = open_cells.shape
    nearest_cell = np.empty((n_c, n_a), np.int64)
    for i in range(n_c):
        for j in range(n_a):
            nearest_cell[i, j] = i * n_a + j
            if not open_cells[i, j]:
                continue
            least = np.inf
            for k in range(n_a):
                along = (k - j) * cells.dy
                for steps in range(n_c):
                    before = row_at(cells, i - steps, n_c)
                    after = row_at(cells, i + steps, n_c)
                    if open_cells[before, k] and open_cells[after, k]:
                        continue
                    around = steps * cells.dx
                    distance = around * around + along * along
                    if distance < least:
                        least = distance
                        row = after if open_cells[before, k] else before
                        nearest_cell[i, j] = row * n_a + k
                    break
    return nearest_cell


@compiled
def with_free_openings(open_cells: Flags, film: Array):
    """Return the quantities of `films`, (6, n_c, n_a), with openings without resistance."""
    film = film.copy()
    for i in range(open_cells.shape[0]):
        for j in range(open_cells.shape[1]):
            if open_cells[i, j]:
                film[CONDUCTIVITY_C, i, j] = FREE
                film[CONDUCTIVITY_A, i, j] = FREE
    return film


@compiled
def close_faces(open_cells: Flags, faces: Faces):
    """Set the flow of faces without a film on either side to zero; in place."""
    n_c, n_a = open_cells.shape
    for i in range(n_c + 1):
        before = (i - 1) % n_c
        after = i % n_c
        for j in range(n_a):
            if open_cells[before, j] and open_cells[after, j]:
                faces.conductance_c[i, j] = 0.0
                faces.transport_c[i, j] = 0.0
    for i in range(n_c):
        for j in range(n_a + 1):
            if (j == 0 or open_cells[i, j - 1]) and (j == n_a or open_cells[i, j]):
                faces.conductance_a[i, j] = 0.0
                faces.transport_a[i, j] = 0.0


@compiled
def flow_into_openings(open_cells: Flags, around: Array):
    """Return the flow into each opening from its neighbours around the circumference.

    The shape is (n_c, n_a) [m3/s]; it is 0 elsewhere. `around` is of `flows.flow_around`.
    """
    n_c, n_a = open_cells.shape
    into = np.zeros((n_c, n_a))
    for i in range(n_c):
        for j in range(n_a):
            if open_cells[i, j]:
                into[i, j] = around[i, j] - around[i + 1, j]
    return into


@compiled
def flow_from_openings(open_cells: Flags, axial_flow: Array, into: Array):
    """Return the flow into the film from all openings [m3/s].

    Parameters
    ----------
    open_cells : ndarray of bool, shape (n_c, n_a)
    axial_flow : ndarray, shape (n_c, n_a + 1)
        Through the axial faces [m3/s].
    into : ndarray, shape (n_c, n_a)
        From `flow_into_openings`.
    """
    total = 0.0
    for i in range(open_cells.shape[0]):
        for j in range(open_cells.shape[1]):
            if open_cells[i, j]:
                total += axial_flow[i, j + 1] - axial_flow[i, j] - into[i, j]
    return total


@compiled
def limit_supply(open_cells: Flags, faces: Faces, limit: Array):
    """Bound what sliding drags in from openings, Eq. (E12); in place.

    Parameters
    ----------
    open_cells : ndarray of bool, shape (n_c, n_a)
    faces : flows.Faces
    limit : ndarray, shape (n_c, n_a + 1)
        S [m3/s], `grid.Edges`.

    Returns
    -------
    ndarray of bool, shape (n_c, n_a + 1)
        Faces where it is bounded.
    """
    n_c, n_a = open_cells.shape
    bounded = np.zeros((n_c, n_a + 1), np.bool_)
    for i in range(n_c):
        for j in range(1, n_a):
            if open_cells[i, j - 1] == open_cells[i, j]:
                continue
            inward = 1.0 if open_cells[i, j - 1] else -1.0  # with ascending j, or descending
            if inward * faces.transport_a[i, j] > limit[i, j]:
                faces.transport_a[i, j] = inward * limit[i, j]  # Eq. (E12)
                bounded[i, j] = True
    return bounded


@compiled
def with_nearest_values(nearest_cell: np.ndarray, fields: Array):
    """Return fields whose openings have the values of the nearest cell with a film.

    Parameters
    ----------
    nearest_cell : ndarray, shape (n_c, n_a)
        From `nearest`.
    fields : ndarray, shape (m, n_c, n_a)
    """
    m, n_c, n_a = fields.shape
    whole = np.empty((m, n_c, n_a))
    for q in range(m):
        for i in range(n_c):
            for j in range(n_a):
                k = int(nearest_cell[i, j])
                whole[q, i, j] = fields[q, k // n_a, k % n_a]
    return whole
