"""Impact: what the time integrator may remember of a step in which the motion was stopped.

A linear method of order 2 puts the end velocity at 2 (mean velocity) - (start velocity) or nearly
so, and carries the acceleration on: a film that stops a piston within one step sends it back, and
the memory drives it on. Generalised-alpha with spectral radius 0.6 returns up to 2.5 times the
velocity, any other one up to 0.9 times (radius 0) and more; a mass pushed onto the film bounces
for ever. As with shocks in gases, the cure cannot be linear: where a step is an impact, its end
velocity is the mean one, as backward Euler's, and the memory is bounded. Elsewhere nothing changes.
Taking too much for an impact costs accuracy: a mean velocity is half a step late.
"""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compiled
from .generalised_alpha import Motion
from .piston_motion import RIGID

IMPACT = 0.25
"""A step is an impact if the change of acceleration over it is worth more than this share of the
larger velocity at its ends. A mass on a film bounces from 0.5 on; in smooth motion the share falls
with the square of the step.
"""

SUDDEN = 0.5
"""... and more than this share of the acceleration before: a stop that several steps resolve grows
from one to the next, and is left to the integrator.
"""

GROWING = 0.25
"""A step is repeated in parts from a smaller share on: a stop may build up over two steps."""

KEPT = 0.5
"""Velocity that the remembered acceleration may be worth over one step, by the velocity left: a
memory worth all of it turns the motion round.
"""

UNLIMITED = 1e3
"""Longest step of a motion that any step resolves [s]."""


class Inertia(NamedTuple):
    """Inertia across the bore of the piston as one rigid body.

    Parameters
    ----------
    mass : float
        Of piston and pin [kg].
    moment : float
        First moment S_y of the piston about A [kg m].
    inertia : float
        I0 about A [kg m2].
    """

    mass: float
    moment: float
    inertia: float


@compiled
def inertia_product(inertia: Inertia, a: np.ndarray, b: np.ndarray) -> float:
    """Return a . M b; if both are the velocity, twice the kinetic energy across the bore.

    Eq. (N6):  a . M b = m a_x b_x - S_y (a_x b_t + a_t b_x) + I0 a_t b_t

    Parameters
    ----------
    inertia : Inertia
    a, b : ndarray, shape (n,)
        Of x_A and the rocking angle; what follows is not looked at.

    Returns
    -------
    float
    """
    # Eq. (N6)
    rocking = inertia.inertia * a[1] * b[1] - inertia.moment * (a[0] * b[1] + a[1] * b[0])
    return inertia.mass * a[0] * b[0] + rocking


@compiled
def longest_step(
    inertia: Inertia,
    before: Motion,
    end: Motion,
    auxiliary: np.ndarray,
    step: float,
    resolution: float,
) -> float:
    """Return the longest step that resolves the motion, before `limit_memory` changes its end [s].

    A result below h asks for a repetition of the step in parts: the force changes too much within
    it. Otherwise it is the limit of the next step. In a longer one, the remembered acceleration
    would turn the motion round.

    Eq. (N12):  unresolved:  h |q''_1 - q''_0| > max(V, h |q''_0|/4, r/h),
                             q'_0 . M q''_1 < 0  and  q'_0 . M (q_1 - q_0) > 0
                then         V/|q''_1 - q''_0|,   V = max(|q'_0|, |q'_1|)/4
                otherwise    max(h, |q'_1|/(2 A), sqrt(r/A)),   A = max(|q''_1|, |a_1|)
                norms |q| by the inertia M (Eq. (N6)), r also, as displacement of A alone

    Parameters
    ----------
    inertia : Inertia
    before, end : Motion
        At both ends of the step, x_A and the rocking angle first.
    auxiliary : ndarray, shape (n,)
        a_1, at its end.
    step : float
        h [s].
    resolution : float
        r, displacement in a step that is too small to be resolved [m].

    Returns
    -------
    float
        At most `UNLIMITED`.
    """
    if step == 0.0:
        return UNLIMITED
    jump = np.empty(RIGID)
    travel = np.empty(RIGID)
    for k in range(RIGID):
        jump[k] = end.acceleration[k] - before.acceleration[k]
        travel[k] = end.position[k] - before.position[k]
    size = np.sqrt(inertia.mass) * resolution
    left = inertia_product(inertia, end.velocity, end.velocity)
    fast = IMPACT * np.sqrt(max(inertia_product(inertia, before.velocity, before.velocity), left))
    steady = GROWING**2 * inertia_product(inertia, before.acceleration, before.acceleration)
    change = np.sqrt(inertia_product(inertia, jump, jump))
    if (
        step * change > max(fast, step * np.sqrt(steady), size / step)
        and inertia_product(inertia, before.velocity, end.acceleration) < 0.0
        and inertia_product(inertia, before.velocity, travel) > 0.0
    ):
        return fast / change  # Eq. (N12)
    known = max(
        inertia_product(inertia, end.acceleration, end.acceleration),
        inertia_product(inertia, auxiliary, auxiliary),
    )
    if known == 0.0:
        return UNLIMITED
    remembered = np.sqrt(known)
    longest = max(KEPT * np.sqrt(left) / remembered, np.sqrt(size / remembered))
    return min(UNLIMITED, max(step, longest))  # Eq. (N12)


@compiled
def limit_memory(
    inertia: Inertia, before: Motion, end: Motion, auxiliary: np.ndarray, step: float
) -> bool:
    """Bound what the end of an impact step passes on to the next step.

    Positions and the film do not change.

    Eq. (N7):  impact:  h |q''_1 - q''_0| > max(|q'_0|, |q'_1|)/4,  |q''_1 - q''_0| > 0.5 |q''_0|,
                        q'_0 . M q''_1 < 0  and  q'_0 . M (q_1 - q_0) > 0
               then     q'_1 = (q_1 - q_0)/h,  a_1 = q''_1 = q''_1 min(1, |q'_1|/(2 h |q''_1|))
               norms |q| by the inertia M (Eq. (N6))

    Both coordinates of the rigid motion are limited together: an impact has one direction. Modes
    are left alone: what stops them is their own spring, which does give back what it took, and
    what the step cannot resolve of them the spectral radius damps.

    Parameters
    ----------
    inertia : Inertia
    before, end : Motion
        At both ends of the step, x_A and the rocking angle first; `end` is changed.
    auxiliary : ndarray, shape (n,)
        At its end; changed.
    step : float
        h [s].

    Returns
    -------
    bool
        Whether the step was an impact.
    """
    if step == 0.0:
        return False
    if inertia_product(inertia, before.velocity, end.acceleration) >= 0.0:
        return False
    jump = np.empty(RIGID)
    mean = np.empty(RIGID)
    for k in range(RIGID):
        jump[k] = step * (end.acceleration[k] - before.acceleration[k])
        mean[k] = (end.position[k] - before.position[k]) / step
    began = inertia_product(inertia, before.velocity, before.velocity)
    ended = inertia_product(inertia, end.velocity, end.velocity)
    steady = step**2 * inertia_product(inertia, before.acceleration, before.acceleration)
    least = max(IMPACT**2 * max(began, ended), SUDDEN**2 * steady)
    if inertia_product(inertia, jump, jump) <= least:
        return False
    # what has turned round within the step was driven back, by something else than a film
    if inertia_product(inertia, before.velocity, mean) <= 0.0:
        return False
    # Eq. (N7)
    for k in range(RIGID):
        end.velocity[k] = mean[k]
    left = np.sqrt(inertia_product(inertia, end.velocity, end.velocity))
    worth = step * np.sqrt(inertia_product(inertia, end.acceleration, end.acceleration))
    share = min(1.0, KEPT * left / worth)
    for k in range(RIGID):
        end.acceleration[k] *= share
        auxiliary[k] = end.acceleration[k]
    return True
