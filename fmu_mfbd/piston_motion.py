"""Equation of motion of the flexible piston on its crank, in minimal coordinates [x_A, rocking angle, modal coordinates].

A's height and the rod's angle follow from x_A and the crank angle, so that there are no constraints and nothing drifts.
"""

from typing import NamedTuple

import numpy as np

from .compiled import compiled
from .floating_frame import frame_force, frame_tangent
from .slider_crank import motion


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


@compiled()
def imbalance(body, mechanism, load, place, rate, acceleration, crank_angle, crank_speed, crank_acceleration):
    """Residual of the equations of motion.

    Eq. (M1):  x_A:   e . (R F + m_pin A'') + rod - (load_x + Y_x load_y) = 0          e = (1, Y_x),  A'' = (x_A'', Y'')
               angle: frame moment - moment = 0,   modes: frame modal force - modal = 0
    with F, the frame's rows (Eq. (R1) to (R3)) at a = R^T A'', R the rotation by the rocking angle.

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
    torque : float
        Torque that the drive exerts on the crank, positive in its direction of turning [N m].
    """
    r = mechanism.crank_radius
    link = motion(mechanism, place[0], rate[0], acceleration[0], crank_angle, crank_speed, crank_acceleration)
    ax, ay, slope = acceleration[0], link[0], link[4]
    c, s = np.cos(place[1]), np.sin(place[1])
    frame = frame_force(body, c * ax + s * ay, -s * ax + c * ay, acceleration[1], rate[1], place[2:], rate[2:], acceleration[2:])
    pin_x = c * frame[0] - s * frame[1] - load.lateral
    pin_y = s * frame[0] + c * frame[1] - load.axial
    pull_x, pull_y = pin_x + mechanism.pin_mass * ax, pin_y + mechanism.pin_mass * ay
    residual = np.empty(len(place))
    residual[0] = pull_x + slope * pull_y + link[6]                                                             # Eq. (M1)
    residual[1] = frame[2] - load.moment
    for k in range(len(load.modal)):
        residual[2 + k] = frame[3 + k] - load.modal[k]
    lever = -r * np.sin(crank_angle) + slope * r * np.cos(crank_angle)
    return residual, pin_x, pin_y, pull_y * lever + link[10]


@compiled()
def tangent(body, mechanism, load, place, rate, acceleration, crank_angle, crank_speed, crank_acceleration, c1, c2):
    """Derivative of the residual (Eq. (M1)) when each end acceleration moves its velocity by c1 [s] and its place by c2 [s2].

    Parameters
    ----------
    body, mechanism, load, place, rate, acceleration, crank_angle, crank_speed, crank_acceleration
        As for `imbalance`.
    c1, c2 : float
        `Coefficients.rate` and `Coefficients.place` of the time integrator.

    Returns
    -------
    ndarray, shape (2 + k, 2 + k)
    """
    link = motion(mechanism, place[0], rate[0], acceleration[0], crank_angle, crank_speed, crank_acceleration)
    lift = link[1] + c1 * link[2] + c2 * link[3]
    slope, bend = link[4], c2 * link[5]
    c, s = np.cos(place[1]), np.sin(place[1])
    ax, ay = acceleration[0], link[0]
    bx, by = c * ax + s * ay, -s * ax + c * ay
    q, dq, ddq = place[2:], rate[2:], acceleration[2:]
    force = frame_force(body, bx, by, acceleration[1], rate[1], q, dq, ddq)
    frame = frame_tangent(body, bx, by, acceleration[1], rate[1], q, dq, ddq, c1, c2)
    ex, ey = c + s * slope, -s + c * slope                  # e in the body frame
    dx, dy = c + s * lift, -s + c * lift                    # dA''/dx_A'' in the body frame
    out = np.empty((len(place), len(place)))
    for i in range(1, len(place)):
        out[i, 0] = frame[1 + i, 0] * dx + frame[1 + i, 1] * dy
        out[i, 1] = frame[1 + i, 2] + c2 * (frame[1 + i, 0] * by - frame[1 + i, 1] * bx)
        out[0, i] = ex * frame[0, 1 + i] + ey * frame[1, 1 + i]
        for j in range(2, len(place)):
            out[i, j] = frame[1 + i, 1 + j]
    pin = mechanism.pin_mass
    vertical = s * force[0] + c * force[1] + pin * ay - load.axial
    rod = link[7] + c1 * link[8] + c2 * link[9]
    out[0, 0] = body.mass * (ex * dx + ey * dy) + bend * vertical + pin * (1 + slope * lift) + rod
    out[0, 1] += c2 * (body.mass * (ex * by - ey * bx) + ey * force[0] - ex * force[1])
    return out


@compiled()
def settle(body, mechanism, load, place, rate, guess, crank_angle, crank_speed, crank_acceleration, c1, c2):
    """End accelerations that balance the equations of motion to 1e-15 or so of their size.

    Newton's method with the part of the exact tangent that couples the rigid motion to everything and each mode to itself. What
    it leaves out, Coriolis and centrifugal coupling of modes, is smaller by 2 w c1, about 1e-4: each iteration gains four digits.

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
    pin_x, pin_y, torque : float
        As for `imbalance`.
    evaluations : int
        Of the residual; 0 if it did not converge.
    size : float
        Last change of the accelerations in the norm of the inertia; relative if it did not converge.
    """
    n = len(place)
    a, end, speed = guess.copy(), np.empty(n), np.empty(n)
    _move(end, speed, place, rate, a, c1, c2)
    matrix = tangent(body, mechanism, load, end, speed, a, crank_angle, crank_speed, crank_acceleration, c1, c2)
    # rigid motions with the modes eliminated: [s00 s01; s10 s11]
    s00, s01, s10, s11 = matrix[0, 0], matrix[0, 1], matrix[1, 0], matrix[1, 1]
    for k in range(2, n):
        s00 -= matrix[0, k] * matrix[k, 0] / matrix[k, k]
        s01 -= matrix[0, k] * matrix[k, 1] / matrix[k, k]
        s10 -= matrix[1, k] * matrix[k, 0] / matrix[k, k]
        s11 -= matrix[1, k] * matrix[k, 1] / matrix[k, k]
    det = s00 * s11 - s01 * s10
    size, total = 0.0, 0.0
    for evaluation in range(1, 40):
        residual, pin_x, pin_y, torque = imbalance(body, mechanism, load, end, speed, a,
                                                   crank_angle, crank_speed, crank_acceleration)
        if evaluation > 1 and size <= 1e-11 * total:
            return a, pin_x, pin_y, torque, evaluation, size
        r0, r1 = residual[0], residual[1]
        for k in range(2, n):
            part = residual[k] / matrix[k, k]
            r0 -= matrix[0, k] * part
            r1 -= matrix[1, k] * part
        d0, d1 = (s11 * r0 - s01 * r1) / det, (s00 * r1 - s10 * r0) / det
        a[0] -= d0
        a[1] -= d1
        m0, m1 = abs(matrix[0, 0]), abs(matrix[1, 1])
        square, whole = m0 * d0 * d0 + m1 * d1 * d1, m0 * a[0] ** 2 + m1 * a[1] ** 2
        for k in range(2, n):
            d = (residual[k] - matrix[k, 0] * d0 - matrix[k, 1] * d1) / matrix[k, k]
            a[k] -= d
            square += matrix[k, k] * d * d
            whole += matrix[k, k] * a[k] * a[k]
        size, total = np.sqrt(square), np.sqrt(whole)
        _move(end, speed, place, rate, a, c1, c2)
    return a, pin_x, pin_y, torque, 0, size / total


@compiled()
def _move(end, speed, place, rate, a, c1, c2):
    """End places and rates from predicted ones and the end accelerations."""
    for k in range(len(a)):
        end[k], speed[k] = place[k] + c2 * a[k], rate[k] + c1 * a[k]
