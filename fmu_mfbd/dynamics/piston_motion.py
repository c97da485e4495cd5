"""Equation of motion of the flexible piston on its crank, in minimal coordinates [x_A, rocking
angle, modal coordinates].

A's height and the rod's angle follow from x_A and the crank angle, so that there are no constraints
and nothing drifts.

References
----------
[Deuflhard2011] P. Deuflhard, Newton Methods for Nonlinear Problems, Springer, 2011.
"""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compiled
from .floating_frame import Arrow, frame_arrow, frame_force
from .pin_friction import friction_moment
from .slider_crank import motion, rod_turn

ROUND_OFF = 4e-15  # of a place: some last digits, of the sum of many modes


class Load(NamedTuple):
    """Forces on the piston at the end of a step.

    Parameters
    ----------
    lateral, axial : float
        Resultants along x and y, pin excepted [N].
    moment : float
        About A, about +z [N m].
    modal : ndarray, shape (k,)
        [kg^-1/2 N]
    """

    lateral: float
    axial: float
    moment: float
    modal: np.ndarray


@compiled
def imbalance(
    body, mechanism, load, place, rate, acceleration, crank_angle, crank_speed, crank_acceleration
):
    """Residual of the equations of motion.

    Eq. (M1):  x_A:   e . (R F + m_pin A'') + rod + M psi_x - (load_x + Y_x load_y) = 0       e = (1, Y_x),  A'' = (x_A'', Y'')
               angle: frame moment - M - moment = 0,   modes: frame modal force - modal = 0
    with F, the frame's rows (Eq. (R1) to (R3)) at a = R^T A'', R the rotation by the rocking angle;
    M, the moment of pin friction (Eq. (J1)); psi, the rod's angle.

    Parameters
    ----------
    body : FlexibleBody
    mechanism : Mechanism
    load : Load
    place, rate, acceleration : ndarray, shape (2 + k,)
        [x_A [m], rocking angle [rad], modal coordinates [kg^1/2 m]] and derivatives in time.
    crank_angle, crank_speed, crank_acceleration : float
        [rad], [rad/s], [rad/s2]

    Returns
    -------
    residual : ndarray, shape (2 + k,)
        [N], [N m], [kg^-1/2 N].
    pin_x, pin_y : float
        Force of the pin on the piston [N].
    moment : float
        Of pin friction on the piston [N m].
    torque : float
        Torque that the drive exerts on the crank, positive in its direction of turning [N m].
    """
    r = mechanism.crank_radius
    link = motion(
        mechanism, place[0], rate[0], acceleration[0], crank_angle, crank_speed, crank_acceleration
    )
    ax, ay, slope = acceleration[0], link[0], link[4]
    c, s = np.cos(place[1]), np.sin(place[1])
    frame = frame_force(
        body,
        c * ax + s * ay,
        -s * ax + c * ay,
        acceleration[1],
        rate[1],
        place[2:],
        rate[2:],
        acceleration[2:],
    )
    pin_x = c * frame[0] - s * frame[1] - load.lateral
    pin_y = s * frame[0] + c * frame[1] - load.axial
    turn, turn_x, _, _, turn_crank = rod_turn(
        mechanism, place[0], rate[0], crank_angle, crank_speed
    )
    moment = friction_moment(mechanism.friction, pin_x, pin_y, rate[1] - turn)[0]
    pull_x, pull_y = pin_x + mechanism.pin_mass * ax, pin_y + mechanism.pin_mass * ay
    residual = np.empty(len(place))
    residual[0] = pull_x + slope * pull_y + link[6] + moment * turn_x  # Eq. (M1)
    residual[1] = frame[2] - moment - load.moment
    for k in range(len(load.modal)):
        residual[2 + k] = frame[3 + k] - load.modal[k]
    lever = -r * np.sin(crank_angle) + slope * r * np.cos(crank_angle)
    return residual, pin_x, pin_y, moment, pull_y * lever + link[10] + moment * turn_crank


@compiled
def tangent(
    body,
    mechanism,
    load,
    place,
    rate,
    acceleration,
    crank_angle,
    crank_speed,
    crank_acceleration,
    c1,
    c2,
):
    """Derivative of the residual (Eq. (M1)) when each end acceleration moves its velocity by c1 [s]
    and its place by c2 [s2], without the coupling of modes among each other
    (`floating_frame.mode_coupling`).

    Parameters
    ----------
    body, mechanism, load, place, rate, acceleration, crank_angle, crank_speed, crank_acceleration
        As for `imbalance`.
    c1, c2 : float
        `Coefficients.rate` and `Coefficients.place` of the time integrator.

    Returns
    -------
    Arrow
        Of two rigid motions.
    """
    link = motion(
        mechanism, place[0], rate[0], acceleration[0], crank_angle, crank_speed, crank_acceleration
    )
    lift, slope, bend = link[1] + c1 * link[2] + c2 * link[3], link[4], c2 * link[5]
    c, s = np.cos(place[1]), np.sin(place[1])
    ax, ay = acceleration[0], link[0]
    bx, by = c * ax + s * ay, -s * ax + c * ay
    q, dq, ddq = place[2:], rate[2:], acceleration[2:]
    force = frame_force(body, bx, by, acceleration[1], rate[1], q, dq, ddq)
    frame = frame_arrow(body, bx, by, acceleration[1], rate[1], q, dq, ddq, c1, c2)
    dx, dy = c + s * lift, -s + c * lift  # dA''/dx_A'' in the body frame
    turn, turn_x, turn_xx, turn_rate_x, _ = rod_turn(
        mechanism, place[0], rate[0], crank_angle, crank_speed
    )
    pin_x, pin_y = (
        c * force[0] - s * force[1] - load.lateral,
        s * force[0] + c * force[1] - load.axial,
    )
    moment, by_x, by_y, by_slip = friction_moment(mechanism.friction, pin_x, pin_y, rate[1] - turn)
    rows = _turned(frame.top, dx, dy, bx, by, c2)
    rows[0, 1] -= c2 * force[1]  # the frame turns, and its force with it
    rows[1, 1] += c2 * force[0]
    top, slip = np.empty((2, len(place))), (-c1 * turn_x - c2 * turn_rate_x, c1)
    for i in range(len(place)):
        px, py = c * rows[0, i] - s * rows[1, i], s * rows[0, i] + c * rows[1, i]
        change = by_x * px + by_y * py + (by_slip * slip[i] if i < 2 else 0.0)
        top[0, i] = px + slope * py + turn_x * change
        top[1, i] = rows[2, i] - change
    pin = mechanism.pin_mass
    top[0, 0] += (
        bend * (pin_y + pin * ay)
        + pin * (1 + slope * lift)
        + link[7]
        + c1 * link[8]
        + c2 * (link[9] + moment * turn_xx)
    )
    return Arrow(top, _turned(frame.left, dx, dy, bx, by, c2), frame.diagonal)


@compiled
def _turned(rows, dx, dy, bx, by, c2):
    """Columns for x_A and the rocking angle from those for the frame's acceleration and angle; the
    others as they are.

    (dx, dy) is the change of A's acceleration with x_A'' and (bx, by) that acceleration, in the
    body frame: it turns by c2.
    """
    out = np.empty((rows.shape[0], rows.shape[1] - 1))
    for j in range(len(out)):
        out[j, 0] = rows[j, 0] * dx + rows[j, 1] * dy
        out[j, 1] = rows[j, 2] + c2 * (rows[j, 0] * by - rows[j, 1] * bx)
        for i in range(2, out.shape[1]):
            out[j, i] = rows[j, 1 + i]
    return out


@compiled
def solve(arrow, right):
    """Solution of `arrow` x = right for two rigid motions: the modes eliminated, then found one by
    one.

    Parameters
    ----------
    arrow : Arrow
    right : ndarray, shape (2 + k,)

    Returns
    -------
    ndarray, shape (2 + k,)
    """
    top, left, diagonal = arrow.top, arrow.left, arrow.diagonal
    s00, s01, s10, s11, r0, r1 = top[0, 0], top[0, 1], top[1, 0], top[1, 1], right[0], right[1]
    for k in range(len(diagonal)):
        x, y = top[0, 2 + k] / diagonal[k], top[1, 2 + k] / diagonal[k]
        s00 -= x * left[k, 0]
        s01 -= x * left[k, 1]
        s10 -= y * left[k, 0]
        s11 -= y * left[k, 1]
        r0 -= x * right[2 + k]
        r1 -= y * right[2 + k]
    out, det = np.empty(len(right)), s00 * s11 - s01 * s10
    out[0], out[1] = (s11 * r0 - s01 * r1) / det, (s00 * r1 - s10 * r0) / det
    for k in range(len(diagonal)):
        out[2 + k] = (right[2 + k] - left[k, 0] * out[0] - left[k, 1] * out[1]) / diagonal[k]
    return out


@compiled
def size_of(arrow, a):
    """Square of a vector of accelerations in the norm of the tangent's diagonal."""
    total = abs(arrow.top[0, 0]) * a[0] ** 2 + abs(arrow.top[1, 1]) * a[1] ** 2
    for k in range(len(arrow.diagonal)):
        total += arrow.diagonal[k] * a[2 + k] ** 2
    return total


@compiled
def solve_coupled(arrow, coupling, right):
    """Solution x of the whole tangent, modes coupled, to 1e-13 of its size.

    Eq. (S1):  x <- arrow^-1 (right - coupling x)

    The coupling is small (Eq. (R4)), so that each pass gains about four digits, at the price of a
    product with it; a factorisation would cost as much as hundreds of passes.

    Parameters
    ----------
    arrow : Arrow
    coupling : ndarray, shape (k, k)
    right : ndarray, shape (2 + k,)

    Returns
    -------
    ndarray, shape (2 + k,)
        Starts with NaN where it does not converge.
    """
    x, left = solve(arrow, right), right.copy()
    for _ in range(40):
        push = coupling @ x[2:]
        for k in range(len(push)):
            left[2 + k] = right[2 + k] - push[k]  # Eq. (S1)
        fresh = solve(arrow, left)
        for k in range(len(x)):
            x[k] = fresh[k] - x[k]
        if size_of(arrow, x) <= 1e-26 * size_of(arrow, fresh):
            return fresh
        x = fresh
    x[0] = np.nan
    return x


@compiled
def settle(
    body, mechanism, load, place, rate, guess, crank_angle, crank_speed, crank_acceleration, c1, c2
):
    """End accelerations that balance the equations of motion to 1e-15 or so of their size, or of
    what places know of them.

    Newton's method with the part of the exact tangent that couples the rigid motion to everything
    and each mode to itself. What it leaves out, Coriolis and centrifugal coupling of modes, is
    smaller by 2 w c1, about 1e-4: each iteration gains three to four digits with the first tangent.
    Dry friction that nearly sticks asks for more: a change after which the next would not shrink is
    halved (natural monotonicity test, [Deuflhard2011] ch. 3), and where it shrinks slowly the
    tangent is made anew. In short steps of a calm motion the last digit of a place is worth more
    acceleration than that: then it decides.

    Parameters
    ----------
    body, mechanism, load
        As for `imbalance`.
    place, rate : ndarray, shape (2 + k,)
        Predicted with accelerations of zero.
    guess : ndarray, shape (2 + k,)
    crank_angle, crank_speed, crank_acceleration : float
        [rad], [rad/s], [rad/s2]
    c1, c2 : float
        [s], [s2]: what an acceleration of 1 adds to rate and place.

    Returns
    -------
    acceleration : ndarray, shape (2 + k,)
    pin_x, pin_y, moment, torque : float
        As for `imbalance`.
    evaluations, tangents : int
        How often residual (0 if it did not converge) and tangent were made.
    size : float
        Last change of the accelerations in the norm of the inertia; relative if it did not
        converge.
    """
    n = len(place)
    a, end, speed = guess.copy(), np.empty(n), np.empty(n)
    _move(end, speed, place, rate, a, c1, c2)
    arrow = tangent(
        body, mechanism, load, end, speed, a, crank_angle, crank_speed, crank_acceleration, c1, c2
    )
    change, size, total, share, tangents = np.zeros(n), 0.0, 0.0, 1.0, 1
    for evaluation in range(1, 80):
        residual, pin_x, pin_y, moment, torque = imbalance(
            body, mechanism, load, end, speed, a, crank_angle, crank_speed, crank_acceleration
        )
        noise = ROUND_OFF * np.sqrt(size_of(arrow, end)) / c2 if c2 > 0.0 else 0.0
        if evaluation > 1 and size <= 1e-11 * total + noise:
            return a, pin_x, pin_y, moment, torque, evaluation, tangents, size
        fresh = solve(arrow, residual)
        left = np.sqrt(size_of(arrow, fresh))
        if evaluation > 1 and left > (1 - share / 4) * size:
            share /= 2
            for k in range(n):
                a[k] += share * change[k]
        else:
            if evaluation > 1 and left > 0.1 * size:
                arrow = tangent(
                    body,
                    mechanism,
                    load,
                    end,
                    speed,
                    a,
                    crank_angle,
                    crank_speed,
                    crank_acceleration,
                    c1,
                    c2,
                )
                fresh = solve(arrow, residual)
                tangents += 1
            change, share = fresh, 1.0
            for k in range(n):
                a[k] -= change[k]
            size, total = np.sqrt(size_of(arrow, change)), np.sqrt(size_of(arrow, a))
        _move(end, speed, place, rate, a, c1, c2)
    return a, pin_x, pin_y, moment, torque, 0, tangents, size / total


@compiled
def _move(end, speed, place, rate, a, c1, c2):
    """End places and rates from predicted ones and the end accelerations."""
    for k in range(len(a)):
        end[k], speed[k] = place[k] + c2 * a[k], rate[k] + c1 * a[k]
