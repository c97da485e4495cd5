"""Equation of motion of the flexible piston on its crank, in minimal coordinates [x_A, rocking angle, modal coordinates].

A's height and the rod's angle follow from x_A and the crank angle, so that there are no constraints and nothing drifts.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

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


@njit(cache=True)
def imbalance(body, mechanism, load, place, rate, acceleration, crank_angle, crank_speed):
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
    crank_angle, crank_speed : float
        [rad], [rad/s]

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
    link = motion(mechanism, place[0], rate[0], acceleration[0], crank_angle, crank_speed)
    ax, ay, slope = acceleration[0], link[0], link[4]
    c, s = np.cos(place[1]), np.sin(place[1])
    frame = frame_force(body, c * ax + s * ay, -s * ax + c * ay, acceleration[1], rate[1], place[2:], rate[2:], acceleration[2:])
    pin_x = c * frame[0] - s * frame[1] - load.lateral
    pin_y = s * frame[0] + c * frame[1] - load.axial
    pull_x, pull_y = pin_x + mechanism.pin_mass * ax, pin_y + mechanism.pin_mass * ay
    residual = np.empty(len(place))
    residual[0] = pull_x + slope * pull_y + link[6]                                                             # Eq. (M1)
    residual[1] = frame[2] - load.moment
    residual[2:] = frame[3:] - load.modal
    lever = -r * np.sin(crank_angle) + slope * r * np.cos(crank_angle)
    return residual, pin_x, pin_y, pull_y * lever + link[10]


@njit(cache=True)
def tangent(body, mechanism, load, place, rate, acceleration, crank_angle, crank_speed, c1, c2):
    """Derivative of the residual (Eq. (M1)) when each end acceleration moves its velocity by c1 [s] and its place by c2 [s2].

    Parameters
    ----------
    body, mechanism, load, place, rate, acceleration, crank_angle, crank_speed
        As for `imbalance`.
    c1, c2 : float
        `Coefficients.rate` and `Coefficients.place` of the time integrator.

    Returns
    -------
    ndarray, shape (2 + k, 2 + k)
    """
    link = motion(mechanism, place[0], rate[0], acceleration[0], crank_angle, crank_speed)
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
    out[0, 0] = body.mass * (ex * dx + ey * dy) + bend * vertical + pin * (1 + slope * lift) + link[7] + c1 * link[8] + c2 * link[9]
    out[0, 1] += c2 * (body.mass * (ex * by - ey * bx) + ey * force[0] - ex * force[1])
    return out
