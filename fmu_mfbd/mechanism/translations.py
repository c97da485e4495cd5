"""Translations of the joints of a chain: motion of the bodies, and rows in the equations.

A joint slides along directions with one coordinate each, which are fixed in the axes of the parent
or of the block (`chain.Joints`). A coordinate can be a play in a film, a guide or a slider.

Functions use b for the number of a body, k for a slide, and p for the parent. `at` is the
`ChainMotion`, `now` the motion in all coordinates, `by` the `Increments`, and `d` the
`MotionChanges`.
"""

from typing import NamedTuple

from ...master.fmi.compiled import compilable
from .chain import IN_BLOCK, IN_PARENT, Joints
from .floating_frame import TURN, X, Y
from .generalised_alpha import Motion


class Sliding(NamedTuple):
    """Position of a body in its joint and its rates, in the axes of the slides [m], [m/s], [m/s2].

    Parameters
    ----------
    x, y, vx, vy, ax, ay : float
    """

    x: float
    y: float
    vx: float
    vy: float
    ax: float
    ay: float


@compilable
def sliding_of(joints: Joints, b: int, axes: int, now: Motion) -> Sliding:
    """Return the sum of all slides of body b in `axes`, `IN_BLOCK` or `IN_PARENT`."""
    x, y, vx, vy, ax, ay = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(joints.first_slide[b], joints.first_slide[b + 1]):
        if joints.turns[k] == axes:
            i, along, aside = joints.slide[k], joints.direction[k, X], joints.direction[k, Y]
            x += along * now.position[i]
            y += aside * now.position[i]
            vx += along * now.velocity[i]
            vy += aside * now.velocity[i]
            ax += along * now.acceleration[i]
            ay += aside * now.acceleration[i]
    return Sliding(x=x, y=y, vx=vx, vy=vy, ax=ax, ay=ay)


@compilable
def slide_direction(joints: Joints, k: int, p: int, at) -> tuple[float, float]:
    """Return the direction of slide k of a joint in the block's axes [-]; p is its parent."""
    x, y = joints.direction[k, X], joints.direction[k, Y]
    if p < 0 or joints.turns[k] == IN_BLOCK:
        return x, y
    c, s = at.axes[p, 0], at.axes[p, 1]
    return c * x - s * y, s * x + c * y


@compilable
def slides_turn(joints: Joints, b: int) -> bool:
    """Return whether the joint of body b has slides in the axes of its parent."""
    for k in range(joints.first_slide[b], joints.first_slide[b + 1]):
        if joints.turns[k] == IN_PARENT:
            return True
    return False


@compilable
def put_origin(joints, b, now, at):
    """Write the motion of the origin of body b into `at`, which has that of its parent.

    Eq. (K41):  X = X_P + R_P (d + u) + v
                X'' = X_P'' + (chi_P'' Z - chi_P'^2) R_P (d + u) + 2 chi_P' Z R_P u' + R_P u'' + v''
                d the joint, u its slides in the axes R_P of the parent P, v those in the block's
    """
    position, velocity, acceleration = at.position, at.velocity, at.acceleration
    p, own = joints.parent[b], sliding_of(joints, b, IN_PARENT, now)
    x, y = joints.marker[b, X] + own.x, joints.marker[b, Y] + own.y
    vx, vy, ax, ay = own.vx, own.vy, own.ax, own.ay
    # Eq. (K41)
    if p < 0:
        position[b, X], position[b, Y] = x, y
        velocity[b, X], velocity[b, Y] = vx, vy
        acceleration[b, X], acceleration[b, Y] = ax, ay
    else:
        c, s = at.axes[p, 0], at.axes[p, 1]
        x, y = c * x - s * y, s * x + c * y
        vx, vy = c * vx - s * vy, s * vx + c * vy
        ax, ay = c * ax - s * ay, s * ax + c * ay
        w, alpha = velocity[p, TURN], acceleration[p, TURN]
        position[b, X] = position[p, X] + x
        position[b, Y] = position[p, Y] + y
        velocity[b, X] = velocity[p, X] - w * y + vx
        velocity[b, Y] = velocity[p, Y] + w * x + vy
        acceleration[b, X] = acceleration[p, X] - alpha * y - w * w * x + (ax - 2 * w * vy)
        acceleration[b, Y] = acceleration[p, Y] + alpha * x - w * w * y + (ay + 2 * w * vx)
    at.arm[b, X], at.arm[b, Y] = x, y
    at.sliding[b, 0], at.sliding[b, 1], at.sliding[b, 2], at.sliding[b, 3] = vx, vy, ax, ay
    aside = sliding_of(joints, b, IN_BLOCK, now)
    position[b, X] += aside.x
    position[b, Y] += aside.y
    velocity[b, X] += aside.vx
    velocity[b, Y] += aside.vy
    acceleration[b, X] += aside.ax
    acceleration[b, Y] += aside.ay


@compilable
def put_origin_changes(joints, b, at, by, d):
    """Write the change of the origin of body b with all unknowns of joints into `d`."""
    p = joints.parent[b]
    w, alpha = 0.0, 0.0
    if p >= 0:
        w, alpha = at.velocity[p, TURN], at.acceleration[p, TURN]
        _carry_changes(joints, b, at, d)
    for k in range(joints.first_slide[b], joints.first_slide[b + 1]):
        # Eq. (K41)
        j = joints.slide[k]
        x, y = slide_direction(joints, k, p, at)
        d.position[b, X, j] += x * by.position[j]
        d.position[b, Y, j] += y * by.position[j]
        d.velocity[b, X, j] += x * by.velocity[j]
        d.velocity[b, Y, j] += y * by.velocity[j]
        d.acceleration[b, X, j] += x * by.acceleration[j]
        d.acceleration[b, Y, j] += y * by.acceleration[j]
        if joints.turns[k] == IN_PARENT:
            dx, dy = x * by.position[j], y * by.position[j]
            d.velocity[b, X, j] -= w * dy
            d.velocity[b, Y, j] += w * dx
            spin = 2 * w * by.velocity[j]
            d.acceleration[b, X, j] -= spin * y + alpha * dy + w * w * dx
            d.acceleration[b, Y, j] += spin * x + alpha * dx - w * w * dy


@compilable
def _carry_changes(joints, b, at, d):
    """Write the change of the origin of body b with the motion of its parent."""
    p = joints.parent[b]
    x, y = at.arm[b, X], at.arm[b, Y]
    w, alpha = at.velocity[p, TURN], at.acceleration[p, TURN]
    turns = slides_turn(joints, b)
    for j in range(d.position.shape[2]):
        # Eq. (K41)
        t, dw, da = d.position[p, TURN, j], d.velocity[p, TURN, j], d.acceleration[p, TURN, j]
        dx, dy = -y * t, x * t
        d.position[b, X, j] = d.position[p, X, j] + dx
        d.position[b, Y, j] = d.position[p, Y, j] + dy
        d.velocity[b, X, j] = d.velocity[p, X, j] - dw * y - w * dy
        d.velocity[b, Y, j] = d.velocity[p, Y, j] + dw * x + w * dx
        spin = 2 * w * dw
        d.acceleration[b, X, j] = (
            d.acceleration[p, X, j] - da * y - alpha * dy - spin * x - w * w * dx
        )
        d.acceleration[b, Y, j] = (
            d.acceleration[p, Y, j] + da * x + alpha * dx - spin * y - w * w * dy
        )
        if turns:
            vx, vy, ax, ay = at.sliding[b]
            d.velocity[b, X, j] -= t * vy
            d.velocity[b, Y, j] += t * vx
            d.acceleration[b, X, j] -= 2 * dw * vy + 2 * w * t * vx + t * ay
            d.acceleration[b, Y, j] += 2 * dw * vx - 2 * w * t * vy + t * ax


@compilable
def add_slide_rows(joints, b, at, force, residual):
    """Add the force that body b needs to the rows of its slides and to that of its parent."""
    p = joints.parent[b]
    for k in range(joints.first_slide[b], joints.first_slide[b + 1]):
        x, y = slide_direction(joints, k, p, at)
        residual[joints.slide[k]] += x * force[b, X] + y * force[b, Y]
    if p >= 0:
        force[p, X] += force[b, X]
        force[p, Y] += force[b, Y]
        force[p, TURN] += at.arm[b, X] * force[b, Y] - at.arm[b, Y] * force[b, X]


@compilable
def add_slide_row_changes(joints, b, at, force, d, change, top):
    """Add the derivative of `add_slide_rows` to that of the rows, `top`, and of the forces."""
    p = joints.parent[b]
    m, columns = d.position.shape[2], change.shape[2]
    for k in range(joints.first_slide[b], joints.first_slide[b + 1]):
        i = joints.slide[k]
        x, y = slide_direction(joints, k, p, at)
        if x != 0.0:
            for j in range(columns):
                top[i, j] += x * change[b, X, j]
        if y != 0.0:
            for j in range(columns):
                top[i, j] += y * change[b, Y, j]
        if p >= 0 and joints.turns[k] == IN_PARENT:
            along = x * force[b, Y] - y * force[b, X]
            for j in range(m):
                top[i, j] += along * d.position[p, TURN, j]
            if i < columns:
                change[p, TURN, i] += along * d.by.position[i]
    if p >= 0:
        x, y = at.arm[b, X], at.arm[b, Y]
        outward = x * force[b, X] + y * force[b, Y]
        for j in range(columns):
            fx, fy = change[b, X, j], change[b, Y, j]
            change[p, X, j] += fx
            change[p, Y, j] += fy
            change[p, TURN, j] += x * fy - y * fx
        for j in range(m):
            change[p, TURN, j] -= outward * d.position[p, TURN, j]
