"""The film of a step under a coating that deflects by the pressure, by Newton's method.

The equations are those of `coating`. As in `film_step`, Python interprets it with a sparse solver.
With dense blocks, and in a native FMU, it is one kernel.
"""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable, compiled
from ..common.faults import FAULT, refuse
from ..common.grid import Array, Entrainment, put
from ..laws import cavitation, coating
from ..laws.asperity import ContactConstants
from ..laws.coating import Softness
from ..laws.contact import contact
from ..laws.piezoviscosity import PressureLaw, true_pressure
from ..solvers.blocks import Factors
from ..solvers.sparse import LinearSolver
from . import film_step
from .film_step import (
    BalanceInputs,
    Domain,
    FilmSolution,
    FullCells,
    balance_pressure,
    face_lift,
    film_slopes,
)
from .flow_film import FilmLaws, FlowFilm, ShearedOil, flow_film
from .flows import Filling
from .tangent import BY_FILM


class Layer(NamedTuple):
    """A coating, and the constants of the film on it.

    compliance : c [m/Pa]; contact : asperity.ContactConstants; laws : flow_film.FilmLaws;
    pressure : piezoviscosity.PressureLaw; share : entrainment velocity in the frame of the grid to
    the sliding velocity [-].
    """

    compliance: float
    contact: ContactConstants
    laws: FilmLaws
    pressure: PressureLaw
    share: float


class CoatedInputs(NamedTuple):
    """Beginning of a step under a coating.

    hard_film, deflection, unknown : ndarray, shape (n_c, n_a), film thickness without the
    deflection at the end of the step, deflection and signed unknown at its beginning;
    steps : ndarray, shape (2, n_c, n_a), `contact.profile_steps`;
    sheared : flow_film.ShearedOil, at its end.
    """

    hard_film: Array
    deflection: Array
    unknown: Array
    steps: Array
    sheared: ShearedOil


class StepSolution(NamedTuple):
    """Film of a step.

    deflection of a coating [m]; flow : flow_film.FlowFilm; solution : film_step.FilmSolution;
    iterations : number of factorisations.
    """

    deflection: Array
    flow: FlowFilm
    solution: FilmSolution
    iterations: int


@compiled
def softness(
    pressed: CoatedInputs,
    deflection: Array,
    layer: Layer,
    inputs: BalanceInputs,
    flow: FlowFilm,
    filling: Filling,
    reduced: Array,
    domain: Domain,
):
    """Return the `coating.Softness` about a film.

    Parameters
    ----------
    pressed : CoatedInputs
    deflection : ndarray, shape (n_c, n_a)
        Deflection of the coating for this film [m].
    layer : Layer
    inputs : film_step.BalanceInputs
        Whatever its film.
    flow : flow_film.FlowFilm
    filling : flows.Filling
        Filling in which the balance is solved.
    reduced : ndarray, shape (n_c, n_a)
        Reduced pressure that presses on the coating [Pa].
    domain : film_step.Domain
    """
    slopes = film_slopes(
        flow.quantities,
        flow.slopes,
        inputs.entrainment,
        Entrainment(np.zeros(deflection.shape), np.full(deflection.shape, layer.share)),
        filling,
        inputs.edges,
        inputs.start.length,
        domain,
    )
    touching = contact(
        pressed.hard_film,
        deflection,
        pressed.steps,
        domain.open_cells,
        layer.contact,
        domain.cells,
    )
    under = true_pressure(layer.pressure, reduced)
    weight, offset = coating.linear_deflection(
        layer.compliance, deflection, touching, under, reduced, domain.open_cells
    )
    return Softness(slopes[BY_FILM], weight, offset)


@compilable
def balanced(
    deflection: Array,
    flow: FlowFilm,
    last: BalanceInputs,
    iterate: FilmSolution,
    factorisations: int,
    domain: Domain,
    solver: LinearSolver | Factors,
) -> StepSolution:
    """Return the film of a step with the flows under its last deflection.

    Parameters
    ----------
    deflection : ndarray, shape (n_c, n_a)
        [m].
    flow : flow_film.FlowFilm
        Under this deflection.
    last : film_step.BalanceInputs
        Inputs of the last iteration.
    iterate : film_step.FilmSolution
        Solution of the last iteration.
    factorisations : int
    domain : film_step.Domain
    solver : sparse.LinearSolver or blocks.Factors
        With the factorisation of `iterate`.

    Returns
    -------
    StepSolution
    """
    now = BalanceInputs(
        film=flow.quantities,
        entrainment=last.entrainment,
        edges=last.edges,
        start=last.start,
        full=last.full,
        softness=last.softness,
        lift=last.lift,
    )
    equations = film_step.equations_of(now, domain)
    put(equations.lift.axial, iterate.lift.axial)
    put(equations.lift.around, iterate.lift.around)
    cells = FullCells(iterate.unknown, iterate.full, factorisations, iterate.stencil)
    solution = film_step.completed(cells, equations, solver, True)
    return StepSolution(deflection, flow, solution, factorisations)


@compilable
def solve(
    pressed: CoatedInputs,
    layer: Layer,
    inputs: BalanceInputs,
    domain: Domain,
    solver: LinearSolver | Factors,
    faults: Array,
) -> StepSolution:
    """Return the film of a step; note a fault if there is none.

    Parameters
    ----------
    pressed : CoatedInputs
    layer : Layer
    inputs : film_step.BalanceInputs
        Whatever its film and softness.
    domain : film_step.Domain
    solver : sparse.LinearSolver or blocks.Factors
    faults : ndarray
        As in `film_step.solve`; a deflection that is not found, with the last change and its cell.

    Returns
    -------
    StepSolution
    """
    hard_film, deflection, unknown, _, sheared = pressed
    full = unknown > 0.0
    guess = inputs.full
    lift = face_lift(inputs.lift, inputs.entrainment, domain)
    factorisations = 0
    iteration = 0
    while True:
        film = hard_film + deflection  # Eq. (L2)
        flow = flow_film(film, sheared, layer.laws)
        reduced, deficit = cavitation.interpret(domain.model, unknown, full, domain.open_cells)
        filling = Filling(balance_pressure(domain.model, unknown, reduced), 1.0 + deficit, lift)
        soft = softness(pressed, deflection, layer, inputs, flow, filling, reduced, domain)
        now = BalanceInputs(
            film=flow.quantities,
            entrainment=inputs.entrainment,
            edges=inputs.edges,
            start=inputs.start,
            full=guess,
            softness=soft,
            lift=inputs.lift,
        )
        solution = film_step.solve(now, domain, solver, faults)
        factorisations += solution.iterations
        iteration += 1
        above = np.maximum(film, layer.laws.minimum_flow_film)
        moved = coating.yielded(deflection, soft, solution.pressure, above)
        if moved.converged or iteration == coating.LIMIT or faults[0] > 0.0:
            if faults[0] == 0.0 and not moved.converged:
                most = float(coating.LIMIT)
                refuse(
                    faults, FAULT.deflection_not_found, moved.i, moved.j, most, moved.change, 0.0
                )
            ended = flow_film(hard_film + moved.deflection, sheared, layer.laws)
            return balanced(moved.deflection, ended, now, solution, factorisations, domain, solver)
        deflection = moved.deflection
        unknown = solution.unknown
        full = solution.full
        guess = solution.full
