"""Flows through the faces of a film, Eq. (E2) of `reynolds`.

Arrays have the shape (n_c, n_a) of the grid; faces (n_c + 1, n_a) across i and (n_c, n_a + 1)
across j.
"""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compiled
from ..common.grid import (
    FIRST,
    LAST,
    LOWER,
    UPPER,
    Array,
    AxialFaces,
    Edges,
    FacesAround,
    Field,
    Flags,
)

FRACTION_ROUNDOFF = 1e-15  # film fraction below zero that is rounding


class Faces(NamedTuple):
    """Conductances K [m3/(Pa s)] and transports T [m3/s] of all faces, Eq. (E3).

    conductance_c, transport_c : ndarray, shape (n_c + 1, n_a), across i.
    conductance_a, transport_a : ndarray, shape (n_c, n_a + 1), across j.
    """

    conductance_c: Array
    transport_c: Array
    conductance_a: Array
    transport_a: Array


class FaceLift(NamedTuple):
    """Lift of the film fraction at the faces, l of Eq. (E2) [-].

    axial, around : ndarray, shapes (n_c, n_a + 1) and (n_c + 1, n_a)
        At the faces across j and across i. On a ring the last face across i is the first one.
    """

    axial: AxialFaces
    around: FacesAround


class Filling(NamedTuple):
    """Pressure and film fraction of a film, Eq. (E4).

    pressure, film_fraction : ndarray, shape (n_c, n_a)
        p above cavitation pressure [Pa], f [-].
    lift : FaceLift
    """

    pressure: Field
    film_fraction: Field
    lift: FaceLift


class Outflow(NamedTuple):
    """Flows of a film, Eq. (E2).

    cells : ndarray, shape (n_c, n_a)
        Sum of outward face flows of each cell [m3/s].
    edges : ndarray, shape (4,)
        Flow into the film over lower, upper, first, last edge [m3/s].
    gross : float
        Sum of the magnitudes of both terms of Eq. (E2) over the edges [m3/s].
    axial, around : ndarray, shapes (n_c, n_a + 1) and (n_c + 1, n_a)
        Flow through the faces across j and across i, positive with ascending j and i [m3/s].
    """

    cells: Array
    edges: Array
    gross: float
    axial: Array
    around: Array


@compiled
def no_lift(shape: tuple[int, int]):
    """Return the `FaceLift` of a grid of that shape without a lift."""
    n_c, n_a = shape
    return FaceLift(np.zeros((n_c, n_a + 1)), np.zeros((n_c + 1, n_a)))


@compiled
def give_up_lift(lift: FaceLift, unknown: Array, full: Flags):
    """Remove the lift from rows in which a cell would owe oil; return whether there was any.

    Film or velocity jumped there.
    """
    gives_up = False
    for i in range(unknown.shape[0]):
        for j in range(unknown.shape[1]):
            if full[i, j] or unknown[i, j] >= -1.0 - FRACTION_ROUNDOFF:
                continue
            for k in range(lift.axial.shape[1]):
                gives_up = gives_up or lift.axial[i, k] != 0.0
                lift.axial[i, k] = 0.0
            for k in range(lift.around.shape[0]):
                gives_up = gives_up or lift.around[k, j] != 0.0
                lift.around[k, j] = 0.0
    return gives_up


@compiled(forceinline=True)
def dragged(t, fraction, limit):
    """Return what sliding drags in over an edge, Eq. (E12); t : transport into the film."""
    return min(max(t, 0.0) * fraction, limit)  # Eq. (E12)


@compiled(forceinline=True)
def _flow(k, t, p_a, p_b, f_a, f_b):
    """Return the face flow, Eq. (E2)."""
    return k * (p_a - p_b) + max(t, 0.0) * f_a + min(t, 0.0) * f_b  # Eq. (E2)


@compiled(forceinline=True)
def _inflow(k, t, pressure, fraction, cell_pressure, cell_fraction, limit):
    """Return the flow over an edge into a cell, Eqs. (E2), (E12); t transport into the film."""
    drawn = k * (pressure - cell_pressure)
    return drawn + dragged(t, fraction, limit) + min(t, 0.0) * cell_fraction


@compiled(forceinline=True)
def _inflow_axial(filling, faces, edges, i, edge):
    """Return the flow into row i over the lower or the upper edge [m3/s]."""
    n_a = filling.pressure.shape[1]
    j = 0 if edge == LOWER else n_a - 1
    face = 0 if edge == LOWER else n_a
    t = faces.transport_a[i, face]
    return _inflow(
        faces.conductance_a[i, face],
        t if edge == LOWER else -t,
        edges.pressure[edge],
        edges.film_fraction[edge],
        filling.pressure[i, j],
        filling.film_fraction[i, j] + filling.lift.axial[i, face],
        edges.limit[i, face],
    )


@compiled
def outflow(filling: Filling, faces: Faces, edges: Edges, ring: bool):
    """Return the flows out of the cells and over the edges, Eq. (E2).

    Parameters
    ----------
    filling : Filling
    faces : Faces
    edges : grid.Edges
    ring : bool

    Returns
    -------
    Outflow
    """
    p = filling.pressure
    k_c, t_c, k_a, t_a = faces
    n_c, n_a = p.shape
    out = np.zeros((n_c, n_a))
    inflow = np.zeros(4)
    gross = 0.0
    last = n_a - 1
    axial = axial_flow(filling, faces, edges)
    for i in range(n_c):
        for j in range(n_a):
            out[i, j] -= axial[i, j]
            out[i, j] += axial[i, j + 1]
        inflow[LOWER] += axial[i, 0]
        inflow[UPPER] -= axial[i, n_a]
        gross += k_a[i, 0] * (p[i, 0] + edges.pressure[LOWER]) + abs(t_a[i, 0])
        gross += k_a[i, n_a] * (p[i, last] + edges.pressure[UPPER]) + abs(t_a[i, n_a])
    last = n_c - 1
    around = flow_around(filling, faces, edges, ring)
    for i in range(1, n_c):
        for j in range(n_a):
            out[i - 1, j] += around[i, j]
            out[i, j] -= around[i, j]
    for j in range(n_a):
        out[0, j] -= around[0, j]
        out[last, j] += around[n_c, j]
        if not ring:
            inflow[FIRST] += around[0, j]
            inflow[LAST] -= around[n_c, j]
            gross += k_c[0, j] * (p[0, j] + edges.pressure[FIRST]) + abs(t_c[0, j])
            gross += k_c[n_c, j] * (p[last, j] + edges.pressure[LAST]) + abs(t_c[n_c, j])
    return Outflow(out, inflow, gross, axial, around)


@compiled
def axial_flow(filling: Filling, faces: Faces, edges: Edges):
    """Return the flow through all axial faces, Eq. (E2), positive with ascending j.

    Parameters
    ----------
    filling : Filling
    faces : Faces
    edges : grid.Edges

    Returns
    -------
    ndarray, shape (n_c, n_a + 1)
        [m3/s].
    """
    p, f, lift = filling
    k, t = faces.conductance_a, faces.transport_a
    n_c, n_a = p.shape
    flow = np.empty((n_c, n_a + 1))
    for i in range(n_c):
        flow[i, 0] = _inflow_axial(filling, faces, edges, i, LOWER)
        flow[i, n_a] = -_inflow_axial(filling, faces, edges, i, UPPER)
        for j in range(1, n_a):
            flow[i, j] = _flow(k[i, j], t[i, j], p[i, j - 1], p[i, j], f[i, j - 1], f[i, j])
            flow[i, j] += t[i, j] * lift.axial[i, j]
    return flow


@compiled
def flow_around(filling: Filling, faces: Faces, edges: Edges, ring: bool):
    """Return the flow through all faces across i, Eq. (E2), positive with ascending i.

    Parameters
    ----------
    filling : Filling
    faces : Faces
    edges : grid.Edges
    ring : bool

    Returns
    -------
    ndarray, shape (n_c + 1, n_a)
        [m3/s].
    """
    p, f, lift = filling
    k, t = faces.conductance_c, faces.transport_c
    n_c, n_a = p.shape
    last = n_c - 1
    flow = np.empty((n_c + 1, n_a))
    for i in range(1, n_c):
        for j in range(n_a):
            flow[i, j] = _flow(k[i, j], t[i, j], p[i - 1, j], p[i, j], f[i - 1, j], f[i, j])
            flow[i, j] += t[i, j] * lift.around[i, j]
    for j in range(n_a):
        if ring:
            q = _flow(k[0, j], t[0, j], p[last, j], p[0, j], f[last, j], f[0, j])
            flow[0, j] = flow[n_c, j] = q + t[0, j] * lift.around[0, j]
            continue
        leaving = f[0, j] + lift.around[0, j]
        flow[0, j] = _flow(
            k[0, j], t[0, j], edges.pressure[FIRST], p[0, j], edges.film_fraction[FIRST], leaving
        )
        leaving = f[last, j] + lift.around[n_c, j]
        flow[n_c, j] = _flow(
            k[n_c, j],
            t[n_c, j],
            p[last, j],
            edges.pressure[LAST],
            leaving,
            edges.film_fraction[LAST],
        )
    return flow
