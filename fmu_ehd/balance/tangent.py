"""Tangent of the mass balance of `reynolds`, exact.

Derivatives of the residual R of Eq. (E1), with the matrix M of the step and the names of
`reynolds`:

Eq. (E6):  M du = -(dR/ds ds + dR/dt dt + dR/dg dg + dR/dU dU)

They are two five-point stencils, which all directions share: one to the film thickness and one to
the sliding velocity.
"""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compiled
from ..common.grid import (
    CENTRE,
    EAST,
    FIRST,
    LAST,
    LOWER,
    NORTH,
    SOUTH,
    UPPER,
    WEST,
    Array,
    Cells,
    Edges,
    Entrainment,
    Flags,
    face_shares,
    images,
)
from ..common.quantities import CONDUCTIVITY_A, CONDUCTIVITY_C, STORED, TRANSPORT, FilmSlopes
from .flows import Filling

# first axis of the tangent of the film balance: derivative to film thickness and to sliding
# velocity
BY_FILM, BY_VELOCITY = range(2)


class Side(NamedTuple):
    """Quantities of the cell on one side of a face.

    conductivity g [m3/(Pa s)], transport t [m], pressure p [Pa], film_fraction f [-].
    """

    conductivity: float
    transport: float
    pressure: float
    film_fraction: float


class FlowSlopes(NamedTuple):
    """Derivatives of the face flow from cell a to cell b.

    g_a, g_b : to the conductivities [Pa]; t_a, t_b : to the transported films [m2/s];
    velocity : to the entrainment velocity at the face [m2].
    """

    g_a: float
    g_b: float
    t_a: float
    t_b: float
    velocity: float


@compiled(forceinline=True)
def _side(conductivity, transport, pressure, fraction, i, j):
    """Return the quantities of cell (i, j) that a face needs."""
    return Side(conductivity[i, j], transport[i, j], pressure[i, j], fraction[i, j])


@compiled(forceinline=True)
def _flow_slopes(a, b, velocity, aspect, width, lift=0.0):
    """Return the derivatives of the face flow from `Side` a to b, Eqs. (E2), (E3)."""
    upstream = lift + (a.film_fraction if velocity > 0.0 else b.film_fraction)
    inverse = 1.0 / (a.conductivity + b.conductivity)
    share_a = a.conductivity * inverse
    share_b = b.conductivity * inverse
    moved = width * velocity * upstream
    bend = moved * (b.transport - a.transport) * inverse
    driven = 2.0 * aspect * (a.pressure - b.pressure)
    return FlowSlopes(
        share_b * (share_b * driven + bend),
        share_a * (share_a * driven - bend),
        moved * share_b,
        moved * share_a,
        width * upstream * (a.transport * share_b + b.transport * share_a),
    )


@compiled(forceinline=True)
def _of_cell(g, t, velocity, row, slopes, du, i, j):
    """Return the derivatives of a face flow to film thickness and sliding velocity of a cell.

    g, t, velocity : its derivatives to conductivity, transported film and entrainment there;
    row : of the conductivity in `films`.
    """
    by_film, by_velocity = slopes
    of_film = g * by_film[row, i, j] + t * by_film[TRANSPORT, i, j]
    of_velocity = velocity * du[i, j]
    if by_velocity.shape[0] > 0:
        of_velocity += g * by_velocity[row, i, j] + t * by_velocity[TRANSPORT, i, j]
    return of_film, of_velocity


@compiled(forceinline=True)
def _edge_slopes(cell, velocity, pressure, entering, sign, aspect, width, lift=0.0):
    """Return the derivatives of the flow over an edge of a cell. Its film is on both sides.

    sign : -1 if the flow counts into the cell, 1 if it counts out of it.
    """
    beyond = Side(cell.conductivity, cell.transport, pressure, entering)
    a, b = (beyond, cell) if sign < 0.0 else (cell, beyond)
    return _flow_slopes(a, b, velocity, aspect, width, lift)


@compiled(forceinline=True)
def _add_edge(q, sign, row, slopes, du, centre, i, j):
    """Add the derivatives of the flow over an edge, `FlowSlopes` q, to the centre of both stencils.

    sign : as in `_edge_slopes`; row : of the conductivity in `films`.
    """
    g, t = q.g_a + q.g_b, q.t_a + q.t_b
    of_film, of_velocity = _of_cell(g, t, q.velocity, row, slopes, du, i, j)
    centre[BY_FILM, i, j] += sign * of_film
    centre[BY_VELOCITY, i, j] += sign * of_velocity


@compiled
def _add_edges(film, slopes, entrainment, dentrainment, filling, edges, cells, centre):
    """Add the derivatives of the flows over the edges to both centres."""
    dx, dy, ring, mirrored = cells
    pressure, fraction, lift = filling
    n_c, n_a = pressure.shape
    t = film[TRANSPORT]
    g = film[CONDUCTIVITY_A]
    u = entrainment.axial
    du = dentrainment.axial
    for i in range(n_c):
        width = images(cells.mirrored, i, n_c) * dx
        aspect = 2.0 * width / dy
        for edge, j, sign in ((LOWER, 0, -1.0), (UPPER, n_a - 1, 1.0)):
            cell = _side(g, t, pressure, fraction, i, j)
            entering = edges.film_fraction[edge]
            face = 0 if edge == LOWER else n_a
            if -sign * width * u[i, j] * t[i, j] * entering > edges.limit[i, face]:
                entering = 0.0  # a given inflow follows neither film nor velocity
            leaving = lift.axial[i, face]
            outside = edges.pressure[edge]
            q = _edge_slopes(cell, u[i, j], outside, entering, sign, aspect, width, leaving)
            _add_edge(q, sign, CONDUCTIVITY_A, slopes, du, centre, i, j)
    if ring or mirrored:
        return
    g = film[CONDUCTIVITY_C]
    u = entrainment.circumferential
    du = dentrainment.circumferential
    aspect = 2.0 * dy / dx
    for j in range(n_a):
        for edge, i, sign in ((FIRST, 0, -1.0), (LAST, n_c - 1, 1.0)):
            cell = _side(g, t, pressure, fraction, i, j)
            entering = edges.film_fraction[edge]
            leaving = lift.around[0 if edge == FIRST else n_c, j]
            outside = edges.pressure[edge]
            q = _edge_slopes(cell, u[i, j], outside, entering, sign, aspect, dy, leaving)
            _add_edge(q, sign, CONDUCTIVITY_C, slopes, du, centre, i, j)


@compiled
def _balance_cells(stencil):
    """Set the centre of both stencils: a cell loses what its neighbours win."""
    _, _, n_c, n_a = stencil.shape
    for m in range(2):
        for i in range(n_c):
            before = (i - 1) % n_c
            after = (i + 1) % n_c
            for j in range(n_a):
                stencil[m, CENTRE, i, j] = -(
                    stencil[m, WEST, after, j] + stencil[m, EAST, before, j]
                )
            for j in range(n_a - 1):
                stencil[m, CENTRE, i, j] -= stencil[m, SOUTH, i, j + 1]
            for j in range(1, n_a):
                stencil[m, CENTRE, i, j] -= stencil[m, NORTH, i, j - 1]


@compiled
def linearise(
    film: Array,
    slopes: FilmSlopes,
    streams: tuple[Entrainment, Entrainment],
    filling: Filling,
    edges: Edges,
    open_cells: Flags,
    cells: Cells,
    area_per_step: float,
):
    """Return the derivative of the cell balance, Eq. (E1), as two five-point stencils.

    They are those to film thickness and to sliding velocity.

    The upstream cell of a face does not change. At rest, the cell before the face counts as
    downstream of the one behind it.

    Parameters
    ----------
    film : ndarray, shape (6, n_c, n_a)
        Quantities of `films`.
    slopes : quantities.FilmSlopes
    streams : (grid.Entrainment, grid.Entrainment)
        Entrainment [m/s], and its derivatives to the sliding velocity [-].
    filling : flows.Filling
    edges : grid.Edges
    open_cells : ndarray of bool, shape (n_c, n_a)
        Cells without a film, whose velocity has no effect.
    cells : grid.Cells
    area_per_step : float
        As in `reynolds.Storage`.

    Returns
    -------
    ndarray, shape (2, 5, n_c, n_a)
        First axis BY_FILM, BY_VELOCITY; second axis as in `reynolds.assemble`.
    """
    by_film, by_velocity = slopes
    entrainment, dentrainment = streams
    dx, dy, ring, mirrored = cells
    height = 2.0 * dy if mirrored else dy
    pressure, fraction, lift = filling
    n_c, n_a = pressure.shape
    stencil = np.empty((2, 5, n_c, n_a))
    stencil[:, SOUTH, :, 0] = 0.0  # no neighbour beyond an edge
    stencil[:, NORTH, :, n_a - 1] = 0.0
    if not ring:
        stencil[:, WEST, 0] = 0.0
        stencil[:, EAST, n_c - 1] = 0.0
    t = film[TRANSPORT]
    g = film[CONDUCTIVITY_A]
    u = entrainment.axial
    du = dentrainment.axial
    for i in range(n_c):
        width = images(cells.mirrored, i, n_c) * dx
        for j in range(n_a - 1):
            a = _side(g, t, pressure, fraction, i, j)
            b = _side(g, t, pressure, fraction, i, j + 1)
            share_a, share_b = face_shares(open_cells[i, j], open_cells[i, j + 1])
            velocity = share_a * u[i, j] + share_b * u[i, j + 1]
            q = _flow_slopes(a, b, velocity, width / dy, width, lift.axial[i, j + 1])
            by_a, by_b = share_a * q.velocity, share_b * q.velocity
            here = _of_cell(q.g_a, q.t_a, by_a, CONDUCTIVITY_A, slopes, du, i, j)
            there = _of_cell(q.g_b, q.t_b, by_b, CONDUCTIVITY_A, slopes, du, i, j + 1)
            for m in range(2):
                stencil[m, SOUTH, i, j + 1] = -here[m]
                stencil[m, NORTH, i, j] = there[m]

    g = film[CONDUCTIVITY_C]
    u = entrainment.circumferential
    du = dentrainment.circumferential
    for i in range(n_c if ring else n_c - 1):
        k = (i + 1) % n_c
        for j in range(n_a):
            a = _side(g, t, pressure, fraction, i, j)
            b = _side(g, t, pressure, fraction, k, j)
            share_a, share_b = face_shares(open_cells[i, j], open_cells[k, j])
            velocity = share_a * u[i, j] + share_b * u[k, j]
            q = _flow_slopes(a, b, velocity, height / dx, height, lift.around[i + 1, j])
            by_a, by_b = share_a * q.velocity, share_b * q.velocity
            here = _of_cell(q.g_a, q.t_a, by_a, CONDUCTIVITY_C, slopes, du, i, j)
            there = _of_cell(q.g_b, q.t_b, by_b, CONDUCTIVITY_C, slopes, du, k, j)
            for m in range(2):
                stencil[m, WEST, k, j] = -here[m]
                stencil[m, EAST, i, j] = there[m]

    _balance_cells(stencil)
    centre = stencil[:, CENTRE]
    _add_edges(film, slopes, entrainment, dentrainment, filling, edges, cells, centre)
    for i in range(n_c):
        for j in range(n_a):
            held = images(cells.mirrored, i, n_c) * area_per_step * fraction[i, j]
            stencil[BY_FILM, CENTRE, i, j] += held * by_film[STORED, i, j]
            if by_velocity.shape[0] > 0:
                stencil[BY_VELOCITY, CENTRE, i, j] += held * by_velocity[STORED, i, j]
    return stencil


@compiled
def apply_stencils(stencil: Array, dfilm: Array, dvelocity: Array, out: Array):
    """Return the right-hand sides of Eq. (E6) for changes of film and sliding velocity.

    Parameters
    ----------
    stencil : ndarray, shape (2, 5, n_c, n_a)
        From `linearise`.
    dfilm, dvelocity : ndarray, shape (m, n_c, n_a)
        [m], [m/s].
    out : ndarray, shape (m, n_c, n_a)
        Overwritten [m3/s].
    """
    m, n_c, n_a = dfilm.shape
    row = np.empty(n_a)
    for q in range(m):
        for i in range(n_c):
            before = (i - 1) % n_c
            after = (i + 1) % n_c
            for j in range(n_a):
                row[j] = (
                    stencil[BY_FILM, CENTRE, i, j] * dfilm[q, i, j]
                    + stencil[BY_FILM, WEST, i, j] * dfilm[q, before, j]
                    + stencil[BY_FILM, EAST, i, j] * dfilm[q, after, j]
                )
            for j in range(n_a):
                row[j] += (
                    stencil[BY_VELOCITY, CENTRE, i, j] * dvelocity[q, i, j]
                    + stencil[BY_VELOCITY, WEST, i, j] * dvelocity[q, before, j]
                    + stencil[BY_VELOCITY, EAST, i, j] * dvelocity[q, after, j]
                )
            for j in range(1, n_a):
                row[j] += (
                    stencil[BY_FILM, SOUTH, i, j] * dfilm[q, i, j - 1]
                    + stencil[BY_VELOCITY, SOUTH, i, j] * dvelocity[q, i, j - 1]
                )
            for j in range(n_a - 1):
                row[j] += (
                    stencil[BY_FILM, NORTH, i, j] * dfilm[q, i, j + 1]
                    + stencil[BY_VELOCITY, NORTH, i, j] * dvelocity[q, i, j + 1]
                )
            for j in range(n_a):
                out[q, i, j] = -row[j]
