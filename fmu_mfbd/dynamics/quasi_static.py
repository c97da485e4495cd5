"""Modes too fast for the step: they follow their load without inertia of their own."""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable, compiled
from ..geometry.arrays import Matrix, Vector


class StaticModes(NamedTuple):
    """Modes that carry stiffness alone; s modes.

    Parameters
    ----------
    stiffness : ndarray, shape (s,)
        omega^2 [rad2/s2].
    T, b, g : ndarray, shapes (2, s), (s,), (s,)
        How the motion of the body frame loads them, see Eq. (J7); zero where it does not move.
    """

    stiffness: Vector
    T: Matrix
    b: Vector
    g: Vector


class FrameAcceleration(NamedTuple):
    """Motion of the body frame that loads its static modes.

    Parameters
    ----------
    x, y : float
        Acceleration of A in the body frame [m/s2].
    alpha : float
        Angular acceleration [rad/s2].
    spin : float
        Square of the angular velocity [rad2/s2].
    """

    x: float
    y: float
    alpha: float
    spin: float


STILL = FrameAcceleration(0.0, 0.0, 0.0, 0.0)
"""A frame that does not move."""


@compilable
def standing(stiffness: np.ndarray) -> StaticModes:
    """Return static modes of a body whose frame does not move."""
    nothing = np.zeros(len(stiffness))
    return StaticModes(stiffness, np.zeros((2, len(stiffness))), nothing, nothing)


@compiled
def static_coordinates(
    modes: StaticModes, force: np.ndarray, ride: FrameAcceleration
) -> np.ndarray:
    """Return the modal coordinates under the current forces.

    Eq. (D6):  Omega^2 q = f - T^T a - alpha g + w^2 b

    Eq. (D3) without the mode's own motion; the frame in turn does not feel these modes. Linear, so
    that changes of the loads give the change of q. Good for loads far slower than the modes: the
    error is about (load's frequency / mode's frequency)^2.

    Parameters
    ----------
    modes : StaticModes
    force : ndarray, shape (s,)
        [kg^-1/2 N]
    ride : FrameAcceleration

    Returns
    -------
    ndarray, shape (s,)
        [kg^1/2 m]
    """
    out = np.empty(len(force))
    for k in range(len(force)):
        translation = force[k] - modes.T[0, k] * ride.x - modes.T[1, k] * ride.y
        load = translation - ride.alpha * modes.g[k] + ride.spin * modes.b[k]
        out[k] = load / modes.stiffness[k]  # Eq. (D6)
    return out


@compiled
def follow(position, velocity, position_before, q, first, step):
    """Set static modes to their coordinates from `first` on.

    Their velocity is the mean over the step, 0 at the start.
    """
    for k in range(len(q)):
        position[first + k] = q[k]
        velocity[first + k] = (q[k] - position_before[first + k]) / step if step > 0.0 else 0.0


@compilable
def moving_modes(omega: np.ndarray, highest: float) -> int:
    """Return the number of modes that have inertia, those up to a frequency [Hz]."""
    count = 0
    for one in omega:
        count += one <= 2 * np.pi * highest
    return count
