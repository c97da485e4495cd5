"""Step of the bodies as one kernel, for derivatives by small differences of the step."""

from ...master.fmi.compiled import compilable
from .response import StepInputs
from .state import PistonState, problem_of, step_coefficients
from .step import BodyModel, StepResult, crank_after, instant_of, others_at, result_of


@compilable
def advance(model: BodyModel, before: PistonState, inputs: StepInputs, step: float) -> StepResult:
    """Return the end of a step [s], as of `model.PistonInBore.advance`.

    `evaluations` of its `Instant` are 0 if the equations were not solved.
    """
    crank = crank_after(model, before, step, inputs.crank_speed)
    c = step_coefficients(before, step, model.settings.spectral_radius)
    problem = problem_of(c, before, crank, others_at(model, inputs, crank))
    now = instant_of(model, problem, inputs)
    return result_of(model, before, problem, before.time + step, now, inputs)
