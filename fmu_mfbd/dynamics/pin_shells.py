"""Where the pin and the journals of the crank are in their shells, and how both turn."""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable
from ..geometry.pin import PIN_SURFACES, ModeMotion, across, axes_of, in_axes, pair, turned
from .generalised_alpha import Motion
from .pin_coordinates import (
    PIN,
    Layout,
    eye_motion,
    of_eye,
    of_modes,
    of_shapes,
    play_at,
)
from .piston_motion import ROCKING
from .slider_crank import CrankMotion, Mechanism, motion

EYE = PIN_SURFACES.index("small_end")
"""Number of the eye's film; those of the bosses come before it, those of the crank after."""


class Shell(NamedTuple):
    """Position of the pin, or a journal of the crank, in a shell, and rotation of both.

    Parameters
    ----------
    axes : ndarray, shape (2, 2)
        R(chi), by the angle that the shell has turned.
    place, velocity : ndarray, shape (2,)
        Of the pin's axis from the shell's, in space [m], [m/s].
    own_turning, turning : float
        chi' of the shell, phi' - chi' of the pin in it [rad/s].
    bent : ModeMotion
        Of the pin, in space; no shapes of a journal of the crank, which stays parallel.
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
def shell_of(mechanism: Mechanism, first: Layout, now: Motion, crank: CrankMotion, k: int) -> Shell:
    """Return the shell of the k-th film of pin and crank."""
    position = now.position
    velocity = now.velocity
    if k < EYE:
        return Shell(
            turned(position[ROCKING]),
            pair(position[PIN.boss_x], position[PIN.boss_y]),
            pair(velocity[PIN.boss_x], velocity[PIN.boss_y]),
            velocity[ROCKING],
            velocity[PIN.spin] - velocity[ROCKING],
            ModeMotion(of_shapes(first, position), of_shapes(first, velocity)),
        )
    eye = eye_motion(first, now)
    rod = motion(mechanism, eye, crank).rod
    aside = mechanism.offset + eye.position + mechanism.crank_radius * np.sin(crank.angle)
    sine = -aside / mechanism.rod_length  # Eq. (K3)
    axes = axes_of(np.sqrt(1.0 - sine**2), sine)
    if k == EYE:
        return Shell(
            axes,
            pair(position[PIN.eye_x], position[PIN.eye_y]),
            pair(velocity[PIN.eye_x], velocity[PIN.eye_y]),
            rod.velocity,
            velocity[PIN.spin] - rod.velocity,
            ModeMotion(of_shapes(first, position), of_shapes(first, velocity)),
        )
    parallel = ModeMotion(np.zeros((0, 2)), np.zeros((0, 2)))
    if k == _big_end(first):
        at = first.big_end
        place = play_at(at, position)
        moved = play_at(at, velocity)
        turning = crank.speed - rod.velocity
        return Shell(axes, place, moved, rod.velocity, turning, parallel)
    at = first.main_bearing
    upright = axes_of(1.0, 0.0)
    place = play_at(at, position)
    return Shell(upright, place, play_at(at, velocity), 0.0, crank.speed, parallel)


@compilable
def _big_end(first):
    """Return the number of the big end's film, -1 if it has none."""
    return EYE + 1 if first.big_end >= 0 else -1


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


@compilable
def shell_modes_of(first: Layout, coordinates: np.ndarray, k: int) -> np.ndarray:
    """Return the modal coordinates of the shell of film k."""
    if k < EYE:
        return of_modes(first, coordinates)
    if k == EYE:
        return of_eye(first, coordinates)
    if k == _big_end(first):
        return coordinates[first.big_end_shell : first.main_bearing_shell]
    return coordinates[first.main_bearing_shell : first.crank]


@compilable
def first_mode(first: Layout, k: int) -> int:
    """Return the coordinate of the first mode of the shell of film k."""
    if k < EYE:
        return first.modes
    if k == EYE:
        return first.eye
    return first.big_end_shell if k == _big_end(first) else first.main_bearing_shell


class ShellChange(NamedTuple):
    """Change of a pin's position (2,) [m] and of its shell's angle [rad].

    It includes the change of the speed at which the pin turns in the shell [rad/s].
    """

    place: np.ndarray
    turn: float
    turning: float


@compilable
def _shell_change(mechanism, first, end, moved, crank, k):
    """Return the change of the shell of film k with a change of the motion."""
    place = moved.position
    speed = moved.velocity
    if k < EYE:
        boss = pair(place[PIN.boss_x], place[PIN.boss_y])
        return ShellChange(boss, place[ROCKING], speed[PIN.spin] - speed[ROCKING])
    rod = motion(mechanism, eye_motion(first, end), crank).rod
    eye = eye_motion(first, moved)
    turn = rod.slope * eye.position
    turning = rod.slope * eye.velocity + rod.velocity_slope * eye.position
    if k == EYE:
        return ShellChange(
            pair(place[PIN.eye_x], place[PIN.eye_y]), turn, speed[PIN.spin] - turning
        )
    if k == _big_end(first):
        return ShellChange(play_at(first.big_end, place), turn, -turning)
    return ShellChange(play_at(first.main_bearing, place), 0.0, 0.0)
