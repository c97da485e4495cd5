"""Rows of cells along which sliding carries the oil, for `balance.transport`.

The rows of a skirt are along its axis, and those of a bearing around the circumference.
"""

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
    keep,
    unlimited_supply,
)
from .common.quantities import CARRIERS, CONDUCTIVITY, CONDUCTIVITY_C, STORED, TRANSPORT
from .step_parts import PreviousFilm


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
    """Return the cells by which the rows of a ring overlap at both ends.

    Each explicit step uses four cells upstream. The expected film may need one step more than the
    last film.
    """
    n_c, n_a = before.unknown.shape
    farthest = 0.0
    for i in range(n_c + 1):
        for j in range(n_a):
            faster = 0.0
            for k in ((i - 1) % n_c, i % n_c):
                faster = max(faster, before.film[TRANSPORT, k, j] / before.film[STORED, k, j])
            farthest = max(farthest, abs(before.travel[i, j]) * ratio / cells.dx * faster)
    steps = np.ceil(min(farthest, transport.FARTHEST) / transport.LARGEST_COURANT) + 1.0
    return 4 * int(steps) + 2


@compiled
def lift(before: PreviousFilm, pace: StepRatios, edges: Edges, step: float, domain: Domain):
    """Return the lift of the film fraction, `transport.lift`, from the past alone."""
    cells = domain.cells
    if not domain.bearing:
        return _lift_of_rows(before, domain.open_cells, pace, edges, step, cells, True)
    n_c, n_a = before.unknown.shape
    travel = before.travel * pace.ratio
    margin = _overlap(before, pace.ratio, cells) if cells.ring else 0
    faces = np.empty(n_c + 2 * margin + 1, np.int64)
    for k in range(faces.size):
        faces[k] = (k - margin) % n_c if cells.ring else k
    order = faces[:-1]
    rows = PreviousFilm(
        unknown=_rows(before.unknown, order),
        unknown_before=before.unknown_before,  # not used by the transport, as the next ones
        pressure=before.pressure,
        growth_before=before.growth_before,
        deflection=before.deflection,
        content=_rows(before.content, order),
        growth=_rows(before.growth, order),
        film=_rows_of_each(before.film, order),
        film_before=_rows_of_each(before.film_before, order),
        passed=_rows(before.passed, faces),
        travel=_rows(before.travel, faces),
        step=before.step,
    )
    open_cells = _rows(domain.open_cells, order)
    fraction = np.ones(5)
    fraction[OPENINGS] = edges.film_fraction[OPENINGS]
    if not cells.ring:
        fraction[LOWER] = edges.film_fraction[FIRST]
        fraction[UPPER] = edges.film_fraction[LAST]
    ends = Edges(edges.pressure, fraction, unlimited_supply(rows.unknown.shape))
    turned = Cells(cells.dy, cells.dx, False, False)
    lifted = _lift_of_rows(rows, open_cells, pace, ends, step, turned, False)
    around = np.empty((n_c + 1, n_a))
    for i in range(n_c + 1):
        k = margin + (i % n_c if cells.ring else i)
        for j in range(n_a):
            around[i, j] = lifted.fraction[j, k]
    return Lift(around, travel)


@compiled
def _lift_of_rows(
    rows: PreviousFilm,
    open_cells: Flags,
    pace: StepRatios,
    edges: Edges,
    step: float,
    cells: Cells,
    at_fronts: bool,
):
    """Return the lift at the faces of the rows; all arguments are arranged as for a skirt."""
    n_c, n_a = rows.unknown.shape
    full = np.empty((n_c, n_a), np.bool_)
    blocked = np.empty((n_c, n_a), np.bool_)
    gained = np.empty((n_c, n_a))
    for i in range(n_c):
        area = images(cells.mirrored, i, n_c) * cells.dx * cells.dy
        for j in range(n_a):
            full[i, j] = rows.unknown[i, j] > 0.0 and not open_cells[i, j]
            blocked[i, j] = full[i, j] or open_cells[i, j]
            passing = rows.passed[i, j + 1] - rows.passed[i, j]
            gained[i, j] = rows.growth[i, j] * rows.step + passing / area
    states = CellStates(full, blocked, gained)
    return transport.lift(rows, states, pace, edges, step, cells, at_fronts)
