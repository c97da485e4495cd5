"""Equations of motion of a piston, its floating pin and its rod, in coordinates [x_A, rocking
angle, pin from the piston's bosses (x, y), pin from the rod's eye (x, y), angle of the pin, modal
coordinates of the piston, shapes of the pin's axis along x, along y, modal coordinates of the rod's
eye, crank pin from the rod's big end (x, y), crank's journal from the main bearing (x, y)], the
last two where they have films.

Bosses and eye hold the pin by their films alone. Where the films are thin the pin moves by
micrometres in them: relative coordinates keep these digits, and the rod stays on the crank without
a constraint to drift from; with a film in its big end it has two coordinates more, and so has a
crank on a film. Seven equations, one a mode, two a shape and two a film of the crank, whatever the
films' grids. Python runs them as written, a step and a native FMU compile them.

The eye's modes stand in the rod's axes and have the inertia of their own motion alone (Eq. (D40)):
what they push the rod by and what its acceleration bends them by is left out. The eye's mass is
the rod's already; what it weighs at 6700 m/s2 bends that of `yielding_bosses` by 0.9 um, a film
under 25 kN by 20 to 60 (`tests/bench/small_end.py`).
"""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable, compiled
from ..geometry.pin import PinResultants, across, in_axes, in_space, pair, turned
from ..geometry.pin_shapes import STRAIGHT, AxisShapes
from .floating_frame import RIGID as FRAME
from .floating_frame import (
    TURN,
    FlexibleBody,
    FrameForce,
    FrameMotion,
    X,
    Y,
    frame_arrow,
    frame_force,
    mode_coupling,
)
from .generalised_alpha import Motion
from .modal_damping import ModalSprings
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
"""Without modes, shapes of the pin and others, which follow in blocks (`layout`)."""

NO_MODES = np.zeros(0)
"""Modal coordinates or forces of a rigid piston."""

NOWHERE = -1
"""Where a block of coordinates begins that there is none of."""


RIGID_EYE = ModalSprings(np.zeros(0), np.zeros(0))
"""Of a rigid eye."""


class Crankshaft(NamedTuple):
    """The crank, where rod or block hold it by films.

    Parameters
    ----------
    big_end, main_bearing : bool
        Which of `CRANK_SURFACES` have a film.
    mass : float
        That moves with the journal in the main bearing [kg].
    unbalance : float
        Mass times distance towards the crank pin [kg m].
    """

    big_end: bool = False
    main_bearing: bool = False
    mass: float = 0.0
    unbalance: float = 0.0


RIGID_CRANK = Crankshaft()
"""One that turns about a fixed axis, with the rod on it without play."""


class Bodies(NamedTuple):
    """Piston with all its modes, mechanism, the pin's moment of inertia about its axis [kg m2],
    shapes of its axis, modes of the rod's eye, the crank.
    """

    piston: FlexibleBody
    mechanism: Mechanism
    spin_inertia: float
    shapes: AxisShapes = STRAIGHT
    eye: ModalSprings = RIGID_EYE
    crank: Crankshaft = RIGID_CRANK

    def bent(self, coordinates: np.ndarray) -> np.ndarray:
        """Those of the pin's shapes, (n, 2)."""
        return of_shapes(layout(self), coordinates)

    def in_eye(self, coordinates: np.ndarray) -> np.ndarray:
        """Those of the eye's modes, (m,)."""
        return of_eye(layout(self), coordinates)


class Layout(NamedTuple):
    """Number of the first coordinate of each block, `crank` of its films together, `NOWHERE` of
    those that it has not; and of coordinates in all.
    """

    modes: int
    shapes: int
    eye: int
    crank: int
    big_end: int
    main_bearing: int
    size: int


@compilable
def layout(bodies: Bodies) -> Layout:
    """Where each block of coordinates begins; the one list of them."""
    shapes = COORDINATES + len(bodies.piston.stiffness)
    eye = shapes + 2 * len(bodies.shapes.mass)
    crank = eye + len(bodies.eye.stiffness)
    end = crank
    big_end = NOWHERE
    main_bearing = NOWHERE
    if bodies.crank.big_end:
        big_end = end
        end += 2
    if bodies.crank.main_bearing:
        main_bearing = end
        end += 2
    return Layout(COORDINATES, shapes, eye, crank, big_end, main_bearing, end)


@compilable
def of_modes(first: Layout, coordinates: np.ndarray) -> np.ndarray:
    """Those of the piston's modes, (k,)."""
    return coordinates[first.modes : first.shapes]


@compilable
def of_shapes(first: Layout, coordinates: np.ndarray) -> np.ndarray:
    """Those of the pin's shapes, (n, 2)."""
    n = (first.eye - first.shapes) // 2
    out = np.empty((n, 2))
    for k in range(n):
        out[k, 0] = coordinates[first.shapes + k]
        out[k, 1] = coordinates[first.shapes + n + k]
    return out


@compilable
def of_eye(first: Layout, coordinates: np.ndarray) -> np.ndarray:
    """Those of the eye's modes, (m,)."""
    return coordinates[first.eye : first.crank]


@compilable
def play_at(first: int, coordinates: np.ndarray) -> np.ndarray:
    """Those of a film of the crank that begin there, (2,); 0 without it."""
    if first < 0:
        return np.zeros(2)
    return pair(coordinates[first], coordinates[first + 1])


@compilable
def shift_of(first: Layout, coordinates: np.ndarray) -> np.ndarray:
    """By which the rod's big end lies beside its place on a crank without play (Eq. (K25)), or its
    change, (2,).
    """
    journal = play_at(first.main_bearing, coordinates)
    crank_pin = play_at(first.big_end, coordinates)
    return pair(journal[0] - crank_pin[0], journal[1] - crank_pin[1])


@compilable
def is_held(coordinate: int) -> bool:
    """Whether it is held so stiffly that a step sees none of its inertia: play and what yields."""
    return BOSS_X <= coordinate <= EYE_Y or coordinate >= COORDINATES


NO_FILM = PinResultants(np.zeros(2), 0.0, 0.0)


class PinFilms(NamedTuple):
    """What the films of the pin do, those of all bosses together, and that in the eye; `force`
    acts on the pin, of the crank's films on the crank.

    Parameters
    ----------
    bosses, eye, big_end, main_bearing : PinResultants
    slope_push : ndarray, shape (k,)
        Moment of pressure on the pin, its opposite on the shell, by the slopes that each mode gives
        the bosses (Eq. (G5)) [kg^-1/2 N].
    eye_slope_push : ndarray, shape (m,)
        Likewise of the eye's modes.
    on_eye : ndarray, shape (m,)
        Forces on the eye's modes (Eq. (G6)) [kg^-1/2 N].
    """

    bosses: PinResultants
    eye: PinResultants
    slope_push: np.ndarray = NO_MODES
    eye_slope_push: np.ndarray = NO_MODES
    on_eye: np.ndarray = NO_MODES
    big_end: PinResultants = NO_FILM
    main_bearing: PinResultants = NO_FILM


@compilable
def on_rod(films: PinFilms) -> float:
    """Moments of the films on the rod about the axes of its shells [N m]."""
    return films.eye.on_shell + films.big_end.on_shell


class Place(NamedTuple):
    """Where the mechanism stands and how it moves.

    Parameters
    ----------
    link : Link
        Of the rod's eye from the place of its big end.
    rod : RodTurn
    axes : ndarray, shape (2, 2)
        R, from the piston's axes to space.
    piston, pin, shift, rod_centre, crank : ndarray, shape (2,)
        Accelerations of A, of the pin's axis, of the rod's big end from its place on a crank
        without play, of the rod's centre of mass, of the crank's journal [m/s2].
    frame : FrameMotion
        Of the piston.
    """

    link: Link
    rod: RodTurn
    axes: np.ndarray
    piston: np.ndarray
    pin: np.ndarray
    shift: np.ndarray
    rod_centre: np.ndarray
    crank: np.ndarray
    frame: FrameMotion


class Lack(NamedTuple):
    """What the equations of motion lack.

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
    at : Place
    force : FrameForce
        That the piston's frame needs, in its own axes.
    """

    residual: np.ndarray
    on_piston: np.ndarray
    above_eye: float
    torque: float
    at: Place
    force: FrameForce


@compilable
def small_end(first: Layout, coordinates: np.ndarray) -> float:
    """x of the rod's eye from its concentric place, less that of its big end from the place on a
    crank without play, or its change in time, by the coordinates'.
    """
    aside = shift_of(first, coordinates)
    return coordinates[LATERAL] + coordinates[BOSS_X] - coordinates[EYE_X] - aside[0]


@compilable
def eye_motion(first: Layout, now: Motion) -> LateralMotion:
    """How the rod's eye moves across the bore, seen from its big end."""
    return LateralMotion(
        small_end(first, now.position),
        small_end(first, now.velocity),
        small_end(first, now.acceleration),
    )


@compilable
def towards_crank_pin(angle: float) -> np.ndarray:
    """Unit vector from the crank's axis to its pin, (2,)."""
    return pair(-np.sin(angle), np.cos(angle))


@compilable
def turning(vector: np.ndarray, crank: CrankMotion) -> np.ndarray:
    """Acceleration of what turns with the crank, (2,) [m/s2].

    Eq. (K26):  u'' = Z u w' - u w^2      Z: a quarter about +z
    """
    onward = across(vector)
    # Eq. (K26)
    return pair(
        onward[0] * crank.acceleration - vector[0] * crank.speed**2,
        onward[1] * crank.acceleration - vector[1] * crank.speed**2,
    )


@compilable
def place_of(bodies: Bodies, now: Motion, crank: CrankMotion) -> Place:
    """Where everything stands.

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
    bodies : Bodies
    now : Motion
        (7 + k + 2 n,)
    crank : CrankMotion
    """
    mechanism = bodies.mechanism
    first = layout(bodies)
    eye = eye_motion(first, now)
    link = motion(mechanism, eye, crank)
    rod = rod_turn(mechanism, eye.position, eye.velocity, crank.angle, crank.speed)
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
    high = link.axial_acceleration + shift[1] + a[EYE_Y]
    piston = pair(a[LATERAL], high - a[BOSS_Y])
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
    pin = pair(a[LATERAL] + a[BOSS_X], high)
    journal = play_at(first.main_bearing, a)
    return Place(link, rod, axes, piston, pin, shift, rod_centre, journal, frame)


@compilable
def imbalance(bodies: Bodies, load: Load, now: Motion, crank: CrankMotion, films: PinFilms) -> Lack:
    """Residual of the equations of motion, by virtual work.

    Eq. (D21):  x_A:    G_x + K_x + N = 0
                angle:  I - M_piston = 0
                a:      K_x + N - B_x = 0,   -G_y - B_y = 0
                e:      -N - E_x = 0,   T - E_y = 0
                phi:    J phi'' - M_pin = 0
                modes:  F_q - modal = 0
                b:      N - m_r G_x'' - C_x = 0,   -T - m_r G_y'' - C_y = 0
                m:      -N + m_r G_x'' + m_c m_x'' + U u_x'' - O_x = 0
                        T + m_r G_y'' + m_c m_y'' + U u_y'' - O_y = 0
                shapes: m s'' + D s' + K s - Q = 0      Q of Eq. (G8), of all films
                eye:    Eq. (D40)
                G = R F - load,   I = F_t - (moment + guided x_A)
                F, F_t, F_q the frame's rows, Eqs. (D1) to (D3), at R^T A''
                K = m_pin P'',   T = G_y + K_y
                N = f1 T + rod - psi1 M_rod        f1, rod, psi1 of Eqs. (K2) to (K4) at x_S
                rod += k m_r (delta_x'' + f1 delta_y'')      where the big end has play (Eq. (K25))
    Eq. (D40):  q'' + D q' + omega^2 q = Q      Q of Eq. (G6), in the rod's axes
    B, E: force of the films in bosses and eye on the pin; C, O: of those in big end and main
    bearing on the crank, of mass m_c and unbalance U; M_piston, M_rod: their moments on the shells;
    M_pin: of all of them on the pin. The drive holds the crank's speed against their moments on
    crank pin and journal besides. With a = e = 0 the first and those of angle and modes
    together are Eq. (D5), with the films' moments for the friction.

    Parameters
    ----------
    bodies : Bodies
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
    sideways = link.slope * above_eye + link.rod_force - at.rod.slope * on_rod(films)
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
    on_pin = films.bosses.on_pin + films.eye.on_pin
    residual = np.empty(first.size)
    residual[LATERAL] = on_piston[0] + pin_x + sideways
    residual[ROCKING] = rocking - films.bosses.on_shell
    residual[BOSS_X] = pin_x + sideways - boss[0]
    residual[BOSS_Y] = -on_piston[1] - boss[1]
    residual[EYE_X] = -sideways - in_eye[0]
    residual[EYE_Y] = above_eye - in_eye[1]
    residual[SPIN] = bodies.spin_inertia * now.acceleration[SPIN] - on_pin
    for k in range(len(bodies.piston.stiffness)):
        residual[first.modes + k] = force.modal[k] - load.modal[k]
    shapes = bodies.shapes
    n = len(shapes.mass)
    for k in range(n):
        for way in range(2):
            m = first.shapes + way * n + k
            held = shapes.damping[k] * now.velocity[m] + shapes.stiffness[k] * now.position[m]
            push = films.bosses.on_shapes[k, way] + films.eye.on_shapes[k, way]
            residual[m] = shapes.mass[k] * now.acceleration[m] + held - push
    for k in range(len(bodies.eye.stiffness)):
        # Eq. (D40)
        m = first.eye + k
        held = bodies.eye.damping[k] * now.velocity[m] + bodies.eye.stiffness[k] * now.position[m]
        residual[m] = now.acceleration[m] + held - films.on_eye[k]
    for way in range(2):
        if first.big_end >= 0:
            residual[first.big_end + way] = at_big_end[way] - films.big_end.force[way]
        if first.main_bearing >= 0:
            journal = thrown[way] - at_big_end[way] - films.main_bearing.force[way]
            residual[first.main_bearing + way] = journal
    lever = link.slope * mechanism.crank_radius * np.cos(crank.angle)
    lever -= mechanism.crank_radius * np.sin(crank.angle)
    torque = above_eye * lever + link.rod_moment - on_rod(films) * at.rod.lever
    onward = across(towards)
    behind = (1 - mechanism.rod_centre) * mechanism.crank_radius
    by_centre = pair(behind * onward[0], behind * onward[1] + mechanism.rod_centre * lever)
    torque += mechanism.rod_mass * (by_centre[0] * at.shift[0] + by_centre[1] * at.shift[1])
    torque += bodies.crank.unbalance * (onward[0] * at.crank[0] + onward[1] * at.crank[1])
    torque -= films.big_end.on_pin + films.main_bearing.on_pin
    return Lack(residual, on_piston, above_eye, torque, at, force)


@compilable
def tangent(
    bodies: Bodies,
    load: Load,
    now: Motion,
    films: PinFilms,
    lack: Lack,
    to_velocity: np.ndarray,
    to_position: np.ndarray,
) -> np.ndarray:
    """Derivative of the residual (Eq. (D21)) when each end acceleration moves its velocity and its
    position by what the time integrator has them move. A column says what one of them changes.

    Parameters
    ----------
    bodies, load, now, films
        As for `imbalance`; the films' nodal forces are held, and turn with their shells.
    lack : Lack
        Of `imbalance`.
    to_velocity, to_position : ndarray, shape (7 + k + 2 n,)
        [s], [s2]; all modes alike.

    Returns
    -------
    ndarray, shape (7 + k + 2 n, 7 + k + 2 n)
    """
    first = layout(bodies)
    mechanism = bodies.mechanism
    link = lack.at.link
    slope = lack.at.rod.slope
    c1 = to_velocity
    c2 = to_position
    modes = len(bodies.piston.stiffness)
    n = len(bodies.shapes.mass)
    frame = _frame_tangent(bodies.piston, lack.at.frame, c1, c2)
    moments = _turned_moments(first, now, films)
    rows = np.empty(FRAME + modes)
    carried = mechanism.rod_centre * mechanism.rod_mass
    swung = link.curvature * lack.above_eye - lack.at.rod.curvature * on_rod(films)
    swung += link.rod_force_by_position + carried * link.curvature * lack.at.shift[1]
    boss = films.bosses.force
    in_eye = films.eye.force
    in_big_end = films.big_end.force
    out = np.zeros((first.size, first.size))
    for j in range(first.size):
        way = way_of(first, j)
        eye_position = way.eye * c2[j]
        eye_velocity = way.eye * c1[j]
        high = link.axial_by_acceleration * way.eye
        high += link.axial_by_velocity * eye_velocity + link.axial_by_position * eye_position
        boss_turn = way.rocking * c2[j]
        eye_turn = slope * eye_position
        on_piston = _frame_rows(rows, lack, frame, way, high, boss_turn)
        slope_push = films.slope_push[way.mode] * c2[j] if way.mode >= 0 else 0.0
        eye_slope_push = films.eye_slope_push[way.eye_mode] * c2[j] if way.eye_mode >= 0 else 0.0
        on_pin_x = mechanism.pin_mass * way.pin_x
        lifting = on_piston[1] + mechanism.pin_mass * (high + way.pin_y)
        sideways = link.slope * lifting + link.rod_force_by_acceleration * way.eye
        sideways += link.rod_force_by_velocity * eye_velocity + swung * eye_position
        sideways = sideways + slope * eye_slope_push
        sideways += carried * (way.shift_x + link.slope * way.shift_y)
        levers = _levers(first, now, films, j, c2[j])
        levers += moments[0] * boss_turn + moments[1] * eye_turn
        out[LATERAL, j] = on_piston[0] + on_pin_x + sideways
        out[ROCKING, j] = rows[TURN] - c2[LATERAL] * load.guided * way.x + slope_push
        out[BOSS_X, j] = on_pin_x + sideways + boss[1] * boss_turn
        out[BOSS_Y, j] = -on_piston[1] - boss[0] * boss_turn
        out[EYE_X, j] = -sideways + in_eye[1] * eye_turn
        out[EYE_Y, j] = lifting - in_eye[0] * eye_turn
        out[SPIN, j] = levers - slope_push - eye_slope_push
        for m in range(modes):
            out[first.modes + m, j] = rows[FRAME + m]
        # films' forces turn with their shells
        for k in range(n):
            on_boss = films.bosses.on_shapes[k]
            on_eye = films.eye.on_shapes[k]
            out[first.shapes + k, j] = on_boss[1] * boss_turn + on_eye[1] * eye_turn
            out[first.shapes + n + k, j] = -on_boss[0] * boss_turn - on_eye[0] * eye_turn
        rod_x = mechanism.rod_mass * (mechanism.rod_centre * way.eye + way.shift_x)
        rod_y = mechanism.rod_mass * (mechanism.rod_centre * high + way.shift_y)
        if first.big_end >= 0:
            out[first.big_end, j] = sideways - rod_x + in_big_end[1] * eye_turn
            out[first.big_end + 1, j] = -lifting - rod_y - in_big_end[0] * eye_turn
        if first.main_bearing >= 0:
            out[first.main_bearing, j] = bodies.crank.mass * way.journal_x - (sideways - rod_x)
            out[first.main_bearing + 1, j] = bodies.crank.mass * way.journal_y - (-lifting - rod_y)
    _add_springs(out, bodies, c1, c2)
    return out


@compilable
def _turned_moments(first, now, films):
    """Return the change of the moment on the pin with the angles of bosses and eye, (2,) [N m]:
    the films' forces turn with their shells, the pin's place and shapes do not.
    """
    boss = films.bosses.force
    eye = films.eye.force
    from_boss = now.position[BOSS_X] * boss[0] + now.position[BOSS_Y] * boss[1]
    from_eye = now.position[EYE_X] * eye[0] + now.position[EYE_Y] * eye[1]
    bent_in_boss = 0.0
    bent_in_eye = 0.0
    n = len(films.bosses.on_shapes)
    for k in range(n):
        for way in range(2):
            s = now.position[first.shapes + way * n + k]
            bent_in_boss += s * films.bosses.on_shapes[k, way]
            bent_in_eye += s * films.eye.on_shapes[k, way]
    return pair(from_boss + bent_in_boss, from_eye + bent_in_eye)


@compilable
def _frame_rows(rows, lack, frame, way, high, boss_turn):
    """Fill in the change of the frame's rows with a coordinate; return that of the force on the
    piston in space, (2,).

    `high` is the acceleration along y that the rod gives its eye, the frame's axes turn.
    """
    at = lack.at
    by_frame = in_axes(at.axes, pair(way.x, high + way.y))
    turned_by = across(in_axes(at.axes, at.piston))
    along = by_frame[0] - turned_by[0] * boss_turn
    up = by_frame[1] - turned_by[1] * boss_turn
    for m in range(len(rows)):
        rows[m] = frame[m, X] * along + frame[m, Y] * up + frame[m, TURN] * way.rocking
        if way.mode >= 0:
            rows[m] += frame[m, FRAME + way.mode]
    on_piston = in_space(at.axes, pair(rows[X], rows[Y]))
    turned_force = across(in_space(at.axes, pair(lack.force.x, lack.force.y)))
    return pair(
        on_piston[0] + turned_force[0] * boss_turn, on_piston[1] + turned_force[1] * boss_turn
    )


@compilable
def _levers(first, now, films, j, to_position):
    """Return the change of the moment on the pin with its place and shapes by coordinate j."""
    boss = films.bosses.force
    eye = films.eye.force
    n = len(films.bosses.on_shapes)
    k = j - first.shapes
    if j == BOSS_X:
        return boss[1] * to_position
    if j == BOSS_Y:
        return -boss[0] * to_position
    if j == EYE_X:
        return eye[1] * to_position
    if j == EYE_Y:
        return -eye[0] * to_position
    if 0 <= k < n:
        return (films.bosses.on_shapes[k, 1] + films.eye.on_shapes[k, 1]) * to_position
    if n <= k < 2 * n:
        return -(films.bosses.on_shapes[k - n, 0] + films.eye.on_shapes[k - n, 0]) * to_position
    return 0.0


@compilable
def _add_springs(out, bodies, c1, c2):
    """Add inertia, damping and stiffness that each coordinate has by itself to the tangent."""
    first = layout(bodies)
    shapes = bodies.shapes
    n = len(shapes.mass)
    out[SPIN, SPIN] += bodies.spin_inertia
    for k in range(n):
        for way in range(2):
            m = first.shapes + way * n + k
            held = shapes.damping[k] * c1[m] + shapes.stiffness[k] * c2[m]
            out[m, m] += shapes.mass[k] + held
    for k in range(len(bodies.eye.stiffness)):
        m = first.eye + k
        # Eq. (D40)
        out[m, m] += 1.0 + bodies.eye.damping[k] * c1[m] + bodies.eye.stiffness[k] * c2[m]


@compilable
def _frame_tangent(
    piston: FlexibleBody, frame: FrameMotion, c1: np.ndarray, c2: np.ndarray
) -> np.ndarray:
    """Derivative of the frame's rows (Eqs. (D1) to (D3)) by A's acceleration in the body's axes,
    the angle and the modes, (3 + k, 3 + k); the integrator moves angle and modes each in its own
    way.
    """
    k = len(frame.q)
    out = np.empty((FRAME + k, FRAME + k))
    arrow = frame_arrow(piston, frame, c1[ROCKING], c2[ROCKING])
    for i in range(FRAME):
        for j in range(FRAME):
            out[i, j] = arrow.top[i, j]
    if k == 0:
        return out
    c1_modes = c1[COORDINATES]
    c2_modes = c2[COORDINATES]
    modal = frame_arrow(piston, frame, c1_modes, c2_modes)
    coupling = mode_coupling(piston, frame.alpha, frame.w, c1_modes, c2_modes)
    for i in range(k):
        for j in range(FRAME):
            out[j, FRAME + i] = modal.top[j, FRAME + i]
            out[FRAME + i, j] = arrow.left[i, j]
        for j in range(k):
            out[FRAME + i, FRAME + j] = coupling[i, j]
        out[FRAME + i, FRAME + i] += modal.diagonal[i]
    return out


class Pushes(NamedTuple):
    """Changes of what acts on the piston beside the pin: along x and y [N], about A [N m], on its
    modes (k,) [kg^-1/2 N].
    """

    lateral: float
    axial: float
    moment: float
    modal: np.ndarray


@compilable
def pushed(
    first: Layout, link: Link, rod: RodTurn, films: PinFilms, on_piston: Pushes
) -> np.ndarray:
    """What changes of the forces add to the residual (Eq. (D21)), shape (7 + k + 2 n,).

    Parameters
    ----------
    first : Layout
    link : Link
    rod : RodTurn
    films : PinFilms
        Changes.
    on_piston : Pushes
    """
    axial = on_piston.axial
    sideways = -link.slope * axial - rod.slope * on_rod(films)
    out = np.empty(first.size)
    out[LATERAL] = sideways - on_piston.lateral
    out[ROCKING] = -on_piston.moment - films.bosses.on_shell
    out[BOSS_X] = sideways - films.bosses.force[0]
    out[BOSS_Y] = axial - films.bosses.force[1]
    out[EYE_X] = -sideways - films.eye.force[0]
    out[EYE_Y] = -axial - films.eye.force[1]
    out[SPIN] = -films.bosses.on_pin - films.eye.on_pin
    for k in range(first.shapes - first.modes):
        out[first.modes + k] = -on_piston.modal[k]
    n = (first.eye - first.shapes) // 2
    for k in range(n):
        for way in range(2):
            push = films.bosses.on_shapes[k, way] + films.eye.on_shapes[k, way]
            out[first.shapes + way * n + k] = -push
    for k in range(first.crank - first.eye):
        out[first.eye + k] = -films.on_eye[k]
    if first.big_end >= 0:
        out[first.big_end] = sideways - films.big_end.force[0]
        out[first.big_end + 1] = axial - films.big_end.force[1]
    if first.main_bearing >= 0:
        out[first.main_bearing] = -sideways - films.main_bearing.force[0]
        out[first.main_bearing + 1] = -axial - films.main_bearing.force[1]
    return out


@compilable
def elastic_energy(bodies: Bodies, position: np.ndarray) -> float:
    """Of the modes of piston and eye and of the pin's shapes [J]."""
    first = layout(bodies)
    total = 0.0
    for k in range(len(bodies.piston.stiffness)):
        total += bodies.piston.stiffness[k] * position[first.modes + k] ** 2 / 2
    for k in range(len(bodies.eye.stiffness)):
        total += bodies.eye.stiffness[k] * position[first.eye + k] ** 2 / 2
    n = len(bodies.shapes.mass)
    for k in range(n):
        for way in range(2):
            s = position[first.shapes + way * n + k]
            total += bodies.shapes.stiffness[k] * s**2 / 2
    return total


class Way(NamedTuple):
    """How a coordinate alone moves A, the pin's axis, the eye from its big end, the big end from
    its place without play, the crank's journal; the rocking angle; numbers of the piston's mode
    and of the eye's, `NOWHERE` of another.
    """

    x: float
    y: float
    pin_x: float
    pin_y: float
    eye: float
    shift_x: float
    shift_y: float
    journal_x: float
    journal_y: float
    rocking: float
    mode: int
    eye_mode: int


@compilable
def way_of(first: Layout, j: int) -> Way:
    """Return how coordinate j moves everything."""
    lateral = 1.0 if j == LATERAL else 0.0
    boss_x = 1.0 if j == BOSS_X else 0.0
    boss_y = 1.0 if j == BOSS_Y else 0.0
    eye_x = 1.0 if j == EYE_X else 0.0
    eye_y = 1.0 if j == EYE_Y else 0.0
    journal_x = 1.0 if j == first.main_bearing else 0.0
    journal_y = 1.0 if first.main_bearing >= 0 and j == first.main_bearing + 1 else 0.0
    shift_x = journal_x - (1.0 if j == first.big_end else 0.0)
    shift_y = journal_y - (1.0 if first.big_end >= 0 and j == first.big_end + 1 else 0.0)
    return Way(
        x=lateral,
        y=eye_y - boss_y + shift_y,
        pin_x=lateral + boss_x,
        pin_y=eye_y + shift_y,
        eye=lateral + boss_x - eye_x - shift_x,
        shift_x=shift_x,
        shift_y=shift_y,
        journal_x=journal_x,
        journal_y=journal_y,
        rocking=1.0 if j == ROCKING else 0.0,
        mode=j - first.modes if first.modes <= j < first.shapes else NOWHERE,
        eye_mode=j - first.eye if first.eye <= j < first.crank else NOWHERE,
    )


@compilable
def _coupled(piston, a, b):
    """Rows of turning and modes of Eq. (D22) for a pair of coordinates' ways."""
    total = a.rocking * (piston.S[X] * b.y - piston.S[Y] * b.x)
    if b.mode >= 0:
        total += a.rocking * piston.g[b.mode]
        total += a.x * piston.T[X, b.mode] + a.y * piston.T[Y, b.mode]
    return total


@compiled
def inertia(bodies: Bodies) -> np.ndarray:
    """M, (7 + k + 2 n, 7 + k + 2 n), of the motion across the bore and of the pin in its shells.

    Eq. (D22):  T = q' . M q'/2      of piston and pin, the piston upright, the rod's eye along the
                                     bore as its big end, at rest without play in it; each shape
                                     and the eye's modes by their own mass

    Driven motion along the bore is none of it, as with a pin that is tied, nor is the rod.
    """
    piston = bodies.piston
    first = layout(bodies)
    out = np.empty((first.size, first.size))
    for i in range(first.size):
        a = way_of(first, i)
        for j in range(first.size):
            b = way_of(first, j)
            # Eq. (D22)
            both = _coupled(piston, a, b) + _coupled(piston, b, a)
            out[i, j] = piston.mass * (a.x * b.x + a.y * b.y) + both
            out[i, j] += bodies.mechanism.pin_mass * (a.pin_x * b.pin_x + a.pin_y * b.pin_y)
    out[ROCKING, ROCKING] += piston.I0
    out[SPIN, SPIN] += bodies.spin_inertia
    for k in range(first.modes, first.shapes):
        out[k, k] += 1.0
    n = len(bodies.shapes.mass)
    for k in range(n):
        for way in range(2):
            m = first.shapes + way * n + k
            out[m, m] += bodies.shapes.mass[k]
    for k in range(first.eye, first.eye + len(bodies.eye.stiffness)):
        out[k, k] += 1.0
    return out


@compiled
def inertia_with_rod(bodies: Bodies) -> np.ndarray:
    """M of `inertia`, of the rod that swings with its eye (Eqs. (K12), (K16)), and of what play
    at the crank moves of rod and crank.

    Eq. (D35):  T += m_r (delta'^2 + 2 k eye' delta_x')/2 + m_c m'^2/2      eye = x_S - delta_x
    """
    out = inertia(bodies)
    mechanism = bodies.mechanism
    first = layout(bodies)
    swung = carried_mass(mechanism)
    for i in range(first.size):
        a = way_of(first, i)
        for j in range(first.size):
            b = way_of(first, j)
            out[i, j] += swung * (a.eye * b.eye)
            # Eq. (D35)
            both = mechanism.rod_centre * (a.eye * b.shift_x + b.eye * a.shift_x)
            shifted = a.shift_x * b.shift_x + a.shift_y * b.shift_y
            out[i, j] += mechanism.rod_mass * (shifted + both)
            thrown = a.journal_x * b.journal_x + a.journal_y * b.journal_y
            out[i, j] += bodies.crank.mass * thrown
    return out
