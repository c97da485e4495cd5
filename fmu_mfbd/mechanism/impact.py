"""Impact: limits of the velocity and acceleration that a stopped motion passes to the next step.

A linear method of order 2 has an end velocity of about 2 (mean velocity) - (start velocity), and
keeps the acceleration for the next step. If a film stops a piston within one step, such a method
therefore sends the piston back, and the remembered acceleration drives it further.
Generalised-alpha returns up to 2.5 times the velocity with a spectral radius of 0.6, and at least
up to 0.9 times, with radius 0. A mass that is pressed onto the film would bounce for ever.

As for shocks in gases, a linear method cannot avoid this. In a step that is an impact, the end
velocity is the mean velocity, as in backward Euler, and the remembered acceleration is bounded.
Other steps do not change. A step that is taken for an impact by mistake is less accurate, because
a mean velocity is half a step late.
"""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compiled
from .generalised_alpha import Motion
from .piston_motion import RIGID

IMPACT = 0.25
"""Least change of acceleration in an impact, times the step, over the larger of both velocities.

A mass on a film bounces from 0.5 on. In smooth motion the share falls with the square of the step.
"""

SUDDEN = 0.5
"""Least change of acceleration in an impact, over the acceleration before.

A stop that several steps resolve grows from step to step, and the integrator handles it.
"""

GROWING = 0.25
"""As `SUDDEN`, for the repetition of a step in parts: a stop may build up over two steps."""

KEPT = 0.5
"""Largest remembered acceleration, times the step, over the end velocity.

At 1, the next step would reverse the motion.
"""

UNLIMITED = 1e3
"""Result of `longest_step` for a motion that any step resolves [s]."""


class Inertia(NamedTuple):
    """Inertia across the bore of the piston as one rigid body.

    Parameters
    ----------
    mass : float
        Of piston and pin [kg].
    moment : float
        First moment S_y of the piston about A, which couples both motions [kg m].
    inertia : float
        I0 about A [kg m2].
    """

    mass: float
    moment: float
    inertia: float


@compiled
def inertia_product(inertia: Inertia, a: np.ndarray, b: np.ndarray) -> float:
    """Return a . M b; if both are the velocity, twice the kinetic energy across the bore.

    Eq. (N6):  a . M b = m a_x b_x - S_y (a_x b_t + a_t b_x) + I0 a_t b_t      t: rocking angle

    Parameters
    ----------
    inertia : Inertia
    a, b : ndarray, shape (n,)
        Of x_A and the rocking angle; further elements are ignored.

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

    If the result is below h, the force changes too much within the step, and the step must be
    repeated in parts. Otherwise the result is the limit of the next step. In a longer one, the
    remembered acceleration would reverse the motion.

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
        a_1 of generalised-alpha at its end, the acceleration that the next step remembers.
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
    ended = inertia_product(inertia, end.velocity, end.velocity)
    fast = IMPACT * np.sqrt(max(inertia_product(inertia, before.velocity, before.velocity), ended))
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
    longest = max(KEPT * np.sqrt(ended) / remembered, np.sqrt(size / remembered))
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

    Both coordinates of the rigid motion are limited together, because an impact has one direction.
    Modes are not limited. Their own springs stop them and return the energy, and the spectral
    radius damps the part that the step cannot resolve.

    Parameters
    ----------
    inertia : Inertia
    before, end : Motion
        At both ends of the step, x_A and the rocking angle first; `end` is changed.
    auxiliary : ndarray, shape (n,)
        a_1 of generalised-alpha at its end; changed.
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
    # a motion that reversed within the step was driven back by another force than a film
    if inertia_product(inertia, before.velocity, mean) <= 0.0:
        return False
    # Eq. (N7)
    for k in range(RIGID):
        end.velocity[k] = mean[k]
    speed = np.sqrt(inertia_product(inertia, end.velocity, end.velocity))
    worth = step * np.sqrt(inertia_product(inertia, end.acceleration, end.acceleration))
    share = min(1.0, KEPT * speed / worth)
    for k in range(RIGID):
        end.acceleration[k] *= share
        auxiliary[k] = end.acceleration[k]
    return True
