"""Equation of motion of the flexible piston on its crank, in minimal coordinates.

They are [x_A, rocking angle, modal coordinates].

A's height and the rod's angle follow from x_A and the crank angle, so that there are no constraints
and nothing drifts.

References
----------
[Deuflhard2011] P. Deuflhard, Newton Methods for Nonlinear Problems, Springer, 2011.
"""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compiled
from ..geometry.arrays import Vector
from .carrier import FIXED, Carrier, CarrierEffect, carried
from .floating_frame import (
    TURN,
    Arrow,
    FlexibleBody,
    FrameMotion,
    X,
    Y,
    frame_arrow,
    frame_force,
)
from .generalised_alpha import Motion, Prediction
from .pin_friction import friction_moment
from .slider_crank import CrankMotion, LateralMotion, Link, Mechanism, motion

LATERAL = 0
ROCKING = 1
"""Coordinates of the rigid piston: x_A [m] and the rocking angle [rad]; modal ones follow."""

RIGID = 2
"""Number of the rigid piston's coordinates."""

ROUND_OFF = 4e-15  # of a coordinate or a force: some last digits, of the sum of many terms


class Load(NamedTuple):
    """Forces on the piston at the end of a step.

    Parameters
    ----------
    lateral, axial : float
        Resultants along x and y, pin excepted [N].
    moment : float
        About A where x_A = 0, about +z [N m].
    guided : float
        Force along -y on the bore's axis, `axial` holds it too [N]: away from x_A = 0 its moment
        about A is larger by guided x_A.
    modal : ndarray, shape (k,)
        [kg^-1/2 N]
    carrier : Carrier
        Motion of the block at the same time.
    """

    lateral: float
    axial: float
    moment: float
    guided: float
    modal: Vector
    carrier: Carrier = FIXED


class Imbalance(NamedTuple):
    """Imbalance of the equations of motion, and the forces at both ends of the rod.

    Parameters
    ----------
    residual : ndarray, shape (2 + k,)
        [N], [N m], [kg^-1/2 N].
    pin_x, pin_y : float
        Force of the pin on the piston [N].
    pin_moment : float
        Of pin friction on the piston [N m].
    torque : float
        Torque that the drive exerts on the crank, positive in its direction of turning [N m].
    """

    residual: np.ndarray
    pin_x: float
    pin_y: float
    pin_moment: float
    torque: float


class Solution(NamedTuple):
    """End accelerations, the forces that go with them, and what it took to solve for them.

    Parameters
    ----------
    acceleration : ndarray, shape (2 + k,)
        [m/s2], [rad/s2], [kg^1/2 m/s2].
    lack : Imbalance
        With these accelerations.
    evaluations, tangents : int
        How often residual (0 if it did not converge) and tangent were made.
    change : float
        Last change of the accelerations in the norm of the inertia; relative if it did not
        converge.
    """

    acceleration: np.ndarray
    lack: Imbalance
    evaluations: int
    tangents: int
    change: float


class Posture(NamedTuple):
    """Mechanism and body frame at an instant.

    Parameters
    ----------
    link : Link
    cosine, sine : float
        Of the rocking angle [-].
    frame : FrameMotion
        In space.
    added : CarrierEffect
    """

    link: Link
    cosine: float
    sine: float
    frame: FrameMotion
    added: CarrierEffect


@compiled
def lateral_motion(now: Motion) -> LateralMotion:
    """Return the motion of A across the bore, from the piston's coordinates."""
    return LateralMotion(now.position[LATERAL], now.velocity[LATERAL], now.acceleration[LATERAL])


@compiled
def posture(mechanism: Mechanism, carrier: Carrier, now: Motion, crank: CrankMotion) -> Posture:
    """Return the position and motion of link, rod and the piston's frame.

    Parameters
    ----------
    mechanism : Mechanism
    carrier : Carrier
    now : Motion
        Of the piston, n = 2 + k.
    crank : CrankMotion

    Returns
    -------
    Posture
    """
    link = motion(mechanism, lateral_motion(now), crank)
    c = np.cos(now.position[ROCKING])
    s = np.sin(now.position[ROCKING])
    added = carried(mechanism, carrier, lateral_motion(now), crank)
    ax = now.acceleration[LATERAL] + added.x
    ay = link.axial_acceleration + added.y
    frame = FrameMotion(
        ax=c * ax + s * ay,
        ay=-s * ax + c * ay,
        alpha=now.acceleration[ROCKING] + carrier.alpha,
        w=now.velocity[ROCKING] + carrier.w,
        q=now.position[RIGID:],
        dq=now.velocity[RIGID:],
        ddq=now.acceleration[RIGID:],
    )
    return Posture(link, c, s, frame, added)


@compiled
def imbalance(
    body: FlexibleBody, mechanism: Mechanism, load: Load, now: Motion, crank: CrankMotion
) -> Imbalance:
    """Return the residual of the equations of motion.

    Eq. (D5):  x_A:    e . (R F + m_pin A'') + rod + M psi_x - (load_x + Y_x load_y) = 0
               angle:  frame moment - M - (moment + guided x_A) = 0
               modes:  frame modal force - modal = 0         e = (1, Y_x),  A'' = (x_A'', Y'')
    with F, the frame's rows (Eq. (D1) to (D3)) at a = R^T A'', R the rotation by the rocking angle;
    M, the moment of pin friction (Eq. (K7)); psi, the rod's angle. Accelerations are those in
    space: the block's motion adds to them by Eq. (K14), to the rod's forces by Eq. (K15).

    Parameters
    ----------
    body : FlexibleBody
    mechanism : Mechanism
    load : Load
    now : Motion
        n = 2 + k: [x_A [m], rocking angle [rad], modal coordinates [kg^1/2 m]].
    crank : CrankMotion

    Returns
    -------
    Imbalance
    """
    at = posture(mechanism, load.carrier, now, crank)
    link = at.link
    c = at.cosine
    s = at.sine
    force = frame_force(body, at.frame)
    pin_x = c * force.x - s * force.y - load.lateral
    pin_y = s * force.x + c * force.y - load.axial
    slip = now.velocity[ROCKING] - link.rod.velocity
    moment = friction_moment(mechanism.friction, pin_x, pin_y, slip).moment
    pull_x = pin_x + mechanism.pin_mass * (now.acceleration[LATERAL] + at.added.x)
    pull_y = pin_y + mechanism.pin_mass * (link.axial_acceleration + at.added.y)

    residual = np.empty(len(now.position))
    # Eq. (D5)
    rod_force = link.rod_force + at.added.rod_force
    residual[LATERAL] = pull_x + link.slope * pull_y + rod_force + moment * link.rod.slope
    turning = load.moment + load.guided * now.position[LATERAL]
    residual[ROCKING] = force.moment - moment - turning
    for k in range(len(load.modal)):
        residual[RIGID + k] = force.modal[k] - load.modal[k]

    r = mechanism.crank_radius
    lever = -r * np.sin(crank.angle) + link.slope * r * np.cos(crank.angle)
    rod_moment = link.rod_moment + at.added.rod_moment
    torque = pull_y * lever + rod_moment + moment * link.rod.lever
    return Imbalance(residual, pin_x, pin_y, moment, torque)


@compiled
def tangent(
    body: FlexibleBody,
    mechanism: Mechanism,
    load: Load,
    now: Motion,
    crank: CrankMotion,
    c1: float,
    c2: float,
) -> Arrow:
    """Compute the derivative of the residual (Eq. (D5)) by the end accelerations.

    Each one changes its velocity by c1 and its position by c2. `floating_frame.mode_coupling` is
    omitted. The contribution of the block's motion is constant over A's position. This omits a
    share 2 w c1, w the block's angular velocity, about 1e-5.

    Parameters
    ----------
    body, mechanism, load, now, crank
        As for `imbalance`.
    c1, c2 : float
        `Coefficients.to_velocity` [s], `Coefficients.to_position` [s2].

    Returns
    -------
    Arrow
        Of two rigid motions.
    """
    at = posture(mechanism, load.carrier, now, crank)
    link = at.link
    rod = link.rod
    c = at.cosine
    s = at.sine
    force = frame_force(body, at.frame)
    frame = frame_arrow(body, at.frame, c1, c2)
    pin_x = c * force.x - s * force.y - load.lateral
    pin_y = s * force.x + c * force.y - load.axial
    slip = now.velocity[ROCKING] - rod.velocity
    friction = friction_moment(mechanism.friction, pin_x, pin_y, slip)

    axial = link.axial_by_acceleration + c1 * link.axial_by_velocity + c2 * link.axial_by_position
    dx = c + s * axial  # dA''/dx_A'' in the body frame
    dy = -s + c * axial
    rows = _by_coordinates(frame.top, dx, dy, at.frame.ax, at.frame.ay, c2)
    rows[X, ROCKING] -= c2 * force.y  # the force turns with the frame
    rows[Y, ROCKING] += c2 * force.x

    slip_by_lateral = -c1 * rod.slope - c2 * rod.velocity_slope
    top = np.empty((RIGID, len(now.position)))
    for i in range(len(now.position)):
        px = c * rows[X, i] - s * rows[Y, i]
        py = s * rows[X, i] + c * rows[Y, i]
        change = friction.by_x * px + friction.by_y * py
        if i == LATERAL:
            change += friction.by_slip * slip_by_lateral
        elif i == ROCKING:
            change += friction.by_slip * c1
        top[LATERAL, i] = px + link.slope * py + rod.slope * change
        top[ROCKING, i] = rows[TURN, i] - change

    top[ROCKING, LATERAL] -= c2 * load.guided
    pin = mechanism.pin_mass
    bend = c2 * link.curvature
    top[LATERAL, LATERAL] += (
        bend * (pin_y + pin * (link.axial_acceleration + at.added.y))
        + pin * (1 + link.slope * axial)
        + link.rod_force_by_acceleration
        + c1 * link.rod_force_by_velocity
        + c2 * (link.rod_force_by_position + friction.moment * rod.curvature)
    )
    left = _by_coordinates(frame.left, dx, dy, at.frame.ax, at.frame.ay, c2)
    return Arrow(top, left, frame.diagonal)


@compiled
def _by_coordinates(rows, dx, dy, ax, ay, c2):
    """Return columns for x_A and the rocking angle from those of the frame's motion.

    The other columns do not change.

    (dx, dy) is the change of A's acceleration with x_A'' and (ax, ay) that acceleration, in the
    body frame: it turns by c2.
    """
    out = np.empty((rows.shape[0], rows.shape[1] - 1))
    for j in range(len(out)):
        out[j, LATERAL] = rows[j, X] * dx + rows[j, Y] * dy
        out[j, ROCKING] = rows[j, TURN] + c2 * (rows[j, X] * ay - rows[j, Y] * ax)
        for i in range(RIGID, out.shape[1]):
            out[j, i] = rows[j, 1 + i]
    return out


@compiled
def solve(arrow: Arrow, right: np.ndarray) -> np.ndarray:
    """Return x of `arrow` x = right for two rigid motions, with the modes eliminated.

    Parameters
    ----------
    arrow : Arrow
    right : ndarray, shape (2 + k,)

    Returns
    -------
    ndarray, shape (2 + k,)
    """
    top = arrow.top
    left = arrow.left
    diagonal = arrow.diagonal
    s00 = top[0, 0]
    s01 = top[0, 1]
    s10 = top[1, 0]
    s11 = top[1, 1]
    r0 = right[0]
    r1 = right[1]
    for k in range(len(diagonal)):
        x = top[0, RIGID + k] / diagonal[k]
        y = top[1, RIGID + k] / diagonal[k]
        s00 -= x * left[k, 0]
        s01 -= x * left[k, 1]
        s10 -= y * left[k, 0]
        s11 -= y * left[k, 1]
        r0 -= x * right[RIGID + k]
        r1 -= y * right[RIGID + k]
    determinant = s00 * s11 - s01 * s10
    out = np.empty(len(right))
    out[0] = (s11 * r0 - s01 * r1) / determinant
    out[1] = (s00 * r1 - s10 * r0) / determinant
    for k in range(len(diagonal)):
        rest = right[RIGID + k] - left[k, 0] * out[0] - left[k, 1] * out[1]
        out[RIGID + k] = rest / diagonal[k]
    return out


@compiled
def squared_size(arrow: Arrow, a: np.ndarray) -> float:
    """Return the square of accelerations in the norm of the tangent's diagonal."""
    total = abs(arrow.top[0, 0]) * a[0] ** 2 + abs(arrow.top[1, 1]) * a[1] ** 2
    for k in range(len(arrow.diagonal)):
        total += arrow.diagonal[k] * a[RIGID + k] ** 2
    return total


@compiled
def solve_coupled(arrow: Arrow, coupling: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Return x of the whole tangent, modes coupled, to 1e-13 of its size.

    Eq. (N3):  x <- arrow^-1 (right - coupling x)

    The coupling is small (Eq. (D4)), so that each pass gains about four digits, at the price of a
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
    x = solve(arrow, right)
    left = right.copy()
    for _ in range(40):
        push = coupling @ x[RIGID:]
        for k in range(len(push)):
            left[RIGID + k] = right[RIGID + k] - push[k]  # Eq. (N3)
        fresh = solve(arrow, left)
        for k in range(len(x)):
            x[k] = fresh[k] - x[k]
        if squared_size(arrow, x) <= 1e-26 * squared_size(arrow, fresh):
            return fresh
        x = fresh
    x[0] = np.nan
    return x


@compiled
def end_accelerations(
    body: FlexibleBody,
    mechanism: Mechanism,
    load: Load,
    predicted: Prediction,
    guess: np.ndarray,
    crank: CrankMotion,
    c1: float,
    c2: float,
) -> Solution:
    """Solve for the end accelerations that fulfil the equations of motion.

    The error is about 1e-15 of their size, or the round-off of positions.

    Newton's method with the part of the exact tangent that couples the rigid motion to everything
    and each mode to itself. What it leaves out, Coriolis and centrifugal coupling of modes, is
    smaller by 2 w c1, about 1e-4: each iteration gains three to four digits with the first tangent.
    Dry friction that nearly sticks asks for more: a change after which the next would not shrink is
    halved (natural monotonicity test, [Deuflhard2011] ch. 3), and where it shrinks slowly the
    tangent is made anew. In short steps of a calm motion the last digit of a position is worth more
    acceleration than that, and where forces balance so is the last digit of a force: then these
    decide.

    Parameters
    ----------
    body, mechanism, load
        As for `imbalance`.
    predicted : Prediction
        With accelerations of zero, n = 2 + k.
    guess : ndarray, shape (2 + k,)
        Accelerations to start from.
    crank : CrankMotion
    c1, c2 : float
        What an acceleration of 1 adds to velocity [s] and position [s2].

    Returns
    -------
    Solution
    """
    n = len(guess)
    a = guess.copy()
    now = Motion(np.empty(n), np.empty(n), a)
    _move(now, predicted, c1, c2)
    arrow = tangent(body, mechanism, load, now, crank, c1, c2)
    tangents = 1
    change = np.zeros(n)
    size = 0.0
    total = 0.0
    share = 1.0
    for evaluation in range(1, 80):
        lack = imbalance(body, mechanism, load, now, crank)
        noise = np.sqrt(squared_size(arrow, now.position)) / c2 if c2 > 0.0 else 0.0
        noise += _size_of_terms(body, mechanism, load, now, crank, arrow)
        if evaluation > 1 and size <= 1e-11 * total + ROUND_OFF * noise:
            return Solution(a, lack, evaluation, tangents, size)
        fresh = solve(arrow, lack.residual)
        left = np.sqrt(squared_size(arrow, fresh))
        if evaluation > 1 and left > (1 - share / 4) * size:
            share /= 2
            for k in range(n):
                a[k] += share * change[k]
        else:
            if evaluation > 1 and left > 0.1 * size:
                arrow = tangent(body, mechanism, load, now, crank, c1, c2)
                fresh = solve(arrow, lack.residual)
                tangents += 1
            change = fresh
            share = 1.0
            for k in range(n):
                a[k] -= change[k]
            size = np.sqrt(squared_size(arrow, change))
            total = np.sqrt(squared_size(arrow, a))
        _move(now, predicted, c1, c2)
    return Solution(a, lack, 0, tangents, size / total)


@compiled
def _size_of_terms(body, mechanism, load, now, crank, arrow):
    """Return the size of accelerations if no forces cancelled, in the norm of `squared_size`.

    The round-off of the residual is a share of it.
    """
    link = motion(mechanism, lateral_motion(now), crank)
    climb = abs(link.axial_acceleration)
    pin = abs(load.axial) + (body.mass + mechanism.pin_mass) * climb
    lateral = abs(load.lateral) + abs(link.rod_force) + mechanism.rod_mass * climb + pin
    guided = abs(load.guided * now.position[LATERAL])
    first_moment = abs(body.S[X]) + abs(body.S[Y])
    turning = abs(load.moment) + guided + first_moment * climb + mechanism.friction.lever * pin
    total = lateral**2 / abs(arrow.top[0, 0]) + turning**2 / abs(arrow.top[1, 1])
    for k in range(len(load.modal)):
        spring = body.stiffness[k] * abs(now.position[RIGID + k])
        force = abs(load.modal[k]) + abs(body.T[Y, k]) * climb + spring
        total += force**2 / arrow.diagonal[k]
    return np.sqrt(total)


@compiled
def _move(now, predicted, c1, c2):
    """Put positions and velocities where the end accelerations take the predicted ones."""
    position = now.position
    velocity = now.velocity
    acceleration = now.acceleration
    predicted_position = predicted.position
    predicted_velocity = predicted.velocity
    for k in range(len(acceleration)):
        position[k] = predicted_position[k] + c2 * acceleration[k]
        velocity[k] = predicted_velocity[k] + c1 * acceleration[k]
