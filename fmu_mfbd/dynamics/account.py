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
    """Compute the energy that the bodies took from the film over a step, from their motion.

    Eq. (D14):  E = T_1 - T_0 - (q_1 - q_0) . (O_0 + O_1)/2 + h (axial power)
    Eq. (D16):  Z = max(T_0, T_1) + |q_1 - q_0| . (|O_0| + |O_1|)/2

    What they hold more of and what other forces took, Eq. (D15), by the trapezoidal rule. It does
    not go by the film's forces: where a time integrator returns a stop as a rebound E shows it. An
    integrator errs by a share of Z, and not of what the film did: in free flight that is nothing.
    After an impact, Eq. (N7), O_0 has the acceleration that the step starts from: the film counts
    all of its force at the start, but less of it drives the bodies, and O_0 holds the difference.
    T holds the rod that swings with x_A (Eq. (K12)): a stop throws it too, and its inertia among
    the O, up and gone within a step, would pass for energy.

    Parameters
    ----------
    kinetic : (float, float)
        T_0, T_1 [J].
    travel : ndarray, shape (n,)
        q_1 - q_0.
    others : (ndarray, ndarray)
        O_0, O_1, shape (n,).
    axial_work : float
        Of the film along the bore's axis [J].

    Returns
    -------
    EnergyAccount
    """
    before, after = kinetic
    begun, ended = others
    gain = after - before - float(travel @ (begun + ended)) / 2 + axial_work  # Eq. (D14)
    turned = float(np.abs(travel) @ (np.abs(begun) + np.abs(ended))) / 2
    return EnergyAccount(gain, max(before, after), turned)  # Eq. (D16)
