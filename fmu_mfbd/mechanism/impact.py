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

VELOCITY_SHARE = 0.25
"""Least change of acceleration in an impact, times the step, over the larger of both velocities.

A mass on a film bounces from 0.5 on. In smooth motion the share falls with the square of the step.
"""

ACCELERATION_SHARE = 0.5
"""Least change of acceleration in an impact, over the acceleration before.

A stop that several steps resolve grows from step to step, and the integrator handles it.
"""

SHARE_IN_PARTS = 0.25
"""As `ACCELERATION_SHARE`, for steps that are repeated in parts. A stop may build up over two."""

MEMORY_SHARE = 0.5
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
        Mass of piston and pin [kg].
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
        Displacements, velocities or accelerations: x_A, rocking angle. Further elements are
        ignored.

    Returns
    -------
    float
    """
    # Eq. (N6)
    rocking = inertia.inertia * a[1] * b[1] - inertia.moment * (a[0] * b[1] + a[1] * b[0])
    return inertia.mass * a[0] * b[0] + rocking


@compiled
def inertia_norm(inertia: Inertia, a: np.ndarray) -> float:
    """Return |a| = sqrt(a . M a), Eq. (N6)."""
    return np.sqrt(inertia_product(inertia, a, a))


@compiled
def change_norm(inertia: Inertia, before: np.ndarray, end: np.ndarray) -> float:
    """Return |end - before|, Eq. (N6)."""
    change = np.empty(RIGID)
    for k in range(RIGID):
        change[k] = end[k] - before[k]
    return inertia_norm(inertia, change)


@compiled
def is_impact(
    inertia: Inertia, before: Motion, end: Motion, step: float, share: float, least: float
) -> bool:
    """Return whether a film stops the motion within a step.

    Eq. (N14):  h |q''_1 - q''_0| > max(V, s h |q''_0|, d/h),   V = max(|q'_0|, |q'_1|)/4,
                q'_0 . M q''_1 < 0  and  q'_0 . M (q_1 - q_0) > 0

    If the motion reverses within the step, another force than a film drives it back. Norms |q| are
    those of the inertia M (Eq. (N6)).

    Parameters
    ----------
    inertia : Inertia
    before, end : Motion
        At both ends of the step, x_A and the rocking angle first.
    step : float
        h [s], > 0.
    share : float
        s, least change of acceleration over the acceleration before [-].
    least : float
        d, least displacement by the change of acceleration, as a norm [kg^1/2 m].

    Returns
    -------
    bool
    """
    travel = np.empty(RIGID)
    for k in range(RIGID):
        travel[k] = end.position[k] - before.position[k]
    change = step * change_norm(inertia, before.acceleration, end.acceleration)
    earlier = share * step * inertia_norm(inertia, before.acceleration)
    return (
        change > max(least_velocity(inertia, before, end), earlier, least / step)
        and inertia_product(inertia, before.velocity, end.acceleration) < 0.0
        and inertia_product(inertia, before.velocity, travel) > 0.0
    )  # Eq. (N14)


@compiled
def least_velocity(inertia: Inertia, before: Motion, end: Motion) -> float:
    """Return V of Eq. (N14) [kg^1/2 m/s], arguments as of `is_impact`."""
    speed = max(inertia_norm(inertia, before.velocity), inertia_norm(inertia, end.velocity))
    return VELOCITY_SHARE * speed


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

    Eq. (N12):  in an impact, Eq. (N14) with s = 1/4 and d = r:  V/|q''_1 - q''_0|
                otherwise:  max(h, |q'_1|/(2 A), sqrt(r/A)),   A = max(|q''_1|, |a_1|)

    Norms are those of the inertia, Eq. (N6). That of r belongs to a displacement of A alone.

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
    size = np.sqrt(inertia.mass) * resolution
    if is_impact(inertia, before, end, step, SHARE_IN_PARTS, size):
        change = change_norm(inertia, before.acceleration, end.acceleration)
        return least_velocity(inertia, before, end) / change  # Eq. (N12)
    remembered = max(inertia_norm(inertia, end.acceleration), inertia_norm(inertia, auxiliary))
    if remembered == 0.0:
        return UNLIMITED
    ended = inertia_norm(inertia, end.velocity)
    longest = max(MEMORY_SHARE * ended / remembered, np.sqrt(size / remembered))
    return min(UNLIMITED, max(step, longest))  # Eq. (N12)


@compiled
def limit_memory(
    inertia: Inertia, before: Motion, end: Motion, auxiliary: np.ndarray, step: float
) -> bool:
    """Bound what the end of an impact step passes on to the next step.

    Positions and the film do not change.

    Eq. (N7):  q'_1 = (q_1 - q_0)/h,  a_1 = q''_1 = q''_1 min(1, |q'_1|/(2 h |q''_1|))
               in an impact, Eq. (N14) with s = 1/2 and d = 0

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
    if step == 0.0 or not is_impact(inertia, before, end, step, ACCELERATION_SHARE, 0.0):
        return False
    # Eq. (N7)
    for k in range(RIGID):
        end.velocity[k] = (end.position[k] - before.position[k]) / step
    speed = inertia_norm(inertia, end.velocity)
    by_memory = step * inertia_norm(inertia, end.acceleration)
    share = min(1.0, MEMORY_SHARE * speed / by_memory)
    for k in range(RIGID):
        end.acceleration[k] *= share
        auxiliary[k] = end.acceleration[k]
    return True
