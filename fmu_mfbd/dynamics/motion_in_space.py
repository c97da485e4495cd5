"""Equations of motion of a rigid piston in space on a tied pin.

The coordinates are [x_A, rocking angle, z, roll, yaw].

z is the shift of A along the pin, +z; roll and yaw are rotations about x and y of the axes that
turn with the rocking angle. They are small, and the equations of first order in them; the motion in
the plane is that of `mechanism`. The rod stays in its plane: its eye slides along the pin, and
holds it square by what `Stop` says.

How stiff rod and eye are. The rod's bending across its plane, 3 E I/L = 95 kN m/rad for a web of
15 000 mm^4 and 100 mm, the eye and the big end in series with it, and the play of both in their
bearings: 2 C/b, 0.8 mrad for an eye of 36 mm with 15 um. Stiffness, damping and play along the pin
are our own choice; no measured ones could be found.
"""

from typing import NamedTuple

import numpy as np

from ..geometry.pin import turned
from .block_force import BlockForce, all_on_block
from .generalised_alpha import Motion
from .pin_friction import friction_moment
from .piston_motion import LATERAL, ROCKING, Load, lateral_motion
from .slider_crank import CrankMotion, Link, Mechanism, carried_mass, height, motion

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
    """Everything that moves, and what holds it.

    Parameters
    ----------
    piston : SpaceBody
    mechanism : Mechanism
    pin_inertia : float
        Of the pin about a diameter, at A [kg m2].
    tilt : float
        Held roll of the rod's eye [rad]: the coordinate roll counts from it.
    pin_offset : float
        x of A from the skirt's axis [m].
    along, askew : Stop
        Of rod and bosses along the pin; of the pin in the rod's eye, about any axis across it.
    """

    piston: SpaceBody
    mechanism: Mechanism
    pin_inertia: float
    tilt: float
    pin_offset: float
    along: Stop
    askew: Stop


class SpaceLoad(NamedTuple):
    """Forces on the piston at the end of a step, all but the pin's.

    Parameters
    ----------
    lateral, axial, moment, guided : float
        As of `piston_motion.Load`; `guided` acts on the bore's axis in z too.
    across : ndarray, shape (3,)
        On [z, roll, yaw], without what `guided` adds away from z = 0 [N], [N m], [N m].
    """

    lateral: float
    axial: float
    moment: float
    guided: float
    across: np.ndarray


class Spin(NamedTuple):
    """Motion of a body in axes that turn with the rocking angle, each (3,).

    Parameters
    ----------
    acceleration : ndarray
        Of A in space [m/s2].
    tilt : ndarray
        Rotation of the body in these axes, small [rad].
    velocity, change : ndarray
        Angular velocity in space [rad/s], and its change there [rad/s2].
    """

    acceleration: np.ndarray
    tilt: np.ndarray
    velocity: np.ndarray
    change: np.ndarray


class SpaceKinematics(NamedTuple):
    """Positions of all parts: link, axes R (2, 2), and acceleration of A (2,) in space.

    It also has the piston without and with the pin, which turns with it except for the rocking
    angle.
    """

    link: Link
    axes: np.ndarray
    of_A: np.ndarray
    spin: Spin
    together: SpaceBody


class SpaceImbalance(NamedTuple):
    """Imbalance of the equations, and the forces between the bodies.

    Parameters
    ----------
    residual : ndarray, shape (5,)
        [N], [N m], [N], [N m], [N m].
    on_piston : ndarray, shape (2,)
        Force of the pin on the piston, along x and y [N].
    pin_moment : float
        Of pin friction on the piston [N m].
    from_rod : ndarray, shape (2,)
        Force of the rod on the pin, along x and y [N].
    held : ndarray, shape (3,)
        Of the rod on the pin: force along z of stop and damper [N], moments about x and y [N m].
    torque : float
        Of the drive on the crank [N m].
    """

    residual: np.ndarray
    on_piston: np.ndarray
    pin_moment: float
    from_rod: np.ndarray
    held: np.ndarray
    torque: float


def skew(vector: np.ndarray) -> np.ndarray:
    """Return the matrix of v x, (3, 3)."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def held(stop: Stop, position: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Return the force of a stop against a motion of n coordinates in any direction, (n,).

    Eq. (K17):  F = k max(0, |q| - play) q/|q| + d q'

    Parameters
    ----------
    stop : Stop
    position, velocity : ndarray, shape (n,)
    """
    size = float(np.linalg.norm(position))
    # Eq. (K17)
    share = 1 - stop.play / size if size > stop.play else 0.0
    return stop.stiffness * share * position + stop.damping * velocity


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


def place_of(bodies: SpaceBodies, now: Motion, crank: CrankMotion) -> SpaceKinematics:
    """Return the position and motion of all parts.

    Eq. (K18):  A'' = (x_A'', Y'', z''),   t = (roll, yaw, 0),   W = (roll', yaw', w)
                W' = (roll'' - w yaw', yaw'' + w roll', w')        w the rocking velocity

    Parameters
    ----------
    bodies : SpaceBodies
    now : Motion
        n = 5.
    crank : CrankMotion
    """
    mechanism = bodies.mechanism
    q, dq, ddq = now
    link = motion(mechanism, lateral_motion(now), crank)
    axes = turned(q[ROCKING])
    # Eq. (K18)
    of_A = np.array([ddq[LATERAL], link.axial_acceleration])
    w = dq[ROCKING]
    spin = Spin(
        acceleration=np.array([*(axes.T @ of_A), ddq[SHIFT]]),
        tilt=np.array([bodies.tilt + q[ROLL], q[YAW], 0.0]),
        velocity=np.array([dq[ROLL], dq[YAW], w]),
        change=np.array([ddq[ROLL] - w * dq[YAW], ddq[YAW] + w * dq[ROLL], ddq[ROCKING]]),
    )
    return SpaceKinematics(link, axes, of_A, spin, with_pin(bodies))


def with_pin(bodies: SpaceBodies) -> SpaceBody:
    """Return the piston with the pin's inertia about its diameters.

    The pin does not turn with the rocking angle, and its mass at A is counted separately.
    """
    thin = bodies.pin_inertia * np.diag([1.0, 1.0, 0.0])
    return bodies.piston._replace(J=bodies.piston.J + thin)


def imbalance(
    bodies: SpaceBodies, load: SpaceLoad, now: Motion, crank: CrankMotion
) -> SpaceImbalance:
    """Return the residual of the equations of motion.

    Eq. (D27):  x_A:    T_x + f1 T_y + rod + M psi1 = 0
                angle:  M_z - M - (moment + guided x_A) = 0
                z:      F_z + m_pin z'' - roll (T_y - guided) + yaw T_x - load_z + K_z = 0
                roll:   M_x - z (T_y - guided) - load_roll + K_roll = 0
                yaw:    M_y + z T_x + roll guided (p + x_A) - load_yaw + K_yaw = 0
                G = R F - load,   T = G + m_pin A''
    F, M of Eq. (D26), of piston and pin; G: force of the pin on the piston; T: that of the rod on
    the pin, square to it, in the rod's plane; M: friction of the pin (Eq. (K7)); K: what stops and
    dampers hold (Eq. (K17)); p: the pin offset. With z = roll = yaw = 0 the pin is tied.
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
    mechanism = bodies.mechanism
    at = place_of(bodies, now, crank)
    force, moment = needed(at.together, at.spin)
    *in_plane, force_z = force
    moment_x, moment_y, moment_z = moment
    # Eq. (D27)
    on_piston = at.axes @ in_plane - [load.lateral, load.axial]
    pull = on_piston + mechanism.pin_mass * at.of_A
    slip = now.velocity[ROCKING] - at.link.rod.velocity
    pin_x, pin_y = on_piston
    friction = friction_moment(mechanism.friction, float(pin_x), float(pin_y), slip).moment
    q = now.position
    roll, *_ = at.spin.tilt
    pull_x, pull_y = pull
    along, about_x, about_y = _held(bodies, now)
    load_z, load_roll, load_yaw = load.across
    rod_force = at.link.rod_force + friction * at.link.rod.slope
    square = _square(load, pull, at.spin.tilt)
    z = q[SHIFT]
    arm = bodies.pin_offset + q[LATERAL]
    residual = np.array(
        [
            pull_x + at.link.slope * pull_y + rod_force,
            moment_z - friction - (load.moment + load.guided * q[LATERAL]),
            force_z + mechanism.pin_mass * now.acceleration[SHIFT] - square - load_z + along,
            moment_x - z * (pull_y - load.guided) - load_roll + about_x,
            moment_y + z * pull_x + roll * load.guided * arm - load_yaw + about_y,
        ]
    )
    lever = at.link.slope * mechanism.crank_radius * np.cos(crank.angle)
    lever -= mechanism.crank_radius * np.sin(crank.angle)
    torque = pull_y * lever + at.link.rod_moment + friction * at.link.rod.lever
    holding = -np.array([along, about_x, about_y])
    return SpaceImbalance(residual, on_piston, friction, pull, holding, float(torque))


def _square(load, pull, tilt):
    """Return the force along z of rod and gas on a pin that is tilted."""
    roll, yaw, _ = tilt
    pull_x, pull_y = pull
    return roll * (pull_y - load.guided) - yaw * pull_x


def _held(bodies, now):
    """Return what holds z, roll and yaw, (3,)."""
    ways = (bodies.along, slice(SHIFT, ROLL)), (bodies.askew, slice(ROLL, COORDINATES))
    return np.concatenate([held(stop, now.position[way], now.velocity[way]) for stop, way in ways])


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

    def residual(way: np.ndarray) -> np.ndarray:
        moved = Motion(*(one + c * way for one, c in zip(now, (c2, c1, 1.0))))
        return imbalance(bodies, load, moved, crank).residual

    return np.column_stack([(residual(way) - residual(-way)) / 2 for way in np.eye(COORDINATES)])


def block_force(
    bodies: SpaceBodies,
    load: SpaceLoad,
    crank_unbalance: float,
    now: Motion,
    crank: CrankMotion,
    lack: SpaceImbalance,
) -> tuple[BlockForce, tuple[float, float, float]]:
    """Return the forces on the block in the plane, then force along z and moments about x and y.

    Eq. (D53):  F_b = -(T + m_r G'' + U u''),   F and M_z of Eq. (D25), u towards the crank pin
                F_z = -Z,   Z = roll (T_y - guided) - yaw T_x + load_z - K_z
                M_x = -(load_roll - K_roll + Y Z - z (load_y + guided))
                M_y = -(load_yaw - K_yaw - x Z + z load_x - guided roll (p + x_A))
                (x, Y, z): A from the crank axis, the rest of Eq. (D27)

    Parameters
    ----------
    bodies, load, now, crank
        As for `imbalance`.
    crank_unbalance : float
        U [kg m].
    lack : SpaceImbalance
        Of the same motion.

    Returns
    -------
    BlockForce, tuple
        All that acts on the block, the main bearings' too, on the crank axis [N], [N m].
    """
    mechanism = bodies.mechanism
    at = place_of(bodies, now, crank)
    k = mechanism.rod_centre
    towards = np.array([-np.sin(crank.angle), np.cos(crank.angle)])
    onward = np.array([-towards[1], towards[0]])
    flung = onward * crank.acceleration - towards * crank.speed**2
    rod = (1 - k) * mechanism.crank_radius * flung + k * at.of_A
    # Eq. (D53)
    bearing = -(lack.from_rod + mechanism.rod_mass * rod + crank_unbalance * flung)
    lateral, _, z, *_ = now.position
    x = mechanism.offset + lateral
    y = height(mechanism, lateral, crank.angle).height
    plane = Load(load.lateral, load.axial, load.moment, load.guided, np.zeros(0))
    along, about_x, about_y = lack.held
    load_z, load_roll, load_yaw = load.across
    needed_z = _square(load, lack.from_rod, at.spin.tilt) + load_z + along
    leaning = load.guided * at.spin.tilt[0] * (bodies.pin_offset + lateral)
    moment_x = load_roll + about_x + y * needed_z - z * (load.axial + load.guided)
    moment_y = load_yaw + about_y - x * needed_z + z * load.lateral - leaning
    on = all_on_block(plane, lateral, x, y, *bearing)
    return on, (-needed_z, -moment_x, -moment_y)


def pushed(
    bodies: SpaceBodies, load: SpaceLoad, now: Motion, crank: CrankMotion, change: SpaceLoad
) -> np.ndarray:
    """Compute the change of the residual (Eq. (D27)) with a change of the load, (5,).

    It is a central difference over changes of at most 1 N or 1 N m: only the friction of the pin
    is not linear in the load.
    """
    share = 1.0 / max(1e-300, *map(abs, (*change[:-1], *change.across)))

    def residual(share: float) -> np.ndarray:
        changed = SpaceLoad._make(one + share * more for one, more in zip(load, change))
        return imbalance(bodies, changed, now, crank).residual

    return (residual(share) - residual(-share)) / (2 * share)


def inertia(bodies: SpaceBodies) -> np.ndarray:
    """Return M, (5, 5), of the motion across the bore.

    Eq. (D28):  q' . M q' = (m + m_pin) |V|^2 + 2 V . (W x S) + W . J W
                V = (x_A', 0, z'),   W = (roll', yaw', rocking velocity)       the piston upright

    Driven motion along the bore is none of it, nor is the rod, as with a piston in its plane.
    """
    body = with_pin(bodies)
    lateral, rocking, shift, roll, yaw = np.eye(COORDINATES)
    V = np.array([lateral, np.zeros(COORDINATES), shift])
    W = np.array([roll, yaw, rocking])
    # Eq. (D28)
    coupled = V.T @ (-skew(body.S)) @ W
    mass = body.mass + bodies.mechanism.pin_mass
    return mass * V.T @ V + coupled + coupled.T + W.T @ body.J @ W


def inertia_with_rod(bodies: SpaceBodies) -> np.ndarray:
    """Return M of `inertia` and of the rod that swings with x_A (Eq. (K12))."""
    M = inertia(bodies)
    M[LATERAL, LATERAL] += carried_mass(bodies.mechanism)
    return M
