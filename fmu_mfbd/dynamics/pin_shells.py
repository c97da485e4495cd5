"""Position and rotation of the pin and of the journals of the crank in their shells."""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable
from ..geometry.pin import ModeMotion, across, axes_of, in_axes, pair
from ..mechanism.chain import Elements
from ..mechanism.floating_frame import TURN
from ..mechanism.generalised_alpha import Motion
from ..mechanism.motion import ChainMotion, MotionChanges


class Shell(NamedTuple):
    """Position of the pin, or a journal of the crank, in a shell, and rotation of both.

    Parameters
    ----------
    axes : ndarray, shape (2, 2)
        R(chi), by the angle that the shell has turned.
    place, velocity : ndarray, shape (2,)
        Position and velocity of the pin's axis relative to the shell's, in space [m], [m/s].
    own_turning, turning : float
        chi' of the shell, phi' - chi' of the pin in it [rad/s].
    bent : ModeMotion
        Motion of the pin's shapes, in space. A journal of the crank has no shapes.
    """

    axes: np.ndarray
    place: np.ndarray
    velocity: np.ndarray
    own_turning: float
    turning: float
    bent: ModeMotion

    def own_place(self) -> np.ndarray:
        """Return d of Eq. (H6) [m]."""
        return in_axes(self.axes, self.place)


@compilable
def shell_of(elements: Elements, at: ChainMotion, now: Motion, e: int) -> Shell:
    """Return the shell of film e of pin and crank."""
    shell, journal = elements.reacts[e], elements.acts[e]
    axes, own_turning = axes_of(1.0, 0.0), 0.0
    if shell >= 0:
        axes, own_turning = axes_of(at.axes[shell, 0], at.axes[shell, 1]), at.velocity[shell, TURN]
    play = elements.play[e]
    return Shell(
        axes=axes,
        place=play_at(play, now.position),
        velocity=play_at(play, now.velocity),
        own_turning=own_turning,
        turning=at.velocity[journal, TURN] - own_turning,
        bent=ModeMotion(shapes_of(elements, now.position, e), shapes_of(elements, now.velocity, e)),
    )


@compilable
def play_at(first: int, coordinates: np.ndarray) -> np.ndarray:
    """Return the two coordinates of a play from a position on, (2,); 0 without a play."""
    if first < 0:
        return np.zeros(2)
    return pair(coordinates[first], coordinates[first + 1])


@compilable
def shapes_of(elements: Elements, coordinates: np.ndarray, e: int) -> np.ndarray:
    """Return the coordinates of the shapes of the pin in film e, (n, 2)."""
    n = elements.shapes[e]
    first = elements.shape[e]
    out = np.empty((n, 2))
    for k in range(n):
        out[k, 0] = coordinates[first + k]
        out[k, 1] = coordinates[first + n + k]
    return out


@compilable
def shell_modes_of(elements: Elements, coordinates: np.ndarray, e: int) -> np.ndarray:
    """Return the modal coordinates of the shell of film e."""
    return coordinates[elements.mode[e] : elements.mode[e] + elements.modes[e]]


@compilable
def turned_back(shell: Shell, place: np.ndarray, change: np.ndarray, turn: float) -> np.ndarray:
    """Return the change of vectors in space, (n, 2), in the axes of a turning shell."""
    out = np.empty(place.shape)
    for k in range(len(place)):
        aside = across(place[k])
        moved = pair(change[k, 0] - turn * aside[0], change[k, 1] - turn * aside[1])
        own = in_axes(shell.axes, moved)
        out[k, 0] = own[0]
        out[k, 1] = own[1]
    return out


@compilable
def own_velocity(shell: Shell) -> np.ndarray:
    """Return d' in the axes of the shell [m/s]."""
    aside = across(shell.place)
    turn = shell.own_turning
    moved = pair(shell.velocity[0] - turn * aside[0], shell.velocity[1] - turn * aside[1])
    return in_axes(shell.axes, moved)


@compilable
def own_bent(shell: Shell) -> ModeMotion:
    """Return tilt and bending of the pin in the axes of the shell."""
    bent = shell.bent
    still = np.zeros(bent.position.shape)
    return ModeMotion(
        turned_back(shell, still, bent.position, 0.0),
        turned_back(shell, bent.position, bent.velocity, shell.own_turning),
    )


class ShellChange(NamedTuple):
    """Change of a pin's position (2,) [m] and of its shell's angle [rad].

    It includes the change of the speed at which the pin turns in the shell [rad/s].
    """

    place: np.ndarray
    turn: float
    turning: float


@compilable
def shell_change(elements: Elements, moved: Motion, bodies: MotionChanges, e: int) -> ShellChange:
    """Return the change of the shell of film e with a change of all coordinates and bodies."""
    shell = elements.reacts[e]
    turn, turning = 0.0, bodies.velocity[elements.acts[e], TURN, 0]
    if shell >= 0:
        turn = bodies.position[shell, TURN, 0]
        turning -= bodies.velocity[shell, TURN, 0]
    return ShellChange(play_at(elements.play[e], moved.position), turn, turning)
