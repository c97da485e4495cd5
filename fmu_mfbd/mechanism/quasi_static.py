"""Modes too fast for the step: they follow their load without inertia of their own."""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable
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


@compilable
def moving_modes(omega: np.ndarray, highest: float) -> int:
    """Return the number of modes that have inertia, those up to a frequency [Hz]."""
    count = 0
    for one in omega:
        count += one <= 2 * np.pi * highest
    return count
