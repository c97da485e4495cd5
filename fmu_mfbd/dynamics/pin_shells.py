"""Where the pin and the journals of the crank are in their shells, and how both turn."""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable
from ..geometry.pin import ModeMotion, across, axes_of, in_axes, pair, turned
from .generalised_alpha import Motion
from .pin_coordinates import (
    EYE,
    ON_PISTON,
    ON_ROD,
    PIN,
    Layout,
    coordinates_of_film,
    eye_motion,
    of_shapes,
    play_at,
)
from .piston_motion import ROCKING
from .slider_crank import CrankMotion, Mechanism, motion


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
    position, velocity = now.position, now.velocity
    film = coordinates_of_film(first, k)
    axes = axes_of(1.0, 0.0)
    own = 0.0
    if film.holder == ON_PISTON:
        axes = turned(position[ROCKING])
        own = velocity[ROCKING]
    elif film.holder == ON_ROD:
        eye = eye_motion(first, now)
        aside = mechanism.offset + eye.position + mechanism.crank_radius * np.sin(crank.angle)
        sine = -aside / mechanism.rod_length  # Eq. (K3)
        axes = axes_of(np.sqrt(1.0 - sine**2), sine)
        own = motion(mechanism, eye, crank).rod.velocity
    parallel = np.zeros((0, 2))
    bent = ModeMotion(parallel, parallel)
    if k <= EYE:
        bent = ModeMotion(of_shapes(first, position), of_shapes(first, velocity))
    return Shell(
        axes,
        play_at(film.place, position),
        play_at(film.place, velocity),
        own,
        (velocity[PIN.spin] if k <= EYE else crank.speed) - own,
        bent,
    )


@compilable
def in_turning_axes(
    axes: np.ndarray, place: np.ndarray, change: np.ndarray, turn: float
) -> np.ndarray:
    """Return the change of a vector in space in axes that turn, (2,)."""
    aside = across(place)
    return in_axes(axes, pair(change[0] - turn * aside[0], change[1] - turn * aside[1]))


@compilable
def own_velocity(shell: Shell) -> np.ndarray:
    """Return d' in the axes of the shell [m/s]."""
    return in_turning_axes(shell.axes, shell.place, shell.velocity, shell.own_turning)


@compilable
def own_bent(shell: Shell) -> ModeMotion:
    """Return tilt and bending of the pin in the axes of the shell."""
    bent, turn = shell.bent, shell.own_turning
    out = ModeMotion(np.empty(bent.position.shape), np.empty(bent.position.shape))
    for k in range(len(bent.position)):
        place = in_axes(shell.axes, bent.position[k])
        velocity = in_turning_axes(shell.axes, bent.position[k], bent.velocity[k], turn)
        for way in range(2):
            out.position[k, way] = place[way]
            out.velocity[k, way] = velocity[way]
    return out


@compilable
def shell_modes_of(first: Layout, coordinates: np.ndarray, k: int) -> np.ndarray:
    """Return the modal coordinates of the shell of film k."""
    film = coordinates_of_film(first, k)
    return coordinates[film.mode : film.end]


class ShellChange(NamedTuple):
    """Change of a pin's position (2,) [m] and of its shell's angle [rad].

    It includes the change of the speed at which the pin turns in the shell [rad/s].
    """

    place: np.ndarray
    turn: float
    turning: float


@compilable
def shell_change(
    mechanism: Mechanism, first: Layout, end: Motion, moved: Motion, crank: CrankMotion, k: int
) -> ShellChange:
    """Return the change of the shell of film k with a change of the motion."""
    film = coordinates_of_film(first, k)
    turn = 0.0
    own = 0.0
    if film.holder == ON_PISTON:
        turn = moved.position[ROCKING]
        own = moved.velocity[ROCKING]
    elif film.holder == ON_ROD:
        rod = motion(mechanism, eye_motion(first, end), crank).rod
        eye = eye_motion(first, moved)
        turn = rod.slope * eye.position
        own = rod.slope * eye.velocity + rod.velocity_slope * eye.position
    spin = moved.velocity[PIN.spin] if k <= EYE else 0.0
    return ShellChange(play_at(film.place, moved.position), turn, spin - own)
