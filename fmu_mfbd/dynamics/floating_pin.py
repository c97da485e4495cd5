"""Equations of motion of a rigid piston, its floating pin and its rod, in coordinates [x_A, rocking
angle, pin from the piston's bosses (x, y), pin from the rod's eye (x, y), angle of the pin].

Bosses and eye hold the pin by their films alone. Where the films are thin the pin moves by
micrometres in them: relative coordinates keep these digits, and the rod stays on the crank without
a constraint to drift from. Plain numpy: seven equations, whatever the films' grids.
"""

from typing import NamedTuple

import numpy as np

from ..geometry.pin import PinResultants, across, cross
from .floating_frame import FlexibleBody
from .generalised_alpha import Motion
from .piston_motion import LATERAL, ROCKING, Load
from .slider_crank import (
    CrankMotion,
    LateralMotion,
    Link,
    Mechanism,
    RodTurn,
    carried_mass,
    motion,
    rod_turn,
)

BOSS_X, BOSS_Y, EYE_X, EYE_Y, SPIN = range(2, 7)
"""Coordinates of the pin: its axis from that of the piston's bosses and of the rod's eye [m], along
x and y in space; its angle about +z [rad]."""

COORDINATES = 7
OF_PIN = COORDINATES - BOSS_X

UNIT = np.eye(COORDINATES)
SMALL_END = UNIT[LATERAL] + UNIT[BOSS_X] - UNIT[EYE_X]
"""x of the rod's eye from its concentric place, by the coordinates."""

PLAY = np.array([BOSS_X, BOSS_Y, EYE_X, EYE_Y])
"""Coordinates that films hold within a clearance."""


class Bodies(NamedTuple):
    """Piston, mechanism, and the pin's moment of inertia about its axis [kg m2]."""

    piston: FlexibleBody
    mechanism: Mechanism
    spin_inertia: float


class PinFilms(NamedTuple):
    """What the films of the pin do, those of all bosses together, and that in the eye; `force`
    acts on the pin.
    """

    bosses: PinResultants
    eye: PinResultants


class Place(NamedTuple):
    """Where the mechanism stands and how it moves.

    Parameters
    ----------
    link : Link
        Of the rod's eye.
    rod : RodTurn
    arm : ndarray, shape (2,)
        First moment of the piston about A in space, R S [kg m].
    piston, pin : ndarray, shape (2,)
        Accelerations of A and of the pin's axis [m/s2].
    """

    link: Link
    rod: RodTurn
    arm: np.ndarray
    piston: np.ndarray
    pin: np.ndarray


class Lack(NamedTuple):
    """What the equations of motion lack.

    Parameters
    ----------
    residual : ndarray, shape (7,)
        [N], [N m]
    on_piston : ndarray, shape (2,)
        Force that piston needs of its pin, G [N].
    above_eye : float
        Force along y that piston and pin need of the rod, T [N].
    torque : float
        Of the drive on the crank [N m].
    """

    residual: np.ndarray
    on_piston: np.ndarray
    above_eye: float
    torque: float


def eye_motion(now: Motion) -> LateralMotion:
    """How the rod's eye moves across the bore."""
    return LateralMotion(*(float(SMALL_END @ one) for one in now))


def place_of(bodies: Bodies, now: Motion, crank: CrankMotion) -> Place:
    """Where everything stands.

    Eq. (K16):  x_S = x_A + a_x - e_x,   Y_S by Eq. (K1) of x_S
                Y_P = Y_S + e_y,   Y_A = Y_P - a_y,   x_P = x_A + a_x
                a = P - A, pin from bosses; e = P - S, pin from the rod's eye

    Parameters
    ----------
    bodies : Bodies
    now : Motion
        n = 7.
    crank : CrankMotion
    """
    eye = eye_motion(now)
    link = motion(bodies.mechanism, eye, crank)
    rod = rod_turn(bodies.mechanism, eye.position, eye.velocity, crank.angle, crank.speed)
    angle = now.position[ROCKING]
    c = np.cos(angle)
    s = np.sin(angle)
    x, y = bodies.piston.S
    a = now.acceleration
    # Eq. (K16)
    high = link.axial_acceleration + a[EYE_Y]
    return Place(
        link=link,
        rod=rod,
        arm=np.array([c * x - s * y, s * x + c * y]),
        piston=np.array([a[LATERAL], high - a[BOSS_Y]]),
        pin=np.array([a[LATERAL] + a[BOSS_X], high]),
    )


def imbalance(bodies: Bodies, load: Load, now: Motion, crank: CrankMotion, films: PinFilms) -> Lack:
    """Residual of the equations of motion, by virtual work.

    Eq. (D21):  x_A:    G_x + K_x + N = 0
                angle:  I - M_piston = 0
                a:      K_x + N - B_x = 0,   -G_y - B_y = 0
                e:      -N - E_x = 0,   T - E_y = 0
                phi:    J phi'' - M_pin = 0
                G = m A'' + angle'' Z s - angle'^2 s - load,   s = R S
                I = Z s . A'' + I_0 angle'' - (moment + guided x_A)
                K = m_pin P'',   T = G_y + K_y
                N = f1 T + rod - psi1 M_rod        f1, rod, psi1 of Eqs. (K2) to (K4) at x_S
    B, E: force of the films in bosses and eye on the pin; M_piston, M_rod: their moments on the
    shells; M_pin: of all of them on the pin. With a = e = 0 the first and the last but two
    together are Eq. (D5), with the films' moments for the friction.

    Parameters
    ----------
    bodies : Bodies
    load : Load
        On the piston, all but the pin's.
    now : Motion
        n = 7.
    crank : CrankMotion
    films : PinFilms
    """
    at = place_of(bodies, now, crank)
    piston = bodies.piston
    mechanism = bodies.mechanism
    link = at.link
    turning = now.velocity[ROCKING]
    spin = now.acceleration[ROCKING]
    needed = np.array([load.lateral, load.axial])
    # Eq. (D21)
    on_piston = piston.mass * at.piston + spin * across(at.arm) - turning**2 * at.arm - needed
    moment = load.moment + load.guided * now.position[LATERAL]
    rocking = cross(at.arm, at.piston) + piston.I0 * spin - moment
    pin_x, pin_y = mechanism.pin_mass * at.pin
    piston_x, piston_y = on_piston
    above_eye = piston_y + pin_y
    sideways = link.slope * above_eye + link.rod_force - at.rod.slope * films.eye.on_shell
    boss_x, boss_y = films.bosses.force
    eye_x, eye_y = films.eye.force
    on_pin = films.bosses.on_pin + films.eye.on_pin
    residual = np.array(
        [
            piston_x + pin_x + sideways,
            rocking - films.bosses.on_shell,
            pin_x + sideways - boss_x,
            -piston_y - boss_y,
            -sideways - eye_x,
            above_eye - eye_y,
            bodies.spin_inertia * now.acceleration[SPIN] - on_pin,
        ]
    )
    lever = link.slope * mechanism.crank_radius * np.cos(crank.angle)
    lever -= mechanism.crank_radius * np.sin(crank.angle)
    torque = above_eye * lever + link.rod_moment - films.eye.on_shell * at.rod.lever
    return Lack(residual, on_piston, float(above_eye), float(torque))


def tangent(
    bodies: Bodies,
    load: Load,
    now: Motion,
    crank: CrankMotion,
    films: PinFilms,
    to_velocity: np.ndarray,
    to_position: np.ndarray,
) -> np.ndarray:
    """Derivative of the residual (Eq. (D21)) when each end acceleration moves its velocity and its
    position by what the time integrator has them move.

    Parameters
    ----------
    bodies, load, now, crank, films
        As for `imbalance`; the films' nodal forces are held, and turn with their shells.
    to_velocity, to_position : ndarray, shape (7,)
        [s], [s2]

    Returns
    -------
    ndarray, shape (7, 7)
    """
    at = place_of(bodies, now, crank)
    piston = bodies.piston
    link = at.link
    rod = at.rod
    c1 = to_velocity
    c2 = to_position
    angle = UNIT[ROCKING]
    w = now.velocity[ROCKING]
    spin = now.acceleration[ROCKING]
    normal = across(at.arm)
    above_eye = imbalance(bodies, load, now, crank, films).above_eye

    eye_position = SMALL_END * c2
    eye_velocity = SMALL_END * c1
    high = link.axial_by_acceleration * SMALL_END
    high = high + link.axial_by_velocity * eye_velocity + link.axial_by_position * eye_position
    by_piston = np.array([UNIT[LATERAL], high + UNIT[EYE_Y] - UNIT[BOSS_Y]])
    by_pin = np.array([UNIT[LATERAL] + UNIT[BOSS_X], high + UNIT[EYE_Y]])
    with_angle = normal - 2 * w * c1[ROCKING] * at.arm
    with_angle = with_angle - c2[ROCKING] * (spin * at.arm + w**2 * normal)
    on_piston = piston.mass * by_piston + np.outer(with_angle, angle)
    rocking = normal @ by_piston
    rocking = rocking + (piston.I0 - c2[ROCKING] * float(at.arm @ at.piston)) * angle
    rocking = rocking - c2[LATERAL] * load.guided * UNIT[LATERAL]
    on_pin = bodies.mechanism.pin_mass * by_pin
    lifting = on_piston[1] + on_pin[1]
    bent = link.curvature * above_eye - rod.curvature * films.eye.on_shell
    bent += link.rod_force_by_position
    sideways = link.slope * lifting + link.rod_force_by_acceleration * SMALL_END
    sideways = sideways + link.rod_force_by_velocity * eye_velocity + bent * eye_position

    boss_turn = angle * c2[ROCKING]
    eye_turn = rod.slope * eye_position
    boss = np.outer(across(films.bosses.force), boss_turn)
    eye = np.outer(across(films.eye.force), eye_turn)
    boss_x, boss_y = films.bosses.force
    eye_x, eye_y = films.eye.force
    from_boss = now.position[BOSS_X : BOSS_Y + 1]
    from_eye = now.position[EYE_X : EYE_Y + 1]
    levers = boss_y * c2[BOSS_X] * UNIT[BOSS_X] - boss_x * c2[BOSS_Y] * UNIT[BOSS_Y]
    levers = levers + float(from_boss @ films.bosses.force) * boss_turn
    levers = levers + eye_y * c2[EYE_X] * UNIT[EYE_X] - eye_x * c2[EYE_Y] * UNIT[EYE_Y]
    levers = levers + float(from_eye @ films.eye.force) * eye_turn
    return np.array(
        [
            on_piston[0] + on_pin[0] + sideways,
            rocking,
            on_pin[0] + sideways - boss[0],
            -on_piston[1] - boss[1],
            -sideways - eye[0],
            lifting - eye[1],
            bodies.spin_inertia * UNIT[SPIN] + levers,
        ]
    )


def pushed(at: Place, films: PinFilms, skirt: tuple[float, float, float]) -> np.ndarray:
    """What changes of the forces add to the residual (Eq. (D21)), shape (7,).

    Parameters
    ----------
    at : Place
    films : PinFilms
        Changes.
    skirt : (float, float, float)
        Changes of what acts on the piston beside the pin: along x and y [N], about A [N m].
    """
    lateral, axial, moment = skirt
    sideways = -at.link.slope * axial - at.rod.slope * films.eye.on_shell
    boss_x, boss_y = films.bosses.force
    eye_x, eye_y = films.eye.force
    return np.array(
        [
            sideways - lateral,
            -moment - films.bosses.on_shell,
            sideways - boss_x,
            axial - boss_y,
            -sideways - eye_x,
            -axial - eye_y,
            -films.bosses.on_pin - films.eye.on_pin,
        ]
    )


def inertia(bodies: Bodies) -> np.ndarray:
    """M, (7, 7), of the motion across the bore and of the pin in its shells.

    Eq. (D22):  T = q' . M q'/2      of piston and pin, the piston upright, the rod's eye at rest
                                     along the bore

    Driven motion along the bore is none of it, as with a pin that is tied, nor is the rod.
    """
    piston = bodies.piston
    a = np.array([UNIT[LATERAL], UNIT[EYE_Y] - UNIT[BOSS_Y]])
    pin = np.array([UNIT[LATERAL] + UNIT[BOSS_X], UNIT[EYE_Y]])
    lever = np.outer(UNIT[ROCKING], across(piston.S) @ a)
    # Eq. (D22)
    M = piston.mass * a.T @ a + lever + lever.T + bodies.mechanism.pin_mass * pin.T @ pin
    M[ROCKING, ROCKING] += piston.I0
    M[SPIN, SPIN] += bodies.spin_inertia
    return M


def inertia_with_rod(bodies: Bodies) -> np.ndarray:
    """M of `inertia`, (7, 7), and of the rod that swings with its eye (Eqs. (K12), (K16))."""
    eye = UNIT[LATERAL] + UNIT[BOSS_X] - UNIT[EYE_X]
    return inertia(bodies) + carried_mass(bodies.mechanism) * np.outer(eye, eye)
