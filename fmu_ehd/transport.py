"""How much more, or less, than the upstream cell a face of a cavitated film carries.

Upstream film fraction alone, Eq. (E2), smears a front over ever more cells. What is missing is
known at the beginning of a step: oil in a cavitated film moves as it lies, without pressure. It is
carried on by explicit steps of third order, kept between its neighbours, and the difference to
what the implicit step would carry enters as a known lift of the film fraction at each axial face:

Eq. (T4):  q = K (p_a - p_b) + T (f_up + lift)
Eq. (T5):  lift = (F - beta F_n) / (w X H_e/H t) - f*_up

so that the volume F' = beta F_n + H_e q [m3] that passes a face in a step of `storage` is F where
film and velocity go on as they did, and the film fraction lands on f*_up = c*_up / s. F, c* are
those of the content after n explicit steps, each with the travel x = X/n, in which less oil moves
than lies in a cell:

Eq. (T6):  c_a <- c_a + x (m_before - m_behind),   m = min(c/s, 1) t
Eq. (T7):  m_face = m_up + (1 - C)/2 phi(r) (m_down - m_up),   C = x t / (s dy)
Eq. (T8):  phi = max(0, min(2 r/C, 2/(1 - C), 1 + (1 + C)/3 (r - 1)))

c content, s stored, t transported film [m] at the beginning of the step, C Courant number [-], r
difference of m before the upstream cell over that behind it [-]. Eq. (T7) with the last term of
Eq. (T8) is of third order where the film fraction is smooth [Leonard1991], the two others keep it
between its neighbours; with C = 1 oil moves on by exactly a cell. The flow remains a linear
function of the unknown with the same coefficients, so matrix, elimination and cavitation are what
they are without; the lift depends on the past alone, so in the tangent it is a constant beside the
upstream film fraction. A flow through a face is the same for both its cells: oil is conserved.

Travel of the last step:

Eq. (T9):  X_n = beta X_{n-1} + H_e U,   X = X_n H / H_n

There is no lift, and transport is of first order as in Eq. (E2): at a face with a full cell on
either side, whose flow obeys the pressure; at edges; in the first step; where sliding reverses;
and where oil travels farther than `FARTHEST` cells in a step, thus in a steady film.

Arrays have the shape (n_c, n_a) of the grid, (n_c, n_a + 1) of its axial faces.

References
----------
[Leonard1991] B. P. Leonard, The ULTIMATE conservative difference scheme applied to unsteady
one-dimensional advection, Comput. Methods Appl. Mech. Eng. 88 (1991) 17-74.
"""

from typing import NamedTuple

import numpy as np

from ..master.fmi.compiled import compiled
from .films import CONDUCTIVITY_A, STORED, TRANSPORT
from .grid import LOWER, UPPER, Array, Cells, Flags

FRACTION_ROUNDOFF = 1e-15  # film fraction below zero that is rounding
FARTHEST = 16.0  # cells of travel in a step
LARGEST_COURANT = 1.0 / 3.0  # of an explicit step
LEAST = 2.0
KAPPA = 0.5
FINAL = 3.0


class Past(NamedTuple):
    """What the last step leaves behind for the transport of the next one.

    film, film_before : ndarray, shape (7, n_c, n_a)
        Quantities of `films` at its end and at its beginning.
    content : ndarray, shape (n_c, n_a)
        c_n at its end [m].
    resting : ndarray of bool, shape (n_c, n_a)
        Cells that are full, or have no film.
    gained : ndarray, shape (n_c, n_a)
        Content that came in circumferentially [m].
    passed, travel : ndarray, shape (n_c, n_a + 1)
        F_n [m3], X_n [m], both positive with ascending j.
    """

    film: Array
    film_before: Array
    content: Array
    resting: Flags
    gained: Array
    passed: Array
    travel: Array


class Pace(NamedTuple):
    """Lengths of a step: ratio H / H_n, share beta of `storage`, and euler H_e / H [-]."""

    ratio: float
    share: float
    euler: float


class Lift(NamedTuple):
    """Eq. (T5), each ndarray of shape (n_c, n_a + 1).

    fraction : lift of the film fraction at a face [-]; travel : X it holds for [m].
    """

    fraction: Array
    travel: Array


def pace(step: float, step_before: float, length: float) -> Pace:
    """`Pace` of a step.

    Parameters
    ----------
    step, step_before, length : float
        H > 0, H_n >= 0, H_e [s].
    """
    if step_before == 0.0:
        return Pace(0.0, 0.0, length / step)
    return Pace(step / step_before, (step - length) / step_before, length / step)


@compiled(inline="always")
def _face_value(before, up, down):
    """m_face, Eq. (T7), from m before the upstream cell, in it, and behind it."""
    step = down - up
    slope = up - before
    if slope * step <= 0.0:
        return up
    # Eq. (T7), phi (m_down - m_up) / 2
    return up + min(step * step, LEAST * slope * step, (2.0 * step + slope) * step / 6.0) / step


@compiled(inline="always")
def _row_flow(
    content, i, stored, mobile, resting, travel, steps, supply, between, given, width, flow
):
    """Volumes that pass the axial faces of row i in one of `steps` explicit steps, Eqs. (T6),
    (T7), into `flow` [m3].
    """
    n_a = content.size
    for j in range(n_a + 1):
        x = travel[i, j] / steps
        up = j - 1 if x > 0.0 else j
        down = j if x > 0.0 else j - 1
        if x == 0.0 or not 0 <= up < n_a or resting[i, up]:
            flow[j] = given[j] / steps
            continue
        here = min(content[up] / stored[i, up], 1.0)
        if not 0 <= down < n_a or resting[i, down]:
            flow[j] = width * x * here * between[i, j]
            continue
        beyond = 2 * up - down
        if beyond < 0:
            before = supply[LOWER] * mobile[i, 0]
        elif beyond == n_a:
            before = supply[UPPER] * mobile[i, n_a - 1]
        else:
            before = min(content[beyond] / stored[i, beyond], 1.0) * mobile[i, beyond]
        there = min(content[down] / stored[i, down], 1.0)
        value = _face_value(before, here * mobile[i, up], there * mobile[i, down])
        room = KAPPA * (1.0 - max(here, there))
        lifted = min(max(value / between[i, j], here - room), here + room)
        flow[j] = width * x * lifted * between[i, j]


@compiled(inline="always")
def _expected(past, quantity, ratio):
    """A quantity of the film after the share `ratio` of a last step, if it goes on as before."""
    last = past.film[quantity]
    before = past.film_before[quantity]
    expected = np.empty_like(last)
    for i in range(last.shape[0]):
        for j in range(last.shape[1]):
            now = last[i, j]
            onward = now + ratio * (now - before[i, j])
            expected[i, j] = min(max(onward, 0.5 * now), 2.0 * now)
    return expected


@compiled(inline="always")
def _face_film(mobile, g):
    """Transported film at the axial faces [m], Eq. (E3)."""
    n_c, n_a = mobile.shape
    between = np.empty((n_c, n_a + 1))
    for i in range(n_c):
        for j in range(n_a + 1):
            a = max(j - 1, 0)
            b = min(j, n_a - 1)
            # Eq. (E3)
            weighted = mobile[i, a] * g[i, b] + mobile[i, b] * g[i, a]
            between[i, j] = weighted / (g[i, a] + g[i, b])
    return between


@compiled
def lift(past: Past, pace: Pace, supply: Array, cells: Cells):
    """Lift of the film fraction at the axial faces for the step to come.

    Parameters
    ----------
    past : Past
    pace : Pace
    supply : ndarray, shape (4,)
        Film fraction at the edges [-].
    cells : grid.Cells

    Returns
    -------
    Lift
    """
    width = cells.dx
    area = cells.dx * cells.dy
    # in the middle of the step, and at its end
    stored = _expected(past, STORED, 0.5 * pace.ratio)
    mobile = _expected(past, TRANSPORT, 0.5 * pace.ratio)
    between = _face_film(mobile, _expected(past, CONDUCTIVITY_A, 0.5 * pace.ratio))
    stored_end = _expected(past, STORED, pace.ratio)
    between_end = _face_film(
        _expected(past, TRANSPORT, pace.ratio), _expected(past, CONDUCTIVITY_A, pace.ratio)
    )
    n_c, n_a = stored.shape
    fraction = np.zeros((n_c, n_a + 1))
    travel = past.travel * pace.ratio  # Eq. (T9)
    given = np.empty(n_a + 1)
    through = np.empty(n_a + 1)
    content = np.empty(n_a)
    ahead = np.empty(n_a)
    source = np.empty(n_a)
    flow = np.empty(n_a + 1)
    flow_ahead = np.empty(n_a + 1)
    for i in range(n_c):
        farthest = 0.0
        for j in range(n_a):
            swept = max(abs(travel[i, j]), abs(travel[i, j + 1]))
            farthest = max(farthest, swept * mobile[i, j] / stored[i, j])
        courant = farthest / cells.dy
        if not 0.0 < courant <= FARTHEST:
            continue
        steps = int(np.ceil(courant / LARGEST_COURANT * (1.0 - 1e-12)))
        for j in range(n_a + 1):
            given[j] = pace.ratio * past.passed[i, j]
            through[j] = 0.0
        # what the implicit step lets in over a starved edge
        if supply[LOWER] < 1.0 and travel[i, 0] > 0.0:
            swept = width * travel[i, 0] * between_end[i, 0]
            given[0] = pace.share * past.passed[i, 0] + pace.euler * swept * supply[LOWER]
        if supply[UPPER] < 1.0 and travel[i, n_a] < 0.0:
            swept = width * travel[i, n_a] * between_end[i, n_a]
            given[n_a] = pace.share * past.passed[i, n_a] + pace.euler * swept * supply[UPPER]
        for j in range(n_a):
            content[j] = past.content[i, j]
            source[j] = max(past.gained[i, j], 0.0) * pace.ratio / steps
        for _ in range(steps):
            _row_flow(
                content,
                i,
                stored,
                mobile,
                past.resting,
                travel,
                steps,
                supply,
                between,
                given,
                width,
                flow,
            )
            for j in range(n_a):
                ahead[j] = content[j]
                if not past.resting[i, j]:
                    ahead[j] += source[j] + (flow[j] - flow[j + 1]) / area  # Eq. (T6)
            _row_flow(
                ahead,
                i,
                stored,
                mobile,
                past.resting,
                travel,
                steps,
                supply,
                between,
                given,
                width,
                flow_ahead,
            )
            for j in range(n_a + 1):
                flow[j] = 0.5 * (flow[j] + flow_ahead[j])
                through[j] += flow[j]
            for j in range(n_a):
                if not past.resting[i, j]:
                    content[j] += source[j] + (flow[j] - flow[j + 1]) / area
        for j in range(1, n_a):
            x = travel[i, j]
            if x == 0.0 or past.resting[i, j - 1] or past.resting[i, j]:
                continue
            up = j - 1 if x > 0.0 else j
            swept = width * x * between_end[i, j]
            # a last flow that pressure drove is none of transport
            last = min(max(pace.ratio * past.passed[i, j] / swept, 0.0), 1.0) * swept / pace.ratio
            reached = min(content[up] / stored_end[i, up], 1.0)
            # Eq. (T5)
            wanted = (through[j] - pace.share * last) / (pace.euler * swept) - reached
            fuller = max(content[j - 1] / stored_end[i, j - 1], content[j] / stored_end[i, j])
            room = FINAL * max(1.0 - fuller, 0.0)
            fraction[i, j] = min(max(wanted, -room), room)
    return Lift(fraction, travel)


@compiled
def along(lift: Lift, axial_velocity: Array):
    """Lift at the faces where oil goes on in the direction that the lift holds for, else 0.

    Parameters
    ----------
    lift : Lift
    axial_velocity : ndarray, shape (n_c, n_a)
        Entrainment velocity of the step [m/s].

    Returns
    -------
    ndarray, shape (n_c, n_a + 1)
    """
    fraction = np.zeros_like(lift.fraction)
    n_c, n_a = axial_velocity.shape
    for i in range(n_c):
        for j in range(1, n_a):
            onward = axial_velocity[i, j - 1] + axial_velocity[i, j]
            if onward * lift.travel[i, j] > 0.0:
                fraction[i, j] = lift.fraction[i, j]
    return fraction


@compiled
def travelled(travel: Array, pace: Pace, axial_velocity: Array, length: float):
    """Travel of a step at the axial faces, Eq. (T9).

    Parameters
    ----------
    travel : ndarray, shape (n_c, n_a + 1)
        X_{n-1} of the step before [m].
    pace : Pace
    axial_velocity : ndarray, shape (n_c, n_a)
        U at the end of the step [m/s].
    length : float
        H_e [s].

    Returns
    -------
    ndarray, shape (n_c, n_a + 1)
        X_n [m].
    """
    n_c, n_a = axial_velocity.shape
    after = np.empty_like(travel)
    for i in range(n_c):
        for j in range(n_a + 1):
            below = axial_velocity[i, max(j - 1, 0)]
            above = axial_velocity[i, min(j, n_a - 1)]
            # Eq. (T9)
            after[i, j] = pace.share * travel[i, j] + length * 0.5 * (below + above)
    return after


@compiled
def owing(unknown: Array, full: Flags):
    """Rows i in which a cell would owe oil.

    Parameters
    ----------
    unknown : ndarray, shape (n_c, n_a)
        Signed unknown of a step.
    full : ndarray of bool, shape (n_c, n_a)

    Returns
    -------
    ndarray of bool, shape (n_c,)
    """
    rows = np.zeros(unknown.shape[0], np.bool_)
    for i in range(unknown.shape[0]):
        for j in range(unknown.shape[1]):
            if not full[i, j] and unknown[i, j] < -1.0 - FRACTION_ROUNDOFF:
                rows[i] = True
    return rows


def without(lift: Lift, rows: Flags) -> Lift:
    """A lift whose fraction is zero in the given rows.

    Parameters
    ----------
    lift : Lift
    rows : ndarray of bool, shape (n_c,)
    """
    return lift._replace(fraction=np.where(rows[:, None], 0.0, lift.fraction))
