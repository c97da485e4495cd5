"""Motion of all bodies of a chain, from the block outwards, and its derivative."""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable
from ..geometry.arrays import Matrix, Vector
from .angles import put_angle, put_angle_changes
from .chain import Joints
from .generalised_alpha import Motion
from .slider_crank import CrankMotion
from .translations import put_origin, put_origin_changes


class Increments(NamedTuple):
    """Change of each coordinate with its unknown, as the time integrator moves it.

    Parameters
    ----------
    position, velocity, acceleration : ndarray, shape (m + k,)
        If the unknowns are end accelerations: [s2], [s] and 1.
    """

    position: Vector
    velocity: Vector
    acceleration: Vector


class ChainMotion(NamedTuple):
    """Motion of all n bodies in the block's axes.

    Parameters
    ----------
    axes : ndarray, shape (n, 2)
        Cosine and sine of the angles [-].
    arm : ndarray, shape (n, 2)
        From the parent's origin to the joint, with slides in its axes [m].
    sliding : ndarray, shape (n, 4)
        Velocity and acceleration of these slides relative to the parent [m/s], [m/s2].
    position : ndarray, shape (n, 2)
        Positions of the origins relative to that of the block [m].
    velocity, acceleration : ndarray, shape (n, 3)
        Rates of the origins [m/s], [m/s2] and of the angles [rad/s], [rad/s2].
    """

    axes: Matrix
    arm: Matrix
    sliding: Matrix
    position: Matrix
    velocity: Matrix
    acceleration: Matrix


class MotionChanges(NamedTuple):
    """Change of the motion of all n bodies with each of m unknowns; angles are the third row.

    Parameters
    ----------
    position, velocity, acceleration : ndarray, shape (n, 3, m)
    by : Increments
        Changes of the coordinates by the unknowns.
    """

    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    by: Increments


@compilable
def no_changes(joints: Joints) -> MotionChanges:
    """Return the change of the motion of all bodies in a direction that moves none, m = 1."""
    n, m = joints.tip.shape
    none, zeros = np.zeros(m), np.zeros((3, n, 3, 1))
    return MotionChanges(zeros[0], zeros[1], zeros[-1], Increments(none, none, none))


@compilable
def chain_motion(joints: Joints, now: Motion, drive: CrankMotion) -> ChainMotion:
    """Compute the motion of all bodies in the block's axes.

    Origins follow by `translations.put_origin`, angles by `angles.put_angle`.

    Parameters
    ----------
    joints : Joints
    now : Motion
        Motion in all n = m + k coordinates.
    drive : CrankMotion

    Returns
    -------
    ChainMotion
    """
    n = len(joints.parent)
    places, rates = np.empty((3, n, 2)), np.zeros((2, n, 3))
    at = ChainMotion(
        axes=places[0],
        arm=places[1],
        sliding=np.empty((n, 4)),
        position=places[-1],
        velocity=rates[0],
        acceleration=rates[1],
    )
    for b in range(n):
        put_origin(joints, b, now, at)
        put_angle(joints, b, now, drive, at)
    return at


@compilable
def motion_changes(joints: Joints, at: ChainMotion, by: Increments) -> MotionChanges:
    """Compute the derivative of `chain_motion` by the unknowns of joints.

    The motion is that in the block's axes, in which the block's own coordinates change nothing.

    Parameters
    ----------
    joints : Joints
    at : ChainMotion
    by : Increments

    Returns
    -------
    MotionChanges
    """
    n, m = joints.tip.shape
    tables = np.zeros((3, n, 3, m))
    d = MotionChanges(tables[0], tables[1], tables[-1], by)
    for b in range(n):
        put_origin_changes(joints, b, at, by, d)
        put_angle_changes(joints, b, at, by, d)
    return d


@compilable
def changes_along(d: MotionChanges, x: np.ndarray) -> MotionChanges:
    """Return the change of positions and velocities with a change x of m unknowns, m = 1."""
    n, rows, m = d.position.shape
    tables = np.zeros((3, n, rows, 1))
    out = MotionChanges(tables[0], tables[1], tables[-1], d.by)
    for b in range(n):
        for row in range(rows):
            for j in range(m):
                out.position[b, row, 0] += d.position[b, row, j] * x[j]
                out.velocity[b, row, 0] += d.velocity[b, row, j] * x[j]
    return out
