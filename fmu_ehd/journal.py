"""A parallel journal in its shell: gap, force of the film, and the position that carries a load.

x points to the cell i = 0 and y to a quarter of a revolution further, from the axis of the shell:

Eq. (E14):  h = C - x cos a - y sin a
Eq. (E15):  F = sum of pressure force (-cos a, -sin a) + circumferential force (-sin a, cos a)
Eq. (E16):  F(x, y) + W = 0,   by Newton's method on the exact dF/d(x, y) of the steady film

a is the angle of a cell, a = 2 pi i / n, C the radial clearance and W the load on the journal.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from .balance.grid import Array
from .laws.cavitation import NotConverged

MOST_POSITIONS = 60
START = 0.5  # of the clearance, along the load
NEARER = 0.3  # of the thinnest film, by which an iteration may lower it
FARTHEST = 0.3  # of the clearance, largest displacement of an iteration


class Carried(NamedTuple):
    """A journal under a load.

    position : ndarray, shape (2,), x, y [m];
    stiffness : ndarray, shape (2, 2), -dF/d(x, y) of the steady film [N/m].
    """

    position: Array
    stiffness: Array


def outward(n: int) -> Array:
    """Return the directions of n cells from the axis of the shell, shape (2, n)."""
    angle = 2.0 * np.pi / n * np.arange(n)
    return np.array([np.cos(angle), np.sin(angle)])


def gap(clearance: Array | float, position: Array, shape: tuple[int, int]) -> Array:
    """Return the film thickness at a position of the journal, Eq. (E14).

    Parameters
    ----------
    clearance : float or ndarray, shape `shape`
        C [m].
    position : ndarray, shape (2,)
        x, y [m].
    shape : tuple of int
        Cells around and along.

    Returns
    -------
    ndarray, shape `shape`
        h [m].
    """
    around, _ = shape
    nearer = (position @ outward(around))[:, None]
    return np.ascontiguousarray(np.broadcast_to(clearance - nearer, shape))  # Eq. (E14)


def film_force(pressure: Array, circumferential: Array | None = None) -> Array:
    """Return the force of the film on the journal, Eq. (E15).

    Parameters
    ----------
    pressure, circumferential : ndarray, shape (n_c, n_a)
        Nodal forces of a bearing [N]. If `circumferential` is omitted, the force of the pressure.

    Returns
    -------
    ndarray, shape (2,)
        F [N].
    """
    x, y = radial = outward(len(pressure))
    force = -radial @ pressure.sum(axis=1)
    if circumferential is not None:
        force += np.array([-y, x]) @ circumferential.sum(axis=1)  # Eq. (E15)
    return force


def stiffness(tangent: Callable[[Array], tuple[Array, ...]], shape: tuple[int, int]) -> Array:
    """Return -dF/d(x, y) of the last step of a film.

    Parameters
    ----------
    tangent : callable
        Change of the nodal forces for a change of the film thickness, shape `shape` [m].
    shape : tuple of int
        Cells around and along.

    Returns
    -------
    ndarray, shape (2, 2)
        [N/m].
    """
    columns = []
    for unit in np.eye(2):
        normal, _, circumferential = tangent(gap(0.0, unit, shape))
        columns.append(-film_force(normal, circumferential))
    return np.ascontiguousarray(np.transpose(columns))


def carrying(
    steady: Callable[[Array], dict[str, Any]],
    tangent: Callable[[Array], tuple[Array, ...]],
    load: Array,
    clearance: Array,
    roughness_rms: float,
    tolerance: float,
) -> Carried:
    """Return the position of a journal under a load, Eq. (E16), and its stiffness.

    Parameters
    ----------
    steady : callable
        Outputs of the steady film of a film thickness.
    tangent : callable
        As for `stiffness`, of that film.
    load : ndarray, shape (2,)
        W [N].
    clearance : ndarray, shape (n_c, n_a)
        C of each cell [m].
    roughness_rms : float
        Replaces a thinner film in the limit of an iteration [m], because contact lets surfaces
        overlap.
    tolerance : float
        Largest |F + W| over |W|.

    Returns
    -------
    Carried

    Raises
    ------
    NotConverged
        If no position carries the load.
    """
    size = np.hypot(*load)
    position = START * clearance.min() * load / size
    missing = load
    for _ in range(MOST_POSITIONS):
        thickness = gap(clearance, position, clearance.shape)
        outputs = steady(thickness)
        forces = outputs["nodal_pressure_force"], outputs["nodal_circumferential_force"]
        missing = film_force(*forces) + load
        by_position = stiffness(tangent, clearance.shape)
        if np.hypot(*missing) <= tolerance * size:
            return Carried(position, by_position)
        change = np.asarray(np.linalg.solve(by_position, missing), dtype=float)  # Eq. (E16)
        position = position + change * _part(thickness, change, clearance.min(), roughness_rms)
    raise NotConverged(
        f"no position of the journal carries the load: forces {missing} N remain at {position} m"
    )


def _part(thickness: Array, change: Array, clearance: float, roughness_rms: float) -> float:
    """Return the part of a displacement that an iteration may take, 0 to 1."""
    least = float(thickness.min())
    lowest = least - NEARER * max(least, roughness_rms)
    around, _ = thickness.shape
    nearer = (change @ outward(around))[:, None]
    far = FARTHEST * clearance / float(np.hypot(*change))
    shut = ((thickness - lowest) / np.maximum(nearer, np.finfo(float).tiny)).min()
    return min(1.0, far, float(shut))
