"""Equations of motion of a rigid piston in space on a tied pin.

The coordinates are [x_A, rocking angle, z, roll, yaw].

z is the displacement of A along the pin, +z. Roll and yaw are rotations about the axes x and y of
the frame that rotates with the rocking angle. They are small, and the equations are of first order
in them. The motion in the plane is that of `mechanism`, on whose chain the piston acts by its
force. The rod moves in its plane. Its eye slides along the pin, and a `Stop` resists its tilt.

The stiffness of the eye contains the bending of the rod across its plane, 3 E I/L = 95 kN m/rad for
a web of 15 000 mm^4 and 100 mm, in series with eye and big end. The play is that of the bearings,
2 C/b, 0.8 mrad for an eye of 36 mm with 15 um. Stiffness, damping and play along the pin are our
own choice, because we know no measured ones.
"""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compiled
from ..mechanism.carrier import FIXED
from ..mechanism.chain import Chain
from ..mechanism.equations import forces_at, friction_at
from ..mechanism.floating_frame import TURN, X, Y
from ..mechanism.generalised_alpha import Motion
from ..mechanism.loads import loads_at
from ..mechanism.motion import ChainMotion, chain_motion
from ..mechanism.piston_motion import LATERAL, RIGID, ROCKING, Load
from ..mechanism.slider_crank import CrankMotion
from .block_force import BlockForce, block_force
from .pin_films import forces_of

SHIFT, ROLL, YAW = 2, 3, 4
"""Coordinates beside x_A and the rocking angle."""

COORDINATES = 5

IN_SPACE = slice(SHIFT, COORDINATES)
"""Those that a piston in its plane has not."""


class SpaceBody(NamedTuple):
    """Inertia of a rigid piston: mass [kg], first moment (3,) [kg m] and tensor (3, 3) [kg m2].

    The moments are about A in its own axes.
    """

    mass: float
    S: np.ndarray
    J: np.ndarray


class Stop(NamedTuple):
    """Holder of a motion: a damper alone within a play, and a spring beyond it.

    Parameters
    ----------
    play : float
        To either side [m], [rad].
    stiffness, damping : float
        [N/m], [N s/m], or [N m/rad], [N m s/rad].
    """

    play: float
    stiffness: float
    damping: float


class SpaceBodies(NamedTuple):
    """All moving bodies, and the stops and dampers on them.

    Parameters
    ----------
    piston : SpaceBody
    chain : Chain
        Crank, rod with the tied pin, and a piston without inertia, see `without_piston`.
    pin_mass : float
        [kg]
    pin_inertia : float
        Moment of inertia of the pin about a diameter at A [kg m2].
    tilt : float
        Held roll of the rod's eye [rad]: the coordinate roll counts from it.
    pin_offset : float
        x of A from the skirt's axis [m].
    along, askew : Stop
        Stops between rod and bosses along the pin, and of the pin in the rod's eye about any axis
        across it.
    """

    piston: SpaceBody
    chain: Chain
    pin_mass: float
    pin_inertia: float
    tilt: float
    pin_offset: float
    along: Stop
    askew: Stop


class SpaceLoad(NamedTuple):
    """Forces on the piston at the end of a step, all but the pin's.

    Parameters
    ----------
    plane : Load
        Its `axis_force` acts on the bore's axis in z too.
    across : ndarray, shape (3,)
        On [z, roll, yaw], without what `axis_force` adds away from z = 0 [N], [N m], [N m].
    """

    plane: Load
    across: np.ndarray


class Spin(NamedTuple):
    """Motion of a body in axes that turn with the rocking angle, each (3,).

    Parameters
    ----------
    acceleration : ndarray
        Acceleration of A in space [m/s2].
    tilt : ndarray
        Rotation of the body in these axes, small [rad].
    velocity, change : ndarray
        Angular velocity in space [rad/s], and its change there [rad/s2].
    """

    acceleration: np.ndarray
    tilt: np.ndarray
    velocity: np.ndarray
    change: np.ndarray


class SpaceImbalance(NamedTuple):
    """Imbalance of the equations, and the forces between the bodies.

    Parameters
    ----------
    residual : ndarray, shape (5,)
        [N], [N m], [N], [N m], [N m].
    on_piston : ndarray, shape (2,)
        Force of the pin on the piston, along x and y [N].
    pin_moment : float
        Moment of pin friction on the piston [N m].
    from_rod : ndarray, shape (2,)
        Force of the rod on the pin, along x and y [N].
    out_of_plane : ndarray, shape (3,)
        Action of the rod on the pin: force of stop and damper along z [N], moments about x and y [N
        m].
    torque : float
        Torque of the drive on the crank [N m].
    on_block : ndarray, shape (3,)
        As of `ChainForces` [N], [N m].
    motion : ChainMotion
        In the plane.
    """

    residual: np.ndarray
    on_piston: np.ndarray
    pin_moment: float
    from_rod: np.ndarray
    out_of_plane: np.ndarray
    torque: float
    on_block: np.ndarray
    motion: ChainMotion


def without_piston(chain: Chain) -> Chain:
    """Return a chain with a last body without inertia."""
    last = np.arange(len(chain.bodies.mass)) == len(chain.bodies.mass) - 1
    mass, I0 = (np.where(last, 0.0, one) for one in (chain.bodies.mass, chain.bodies.I0))
    S = np.where(last[:, None], 0.0, chain.bodies.S)
    return chain._replace(bodies=chain.bodies._replace(mass=mass, I0=I0, S=S))


@compiled
def skew(vector: np.ndarray) -> np.ndarray:
    """Return the matrix of v x, (3, 3)."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


@compiled
def stop_force(stop: Stop, position: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Return the force of a stop against a motion of n coordinates in any direction, (n,).

    Eq. (K17):  F = k max(0, |q| - play) q/|q| + d q'

    Parameters
    ----------
    stop : Stop
    position, velocity : ndarray, shape (n,)
    """
    size = np.sqrt((position * position).sum())
    # Eq. (K17)
    share = 1 - stop.play / size if size > stop.play else 0.0
    return stop.stiffness * share * position + stop.damping * velocity


@compiled
def needed(body: SpaceBody, spin: Spin) -> tuple[np.ndarray, np.ndarray]:
    """Return force [N] and moment about A [N m] of a motion, (3,) each, in the turning axes.

    Eq. (D26):  F = m a + W' x S' + W x (W x S'),   M = S' x a + J' W' + W x J' W
                S' = S + t x S,   J' = J + [t] J - J [t]

    a: acceleration of A, t: tilt, W: angular velocity. Of first order in the tilt.

    Parameters
    ----------
    body : SpaceBody
    spin : Spin
    """
    t = skew(spin.tilt)
    w = skew(spin.velocity)
    # Eq. (D26)
    S = body.S + t @ body.S
    J = body.J + t @ body.J - body.J @ t
    force = body.mass * spin.acceleration + (skew(spin.change) + w @ w) @ S
    moment = skew(S) @ spin.acceleration + J @ spin.change + w @ (J @ spin.velocity)
    return force, moment


@compiled
def spin_of(bodies: SpaceBodies, at: ChainMotion, now: Motion) -> Spin:
    """Return the motion of the piston, whose motion in the plane is `at`.

    Eq. (K18):  A'' = (x_A'', Y'', z''),   t = (roll, yaw, 0),   W = (roll', yaw', w)
                W' = (roll'' - w yaw', yaw'' + w roll', w')        w the rocking velocity
    """
    q, dq, ddq = now
    (c, s), (x, y, _) = at.axes[-1], at.acceleration[-1]
    w = dq[ROCKING]
    # Eq. (K18)
    return Spin(
        np.array([c * x + s * y, c * y - s * x, ddq[SHIFT]]),
        np.array([bodies.tilt + q[ROLL], q[YAW], 0.0]),
        np.array([dq[ROLL], dq[YAW], w]),
        np.array([ddq[ROLL] - w * dq[YAW], ddq[YAW] + w * dq[ROLL], ddq[ROCKING]]),
    )


@compiled
def with_pin(bodies: SpaceBodies) -> SpaceBody:
    """Return the piston with the pin's inertia about its diameters.

    The pin does not turn with the rocking angle, and its mass at A is counted separately.
    """
    J = bodies.piston.J.copy()
    J[0, 0] += bodies.pin_inertia
    J[1, 1] += bodies.pin_inertia
    return SpaceBody(bodies.piston.mass, bodies.piston.S, J)


@compiled
def imbalance(
    bodies: SpaceBodies, load: SpaceLoad, now: Motion, crank: CrankMotion
) -> SpaceImbalance:
    """Return the residual of the equations of motion.

    Eq. (D27):  x_A:    T_x + f1 T_y + rod + M psi1 = 0
                angle:  M_z - M - (moment + axis_force x_A) = 0
                z:      F_z + m_pin z'' - roll (T_y - axis_force) + yaw T_x - load_z + K_z = 0
                roll:   M_x - z (T_y - axis_force) - load_roll + K_roll = 0
                yaw:    M_y + z T_x + roll axis_force (p + x_A) - load_yaw + K_yaw = 0
                G = R F - load,   T = G + m_pin A''
    F, M of Eq. (D26), of piston and pin; rod: its inertia (Eq. (D61)); G: force of the pin on the
    piston; T: that of the rod on the pin, square to it, in the rod's plane; M: friction of the pin
    (Eq. (K7)); K: what stops and dampers hold (Eq. (K17)); p: the pin offset. With z = roll = yaw =
    0 the pin is tied.
    Gas stays on the bore's axis and leans with the crown: upright, it would not balance the rod's
    force under a pin that has rolled with the piston. The moment about A that leaning has by the
    height of the rings is left out, as it is in the plane (Eq. (D8)).

    Parameters
    ----------
    bodies : SpaceBodies
    load : SpaceLoad
    now : Motion
        n = 5.
    crank : CrankMotion
    """
    chain, last = bodies.chain, len(bodies.chain.bodies.mass) - 1
    plane = Motion(now.position[:RIGID], now.velocity[:RIGID], now.acceleration[:RIGID])
    at = chain_motion(chain.joints, plane, crank)
    spin = spin_of(bodies, at, now)
    force, moment = needed(with_pin(bodies), spin)
    c, s = at.axes[last]
    x, y = c * force[X] - s * force[Y], s * force[X] + c * force[Y]
    loads = loads_at(chain, forces_of(chain, load.plane), at, plane)
    # Eq. (D27)
    skirt = loads.wrench[0]
    skirt[X] -= x
    skirt[Y] -= y
    skirt[TURN] -= moment[TURN]
    own = forces_at(chain, loads, at, plane, FIXED)
    on_piston = own.joint_wrench[last, :TURN].copy()
    pull = on_piston + bodies.pin_mass * at.acceleration[last, :TURN]
    q = now.position
    roll, z, arm = spin.tilt[0], q[SHIFT], bodies.pin_offset + q[LATERAL]
    holding, (load_z, load_roll, load_yaw) = _stop_forces(bodies, now), load.across
    carried = bodies.pin_mass * now.acceleration[SHIFT]
    out_of_plane = np.array(
        [
            force[-1] + carried - _square(load, pull, spin.tilt) - load_z,
            moment[X] - z * (pull[Y] - load.plane.axis_force) - load_roll,
            moment[Y] + z * pull[X] + roll * load.plane.axis_force * arm - load_yaw,
        ]
    )
    on_block = own.on_block
    on_block[X] -= x
    on_block[Y] -= y
    on_block[TURN] -= at.position[last, X] * y - at.position[last, Y] * x + moment[TURN]
    return SpaceImbalance(
        residual=np.concatenate((own.residual, out_of_plane + holding)),
        on_piston=on_piston,
        pin_moment=friction_at(chain.joints, at, own.joint_wrench, last).moment,
        from_rod=pull,
        out_of_plane=-holding,
        torque=own.torque,
        on_block=on_block,
        motion=at,
    )


@compiled
def _square(load, pull, tilt):
    """Return the force along z of rod and gas on a pin that is tilted."""
    roll, yaw, _ = tilt
    pull_x, pull_y = pull
    return roll * (pull_y - load.plane.axis_force) - yaw * pull_x


@compiled
def _stop_forces(bodies, now):
    """Return the forces of the stops in z, roll and yaw, (3,) [N], [N m]."""
    q, v = now.position, now.velocity
    along = stop_force(bodies.along, q[SHIFT:ROLL], v[SHIFT:ROLL])
    return np.concatenate((along, stop_force(bodies.askew, q[ROLL:], v[ROLL:])))


@compiled
def tangent(
    bodies: SpaceBodies, load: SpaceLoad, now: Motion, crank: CrankMotion, c1: float, c2: float
) -> np.ndarray:
    """Compute the derivative of the residual (Eq. (D27)), (5, 5), by central differences.

    Each end acceleration changes its velocity by c1 [s] and its position by c2 [s2]. Differences
    over 1 m/s2 and 1 rad/s2 change velocities by less than 1 mm/s and 1 mrad/s. Their error and
    their round-off are some 1e-11 of a column.

    Parameters
    ----------
    bodies, load, now, crank
        As for `imbalance`.
    c1, c2 : float
        `Coefficients.to_velocity`, `Coefficients.to_position`.
    """

    out = np.empty((COORDINATES, COORDINATES))
    for j in range(COORDINATES):
        for sign in (-0.5, 0.5):
            seed = np.zeros(COORDINATES)
            seed[j] = 2 * sign
            moved = Motion(
                now.position + c2 * seed, now.velocity + c1 * seed, now.acceleration + seed
            )
            residual = imbalance(bodies, load, moved, crank).residual
            for i in range(COORDINATES):
                out[i, j] = sign * residual[i] + (out[i, j] if sign > 0.0 else 0.0)
    return out


def forces_on_block(
    bodies: SpaceBodies, load: SpaceLoad, now: Motion, imbalance: SpaceImbalance
) -> tuple[BlockForce, tuple[float, float, float]]:
    """Return the forces on the block in the plane, then force along z and moments about x and y.

    Eq. (D53):  F_z = -Z,   Z = roll (T_y - axis_force) - yaw T_x + load_z - K_z
                M_x = -(load_roll - K_roll + Y Z - z (load_y + axis_force))
                M_y = -(load_yaw - K_yaw - x Z + z load_x - axis_force roll (p + x_A))
                (x, Y, z): A from the crank axis, the rest of Eq. (D27)

    Parameters
    ----------
    bodies, load, now
        As for `imbalance`.
    imbalance : SpaceImbalance
        Imbalance of the same motion.

    Returns
    -------
    BlockForce, tuple
        All that acts on the block, the main bearings' too, on the crank axis [N], [N m].
    """
    lateral, _, z, roll, yaw = now.position
    x, y = imbalance.motion.position[-1]
    tilt = np.array([bodies.tilt + roll, yaw, 0.0])
    along, about_x, about_y = imbalance.out_of_plane
    load_z, load_roll, load_yaw = load.across
    # Eq. (D53)
    needed_z = _square(load, imbalance.from_rod, tilt) + load_z + along
    leaning = load.plane.axis_force * tilt[0] * (bodies.pin_offset + lateral)
    moment_x = load_roll + about_x + y * needed_z - z * (load.plane.axial + load.plane.axis_force)
    moment_y = load_yaw + about_y - x * needed_z + z * load.plane.lateral - leaning
    on = block_force(load.plane, np.zeros(RIGID), imbalance.on_block)
    return on, (-needed_z, -moment_x, -moment_y)


def pushed(
    bodies: SpaceBodies, load: SpaceLoad, now: Motion, crank: CrankMotion, change: SpaceLoad
) -> np.ndarray:
    """Compute the change of the residual (Eq. (D27)) with a change of the load, (5,).

    It is a central difference over changes of at most 1 N or 1 N m: only the friction of the pin
    is not linear in the load.
    """
    *plane, _ = change.plane
    share = 1.0 / max(1e-300, *map(abs, (*plane, *change.across)))

    def residual(share: float) -> np.ndarray:
        moved = Load._make(one + share * more for one, more in zip(load.plane, change.plane))
        changed = SpaceLoad(moved, load.across + share * change.across)
        return imbalance(bodies, changed, now, crank).residual

    return (residual(share) - residual(-share)) / (2 * share)


def inertia(bodies: SpaceBodies) -> np.ndarray:
    """Return M, (5, 5), of the motion across the bore.

    Eq. (D28):  q' . M q' = (m + m_pin) |V|^2 + 2 V . (W x S) + W . J W
                V = (x_A', 0, z'),   W = (roll', yaw', rocking velocity)       the piston upright

    It contains neither the driven motion along the bore nor the rod, as for a piston in its plane.
    """
    body = with_pin(bodies)
    lateral, rocking, shift, roll, yaw = np.eye(COORDINATES)
    V = np.array([lateral, np.zeros(COORDINATES), shift])
    W = np.array([roll, yaw, rocking])
    # Eq. (D28)
    coupled = V.T @ (-skew(body.S)) @ W
    mass = body.mass + bodies.pin_mass
    return mass * V.T @ V + coupled + coupled.T + W.T @ body.J @ W
