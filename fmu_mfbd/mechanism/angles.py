"""Angles of the bodies of a chain: how each follows, and its rows in the equations of motion.

The angle of a body is driven, a coordinate, the sum of both, or that of a rod that swings. A new
kind of angle needs its members in `chain.Joints` and a branch in each function of this file:
motion, derivative of the motion, row of the residual, derivative of the row.
"""

import numpy as np

from ...master.fmi.compiled import compilable
from ..dynamics.floating_frame import TURN, X


@compilable
def put_angle(joints, b, now, drive, at):
    """Write the angle of body b and its rates into the motion `at`, which has those of its origin.

    Eq. (K42):  sin chi = (x - x_T)/L,   chi' = (x' - x_T')/(L cos chi)
                chi'' = (x'' - x_T'' + L sin chi chi'^2)/(L cos chi)
                of a rod with its origin at x and its tip at x_T, linear in the coordinates
    """
    length = joints.rod_length[b]
    if length == 0.0:
        angle = joints.driven[b] * drive.angle
        at.velocity[b, TURN] = joints.driven[b] * drive.speed
        at.acceleration[b, TURN] = joints.driven[b] * drive.acceleration
        k = joints.angle[b]
        if k >= 0:
            angle += now.position[k]
            at.velocity[b, TURN] += now.velocity[k]
            at.acceleration[b, TURN] += now.acceleration[k]
        at.axes[b, 0], at.axes[b, 1] = np.cos(angle), np.sin(angle)
        return
    x, v, a = joints.offset[b], 0.0, 0.0
    for j in range(joints.tip.shape[1]):
        x += joints.tip[b, j] * now.position[j]
        v += joints.tip[b, j] * now.velocity[j]
        a += joints.tip[b, j] * now.acceleration[j]
    # Eq. (K42)
    sine = (at.position[b, X] - x) / length
    cosine = np.sqrt(1 - sine * sine)
    w = (at.velocity[b, X] - v) / (length * cosine)
    at.axes[b, 0], at.axes[b, 1] = cosine, sine
    at.velocity[b, TURN] = w
    at.acceleration[b, TURN] = (at.acceleration[b, X] - a + length * sine * w * w) / (
        length * cosine
    )


@compilable
def put_angle_changes(joints, b, at, by, d):
    """Write the change of the angle of body b with all unknowns of joints into `d`."""
    k = joints.angle[b]
    if joints.rod_length[b] == 0.0:
        if k >= 0:
            d.position[b, TURN, k] = by.position[k]
            d.velocity[b, TURN, k] = by.velocity[k]
            d.acceleration[b, TURN, k] = by.acceleration[k]
        return
    along, aside = joints.rod_length[b] * at.axes[b, 0], joints.rod_length[b] * at.axes[b, 1]
    w, alpha = at.velocity[b, TURN], at.acceleration[b, TURN]
    for j in range(joints.tip.shape[1]):
        # Eq. (K42)
        tip = joints.tip[b, j]
        t = (d.position[b, X, j] - tip * by.position[j]) / along
        dw = (d.velocity[b, X, j] - tip * by.velocity[j] + w * aside * t) / along
        da = d.acceleration[b, X, j] - tip * by.acceleration[j] + 2 * aside * w * dw
        d.position[b, TURN, j] = t
        d.velocity[b, TURN, j] = dw
        d.acceleration[b, TURN, j] = (da + (along * w * w + alpha * aside) * t) / along


@compilable
def add_angle_row(joints, b, at, moment, force, residual):
    """Add the moment that body b needs to its row, and return its part of the drive's torque.

    A rod is held at its tip: the force there is added to `force` of the rod.
    """
    if joints.rod_length[b] > 0.0:
        push = moment / (joints.rod_length[b] * at.axes[b, 0])
        for j in range(joints.tip.shape[1]):
            residual[j] -= joints.tip[b, j] * push
        force[b, X] += push
        return 0.0
    if joints.angle[b] >= 0:
        residual[joints.angle[b]] += moment
    return joints.driven[b] * moment


@compilable
def add_angle_row_changes(joints, b, at, force, d, change, top, torque):
    """Add the derivative of `add_angle_row` to that of the rows, `top`, and of the torque."""
    columns = change.shape[2]
    if joints.rod_length[b] > 0.0:
        along = joints.rod_length[b] * at.axes[b, 0]
        by_turn = force[b, TURN] * at.axes[b, 1] / (along * at.axes[b, 0])
        push = np.empty(columns)
        for j in range(columns):
            push[j] = change[b, TURN, j] / along
        for j in range(d.position.shape[2]):
            push[j] += by_turn * d.position[b, TURN, j]
        for j in range(columns):
            change[b, X, j] += push[j]
        for i in range(joints.tip.shape[1]):
            tip = joints.tip[b, i]
            if tip != 0.0:
                for j in range(columns):
                    top[i, j] -= tip * push[j]
        return
    if joints.driven[b] != 0.0:
        for j in range(columns):
            torque[j] += joints.driven[b] * change[b, TURN, j]
    i = joints.angle[b]
    if i >= 0:
        for j in range(columns):
            top[i, j] += change[b, TURN, j]
