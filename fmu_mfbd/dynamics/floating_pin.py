"""Equations of motion of a piston, its floating pin and its rod, in coordinates [x_A, rocking
angle, pin from the piston's bosses (x, y), pin from the rod's eye (x, y), angle of the pin, modal
coordinates of the piston, shapes of the pin's axis along x, along y].

Bosses and eye hold the pin by their films alone. Where the films are thin the pin moves by
micrometres in them: relative coordinates keep these digits, and the rod stays on the crank without
a constraint to drift from. Plain numpy but for the piston's frame: seven equations, one a mode and
two a shape, whatever the films' grids.
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


class Bodies(NamedTuple):
    """Piston with all its modes, mechanism, the pin's moment of inertia about its axis [kg m2],
    shapes of its axis.
    """

    piston: FlexibleBody
    mechanism: Mechanism
    spin_inertia: float
    shapes: AxisShapes = STRAIGHT

    def blocks(self) -> dict[str, slice]:
        """Where each block of coordinates stands; the one list of them."""
        sizes = (
            ("rigid", COORDINATES),
            ("modes", len(self.piston.stiffness)),
            ("shapes", 2 * len(self.shapes.mass)),
        )
        return _blocks(sizes)

    def stacked(self, **parts: np.ndarray) -> np.ndarray:
        """Rows of every block by its name, in the order of `blocks`."""
        return np.concatenate([parts[name] for name in self.blocks()])

    def modal(self, coordinates: np.ndarray) -> np.ndarray:
        """Those of the piston's modes, (k,)."""
        return coordinates[self.blocks()["modes"]]

    def bent(self, coordinates: np.ndarray) -> np.ndarray:
        """Those of the pin's shapes, (n, 2)."""
        return coordinates[self.blocks()["shapes"]].reshape(2, -1).T

    def size(self) -> int:
        """Number of coordinates."""
        return max(block.stop for block in self.blocks().values())

    def held(self) -> np.ndarray:
        """Those held so stiffly that a step sees none of their inertia: play and what yields."""
        rigid = self.blocks()["rigid"]
        return np.append(PLAY, np.arange(rigid.stop, self.size()))


class PinFilms(NamedTuple):
    """What the films of the pin do, those of all bosses together, and that in the eye; `force`
    acts on the pin.

    Parameters
    ----------
    bosses, eye : PinResultants
    slope_push : ndarray, shape (k,)
        Moment of pressure on the pin, its opposite on the shell, by the slopes that each mode gives
        the bosses (Eq. (G5)) [kg^-1/2 N].
    """

    bosses: PinResultants
    eye: PinResultants
    slope_push: np.ndarray = NO_MODES


class Place(NamedTuple):
    """Where the mechanism stands and how it moves.

    Parameters
    ----------
    link : Link
        Of the rod's eye.
    rod : RodTurn
    axes : ndarray, shape (2, 2)
        R, from the piston's axes to space.
    piston, pin : ndarray, shape (2,)
        Accelerations of A and of the pin's axis [m/s2].
    frame : FrameMotion
        Of the piston.
    """

    link: Link
    rod: RodTurn
    axes: np.ndarray
    piston: np.ndarray
    pin: np.ndarray
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


def small_end(coordinates: np.ndarray) -> float:
    """x of the rod's eye from its concentric place, or its change in time, by the coordinates'."""
    return float(coordinates[LATERAL] + coordinates[BOSS_X] - coordinates[EYE_X])


def eye_motion(now: Motion) -> LateralMotion:
    """How the rod's eye moves across the bore."""
    return LateralMotion(*(small_end(one) for one in now))


def place_of(bodies: Bodies, now: Motion, crank: CrankMotion) -> Place:
    """Where everything stands.

    Eq. (K16):  x_S = x_A + a_x - e_x,   Y_S by Eq. (K1) of x_S
                Y_P = Y_S + e_y,   Y_A = Y_P - a_y,   x_P = x_A + a_x
                a = P - A, pin from bosses; e = P - S, pin from the rod's eye

    Parameters
    ----------
    bodies : Bodies
    now : Motion
        (7 + k + 2 n,)
    crank : CrankMotion
    """
    eye = eye_motion(now)
    link = motion(bodies.mechanism, eye, crank)
    rod = rod_turn(bodies.mechanism, eye.position, eye.velocity, crank.angle, crank.speed)
    axes = turned(now.position[ROCKING])
    a = now.acceleration
    # Eq. (K16)
    high = link.axial_acceleration + a[EYE_Y]
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
    return Place(link, rod, axes, piston, np.array([a[LATERAL] + a[BOSS_X], high]), frame)


def imbalance(bodies: Bodies, load: Load, now: Motion, crank: CrankMotion, films: PinFilms) -> Lack:
    """Residual of the equations of motion, by virtual work.

    Eq. (D21):  x_A:    G_x + K_x + N = 0
                angle:  I - M_piston = 0
                a:      K_x + N - B_x = 0,   -G_y - B_y = 0
                e:      -N - E_x = 0,   T - E_y = 0
                phi:    J phi'' - M_pin = 0
                modes:  F_q - modal = 0
                shapes: m s'' + D s' + K s - Q = 0      Q of Eq. (G8), of all films
                G = R F - load,   I = F_t - (moment + guided x_A)
                F, F_t, F_q the frame's rows, Eqs. (D1) to (D3), at R^T A''
                K = m_pin P'',   T = G_y + K_y
                N = f1 T + rod - psi1 M_rod        f1, rod, psi1 of Eqs. (K2) to (K4) at x_S
    B, E: force of the films in bosses and eye on the pin; M_piston, M_rod: their moments on the
    shells; M_pin: of all of them on the pin. With a = e = 0 the first and those of angle and modes
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
    sideways = link.slope * above_eye + link.rod_force - at.rod.slope * films.eye.on_shell
    boss_x, boss_y = films.bosses.force
    eye_x, eye_y = films.eye.force
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
    )
    lever = link.slope * mechanism.crank_radius * np.cos(crank.angle)
    lever -= mechanism.crank_radius * np.sin(crank.angle)
    torque = above_eye * lever + link.rod_moment - films.eye.on_shell * at.rod.lever
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

    eye = unit[LATERAL] + unit[BOSS_X] - unit[EYE_X]
    eye_position = eye * c2
    eye_velocity = eye * c1
    high = link.axial_by_acceleration * eye
    high = high + link.axial_by_velocity * eye_velocity + link.axial_by_position * eye_position
    by_piston = np.array([unit[LATERAL], high + unit[EYE_Y] - unit[BOSS_Y]])
    by_pin = np.array([unit[LATERAL] + unit[BOSS_X], high + unit[EYE_Y]])
    # A's acceleration in the body's axes, which turn, then the angle and the modes
    by_frame = at.axes.T @ by_piston - np.outer(across(at.axes.T @ at.piston), angle * c2)
    rows = _frame_tangent(bodies, at.frame, c1, c2) @ np.vstack([by_frame, angle, modes])
    on_piston = at.axes @ rows[:TURN]
    on_piston = on_piston + np.outer(across(at.axes @ [force.x, force.y]), angle * c2)
    slope_push = films.slope_push @ modes * c2 if len(films.slope_push) else 0.0
    rocking = rows[TURN] - c2[LATERAL] * load.guided * unit[LATERAL] + slope_push
    on_pin = bodies.mechanism.pin_mass * by_pin
    lifting = on_piston[1] + on_pin[1]
    bent = link.curvature * above_eye - rod.curvature * films.eye.on_shell
    bent += link.rod_force_by_position
    sideways = link.slope * lifting + link.rod_force_by_acceleration * eye
    sideways = sideways + link.rod_force_by_velocity * eye_velocity + bent * eye_position

    boss_turn = angle * c2[ROCKING]
    eye_turn = rod.slope * eye_position
    boss = np.outer(across(films.bosses.force), boss_turn)
    in_eye = np.outer(across(films.eye.force), eye_turn)
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
        bodies.spin_inertia * unit[SPIN] + levers - slope_push,
    ]
    return bodies.stacked(rigid=np.array(rigid), modes=rows[FRAME:], shapes=bending)


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
    sideways = -at.link.slope * axial - at.rod.slope * films.eye.on_shell
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
    return bodies.stacked(rigid=np.array(rigid), modes=-modal, shapes=-on_shapes(films).ravel())


def inertia(bodies: Bodies) -> np.ndarray:
    """M, (7 + k + 2 n, 7 + k + 2 n), of the motion across the bore and of the pin in its shells.

    Eq. (D22):  T = q' . M q'/2      of piston and pin, the piston upright, the rod's eye at rest
                                     along the bore; each shape by its own mass

    Driven motion along the bore is none of it, as with a pin that is tied, nor is the rod.
    """
    piston = bodies.piston
    unit = np.eye(bodies.size())
    modes = bodies.modal(unit)
    a = np.array([unit[LATERAL], unit[EYE_Y] - unit[BOSS_Y]])
    pin = np.array([unit[LATERAL] + unit[BOSS_X], unit[EYE_Y]])
    coupled = np.outer(unit[ROCKING], across(piston.S) @ a + piston.g @ modes)
    coupled = coupled + a.T @ piston.T @ modes
    # Eq. (D22)
    M = piston.mass * a.T @ a + coupled + coupled.T + bodies.mechanism.pin_mass * pin.T @ pin
    M[ROCKING, ROCKING] += piston.I0
    M[SPIN, SPIN] += bodies.spin_inertia
    own = np.arange(len(M))[bodies.blocks()["shapes"]]
    M[own, own] += np.tile(bodies.shapes.mass, 2)
    return M + modes.T @ modes


def inertia_with_rod(bodies: Bodies) -> np.ndarray:
    """M of `inertia` and of the rod that swings with its eye (Eqs. (K12),
    (K16)).
    """
    M = inertia(bodies)
    unit = np.eye(len(M))
    eye = unit[LATERAL] + unit[BOSS_X] - unit[EYE_X]
    return M + carried_mass(bodies.mechanism) * np.outer(eye, eye)
