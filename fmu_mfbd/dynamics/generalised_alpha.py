"""Generalised-alpha time integration: the coefficients and the update, shared by every equation of
motion here.

References
----------
[ChungHulbert1993] J. Chung, G. M. Hulbert, J. Appl. Mech. 60 (1993) 371-375.
[ArnoldBruels2007] M. Arnold, O. Bruels, Multibody Syst. Dyn. 18 (2007) 185-202.
"""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compiled


class Coefficients(NamedTuple):
    """What a step of the generalised-alpha method needs; see `coefficients`.

    Parameters
    ----------
    step, alpha_m, alpha_f, beta, gamma : float
        [s]; [-].
    weight, rate, place : float
        What an end acceleration of 1 adds to the end's auxiliary acceleration [-], velocity [s] and
        position [s2].
    """

    step: float
    alpha_m: float
    alpha_f: float
    beta: float
    gamma: float
    weight: float
    rate: float
    place: float


def coefficients(step, spectral_radius):
    """Coefficients of the method of order 2 with a given damping of what the step cannot resolve.

    Eq. (G1):  alpha_m = (2 rho - 1)/(rho + 1),  alpha_f = rho/(rho + 1),  gamma = 1/2 + alpha_f - alpha_m,  beta = (gamma +
               1/2)^2 / 4

    Parameters
    ----------
    step : float
        Step [s], > 0.
    spectral_radius : float
        rho at infinite frequency [-], 0 (annihilates it in one step) to 1 (keeps all energy).

    Returns
    -------
    Coefficients

    References
    ----------
    [ChungHulbert1993]. Order 2 is checked in tests/verification/test_mfbd.py.
    """
    rho = spectral_radius
    alpha_m, alpha_f = (2 * rho - 1) / (rho + 1), rho / (rho + 1)  # Eq. (G1)
    gamma = 0.5 + alpha_f - alpha_m
    beta, weight = (gamma + 0.5) ** 2 / 4, (1 - alpha_f) / (1 - alpha_m)
    return Coefficients(
        step, alpha_m, alpha_f, beta, gamma, weight, weight * step * gamma, weight * step**2 * beta
    )


@compiled
def predict(c, place, rate, acceleration, auxiliary):
    """End position, velocity and auxiliary acceleration if the end acceleration were zero.

    Eq. (G2):  (1 - alpha_m) a_1 + alpha_m a_0 = (1 - alpha_f) q''_1 + alpha_f q''_0
               q'_1 = q'_0 + h ((1 - gamma) a_0 + gamma a_1)
               q_1  = q_0 + h q'_0 + h^2 ((1/2 - beta) a_0 + beta a_1)

    The equation of motion holds exactly at the end of the step, with the end-of-step forces;
    `Coefficients.weight`, `.rate` and `.place` add the part of q''_1.

    Parameters
    ----------
    c : Coefficients
    place, rate, acceleration, auxiliary : ndarray, shape (n,)
        q_0, q'_0, q''_0, a_0.

    Returns
    -------
    place, rate, auxiliary : ndarray, shape (n,)

    References
    ----------
    [ArnoldBruels2007]
    """
    end, speed, a = np.empty(len(place)), np.empty(len(place)), np.empty(len(place))
    for k in range(len(place)):  # a loop: array expressions take the compiler seconds each
        a[k] = (c.alpha_f * acceleration[k] - c.alpha_m * auxiliary[k]) / (
            1 - c.alpha_m
        )  # Eq. (G2)
        end[k] = (
            place[k]
            + c.step * rate[k]
            + c.step**2 * ((0.5 - c.beta) * auxiliary[k] + c.beta * a[k])
        )
        speed[k] = rate[k] + c.step * ((1 - c.gamma) * auxiliary[k] + c.gamma * a[k])
    return end, speed, a
