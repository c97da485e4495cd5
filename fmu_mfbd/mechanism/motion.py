"""Motion of all bodies of a chain, from the block outwards, and its derivative."""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable
from ..dynamics.floating_frame import TURN, X, Y
from ..dynamics.generalised_alpha import Coefficients, Motion
from ..dynamics.slider_crank import CrankMotion
from ..geometry.arrays import Matrix, Vector
from .angles import put_angle, put_angle_changes
from .chain import Joints


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


@compilable
def increments_of(c: Coefficients, n: int) -> Increments:
    """Return those of n coordinates with their end accelerations in a step (Eq. (N2))."""
    return Increments(np.full(n, c.to_position), np.full(n, c.to_velocity), np.ones(n))


class ChainMotion(NamedTuple):
    """Motion of all n bodies in the block's axes.

    Parameters
    ----------
    axes : ndarray, shape (n, 2)
        Cosine and sine of the angles [-].
    arm : ndarray, shape (n, 2)
        From the parent's origin to the joint [m].
    position : ndarray, shape (n, 2)
        Of the origins, from that of the block [m].
    velocity, acceleration : ndarray, shape (n, 3)
        Of the origins [m/s], [m/s2] and of the angles [rad/s], [rad/s2].
    """

    axes: Matrix
    arm: Matrix
    position: Matrix
    velocity: Matrix
    acceleration: Matrix


class MotionChanges(NamedTuple):
    """Change of the motion of all n bodies with each of m unknowns; angles are the third row.

    Parameters
    ----------
    position, velocity, acceleration : ndarray, shape (n, 3, m)
    """

    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray


class ChainChange(NamedTuple):
    """Change of position and velocity of all n bodies; angles are the third column.

    Parameters
    ----------
    position, velocity : ndarray, shape (n, 3)
    """

    position: np.ndarray
    velocity: np.ndarray


@compilable
def chain_motion(joints: Joints, now: Motion, drive: CrankMotion) -> ChainMotion:
    """Compute the motion of all bodies in the block's axes.

    Eq. (K41):  X = X_P + R_P d + j u,   X'' = X_P'' + (chi_P'' Z - chi_P'^2) R_P d + j u''
                d the joint in the axes R_P of the parent P, u the play and j its sign

    Angles follow by `angles.put_angle`.

    Parameters
    ----------
    joints : Joints
    now : Motion
        Of all coordinates, n = m + k.
    drive : CrankMotion

    Returns
    -------
    ChainMotion
    """
    n = len(joints.parent)
    places, rates = np.empty((3, n, 2)), np.zeros((2, n, 3))
    at = ChainMotion(places[0], places[1], places[-1], rates[0], rates[1])
    position, velocity, acceleration = at.position, at.velocity, at.acceleration
    for b in range(n):
        # Eq. (K41)
        p = joints.parent[b]
        x, y = joints.marker[b, X], joints.marker[b, Y]
        if p < 0:
            position[b, X], position[b, Y] = x, y
        else:
            c, s = at.axes[p, 0], at.axes[p, 1]
            x, y = c * x - s * y, s * x + c * y
            w, alpha = velocity[p, TURN], acceleration[p, TURN]
            position[b, X] = position[p, X] + x
            position[b, Y] = position[p, Y] + y
            velocity[b, X] = velocity[p, X] - w * y
            velocity[b, Y] = velocity[p, Y] + w * x
            acceleration[b, X] = acceleration[p, X] - alpha * y - w * w * x
            acceleration[b, Y] = acceleration[p, Y] + alpha * x - w * w * y
        at.arm[b, X], at.arm[b, Y] = x, y
        first = joints.play[b]
        if first >= 0:
            for way in range(2):
                position[b, way] += joints.sign[b] * now.position[first + way]
                velocity[b, way] += joints.sign[b] * now.velocity[first + way]
                acceleration[b, way] += joints.sign[b] * now.acceleration[first + way]
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
    d = MotionChanges(tables[0], tables[1], tables[-1])
    for b in range(n):
        p = joints.parent[b]
        if p >= 0:
            x, y = at.arm[b, X], at.arm[b, Y]
            w, alpha = at.velocity[p, TURN], at.acceleration[p, TURN]
            for j in range(m):
                # Eq. (K41)
                t, dw, da = (
                    d.position[p, TURN, j],
                    d.velocity[p, TURN, j],
                    d.acceleration[p, TURN, j],
                )
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
        first = joints.play[b]
        if first >= 0:
            for way in range(2):
                j = first + way
                d.position[b, way, j] += joints.sign[b] * by.position[j]
                d.velocity[b, way, j] += joints.sign[b] * by.velocity[j]
                d.acceleration[b, way, j] += joints.sign[b] * by.acceleration[j]
        put_angle_changes(joints, b, at, by, d)
    return d


@compilable
def changes_along(d: MotionChanges, x: np.ndarray) -> ChainChange:
    """Return the change of the motion of all bodies with a change x of m unknowns."""
    n, rows, m = d.position.shape
    out = ChainChange(np.zeros((n, rows)), np.zeros((n, rows)))
    for b in range(n):
        for row in range(rows):
            for j in range(m):
                out.position[b, row] += d.position[b, row, j] * x[j]
                out.velocity[b, row] += d.velocity[b, row, j] * x[j]
    return out
