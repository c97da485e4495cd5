"""Mass balance of a thin film on a grid: face flows and five-point matrix.

Each cell, with c_e and H_e of `storage`:

Eq. (E1):  A (f s - c_e) / H_e + sum of outward face flows = 0

Flow from cell a to its neighbour b [m3/s]:

Eq. (E2):  q = K (p_a - p_b) + max(T, 0) f_a + min(T, 0) f_b + T l
Eq. (E3):  K = (w/d) 2 kappa_a kappa_b / (kappa_a + kappa_b)
           T = w U (h_Ua kappa_b + h_Ub kappa_a) / (kappa_a + kappa_b)

One signed unknown u a cell:

Eq. (E4):  u > 0: p = u, f = 1;   u <= 0: p = 0, f = 1 + u

which makes the flow linear, c = K or T by whether a (or b) is full or cavitated:

Eq. (E5):  q = c_a u_a + c_b u_b + T (1 + l),   c_a = K or max(T, 0),   c_b = -K or min(T, 0)

Sliding drags in over an edge, T towards the film,

Eq. (E12):  min(max(T, 0) f, S)

A cell area [m2], H_e length of the backward Euler step [s] that starts from the content c_e [m], f
film fraction [-], p pressure above cavitation pressure [Pa], w face width, d distance between cell
centres [m], U entrainment velocity at the face, the mean of both cells [m/s]. Per cell: s stored
film [m], h_U transported film [m], kappa conductivity [m3/(Pa s)]; for smooth surfaces s = h_U = h
and kappa = h^3 / (12 mu). l is the lift of the film fraction at the face [-], known when a step
begins and 0 without one, `transport`. f at an edge and S, the most that can be dragged in [m3/s],
are given, `grid.Edges`. Over an edge, l applies to oil that leaves the film.

The face film of Eq. (E3) is that of two half cells of constant thickness in series, so a stepped
film is exact on every grid and a smooth one of second order; it stays near the thinner film where
the film jumps. Film fraction multiplies the same face film upstream, so the flow is continuous when
a cell fills or empties, f >= 0, and the matrix is a column-dominant M-matrix. Its columns for u <=
0 need no scaling: elimination is indifferent to column scale. Edges are half a cell away from the
centre (d/2), with the film of their cell.

Arrays have the shape (n_c, n_a) of the grid; faces (n_c + 1, n_a) across i and (n_c, n_a + 1)
across j. Face i is between cells i - 1 and i. All functions are pure, except `hold`.

References
----------
[Elrod1981] H. G. Elrod, A cavitation algorithm, J. Lubr. Technol. 103 (1981) 350-354 (the film
content as unknown).
[Woloszynski2015] T. Woloszynski, P. Podsiadlo, G. W. Stachowiak, Efficient solution to the
cavitation problem in hydrodynamic lubrication, Tribol. Lett. 58 (2015) 18 (the complementarity
form).
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
from ..common.quantities import CONDUCTIVITY_A, CONDUCTIVITY_C, TRANSPORT
from .flows import FaceLift, Faces, Filling, dragged, outflow

# share of the gross flows, and of the film volume a step, that the throughput of a film is taken
# for at least
LEAST_THROUGHPUT = 1e-3


class Storage(NamedTuple):
    """Storage term of Eq. (E1).

    stored, content : ndarray, shape (n_c, n_a)
        Stored film s of a full cell at the end of the step, and content c_e that the step starts
        from [m].
    area_per_step : float
        A / H_e of one image [m2/s]; 0 for a steady film.
    """

    stored: Array
    content: Array
    area_per_step: float


class Balance(NamedTuple):
    """Residual of Eq. (E1).

    film_fraction, content, residual : ndarray, shape (n_c, n_a)
        f [-], content f s at the end of the step [m], inflow - growth [m3/s]; both 0 in openings.
    edge_flow : ndarray, shape (4,)
        As `Outflow.edges`.
    imbalance : float
        |inflow - growth| / throughput of the whole film [-].
    axial_flow, flow_around : ndarray, shapes (n_c, n_a + 1) and (n_c + 1, n_a)
        As `Outflow.axial` and `Outflow.around`.
    """

    film_fraction: Array
    content: Array
    residual: Array
    edge_flow: Array
    imbalance: float
    axial_flow: Array
    flow_around: Array


@compiled(forceinline=True)
def _face(g_a, g_b, t_a, t_b, velocity, aspect, width):
    """Return the conductance K and transport T of a face, Eq. (E3)."""
    inverse = 1.0 / (g_a + g_b)
    conductance = aspect * 2.0 * g_a * g_b * inverse  # Eq. (E3)
    transport = width * velocity * (t_a * g_b + t_b * g_a) * inverse
    return conductance, transport


@compiled
def faces(film: Array, entrainment: Entrainment, open_cells: Flags, cells: Cells):
    """Return the conductances and transports of all faces, Eq. (E3).

    Parameters
    ----------
    film : ndarray, shape (6, n_c, n_a)
        Quantities of `films`; conductivities and transported film > 0.
    entrainment : grid.Entrainment
    open_cells : ndarray of bool, shape (n_c, n_a)
        Cells without a film, whose velocity has no effect.
    cells : grid.Cells

    Returns
    -------
    Faces
    """
    dx, dy, ring, mirrored = cells
    height = 2.0 * dy if mirrored else dy  # Eq. (E19)
    velocity_c, velocity_a = entrainment
    _, n_c, n_a = film.shape
    k_c = np.empty((n_c + 1, n_a))
    t_c = np.empty((n_c + 1, n_a))
    k_a = np.empty((n_c, n_a + 1))
    t_a = np.empty((n_c, n_a + 1))
    for i in range(n_c + 1):
        if ring:
            below = (i - 1) % n_c
            above = i % n_c
        else:
            below = max(i - 1, 0)
            above = min(i, n_c - 1)
        aspect = height / dx if ring or 0 < i < n_c else 2.0 * dy / dx
        for j in range(n_a):
            if mirrored and not 0 < i < n_c:
                k_c[i, j] = t_c[i, j] = 0.0
                continue
            share_a, share_b = face_shares(open_cells[below, j], open_cells[above, j])
            k_c[i, j], t_c[i, j] = _face(
                film[CONDUCTIVITY_C, below, j],
                film[CONDUCTIVITY_C, above, j],
                film[TRANSPORT, below, j],
                film[TRANSPORT, above, j],
                share_a * velocity_c[below, j] + share_b * velocity_c[above, j],
                aspect,
                height,
            )
    for i in range(n_c):
        width = images(cells.mirrored, i, n_c) * dx  # Eq. (E19)
        for j in range(n_a + 1):
            below = max(j - 1, 0)
            above = min(j, n_a - 1)
            aspect = width / dy if 0 < j < n_a else 2.0 * width / dy
            share_a, share_b = face_shares(open_cells[i, below], open_cells[i, above])
            k_a[i, j], t_a[i, j] = _face(
                film[CONDUCTIVITY_A, i, below],
                film[CONDUCTIVITY_A, i, above],
                film[TRANSPORT, i, below],
                film[TRANSPORT, i, above],
                share_a * velocity_a[i, below] + share_b * velocity_a[i, above],
                aspect,
                width,
            )
    return Faces(k_c, t_c, k_a, t_a)


@compiled(forceinline=True)
def _inflow_part(k, t, pressure, fraction, limit):
    """Return the known part of the flow over an edge into a full film, Eq. (E5).

    The edge drives it in; t : transport into the film.
    """
    return k * pressure + dragged(t, fraction, limit) + min(t, 0.0)


@compiled
def assemble(
    full: Flags, faces: Faces, lift: FaceLift, storage: Storage, edges: Edges, cells: Cells
):
    """Return five-point matrix and right-hand side of Eq. (E1), by Eq. (E5).

    The pattern of full cells is given.

    Parameters
    ----------
    full : ndarray of bool, shape (n_c, n_a)
        Pattern: True where u is pressure.
    faces : Faces
    lift : FaceLift
    storage : Storage
    edges : grid.Edges
    cells : grid.Cells

    Returns
    -------
    stencil : ndarray, shape (5, n_c, n_a)
        Axis as in `grid`.
    right : ndarray, shape (n_c, n_a)
        [m3/s].
    """
    k_c, t_c, k_a, t_a = faces
    lift_axial, lift_around = lift
    stored, content, area_per_step = storage
    edge_pressure, edge_fraction, _ = edges
    ring = cells.ring
    n_c, n_a = full.shape
    stencil = np.zeros((5, n_c, n_a))
    right = np.empty((n_c, n_a))
    for i in range(n_c):
        rate = images(cells.mirrored, i, n_c) * area_per_step
        for j in range(n_a):
            right[i, j] = rate * (content[i, j] - stored[i, j])  # Eq. (E1)
            if not full[i, j]:
                stencil[CENTRE, i, j] = rate * stored[i, j]
    for i in range(n_c if ring else n_c + 1):  # on a ring face n_c is face 0
        a = (i - 1) % n_c
        b = i % n_c
        for j in range(n_a):
            k = k_c[i, j]
            t = t_c[i, j]
            c_a = k if full[a, j] else max(t, 0.0)  # Eq. (E5)
            c_b = -k if full[b, j] else min(t, 0.0)
            if ring or 0 < i < n_c:
                stencil[CENTRE, a, j] += c_a
                stencil[EAST, a, j] += c_b
                right[a, j] -= t * (1.0 + lift_around[i, j])
                stencil[CENTRE, b, j] -= c_b
                stencil[WEST, b, j] -= c_a
                right[b, j] += t * (1.0 + lift_around[i, j])
            elif i == 0:
                stencil[CENTRE, b, j] -= c_b
                right[b, j] += _inflow_part(
                    k, t, edge_pressure[FIRST], edge_fraction[FIRST], np.inf
                )
                right[b, j] += min(t, 0.0) * lift_around[i, j]
            else:
                stencil[CENTRE, a, j] += c_a
                right[a, j] += _inflow_part(k, -t, edge_pressure[LAST], edge_fraction[LAST], np.inf)
                right[a, j] += min(-t, 0.0) * lift_around[i, j]
    for i in range(n_c):
        k = k_a[i, 0]
        t = t_a[i, 0]
        stencil[CENTRE, i, 0] -= -k if full[i, 0] else min(t, 0.0)
        right[i, 0] += _inflow_part(
            k, t, edge_pressure[LOWER], edge_fraction[LOWER], edges.limit[i, 0]
        )
        right[i, 0] += min(t, 0.0) * lift_axial[i, 0]
        for j in range(1, n_a):
            k = k_a[i, j]
            t = t_a[i, j]
            c_a = k if full[i, j - 1] else max(t, 0.0)
            c_b = -k if full[i, j] else min(t, 0.0)
            stencil[CENTRE, i, j - 1] += c_a
            stencil[NORTH, i, j - 1] += c_b
            right[i, j - 1] -= t * (1.0 + lift_axial[i, j])
            stencil[CENTRE, i, j] -= c_b
            stencil[SOUTH, i, j] -= c_a
            right[i, j] += t * (1.0 + lift_axial[i, j])
        k = k_a[i, n_a]
        t = t_a[i, n_a]
        stencil[CENTRE, i, n_a - 1] += k if full[i, n_a - 1] else max(t, 0.0)
        right[i, n_a - 1] += _inflow_part(
            k, -t, edge_pressure[UPPER], edge_fraction[UPPER], edges.limit[i, n_a]
        )
        right[i, n_a - 1] += min(-t, 0.0) * lift_axial[i, n_a]
    return stencil, right


@compiled
def hold(fixed: Flags, value: float, stencil: Array, right: Array):
    """Replace the balance of fixed cells by u = value; in place.

    Parameters
    ----------
    fixed : ndarray of bool, shape (n_c, n_a)
    value : float
        Signed unknown of fixed cells.
    stencil, right : ndarray, shape (5, n_c, n_a), (n_c, n_a)
        From `assemble`.
    """
    for i in range(fixed.shape[0]):
        for j in range(fixed.shape[1]):
            if fixed[i, j]:
                for k in range(5):
                    stencil[k, i, j] = 0.0
                stencil[CENTRE, i, j] = 1.0
                right[i, j] = value


@compiled
def balance(
    pressure: Array,
    deficit: Array,
    faces: Faces,
    lift: FaceLift,
    storage: Storage,
    edges: Edges,
    open_cells: Flags,
    cells: Cells,
):
    """Return the residual of Eq. (E1), the content and the mass imbalance of the whole film.

    Residual and content are those of each cell at the end of the step.

    Parameters
    ----------
    pressure, deficit : ndarray, shape (n_c, n_a)
        Pressure above cavitation pressure [Pa], film fraction - 1 [-].
    faces : Faces
    lift : FaceLift
    storage : Storage
    edges : grid.Edges
    open_cells : ndarray of bool, shape (n_c, n_a)
        Cells without a film; what flows out of them counts as inflow over an edge.
    cells : grid.Cells

    Returns
    -------
    Balance
    """
    stored, content, area_per_step = storage
    fraction = 1.0 + deficit
    filling = Filling(pressure, fraction, lift)
    out, edge_flow, gross, axial, around = outflow(filling, faces, edges, cells.ring)
    now = np.empty_like(pressure)
    residual = np.empty_like(pressure)
    total = 0.0
    inflow = 0.0
    throughput = 0.0
    volume = 0.0
    for flow in edge_flow:
        inflow += flow
        throughput += abs(flow)
    for i in range(pressure.shape[0]):
        alike = images(cells.mirrored, i, pressure.shape[0])
        rate = alike * area_per_step
        for j in range(pressure.shape[1]):
            if open_cells[i, j]:
                now[i, j] = 0.0
                residual[i, j] = 0.0
                inflow += out[i, j]
                throughput += abs(out[i, j])
                continue
            now[i, j] = fraction[i, j] * stored[i, j]
            growth = rate * (stored[i, j] - content[i, j] + deficit[i, j] * stored[i, j])
            residual[i, j] = -out[i, j] - growth  # Eq. (E1)
            volume += alike * stored[i, j]
            total += growth
            throughput += abs(growth)
    # the floor is for films almost without flow, whose imbalance is round-off
    floor = max(LEAST_THROUGHPUT * gross, LEAST_THROUGHPUT * area_per_step * volume, 1e-300)
    imbalance = abs(inflow - total) / max(throughput, floor)
    return Balance(
        film_fraction=fraction,
        content=now,
        residual=residual,
        edge_flow=edge_flow,
        imbalance=imbalance,
        axial_flow=axial,
        flow_around=around,
    )
