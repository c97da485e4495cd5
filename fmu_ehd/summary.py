"""Scalars of a whole film in one pass over its cells."""

from typing import Annotated, NamedTuple

import numpy as np

from ..master.fmi.compiled import compiled
from .common.grid import Array, Cells, images
from .laws.friction import ShearForces


class Halves(NamedTuple):
    """Shares of the circumferential cells in the thrust half (+x; i runs from +z towards +x).

    share : ndarray, shape (n_c,), of the cell that lies on the thrust side [-];
    sine : ndarray, shape (n_c,), of the cell's angle from the pin axis [-].
    """

    share: Annotated[Array, "n_c"]
    sine: Annotated[Array, "n_c"]


class HalfValues(NamedTuple):
    """One number for each half of the skirt."""

    thrust: float
    anti_thrust: float


class Summary(NamedTuple):
    """Extremes and sums of a film.

    thinnest : HalfValues, minimum film thickness [m]; highest : maximum pressure [Pa];
    radial : HalfValues, force across the thrust plane, >= 0 pushes apart [N];
    friction : HalfValues, axial force on the skirt [N];
    hydrodynamic, asperity : axial force by its cause [N]; power : friction power [W];
    contact_area : mean of the contact area fraction [-].
    """

    thinnest: HalfValues
    highest: float
    radial: HalfValues
    friction: HalfValues
    hydrodynamic: float
    asperity: float
    power: float
    contact_area: float


def halves(n_circumferential: int) -> Halves:
    """Return the halves of a ring of cells, one of which has its centre on the thrust line.

    Eq. (F4):  theta_i = pi/2 + (i - floor(n/4)) 2 pi/n,   i = 0 .. n - 1, from the pin axis
    """
    cell = 2.0 * np.pi / n_circumferential
    from_thrust = (np.arange(n_circumferential) - n_circumferential // 4) * cell  # Eq. (F4)
    distance = np.abs(np.remainder(from_thrust + np.pi, 2.0 * np.pi) - np.pi)
    share = np.clip(0.5 + (0.5 * np.pi - distance) / cell, 0.0, 1.0)
    return Halves(np.round(share, 12), np.cos(from_thrust))  # a cell that ends on the axis is whole


@compiled
def summarise(
    film_thickness: Array,
    velocity: Array,
    pressure: Array,
    pressure_force: Array,
    forces: ShearForces,
    contact_area: Array,
    halves: Halves,
    cells: Cells,
):
    """Return the extremes and sums of a film.

    Parameters
    ----------
    film_thickness, velocity, pressure, pressure_force, contact_area : ndarray, shape (n_c, n_a)
        h [m], inf in cells without a film, which do not count; V [m/s], [Pa], [N], [-]. Forces are
        those of a cell and its images.
    forces : friction.ShearForces
    halves : Halves
    cells : grid.Cells

    Returns
    -------
    Summary
    """
    viscous, boundary = forces
    share, sine = halves
    n_c, n_a = film_thickness.shape
    thinnest = np.full(2, np.inf)
    radial = np.zeros(2)
    friction = np.zeros(2)
    highest = -np.inf
    hydrodynamic = 0.0
    asperity = 0.0
    power = 0.0
    area = 0.0
    count = 0.0
    for i in range(n_c):
        low = np.inf
        normal = 0.0
        wet = 0.0
        dry = 0.0
        alike = images(cells.mirrored, i, n_c)
        for j in range(n_a):
            if film_thickness[i, j] == np.inf:
                continue
            count += alike
            low = min(low, film_thickness[i, j])
            highest = max(highest, pressure[i, j])
            normal += pressure_force[i, j]
            wet += viscous[i, j]
            dry += boundary[i, j]
            # Eq. (F3)
            power -= (viscous[i, j] + boundary[i, j]) * velocity[i, j]
            area += alike * contact_area[i, j]
        hydrodynamic += wet
        asperity += dry
        for side in range(2):
            part = share[i] if side == 0 else 1.0 - share[i]
            if part > 0.0:
                thinnest[side] = min(thinnest[side], low)
            radial[side] += part * abs(sine[i]) * normal
            friction[side] += part * (wet + dry)
    return Summary(
        thinnest=HalfValues(thinnest[0], thinnest[1]),
        highest=highest,
        radial=HalfValues(radial[0], radial[1]),
        friction=HalfValues(friction[0], friction[1]),
        hydrodynamic=hydrodynamic,
        asperity=asperity,
        power=power,
        contact_area=area / max(count, 1.0),
    )
