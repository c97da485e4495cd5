"""Springs and dampers of modes, and the number of modes with inertia."""

from typing import Any, NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable
from ..geometry.arrays import Vector


class ModalSprings(NamedTuple):
    """Squares of the frequencies of modes [rad2/s2] and their damping [rad/s], shape (k,)."""

    stiffness: Vector
    damping: Vector


@compilable
def count_modes_with_inertia(omega: np.ndarray, highest: float) -> int:
    """Return the number of modes with inertia, which are those up to the frequency `highest` [Hz].

    omega : ndarray, shape (k,), ascending [rad/s]. Modes above are quasi-static.
    """
    count = 0
    for frequency in omega:
        count += frequency <= 2 * np.pi * highest
    return count


@compilable
def put_damping(damping: np.ndarray, stiffness: np.ndarray, p: Any) -> None:
    """Write the damping of modes with these stiffnesses.

    Eq. (I5):  D = 2 zeta omega      zeta the ratio below or above the transition

    Parameters
    ----------
    damping : ndarray, shape (k,)
        D, overwritten [rad/s].
    stiffness : ndarray, shape (k,)
        omega times omega [rad2/s2], of which np.sqrt returns omega exactly.
    p : Parameters
        zeta: `damping_ratio` below `damping_transition_frequency`, `high_frequency_damping_ratio`
        above [-].
    """
    for k in range(len(stiffness)):
        omega = np.sqrt(stiffness[k])
        fast = 2 * np.pi * p.damping_transition_frequency <= omega
        zeta = p.high_frequency_damping_ratio if fast else p.damping_ratio
        damping[k] = 2 * zeta * omega  # Eq. (I5)
