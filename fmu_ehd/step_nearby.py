"""Step of a film next to a solved one, for the derivative of the step.

Python runs it as one kernel, `advance`.
"""

from typing import NamedTuple

from ..master.fmi.compiled import compilable
from .balance.coated_film import StepSolution
from .balance.flow_film import flow_film
from .balance.nearby import SolvedBalance, solve_nearby
from .common.grid import Array
from .constants import FilmConstants
from .solvers.blocks import Factors
from .solvers.sparse import LinearSolver
from .state import Fields, Inputs, Memory, Scalars
from .step import balance_of, begin, end, sheared_of


class NearbyStep(NamedTuple):
    """End of a step next to a solved one."""

    memory: Memory
    fields: Fields
    scalars: Scalars


@compilable
def advance(
    fixed: FilmConstants,
    memory: Memory,
    inputs: Inputs,
    base: SolvedBalance,
    solver: LinearSolver | Factors,
    faults: Array,
) -> NearbyStep:
    """Return the end of a step of a film without a coating, next to a solved step.

    Parameters
    ----------
    fixed, memory, inputs : FilmConstants, Memory, Inputs
        Of this step, which may all differ from those of the solved one.
    base : SolvedBalance
    solver : sparse.LinearSolver or blocks.Factors
        With the factorisation of the solved step.
    faults : ndarray
        As in `step.begin` and `step.end`.
    """
    begun = begin(fixed, memory, inputs, faults)
    flow = flow_film(inputs.hard_film, sheared_of(inputs), fixed.laws)
    film = solve_nearby(balance_of(flow, begun), fixed.domain, base, solver)
    solved = StepSolution(memory.film.deflection, flow, film, 1)
    ended = end(fixed, memory, inputs, begun, solved, faults)
    return NearbyStep(ended.memory, ended.fields, ended.scalars)
