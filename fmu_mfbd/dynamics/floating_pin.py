"""Equations of motion of a piston, its floating pin and its rod, in coordinates [x_A, rocking
angle, pin from the piston's bosses (x, y), pin from the rod's eye (x, y), angle of the pin, modal
coordinates of the piston, shapes of the pin's axis along x, along y, modal coordinates of the rod's
eye, crank pin from the rod's big end (x, y), crank's journal from the main bearing (x, y)], the
last two where they have films.

Bosses and eye hold the pin by their films alone. Where the films are thin the pin moves by
micrometres in them: relative coordinates keep these digits, and the rod stays on the crank without
a constraint to drift from; with a film in its big end it has two coordinates more, and so has a
crank on a film. Plain numpy but for the piston's frame: seven equations, one a mode, two a shape
and two a film of the crank, whatever the films' grids.

The eye's modes stand in the rod's axes and have the inertia of their own motion alone (Eq. (D40)):
what they push the rod by and what its acceleration bends them by is left out. The eye's mass is
the rod's already; what it weighs at 6700 m/s2 bends that of `yielding_bosses` by 0.9 um, a film
under 25 kN by 20 to 60 (`tests/bench/small_end.py`).
"""

from functools import cache
from typing import NamedTuple

import numpy as np

from ..geometry.pin import PinResultants, across, turned
from ..geometry.pin_shapes import STRAIGHT, AxisShapes
from .floating_frame import RIGID as FRAME
from .floating_frame import (
    TURN,
    FlexibleBody,
    FrameMotion,
    frame_arrow,
    frame_force,
    mode_coupling,
)
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
"""Without modes, shapes of the pin and others, which follow in blocks (`Bodies.blocks`)."""

NO_MODES = np.zeros(0)
"""Modal coordinates or forces of a rigid piston."""

PLAY = np.array([BOSS_X, BOSS_Y, EYE_X, EYE_Y])
"""Coordinates that films hold within a clearance."""


@cache
def _blocks(sizes: tuple[tuple[str, int], ...]) -> dict[str, slice]:
    """Where each block of coordinates stands, from names and sizes in their order."""
    blocks = {}
    first = 0
    for name, size in sizes:
        blocks[name] = slice(first, first + size)
        first += size
    return blocks


class EyeModes(NamedTuple):
    """By which the rod's eye yields: squares of their frequencies [rad2/s2], damping [rad/s], (m,).

    Eq. (D40):  q'' + D q' + omega^2 q = Q      Q of Eq. (G6), all in the rod's axes
    """

    stiffness: np.ndarray
    damping: np.ndarray

    def needed(self, now: Motion) -> np.ndarray:
        """Forces that their motion needs of the film, (m,) [kg^-1/2 N]."""
        # Eq. (D40)
        return now.acceleration + self.damping * now.velocity + self.stiffness * now.position


RIGID_EYE = EyeModes(np.zeros(0), np.zeros(0))
"""Of a rigid eye."""


class Crankshaft(NamedTuple):
    """The crank, where rod or block hold it by films.

    Parameters
    ----------
    surfaces : tuple of str
        Which of `CRANK_SURFACES` have a film.
    mass : float
        That moves with the journal in the main bearing [kg].
    unbalance : float
        Mass times distance towards the crank pin [kg m].
    """

    surfaces: tuple[str, ...] = ()
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
    eye: EyeModes = RIGID_EYE
    crank: Crankshaft = RIGID_CRANK

    def blocks(self) -> dict[str, slice]:
        """Where each block of coordinates stands; the one list of them."""
        sizes = (
            ("rigid", COORDINATES),
            ("modes", len(self.piston.stiffness)),
            ("shapes", 2 * len(self.shapes.mass)),
            ("eye", len(self.eye.stiffness)),
            *((name, 2) for name in self.crank.surfaces),
        )
        return _blocks(sizes)

    def stacked(self, **parts: np.ndarray) -> np.ndarray:
        """Rows of every block by its name, in the order of `blocks`; others are left out."""
        return np.concatenate([parts[name] for name in self.blocks()])

    def play(self, name: str, coordinates: np.ndarray) -> np.ndarray:
        """Those of a film of the crank, (2,) or of several columns (2, ..); 0 without it."""
        block = self.blocks().get(name)
        if block is None:
            return np.zeros((2, *coordinates.shape[1:]))
        return coordinates[block]

    def shift(self, coordinates: np.ndarray) -> np.ndarray:
        """By which the rod's big end lies beside its place on a crank without play (Eq. (K25)), or
        its change.
        """
        return self.play("main_bearing", coordinates) - self.play("big_end", coordinates)

    def modal(self, coordinates: np.ndarray) -> np.ndarray:
        """Those of the piston's modes, (k,)."""
        return coordinates[self.blocks()["modes"]]

    def bent(self, coordinates: np.ndarray) -> np.ndarray:
        """Those of the pin's shapes, (n, 2)."""
        return coordinates[self.blocks()["shapes"]].reshape(2, -1).T

    def in_eye(self, coordinates: np.ndarray) -> np.ndarray:
        """Those of the eye's modes, (m,)."""
        return coordinates[self.blocks()["eye"]]

    def size(self) -> int:
        """Number of coordinates."""
        return max(block.stop for block in self.blocks().values())

    def held(self) -> np.ndarray:
        """Those held so stiffly that a step sees none of their inertia: play and what yields."""
        rigid = self.blocks()["rigid"]
        return np.append(PLAY, np.arange(rigid.stop, self.size()))


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

    def on_rod(self) -> float:
        """Moments of the films on the rod about the axes of its shells [N m]."""
        return self.eye.on_shell + self.big_end.on_shell


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
    """

    residual: np.ndarray
    on_piston: np.ndarray
    above_eye: float
    torque: float


def small_end(bodies: Bodies, coordinates: np.ndarray) -> float:
    """x of the rod's eye from its concentric place, less that of its big end from the place on a
    crank without play, or its change in time, by the coordinates'.
    """
    x = coordinates[LATERAL] + coordinates[BOSS_X] - coordinates[EYE_X]
    aside, _ = bodies.shift(coordinates)
    return float(x - aside)


def eye_motion(bodies: Bodies, now: Motion) -> LateralMotion:
    """How the rod's eye moves across the bore, seen from its big end."""
    return LateralMotion(*(small_end(bodies, one) for one in now))


def towards_crank_pin(angle: float) -> np.ndarray:
    """Unit vector from the crank's axis to its pin, (2,)."""
    return np.array([-np.sin(angle), np.cos(angle)])


def turning(vector: np.ndarray, crank: CrankMotion) -> np.ndarray:
    """Acceleration of what turns with the crank, (2,) [m/s2].

    Eq. (K26):  u'' = Z u w' - u w^2      Z: a quarter about +z
    """
    return across(vector) * crank.acceleration - vector * crank.speed**2  # Eq. (K26)


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
    eye = eye_motion(bodies, now)
    link = motion(mechanism, eye, crank)
    rod = rod_turn(mechanism, eye.position, eye.velocity, crank.angle, crank.speed)
    axes = turned(now.position[ROCKING])
    a = now.acceleration
    # Eq. (K25)
    shift = bodies.shift(a)
    k = mechanism.rod_centre
    crank_pin = turning(mechanism.crank_radius * towards_crank_pin(crank.angle), crank)
    from_big_end = np.array([eye.acceleration, link.axial_acceleration])
    rod_centre = shift + (1 - k) * crank_pin + k * from_big_end
    # Eq. (K16)
    _, lifted = shift
    high = link.axial_acceleration + lifted + a[EYE_Y]
    piston = np.array([a[LATERAL], high - a[BOSS_Y]])
    along, up = (axes.T @ piston).tolist()
    frame = FrameMotion(
        ax=along,
        ay=up,
        alpha=float(a[ROCKING]),
        w=float(now.velocity[ROCKING]),
        q=bodies.modal(now.position),
        dq=bodies.modal(now.velocity),
        ddq=bodies.modal(a),
    )
    pin = np.array([a[LATERAL] + a[BOSS_X], high])
    journal = bodies.play("main_bearing", a)
    return Place(link, rod, axes, piston, pin, shift, rod_centre, journal, frame)


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
    mechanism = bodies.mechanism
    link = at.link
    force = frame_force(bodies.piston, at.frame)
    # Eq. (D21)
    on_piston = at.axes @ [force.x, force.y] - [load.lateral, load.axial]
    rocking = force.moment - (load.moment + load.guided * now.position[LATERAL])
    pin_x, pin_y = mechanism.pin_mass * at.pin
    piston_x, piston_y = on_piston
    above_eye = piston_y + pin_y
    shift_x, shift_y = at.shift
    carried = mechanism.rod_centre * mechanism.rod_mass
    sideways = link.slope * above_eye + link.rod_force - at.rod.slope * films.on_rod()
    sideways += carried * (shift_x + link.slope * shift_y)
    boss_x, boss_y = films.bosses.force
    eye_x, eye_y = films.eye.force
    at_big_end = np.array([sideways, -above_eye]) - mechanism.rod_mass * at.rod_centre
    towards = towards_crank_pin(crank.angle)
    thrown = bodies.crank.mass * at.crank + bodies.crank.unbalance * turning(towards, crank)
    on_pin = films.bosses.on_pin + films.eye.on_pin
    rigid = [
        piston_x + pin_x + sideways,
        rocking - films.bosses.on_shell,
        pin_x + sideways - boss_x,
        -piston_y - boss_y,
        -sideways - eye_x,
        above_eye - eye_y,
        bodies.spin_inertia * now.acceleration[SPIN] - on_pin,
    ]
    residual = bodies.stacked(
        rigid=np.array(rigid),
        modes=force.modal - load.modal,
        shapes=_bending(bodies, now, films),
        eye=bodies.eye.needed(Motion(*(bodies.in_eye(one) for one in now))) - films.on_eye,
        big_end=at_big_end - films.big_end.force,
        main_bearing=thrown - at_big_end - films.main_bearing.force,
    )
    lever = link.slope * mechanism.crank_radius * np.cos(crank.angle)
    lever -= mechanism.crank_radius * np.sin(crank.angle)
    torque = above_eye * lever + link.rod_moment - films.on_rod() * at.rod.lever
    onward = across(towards)
    by_centre = (1 - mechanism.rod_centre) * mechanism.crank_radius * onward
    by_centre = by_centre + [0.0, mechanism.rod_centre * lever]
    torque += mechanism.rod_mass * (by_centre @ at.shift)
    torque += bodies.crank.unbalance * (onward @ at.crank)
    torque -= films.big_end.on_pin + films.main_bearing.on_pin
    return Lack(residual, on_piston, float(above_eye), float(torque))


def _bending(bodies: Bodies, now: Motion, films: PinFilms) -> np.ndarray:
    """Rows of the pin's shapes (Eq. (D21)), (2 n,)."""
    position, velocity, acceleration = (bodies.bent(one).T for one in now)
    shapes = bodies.shapes
    held = shapes.damping * velocity + shapes.stiffness * position
    return (shapes.mass * acceleration + held - on_shapes(films)).ravel()


def on_shapes(films: PinFilms) -> np.ndarray:
    """Forces of all films on the pin's shapes along x and y, (2, n) [N]."""
    return (films.bosses.on_shapes + films.eye.on_shapes).T


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
    to_velocity, to_position : ndarray, shape (7 + k + 2 n,)
        [s], [s2]; all modes alike.

    Returns
    -------
    ndarray, shape (7 + k + 2 n, 7 + k + 2 n)
    """
    at = place_of(bodies, now, crank)
    link = at.link
    rod = at.rod
    c1 = to_velocity
    c2 = to_position
    unit = np.eye(len(now.position))
    angle = unit[ROCKING]
    modes = bodies.modal(unit)
    force = frame_force(bodies.piston, at.frame)
    above_eye = imbalance(bodies, load, now, crank, films).above_eye

    shift_x, shift_y = bodies.shift(unit)
    eye = unit[LATERAL] + unit[BOSS_X] - unit[EYE_X] - shift_x
    eye_position = eye * c2
    eye_velocity = eye * c1
    high = link.axial_by_acceleration * eye
    high = high + link.axial_by_velocity * eye_velocity + link.axial_by_position * eye_position
    by_rod = bodies.mechanism.rod_centre * np.array([eye, high]) + [shift_x, shift_y]
    high = high + shift_y
    by_piston = np.array([unit[LATERAL], high + unit[EYE_Y] - unit[BOSS_Y]])
    by_pin = np.array([unit[LATERAL] + unit[BOSS_X], high + unit[EYE_Y]])
    # A's acceleration in the body's axes, which turn, then the angle and the modes
    by_frame = at.axes.T @ by_piston - np.outer(across(at.axes.T @ at.piston), angle * c2)
    rows = _frame_tangent(bodies, at.frame, c1, c2) @ np.vstack([by_frame, angle, modes])
    on_piston = at.axes @ rows[:TURN]
    on_piston = on_piston + np.outer(across(at.axes @ [force.x, force.y]), angle * c2)
    slope_push = films.slope_push @ modes * c2 if len(films.slope_push) else 0.0
    rocking = rows[TURN] - c2[LATERAL] * load.guided * unit[LATERAL] + slope_push
    in_eye_slope = films.eye_slope_push @ bodies.in_eye(unit) * c2 if len(films.on_eye) else 0.0
    on_pin = bodies.mechanism.pin_mass * by_pin
    lifting = on_piston[1] + on_pin[1]
    carried = bodies.mechanism.rod_centre * bodies.mechanism.rod_mass
    _, shifting = at.shift
    bent = link.curvature * above_eye - rod.curvature * films.on_rod()
    bent += link.rod_force_by_position + carried * link.curvature * shifting
    sideways = link.slope * lifting + link.rod_force_by_acceleration * eye
    sideways = sideways + link.rod_force_by_velocity * eye_velocity + bent * eye_position
    sideways = sideways + rod.slope * in_eye_slope
    sideways = sideways + carried * (shift_x + link.slope * shift_y)
    at_big_end = np.array([sideways, -lifting]) - bodies.mechanism.rod_mass * by_rod

    boss_turn = angle * c2[ROCKING]
    eye_turn = rod.slope * eye_position
    boss = np.outer(across(films.bosses.force), boss_turn)
    in_eye = np.outer(across(films.eye.force), eye_turn)
    in_big_end = np.outer(across(films.big_end.force), eye_turn)
    thrown = bodies.crank.mass * bodies.play("main_bearing", unit)
    boss_x, boss_y = films.bosses.force
    eye_x, eye_y = films.eye.force
    from_boss = now.position[BOSS_X : BOSS_Y + 1]
    from_eye = now.position[EYE_X : EYE_Y + 1]
    levers = boss_y * c2[BOSS_X] * unit[BOSS_X] - boss_x * c2[BOSS_Y] * unit[BOSS_Y]
    levers = levers + float(from_boss @ films.bosses.force) * boss_turn
    levers = levers + eye_y * c2[EYE_X] * unit[EYE_X] - eye_x * c2[EYE_Y] * unit[EYE_Y]
    levers = levers + float(from_eye @ films.eye.force) * eye_turn
    bent, bending = _bending_tangent(bodies, now, films, (boss_turn, eye_turn), (c1, c2))
    levers = levers + bent
    rigid = [
        on_piston[0] + on_pin[0] + sideways,
        rocking,
        on_pin[0] + sideways - boss[0],
        -on_piston[1] - boss[1],
        -sideways - in_eye[0],
        lifting - in_eye[1],
        bodies.spin_inertia * unit[SPIN] + levers - slope_push - in_eye_slope,
    ]
    of_eye = Motion(*(bodies.in_eye(one) for one in (c2, c1, np.ones_like(c1))))
    return bodies.stacked(
        rigid=np.array(rigid),
        modes=rows[FRAME:],
        shapes=bending,
        eye=bodies.eye.needed(of_eye)[:, None] * bodies.in_eye(unit),
        big_end=at_big_end - in_big_end,
        main_bearing=thrown - at_big_end,
    )


def _bending_tangent(
    bodies: Bodies,
    now: Motion,
    films: PinFilms,
    turns: tuple[np.ndarray, np.ndarray],
    reach: tuple[np.ndarray, np.ndarray],
) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives of the moment of the shapes' levers (Eq. (G8)), by all coordinates, and of the
    shapes' rows, (2 n, 7 + k + 2 n); `turns`: of bosses and eye, by all coordinates.
    """
    shapes = bodies.shapes
    count = len(shapes.mass)
    size = len(now.position)
    lever = np.zeros(size)
    rows = np.zeros((2 * count, size))
    if not count:
        return lever, rows
    to_velocity, to_position = reach
    own = np.arange(size)[bodies.blocks()["shapes"]]
    along_x, along_y = own.reshape(2, count)
    twice = (np.tile(one, 2) for one in (shapes.mass, shapes.damping, shapes.stiffness))
    mass, damping, stiffness = twice
    rows[:, own] = np.diag(mass + damping * to_velocity[own] + stiffness * to_position[own])
    push_x, push_y = on_shapes(films)
    lever[along_x] = push_y * to_position[along_x]
    lever[along_y] = -push_x * to_position[along_y]
    position = bodies.bent(now.position)
    for one, turn in zip((films.bosses, films.eye), turns):
        # the film's force turns with its shell
        x, y = one.on_shapes.T
        rows -= np.outer(np.concatenate([-y, x]), turn)
        lever += float(np.sum(position * one.on_shapes)) * turn
    return lever, rows


def _frame_tangent(
    bodies: Bodies, frame: FrameMotion, c1: np.ndarray, c2: np.ndarray
) -> np.ndarray:
    """Derivative of the frame's rows (Eqs. (D1) to (D3)) by A's acceleration in the body's axes,
    the angle and the modes, (3 + k, 3 + k); the integrator moves angle and modes each in its own
    way.
    """
    piston = bodies.piston
    arrow = frame_arrow(piston, frame, c1[ROCKING], c2[ROCKING])
    if not len(frame.q):
        return arrow.top
    of_modes = bodies.modal(c1)[0], bodies.modal(c2)[0]
    modal = frame_arrow(piston, frame, *of_modes)
    coupling = mode_coupling(piston, frame.alpha, frame.w, *of_modes)
    top = np.hstack([arrow.top[:, :FRAME], modal.top[:, FRAME:]])
    return np.vstack([top, np.hstack([arrow.left, np.diag(modal.diagonal) + coupling])])


def pushed(
    bodies: Bodies,
    at: Place,
    films: PinFilms,
    skirt: tuple[float, float, float],
    modal: np.ndarray = NO_MODES,
) -> np.ndarray:
    """What changes of the forces add to the residual (Eq. (D21)), shape (7 + k + 2 n,).

    Parameters
    ----------
    bodies : Bodies
    at : Place
    films : PinFilms
        Changes.
    skirt : (float, float, float)
        Changes of what acts on the piston beside the pin: along x and y [N], about A [N m].
    modal : ndarray, shape (k,)
        Changes of all modal forces on it [kg^-1/2 N].
    """
    lateral, axial, moment = skirt
    sideways = -at.link.slope * axial - at.rod.slope * films.on_rod()
    at_big_end = np.array([sideways, axial])
    boss_x, boss_y = films.bosses.force
    eye_x, eye_y = films.eye.force
    rigid = [
        sideways - lateral,
        -moment - films.bosses.on_shell,
        sideways - boss_x,
        axial - boss_y,
        -sideways - eye_x,
        -axial - eye_y,
        -films.bosses.on_pin - films.eye.on_pin,
    ]
    return bodies.stacked(
        rigid=np.array(rigid),
        modes=-modal,
        shapes=-on_shapes(films).ravel(),
        eye=-films.on_eye,
        big_end=at_big_end - films.big_end.force,
        main_bearing=-at_big_end - films.main_bearing.force,
    )


def inertia(bodies: Bodies) -> np.ndarray:
    """M, (7 + k + 2 n, 7 + k + 2 n), of the motion across the bore and of the pin in its shells.

    Eq. (D22):  T = q' . M q'/2      of piston and pin, the piston upright, the rod's eye along the
                                     bore as its big end, at rest without play in it; each shape
                                     and the eye's modes by their own mass

    Driven motion along the bore is none of it, as with a pin that is tied, nor is the rod.
    """
    piston = bodies.piston
    unit = np.eye(bodies.size())
    modes = bodies.modal(unit)
    _, lifted = bodies.shift(unit)
    a = np.array([unit[LATERAL], unit[EYE_Y] - unit[BOSS_Y] + lifted])
    pin = np.array([unit[LATERAL] + unit[BOSS_X], unit[EYE_Y] + lifted])
    coupled = np.outer(unit[ROCKING], across(piston.S) @ a + piston.g @ modes)
    coupled = coupled + a.T @ piston.T @ modes
    # Eq. (D22)
    M = piston.mass * a.T @ a + coupled + coupled.T + bodies.mechanism.pin_mass * pin.T @ pin
    M[ROCKING, ROCKING] += piston.I0
    M[SPIN, SPIN] += bodies.spin_inertia
    own = np.arange(len(M))[bodies.blocks()["shapes"]]
    M[own, own] += np.tile(bodies.shapes.mass, 2)
    own = np.arange(len(M))[bodies.blocks()["eye"]]
    M[own, own] += 1.0
    return M + modes.T @ modes


def inertia_with_rod(bodies: Bodies) -> np.ndarray:
    """M of `inertia`, of the rod that swings with its eye (Eqs. (K12), (K16)), and of what play
    at the crank moves of rod and crank.

    Eq. (D35):  T += m_r (delta'^2 + 2 k eye' delta_x')/2 + m_c m'^2/2      eye = x_S - delta_x
    """
    M = inertia(bodies)
    mechanism = bodies.mechanism
    unit = np.eye(len(M))
    shift = bodies.shift(unit)
    aside, _ = shift
    eye = unit[LATERAL] + unit[BOSS_X] - unit[EYE_X] - aside
    M = M + carried_mass(mechanism) * np.outer(eye, eye)
    # Eq. (D35)
    both = mechanism.rod_centre * np.outer(eye, aside)
    M = M + mechanism.rod_mass * (shift.T @ shift + both + both.T)
    journal = bodies.play("main_bearing", unit)
    return M + bodies.crank.mass * journal.T @ journal
