"""Derivative of the forces in a chain by its motion, its loads and the motion of its block."""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable
from .angles import add_angle_row_changes
from .carrier import FIXED, BlockMotion
from .chain import Chain, Loads
from .equations import (
    ChainForces,
    friction_at,
    has_friction,
    moment_of_shapes,
    point_of,
    subtract_loads,
)
from .floating_frame import TURN, ArrowMatrix, X, Y
from .generalised_alpha import Motion
from .inertia import inertia_changes, shaken_forces
from .laws import subtract_law_changes
from .motion import Increments, MotionChanges, chain_motion, motion_changes, no_changes
from .slider_crank import CrankMotion
from .translations import add_slide_row_changes


class ChainDerivative(NamedTuple):
    """Derivative of `ChainForces` by the unknowns of the time integrator.

    Parameters
    ----------
    arrow : ArrowMatrix
        Derivative of the residual, with m rigid motions and k modes.
    torque : ndarray, shape (m + k,)
    on_block : ndarray, shape (3, m + k)
    motion : MotionChanges
    """

    arrow: ArrowMatrix
    torque: np.ndarray
    on_block: np.ndarray
    motion: MotionChanges


@compilable
def chain_derivative(
    chain: Chain, loads: Loads, now: Motion, forces: ChainForces, by: Increments
) -> ChainDerivative:
    """Compute the derivative of all forces by the unknowns of the time integrator.

    It is the derivative of both sweeps, for all unknowns at once. Apart from slopes and laws, the
    force of an element and that on its shapes are constant in the axes of one body. So is its
    moment in these axes about a point of another body. Coupling of modes among each other (Eq.
    (D4)) is omitted.

    Parameters
    ----------
    chain, loads, now
        As for `chain_forces`.
    forces : ChainForces
    by : Increments

    Returns
    -------
    ChainDerivative
    """
    at = forces.motion
    d = motion_changes(chain.joints, at, by)
    changes = inertia_changes(chain.bodies, at, now, forces.inertia, by, d)
    change = changes.wrench
    m = chain.joints.tip.shape[1]
    top = np.zeros((m, change.shape[2]))
    total = _total_change(at, forces.inertia.wrench, d, change)
    _subtract_load_changes(chain.elements, loads.wrench, at, d, change)
    if len(loads.law_slopes) > 0:
        subtract_law_changes(chain, loads, at, d, change)
    _subtract_modal_changes(chain, loads, now, by, d, changes, total)
    torque = _inward_changes(chain.joints, at, forces.joint_wrench, d, change, top)
    for j in range(len(torque)):
        total[TURN, j] -= torque[j]
    for i in range(3):
        for j in range(len(torque)):
            total[i, j] = -total[i, j]
    return ChainDerivative(ArrowMatrix(top, changes.left, changes.diagonal), torque, total, d)


@compilable
def _total_change(at, needed, d, change):
    """Return the change of the force that all bodies need, and of its moment about the block."""
    total = np.zeros((3, change.shape[2]))
    for b in range(len(needed)):
        # Eq. (D63)
        x, y = at.position[b, X], at.position[b, Y]
        for j in range(change.shape[2]):
            fx, fy = change[b, X, j], change[b, Y, j]
            total[X, j] += fx
            total[Y, j] += fy
            total[TURN, j] += x * fy - y * fx + change[b, TURN, j]
        for j in range(d.position.shape[2]):
            total[TURN, j] += d.position[b, X, j] * needed[b, Y]
            total[TURN, j] -= d.position[b, Y, j] * needed[b, X]
    return total


@compilable
def _subtract_load_changes(elements, wrench, at, d, change):
    """Subtract the change of the loads of all elements with the unknowns of joints."""
    for e in range(len(wrench)):
        body, other = elements.acts[e], elements.reacts[e]
        c, axes = elements.carrier[e], elements.axes[e]
        x, y = wrench[e, X], wrench[e, Y]
        px, py = point_of(elements, at, e)
        out_x, out_y = px - at.position[body, X], py - at.position[body, Y]
        arm_x, arm_y = px, py
        if c >= 0:
            arm_x, arm_y = px - at.position[c, X], py - at.position[c, Y]
        for j in range(d.position.shape[2]):
            fx, fy, dx, dy = 0.0, 0.0, 0.0, 0.0
            if axes >= 0:
                t = d.position[axes, TURN, j]
                fx, fy = -y * t, x * t
            if c >= 0:
                t = d.position[c, TURN, j]
                dx, dy = d.position[c, X, j] - arm_y * t, d.position[c, Y, j] + arm_x * t
            # Eq. (D62)
            lx, ly = dx - d.position[body, X, j], dy - d.position[body, Y, j]
            change[body, X, j] -= fx
            change[body, Y, j] -= fy
            change[body, TURN, j] -= lx * y - ly * x + out_x * fy - out_y * fx
            if other >= 0:
                lx, ly = dx - d.position[other, X, j], dy - d.position[other, Y, j]
                change[other, X, j] += fx
                change[other, Y, j] += fy
                change[other, TURN, j] += lx * y - ly * x
                change[other, TURN, j] += (px - at.position[other, X]) * fy
                change[other, TURN, j] -= (py - at.position[other, Y]) * fx


@compilable
def _subtract_modal_changes(chain, loads, now, by, d, changes, total):
    """Subtract the change of moments by slopes and shapes, and of the forces on shapes."""
    elements, change, left = chain.elements, changes.wrench, changes.left
    m = d.position.shape[2]
    slope = 0
    for e in range(len(elements.acts)):
        body, other, axes = elements.acts[e], elements.reacts[e], elements.axes[e]
        for j in range(elements.mode[e], elements.mode[e] + elements.modes[e]):
            moment = loads.slopes[slope] * by.position[j]
            change[body, TURN, j] -= moment
            if other >= 0:
                change[other, TURN, j] += moment
            slope += 1
        n = elements.shapes[e]
        if n == 0:
            continue
        row = np.zeros(change.shape[2])
        for k in range(n):
            x = elements.shape[e] + k
            y = x + n
            force = loads.on_shapes[e, k]
            fx, fy = force[X], force[Y]
            # s x Q
            row[x] += by.position[x] * fy
            row[y] -= by.position[y] * fx
            if axes >= 0:
                outward = now.position[x] * fx + now.position[y] * fy
                for j in range(m):
                    t = d.position[axes, TURN, j]
                    row[j] += outward * t
                    left[x - m, j] += fy * t
                    left[y - m, j] -= fx * t
        for j in range(len(row)):
            change[body, TURN, j] += row[j]
            total[TURN, j] += row[j]


@compilable
def _inward_changes(joints, at, force, d, change, top):
    """Add the derivative of the rows of all joints, and change the parents' forces.

    Returns the change of the drive's torque, (m + k,).
    """
    torque = np.zeros(change.shape[2])
    for b in range(len(joints.parent) - 1, -1, -1):
        # Eq. (D61)
        if has_friction(joints.friction, b):
            _subtract_friction_changes(joints, at, force, b, d, change)
        add_angle_row_changes(joints, b, at, force, d, change, top, torque)
        add_slide_row_changes(joints, b, at, force, d, change, top)
    return torque


@compilable
def _subtract_friction_changes(joints, at, force, b, d, change):
    """Subtract the change of friction from that of the moment on body b, and pass it on."""
    p = joints.parent[b]
    friction = friction_at(joints, at, force, b)
    for j in range(change.shape[2]):
        moment = friction.by_x * change[b, X, j] + friction.by_y * change[b, Y, j]
        if j < d.velocity.shape[2]:
            slip = d.velocity[b, TURN, j]
            if p >= 0:
                slip -= d.velocity[p, TURN, j]
            moment += friction.by_slip * slip
        change[b, TURN, j] -= moment
        if p >= 0:
            change[p, TURN, j] += moment


class PushedForces(NamedTuple):
    """Change of residual (m + k,) and force on the block (3,) without a change of the motion."""

    residual: np.ndarray
    on_block: np.ndarray


@compilable
def pushed_forces(
    chain: Chain, forces: ChainForces, now: Motion, loads: Loads, carrier: BlockMotion
) -> PushedForces:
    """Compute the derivative of all forces in a direction of loads and of a given block's motion.

    Parameters
    ----------
    chain : Chain
    forces : ChainForces
    now : Motion
        Motion in all m + k coordinates.
    loads, carrier : Loads, BlockMotion
        The direction.

    Returns
    -------
    PushedForces
    """
    at = forces.motion
    n, m = chain.joints.tip.shape
    still = no_changes(chain.joints)
    inertia = shaken_forces(chain.bodies, at, forces.inertia, still, carrier)
    total = _total_change(at, forces.inertia.wrench, still, inertia.wrench)
    push, top = np.zeros((n, 3)), np.zeros((m, 1))
    subtract_loads(chain.elements, loads.wrench, at, push)
    change = inertia.wrench
    for b in range(n):
        for i in range(3):
            change[b, i, 0] += push[b, i]
    (torque,) = _inward_changes(chain.joints, at, forces.joint_wrench, still, change, top)
    residual = np.concatenate((top[:, 0], inertia.left[:, 0] - loads.modal))
    total[TURN, 0] -= torque
    for e in range(len(loads.on_shapes) if loads.on_shapes.shape[1] > 0 else 0):
        total[TURN, 0] += moment_of_shapes(chain.elements, loads, now, e)
    return PushedForces(residual, -total[:, 0])


@compilable
def drive_inertia(chain: Chain, forces: ChainForces, now: Motion, drive: CrankMotion) -> float:
    """Return the derivative of the drive's torque by its angular acceleration [kg m2].

    The coordinates keep their motion: all bodies follow the drive as at rest.

    Parameters
    ----------
    chain : Chain
    forces : ChainForces
    now : Motion
    drive : CrankMotion
        Motion of the crank, for both.
    """
    at = forces.motion
    n, m = chain.joints.tip.shape
    none = np.zeros(len(now.position))
    turning = CrankMotion(drive.angle, 0.0, 1.0)
    rates = chain_motion(chain.joints, Motion(now.position, none, none), turning).acceleration
    d = no_changes(chain.joints)
    for b in range(n):
        for i in range(3):
            d.acceleration[b, i, 0] = rates[b, i]
    change = shaken_forces(chain.bodies, at, forces.inertia, d, FIXED).wrench
    (torque,) = _inward_changes(chain.joints, at, forces.joint_wrench, d, change, np.zeros((m, 1)))
    return torque
