"""Angles of the bodies of a chain: how each follows, and its rows in the equations of motion.

The angle of a body is driven, a coordinate, the sum of both, or that of a rod that swings. A new
kind of angle needs its members in `chain.Joints` and a branch in each function of this file:
motion, derivative of the motion, row of the residual, derivative of the row.
"""

import numpy as np

from ...master.fmi.compiled import compilable
from .chain import IN_PARENT
from .floating_frame import TURN, X, Y
from .translations import slide_direction, sliding_of


@compilable
def put_angle(joints, b, now, drive, at):
    """Write the angle of body b and its rates into the motion `at`, which has those of its origin.

    Eq. (K42):  x + (R h)_x = x_T,   R = R(chi),   h the rod's tip with its slides u
                chi' = (x' - x_T' + (R u')_x)/(R h)_y
                chi'' = (x'' - x_T'' + (R u'')_x - 2 chi' (R u')_y - chi'^2 (R h)_x)/(R h)_y
                of a rod with its origin at x and its tip at x_T, linear in the coordinates
    """
    tip_body = joints.tip_body[b]
    if tip_body < 0:
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
    own = sliding_of(joints, tip_body, IN_PARENT, now)
    across, length = joints.marker[tip_body, X] + own.x, joints.marker[tip_body, Y] + own.y
    reach = np.sqrt(length * length + across * across)
    c, s = length / reach, across / reach
    sine = (at.position[b, X] - x) / reach
    cosine = np.sqrt(1 - sine * sine)
    cosine, sine = c * cosine - s * sine, c * sine + s * cosine
    arm_x, arm_y = cosine * across - sine * length, sine * across + cosine * length
    vx, vy = cosine * own.vx - sine * own.vy, sine * own.vx + cosine * own.vy
    w = (at.velocity[b, X] - v + vx) / arm_y
    at.axes[b, 0], at.axes[b, 1] = cosine, sine
    at.velocity[b, TURN] = w
    sliding = cosine * own.ax - sine * own.ay - 2 * w * vy
    at.acceleration[b, TURN] = (at.acceleration[b, X] - a - arm_x * w * w + sliding) / arm_y


@compilable
def put_angle_changes(joints, b, at, by, d):
    """Write the change of the angle of body b with all unknowns of joints into `d`."""
    k, tip_body = joints.angle[b], joints.tip_body[b]
    if tip_body < 0:
        if k >= 0:
            d.position[b, TURN, k] = by.position[k]
            d.velocity[b, TURN, k] = by.velocity[k]
            d.acceleration[b, TURN, k] = by.acceleration[k]
        return
    along, aside = at.arm[tip_body, Y], -at.arm[tip_body, X]
    w, alpha = at.velocity[b, TURN], at.acceleration[b, TURN]
    vx, vy, _, ay = at.sliding[tip_body]
    for j in range(joints.tip.shape[1]):
        # Eq. (K42)
        tip, ex, ey = joints.tip[b, j], 0.0, 0.0
        for i in range(joints.first_slide[tip_body], joints.first_slide[tip_body + 1]):
            if joints.slide[i] == j and joints.turns[i] == IN_PARENT:
                ex, ey = slide_direction(joints, i, b, at)
        dx, dv, da = (ex - tip) * by.position[j], (ex - tip) * by.velocity[j], 0.0
        t = (d.position[b, X, j] + dx) / along
        longer = ey * by.position[j] - aside * t
        dw = (d.velocity[b, X, j] + dv - w * longer - vy * t) / along
        further = ex * by.position[j] - along * t
        da = d.acceleration[b, X, j] + (ex - tip) * by.acceleration[j] + 2 * aside * w * dw
        da -= 2 * (dw * vy + w * (t * vx + ey * by.velocity[j])) + t * ay
        d.position[b, TURN, j] = t
        d.velocity[b, TURN, j] = dw
        d.acceleration[b, TURN, j] = (da - w * w * further - alpha * longer) / along


@compilable
def add_angle_row(joints, b, at, moment, force, residual):
    """Add the moment that body b needs to its row, and return its part of the drive's torque.

    A rod is held at its tip: the force there is added to `force` of the rod.
    """
    tip_body = joints.tip_body[b]
    if tip_body >= 0:
        push = moment / at.arm[tip_body, Y]
        for j in range(joints.tip.shape[1]):
            residual[j] -= joints.tip[b, j] * push
        for k in range(joints.first_slide[tip_body], joints.first_slide[tip_body + 1]):
            if joints.turns[k] == IN_PARENT:
                x, _ = slide_direction(joints, k, b, at)
                residual[joints.slide[k]] += x * push
        force[b, X] += push
        return 0.0
    if joints.angle[b] >= 0:
        residual[joints.angle[b]] += moment
    return joints.driven[b] * moment


@compilable
def add_angle_row_changes(joints, b, at, force, d, change, top, torque):
    """Add the derivative of `add_angle_row` to that of the rows, `top`, and of the torque."""
    columns = change.shape[2]
    if joints.tip_body[b] >= 0:
        _add_tip_changes(joints, b, at, force, d, change, top)
        return
    if joints.driven[b] != 0.0:
        for j in range(columns):
            torque[j] += joints.driven[b] * change[b, TURN, j]
    i = joints.angle[b]
    if i >= 0:
        for j in range(columns):
            top[i, j] += change[b, TURN, j]


@compilable
def _add_tip_changes(joints, b, at, force, d, change, top):
    """Add the derivative of the force that holds the tip of a rod."""
    columns, tip_body = change.shape[2], joints.tip_body[b]
    along, push = at.arm[tip_body, Y], np.empty(change.shape[2])
    by_length = force[b, TURN] / (along * along)
    for j in range(columns):
        push[j] = change[b, TURN, j] / along
    for j in range(d.position.shape[2]):
        push[j] -= by_length * at.arm[tip_body, X] * d.position[b, TURN, j]
    for k in range(joints.first_slide[tip_body], joints.first_slide[tip_body + 1]):
        if joints.turns[k] == IN_PARENT and joints.slide[k] < columns:
            _, y = slide_direction(joints, k, b, at)
            push[joints.slide[k]] -= by_length * y * d.by.position[joints.slide[k]]
    for j in range(columns):
        change[b, X, j] += push[j]
    for i in range(joints.tip.shape[1]):
        tip = joints.tip[b, i]
        if tip != 0.0:
            for j in range(columns):
                top[i, j] -= tip * push[j]
    for k in range(joints.first_slide[tip_body], joints.first_slide[tip_body + 1]):
        if joints.turns[k] == IN_PARENT:
            i = joints.slide[k]
            x, y = slide_direction(joints, k, b, at)
            for j in range(columns):
                top[i, j] += x * push[j]
            for j in range(d.position.shape[2]):
                top[i, j] -= y * force[b, TURN] / along * d.position[b, TURN, j]
