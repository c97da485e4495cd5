"""Equations of motion of a piston, its floating pin and its rod, by `pin_coordinates`.

Bosses and eye hold the pin by their films alone. Where the films are thin the pin moves by
micrometres in them: relative coordinates keep these digits, and the rod stays on the crank without
a constraint to drift from; with a film in its big end it has two coordinates more, and so has a
crank on a film. Seven equations, one a mode, two a shape and two a film of the crank, whatever the
films' grids. Python runs them as written, a step and a native FMU compile them.

The modes of eye and big end stand in the rod's axes, those of the main bearing in space. They have
the inertia of their own motion alone (Eq. (D40)): what they push the rod by and what its
acceleration bends them by is left out. The mass of the shells is that of rod and block already. The
weight of the eye of `yielding_bosses` at 6700 m/s2 bends it by 0.9 um, a film under 25 kN by 20 to
60 (`tests/bench/small_end.py`).
"""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable
from ..geometry.pin import PinResultants, across, in_axes, in_space, pair, turned
from .floating_frame import (
    FrameForce,
    FrameMotion,
    frame_force,
)
from .generalised_alpha import Motion
from .pin_coordinates import (
    NO_MODES,
    PIN,
    Layout,
    PinBodies,
    eye_motion,
    layout,
    of_modes,
    play_at,
    shift_of,
)
from .piston_motion import LATERAL, ROCKING, Load
from .slider_crank import (
    CrankMotion,
    Link,
    motion,
)

NO_FILM = PinResultants(np.zeros(2), 0.0, 0.0)


class PinFilms(NamedTuple):
    """Resultants of the pin's films: all bosses together, and the eye.

    `force` acts on the pin. The force of the crank's films acts on the crank.

    Parameters
    ----------
    bosses, eye, big_end, main_bearing : PinResultants
    slope_push : ndarray, shape (k,)
        Moment of pressure on the pin, its opposite on the shell, by the slopes that each mode gives
        the bosses (Eq. (G5)) [kg^-1/2 N].
    shell_slope_push : ndarray, shape (m,)
        Likewise of the modes of eye, big end and main bearing.
    on_shells : ndarray, shape (m,)
        Forces on these modes (Eq. (G6)) [kg^-1/2 N].
    """

    bosses: PinResultants
    eye: PinResultants
    slope_push: np.ndarray = NO_MODES
    shell_slope_push: np.ndarray = NO_MODES
    on_shells: np.ndarray = NO_MODES
    big_end: PinResultants = NO_FILM
    main_bearing: PinResultants = NO_FILM


@compilable
def no_film(shapes: int) -> PinResultants:
    """Return no forces, on so many shapes of the pin."""
    return PinResultants(np.zeros(2), 0.0, 0.0, np.zeros((shapes, 2)))


@compilable
def no_films(first: Layout) -> PinFilms:
    """Return films without forces."""
    pin = no_film((first.eye - first.shapes) // 2)
    on_shells = np.zeros(first.crank - first.eye)
    on_modes = np.zeros(first.shapes - first.modes)
    return PinFilms(pin, pin, on_modes, on_shells, on_shells, no_film(0), no_film(0))


@compilable
def on_rod(films: PinFilms) -> float:
    """Return the moments of the films on the rod about the axes of its shells [N m]."""
    return films.eye.on_shell + films.big_end.on_shell


class PinKinematics(NamedTuple):
    """Position and motion of the mechanism.

    Parameters
    ----------
    link : Link
        Of the rod's eye from the place of its big end.
    axes : ndarray, shape (2, 2)
        R, from the piston's axes to space.
    piston, pin, shift, rod_centre, crank : ndarray, shape (2,)
        Accelerations of A, of the pin's axis, of the rod's big end from its place on a crank
        without play, of the rod's centre of mass, of the crank's journal [m/s2].
    frame : FrameMotion
        Of the piston.
    """

    link: Link
    axes: np.ndarray
    piston: np.ndarray
    pin: np.ndarray
    shift: np.ndarray
    rod_centre: np.ndarray
    crank: np.ndarray
    frame: FrameMotion


class PinImbalance(NamedTuple):
    """Imbalance of the equations of motion.

    Parameters
    ----------
    residual : ndarray, shape (7 + k + 2 n,)
        [N], [N m], [kg^-1/2 N], [N]
    on_piston : ndarray, shape (2,)
        Force that piston needs of its pin, G [N].
    above_eye : float
        Force along y that piston and pin need of the rod, T [N].
    torque : float
        Of the drive on the crank [N m].
    on_bearings : ndarray, shape (2,)
        Force of the crank on its main bearings [N].
    at : PinKinematics
    force : FrameForce
        That the piston's frame needs, in its own axes.
    """

    residual: np.ndarray
    on_piston: np.ndarray
    above_eye: float
    torque: float
    on_bearings: np.ndarray
    at: PinKinematics
    force: FrameForce


@compilable
def towards_crank_pin(angle: float) -> np.ndarray:
    """Return the unit vector from the crank's axis to its pin, (2,)."""
    return pair(-np.sin(angle), np.cos(angle))


@compilable
def turning(vector: np.ndarray, crank: CrankMotion) -> np.ndarray:
    """Return the acceleration of what turns with the crank, (2,) [m/s2].

    Eq. (K26):  u'' = Z u w' - u w^2      Z: a quarter about +z
    """
    onward = across(vector)
    # Eq. (K26)
    return pair(
        onward[0] * crank.acceleration - vector[0] * crank.speed**2,
        onward[1] * crank.acceleration - vector[1] * crank.speed**2,
    )


@compilable
def place_of(bodies: PinBodies, now: Motion, crank: CrankMotion) -> PinKinematics:
    """Return the position and motion of all parts.

    Eq. (K16):  x_S = x_A + a_x - e_x,   Y_S by Eq. (K1) of x_S
                Y_P = Y_S + e_y,   Y_A = Y_P - a_y,   x_P = x_A + a_x
                a = P - A, pin from bosses; e = P - S, pin from the rod's eye
    Eq. (K25):  O = m,   C = O + r u,   B = C - b = r u + delta,   delta = m - b
                x_S, Y_S of Eqs. (K1) to (K3) at x_S - delta_x, S then shifted by delta
                G'' = delta'' + (1 - k) r u'' + k (S'' - delta'')      of the rod's centre
                m the crank's journal O from the main bearing, b its pin C from the rod's big end B,
                u = (-sin phi, cos phi)

    Parameters
    ----------
    bodies : PinBodies
    now : Motion
        (7 + k + 2 n,)
    crank : CrankMotion
    """
    mechanism = bodies.mechanism
    first = layout(bodies)
    eye = eye_motion(first, now)
    link = motion(mechanism, eye, crank)
    axes = turned(now.position[ROCKING])
    a = now.acceleration
    # Eq. (K25)
    shift = shift_of(first, a)
    k = mechanism.rod_centre
    r = mechanism.crank_radius
    towards = towards_crank_pin(crank.angle)
    crank_pin = turning(pair(r * towards[0], r * towards[1]), crank)
    rod_centre = pair(
        shift[0] + (1 - k) * crank_pin[0] + k * eye.acceleration,
        shift[1] + (1 - k) * crank_pin[1] + k * link.axial_acceleration,
    )
    # Eq. (K16)
    high = link.axial_acceleration + shift[1] + a[PIN.eye_y]
    piston = pair(a[LATERAL], high - a[PIN.boss_y])
    of_A = in_axes(axes, piston)
    frame = FrameMotion(
        of_A[0],
        of_A[1],
        a[ROCKING],
        now.velocity[ROCKING],
        of_modes(first, now.position),
        of_modes(first, now.velocity),
        of_modes(first, a),
    )
    pin = pair(a[LATERAL] + a[PIN.boss_x], high)
    journal = play_at(first.main_bearing, a)
    return PinKinematics(link, axes, piston, pin, shift, rod_centre, journal, frame)


@compilable
def imbalance(
    bodies: PinBodies, load: Load, now: Motion, crank: CrankMotion, films: PinFilms
) -> PinImbalance:
    """Return the residual of the equations of motion.

    Eq. (D21):  x_A:    G_x + K_x + N = 0
                angle:  I - M_piston = 0
                a:      K_x + N - B_x = 0,   -G_y - B_y = 0
                e:      -N - E_x = 0,   T - E_y = 0
                phi:    J phi'' - M_pin = 0
                modes:  F_q - modal = 0
                b:      N - m_r G_x'' - C_x = 0,   -T - m_r G_y'' - C_y = 0
                m:      -N + m_r G_x'' + m_c m_x'' + U u_x'' - O_x = 0
                        T + m_r G_y'' + m_c m_y'' + U u_y'' - O_y = 0
                shapes: s'' + D s' + K s - Q = 0        Q of Eq. (G8), of all films
                shells: Eq. (D40)
                G = R F - load,   I = F_t - (moment + guided x_A)
                F, F_t, F_q the frame's rows, Eqs. (D1) to (D3), at R^T A''
                K = m_pin P'',   T = G_y + K_y
                N = f1 T + rod - psi1 M_rod        f1, rod, psi1 of Eqs. (K2) to (K4) at x_S
                rod += k m_r (delta_x'' + f1 delta_y'')      where the big end has play (Eq. (K25))
    Eq. (D40):  q'' + D q' + omega^2 q = Q      Q of Eq. (G6), in the axes of the shell
    B, E: force of the films in bosses and eye on the pin; C, O: of those in big end and main
    bearing on the crank, of mass m_c and unbalance U; M_piston, M_rod: their moments on the shells;
    M_pin: of all of them on the pin. The drive holds the crank's speed against their moments on
    crank pin and journal besides. With a = e = 0 the first and those of angle and modes
    together are Eq. (D5), with the films' moments for the friction.

    Parameters
    ----------
    bodies : PinBodies
    load : Load
        On the piston, all but the pin's; `modal` with that of the bosses' films.
    now : Motion
        (7 + k + 2 n,)
    crank : CrankMotion
    films : PinFilms
    """
    at = place_of(bodies, now, crank)
    first = layout(bodies)
    mechanism = bodies.mechanism
    link = at.link
    force = frame_force(bodies.piston, at.frame)
    # Eq. (D21)
    needed = in_space(at.axes, pair(force.x, force.y))
    on_piston = pair(needed[0] - load.lateral, needed[1] - load.axial)
    rocking = force.moment - (load.moment + load.guided * now.position[LATERAL])
    pin_x = mechanism.pin_mass * at.pin[0]
    pin_y = mechanism.pin_mass * at.pin[1]
    above_eye = on_piston[1] + pin_y
    carried = mechanism.rod_centre * mechanism.rod_mass
    sideways = link.slope * above_eye + link.rod_force - link.rod.slope * on_rod(films)
    sideways += carried * (at.shift[0] + link.slope * at.shift[1])
    boss = films.bosses.force
    in_eye = films.eye.force
    at_big_end = pair(
        sideways - mechanism.rod_mass * at.rod_centre[0],
        -above_eye - mechanism.rod_mass * at.rod_centre[1],
    )
    towards = towards_crank_pin(crank.angle)
    flung = turning(towards, crank)
    thrown = pair(
        bodies.crank.mass * at.crank[0] + bodies.crank.unbalance * flung[0],
        bodies.crank.mass * at.crank[1] + bodies.crank.unbalance * flung[1],
    )
    on_bearings = pair(at_big_end[0] - thrown[0], at_big_end[1] - thrown[1])
    on_pin = films.bosses.on_pin + films.eye.on_pin
    residual = np.empty(first.size)
    residual[LATERAL] = on_piston[0] + pin_x + sideways
    residual[ROCKING] = rocking - films.bosses.on_shell
    residual[PIN.boss_x] = pin_x + sideways - boss[0]
    residual[PIN.boss_y] = -on_piston[1] - boss[1]
    residual[PIN.eye_x] = -sideways - in_eye[0]
    residual[PIN.eye_y] = above_eye - in_eye[1]
    residual[PIN.spin] = bodies.spin_inertia * now.acceleration[PIN.spin] - on_pin
    for k in range(len(bodies.piston.stiffness)):
        residual[first.modes + k] = force.modal[k] - load.modal[k]
    shapes = bodies.shapes
    n = len(shapes.stiffness)
    for k in range(n):
        for way in range(2):
            m = first.shapes + way * n + k
            held = shapes.damping[k] * now.velocity[m] + shapes.stiffness[k] * now.position[m]
            push = films.bosses.on_shapes[k, way] + films.eye.on_shapes[k, way]
            residual[m] = now.acceleration[m] + held - push
    springs = bodies.shells
    for k in range(len(springs.stiffness)):
        # Eq. (D40)
        m = first.eye + k
        held = springs.damping[k] * now.velocity[m] + springs.stiffness[k] * now.position[m]
        residual[m] = now.acceleration[m] + held - films.on_shells[k]
    for way in range(2):
        if first.big_end >= 0:
            residual[first.big_end + way] = at_big_end[way] - films.big_end.force[way]
        if first.main_bearing >= 0:
            journal = -on_bearings[way] - films.main_bearing.force[way]
            residual[first.main_bearing + way] = journal
    lever = link.slope * mechanism.crank_radius * np.cos(crank.angle)
    lever -= mechanism.crank_radius * np.sin(crank.angle)
    torque = above_eye * lever + link.rod_moment - on_rod(films) * link.rod.lever
    onward = across(towards)
    behind = (1 - mechanism.rod_centre) * mechanism.crank_radius
    by_centre = pair(behind * onward[0], behind * onward[1] + mechanism.rod_centre * lever)
    torque += mechanism.rod_mass * (by_centre[0] * at.shift[0] + by_centre[1] * at.shift[1])
    torque += bodies.crank.unbalance * (onward[0] * at.crank[0] + onward[1] * at.crank[1])
    torque -= films.big_end.on_pin + films.main_bearing.on_pin
    return PinImbalance(residual, on_piston, above_eye, torque, on_bearings, at, force)


@compilable
def generalised_forces(first: Layout, films: PinFilms, on_piston: Load) -> np.ndarray:
    """Return the generalised forces, but for what they do along the driven motion.

    Parameters
    ----------
    first : Layout
    films : PinFilms
    on_piston : Load
        Of others than the pin.

    Returns
    -------
    ndarray, shape (7 + k + 2 n,)
    """
    out = np.empty(first.size)
    out[LATERAL] = on_piston.lateral
    out[ROCKING] = on_piston.moment + films.bosses.on_shell
    out[PIN.boss_x] = films.bosses.force[0]
    out[PIN.boss_y] = films.bosses.force[1]
    out[PIN.eye_x] = films.eye.force[0]
    out[PIN.eye_y] = films.eye.force[1]
    out[PIN.spin] = films.bosses.on_pin + films.eye.on_pin
    for k in range(first.shapes - first.modes):
        out[first.modes + k] = on_piston.modal[k]
    n = (first.eye - first.shapes) // 2
    for k in range(n):
        for way in range(2):
            push = films.bosses.on_shapes[k, way] + films.eye.on_shapes[k, way]
            out[first.shapes + way * n + k] = push
    for k in range(first.crank - first.eye):
        out[first.eye + k] = films.on_shells[k]
    for way in range(2):
        if first.big_end >= 0:
            out[first.big_end + way] = films.big_end.force[way]
        if first.main_bearing >= 0:
            out[first.main_bearing + way] = films.main_bearing.force[way]
    return out


@compilable
def pushed(first: Layout, link: Link, films: PinFilms, on_piston: Load) -> np.ndarray:
    """Return what changes of the forces add to the residual of Eq. (D21), shape (7 + k + 2 n,).

    Parameters
    ----------
    first : Layout
    link : Link
    films : PinFilms
        Changes.
    on_piston : Load
        Of others than the pin.
        Changes.
    """
    along = on_piston.axial
    sideways = -link.slope * along - link.rod.slope * on_rod(films)
    out = generalised_forces(first, films, on_piston)
    for k in range(len(out)):
        out[k] = -out[k]
    out[LATERAL] += sideways
    out[PIN.boss_x] += sideways
    out[PIN.boss_y] += along
    out[PIN.eye_x] -= sideways
    out[PIN.eye_y] -= along
    if first.big_end >= 0:
        out[first.big_end] += sideways
        out[first.big_end + 1] += along
    if first.main_bearing >= 0:
        out[first.main_bearing] -= sideways
        out[first.main_bearing + 1] -= along
    return out
