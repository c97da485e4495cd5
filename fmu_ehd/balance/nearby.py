"""Film of a step next to a solved one, for the derivative of the step.

Eq. (T30):  u = u_0 + M^-1 r(u_0)

r is the residual of the balance, Eq. (E1), of a step whose state, inputs or parameters differ from
those of the solved step with the unknown u_0 and the matrix M. The pattern of full cells is that of
the solved step. The error is of second order in the differences. Half of the difference of two such
steps, with opposite differences, is therefore the derivative of the unknown to third order.

The lift of the film fraction follows the state, but remains 0 in rows in which the solved step has
none.
"""

from typing import NamedTuple

from ...master.fmi.compiled import compilable, compiled
from ..common.grid import OPENINGS, Array, Flags
from ..solvers.blocks import Factors
from ..solvers.sparse import LinearSolver
from .film_step import (
    BalanceInputs,
    Domain,
    Equations,
    FilmSolution,
    FullCells,
    balance,
    equations_of,
    solutions,
    solved,
)
from .flows import FaceLift


class SolvedBalance(NamedTuple):
    """Balance of a solved step.

    unknown, full, stencil : as in `film_step.FilmSolution`; lift : flows.FaceLift.
    """

    unknown: Array
    full: Flags
    stencil: Array
    lift: FaceLift


@compiled
def hold_lift(lift: FaceLift, solved: FaceLift):
    """Remove the lift from the rows in which the solved step has none, in place.

    These include the rows in which it was given up (`flows.give_up_lift`).
    """
    for i in range(lift.axial.shape[0]):
        if not solved.axial[i].any():
            lift.axial[i] = 0.0
    for j in range(lift.around.shape[1]):
        if not solved.around[:, j].any():
            lift.around[:, j] = 0.0


@compiled
def with_supply(unknown: Array, equations: Equations):
    """Return the unknown with the supply of the openings."""
    out = unknown.copy()
    edges, domain = equations.edges, equations.domain
    if domain.has_openings:
        supply = edges.film_fraction[OPENINGS]
        held = edges.pressure[OPENINGS] if supply >= 1.0 else supply - 1.0
        for i in range(out.shape[0]):
            for j in range(out.shape[1]):
                if domain.open_cells[i, j]:
                    out[i, j] = held
    return out


@compilable
def solve_nearby(
    given: BalanceInputs, domain: Domain, base: SolvedBalance, solver: LinearSolver | Factors
) -> FilmSolution:
    """Return the film of a step next to a solved one, Eq. (T30).

    Parameters
    ----------
    given : BalanceInputs
    domain : Domain
    base : SolvedBalance
    solver : sparse.LinearSolver or blocks.Factors
        With the factorisation of the solved step.

    Returns
    -------
    FilmSolution
    """
    equations = equations_of(given, domain)
    hold_lift(equations.lift, base.lift)
    first = with_supply(base.unknown, equations)
    _, now = balance(first, base.full, equations)
    right = now.residual.reshape((1, *now.residual.shape))
    unknown = first + solutions(solver, base.stencil, right)[0]  # Eq. (T30)
    pressure, now = balance(unknown, base.full, equations)
    cells = FullCells(unknown, base.full, 1, base.stencil)
    return solved(cells, pressure, now, equations)
