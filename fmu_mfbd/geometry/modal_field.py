"""Modal displacement on a regular grid around a cylinder, and modal forces back, in the least
arithmetic.

A body that is its own mirror image about the thrust plane and across it has modes that are even or
odd about both. Then a quarter of the circumference and a quarter of the modes at a time hold
everything, and both products cost a quarter. A body without that symmetry has one class, all of the
circumference; the code is the same.
"""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compiled

SIGNS = np.array(
    [[1.0, 1.0, 1.0, 1.0], [1.0, -1.0, 1.0, -1.0], [1.0, 1.0, -1.0, -1.0], [1.0, -1.0, -1.0, 1.0]]
)
"""Sign of a class at theta, pi - theta, -theta, pi + theta; class 2 x + z, x and z 1 where odd
across x = 0, z = 0.
"""


class ModalField(NamedTuple):
    """One displacement component of k modes.

    Modes of one symmetry class stand together, four at a time: a pass over the points then serves
    four of them. Places left over hold zeros. Single precision halves what has to be fetched, and
    that is what a product costs; forces and displacements use the same rounded values (6e-8 of
    them), so that work and sensitivities stay exact.

    Parameters
    ----------
    table : ndarray of float32, shape (4 groups, rows * part)
        Values [kg^-1/2]; each row of the grid (a height) holds `part` angles from theta = 0 on.
    mode : ndarray of int, shape (4 groups,)
        Number of the mode; -1: none.
    kind : ndarray of int, shape (groups,)
        Symmetry class.
    modes, classes, part : int
        k; 4 and a quarter of the angles, or 1 and all of them.
    """

    table: np.ndarray
    mode: np.ndarray
    kind: np.ndarray
    modes: int
    classes: int
    part: int


def modal_field(values, kind=None):
    """Pack values (angles, rows, k) by the modes' symmetry classes; kind None (or angles not
    divisible by 4): no symmetry.
    """
    angles, rows, k = values.shape
    if kind is None or angles % 4:
        kind, classes, part = np.zeros(k, np.int64), 1, values
    else:
        classes, part = 4, (values[mirrors(angles)] * SIGNS[kind].T[:, None, None, :]).mean(axis=0)
    lines = part.transpose(2, 1, 0).reshape(k, rows * len(part))
    mode = [np.flatnonzero(kind == number) for number in range(classes)]
    groups = np.repeat(np.arange(classes), [-(-len(m) // 4) for m in mode])
    mode = np.concatenate([np.append(m, np.full(-len(m) % 4, -1)) for m in mode])
    table = np.vstack([lines, np.zeros(rows * len(part))])[mode]  # -1: the last line, of zeros
    return ModalField(
        table.astype(np.float32),
        mode.astype(np.int64),
        groups.astype(np.int64),
        k,
        classes,
        len(part),
    )


def mirrors(angles):
    """Indices of theta_i, pi - theta_i, -theta_i, pi + theta_i for the first quarter of the angles,
    shape (4, angles / 4).
    """
    i = np.arange(angles // 4)
    return np.stack([i, angles // 2 - 1 - i, angles - 1 - i, angles // 2 + i])


@compiled
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
    sums, q = np.zeros((field.classes, count)), _places(field, coordinates)
    for g in range(len(field.kind)):
        a, b, c, d = _four(field, g, start, count)
        line, qa, qb, qc, qd = (
            sums[field.kind[g]],
            q[4 * g],
            q[4 * g + 1],
            q[4 * g + 2],
            q[4 * g + 3],
        )
        for p in range(count):
            line[p] += (qa * a[p] + qb * b[p]) + (qc * c[p] + qd * d[p])  # Eq. (H4)
    return _unfold(field, sums, rows)


@compiled
def read_both(field, first, rows, place, rate):
    """Displacement and its rate in one pass over the table, which is what a reading costs; both as
    `read` gives them.
    """
    start, count = first * field.part, rows * field.part
    sums, rates = np.zeros((field.classes, count)), np.zeros((field.classes, count))
    q, r = _places(field, place), _places(field, rate)
    for g in range(len(field.kind)):
        a, b, c, d = _four(field, g, start, count)
        line, qa, qb, qc, qd = (
            sums[field.kind[g]],
            q[4 * g],
            q[4 * g + 1],
            q[4 * g + 2],
            q[4 * g + 3],
        )
        fast, ra, rb, rc, rd = (
            rates[field.kind[g]],
            r[4 * g],
            r[4 * g + 1],
            r[4 * g + 2],
            r[4 * g + 3],
        )
        for p in range(count):
            line[p] += (qa * a[p] + qb * b[p]) + (qc * c[p] + qd * d[p])  # Eq. (H4)
            fast[p] += (ra * a[p] + rb * b[p]) + (rc * c[p] + rd * d[p])
    return _unfold(field, sums, rows), _unfold(field, rates, rows)


@compiled
def _four(field, group, start, count):
    """Values of the four modes of a group on some points."""
    table, k, stop = field.table, 4 * group, start + count
    return (
        table[k, start:stop],
        table[k + 1, start:stop],
        table[k + 2, start:stop],
        table[k + 3, start:stop],
    )


@compiled
def _places(field, coordinates):
    """Modal coordinates in the order of the table."""
    out = np.zeros(len(field.mode))
    for s in range(len(out)):
        if field.mode[s] >= 0:
            out[s] = coordinates[field.mode[s]]
    return out


@compiled
def _unfold(field, sums, rows):
    """All angles (rows, angles) from the sums of each symmetry class."""
    part = field.part
    if field.classes == 1:
        return sums.reshape(rows, part)
    out = np.empty((rows, 4 * part))
    for r in range(rows):
        for i in range(part):
            a, b, c, d = (
                sums[0, r * part + i],
                sums[1, r * part + i],
                sums[2, r * part + i],
                sums[3, r * part + i],
            )
            out[r, i] = (a + b) + (c + d)
            out[r, 2 * part - 1 - i] = (a - b) + (c - d)
            out[r, 4 * part - 1 - i] = (a + b) - (c + d)
            out[r, 2 * part + i] = (a - b) - (c - d)
    return out


@compiled
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
            a, b, c, d = (
                force[r, i],
                force[r, 2 * part - 1 - i],
                force[r, 4 * part - 1 - i],
                force[r, 2 * part + i],
            )
            sums[0, p], sums[1, p] = (a + b) + (c + d), (a - b) + (c - d)
            sums[2, p], sums[3, p] = (a + b) - (c + d), (a - b) - (c - d)
    out = np.empty(field.modes)
    for g in range(len(field.kind)):
        a, b, c, d = _four(field, g, start, count)
        line, ta, tb, tc, td = sums[field.kind[g]], 0.0, 0.0, 0.0, 0.0
        for p in range(count):
            f = line[p]
            ta += f * a[p]
            tb += f * b[p]
            tc += f * c[p]
            td += f * d[p]
        for s, total in enumerate((ta, tb, tc, td)):
            if field.mode[4 * g + s] >= 0:
                out[field.mode[4 * g + s]] = total
    return out
