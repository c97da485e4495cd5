"""Modal displacement on a regular grid around a cylinder, and modal forces back, in the least arithmetic.

A body that is its own mirror image about the thrust plane and across it has modes that are even or odd about both. Then a
quarter of the circumference and a quarter of the modes at a time hold everything, and both products cost a quarter. A body
without that symmetry has one class, all of the circumference; the code is the same.
"""

from typing import NamedTuple

import numpy as np

from .compiled import compiled_sums

SIGNS = np.array([[1.0, 1.0, 1.0, 1.0], [1.0, -1.0, 1.0, -1.0], [1.0, 1.0, -1.0, -1.0], [1.0, -1.0, -1.0, 1.0]])
"""Sign of a class at theta, pi - theta, -theta, pi + theta; class 2 x + z, x and z 1 where odd across x = 0, z = 0."""


class ModalField(NamedTuple):
    """One displacement component of k modes.

    Parameters
    ----------
    table : ndarray, shape (k, rows * part)
        Values [kg^-1/2]; each row of the grid (a height) holds `part` angles from theta = 0 on.
    kind : ndarray of int, shape (k,)
        Symmetry class of each mode.
    classes, part : int
        4 and a quarter of the angles, or 1 and all of them.
    """

    table: np.ndarray
    kind: np.ndarray
    classes: int
    part: int


def modal_field(values, kind=None):
    """Pack values (angles, rows, k) by the modes' symmetry classes; kind None (or angles not divisible by 4): no symmetry."""
    angles, rows, k = values.shape
    if kind is None or angles % 4:
        return ModalField(np.ascontiguousarray(values.transpose(2, 1, 0), np.float32).reshape(k, rows * angles), np.zeros(k, np.int64), 1,
                          angles)
    quarter = (values[mirrors(angles)] * SIGNS[kind].T[:, None, None, :]).mean(axis=0)
    return ModalField(np.ascontiguousarray(quarter.transpose(2, 1, 0), np.float32).reshape(k, rows * angles // 4),
                      np.asarray(kind, np.int64), 4, angles // 4)


def mirrors(angles):
    """Indices of theta_i, pi - theta_i, -theta_i, pi + theta_i for the first quarter of the angles, shape (4, angles / 4)."""
    i = np.arange(angles // 4)
    return np.stack([i, angles // 2 - 1 - i, angles - 1 - i, angles // 2 + i])


@compiled_sums()
def read(field, first, rows, coordinates):
    """Displacement on some rows of the grid.

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
    start, count = first * field.part, rows * field.part
    sums = np.zeros((field.classes, count))
    for k in range(len(coordinates)):
        q, line, row = coordinates[k], sums[field.kind[k]], field.table[k, start:start + count]
        for p in range(count):
            line[p] += q * row[p]                                                                               # Eq. (H4)
    return _unfold(field, sums, rows)


@compiled_sums()
def read_both(field, first, rows, place, rate):
    """Displacement and its rate in one pass over the table, which is what a reading costs; both as `read` gives them."""
    start, count = first * field.part, rows * field.part
    sums, rates = np.zeros((field.classes, count)), np.zeros((field.classes, count))
    for k in range(len(place)):
        q, dq, row = place[k], rate[k], field.table[k, start:start + count]
        line, line_rate = sums[field.kind[k]], rates[field.kind[k]]
        for p in range(count):
            line[p] += q * row[p]                                                                               # Eq. (H4)
            line_rate[p] += dq * row[p]
    return _unfold(field, sums, rows), _unfold(field, rates, rows)


@compiled_sums()
def _unfold(field, sums, rows):
    """All angles (rows, angles) from the sums of each symmetry class."""
    part = field.part
    if field.classes == 1:
        return sums.reshape(rows, part)
    out = np.empty((rows, 4 * part))
    for r in range(rows):
        for i in range(part):
            a, b, c, d = sums[0, r * part + i], sums[1, r * part + i], sums[2, r * part + i], sums[3, r * part + i]
            out[r, i] = (a + b) + (c + d)
            out[r, 2 * part - 1 - i] = (a - b) + (c - d)
            out[r, 4 * part - 1 - i] = (a + b) - (c + d)
            out[r, 2 * part + i] = (a - b) - (c - d)
    return out


@compiled_sums()
def spread(field, first, force):
    """Modal forces of forces at the points of some rows: the transpose of `read`.

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
    part, rows = field.part, len(force)
    start, count = first * part, rows * part
    sums = np.empty((field.classes, count))
    for r in range(rows):
        for i in range(part):
            p = r * part + i
            if field.classes == 1:
                sums[0, p] = force[r, i]
                continue
            a, b, c, d = force[r, i], force[r, 2 * part - 1 - i], force[r, 4 * part - 1 - i], force[r, 2 * part + i]
            sums[0, p], sums[1, p] = (a + b) + (c + d), (a - b) + (c - d)
            sums[2, p], sums[3, p] = (a + b) - (c + d), (a - b) - (c - d)
    out = np.empty(len(field.kind))
    for k in range(len(out)):
        line, row, total = sums[field.kind[k]], field.table[k, start:start + count], 0.0
        for p in range(count):
            total += line[p] * row[p]
        out[k] = total
    return out
