"""A parallel journal in its shell: gap, force of the film, and the position that carries a load.

x points to the cell i = 0 and y to a quarter of a revolution further, from the axis of the shell:

Eq. (E14):  h = C - x cos a - y sin a
Eq. (E15):  F = sum of pressure force (-cos a, -sin a) + circumferential force (-sin a, cos a)
Eq. (E16):  F(x, y, q) + W = 0,   q_k = sum of p O_k - f T_k,   h opens by sum_k O_k q_k

a is the angle of a cell, a = 2 pi i / n, C the radial clearance and W the load on the journal. p
and f are the nodal forces of pressure and friction. O_k and T_k are a shape of an elastic shell
outward and around, for unit stiffness, with the coordinate q_k.

Newton's method solves Eq. (E16) with the exact tangent of the steady film, and damps the shells:

Eq. (E17):  (dR/dq - 4 r/r_max) dq = -R,   R_k = sum of p O_k - f T_k - q_k,   r = |R|

r_max is the largest r so far. This is a step of dq/dt = R whose length grows as R vanishes
[Kelley1998]. Without damping, soft shells can end in a balance that they do not reach from rest, or
in none.

References
----------
[Kelley1998] C. T. Kelley, D. E. Keyes, Convergence analysis of pseudo-transient continuation, SIAM
J. Numerical Analysis 35 (1998) 508.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np

from .balance.grid import Array
from .laws.cavitation import NotConverged

MOST_POSITIONS = 60
START = 0.5  # of the clearance, along the load
NEARER = 0.3  # of the thinnest film, by which an iteration may lower it
FARTHEST = 0.3  # of the clearance, largest displacement of an iteration
DAMPING = 4.0  # largest damping of the shells over their stiffness, Eq. (E17)


class ElasticShell(Protocol):
    """Modes of a shell, or of a journal, on the cells of its film.

    omega : ndarray, shape (k,), angular eigenfrequencies [rad/s]; outward, onward : ndarray, shape
    (n_c, n_a, k), displacement that opens the film, and around it [kg^-1/2].
    """

    @property
    def omega(self) -> Array: ...
    @property
    def outward(self) -> Array: ...
    @property
    def onward(self) -> Array: ...


class Shapes(NamedTuple):
    """Shapes in which the film thickness changes, and the forces against them.

    outward, onward : ndarray, shape (cells, m), O and T [m] per unit of the coordinate;
    load, stiffness : ndarray, shape (m,), external force, and force per unit of the coordinate.
    """

    outward: Array
    onward: Array
    load: Array
    stiffness: Array

    def thickness(self, coordinates: Array, shape: tuple[int, int]) -> Array:
        """Return the change of the film thickness, shape `shape` [m]."""
        return (self.outward @ coordinates).reshape(shape)

    def push(self, pressure: Array, circumferential: Array) -> Array:
        """Return the forces of a film on the shapes, shape (m,)."""
        return pressure.ravel() @ self.outward - circumferential.ravel() @ self.onward


class Carried(NamedTuple):
    """A journal under a load.

    position : ndarray, shape (2,), x, y [m];
    stiffness : ndarray, shape (2, 2), -dF/d(x, y) of the steady film and its shells [N/m];
    deflection : ndarray, shape (n_c, n_a), by which the shells open the film [m].
    """

    position: Array
    stiffness: Array
    deflection: Array


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


def shapes_of(
    shells: Sequence[ElasticShell], shape: tuple[int, int], load: Array | None = None
) -> Shapes:
    """Return the displacement of a journal under a load, then the modes of its shells.

    Parameters
    ----------
    shells : sequence of ElasticShell
    shape : tuple of int
        Cells around and along.
    load : ndarray, shape (2,), optional
        W [N]. If omitted, the journal does not move.

    Returns
    -------
    Shapes
    """
    around, along = shape
    cells = around * along
    x, y = np.repeat(outward(around), along, axis=1)
    still = np.zeros((cells, 0))
    first = (still, still) if load is None else (np.stack([-x, -y], 1), np.stack([y, -x], 1))
    opened = [(one.outward / one.omega).reshape(cells, -1) for one in shells]
    turned = [(one.onward / one.omega).reshape(cells, -1) for one in shells]
    sides = np.hstack([first[0], *opened]), np.hstack([first[-1], *turned])
    at_rest = np.zeros(0) if load is None else load
    elastic = np.ones(sides[0].shape[1] - len(at_rest))
    padded = np.concatenate([at_rest, 0.0 * elastic])
    return Shapes(*sides, padded, np.concatenate([0.0 * at_rest, elastic]))


def by_shapes(
    tangent: Callable[[Array], tuple[Array, ...]], shapes: Shapes, shape: tuple[int, int]
) -> Array:
    """Return the change of the forces on shapes by their coordinates, of the last step of a film.

    Parameters
    ----------
    tangent : callable
        Change of the nodal forces for a change of the film thickness, shape `shape` [m].
    shapes : Shapes
    shape : tuple of int
        Cells around and along.

    Returns
    -------
    ndarray, shape (m, m)
    """
    columns = []
    for outward_shape in shapes.outward.T:
        normal, _, circumferential = tangent(np.ascontiguousarray(outward_shape.reshape(shape)))
        columns.append(shapes.push(normal, circumferential))
    return np.transpose(columns) - np.diag(shapes.stiffness)


def stiffness(tangent: Callable[[Array], tuple[Array, ...]], shape: tuple[int, int]) -> Array:
    """Return -dF/d(x, y) of the last step of a film in a rigid shell, shape (2, 2) [N/m].

    `tangent` and `shape` are those of `by_shapes`.
    """
    return -by_shapes(tangent, shapes_of((), shape, np.zeros(2)), shape)


def carrying(
    steady: Callable[[Array], dict[str, Any]],
    tangent: Callable[[Array], tuple[Array, ...]],
    shapes: Shapes,
    clearance: Array,
    roughness_rms: float,
    tolerance: float,
) -> Carried:
    """Return the position of a journal and the deflection of its shells, Eq. (E16).

    Parameters
    ----------
    steady : callable
        Outputs of the steady film of a film thickness.
    tangent : callable
        As for `by_shapes`, of that film.
    shapes : Shapes
        As `shapes_of` returns them.
    clearance : ndarray, shape (n_c, n_a)
        C of each cell [m].
    roughness_rms : float
        Replaces a thinner film in the limit of an iteration [m], because contact lets surfaces
        overlap.
    tolerance : float
        Largest |F + W| over |W|, and of the shells the root of the energy out of balance over that
        of the load.

    Returns
    -------
    Carried

    Raises
    ------
    NotConverged
        If no position carries the load.
    """
    shape = clearance.shape
    size = np.hypot.reduce(shapes.load)
    free = shapes.stiffness == 0.0
    coordinates = START * clearance.min() * shapes.load / (size or 1.0)
    missing = shapes.load
    most = np.finfo(float).tiny
    for _ in range(MOST_POSITIONS):
        thickness = clearance + shapes.thickness(coordinates, shape)
        outputs = steady(thickness)
        forces = outputs["nodal_pressure_force"], outputs["nodal_circumferential_force"]
        push = shapes.push(*forces)
        missing = push + shapes.load - shapes.stiffness * coordinates
        by_shape = by_shapes(tangent, shapes, shape)
        bound = tolerance * np.where(free, size, np.linalg.norm(push[~free]))
        if all(
            np.linalg.norm(missing[one]) <= bound[one].max(initial=0.0) for one in (free, ~free)
        ):
            stiff = -by_shape[np.ix_(free, free)]
            if not free.all():
                coupled = by_shape[np.ix_(free, ~free)]
                yielding = np.linalg.solve(
                    by_shape[np.ix_(~free, ~free)], by_shape[np.ix_(~free, free)]
                )
                stiff = stiff + coupled @ yielding
            deflection = shapes.thickness(np.where(free, 0.0, coordinates), shape)
            return Carried(coordinates[free], stiff, deflection)
        unbalanced = float(np.linalg.norm(missing[~free]))
        most = max(most, unbalanced)
        damping = DAMPING * unbalanced / most * shapes.stiffness
        damped = by_shape - np.diag(damping)  # Eq. (E17)
        change = np.asarray(np.linalg.solve(damped, -missing), dtype=float)  # Eq. (E16)
        opened = shapes.thickness(change, shape)
        coordinates = coordinates + change * _part(
            thickness, opened, clearance.min(), roughness_rms
        )
    raise NotConverged(
        f"no position of the journal carries the load: forces {missing[free]} N remain at "
        f"{coordinates[free]} m"
    )


def _part(thickness: Array, opened: Array, clearance: float, roughness_rms: float) -> float:
    """Return the part of a change of the film thickness that an iteration may take, 0 to 1."""
    least = float(thickness.min())
    lowest = least - NEARER * max(least, roughness_rms)
    tiny = np.finfo(float).tiny
    far = FARTHEST * clearance / max(float(np.abs(opened).max()), tiny)
    shut = ((thickness - lowest) / np.maximum(-opened, tiny)).min()
    return min(1.0, far, float(shut))
