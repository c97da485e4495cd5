"""One time step of the film: balance, cavitation, linear solver and tangent.

Python runs it as written with a sparse solver; with dense blocks, and in a native FMU, it is one
kernel.
"""

from typing import Any, NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable, compiled, standing_for
from ..common.faults import FAULT, refuse
from ..common.grid import (
    FIRST,
    LAST,
    OPENINGS,
    Array,
    Cells,
    Edges,
    Entrainment,
    Flags,
    axial_face_velocity,
    face_velocity_around,
)
from ..common.quantities import STORED, FilmSlopes
from ..laws import cavitation
from ..laws.cavitation import Cavitation
from ..laws.coating import Softness, soften
from ..solvers.blocks import (
    BlockTridiagonal,
    Factors,
    factorise_changed,
    substitute,
    substitute_one,
)
from ..solvers.sparse import LinearSolver
from . import flows, openings, reynolds, tangent
from .flows import FaceLift, Faces, Filling
from .reynolds import Storage
from .storage import EulerStep
from .transport import Lift

REFINE_ABOVE = 2e-13  # mass imbalance above which the solution is refined once
EVEN = 1e-9  # differences over the highest pressure up to which they may be round-off
HARD = Softness(np.zeros((0, 0, 0)), np.zeros((0, 0)), np.zeros((0, 0)))
NO_LIFT = Lift(np.zeros((0, 0)), np.zeros((0, 0)))


class Domain(NamedTuple):
    """Constants of a film during a run.

    cells : grid.Cells; open_cells : ndarray of bool, shape (n_c, n_a), cells without a film;
    has_openings : whether there are any; model : cavitation.Cavitation;
    together : iterations in which all cells switch together, `cavitation.at_once`;
    bearing : whether sliding carries the oil around, and not along the axis;
    is_lifted : whether the film fraction has a lift, `transport`.
    """

    cells: Cells
    open_cells: Flags
    has_openings: bool
    model: Cavitation
    together: int
    bearing: bool
    is_lifted: bool


class BalanceInputs(NamedTuple):
    """Inputs of a step of the balance.

    film : ndarray, shape (6, n_c, n_a), quantities of `films` at its end;
    entrainment : grid.Entrainment, at its end [m/s]; edges : grid.Edges, at its end;
    start : storage.EulerStep, content that it starts from, and its length;
    full : ndarray of bool, shape (n_c, n_a), guess of the full cells;
    softness : coating.Softness, `HARD` without a coating;
    lift : transport.Lift, of the film fraction, `NO_LIFT` for none.
    """

    film: Array
    entrainment: Entrainment
    edges: Edges
    start: EulerStep
    full: Flags
    softness: Softness
    lift: Lift


class Equations(NamedTuple):
    """Eqs. (E1) to (E5) of one step, for any pattern of full cells.

    lift : flows.FaceLift;
    follows_pattern : whether they depend on the pattern of full cells: in every model that
    switches, and under a coating, which follows no pressure that is cut off.
    """

    faces: Faces
    lift: FaceLift
    storage: Storage
    edges: Edges
    softness: Softness
    domain: Domain
    follows_pattern: bool


class FullCells(NamedTuple):
    """Signed unknown and full cells of one step.

    unknown : ndarray, shape (n_c, n_a), u: pressure [Pa] in full cells, film_fraction - 1 [-]
    elsewhere; that of Eq. (C6) [Pa] with a rounding;
    full : ndarray of bool, shape (n_c, n_a);
    iterations : number of factorisations;
    stencil : ndarray, shape (5, n_c, n_a), that was factorised last.
    """

    unknown: Array
    full: Flags
    iterations: int
    stencil: Array


class FilmSolution(NamedTuple):
    """Film at the end of a step.

    unknown, pressure, film_fraction, content : ndarray, shape (n_c, n_a), signed unknown u,
    pressure above cavitation pressure [Pa], film fraction [-], content f s [m];
    full : ndarray of bool, shape (n_c, n_a), True where the film is full;
    axial_flow : ndarray, shape (n_c, n_a + 1), flow through the axial faces, positive with
    ascending j [m3/s]; flow_around : ndarray, shape (n_c + 1, n_a), through those across i;
    edge_flow : ndarray, shape (4,), flow into the film over lower, upper, first, last edge [m3/s];
    from_openings : flow into the film from all openings, or over both ends of a sector [m3/s];
    spilled : ndarray, shape (n_c, n_a), `openings.spilled`; without openings of shape (0, 0);
    mass_imbalance : |inflow - growth| / throughput [-], rates at the end of the step, growth by Eq.
    (T1); throughput = edge flows + growth, at least 0.1 % of the film volume a step;
    iterations : number of factorisations;
    lift : flows.FaceLift;
    stencil : ndarray, shape (5, n_c, n_a), that was factorised last.
    """

    unknown: Array
    pressure: Array
    film_fraction: Array
    content: Array
    full: Flags
    axial_flow: Array
    flow_around: Array
    edge_flow: Array
    from_openings: float
    spilled: Array
    mass_imbalance: float
    iterations: int
    lift: FaceLift
    stencil: Array


# ---- linear solver: dense blocks in kernels, any solver in Python


@standing_for(factorise_changed)
def factorise(solver: LinearSolver | Factors, stencil: Array, lowest: int, highest: int) -> None:
    """Factorise a stencil whose columns changed from station `lowest` to `highest`."""
    if isinstance(solver, Factors):
        factorise_changed(solver, stencil, lowest, highest)
    else:
        solver.factorise(stencil, (lowest, highest))


@standing_for(substitute_one)
def solution(solver: LinearSolver | Factors, stencil: Array, right: Array) -> Array:
    """Return the solution for a right-hand side, shape (n_c, n_a), which may be overwritten."""
    if isinstance(solver, Factors):
        return substitute_one(solver, stencil, right)
    return solver.solve(right[None])[0]


@compiled
def _solutions(factors, stencil, right):
    substitute(factors, stencil, factors.direction[0] > 0.0, right)
    return right


@standing_for(_solutions)
def solutions(solver: LinearSolver | Factors, stencil: Array, right: Array) -> Array:
    """Solve for right-hand sides of shape (m, n_c, n_a), with the last stencil factorised."""
    if isinstance(solver, Factors):
        return _solutions(solver, stencil, right)
    if isinstance(solver, BlockTridiagonal):
        solver.stencil = stencil
    return solver.solve(right)


# ---- a step


@compiled
def assemble(equations: Equations, pattern: Flags):
    """Return five-point matrix and right-hand side, as `reynolds.assemble`.

    `pattern`, shape (n_c, n_a) : whether each cell is full.
    """
    faces, lift, storage, edges, softness, domain, _ = equations
    model = domain.model
    full = pattern
    if not model.conserving:
        full = np.full(pattern.shape, True)
    stencil, right = reynolds.assemble(full, faces, lift, storage, edges, domain.cells)
    if model.switching and not model.conserving:
        cavitation.without_pressure(pattern, stencil)
    if softness.weight.size > 0:
        soften(pattern, softness, stencil, right)
    if domain.has_openings:
        supply = edges.film_fraction[OPENINGS]
        held = edges.pressure[OPENINGS] if supply >= 1.0 else supply - 1.0
        reynolds.hold(domain.open_cells, held, stencil, right)
    return stencil, right


@compilable
def full_cells(
    equations: Equations, solver: LinearSolver | Factors, full: Flags, faults: Array
) -> FullCells:
    """Return the pattern of full cells and the signed unknown of one step, Eq. (C1).

    Parameters
    ----------
    equations : Equations
    solver : sparse.LinearSolver or blocks.Factors
        Left with the factorisation of the last pattern.
    full : ndarray of bool, shape (n_c, n_a)
        First guess.
    faults : ndarray
        `faults.refuse`: a solution that is not finite; a pattern that is not found, with the number
        of cells that still switch and the first of them.

    Returns
    -------
    FullCells
    """
    domain = equations.domain
    model = domain.model
    lowest = 0
    highest = full.shape[1] - 1
    iteration = 0
    while True:
        stencil, right = assemble(equations, full)
        factorise(solver, stencil, lowest, highest)
        unknown = solution(solver, stencil, right)
        singly = iteration >= domain.together
        pattern_change = cavitation.switch(
            full, unknown, domain.open_cells, model.conserving, singly
        )
        iteration += 1
        if pattern_change.switched < 0:
            refuse(faults, FAULT.not_finite, pattern_change.i, pattern_change.j, 0.0, 0.0, 0.0)
        elif (
            pattern_change.switched > 0
            and equations.follows_pattern
            and iteration == cavitation.LIMIT
        ):
            u = unknown[pattern_change.i, pattern_change.j]
            most = float(cavitation.LIMIT)
            refuse(
                faults,
                FAULT.still_switching,
                pattern_change.i,
                pattern_change.j,
                most,
                float(pattern_change.switched),
                u,
            )
        if (
            pattern_change.switched <= 0 or not equations.follows_pattern or faults[0] > 0.0
        ):  # Eq. (C1)
            return FullCells(unknown, full, iteration, stencil)
        lowest = pattern_change.lowest
        highest = pattern_change.highest
        full = pattern_change.pattern


@compiled
def newton_matrix(equations: Equations, unknown: Array, full: Flags):
    """Return the derivative of the balance, Eq. (E1), to the unknown of Eq. (C6)."""
    faces, lift, storage, edges, _, domain, _ = equations
    of_pressure, of_fraction = cavitation.shares(domain.model, unknown, full)
    everywhere = np.full(full.shape, True)
    stencil, _ = reynolds.assemble(everywhere, faces, lift, storage, edges, domain.cells)
    by_fraction, right = reynolds.assemble(~everywhere, faces, lift, storage, edges, domain.cells)
    cavitation.add_weighted(stencil, of_pressure, by_fraction, of_fraction)
    if domain.has_openings:
        reynolds.hold(domain.open_cells, 0.0, stencil, right)
    return stencil


@compilable
def rounded_cells(
    sharp: FullCells, equations: Equations, solver: LinearSolver | Factors, faults: Array
) -> FullCells:
    """Return the unknown of one step by Newton's method, Eq. (C6).

    Parameters
    ----------
    sharp : FullCells
        Solution of Eq. (C1).
    equations : Equations
    solver : sparse.LinearSolver or blocks.Factors
        Left with the factorisation of the solution.
    faults : ndarray
        `faults.refuse`: no solution, with the last change of the derivatives and its cell.

    Returns
    -------
    FullCells
    """
    domain = equations.domain
    rounding = domain.model.rounding
    full = sharp.full
    unknown = cavitation.rounding_start(sharp.unknown, full, domain.open_cells)
    iteration = 0
    while True:
        _, now = balance(unknown, full, equations)
        stencil = newton_matrix(equations, unknown, full)
        factorise(solver, stencil, 0, full.shape[1] - 1)
        change = solution(solver, stencil, now.residual)
        bend, i, j = cavitation.unsettled(rounding, unknown, change, domain.open_cells)
        unknown = unknown + change
        iteration += 1
        if bend <= cavitation.SETTLED:
            break
        if iteration == cavitation.MOST_ROUNDED or not np.isfinite(bend):
            refuse(faults, FAULT.rounding_not_found, i, j, float(iteration), bend, 0.0)
            break
    full = (full & domain.open_cells) | ((unknown > 0.0) & ~domain.open_cells)
    return FullCells(unknown, full, sharp.iterations + iteration, stencil)


@compiled
def sliding_velocity(entrainment: Entrainment, domain: Domain):
    """Return the entrainment velocity at the faces that sliding carries the oil through [m/s].

    Their shape is (n_c, n_a + 1), of a bearing (n_c + 1, n_a).
    """
    if domain.bearing:
        return face_velocity_around(
            entrainment.circumferential, domain.open_cells, domain.cells.ring
        )
    return axial_face_velocity(entrainment.axial, domain.open_cells)


@compiled
def face_lift(lift: Lift, entrainment: Entrainment, domain: Domain):
    """Return `flows.FaceLift` for the velocity at the end of a step.

    It is 0 where oil does not go on in the direction that the lift holds for, and if cavities hold
    no oil.
    """
    at_end = flows.no_lift(domain.open_cells.shape)
    if lift.fraction.size > 0 and domain.model.conserving:
        velocity = sliding_velocity(entrainment, domain)
        at_faces = at_end.around if domain.bearing else at_end.axial
        for i in range(velocity.shape[0]):
            for j in range(velocity.shape[1]):
                if velocity[i, j] * lift.travel[i, j] > 0.0:
                    at_faces[i, j] = lift.fraction[i, j]
    return at_end


@compiled
def balance(unknown: Array, full: Flags, equations: Equations):
    """Return the pressure and the result of `reynolds.balance` for a signed unknown."""
    faces, lift, storage, edges, _, domain, _ = equations
    pressure, deficit = cavitation.interpret(domain.model, unknown, full, domain.open_cells)
    return pressure, reynolds.balance(
        pressure, deficit, faces, lift, storage, edges, domain.open_cells, domain.cells
    )


@compiled
def equations_of(given: BalanceInputs, domain: Domain):
    """Return the equations of a step."""
    film = given.film
    if domain.has_openings:
        film = openings.with_free_openings(domain.open_cells, film)
    faces = reynolds.faces(film, given.entrainment, domain.open_cells, domain.cells)
    if domain.has_openings:
        openings.close_faces(domain.open_cells, faces)
        openings.limit_supply(domain.open_cells, faces, given.edges.limit)
    lift = face_lift(given.lift, given.entrainment, domain)
    rate = domain.cells.dx * domain.cells.dy / given.start.length
    held = Storage(film[STORED], given.start.content, rate)
    model = domain.model
    follows = model.switching or (model.clipping and given.softness.weight.size > 0)
    return Equations(
        faces=faces,
        lift=lift,
        storage=held,
        edges=given.edges,
        softness=given.softness,
        domain=domain,
        follows_pattern=follows,
    )


@compiled
def first_guess(full: Flags, equations: Equations):
    """Return the first pattern: all cells if none ever switches, openings by their supply."""
    _, _, _, edges, _, domain, follows_pattern = equations
    guess = full.copy()
    for i in range(full.shape[0]):
        for j in range(full.shape[1]):
            if domain.open_cells[i, j]:
                guess[i, j] = edges.film_fraction[OPENINGS] >= 1.0
            if not follows_pattern:
                guess[i, j] = True
    return guess


@compiled
def solved(cells: FullCells, pressure: Array, balance: reynolds.Balance, equations: Equations):
    """Return the `FilmSolution` with its flows."""
    domain = equations.domain
    spilled = np.zeros((0, 0))
    from_openings = 0.0
    if not (domain.cells.ring or domain.cells.mirrored):
        from_openings = balance.edge_flow[FIRST] + balance.edge_flow[LAST]
    elif domain.has_openings:
        spilled = openings.flow_into_openings(domain.open_cells, balance.flow_around)
        from_openings = openings.flow_from_openings(domain.open_cells, balance.axial_flow, spilled)
    return FilmSolution(
        unknown=cells.unknown,
        pressure=pressure,
        film_fraction=balance.film_fraction,
        content=balance.content,
        full=cells.full,
        axial_flow=balance.axial_flow,
        flow_around=balance.flow_around,
        edge_flow=balance.edge_flow,
        from_openings=from_openings,
        spilled=spilled,
        mass_imbalance=balance.imbalance,
        iterations=cells.iterations,
        lift=equations.lift,
        stencil=cells.stencil,
    )


@compilable
def solve(
    given: BalanceInputs, domain: Domain, solver: LinearSolver | Factors, faults: Array
) -> FilmSolution:
    """Solve Eqs. (E1)-(E5) for one step; a fault is noted where there is no solution.

    Parameters
    ----------
    given : BalanceInputs
    domain : Domain
    solver : sparse.LinearSolver or blocks.Factors
    faults : ndarray
        As in `full_cells`.

    Returns
    -------
    FilmSolution
    """
    equations = equations_of(given, domain)
    solution = full_cells(equations, solver, first_guess(given.full, equations), faults)
    iterations = solution.iterations
    while faults[0] == 0.0 and flows.give_up_lift(equations.lift, solution.unknown, solution.full):
        solution = full_cells(equations, solver, solution.full, faults)
        iterations += solution.iterations
    whole = FullCells(solution.unknown, solution.full, iterations, solution.stencil)
    if domain.model.rounding > 0.0 and faults[0] == 0.0:
        whole = rounded_cells(whole, equations, solver, faults)
    return completed(whole, equations, solver, given.softness.weight.size == 0)


@compilable
def completed(
    cells: FullCells, equations: Equations, solver: LinearSolver | Factors, refines: bool
) -> FilmSolution:
    """Return the film of an unknown, refined once if its round-off matters.

    It matters if oil is conserved, and under a uniform pressure, because its differences cause
    friction. If pressures are cut off, the residual is larger than round-off.

    Parameters
    ----------
    cells : FullCells
    equations : Equations
    solver : sparse.LinearSolver or blocks.Factors
        With the factorisation of `cells`.
    refines : bool
        False for an iteration of a coating, which does not balance yet.

    Returns
    -------
    FilmSolution
    """
    unknown = cells.unknown
    pressure, now = balance(unknown, cells.full, equations)
    conserving = equations.domain.model.conserving
    lost = conserving and now.imbalance > REFINE_ABOVE
    highest = pressure.max()
    even = highest > 0.0 and highest - pressure.min() <= EVEN * highest
    if refines and (lost or (even and (conserving or (pressure == unknown).all()))):
        unknown = unknown + solution(solver, cells.stencil, now.residual)
        pressure, now = balance(unknown, cells.full, equations)
    whole = FullCells(unknown, cells.full, cells.iterations, cells.stencil)
    return solved(whole, pressure, now, equations)


def run(way: Any, *arguments: Any) -> Any:
    """Call `way`, whose last two arguments are a solver and faults.

    With dense blocks it is one kernel.
    """
    *given, solver, faults = arguments
    if type(solver) is BlockTridiagonal:
        return way.dispatcher(*given, solver.factors, faults)
    return way(*arguments)


# ---- tangent


@compilable
def balance_pressure(model: Cavitation, unknown: Array, pressure: Array) -> Array:
    """Return the pressure with which a balance is solved [Pa], before it is cut off, Eq. (C4)."""
    return unknown if model.clipping else pressure


@compilable
def solved_filling(film: FilmSolution, model: Cavitation) -> Filling:
    """Return the filling with which the balance of a step was solved."""
    pressure = balance_pressure(model, film.unknown, film.pressure)
    return Filling(pressure, film.film_fraction, film.lift)


@compiled
def film_slopes(
    film: Array,
    slopes: FilmSlopes,
    entrainment: Entrainment,
    dentrainment: Entrainment,
    filling: Filling,
    edges: Edges,
    length: float,
    domain: Domain,
):
    """Return the derivative of the film balance to film thickness and sliding velocity.

    It is that of `tangent.linearise`.

    Parameters
    ----------
    film : ndarray, shape (6, n_c, n_a)
        Quantities of `films`.
    slopes : quantities.FilmSlopes
    entrainment, dentrainment : grid.Entrainment
        [m/s], and derivatives to the sliding velocity [-].
    filling : reynolds.Filling
    edges : grid.Edges
    length : float
        H_e [s].
    domain : Domain

    Returns
    -------
    ndarray, shape (2, 5, n_c, n_a)
    """
    cells = domain.cells
    lift = filling.lift
    if domain.has_openings:
        film = openings.with_free_openings(domain.open_cells, film)
        faces = reynolds.faces(film, entrainment, domain.open_cells, cells)
        bounded = openings.limit_supply(domain.open_cells, faces, edges.limit)
        axial = lift.axial.copy()
        for i in range(axial.shape[0]):
            for j in range(axial.shape[1]):
                if bounded[i, j]:
                    axial[i, j] = -1.0  # a given inflow follows neither film nor velocity
        lift = FaceLift(axial, lift.around)
    stencil = tangent.linearise(
        film,
        slopes,
        (entrainment, dentrainment),
        Filling(filling.pressure, filling.film_fraction, lift),
        edges,
        domain.open_cells,
        cells,
        cells.dx * cells.dy / length,
    )
    for m in range(2):
        for k in range(5):
            for i in range(domain.open_cells.shape[0]):
                for j in range(domain.open_cells.shape[1]):
                    if domain.open_cells[i, j]:
                        stencil[m, k, i, j] = 0.0
    return stencil
