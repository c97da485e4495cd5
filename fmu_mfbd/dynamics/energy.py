"""Energy of the motion across the bore at the end of a step, and its change in the step."""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compiled
from ..mechanism.floating_frame import ArrowMatrix
from ..mechanism.generalised_alpha import Motion
from ..mechanism.solution import arrow_product


class EnergyLedger(NamedTuple):
    """Energies at the end of a step, and works during the step.

    Parameters
    ----------
    kinetic, elastic : float
        Kinetic energy of lateral motion, rocking and all modes; elastic energy of all modes [J].
    film_work : float
        Work of the film on both bodies in the step [J].
    error : float
        e of Eq. (D10) [J].
    axial_work : float
        Part of `film_work` along the bore's axis [J].
    accounted : float
        `kinetic` and that of the rod by the motion of x_A (Eq. (K12)) [J].
    """

    kinetic: float
    elastic: float
    film_work: float
    error: float
    axial_work: float
    accounted: float


@compiled
def energy_ledger(
    before: Motion,
    next_start: Motion,
    end: Motion,
    inertia: ArrowMatrix,
    with_rod: ArrowMatrix,
    push: np.ndarray,
    driven: float,
    elastic: float,
) -> EnergyLedger:
    """Return the energies at the end of a step.

    Eq. (D10):  e = T_1 - T_0 - (q_1 - q_0) . M (q''_0 + q''_1)/2,   T = q' . M q'/2
    Eq. (D11):  W = Q . (q_1 - q_0) + h (axial power)

    The last part of e is the work of all forces by the trapezoidal rule, springs' exactly; e falls
    with the third power of the step in smooth motion. W is the work of the film with its forces at
    the end. If the film stores no energy, -W is what it turns into heat.

    Parameters
    ----------
    before, next_start, end : Motion
        At the start; at the end, as the next step starts from it and as the equations hold.
    inertia, with_rod : ArrowMatrix
        M, without and with the rod.
    push : ndarray, shape (n,)
        Generalised forces Q of all films [N], [N m], [kg^-1/2 N].
    driven, elastic : float
        Work along the bore's axis, energy of all modes [J].
    """
    mean = (before.acceleration + end.acceleration) / 2
    along = arrow_product(with_rod, mean)
    began, ended = (
        arrow_product(with_rod, before.velocity),
        arrow_product(with_rod, next_start.velocity),
    )
    alone = arrow_product(inertia, next_start.velocity)
    first = 0.0
    last = 0.0
    moving = 0.0
    by_forces = 0.0
    work = driven
    for k in range(len(push)):
        travel = end.position[k] - before.position[k]
        work += push[k] * travel  # Eq. (D11)
        by_forces += travel * along[k]
        first += before.velocity[k] * began[k]
        last += next_start.velocity[k] * ended[k]
        moving += next_start.velocity[k] * alone[k]
    error = (last - first) / 2 - by_forces  # Eq. (D10)
    return EnergyLedger(
        kinetic=moving / 2,
        elastic=elastic,
        film_work=work,
        error=error,
        axial_work=driven,
        accounted=last / 2,
    )


@compiled
def other_forces(with_rod: ArrowMatrix, acceleration: np.ndarray, push: np.ndarray) -> np.ndarray:
    """Compute all forces on the motion across the bore except the film's, shape (n,).

    They are forces of springs, damping, gas, pin and rod. The part that the rod's inertia needs is
    omitted.

    Eq. (D15):  O = M q'' - Q
    """
    return arrow_product(with_rod, acceleration) - push  # Eq. (D15)
