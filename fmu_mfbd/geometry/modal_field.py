"""Modal displacement on a regular grid around a cylinder, and modal forces of forces on it.

A body that is its own mirror image about the thrust plane and across it has modes that are even or
odd about both. A quarter of the circumference and of the modes is then sufficient, and both
products cost a quarter. Angles on a plane of symmetry are their own images and count half. A body
without that symmetry has one class with the whole circumference.

Half of a field from the thrust line to the anti-thrust line has the classes that are even about
that plane. Odd modes have no part in it.
"""

from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...master.fmi.compiled import compiled
from ...master.fmi.symmetry import half_grid, odd_part

EVEN = 0
ODD_Z = 1
ODD_X = 2
ODD_BOTH = 3
"""Symmetry classes: odd across z = 0, odd across x = 0, odd across both."""
ODD_X_OF_HALF = 1
"""Class of half a field, whose other class is EVEN."""

LANES = 16
"""Partial sums of a modal force. A processor computes them at the same time."""

SIGNS = np.array(
    [[1.0, 1.0, 1.0, 1.0], [1.0, -1.0, 1.0, -1.0], [1.0, 1.0, -1.0, -1.0], [1.0, -1.0, -1.0, 1.0]]
)
"""Sign of a class at theta, pi - theta, -theta, pi + theta; class 2 x + z, x and z 1 where odd
across x = 0, z = 0.
"""


class ModalField(NamedTuple):
    """Displacement component of k modes.

    Single precision halves the memory traffic, which determines the cost. Forces and displacements
    use the same rounded values (6e-8), so that work and sensitivities are exact.

    Parameters
    ----------
    table : ndarray of float32, shape (k, rows * part)
        Values [kg^-1/2]; each row of the grid (a height) has `part` angles from theta = 0 on.
    kind : ndarray of int, shape (k,)
        Symmetry class. Modes with a class that the field does not have are 0 in it.
    classes, part : int
        4, or 2 of half a field, and a quarter of the angles with those on the planes of symmetry;
        or 1 and all angles.
    image : ndarray of int, shape (classes, part)
        Number of the angle at theta, pi - theta, -theta, pi + theta; of half a field at
        pi - theta, pi + theta.
    share : ndarray, shape (part,)
        1, or 1/2 if two of these angles are equal [-].
    """

    table: Annotated[NDArray[np.float32], "k, points"]
    kind: Annotated[NDArray[np.int64], "k"]
    classes: int
    part: int
    image: Annotated[NDArray[np.int64], "classes, part"]
    share: Annotated[np.ndarray, "part"]


def modal_field(values: np.ndarray, kind: np.ndarray | None = None) -> ModalField:
    """Return values (angles of `grid.cell_centres`, rows, k), sorted by symmetry classes.

    If kind is None, the number of angles is odd, or there are no modes, there is no symmetry.
    """
    angles, rows, k = values.shape
    if kind is None or angles % 2 or k == 0:
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
    lines = part.transpose(2, 1, 0).reshape(k, rows * len(part))
    return ModalField(
        table=lines.astype(np.float32),
        kind=np.asarray(kind, dtype=np.int64),
        classes=classes,
        part=len(part),
        image=image,
        share=share,
    )


def half_field(field: ModalField, angles: int) -> ModalField:
    """Return half of a field with an even number of angles, the even part about the thrust plane.

    Its angles are those of `half_grid`.
    """
    first, last, _ = half_grid(angles)
    k, points = field.table.shape
    if field.classes == 4:
        image = field.image[[1, 3]] - first
        share = np.where(image[0] == image[1], 0.5, 1.0)
        kind = np.array([EVEN, 2, ODD_X_OF_HALF, 3])[field.kind]
        return field._replace(kind=kind, classes=2, image=image, share=share)
    values = field.table.astype(float).reshape(k, points // angles, angles)
    even = (values - odd_part(values, 2))[:, :, first:last]
    return ModalField(
        table=even.reshape(k, points // angles * (last - first)).astype(np.float32),
        kind=field.kind,
        classes=1,
        part=last - first,
        image=np.arange(last - first)[None],
        share=np.ones(last - first),
    )


def mirrors(angles: int) -> np.ndarray:
    """Return the numbers of theta_i, pi - theta_i, -theta_i, pi + theta_i, (4, angles // 4 + 1).

    The angles are those up to the thrust line, and the number of all angles is even.
    """
    thrust = angles // 4
    i = np.arange(thrust + 1)
    across = 2 * thrust - i
    return np.stack([i, across, across + angles // 2, i + angles // 2]) % angles


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
    for k in range(len(field.table)):
        if field.kind[k] >= field.classes or coordinates[k] == 0.0:
            continue
        values = field.table[k, start : start + count]
        line = sums[field.kind[k]]
        for p in range(count):
            line[p] += coordinates[k] * values[p]  # Eq. (H4)
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
    for k in range(len(field.table)):
        if field.kind[k] >= field.classes:
            continue
        values = field.table[k, start : start + count]
        line = sums[field.kind[k]]
        fast = fast_sums[field.kind[k]]
        for p in range(count):
            # Eq. (H4)
            line[p] += position[k] * values[p]
            fast[p] += velocity[k] * values[p]
    return _unfold(field, sums, rows), _unfold(field, fast_sums, rows)


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
            if field.classes == 2:
                c = sums[ODD_X_OF_HALF, p]
                out[r, image[0, i]] = a + c
                out[r, image[1, i]] = a - c
                continue
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
            if field.classes == 2:
                sums[EVEN, p] = a + b
                sums[ODD_X_OF_HALF, p] = a - b
                continue
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

    Each is the sum of `LANES` partial sums, every one over each `LANES`-th point.

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
    out = np.zeros(len(field.table))
    if len(out) == 0:
        return out
    start = first * field.part
    count = len(force) * field.part
    sums = _fold(field, force)
    partial = np.empty(LANES)
    whole = count - count % LANES
    for k in range(len(out)):
        if field.kind[k] >= field.classes:
            continue
        values = field.table[k, start : start + count]
        line = sums[field.kind[k]]
        for i in range(LANES):
            partial[i] = 0.0
        for p in range(0, whole, LANES):
            for i in range(LANES):
                partial[i] += line[p + i] * values[p + i]
        for i in range(count - whole):
            partial[i] += line[whole + i] * values[whole + i]
        for i in range(LANES):
            out[k] += partial[i]
    return out
