"""Energy of the motion across the bore: what the bodies hold, and what a step gave them."""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compiled
from ..geometry.film import FilmForces
from .floating_frame import FlexibleBody, X
from .generalised_alpha import Motion
from .impact import Inertia, inertia_product
from .piston_motion import LATERAL, RIGID, ROCKING
from .skirt_films import by_coordinate


class EnergyLedger(NamedTuple):
    """Energies at the end of a step, and what came in over it.

    Parameters
    ----------
    kinetic, elastic : float
        Of the motion across the bore, rocking and all modes; of all modes [J].
    film_work : float
        Of the film on both bodies over the step [J].
    error : float
        `energy_error` [J].
    axial_work : float
        Part of `film_work` along the bore's axis [J].
    accounted : float
        `kinetic` and what the rod holds by the motion of x_A (Eq. (K12)) [J].
    """

    kinetic: float
    elastic: float
    film_work: float
    error: float
    axial_work: float
    accounted: float


class MovingBodies(NamedTuple):
    """Everything that has inertia across the bore.

    Parameters
    ----------
    body : FlexibleBody
        The piston.
    rigid : Inertia
        Its rigid motion, pin included.
    block : int
        Number of the block's first coordinate.
    block_stiffness : ndarray, shape (k',)
        omega^2 of its modes that have inertia [rad2/s2].
    """

    body: FlexibleBody
    rigid: Inertia
    block: int
    block_stiffness: np.ndarray


@compiled
def motion_product(moving: MovingBodies, a: np.ndarray, b: np.ndarray) -> float:
    """Return a . M b of the rigid motion across the bore (Eq. (N6)) and of modes with inertia.

    Eq. (D9):  a . M b = Eq. (N6) + sum ((a_x T_x + a_t g) b_q + (b_x T_x + b_t g) a_q + a_q b_q)

    Parameters
    ----------
    moving : MovingBodies
    a, b : ndarray, shape (n,)
    """
    body = moving.body
    total = inertia_product(moving.rigid, a, b)
    for k in range(len(body.stiffness)):
        # Eq. (D9)
        total += (a[LATERAL] * body.T[X, k] + a[ROCKING] * body.g[k]) * b[RIGID + k]
        total += (b[LATERAL] * body.T[X, k] + b[ROCKING] * body.g[k]) * a[RIGID + k]
        total += a[RIGID + k] * b[RIGID + k]
    for k in range(moving.block, moving.block + len(moving.block_stiffness)):
        total += a[k] * b[k]
    return total


@compiled
def elastic_energy(moving: MovingBodies, position: np.ndarray) -> float:
    """Return the energy of the modes that have inertia, half the sum of Omega^2 q^2 [J]."""
    total = 0.0
    stiffness = moving.body.stiffness
    for k in range(len(stiffness)):
        total += stiffness[k] * position[RIGID + k] ** 2 / 2
    for k in range(len(moving.block_stiffness)):
        total += moving.block_stiffness[k] * position[moving.block + k] ** 2 / 2
    return total


@compiled
def energy_error(moving: MovingBodies, before: Motion, kept: Motion, end: Motion) -> float:
    """Return the energy that time integration created (+) or lost (-) in a step [J].

    Eq. (D10):  e = T_1 - T_0 - (q_1 - q_0) . M (q''_0 + q''_1)/2,   T = q' . M q'/2

    The second part is the work of all forces by the trapezoidal rule, springs' exactly; e falls
    with the third power of the step in smooth motion.

    Parameters
    ----------
    moving : MovingBodies
    before, kept, end : Motion
        At the start; at the end, as the next step starts from it and as the equations hold.
    """
    n = len(before.position)
    way = np.empty(n)
    mean = np.empty(n)
    for k in range(n):
        way[k] = end.position[k] - before.position[k]
        mean[k] = (before.acceleration[k] + end.acceleration[k]) / 2
    first = motion_product(moving, before.velocity, before.velocity)
    last = motion_product(moving, kept.velocity, kept.velocity)
    return (last - first) / 2 - motion_product(moving, way, mean)  # Eq. (D10)


@compiled
def film_work(
    forces: FilmForces, before: np.ndarray, position: np.ndarray, rubbing: float
) -> float:
    """Return the work of the film on both bodies over a step, with its forces at the end [J].

    Eq. (D11):  W = Q . (q_1 - q_0) + h (axial power)

    Without a film that stores energy this is minus what the film turns into heat.

    Parameters
    ----------
    forces : FilmForces
    before, position : ndarray, shape (n,)
        At both ends of the step.
    rubbing : float
        Work along the bore's axis [J].
    """
    push = by_coordinate(forces)
    work = rubbing
    for k in range(len(position)):
        work += push[k] * (position[k] - before[k])  # Eq. (D11)
    return work


@compiled
def other_forces(moving: MovingBodies, acceleration: np.ndarray, forces: FilmForces) -> np.ndarray:
    """Compute all forces on the motion across the bore except the film's, from its acceleration.

    They are forces of springs, damping, gas, pin and rod. If `moving` holds the rod's inertia
    against x_A'', that part is omitted.

    Eq. (D15):  O = M q'' - Q

    Parameters
    ----------
    moving : MovingBodies
    acceleration : ndarray, shape (n,)
        As the equations of motion hold.
    forces : FilmForces
        Q.

    Returns
    -------
    ndarray, shape (n,)
        [N], [N m], [kg^-1/2 N].
    """
    body = moving.body
    rigid = moving.rigid
    a = acceleration
    push = by_coordinate(forces)
    out = np.empty(len(a))
    # Eq. (D15), with M of Eq. (D9); modes that follow statically have none
    out[LATERAL] = rigid.mass * a[LATERAL] - rigid.moment * a[ROCKING] - push[LATERAL]
    out[ROCKING] = rigid.inertia * a[ROCKING] - rigid.moment * a[LATERAL] - push[ROCKING]
    for k in range(RIGID, len(a)):
        out[k] = -push[k]
    for k in range(len(body.stiffness)):
        m = RIGID + k
        out[LATERAL] += body.T[X, k] * a[m]
        out[ROCKING] += body.g[k] * a[m]
        out[m] += a[m] + body.T[X, k] * a[LATERAL] + body.g[k] * a[ROCKING]
    for k in range(moving.block, moving.block + len(moving.block_stiffness)):
        out[k] += a[k]
    return out
