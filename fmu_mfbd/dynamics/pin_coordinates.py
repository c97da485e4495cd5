"""Coordinates of a piston on a floating pin.

They are [x_A, rocking angle, pin from the piston's bosses (x, y), pin from the rod's eye (x, y),
angle of the pin, modal coordinates of the piston, shapes of the pin's axis along x and along y,
modal coordinates of the shells of eye, big end and main bearing]. Films of the crank
add [crank pin from the rod's big end (x, y), journal from the main bearing (x, y)].
"""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable
from ..geometry.pin import pair
from ..geometry.pin_shapes import STRAIGHT, AxisShapes
from .floating_frame import FlexibleBody
from .generalised_alpha import Motion
from .modal_damping import ModalSprings
from .piston_motion import LATERAL, RIGID
from .slider_crank import LateralMotion, Mechanism


class PinCoordinates(NamedTuple):
    """Places of the pin's coordinates.

    They are the positions of its axis from that of the piston's bosses and of the rod's eye [m],
    along x and y in space, and its angle about +z [rad].
    """

    boss_x: int = RIGID
    boss_y: int = RIGID + 1
    eye_x: int = RIGID + 2
    eye_y: int = RIGID + 3
    spin: int = RIGID + 4


PIN = PinCoordinates()
COORDINATES = PIN.spin + 1
"""Without modes, shapes of the pin and others, which follow in blocks (`layout`)."""


NO_MODES = np.zeros(0)
"""Modal coordinates or forces of a rigid piston."""


NOWHERE = -1
"""Where a block of coordinates begins that there is none of."""


RIGID_SHELLS = ModalSprings(np.zeros(0), np.zeros(0))
"""Springs of rigid shells."""


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
    big_end_modes, main_bearing_modes : int
        Number of modes of each shell.
    """

    big_end: bool = False
    main_bearing: bool = False
    mass: float = 0.0
    unbalance: float = 0.0
    big_end_modes: int = 0
    main_bearing_modes: int = 0


RIGID_CRANK = Crankshaft()
"""One that turns about a fixed axis, with the rod on it without play."""


class PinBodies(NamedTuple):
    """Piston with all modes, mechanism, inertia of the pin about its axis [kg m2], and other parts.

    These are the shapes of the pin's axis, the modes of all shells of rod and block, and the crank.
    """

    piston: FlexibleBody
    mechanism: Mechanism
    spin_inertia: float
    shapes: AxisShapes = STRAIGHT
    shells: ModalSprings = RIGID_SHELLS
    crank: Crankshaft = RIGID_CRANK

    def bent(self, coordinates: np.ndarray) -> np.ndarray:
        """Return the coordinates of the pin's shapes, (n, 2)."""
        return of_shapes(layout(self), coordinates)

    def in_eye(self, coordinates: np.ndarray) -> np.ndarray:
        """Return the coordinates of the eye's modes, (m,)."""
        return of_eye(layout(self), coordinates)


class Layout(NamedTuple):
    """Number of the first coordinate of each block, and of all coordinates.

    `crank` is the first one of all its films. Absent films are `NOWHERE`. The modes of the shells
    are in the order of their films, from `eye` to `crank`.
    """

    modes: int
    shapes: int
    eye: int
    big_end_shell: int
    main_bearing_shell: int
    crank: int
    big_end: int
    main_bearing: int
    size: int


@compilable
def layout(bodies: PinBodies) -> Layout:
    """Return the first number of each block of coordinates."""
    shapes = COORDINATES + len(bodies.piston.stiffness)
    eye = shapes + 2 * len(bodies.shapes.stiffness)
    crank = eye + len(bodies.shells.stiffness)
    main_bearing_shell = crank - bodies.crank.main_bearing_modes
    big_end_shell = main_bearing_shell - bodies.crank.big_end_modes
    end = crank
    big_end = NOWHERE
    main_bearing = NOWHERE
    if bodies.crank.big_end:
        big_end = end
        end += 2
    if bodies.crank.main_bearing:
        main_bearing = end
        end += 2
    return Layout(
        COORDINATES,
        shapes,
        eye,
        big_end_shell,
        main_bearing_shell,
        crank,
        big_end,
        main_bearing,
        end,
    )


@compilable
def of_modes(first: Layout, coordinates: np.ndarray) -> np.ndarray:
    """Return the coordinates of the piston's modes, (k,)."""
    return coordinates[first.modes : first.shapes]


@compilable
def of_shapes(first: Layout, coordinates: np.ndarray) -> np.ndarray:
    """Return the coordinates of the pin's shapes, (n, 2)."""
    n = (first.eye - first.shapes) // 2
    out = np.empty((n, 2))
    for k in range(n):
        out[k, 0] = coordinates[first.shapes + k]
        out[k, 1] = coordinates[first.shapes + n + k]
    return out


@compilable
def of_eye(first: Layout, coordinates: np.ndarray) -> np.ndarray:
    """Return the coordinates of the eye's modes, (m,)."""
    return coordinates[first.eye : first.big_end_shell]


@compilable
def play_at(first: int, coordinates: np.ndarray) -> np.ndarray:
    """Return the coordinates of a film of the crank from a position on, (2,); 0 without it."""
    if first < 0:
        return np.zeros(2)
    return pair(coordinates[first], coordinates[first + 1])


@compilable
def shift_of(first: Layout, coordinates: np.ndarray) -> np.ndarray:
    """Return the displacement of the rod's big end due to play at the crank (Eq. (K25)), (2,).

    A change of the coordinates gives its change.
    """
    journal = play_at(first.main_bearing, coordinates)
    crank_pin = play_at(first.big_end, coordinates)
    return pair(journal[0] - crank_pin[0], journal[1] - crank_pin[1])


@compilable
def is_held(coordinate: int) -> bool:
    """Return whether a coordinate is so stiff that a step does not resolve its inertia."""
    return PIN.boss_x <= coordinate <= PIN.eye_y or coordinate >= COORDINATES


@compilable
def small_end(first: Layout, coordinates: np.ndarray) -> float:
    """Return x of the rod's eye from its concentric position, minus that of its big end.

    The big end counts from its position on a crank without play. Velocities of the coordinates give
    the rate.
    """
    aside = shift_of(first, coordinates)
    return coordinates[LATERAL] + coordinates[PIN.boss_x] - coordinates[PIN.eye_x] - aside[0]


@compilable
def eye_motion(first: Layout, now: Motion) -> LateralMotion:
    """Return the motion of the rod's eye across the bore, relative to its big end."""
    return LateralMotion(
        small_end(first, now.position),
        small_end(first, now.velocity),
        small_end(first, now.acceleration),
    )


@compilable
def _of_skirt(first, coordinates):
    """Return the coordinates of the skirt's film: x_A, rocking angle, modes."""
    modal = of_modes(first, coordinates)
    out = np.empty(RIGID + len(modal))
    for k in range(RIGID):
        out[k] = coordinates[k]
    for k in range(len(modal)):
        out[RIGID + k] = modal[k]
    return out


@compilable
def lifted(first: Layout, coordinates: np.ndarray) -> float:
    """Return the lift of A by play (Eqs. (K16), (K25)) [m], or its change."""
    return coordinates[PIN.eye_y] - coordinates[PIN.boss_y] + shift_of(first, coordinates)[1]
