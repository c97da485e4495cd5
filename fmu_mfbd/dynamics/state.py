"""The state of the bodies, the same in Python and in a native FMU."""

from typing import Annotated, NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable
from ..geometry.arrays import Vector
from ..mechanism.bdf2 import memory_of
from ..mechanism.generalised_alpha import Coefficients, Motion, coefficients
from ..mechanism.slider_crank import CrankMotion
from .first_steps import FIRST_STEPS, first_steps
from .instant import Instant
from .system import OtherForces, StepProblem


class PistonState(NamedTuple):
    """Everything that a step starts from; n coordinates.

    Parameters
    ----------
    time : float
        Since the start [s].
    crank_angle, crank_speed, crank_acceleration : float
        [rad], 0 at firing top dead centre; [rad/s]; [rad/s2].
    crank_jerk : float
        By which the acceleration of a free crank changed over the last step [rad/s3]; 0 for
        another.
    position, velocity, acceleration, auxiliary : ndarray, shape (n,)
        [x_A [m], rocking angle [rad], piston then block modal coordinates [kg^1/2 m]], derivatives
        in time, and the time integrator's auxiliary acceleration; for BDF2 the mean acceleration
        over the last step.
    mean_velocity : ndarray, shape (n,)
        Over the last step; 0 without one.
    step : float
        Length of the last step [s]; 0 without one.
    kinetic : float
        Energy of the motion across the bore, the rod's with it [J].
    other_forces : ndarray, shape (n,)
        On that motion at the start of the next step, all but the film's [N], [N m], [kg^-1/2 N].
    steps : int
        Taken since the start.
    thermal_opening : float
        Change of the film thickness with the temperatures (Eq. (I12)) [m].
    bore_deflection : ndarray, shape (w, s)
        Deflection that another participant gave [m]. Shape (0, 0) if none did.
    field_growth : ndarray, shape (g,)
        Growth of walls by field inputs of temperature (`thermal_growth.field_growth`) [m].
    """

    time: float
    crank_angle: float
    crank_speed: float
    crank_acceleration: float
    crank_jerk: float
    position: Vector
    velocity: Vector
    acceleration: Vector
    auxiliary: Vector
    mean_velocity: Vector
    step: float
    kinetic: float
    other_forces: Vector
    steps: int
    thermal_opening: float
    bore_deflection: Annotated[np.ndarray, "w, s"]
    field_growth: Annotated[np.ndarray, "g"]


@compilable
def state_at(
    before: PistonState,
    step: float,
    now: Instant,
    crank: CrankMotion,
    jerk: float,
    time: float,
    steps: int,
    growth: tuple[float, np.ndarray],
) -> PistonState:
    """Return the state a step [s] after another; the first steps remember no acceleration.

    `growth` is that of `thermal_opening` and that of `field_growth` [m].
    """
    opening, by_field = growth
    auxiliary = np.zeros(len(now.auxiliary)) if steps < FIRST_STEPS else now.auxiliary
    mean_velocity = np.zeros(len(auxiliary))
    if step > 0.0:
        mean_velocity = (now.end.position - before.position) / step
    return PistonState(
        time=time,
        crank_angle=crank.angle,
        crank_speed=crank.speed,
        crank_acceleration=crank.acceleration,
        crank_jerk=jerk,
        position=now.end.position,
        velocity=now.next_start.velocity,
        acceleration=now.next_start.acceleration,
        auxiliary=auxiliary,
        mean_velocity=mean_velocity,
        step=step,
        kinetic=now.ledger.accounted,
        other_forces=now.next_other_forces,
        steps=steps,
        thermal_opening=opening,
        bore_deflection=np.zeros((0, 0)),
        field_growth=by_field,
    )


@compilable
def problem_of(
    c: Coefficients, before: PistonState, crank: CrankMotion, others: OtherForces
) -> StepProblem:
    """Return the problem of a step from a state."""
    motion = Motion(before.position, before.velocity, before.acceleration)
    return StepProblem(
        coefficients=c,
        before=motion,
        auxiliary=before.auxiliary,
        mean_velocity=before.mean_velocity,
        crank=crank,
        others=others,
    )


@compilable
def step_coefficients(state: PistonState, step: float, spectral_radius: float) -> Coefficients:
    """Return the coefficients of a step [s] that starts from a state."""
    if state.steps < FIRST_STEPS:
        return first_steps(step)
    return coefficients(step, spectral_radius, memory_of(step, state.step))
