"""Transport of oil in a cavitated film, by a lift of the film fraction at faces.

Sliding carries the oil along the axis of a skirt, and around the circumference of a bearing. In
this file a row of cells follows that direction: cell j, counted along it, has the faces j and
j + 1. `oil_rows` arranges the cells of a bearing in this way. Across the rows there is no lift.

The film fraction of the upstream cell alone smears a front of oil over more and more cells. Oil in
a cavitated film moves without pressure, so its motion is known when a step begins. An explicit
scheme computes it and keeps fronts sharp. The difference from the transport of the implicit step
is a lift l of the film fraction at the faces, Eq. (E2):

Eq. (T11):  l = (F - beta_t F_n) / (w X H_e/H h_U) - f*_up,   |l| <= 3 (1 - f*)

In a step of `storage`, the volume beta_t F_n + H_e q [m3] passes a face. With this lift it is F,
and the film fraction upstream is f*, if film and velocity continue as in the last step. F and f*
result from explicit steps of Heun's method, in each of which oil travels x, at most a third of a
cell:

Eq. (T12):  c <- c + (x_before m_before - x_behind m_behind) / dy + gain
Eq. (T13):  m = m_up + min(D^2, 2 d D, (2 D + d) D / 6) / D   where d D > 0,   else m_up
Eq. (T14):  |m / h_U - f_up| <= 3 (1 - f) / 4

c content, h_U transported film [m], f the larger film fraction of the two cells of the face, or
that of the upstream cell where the other one holds a front, m = f h_U of a cell or at a face [m], d
and D differences of m before and behind the upstream cell. The last term of Eq. (T13) is of third
order where m is smooth [Koren1993]; the two others keep m at the face between its neighbours, and
the oil of an explicit step positive and without new extremes. By Eq. (T14) the lift fades where the
film gets full. Pressure determines the flow out of a full cell, which has no lift, and no lift may
appear when a cell fills or empties. Film quantities are those expected in the middle of the step,
for f* those at its end. `gain` is the content that came in from other rows in the last step. The
flow through a face next to a full cell is that of the last step.

At an edge or opening through which oil leaves, there is no cell behind. Two cells before it give m:

Eq. (T17):  m = 2 m_up - m_before,   not below 0, not above h_U

Where oil enters a full zone of a skirt, the last cell before it holds the front:

Eq. (T16):  l = (1 - f_in) / 2 + (f_in - f_z) (a - 1/2)      at the face into the full zone

f_in is the film fraction that enters this cell, f_z that of the flow into the zone, and a the share
of the cell that is full. The front is thus s = a + 1/2 cells before the centre of the first full
cell, and the flow into the zone is T - K p / s, with the pressure p there. The balance has no
pressure at the centre of the cell of the front, so it needs f = f_z + (1 - f_z) s at this face. The
cell holds f_in + (1 - f_in) a, and Eq. (T16) is the difference. Its last term is at most
3 (1 - f_in) / 4. l is at least -f_in, and takes no more oil than the cell holds and gets. f_z comes
from the flow behind the first full cell in the last step. If the cell of the front fills in the
next step, the front moves to the cell before it.

Travel of the last step and of this one:

Eq. (T15):  X_n = beta_t X_{n-1} + H_e U,   X = X_n H / H_n

The lift depends on the past only. The flow therefore remains a linear function of the unknown with
the same coefficients, and matrix and cavitation are those without a lift. A repeated step has the
same bits, and l is a constant in the tangent. The flow through a face is the same for both cells,
so oil is conserved to round-off. A steady film remains steady with any step, since F is then X
times a flow that does not depend on the step.

If oil travels farther than `FARTHEST` cells in a step, the explicit steps end there, and the flow
of the last one holds for the rest. So any step has a lift, and a film that settles in long steps
settles at the same front as in short ones, or at the next one that Eq. (T16) allows.

In some places there is no lift, and transport is of first order: at faces behind a full cell, at
edges through which oil enters, in the first step, where sliding reverses, and at the fronts of a
bearing. There oil also goes sideways, and with Eq. (T16) long steps would not settle. If film or
velocity jump within a step, a cell can owe oil. Its row is then solved again without lift.

Arrays have the shape (rows, n) of the cells, (rows, n + 1) of their faces.

References
----------
[Koren1993] B. Koren, A robust upwind discretization method for advection, diffusion and source
terms, in Numerical Methods for Advection-Diffusion Problems, Vieweg 1993, 117-138 (the limiter).
"""

from typing import Any, NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable, compiled
from ..common.grid import LOWER, OPENINGS, UPPER, Array, Cells, Edges, Flags, images
from ..common.quantities import CONDUCTIVITY, STORED, TRANSPORT

NEAREST = 1e-9  # cells of travel in a step, below which there is no lift: only round-off moves
FARTHEST = 16.0  # cells that the explicit steps cover at most
LARGEST_COURANT = 1.0 / 3.0  # of an explicit step
STEEPEST = 1.0 / LARGEST_COURANT - 1.0  # bound on m at a face in Eq. (T13), no oil owed up to it
# shares of the deficit 1 - f that the film fraction at a face may differ by from the upstream one,
# in an explicit step and with the memory of the last step; from order tests in the step
NEAR_FULL = 0.75
NEAR_FULL_WITH_MEMORY = 3.0


class CellStates(NamedTuple):
    """State of the cells at the end of the last step, for the transport of the next one.

    full, blocked : ndarray of bool, shape (rows, n)
        Cells that are full; and those that carry no oil: full ones, and those without a film.
    gained : ndarray, shape (rows, n)
        Content that came in from other rows [m].
    """

    full: Flags
    blocked: Flags
    gained: Array


class StepRatios(NamedTuple):
    """Lengths of a step: ratio H / H_n, share beta_t of `storage`, and euler H_e / H [-]."""

    ratio: float
    share: float
    euler: float


class Lift(NamedTuple):
    """Eq. (T11), each ndarray of shape (n_c, n_a + 1), of a bearing (n_c + 1, n_a).

    fraction : lift of the film fraction at a face [-]; travel : X it holds for [m].
    """

    fraction: Array
    travel: Array


@compilable
def pace(step: float, step_before: float, length: float) -> StepRatios:
    """`StepRatios` of a step.

    Parameters
    ----------
    step, step_before, length : float
        H > 0, H_n >= 0, H_e [s].
    """
    if step_before == 0.0:
        return StepRatios(0.0, 0.0, length / step)
    return StepRatios(step / step_before, (step - length) / step_before, length / step)


@compiled(forceinline=True)
def _face_value(before, up, down):
    """m at a face, Eq. (T13), from m before the upstream cell, in it, and behind it."""
    step = down - up
    slope = up - before
    if slope * step <= 0.0:
        return up
    # Eq. (T13)
    return up + min(step * step, STEEPEST * slope * step, (2.0 * step + slope) * step / 6.0) / step


class TransportFilm(NamedTuple):
    """Film that oil is carried through in a step.

    stored, mobile : ndarray, shape (rows, n), stored and transported film s and t [m];
    between : ndarray, shape (rows, n + 1), transported film at the faces [m];
    travel : ndarray, shape (rows, n + 1), X [m];
    full, blocked : ndarray of bool, shape (rows, n), as in `CellStates`;
    supply : ndarray, shape (2, rows), film fraction at lower and upper edge [-];
    width : ndarray, shape (rows,), of the faces of each row [m].
    """

    stored: Array
    mobile: Array
    between: Array
    travel: Array
    full: Flags
    blocked: Flags
    supply: Array
    width: Array


@compiled(forceinline=True)
def _holds_front(cell, onward, i, full):
    """Return whether oil goes from a cell into a full one; onward: 1 with ascending j, else -1."""
    return 0 <= cell + onward < full.shape[1] and full[i, cell + onward]


@compiled(forceinline=True)
def _row_flow(amount, i, film, steps, known_volume, flow):
    """Compute the volumes that pass the axial faces of row i in an explicit step into `flow` [m3].

    It is one of `steps`, Eqs. (T12) to (T14).

    amount : of the cells of the row, content [m], or film fraction in a cell without a film;
    known_volume : passes the faces in all steps where it does not follow from transport [m3].
    """
    stored, mobile, between, travel, full, blocked, supply, widths = film
    width = widths[i]
    n_a = amount.size
    for j in range(n_a + 1):
        x = travel[i, j] / steps
        up = j - 1 if x > 0.0 else j
        down = j if x > 0.0 else j - 1
        is_known = not 0 <= up < n_a or blocked[i, up] or _holds_front(up, down - up, i, full)
        if x == 0.0 or is_known:
            flow[j] = known_volume[j] / steps
            continue
        fraction_up = min(amount[up] / stored[i, up], 1.0)
        at_edge = not 0 <= down < n_a or (blocked[i, down] and not full[i, down])
        beyond = 2 * up - down
        if beyond < 0:
            m_before = supply[LOWER, i] * mobile[i, up]
        elif beyond == n_a:
            m_before = supply[UPPER, i] * mobile[i, up]
        elif blocked[i, beyond] and not full[i, beyond]:
            m_before = amount[beyond] * mobile[i, up]
        else:
            m_before = min(amount[beyond] / stored[i, beyond], 1.0) * mobile[i, beyond]
        m_up = fraction_up * mobile[i, up]
        fraction_beyond_face = fraction_up
        if at_edge:
            m_face = min(max(2.0 * m_up - m_before, 0.0), mobile[i, up])  # Eq. (T17)
        else:
            fraction_down = min(amount[down] / stored[i, down], 1.0)
            m_face = _face_value(m_before, m_up, fraction_down * mobile[i, down])
            if not _holds_front(down, down - up, i, full):
                fraction_beyond_face = fraction_down
        room = NEAR_FULL * (1.0 - max(fraction_up, fraction_beyond_face))
        # Eq. (T14)
        lifted = min(max(m_face / between[i, j], fraction_up - room), fraction_up + room)
        flow[j] = width * x * lifted * between[i, j]


@compiled(forceinline=True)
def _lift_in_row(i, film, through, amount, past, pace, length, fraction):
    """Compute the lift at the faces of row i, Eq. (T11), into `fraction`.

    through : as in `_lift_at_fronts`; amount : as in `_row_flow`, at the end of the step;
    past : step_parts.PreviousFilm; length : of a cell [m].
    """
    n_a = amount.size
    for j in range(n_a + 1):
        x = film.travel[i, j]
        up = j - 1 if x > 0.0 else j
        down = 2 * j - 1 - up
        if abs(x) <= NEAREST * length or not 0 <= up < n_a or film.blocked[i, up]:
            continue
        at_edge = not 0 <= down < n_a or (film.blocked[i, down] and not film.full[i, down])
        if not at_edge and film.blocked[i, down]:
            continue
        swept = film.width[i] * x * film.between[i, j]
        # the bounds remove a last flow by pressure
        last = min(max(pace.ratio * past.passed[i, j] / swept, 0.0), 1.0) * swept / pace.ratio
        reached = min(amount[up] / film.stored[i, up], 1.0)
        # Eq. (T11)
        wanted = (through[j] - pace.share * last) / (pace.euler * swept) - reached
        fuller = amount[up] / film.stored[i, up]
        if not at_edge and not _holds_front(down, down - up, i, film.full):
            fuller = max(fuller, amount[down] / film.stored[i, down])
        room = NEAR_FULL_WITH_MEMORY * max(1.0 - fuller, 0.0)
        fraction[i, j] = min(max(wanted, -room), room)


@compiled(forceinline=True)
def _lift_at_fronts(i, film, last_volume, through, content, past, area, fraction):
    """Compute the lift at the faces of row i into full cells, Eq. (T16), into `fraction`.

    last_volume, through : volumes that passed the faces in the last step, in proportion to the
    length of this one, and that oil without pressure passes in it, towards ascending j [m3];
    content : at the end of the step [m]; past : step_parts.PreviousFilm; area : of a cell [m2].
    """
    stored_before = past.film[STORED]
    n_a = content.size
    for j in range(1, n_a):
        x = film.travel[i, j]
        onward = 1 if x > 0.0 else -1
        cell = j - 1 if x > 0.0 else j
        if film.blocked[i, cell] or not film.full[i, cell + onward]:
            continue
        flow = onward * last_volume[j]
        if 0 < j + onward < n_a and film.full[i, cell + 2 * onward]:
            grown = film.stored[i, cell + onward] - stored_before[i, cell + onward]
            flow = onward * last_volume[j + onward] + grown * area
        upstream = cell - onward
        while 0 <= upstream < n_a and not film.blocked[i, upstream]:
            if content[cell] <= film.stored[i, cell]:
                break
            # the cell fills in this step, and the front moves on
            flow += (film.stored[i, cell] - stored_before[i, cell]) * area
            cell = upstream
            upstream -= onward
        entry = cell if x > 0.0 else cell + 1
        face = entry + onward
        if film.travel[i, face] * film.travel[i, entry] <= 0.0:
            continue
        swept = film.width[i] * film.travel[i, entry] * film.mobile[i, cell]
        entering = min(max(through[entry] / swept, 0.0), 1.0)
        if entering == 1.0:
            continue
        deficit = 1.0 - entering
        share = (content[cell] / film.stored[i, cell] - entering) / deficit
        drawn = film.width[i] * abs(film.travel[i, face]) * film.between[i, face]
        passing = min(max(flow / drawn, 0.0), 1.0)
        moving = (entering - passing) * (min(max(share, 0.0), 1.0) - 0.5)
        room = NEAR_FULL * deficit
        wanted = 0.5 * deficit + min(max(moving, -room), room)
        available = abs(through[entry]) + past.content[i, cell] * area
        # Eq. (T16)
        fraction[i, face] = max(min(wanted, available / drawn), -entering)


@compiled(forceinline=True)
def _expected(past, quantity, ratio):
    """Return a quantity extrapolated over the share `ratio` of the last step."""
    last = past.film[quantity]
    before = past.film_before[quantity]
    expected = np.empty_like(last)
    for i in range(last.shape[0]):
        for j in range(last.shape[1]):
            now = last[i, j]
            onward = now + ratio * (now - before[i, j])
            expected[i, j] = min(max(onward, 0.5 * now), 2.0 * now)
    return expected


@compiled(forceinline=True)
def _face_film(mobile, g, states):
    """Transported film at the axial faces [m], Eq. (E3); next to an opening that of the cell."""
    n_c, n_a = mobile.shape
    between = np.empty((n_c, n_a + 1))
    for i in range(n_c):
        for j in range(n_a + 1):
            a = max(j - 1, 0)
            b = min(j, n_a - 1)
            if states.blocked[i, a] and not states.full[i, a]:
                a = b
            elif states.blocked[i, b] and not states.full[i, b]:
                b = a
            # Eq. (E3)
            weighted = mobile[i, a] * g[i, b] + mobile[i, b] * g[i, a]
            between[i, j] = weighted / (g[i, a] + g[i, b])
    return between


@compiled(forceinline=True)
def _expected_film(past, states, ratio, travel, supply, width):
    """Return the film that is expected after the share `ratio` of the last step."""
    stored = _expected(past, STORED, ratio)
    mobile = _expected(past, TRANSPORT, ratio)
    between = _face_film(mobile, _expected(past, CONDUCTIVITY, ratio), states)
    return TransportFilm(
        stored=stored,
        mobile=mobile,
        between=between,
        travel=travel,
        full=states.full,
        blocked=states.blocked,
        supply=supply,
        width=width,
    )


@compiled(forceinline=True)
def _explicit_steps(i, film, length):
    """Return the number of explicit steps of row i, 0 without a lift; length : of a cell [m]."""
    farthest = 0.0
    for j in range(film.mobile.shape[1]):
        if film.blocked[i, j] and not film.full[i, j]:
            continue
        swept = max(abs(film.travel[i, j]), abs(film.travel[i, j + 1]))
        farthest = max(farthest, swept * film.mobile[i, j] / film.stored[i, j])
    courant = farthest / length
    if courant <= NEAREST:
        return 0.0
    return np.ceil(courant / LARGEST_COURANT * (1.0 - 1e-12))


@compiled(forceinline=True)
def _entering(fraction, limit, step, swept):
    """Film fraction that comes in over an edge; swept: volume of the film dragged in [m3]."""
    return min(fraction, limit * step / swept) if swept > 0.0 else fraction


@compiled
def lift(
    past: Any,
    states: CellStates,
    pace: StepRatios,
    edges: Edges,
    step: float,
    cells: Cells,
    at_fronts: bool,
):
    """Return the lift of the film fraction at the faces of the rows for the step to come.

    Parameters
    ----------
    past : step_parts.PreviousFilm
    states : CellStates
    pace : StepRatios
    edges : grid.Edges
    step : float
        H [s].
    cells : grid.Cells
    at_fronts : bool
        Whether faces into full cells have a lift, Eq. (T16).

    Returns
    -------
    Lift
    """
    n_c, n_a = past.content.shape
    widths = np.empty(n_c)
    for i in range(n_c):
        widths[i] = images(cells.mirrored, i, n_c) * cells.dx  # Eq. (E19)
    fraction = np.zeros((n_c, n_a + 1))
    travel = past.travel * pace.ratio  # Eq. (T15)
    supply = np.empty((2, n_c))
    middle = _expected_film(past, states, 0.5 * pace.ratio, travel, supply, widths)
    end = _expected_film(past, states, pace.ratio, travel, supply, widths)
    known_volume = np.empty(n_a + 1)
    through = np.empty(n_a + 1)
    amount = np.empty(n_a)
    predicted, source = np.empty(n_a), np.empty(n_a)
    flow = np.empty(n_a + 1)
    flow_predicted = np.empty(n_a + 1)
    for i in range(n_c):
        steps = _explicit_steps(i, middle, cells.dy)
        if steps == 0:
            continue
        width = widths[i]
        area = width * cells.dy
        for j in range(n_a + 1):
            known_volume[j], through[j] = pace.ratio * past.passed[i, j], 0.0
        # what the implicit step lets in over a starved edge
        swept = width * travel[i, 0] * end.between[i, 0]
        supply[LOWER, i] = _entering(edges.film_fraction[LOWER], edges.limit[i, 0], step, swept)
        if supply[LOWER, i] < 1.0 and swept > 0.0:
            known_volume[0] = pace.share * past.passed[i, 0] + pace.euler * swept * supply[LOWER, i]
        swept = width * travel[i, n_a] * end.between[i, n_a]
        supply[UPPER, i] = _entering(edges.film_fraction[UPPER], edges.limit[i, n_a], step, -swept)
        if supply[UPPER, i] < 1.0 and swept < 0.0:
            known_volume[n_a] = (
                pace.share * past.passed[i, n_a] + pace.euler * swept * supply[UPPER, i]
            )
        for j in range(n_a):
            no_film = states.blocked[i, j] and not states.full[i, j]
            amount[j] = edges.film_fraction[OPENINGS] if no_film else past.content[i, j]
            source[j] = max(states.gained[i, j], 0.0) * pace.ratio / steps
        for j in range(1, n_a):
            up = j - 1 if travel[i, j] > 0.0 else j
            if edges.limit[i, j] == np.inf or states.blocked[i, 2 * j - 1 - up]:
                continue
            # a film that starts behind an opening
            swept = width * travel[i, j] * end.between[i, j]
            entering = _entering(1.0, edges.limit[i, j], step, abs(swept))
            if entering < 1.0:
                amount[up] = entering
                known_volume[j] = pace.share * past.passed[i, j] + pace.euler * swept * entering
        taken = int(min(steps, FARTHEST / LARGEST_COURANT))
        for k in range(taken):
            times = steps - k if k == taken - 1 else 1.0
            _row_flow(amount, i, middle, steps, known_volume, flow)
            for j in range(n_a):
                predicted[j] = amount[j]
                if not states.blocked[i, j]:
                    predicted[j] += source[j] + (flow[j] - flow[j + 1]) / area  # Eq. (T12)
            _row_flow(predicted, i, middle, steps, known_volume, flow_predicted)
            for j in range(n_a + 1):
                flow[j] = 0.5 * (flow[j] + flow_predicted[j])
                through[j] += times * flow[j]
            for j in range(n_a):
                if not states.blocked[i, j]:
                    amount[j] += source[j] + (flow[j] - flow[j + 1]) / area
        _lift_in_row(i, end, through, amount, past, pace, cells.dy, fraction)
        if at_fronts:
            _lift_at_fronts(i, end, known_volume, through, amount, past, area, fraction)
    return Lift(fraction, travel)
