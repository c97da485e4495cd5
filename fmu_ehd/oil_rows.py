"""Rows of cells along which sliding carries the oil, for `balance.transport`.

Those of a skirt lie along its axis, and those of a bearing around it.
"""

from typing import NamedTuple

import numpy as np

from ..master.fmi.compiled import compiled
from .balance import transport
from .balance.film_step import Domain
from .balance.transport import CellStates, Lift, StepRatios
from .common.grid import (
    FIRST,
    LAST,
    LOWER,
    OPENINGS,
    UPPER,
    Array,
    Cells,
    Edges,
    Flags,
    images,
    in_plenty,
    keep,
)
from .common.quantities import CARRIERS, CONDUCTIVITY, CONDUCTIVITY_C, STORED, TRANSPORT
from .step_parts import PreviousFilm


class PastRows(NamedTuple):
    """Past of a film along the rows of `balance.transport`, as in `PreviousFilm`."""

    unknown: Array
    content: Array
    growth: Array
    film: Array
    film_before: Array
    passed: Array
    travel: Array
    open_cells: Flags
    step: float


@compiled
def carriers(film: Array, bearing: bool):
    """Return the quantities of `films` that `transport` needs, shape (3, n_c, n_a)."""
    if not bearing:
        return film[:CARRIERS]
    carrying = film[:CARRIERS].copy()
    keep(carrying[CONDUCTIVITY], film[CONDUCTIVITY_C])
    return carrying


@compiled
def _rows(field: np.ndarray, order: np.ndarray):
    """Return cells, shape (n_c, n_a), or faces across i, as rows along i, (n_a, length).

    order : ndarray of int, shape (length,), i of each cell or face of a row.
    """
    rows = np.empty((field.shape[1], order.size), field.dtype)
    for k in range(order.size):
        for j in range(field.shape[1]):
            rows[j, k] = field[order[k], j]
    return rows


@compiled
def _rows_of_each(fields: Array, order: np.ndarray):
    """Return `_rows` of fields of shape (m, n_c, n_a)."""
    m, _, n_a = fields.shape
    rows = np.empty((m, n_a, order.size))
    for q in range(m):
        keep(rows[q], _rows(fields[q], order))
    return rows


@compiled
def _overlap(before: PreviousFilm, ratio: float, cells: Cells):
    """Return the cells by which the rows of a ring overlap at both ends, so its lift has no seam.

    An explicit step looks four cells upstream. The film that is expected may need one step more
    than the last one.
    """
    n_c, n_a = before.unknown.shape
    farthest = 0.0
    for i in range(n_c + 1):
        for j in range(n_a):
            faster = 0.0
            for k in ((i - 1) % n_c, i % n_c):
                here = before.film[TRANSPORT, k, j] / before.film[STORED, k, j]
                faster = max(faster, here)
            farthest = max(farthest, abs(before.travel[i, j]) * ratio / cells.dx * faster)
    steps = np.ceil(min(farthest, transport.FARTHEST) / transport.LARGEST_COURANT) + 1.0
    return 4 * int(steps) + 2


@compiled
def lift(before: PreviousFilm, pace: StepRatios, edges: Edges, step: float, domain: Domain):
    """Return the lift of the film fraction, `transport.lift`, from the past alone."""
    cells = domain.cells
    if not domain.bearing:
        rows = PastRows(
            unknown=before.unknown,
            content=before.content,
            growth=before.growth,
            film=before.film,
            film_before=before.film_before,
            passed=before.passed,
            travel=before.travel,
            open_cells=domain.open_cells,
            step=before.step,
        )
        return _lift_of_rows(rows, pace, edges, step, cells, True)
    n_c, n_a = before.unknown.shape
    travel = before.travel * pace.ratio
    margin = _overlap(before, pace.ratio, cells) if cells.ring else 0
    faces = np.empty(n_c + 2 * margin + 1, np.int64)
    for k in range(faces.size):
        faces[k] = (k - margin) % n_c if cells.ring else k
    order = faces[:-1]
    rows = PastRows(
        unknown=_rows(before.unknown, order),
        content=_rows(before.content, order),
        growth=_rows(before.growth, order),
        film=_rows_of_each(before.film, order),
        film_before=_rows_of_each(before.film_before, order),
        passed=_rows(before.passed, faces),
        travel=_rows(before.travel, faces),
        open_cells=_rows(domain.open_cells, order),
        step=before.step,
    )
    fraction = np.ones(5)
    fraction[OPENINGS] = edges.film_fraction[OPENINGS]
    if not cells.ring:
        fraction[LOWER] = edges.film_fraction[FIRST]
        fraction[UPPER] = edges.film_fraction[LAST]
    ends = Edges(edges.pressure, fraction, in_plenty(rows.unknown.shape))
    lifted = _lift_of_rows(rows, pace, ends, step, Cells(cells.dy, cells.dx, False, False), False)
    around = np.empty((n_c + 1, n_a))
    for i in range(n_c + 1):
        k = margin + (i % n_c if cells.ring else i)
        for j in range(n_a):
            around[i, j] = lifted.fraction[j, k]
    return Lift(around, travel)


@compiled
def _lift_of_rows(
    rows: PastRows, pace: StepRatios, edges: Edges, step: float, cells: Cells, at_fronts: bool
):
    """Lift of the film fraction at the faces of the rows; `edges` and `cells` as of a skirt."""
    n_c, n_a = rows.unknown.shape
    full = np.empty((n_c, n_a), np.bool_)
    resting = np.empty((n_c, n_a), np.bool_)
    gained = np.empty((n_c, n_a))
    for i in range(n_c):
        area = images(cells.mirrored, i, n_c) * cells.dx * cells.dy
        for j in range(n_a):
            full[i, j] = rows.unknown[i, j] > 0.0 and not rows.open_cells[i, j]
            resting[i, j] = full[i, j] or rows.open_cells[i, j]
            passing = rows.passed[i, j + 1] - rows.passed[i, j]
            gained[i, j] = rows.growth[i, j] * rows.step + passing / area
    states = CellStates(full, resting, gained)
    return transport.lift(rows, states, pace, edges, step, cells, at_fronts)
