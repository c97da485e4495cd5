"""The bodies' account of energy over a step, of the motion across the bore and along it."""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable


class EnergyAccount(NamedTuple):
    """Energies of a step [J].

    gain : Eq. (D14); kinetic, exchanged : the two sizes of its terms, Eq. (D16).
    """

    gain: float
    kinetic: float
    exchanged: float


@compilable
def account(
    kinetic: tuple[float, float],
    travel: np.ndarray,
    others: tuple[np.ndarray, np.ndarray],
    axial_work: float,
) -> EnergyAccount:
    """Compute the energy that the film gave the bodies in a step, from their motion.

    Eq. (D14):  E = T_1 - T_0 - (q_1 - q_0) . (O_0 + O_1)/2 + h (axial power)
    Eq. (D16):  Z = max(T_0, T_1) + |q_1 - q_0| . (|O_0| + |O_1|)/2

    It is the change of kinetic energy minus the work of the other forces O, Eq. (D15), by the
    trapezoidal rule. It does not use the film's forces, so E shows if a time integrator returns a
    stop as a rebound. The error of an integrator is a share of Z, not of the work of the film,
    which is zero in free flight.

    After an impact, Eq. (N7), O_0 corresponds to the acceleration with which the step starts. The
    film counts its total force at the start, but less of it drives the bodies, and O_0 contains the
    difference. T contains the rod that swings with x_A (Eq. (K12)), because a stop moves it too. If
    its inertia were part of O, which exists only within the step, it would appear as energy.

    Parameters
    ----------
    kinetic : (float, float)
        T_0, T_1 [J].
    travel : ndarray, shape (n,)
        q_1 - q_0.
    others : (ndarray, ndarray)
        O_0, O_1, shape (n,).
    axial_work : float
        Work of the film along the bore's axis [J].

    Returns
    -------
    EnergyAccount
    """
    before, after = kinetic
    begun, ended = others
    gain = after - before - float(travel @ (begun + ended)) / 2 + axial_work  # Eq. (D14)
    turned = float(np.abs(travel) @ (np.abs(begun) + np.abs(ended))) / 2
    return EnergyAccount(gain, max(before, after), turned)  # Eq. (D16)
