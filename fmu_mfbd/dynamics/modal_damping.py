"""Springs and dampers of modes: damping ratios by frequency bands, and Rayleigh's two terms."""

from typing import Any, NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable
from ..geometry.arrays import Vector


class ModalSprings(NamedTuple):
    """Squares of the frequencies of modes [rad2/s2] and their damping [rad/s], shape (k,)."""

    stiffness: Vector
    damping: Vector


class DampingBands(NamedTuple):
    """Damping ratios [-], each from a frequency on [Hz] to the next one; the first is from 0 Hz."""

    above: Vector
    ratio: Vector


@compilable
def bands_of(given: DampingBands, p: Any) -> DampingBands:
    """Return the bands of the build table, else the two of the parameters `p`."""
    if len(given.above) > 0:
        return given
    above = np.zeros(2)
    above[1] = p.damping_transition_frequency
    ratio = np.empty(2)
    ratio[0] = p.damping_ratio
    ratio[1] = p.high_frequency_damping_ratio
    return DampingBands(above, ratio)


@compilable
def modal_springs(omega: np.ndarray, given: DampingBands, p: Any) -> ModalSprings:
    """Return springs and dampers of modes.

    Eq. (I5):  D = 2 zeta omega + a + b omega^2      zeta the ratio of the band that omega/(2 pi)
                                                     lies in

    Parameters
    ----------
    omega : ndarray, shape (k,)
        [rad/s]
    given : DampingBands
        Of the build table, empty without.
    p : Parameters
        a, b: rayleigh_mass_factor [1/s], rayleigh_stiffness_factor [s].
    """
    bands = bands_of(given, p)
    out = ModalSprings(np.empty(len(omega)), np.empty(len(omega)))
    for k in range(len(omega)):
        zeta = 0.0
        for j in range(len(bands.above)):
            if 2 * np.pi * bands.above[j] <= omega[k]:
                zeta = bands.ratio[j]
        out.stiffness[k] = omega[k] * omega[k]
        # Eq. (I5)
        out.damping[k] = (
            2 * zeta * omega[k]
            + p.rayleigh_mass_factor
            + p.rayleigh_stiffness_factor * out.stiffness[k]
        )
    return out
