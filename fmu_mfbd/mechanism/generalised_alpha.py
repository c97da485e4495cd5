"""Generalised-alpha time integration: coefficients and update of every equation of motion.

References
----------
[Chung1993] J. Chung, G. M. Hulbert, J. Appl. Mech. 60 (1993) 371-375.
[Arnold2007] M. Arnold, O. Bruels, Multibody Syst. Dyn. 18 (2007) 185-202.
"""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable, compiled
from ..geometry.arrays import Vector


class Coefficients(NamedTuple):
    """Coefficients of a step of the generalised-alpha method; see `coefficients`.

    Parameters
    ----------
    step : float
        h [s].
    alpha_m, alpha_f, beta, gamma : float
        [-]
    to_auxiliary, to_velocity, to_position : float
        What an end acceleration of 1 adds to the end's auxiliary acceleration [-], velocity [s] and
        position [s2].
    memory : float
        Time for which BDF2 continues the last step, Eq. (N9) [s]; 0 for backward Euler.
    """

    step: float
    alpha_m: float
    alpha_f: float
    beta: float
    gamma: float
    to_auxiliary: float
    to_velocity: float
    to_position: float
    memory: float


class Motion(NamedTuple):
    """Coordinates and their derivatives in time at an instant.

    Parameters
    ----------
    position, velocity, acceleration : ndarray, shape (n,)
        q, q', q''.
    """

    position: Vector
    velocity: Vector
    acceleration: Vector


class Prediction(NamedTuple):
    """The end of a step if the end acceleration were zero.

    Parameters
    ----------
    position, velocity, auxiliary : ndarray, shape (n,)
        q, q' and the auxiliary acceleration a.
    """

    position: np.ndarray
    velocity: np.ndarray
    auxiliary: np.ndarray


@compilable
def coefficients(step: float, spectral_radius: float, memory: float = 0.0) -> Coefficients:
    """Return the coefficients of the second-order method with a given numerical damping.

    Eq. (N1):  alpha_m = (2 rho - 1)/(rho + 1),  alpha_f = rho/(rho + 1)
               gamma_N = 1/2 + alpha_f - alpha_m,  beta_N = (gamma_N + 1/2)^2 / 4

    Parameters
    ----------
    step : float
        Step [s], > 0; 0 leaves position and velocity as they are.
    spectral_radius : float
        rho at infinite frequency [-], 0 (annihilates it in one step) to 1 (keeps all energy).
    memory : float
        `bdf2.memory_of` the coordinates that use BDF2 [s].

    Returns
    -------
    Coefficients

    References
    ----------
    [Chung1993]. Order 2 is checked in tests/verification/test_mfbd.py.
    """
    rho = spectral_radius
    # Eq. (N1)
    alpha_m = (2 * rho - 1) / (rho + 1)
    alpha_f = rho / (rho + 1)
    gamma = 0.5 + alpha_f - alpha_m
    beta = (gamma + 0.5) ** 2 / 4
    to_auxiliary = (1 - alpha_f) / (1 - alpha_m)
    return Coefficients(
        step=step,
        alpha_m=alpha_m,
        alpha_f=alpha_f,
        beta=beta,
        gamma=gamma,
        to_auxiliary=to_auxiliary,
        to_velocity=to_auxiliary * step * gamma,
        to_position=to_auxiliary * step**2 * beta,
        memory=memory,
    )


@compiled
def predict(c: Coefficients, before: Motion, auxiliary: np.ndarray) -> Prediction:
    """Return end position, velocity and auxiliary acceleration for zero end acceleration.

    Eq. (N2):  (1 - alpha_m) a_1 + alpha_m a_0 = (1 - alpha_f) q''_1 + alpha_f q''_0
               q'_1 = q'_0 + h ((1 - gamma_N) a_0 + gamma_N a_1)
               q_1  = q_0 + h q'_0 + h^2 ((1/2 - beta_N) a_0 + beta_N a_1)

    The equation of motion holds exactly at the end of the step, with the end-of-step forces; `c`
    adds the part of q''_1 by `to_auxiliary`, `to_velocity` and `to_position`.

    Parameters
    ----------
    c : Coefficients
    before : Motion
        q_0, q'_0, q''_0.
    auxiliary : ndarray, shape (n,)
        a_0.

    Returns
    -------
    Prediction

    References
    ----------
    [Arnold2007]
    """
    n = len(before.position)
    position = np.empty(n)
    velocity = np.empty(n)
    a = np.empty(n)
    for k in range(n):  # a loop: array expressions take the compiler seconds each
        # Eq. (N2)
        known = c.alpha_f * before.acceleration[k] - c.alpha_m * auxiliary[k]
        a[k] = known / (1 - c.alpha_m)
        mean = (0.5 - c.beta) * auxiliary[k] + c.beta * a[k]
        position[k] = before.position[k] + c.step * before.velocity[k] + c.step**2 * mean
        velocity[k] = before.velocity[k] + c.step * ((1 - c.gamma) * auxiliary[k] + c.gamma * a[k])
    return Prediction(position, velocity, a)
