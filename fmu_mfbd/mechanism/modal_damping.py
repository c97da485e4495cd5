"""Springs and dampers of modes: one damping ratio for slow modes, another for fast ones."""

from typing import Any, NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable
from ..geometry.arrays import Vector


class ModalSprings(NamedTuple):
    """Squares of the frequencies of modes [rad2/s2] and their damping [rad/s], shape (k,)."""

    stiffness: Vector
    damping: Vector


@compilable
def modal_springs(omega: np.ndarray, p: Any) -> ModalSprings:
    """Return springs and dampers of modes (Eq. (I5)).

    Parameters
    ----------
    omega : ndarray, shape (k,)
        [rad/s]
    p : Parameters
    """
    out = ModalSprings(omega * omega, np.empty(len(omega)))
    put_damping(out.damping, out.stiffness, p)
    return out


@compilable
def put_damping(damping: np.ndarray, stiffness: np.ndarray, p: Any) -> None:
    """Write the damping of modes with these stiffnesses.

    Eq. (I5):  D = 2 zeta omega      zeta the ratio below or above the transition

    Parameters
    ----------
    damping : ndarray, shape (k,)
        D, overwritten [rad/s].
    stiffness : ndarray, shape (k,)
        omega^2 [rad2/s2]; its root is omega to the bit.
    p : Parameters
        zeta: damping_ratio below damping_transition_frequency, and high_frequency_damping_ratio
        from there on [-].
    """
    for k in range(len(stiffness)):
        omega = np.sqrt(stiffness[k])
        fast = 2 * np.pi * p.damping_transition_frequency <= omega
        zeta = p.high_frequency_damping_ratio if fast else p.damping_ratio
        damping[k] = 2 * zeta * omega  # Eq. (I5)
