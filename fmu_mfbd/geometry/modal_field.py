"""Modal displacement on a regular grid around a cylinder, and modal forces of forces on it.

A body that is its own mirror image about the thrust plane and across it has modes that are even or
odd about both. A quarter of the circumference and of the modes is then sufficient, and both
products cost a quarter. Angles on a plane of symmetry are their own images and count half. A body
without that symmetry has one class with the whole circumference.
"""

from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...master.fmi.compiled import compiled

EVEN = 0
ODD_Z = 1
ODD_X = 2
ODD_BOTH = 3
"""Symmetry classes: odd across z = 0, odd across x = 0, odd across both."""

SIGNS = np.array(
    [[1.0, 1.0, 1.0, 1.0], [1.0, -1.0, 1.0, -1.0], [1.0, 1.0, -1.0, -1.0], [1.0, -1.0, -1.0, 1.0]]
)
"""Sign of a class at theta, pi - theta, -theta, pi + theta; class 2 x + z, x and z 1 where odd
across x = 0, z = 0.
"""


class ModalField(NamedTuple):
    """Displacement component of k modes.

    The table contains groups of four modes of one symmetry class, filled up with zeros, so that one
    pass over the points serves four modes. Single precision halves the memory traffic, which
    determines the cost. Forces and displacements use the same rounded values (6e-8), so that work
    and sensitivities are exact.

    Parameters
    ----------
    table : ndarray of float32, shape (4 groups, rows * part)
        Values [kg^-1/2]; each row of the grid (a height) has `part` angles from theta = 0 on.
    mode : ndarray of int, shape (4 groups,)
        Number of the mode, -1 for none.
    kind : ndarray of int, shape (groups,)
        Symmetry class.
    modes, classes, part : int
        k, then 4 and a quarter of the angles with those on the planes of symmetry, or 1 and all
        angles.
    image : ndarray of int, shape (classes, part)
        Number of the angle at theta, pi - theta, -theta, pi + theta.
    share : ndarray, shape (part,)
        1, or 1/2 if two of these angles are equal [-].
    """

    table: Annotated[NDArray[np.float32], "fours, points"]
    mode: Annotated[NDArray[np.int64], "fours", "within(x, -1.0, modes)"]
    kind: Annotated[NDArray[np.int64], "groups", "within(x, 0.0, classes) and 4 * groups == fours"]
    modes: Annotated[int, "x >= 0"]
    classes: Annotated[int, "x == 1 or x == 4"]
    part: Annotated[int, "x > 0"]
    image: Annotated[NDArray[np.int64], "classes, part", "within(x, 0.0, points)"]
    share: Annotated[np.ndarray, "part"]


class FourCoordinates(NamedTuple):
    """Coordinates or velocities of the four modes of a group [kg^1/2 m], [kg^1/2 m/s]."""

    a: float
    b: float
    c: float
    d: float


def modal_field(values: np.ndarray, kind: np.ndarray | None = None) -> ModalField:
    """Return values (angles of `grid.cell_centres`, rows, k), sorted by symmetry classes.

    If kind is None, or the number of angles is odd, there is no symmetry.
    """
    angles, rows, k = values.shape
    if kind is None or angles % 2:
        kind = np.zeros(k, np.int64)
        classes = 1
        image = np.arange(angles)[None]
        share = np.ones(angles)
        part = values
    else:
        classes = 4
        image = mirrors(angles)
        on_thrust_line, on_pin_axis = image[0] == image[1:3]
        share = np.where(on_thrust_line | on_pin_axis, 0.5, 1.0)
        part = (values[image] * SIGNS[kind].T[:, None, None, :]).mean(axis=0)
    order, groups = _fours(kind, classes)
    lines = part.transpose(2, 1, 0).reshape(k, rows * len(part))
    lines = np.vstack([lines, np.zeros(rows * len(part))])
    return ModalField(
        table=lines[order].astype(np.float32),  # -1: the last line, of zeros
        mode=order.astype(np.int64),
        kind=groups.astype(np.int64),
        modes=k,
        classes=classes,
        part=len(part),
        image=image,
        share=share,
    )


def _fours(kind, classes):
    """Return the modes in the order of the table, -1 for none, and the class of each group."""
    order = []
    groups = []
    for number in range(classes):
        members = np.flatnonzero(kind == number)
        spare = -len(members) % 4
        order.append(np.append(members, np.full(spare, -1)))
        groups.append(np.full((len(members) + spare) // 4, number))
    return np.concatenate(order), np.concatenate(groups)


def mirrors(angles: int) -> np.ndarray:
    """Return the numbers of theta_i, pi - theta_i, -theta_i, pi + theta_i, (4, angles // 4 + 1).

    The angles are those up to the thrust line, and the number of all angles is even.
    """
    thrust = angles // 4
    i = np.arange(thrust + 1)
    across = 2 * thrust - i
    return np.stack([i, across, across + angles // 2, i + angles // 2]) % angles


@compiled
def is_field(field: ModalField, angles: int, rows: int, modes: int) -> bool:
    """Return whether a field has these angles, rows and modes."""
    own = field.part if field.classes == 1 else field.image.max() + 1
    points = field.table.shape[1]
    return own == angles and points == rows * field.part and field.modes == modes


@compiled
def read(field: ModalField, first: int, rows: int, coordinates: np.ndarray) -> np.ndarray:
    """Return the displacement on some rows of the grid.

    Eq. (H4):  u(theta, row) = sum_k value_k(theta, row) q_k

    Parameters
    ----------
    field : ModalField
    first, rows : int
        First row and number of rows.
    coordinates : ndarray, shape (k,)
        [kg^1/2 m]

    Returns
    -------
    ndarray, shape (rows, angles)
        [m]
    """
    start = first * field.part
    count = rows * field.part
    sums = np.zeros((field.classes, count))
    ordered = _in_table_order(field, coordinates)
    for g in range(len(field.kind)):
        a, b, c, d = _four(field, g, start, count)
        q = _four_coordinates(ordered, g)
        line = sums[field.kind[g]]
        for p in range(count):
            # Eq. (H4)
            line[p] += (q.a * a[p] + q.b * b[p]) + (q.c * c[p] + q.d * d[p])
    return _unfold(field, sums, rows)


@compiled
def read_both(
    field: ModalField, first: int, rows: int, position: np.ndarray, velocity: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return displacement and velocity, both as `read` does, in one pass over the table."""
    start = first * field.part
    count = rows * field.part
    sums = np.zeros((field.classes, count))
    fast_sums = np.zeros((field.classes, count))
    ordered = _in_table_order(field, position)
    fast_ordered = _in_table_order(field, velocity)
    for g in range(len(field.kind)):
        a, b, c, d = _four(field, g, start, count)
        q = _four_coordinates(ordered, g)
        v = _four_coordinates(fast_ordered, g)
        line = sums[field.kind[g]]
        fast = fast_sums[field.kind[g]]
        for p in range(count):
            # Eq. (H4)
            line[p] += (q.a * a[p] + q.b * b[p]) + (q.c * c[p] + q.d * d[p])
            fast[p] += (v.a * a[p] + v.b * b[p]) + (v.c * c[p] + v.d * d[p])
    return _unfold(field, sums, rows), _unfold(field, fast_sums, rows)


@compiled
def _four(field, group, start, count):
    """Return the values of the four modes of a group on some points."""
    k = 4 * group
    stop = start + count
    return (
        field.table[k, start:stop],
        field.table[k + 1, start:stop],
        field.table[k + 2, start:stop],
        field.table[k + 3, start:stop],
    )


@compiled
def _four_coordinates(ordered, group):
    """Return the coordinates of the four modes of a group."""
    k = 4 * group
    return FourCoordinates(ordered[k], ordered[k + 1], ordered[k + 2], ordered[k + 3])


@compiled
def _in_table_order(field, coordinates):
    """Return the modal coordinates in the order of the table."""
    out = np.zeros(len(field.mode))
    for s in range(len(out)):
        if field.mode[s] >= 0:
            out[s] = coordinates[field.mode[s]]
    return out


@compiled
def _unfold(field, sums, rows):
    """Return values at all angles, (rows, angles), from the sums of each symmetry class."""
    part = field.part
    image = field.image
    if field.classes == 1:
        return sums.reshape(rows, part)
    out = np.empty((rows, image.max() + 1))
    for r in range(rows):
        for i in range(part):
            p = r * part + i
            a = sums[EVEN, p]
            b = sums[ODD_Z, p]
            c = sums[ODD_X, p]
            d = sums[ODD_BOTH, p]
            out[r, image[0, i]] = (a + b) + (c + d)
            out[r, image[1, i]] = (a - b) + (c - d)
            out[r, image[2, i]] = (a + b) - (c + d)
            out[r, image[3, i]] = (a - b) - (c - d)
    return out


@compiled
def _fold(field, force):
    """Return the sums of each class from forces (rows, angles): the transpose of `_unfold`."""
    part = field.part
    image = field.image
    rows = len(force)
    sums = np.empty((field.classes, rows * part))
    for r in range(rows):
        for i in range(part):
            p = r * part + i
            if field.classes == 1:
                sums[EVEN, p] = force[r, i]
                continue
            a = field.share[i] * force[r, image[0, i]]
            b = field.share[i] * force[r, image[1, i]]
            c = field.share[i] * force[r, image[2, i]]
            d = field.share[i] * force[r, image[3, i]]
            sums[EVEN, p] = (a + b) + (c + d)
            sums[ODD_Z, p] = (a - b) + (c - d)
            sums[ODD_X, p] = (a + b) - (c + d)
            sums[ODD_BOTH, p] = (a - b) - (c - d)
    return sums


@compiled
def spread(field: ModalField, first: int, force: np.ndarray) -> np.ndarray:
    """Return the modal forces of forces at the points of some rows: the transpose of `read`.

    Parameters
    ----------
    field : ModalField
    first : int
        First row.
    force : ndarray, shape (rows, angles)
        [N]

    Returns
    -------
    ndarray, shape (k,)
        [kg^-1/2 N]
    """
    start = first * field.part
    count = len(force) * field.part
    sums = _fold(field, force)
    out = np.empty(field.modes)
    for g in range(len(field.kind)):
        a, b, c, d = _four(field, g, start, count)
        line = sums[field.kind[g]]
        on_a = 0.0
        on_b = 0.0
        on_c = 0.0
        on_d = 0.0
        for p in range(count):
            f = line[p]
            on_a += f * a[p]
            on_b += f * b[p]
            on_c += f * c[p]
            on_d += f * d[p]
        totals = (on_a, on_b, on_c, on_d)
        for s in range(4):
            if field.mode[4 * g + s] >= 0:
                out[field.mode[4 * g + s]] = totals[s]
    return out
