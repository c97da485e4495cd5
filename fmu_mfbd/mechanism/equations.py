"""Equations of motion of a chain: residual and all forces in it."""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable
from ..geometry.arrays import Matrix, Vector
from .angles import add_angle_row
from .carrier import BlockMotion
from .chain import REACTION, Chain, Elements, Joints, Loads
from .floating_frame import TURN, X, Y
from .generalised_alpha import Motion
from .inertia import (
    InertiaForces,
    inertia_forces,
)
from .motion import ChainMotion, chain_motion
from .pin_friction import PinMoment, friction_moment, pin_friction_from
from .slider_crank import CrankMotion
from .translations import add_slide_rows


class ChainForces(NamedTuple):
    """Residual of a chain and all forces in it.

    Parameters
    ----------
    residual : ndarray, shape (m + k,)
        Residuals of the m coordinates of joints [N] or [N m], then of the k modes [kg^-1/2 N].
    torque : float
        Torque of the drive, which is outside the block [N m].
    on_block : ndarray, shape (3,)
        Forces of joints and reactions on the block in its axes [N], and moment about its origin
        [N m].
    joint_wrench : ndarray, shape (n, 3)
        Force of the parent on each body [N], moment about the body's origin [N m]. That of a rod
        that swings contains the force that holds its tip.
    motion : ChainMotion
    inertia : InertiaForces
    """

    residual: Vector
    torque: float
    on_block: Vector
    joint_wrench: Matrix
    motion: ChainMotion
    inertia: InertiaForces


@compilable
def chain_forces(
    chain: Chain, loads: Loads, now: Motion, drive: CrankMotion, carrier: BlockMotion
) -> ChainForces:
    """Compute the motion of all bodies, and by it the residual of `forces_at`."""
    return forces_at(chain, loads, chain_motion(chain.joints, now, drive), now, carrier)


@compilable
def forces_at(
    chain: Chain, loads: Loads, at: ChainMotion, now: Motion, carrier: BlockMotion
) -> ChainForces:
    """Compute the residual of the equations of motion.

    Eq. (D61):  r_j = sum_b J_bj . (F_b - Q_b),   r_k = F_k - Q_k
                F the force that a body or mode needs, Q its load
                J_bj = dX_b/dq_j by Eqs. (K41) and (K42)
    Eq. (D62):  Q = (F_e, M_e + d x F_e)      on the body of an element
                Q = (-F_e, M_R - l x F_e)      on that of its reaction
                d, l from the origins of both bodies to marker and point of the element;
                with `at_point`, d is to the point
    Eq. (D63):  (F, M) = (0, 0, torque) - sum_b (F_b, X_b x F_b + M_b)      on the block

    Forces between the bodies cancel in Eq. (D63). The moment on the block also has - s x Q of the
    shapes s of a bent journal. The products with J are a sweep from the last body inwards, in which
    each body adds its force to that of its parent.

    Parameters
    ----------
    chain : Chain
    loads : Loads
    at : ChainMotion
    now : Motion
        Motion in all m + k coordinates.
    carrier : BlockMotion
        Motion of the block.

    Returns
    -------
    ChainForces
    """
    m = chain.joints.tip.shape[1]
    inertia = inertia_forces(chain.bodies, at, now, carrier, m)
    residual = np.zeros(len(now.position))
    for i in range(len(loads.modal)):
        residual[m + i] = inertia.modal[i] - loads.modal[i]
    force = inertia.wrench.copy()
    total = np.zeros(3)
    for e in range(len(loads.on_shapes) if loads.on_shapes.shape[1] > 0 else 0):
        total[TURN] += moment_of_shapes(chain.elements, loads, now, e)
    for b in range(len(force)):
        x, y = at.position[b, X], at.position[b, Y]
        total[X] += force[b, X]
        total[Y] += force[b, Y]
        total[TURN] += x * force[b, Y] - y * force[b, X] + force[b, TURN]
    subtract_loads(chain.elements, loads.wrench, at, force)
    torque = _inwards(chain.joints, at, force, residual)
    total[TURN] -= torque
    for i in range(3):
        total[i] = -total[i]  # Eq. (D63)
    return ChainForces(
        residual=residual,
        torque=torque,
        on_block=total,
        joint_wrench=force,
        motion=at,
        inertia=inertia,
    )


@compilable
def point_of(elements: Elements, at: ChainMotion, e: int) -> tuple[float, float]:
    """Return the point of element e from the block's origin, in the block's axes [m]."""
    c = elements.carrier[e]
    x, y = elements.point[e, X], elements.point[e, Y]
    if c < 0:
        return x, y
    cosine, sine = at.axes[c, 0], at.axes[c, 1]
    return at.position[c, X] + cosine * x - sine * y, at.position[c, Y] + sine * x + cosine * y


@compilable
def subtract_loads(elements, wrench, at, force):
    """Subtract the loads of all elements from the forces that bodies need."""
    for e in range(len(wrench)):
        # Eq. (D62)
        body, other = elements.acts[e], elements.reacts[e]
        x, y = wrench[e, X], wrench[e, Y]
        c, s = at.axes[body, 0], at.axes[body, 1]
        mx, my = elements.marker[e, X], elements.marker[e, Y]
        arm_x, arm_y = c * mx - s * my, s * mx + c * my
        px, py = point_of(elements, at, e)
        if elements.at_point[e] != 0.0:
            arm_x, arm_y = px - at.position[body, X], py - at.position[body, Y]
        force[body, X] -= x
        force[body, Y] -= y
        force[body, TURN] -= wrench[e, TURN] + arm_x * y - arm_y * x
        if other >= 0:
            turning = (px - at.position[other, X]) * y - (py - at.position[other, Y]) * x
            force[other, X] += x
            force[other, Y] += y
            force[other, TURN] += turning - wrench[e, REACTION]


@compilable
def moment_of_shapes(elements: Elements, loads: Loads, now: Motion, e: int) -> float:
    """Return the sum of s x Q over the shapes of element e [N m]."""
    total = 0.0
    n = elements.shapes[e]
    for i in range(n):
        j = elements.shape[e] + i
        force = loads.on_shapes[e, i]
        total += now.position[j] * force[Y] - now.position[j + n] * force[X]
    return total


@compilable
def _inwards(joints, at, force, residual):
    """Add the rows of all joints, and to each body's force those of its children.

    Returns the torque of the drive.
    """
    torque = 0.0
    for b in range(len(force) - 1, -1, -1):
        # Eq. (D61)
        moment = force[b, TURN]
        if has_friction(joints.friction, b):
            rubbing = friction_at(joints, at, force, b).moment
            moment -= rubbing
            if joints.parent[b] >= 0:
                force[joints.parent[b], TURN] += rubbing
        torque += add_angle_row(joints, b, at, moment, force, residual)
        add_slide_rows(joints, b, at, force, residual)
    return torque


@compilable
def friction_at(joints: Joints, at: ChainMotion, force: np.ndarray, b: int) -> PinMoment:
    """Return the moment of friction of its parent on body b.

    `force` is as `ChainForces.joint_wrench`.
    """
    parent = joints.parent[b]
    slip = at.velocity[b, TURN]
    if parent >= 0:
        slip -= at.velocity[parent, TURN]
    friction = pin_friction_from(joints.friction[b])
    return friction_moment(friction, force[b, X], force[b, Y], slip)


@compilable
def has_friction(friction: np.ndarray, b: int) -> bool:
    """Return whether the joint of body b has friction; see `Joints`."""
    of_joint = pin_friction_from(friction[b])
    return of_joint.lever > 0.0 or of_joint.viscous > 0.0
