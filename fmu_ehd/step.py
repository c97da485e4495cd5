"""Step of a film, one source for Python and machine code.

Python runs it (`model`), and a native FMU compiles it (`native`).

A step is `begin`, `solve` and `end`. The caller checks the faults that each has noted. Its
derivatives are in `step_tangent`. Only this file and `constants` know whether the film is that of a
skirt or of a bearing, and whether there is oil on the bore.
"""

from typing import NamedTuple

import numpy as np

from ..master.fmi.compiled import compilable, standing_for
from ..master.fmi.noted import remark
from . import oil_rows
from . import step_parts as parts
from .balance import coated_film, film_step, oil_layer
from .balance.coated_film import CoatedInputs, Layer, StepSolution
from .balance.film_step import (
    BalanceInputs,
    Domain,
    FilmSolution,
    solved_filling,
)
from .balance.flow_film import FlowFilm, ShearedOil, flow_film
from .balance.oil_layer import LayerVolumes, OilLayer
from .balance.transport import Lift
from .common.faults import FAULT
from .common.grid import LOWER, UPPER, Array, Edges, Entrainment, sum_of_products
from .common.quantities import STORED
from .constants import FilmConstants
from .laws import circumferential
from .laws.circumferential import CircumferentialInputs
from .laws.coating import Softness
from .laws.contact import has_narrow_steps, profile_steps
from .laws.friction import FrictionPowers
from .laws.piezoviscosity import (
    PRESSURE_VISCOSITY_LAWS,
    TruePressure,
    check_suction,
    raised,
    true_pressure,
)
from .solvers.blocks import Factors
from .solvers.sparse import LinearSolver
from .state import Fields, Inputs, LastStep, Memory, Scalars


class StepStart(NamedTuple):
    """Data from which a step starts.

    begin : step_parts.EulerStart; covered : oil_layer.OilLayer, after the motion of the skirt;
    edges : grid.Edges; lift : transport.Lift;
    entrainment : grid.Entrainment, at the end of the step [m/s].
    """

    begin: parts.EulerStart
    covered: OilLayer
    edges: Edges
    lift: Lift
    entrainment: Entrainment


class ForceInputs(NamedTuple):
    """Data of a film for its forces.

    Deflection [m], steps of `Memory`, flow_film.FlowFilm, piezoviscosity.TruePressure, film
    fraction [-].
    """

    deflection: Array
    steps: Array
    flow: FlowFilm
    under: TruePressure
    fraction: Array


class SurfaceForces(NamedTuple):
    """Forces of a film along and around its axis [N], (n_c, n_a), 0 on a skirt, and powers."""

    along: parts.Forces
    around: Array
    powers: FrictionPowers


class StepResult(NamedTuple):
    """Result of a step; iterations : number of factorisations."""

    memory: Memory
    fields: Fields
    scalars: Scalars
    last: LastStep
    iterations: int


# ---- solvers: dense blocks in kernels, any solver in Python


@standing_for(film_step.solve)
def solve_bare(
    inputs: BalanceInputs, domain: Domain, solver: LinearSolver | Factors, faults: Array
) -> FilmSolution:
    """Film of hard surfaces."""
    return film_step.run(film_step.solve, inputs, domain, solver, faults)


@standing_for(coated_film.solve)
def solve_coated(
    pressed: CoatedInputs,
    layer: Layer,
    inputs: BalanceInputs,
    domain: Domain,
    solver: LinearSolver | Factors,
    faults: Array,
) -> StepSolution:
    """Film under a coating that yields to the pressure."""
    return film_step.run(coated_film.solve, pressed, layer, inputs, domain, solver, faults)


# ---- forces


@compilable
def sheared_of(inputs: Inputs) -> ShearedOil:
    """Oil that is sheared."""
    around = inputs.around
    return ShearedOil(inputs.velocity, inputs.turning, around.viscosity, around.temperature)


@compilable
def turning_of(fixed: FilmConstants, inputs: Inputs) -> CircumferentialInputs:
    """Return the inputs of shear around the circumference."""
    cells = fixed.domain.cells
    return CircumferentialInputs(
        inputs.turning, inputs.around.outside.opening, cells.dx, cells.ring
    )


@compilable
def acting_of(
    fixed: FilmConstants, inputs: Inputs, forces: ForceInputs, faults: Array
) -> SurfaceForces:
    """Return the forces of a solved film; note a fault if they are not finite."""
    outside = inputs.around.outside
    film = parts.SolvedFilm(
        hard_film=inputs.hard_film,
        deflection=forces.deflection,
        steps=forces.steps,
        velocity=inputs.velocity,
        turning=inputs.turning,
        quantities=raised(forces.flow.quantities, forces.under.ratio),
        pressure=forces.under.pressure,
        fraction=forces.fraction,
        lower=outside.lower,
        upper=outside.upper,
    )
    acted = parts.forces(film, fixed.surfaces, fixed.domain, faults)
    powers = FrictionPowers(acted.summary.power, acted.boundary_power)
    if not fixed.domain.bearing:
        return SurfaceForces(acted, inputs.turning, powers)
    turning = turning_of(fixed, inputs)
    around = circumferential.shear_forces(acted.shear, turning)
    thickness = inputs.hard_film + forces.deflection  # Eq. (L2)
    above = np.maximum(thickness, fixed.laws.minimum_flow_film)
    powers = circumferential.powers(powers, acted.shear, around, turning, above)
    return SurfaceForces(acted, around.viscous + around.boundary, powers)


@compilable
def fields_of(acting: SurfaceForces, fraction: Array) -> Fields:
    """Return the outputs of each cell."""
    acted = acting.along
    return Fields(
        nodal_pressure_force=acted.pressure,
        nodal_friction_force=acted.friction,
        pressure=acted.absolute,
        asperity_pressure=acted.contact.pressure,
        film_fraction=fraction,
        nodal_circumferential_force=acting.around,
    )


@compilable
def scalars_of(
    fixed: FilmConstants, acting: SurfaceForces, ledger: parts.BalanceScalars, layer: OilLayer
) -> Scalars:
    """Return the scalar outputs."""
    whole = acting.along.summary
    lower, upper, openings = ledger.flows
    on_bore = oil_layer.volume(fixed.bore, layer) if fixed.bore.supply.followed else 0.0
    torque = 0.0
    if fixed.domain.bearing:
        torque = fixed.radius * sum_of_products(acting.around, np.ones(acting.around.shape))
    return Scalars(
        minimum_film_thickness=min(whole.thinnest.thrust, whole.thinnest.anti_thrust),
        maximum_pressure=whole.highest,
        friction_force_hydrodynamic=whole.hydrodynamic,
        friction_force_asperity=whole.asperity,
        friction_power=acting.powers.friction,
        boundary_friction_share=ledger.boundary_share,
        minimum_film_thickness_thrust_side=whole.thinnest.thrust,
        radial_force_thrust_side=whole.radial.thrust,
        friction_force_thrust_side=whole.friction.thrust,
        minimum_film_thickness_anti_thrust_side=whole.thinnest.anti_thrust,
        radial_force_anti_thrust_side=whole.radial.anti_thrust,
        friction_force_anti_thrust_side=whole.friction.anti_thrust,
        flow_lower_edge=lower,
        flow_upper_edge=upper,
        stored_energy=acting.along.stored,
        received_power=ledger.received_power,
        flow_openings=openings,
        # the three terms of Eq. (T27)
        oil_in_film=ledger.oil_in_film,
        oil_on_bore=on_bore,
        oil_supplied=layer.supplied,
        mass_imbalance=ledger.imbalance,
        contact_area_fraction=whole.contact_area,
        friction_power_hydrodynamic=acting.powers.friction - acting.powers.boundary,
        friction_power_asperity=acting.powers.boundary,
        heat_generated=ledger.heat,
        outflow_upper_edge=ledger.outflow,
        friction_torque=torque,
    )


# ---- start


@compilable
def start(
    fixed: FilmConstants, inputs: Inputs, filled: float, faults: Array
) -> tuple[Memory, Fields, Scalars]:
    """Return state and outputs of a film at its start.

    The film is full, with the reduced pressure linear between the edges; or it is filled in part
    and has no pressure.

    Parameters
    ----------
    fixed : FilmConstants
    inputs : Inputs
        Its length unused.
    filled : float
        Film fraction [-].
    faults : ndarray
        `faults.refuse`: overlap, forces that are not finite; `faults.remark`: steps of one cell.
    """
    parts.check_film(inputs.hard_film, fixed.surfaces, faults)
    shape = inputs.hard_film.shape
    n_c, n_a = shape
    lower = inputs.around.edges.pressure[LOWER]
    upper = inputs.around.edges.pressure[UPPER]
    domain = fixed.domain
    flow = flow_film(inputs.hard_film, sheared_of(inputs), fixed.laws)
    film = flow.quantities
    pressure = np.zeros(shape)
    content = np.zeros(shape)
    for i in range(n_c):
        for j in range(n_a):
            if filled >= 1.0:
                pressure[i, j] = lower + (upper - lower) * ((j + 0.5) / n_a)
            if not domain.open_cells[i, j]:
                content[i, j] = filled * film[STORED, i, j]
    unknown = pressure if filled >= 1.0 else np.full(shape, filled - 1.0)
    fraction = np.full(shape, filled)
    still = np.zeros(shape)
    under = true_pressure(inputs.around.pressure_law, pressure)
    rms = fixed.surfaces.contact.roughness_rms
    steps = profile_steps(inputs.hard_film, domain.open_cells, rms, domain.cells)
    acting = acting_of(fixed, inputs, ForceInputs(still, steps, flow, under, fraction), faults)
    carriers = oil_rows.carriers(film, domain.bearing)
    no_flow = np.zeros((n_c + 1, n_a) if domain.bearing else (n_c, n_a + 1))
    before = parts.PreviousFilm(
        unknown=unknown,
        unknown_before=unknown,
        pressure=under.pressure,
        content=content,
        growth=still,
        growth_before=still,
        deflection=still,
        film=carriers,
        film_before=carriers,
        passed=no_flow,
        travel=no_flow,
        step=0.0,
    )
    layer = oil_layer.none_followed()
    if fixed.bore.supply.followed:
        layer = oil_layer.start(fixed.bore, inputs.velocity, domain.open_cells)
    oil = sum_of_products(content, fixed.surfaces.area)
    heat = acting.powers.friction
    ledger = parts.BalanceScalars(
        boundary_share=0.0,
        received_power=0.0,
        flows=(0.0, 0.0, 0.0),
        outflow=0.0,
        imbalance=0.0,
        oil_in_film=oil,
        heat=heat,
    )
    if has_narrow_steps(inputs.hard_film, domain.open_cells, rms, domain.cells):
        remark(faults, FAULT.narrow_steps)
    totals = parts.Totals(0.0, 0.0, acting.along.stored, acting.along.volume)
    parts.check_finite(before, totals, faults)
    scalars = scalars_of(fixed, acting, ledger, layer)
    return Memory(before, totals, layer, steps), fields_of(acting, fraction), scalars


# ---- a step


@compilable
def begin(fixed: FilmConstants, memory: Memory, inputs: Inputs, faults: Array) -> StepStart:
    """Return the data from which a step starts.

    A fault is noted if surfaces overlap too far, or if the skirt has gone too far.
    """
    parts.check_film(inputs.hard_film, fixed.surfaces, faults)
    before = memory.film
    layer = memory.layer
    around = inputs.around
    domain = fixed.domain
    begun = parts.begin(before, inputs.length, domain.cells)
    edges = around.edges
    if fixed.bore.supply.followed:
        bore = fixed.bore
        layer = oil_layer.covered(
            bore, layer, inputs.length, before.step, around.ring_layer, around.splash, faults
        )
        carried = oil_layer.inflow(bore, begun.pace.share * before.passed)
        limit = oil_layer.limit(bore, layer, carried, begun.start.length)
        edges = Edges(edges.pressure, edges.film_fraction, limit)
    lift = Lift(np.zeros((0, 0)), np.zeros((0, 0)))
    if domain.is_lifted:
        lift = oil_rows.lift(before, begun.pace, edges, inputs.length, domain)
    moved = Entrainment(fixed.share * inputs.turning, fixed.share * inputs.velocity)
    return StepStart(begun, layer, edges, lift, moved)


@compilable
def balance_of(flow: FlowFilm, begun: StepStart) -> BalanceInputs:
    """Return the inputs of the balance of a hard film."""
    nothing = np.zeros((0, 0))
    return BalanceInputs(
        film=flow.quantities,
        entrainment=begun.entrainment,
        edges=begun.edges,
        start=begun.begin.start,
        full=begun.begin.guess,
        softness=Softness(np.zeros((0, 0, 0)), nothing, nothing),
        lift=begun.lift,
    )


@compilable
def solve(
    fixed: FilmConstants,
    memory: Memory,
    inputs: Inputs,
    begun: StepStart,
    solver: LinearSolver | Factors,
    faults: Array,
) -> StepSolution:
    """Film of a step; a fault is noted where there is none, or where surfaces overlap too far."""
    before = memory.film
    sheared = sheared_of(inputs)
    flow = flow_film(inputs.hard_film, sheared, fixed.laws)
    balance_inputs = balance_of(flow, begun)
    surfaces = fixed.surfaces
    if surfaces.compliance > 0.0:
        law = inputs.around.pressure_law
        layer = Layer(surfaces.compliance, surfaces.contact, fixed.laws, law, fixed.share)
        pressed = CoatedInputs(
            inputs.hard_film, before.deflection, before.unknown, memory.steps, sheared
        )
        solved = solve_coated(pressed, layer, balance_inputs, fixed.domain, solver, faults)
        gap = inputs.hard_film + solved.deflection
        parts.check_overlap(gap, surfaces, 0.0, FAULT.overlap_of_coating, faults)
        return solved
    solution = solve_bare(balance_inputs, fixed.domain, solver, faults)
    return StepSolution(before.deflection, flow, solution, solution.iterations)


@compilable
def _layer_left(
    fixed: FilmConstants,
    memory: Memory,
    inputs: Inputs,
    begun: StepStart,
    solved: StepSolution,
    passed: Array,
) -> OilLayer:
    """Return the oil outside the film after a step; passed : of `step_parts.OilTransport`."""
    layer = begun.covered
    if not fixed.bore.supply.followed:
        return layer
    bore = fixed.bore
    spilled = begun.begin.pace.share * layer.spilled
    if fixed.domain.has_openings:
        spilled = spilled + begun.begin.start.length * solved.solution.spilled  # Eq. (T28)
    volumes = LayerVolumes(oil_layer.inflow(bore, passed), spilled)
    gaps = oil_layer.gaps(bore, inputs.hard_film + solved.deflection)
    mean = oil_layer.mean_of(inputs.velocity, fixed.domain.open_cells, bore.cells)
    return oil_layer.left(bore, layer, memory.layer, volumes, gaps, mean, inputs.length)


@compilable
def end(
    fixed: FilmConstants,
    memory: Memory,
    inputs: Inputs,
    begun: StepStart,
    solved: StepSolution,
    faults: Array,
) -> StepResult:
    """Return the forces of a step and the memory for the next one.

    A fault is noted if they are not finite.
    """
    before = memory.film
    film = solved.solution
    flow = solved.flow
    domain = fixed.domain
    length = inputs.length
    under = true_pressure(inputs.around.pressure_law, film.pressure)
    check_suction(inputs.around.pressure_law, under.pressure, faults)
    force_inputs = ForceInputs(solved.deflection, memory.steps, flow, under, film.film_fraction)
    acting = acting_of(fixed, inputs, force_inputs, faults)
    acted = acting.along
    law = inputs.around.pressure_law
    cavitation = fixed.surfaces.cavitation_pressure
    highest = acted.summary.highest - cavitation
    if law.kind != PRESSURE_VISCOSITY_LAWS.none and highest > law.limit:
        remark(faults, FAULT.beyond_pressure_law)
    went = parts.oil_transport(before, begun.begin, film, begun.entrainment, length, domain)
    account = parts.account(
        before, memory.totals, acted, acting.powers, film, went.growth, cavitation, length
    )
    layer = _layer_left(fixed, memory, inputs, begun, solved, went.passed)
    ledger = parts.BalanceScalars(
        boundary_share=account.boundary_share,
        received_power=account.received_power,
        flows=(float(film.edge_flow[LOWER]), float(film.edge_flow[UPPER]), film.from_openings),
        outflow=parts.leaving_above(film.axial_flow),
        imbalance=film.mass_imbalance,
        oil_in_film=account.oil,
        heat=account.heat,
    )
    after = parts.PreviousFilm(
        unknown=film.unknown,
        unknown_before=before.unknown,
        pressure=under.pressure,
        content=film.content,
        growth=went.growth,
        growth_before=before.growth,
        deflection=solved.deflection,
        film=oil_rows.carriers(flow.quantities, domain.bearing),
        film_before=before.film,
        passed=went.passed,
        travel=went.travel,
        step=length,
    )
    parts.check_finite(after, account.totals, faults)
    last = LastStep(
        film=flow.quantities,
        slopes=flow.slopes,
        slopes_around=flow.slopes_around,
        under=under,
        filling=solved_filling(film, domain.model),
        edges=begun.edges,
        length=begun.begin.start.length,
        unknown=film.unknown,
        full=film.full,
        stencil=film.stencil,
        shear=acted.shear,
        pressure_slope=acted.contact.pressure_slope,
        stress_slope=acted.contact.shear_stress_slope,
        touching=acted.touching,
        turning=turning_of(fixed, inputs),
    )
    return StepResult(
        Memory(after, account.totals, layer, memory.steps),
        fields_of(acting, film.film_fraction),
        scalars_of(fixed, acting, ledger, layer),
        last,
        solved.iterations,
    )
