"""BDF2 of variable steps: time integration of the stiff coordinates.

These are displacements of the pin within its play, which films resist, and modes next to these
films, which springs resist. Their free motion decays within microseconds, far below a step. BDF2
follows such a load with order 2 and without oscillation. A stop within a step is bounded as one of
the piston, Eq. (N7).

References
----------
[Hairer1993] E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd
ed., Springer 1993, section III.5 (variable-step BDF and their stability).
"""

import numpy as np

from ...master.fmi.compiled import compilable
from .generalised_alpha import Coefficients, Motion, Prediction, predict
from .impact import Inertia, limit_memory
from .motion import Increments

BY_ALPHA, BY_BDF2, STATIC = 0.0, 1.0, 2.0
"""Time integrators of a coordinate: generalised alpha, BDF2, or a mode that follows its load."""

LARGEST_RATIO = 2.0
"""Largest ratio of two steps that counts: BDF2 is zero-stable below 1 + sqrt(2) [Hairer1993]."""

UNIT = Inertia(1.0, 0.0, 1.0)
"""Inertia of a play: both directions count alike in Eq. (N6)."""


@compilable
def memory_of(step: float, last: float) -> float:
    """Return the time for which BDF2 continues the last step [s].

    Eq. (N11):  tau = H_n w^2/(1 + 2 w),   w = min(h/H_n, 2)

    Steps that grow by more than a factor of 2 are of first order.

    Parameters
    ----------
    step, last : float
        h and the step before, H_n [s]; 0 without one.
    """
    if last == 0.0:
        return 0.0
    ratio = min(step / last, LARGEST_RATIO)
    return last * ratio**2 / (1 + 2 * ratio)  # Eq. (N11)


@compilable
def reach_of(c: Coefficients, kinds: np.ndarray) -> Increments:
    """Return the change of coordinates with their unknowns.

    These are end accelerations (Eqs. (N2), (N9)), but for modes without inertia.

    Eq. (N13):  q_1 = q_0 + h^2 u,   q'_1 = (q_1 - q_0)/h,   q''_1 = 0      u the unknown of a mode
                without inertia; at the start q_1 = q_0 + u, q'_1 = 0

    Parameters
    ----------
    c : Coefficients
    kinds : ndarray, shape (n,)
        `BY_ALPHA`, `BY_BDF2` or `STATIC` of each coordinate.
    """
    n = len(kinds)
    out = Increments(np.empty(n), np.empty(n), np.ones(n))
    own = c.step - c.memory
    for k in range(n):
        out.velocity[k] = own if kinds[k] == BY_BDF2 else c.to_velocity
        out.position[k] = own**2 if kinds[k] == BY_BDF2 else c.to_position
        if kinds[k] == STATIC:
            # Eq. (N13)
            out.velocity[k], out.acceleration[k] = c.step, 0.0
            out.position[k] = c.step**2 if c.step > 0.0 else 1.0
    return out


@compilable
def predicted_of(
    c: Coefficients,
    before: Motion,
    auxiliary: np.ndarray,
    mean_velocity: np.ndarray,
    kinds: np.ndarray,
) -> Prediction:
    """Return the end of a step if its unknowns were zero.

    Eq. (N9):  q'_1 = q'_0 + tau a_0 + (h - tau) q''_1,   a_1 = (q'_1 - q'_0)/h
               q_1  = q_0 + tau u_0 + (h - tau) q'_1,     u_1 = (q_1 - q_0)/h

    This is BDF2 as a step of backward Euler (tau = 0) of length h - tau. Other coordinates follow
    Eqs. (N2) and (N13).

    Parameters
    ----------
    c : Coefficients
        h and its memory tau.
    before : Motion
        q_0, q'_0 and q''_0, shape (n,).
    auxiliary, mean_velocity : ndarray, shape (n,)
        a_0 and u_0 [m/s2], [m/s].
    kinds : ndarray, shape (n,)
        As of `reach_of`.
    """
    end = predict(c, before, auxiliary)
    for k in range(len(end.position)):
        if kinds[k] == BY_BDF2:
            # Eq. (N9)
            end.velocity[k] = before.velocity[k] + c.memory * auxiliary[k]
            passed = c.memory * mean_velocity[k]
            end.position[k] = before.position[k] + passed + (c.step - c.memory) * end.velocity[k]
        elif kinds[k] == STATIC:
            end.velocity[k], end.position[k] = 0.0, before.position[k]  # Eq. (N13)
    return end


@compilable
def auxiliary_after(
    c: Coefficients, predicted: Prediction, before: Motion, end: Motion, kinds: np.ndarray
) -> np.ndarray:
    """Return a_1 of Eqs. (N2) and (N9), shape (n,); `kinds` as of `reach_of`."""
    out = predicted.auxiliary
    for k in range(len(out)):
        if kinds[k] != BY_BDF2:
            out[k] += c.to_auxiliary * end.acceleration[k]
        elif c.step > 0.0:
            out[k] = (end.velocity[k] - before.velocity[k]) / c.step
    return out


@compilable
def limit_plays(
    plays: np.ndarray, before: Motion, end: Motion, auxiliary: np.ndarray, step: float
) -> None:
    """Bound what each play passes on if a film stopped it within the step, Eq. (N7).

    `plays` are the first coordinates of those of all films, -1 for none. Films that share a play
    follow each other.
    """
    last = -1
    for play in plays:
        if play >= 0 and play != last:
            pair = slice(play, play + 2)
            limit_memory(
                UNIT,
                Motion(before.position[pair], before.velocity[pair], before.acceleration[pair]),
                Motion(end.position[pair], end.velocity[pair], end.acceleration[pair]),
                auxiliary[pair],
                step,
            )
        last = play
