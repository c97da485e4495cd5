"""Native entries of the bodies, which need no Python, and their limits.

The entries compose the kernels and functions of `dynamics`, as `model` does.
"""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ..master.fmi.block import memory_of, part, room, row_of
from ..master.fmi.compiled import compiled, packed
from ..master.fmi.errors import BadInput
from ..master.fmi.native_parts import Entry, NativePart, size
from ..master.fmi.noted import ROOM, refuse, remark
from ..master.fmi.slave import PRODUCT, SEED, reserved
from .dynamics.account import account
from .dynamics.assembly import (
    ReducedBodies,
    assemble_system,
    bands,
    body_faults,
    fit_of,
    load_bodies,
    machined_gap,
    measured,
    pin_surfaces,
    surfaces,
)
from .dynamics.block_force import by_carrier, carried_force, force_at, force_change
from .dynamics.build_options import BuildOptions
from .dynamics.carrier import FIXED, Carrier
from .dynamics.contradictions import (
    FAULTS,
    GIVEN_TWICE,
    NO_ANGLE,
    NOT_SOLVED,
    check,
    pin_radius,
)
from .dynamics.drive import End, Scalars, demand_of, others_of, scalars_of
from .dynamics.elimination import no_factors
from .dynamics.generalised_alpha import Motion, coefficients
from .dynamics.instant import end_of_step
from .dynamics.modal_damping import modal_springs
from .dynamics.parameters import (
    CRANK_PARAMETERS,
    Parameters,
    PinParameters,
)
from .dynamics.pin_coordinates import COORDINATES, layout, of_eye
from .dynamics.pin_inertia import inertia, inertia_with_rod
from .dynamics.pin_instant import PinScalars, end_of_pin_step
from .dynamics.pin_response import respond_pin
from .dynamics.pin_shells import EYE
from .dynamics.piston_motion import LATERAL, RIGID, ROCKING
from .dynamics.response import StepEnd, linearise, response, step_end
from .dynamics.slider_crank import CrankMotion, driven
from .dynamics.state import PistonState, crank_of, motion_of, state_at, step_coefficients
from .dynamics.system import RingForce, StepProblem
from .dynamics.tables import gas_pressure
from .geometry.film import NodalForces, knot_rule
from .geometry.grid import cell_centres
from .geometry.pin import PinForces, PinSurface
from .geometry.profile import fourier_bore, linear_growth
from .geometry.surfaces import (
    count_of,
    pin_surface_at,
    pins_in_block,
    pins_of,
    put_pin_surface,
    row_at,
    surface_at,
    with_room,
)
from .native_block import (
    DIRECTION,
    FAULTS_AT,
    FIELDS,
    LAST,
    NOWHERE,
    ON_PIN,
    SETTING,
    STATE,
    CarrierPlaces,
    Constants,
    Direction,
    FieldPlaces,
    GasCurve,
    Given,
    OutputPlaces,
    ProductPlaces,
    RingPlaces,
    VariablePlaces,
    direction_of,
    given_of,
    has_pins,
    last_of,
    pin_system_of,
    put_direction,
    put_last,
    put_state,
    settings_of,
    state_of,
    system_of,
)

COVERED: dict[str, tuple[str, ...] | float] = {"crank_free": 0.0, "quasi_static_frequency": 1e9}
"""The only value of a number that is in the library; all else is free."""

GAS_EITHER, GAS_TABLE, GAS_INPUT = range(1, 4)
"""Numbers of the choices in `GAS_SOURCES`."""
CHOSEN_GAS = SETTING.index("gas_source")
ENERGY_GAIN, ENERGY_SIZE = map(Scalars._fields.index, ("energy_gain", "energy_size"))
OPTIONS = {
    "speed": "a table of crank speed",
    "motion_in_space": "a motion in space",
    "in_space": "a motion in space",
}
"""Build options, as a case gives them and as build.json holds them, that are not covered."""
ON_WHEN_EMPTY = ("motion_in_space", "in_space")
"""Those of which an empty table is a choice."""


def uncovered(options: Mapping[str, Any]) -> Iterable[str]:
    """Sentences on build options that the library does not cover."""
    for name, what in OPTIONS.items():
        if options.get(name) or (name in ON_WHEN_EMPTY and options.get(name) == {}):
            yield f"{name}: expected nothing in a native FMU, got {what}"
    if (options.get("block") or {}).get("bore_from_outside"):
        yield "block.bore_from_outside: expected nothing in a native FMU, got a table"
    if shapes := dict(options.get("floating_pin") or {}).get("pin_shapes"):
        yield f"floating_pin.pin_shapes: expected 0 in a native FMU, got {shapes}"


# ---- what the memory begins with


def given(slave: Any) -> np.ndarray:
    """Return the constant part of the memory of an FMU: head and parts without parameters.

    Parameters
    ----------
    slave : slave.Mfbd
        Its resources hold the reduced bodies.
    """
    options: BuildOptions = slave.built
    bodies = load_bodies(slave.resources, options)
    if wrong := body_faults(bodies.piston, bodies.block, options, bodies.bosses):
        raise BadInput(wrong)
    begun = _begun(slave, options, bodies)
    n = max(len(begun.start_position), len(FIXED))
    lengths = {
        "state": room(PistonState, n=len(begun.start_position), w=0, s=0),
        "last": room(StepEnd, n=n, m=n),
        "direction": room(Direction, n=n, m=n),
        "faults": ROOM,
    }
    return memory_of({"given": row_of(begun)}, lengths)


def _begun(slave: Any, options: BuildOptions, bodies: ReducedBodies) -> Given:
    """Return `Given` before a start."""
    piston, block, bosses, eye = bodies
    angle, height = cell_centres(*options.grid, piston.skirt_lower, piston.skirt_upper)
    k, m = len(piston.omega), len(block.omega)
    rings = Parameters(top_ring_height=1.0, second_ring_height=1.0)  # of any, for the wall
    films = with_room(surfaces(piston, block, options, rings), len(block.heights))
    orders = fourier_bore(options.block.orders, angle)[:, None]
    widening = orders + measured(options.block.profiles, angle, block.heights)
    profile = np.broadcast_to(measured(options.piston.profiles, angle, height), options.grid)
    of_films = [profile[:, one.first : one.last].ravel() for one in options.film_surfaces()]
    gas, begin, pin = options.gas, options.start, options.floating_pin
    crank = {name: CRANK_PARAMETERS[name]() for name in options.crank_surfaces()}
    pins = pin_surfaces(options, 1.0, PinParameters(), crank, bosses, eye) if pin else ()
    n = coordinates(options, k, m)
    none = np.zeros(0)
    of_inertia = np.zeros((n, n) if pin else (0, 0))
    return Given(
        places=_places(slave),
        constants=Constants(
            bore_radius=block.radius,
            start_given=begin is not None,
            start_angle=begin.crank_angle if begin else 0.0,
        ),
        fit=fit_of(piston, block, options, bosses, eye.eye_radius if eye else 0.0),
        system=assemble_system(piston, block, options, rings, films),
        measured=np.concatenate(of_films),
        heights=block.heights,
        widening=np.broadcast_to(widening, (len(angle), len(block.heights))),
        inverse=knot_rule(len(block.heights)),
        bands=bands(options),
        gas=GasCurve(gas.angle, gas.pressure, gas.cycle) if gas else GasCurve(none, none, 0.0),
        start_position=begin.position() if begin else np.zeros(n),
        start_velocity=begin.velocity() if begin else np.zeros(n),
        piston_omega=piston.omega,
        block_omega=block.omega,
        pin_surfaces=pins_in_block(pins),
        eye_omega=eye.eye_omega if eye else none,
        settings=np.zeros(len(SETTING)),
        inertia=of_inertia,
        with_rod=of_inertia,
        has_linear=np.zeros(1),
        evaluations=np.zeros(1),
        tangents=np.zeros(1),
    )


def coordinates(options: BuildOptions, piston_modes: int, block_modes: int) -> int:
    """Return how many the bodies have."""
    pin = options.floating_pin
    if pin is None:
        return RIGID + piston_modes + block_modes
    return COORDINATES + piston_modes + pin.small_end_modes + 2 * len(options.crank_bearings)


def _places(slave) -> VariablePlaces:
    """Return where everything lies among a slave's variables."""

    def place(name, kind=""):
        return slave.references.get(reserved(kind, name) if kind else name, NOWHERE)

    def places(places, prefix, kind=""):
        return places(*(place(f"{prefix}{name}", kind) for name in places._fields))

    def each(names):
        return np.array([place(name) for name in names], dtype=float)

    def fields(films, others):
        names = [others.get(name, name) for name in FIELDS]
        columns = [[place(f"{film.prefix}{name}") for film in films] for name in names]
        for kind, some in ((SEED, names[:2]), (PRODUCT, names[2:4])):
            columns += [[place(f"{film.prefix}{name}", kind) for film in films] for name in some]
        columns.append([np.prod(film.shape) for film in films])
        return FieldPlaces(*(np.array(column, dtype=float) for column in columns))

    settings = each(SETTING)
    settings[SETTING.index("crank_free")] = NOWHERE  # no real number; 0 is all that is covered
    return VariablePlaces(
        settings,  # `gas_source` is a choice: its place is among the whole numbers
        each(Scalars._fields),
        each(PinScalars._fields),
        place("gas_pressure"),
        place("land_pressure"),
        place("crank_speed"),
        places(RingPlaces, "ring_"),
        places(CarrierPlaces, "block_"),
        places(RingPlaces, "ring_", SEED),
        places(CarrierPlaces, "block_", SEED),
        places(OutputPlaces, ""),
        places(ProductPlaces, "", PRODUCT),
        fields(slave.built.film_grids(), {}),
        fields(slave.built.pin_grids(), ON_PIN),
    )


# ---- a start


@compiled
def machine(given, p):
    """Gaps of all surfaces, as `assembly.skirt_gap`."""
    x = given.fit
    first = 0
    for k in range(count_of(given.system.surfaces)):
        skirt = surface_at(given.system.surfaces, k).skirt
        c, a = skirt.gap.shape
        for i in range(c):
            for j in range(a):
                skirt.gap[i, j] = given.measured[first + i * a + j] + machined_gap(
                    skirt.angle[i], skirt.height[j], x.skirt_lower, x.skirt_upper, p
                )
        first += c * a


@compiled
def machine_pins(given, p):
    """Radii and clearances of pin and crank, as `assembly.pin_surfaces`; what has inertia."""
    x = given.fit
    for k in range(pins_of(given.pin_surfaces)):
        radius = pin_radius(x.piston_radius, p)
        clearance = p.boss_clearance if k < EYE else p.small_end_clearance
        if k == EYE + 1 and x.has_big_end:
            radius = p.big_end_radius
            clearance = p.big_end_clearance
        elif k > EYE:
            radius = p.main_bearing_radius
            clearance = p.main_bearing_clearance
        one = pin_surface_at(given.pin_surfaces, k)
        for j in range(len(one.clearance)):
            one.clearance[j] = clearance
        turned = PinSurface(one.outward, one.onward, radius, one.clearance, one.modes, one.axis)
        put_pin_surface(row_at(given.pin_surfaces, k), turned)
    bodies = pin_system_of(given, system_of(given)).bodies
    keep(given.inertia, inertia(bodies))
    keep(given.with_rod, inertia_with_rod(bodies))


@compiled
def widen(given, p):
    """Write the widening of the bore, as `assembly.bore_shape`; all surfaces share one bore."""
    heights = given.heights
    shape = surface_at(given.system.surfaces, 0).bore.shape
    knots, c = shape.shape
    for k in range(knots):
        for i in range(c):
            total = 0.0
            for j in range(len(heights)):
                wider = given.widening[i, j] + linear_growth(
                    heights[j], heights[0], heights[-1], p.bore_growth_lower, p.bore_growth_upper
                )
                total += given.inverse[k, j] * wider
            shape[k, i] = total


@compiled
def prepare(real, integer, given):
    """Write what follows from the parameters, as `assembly.assemble`."""
    for k in range(len(given.settings)):
        at = int(given.places.settings[k])
        given.settings[k] = 0.0
        if at >= 0:
            given.settings[k] = float(integer[at]) if k == CHOSEN_GAS else real[at]
    p = settings_of(given)
    machine(given, p)
    widen(given, p)
    system = given.system
    keep(system.piston.damping, modal_springs(given.piston_omega, given.bands, p).damping)
    keep(system.block.damping, modal_springs(given.block_omega, given.bands, p).damping)
    if has_pins(given):
        machine_pins(given, p)


# ---- a step


@compiled
def gathered(real, begins, cells):
    """Return a field of all film surfaces, their cells one after another."""
    field = np.empty(int(cells.sum()))
    first = 0
    for s in range(len(cells)):
        for k in range(int(cells[s])):
            field[first + k] = real[int(begins[s]) + k]
        first += int(cells[s])
    return field


@compiled
def scatter(real, begins, cells, field):
    """Write a stacked field into the variables of all film surfaces."""
    first = 0
    for s in range(len(cells)):
        for k in range(int(cells[s])):
            real[int(begins[s]) + k] = field[first + k]
        first += int(cells[s])


@compiled
def put_each(real, places, values):
    """Put numbers into the variables, where there is a place."""
    for k in range(len(places)):
        if places[k] >= 0.0:
            real[int(places[k])] = values[k]


@compiled
def put_stacked(real, first, values):
    """Put an array into the variables from a place on."""
    for k in range(len(values)):
        real[first + k] = values[k]


@compiled
def forces_at(real, places, of_seeds):
    """Return normal and tangential forces of films, or their seeds."""
    push = places.push_seed if of_seeds else places.push
    drag = places.drag_seed if of_seeds else places.drag
    return NodalForces(gathered(real, push, places.cells), gathered(real, drag, places.cells))


@compiled
def rings_at(real, places):
    """Return the forces of the rings, or their seeds."""
    return RingForce(real[places.side_force], real[places.axial_force], real[places.moment])


@compiled
def carried_at(real, places):
    """Motion of a mounted block, or its seeds; 0 of another."""
    motion = np.zeros(len(FIXED))
    if places.acceleration_x >= 0:
        for k in range(len(places)):
            motion[k] = real[places[k]]
    return motion


@compiled
def is_mounted(given):
    """Return whether the block moves."""
    return given.places.carrier.acceleration_x >= 0


@compiled
def keep(to, what):
    """Copy an array, in a loop."""
    to = to.reshape(to.size)
    what = what.reshape(what.size)
    for k in range(len(to)):
        to[k] = what[k]


@compiled
def publish(real, integer, given, now, scalars):
    """Write the outputs and the numbers of evaluations into the variables."""
    places = given.places
    put_each(real, places.scalars, scalars)
    scatter(real, places.skirt.thickness, places.skirt.cells, now.film_thickness)
    scatter(real, places.skirt.sliding, places.skirt.cells, now.sliding_velocity)
    put_each(real, places.skirt.work_error, now.work_error)
    if len(given.piston_omega) + len(given.block_omega):
        first = COORDINATES if has_pins(given) else RIGID
        last = first + len(given.piston_omega) + len(given.block_omega)
        put_stacked(real, places.outputs.modal_coordinate, now.position[first:last])
        put_stacked(real, places.outputs.modal_velocity, now.kept_velocity[first:last])
    given.evaluations[0] += now.evaluations
    given.tangents[0] += now.tangents
    integer[places.outputs.residual_evaluations] = int(given.evaluations[0])
    integer[places.outputs.jacobian_evaluations] = int(given.tangents[0])


@compiled
def publish_pin(real, given, bodies, found):
    """Write the outputs of pin and crank into the variables."""
    places = given.places
    pins = places.pins
    scatter(real, pins.thickness, pins.cells, found.film_thickness)
    scatter(real, pins.sliding, pins.cells, found.circumferential_velocity)
    put_each(real, pins.work_error, found.work_error)
    put_each(real, places.pin_scalars, found.scalars)
    if len(bodies.eye.stiffness):
        first = layout(bodies)
        at = places.outputs.small_end_modal_coordinate
        put_stacked(real, at, of_eye(first, found.now.position))
        at = places.outputs.small_end_modal_velocity
        put_stacked(real, at, of_eye(first, found.now.kept_velocity))


_, carrier_from = packed(Carrier)


@compiled
def crown_pressure(real, memory, given, p, crank_angle):
    """Gas pressure by input and table [Pa], as `gas_source` says; a remark if it is given twice."""
    by_input = real[given.places.gas_pressure]
    has_table = len(given.gas.angle) > 0
    if has_table and by_input != 0.0 and p.gas_source == GAS_EITHER:
        remark(part(memory, FAULTS_AT), GIVEN_TWICE)
    pressure = 0.0 if p.gas_source == GAS_TABLE else by_input
    if has_table and p.gas_source != GAS_INPUT:
        pressure += gas_pressure(given.gas, crank_angle)
    return pressure


@compiled
def solve(real, integer, memory, c, before, auxiliary, at):
    """Solve a step as `model.PistonInBore._solve`, and write its state and outputs.

    If the step is rejected, the fault is noted and the state stays.
    """
    crank = at.crank
    if not np.isfinite(crank.angle):
        refuse(part(memory, FAULTS_AT), NO_ANGLE, 0.0, 0.0, crank.angle, 0.0, 0.0)
        return
    given = given_of(memory)
    places = given.places
    p = settings_of(given)
    system = system_of(given)
    pressure = crown_pressure(real, memory, given, p, crank.angle)
    others = others_of(
        np.pi * given.constants.bore_radius**2,
        pressure,
        rings_at(real, places.rings),
        real[places.land_pressure],
        carrier_from(carried_at(real, places.carrier)),
    )
    step = StepProblem(c, before, auxiliary, crank, others)
    skirt = forces_at(real, places.skirt, False)
    factors = no_factors()
    if has_pins(given):
        of = pin_system_of(given, system)
        on_pins = forces_at(real, places.pins, False)
        forces = PinForces(on_pins.pressure, on_pins.friction)
        found_with_pin = end_of_pin_step(of, step, skirt, forces)
        now = found_with_pin.now
        factors = found_with_pin.factors
        if now.evaluations > 0:
            publish_pin(real, given, of.bodies, found_with_pin)
    else:
        now = end_of_step(system, step, skirt)
    if now.evaluations == 0:
        refuse(part(memory, FAULTS_AT), NOT_SOLVED, 0.0, 0.0, crank.angle, now.change, 0.0)
        return
    scalars = scalars_of(now, crank, p.crank_inertia, system.piston, system.surfaces)
    publish(real, integer, given, now, scalars)
    state = state_at(now, crank, at.time, at.steps)
    if at.steps > 0:
        begun = state_of(memory)
        found = account(
            (begun.kinetic, state.kinetic),
            state.position - begun.position,
            (begun.other_forces, state.other_forces),
            scalars.energy_gain,
        )
        real[int(places.scalars[ENERGY_GAIN])] = found.gain
        real[int(places.scalars[ENERGY_SIZE])] = found.size
    real[places.outputs.cylinder_pressure] = pressure
    real[places.outputs.side_force_demand] = demand_of(system, others, crank)
    # a tied pin's derivatives follow from the piston alone
    n = len(now.position) if has_pins(given) else RIGID + len(given.piston_omega)
    last = step_end(c, now, crank, n, factors)
    put_last(part(memory, LAST), last)
    given.has_linear[0] = 0.0
    if is_mounted(given):
        force = force_at(system, p.crank_unbalance, last)
        put_block_force(real, places.outputs, force)
        real[places.outputs.main_bearing_force_x] = force.bearing_x
        real[places.outputs.main_bearing_force_y] = force.bearing_y
    put_state(part(memory, STATE), state)


@compiled
def put_block_force(real, places, force):
    """Write the forces on a mounted block into the variables."""
    real[places.force_on_block_x] = force.x
    real[places.force_on_block_y] = force.y
    real[places.moment_on_block] = force.moment


@compiled
def make_direction(memory, given, system, last):
    """Write the derivatives that all directions of a tied pin share into the memory."""
    found = linearise(system, last)
    columns = np.zeros((len(FIXED), 0))
    if is_mounted(given):
        columns = by_carrier(system, last)
    put_direction(part(memory, DIRECTION), Direction(found, columns))
    given.has_linear[0] = 1.0
    given.tangents[0] += 1.0


@compiled
def change_of_tied(real, memory, given, system, last):
    """Answer of a tied pin to the seeds."""
    if given.has_linear[0] == 0.0:
        make_direction(memory, given, system, last)
    direction = direction_of(memory)
    places = given.places
    on_piston = np.zeros(RIGID + len(given.piston_omega))
    if is_mounted(given):
        on_piston = carried_force(direction.by_carrier, carried_at(real, places.carrier_seed))
    forces = forces_at(real, places.skirt, True)
    rings = rings_at(real, places.rings_seed)
    return response(system, last.guided, direction.linear, forces, rings, on_piston)


@compiled
def change_with_pin(real, given, system, last):
    """Answer of a floating pin to the seeds, that of its films into the variables."""
    places = given.places
    on_pins = forces_at(real, places.pins, True)
    found = respond_pin(
        pin_system_of(given, system),
        last,
        forces_at(real, places.skirt, True),
        rings_at(real, places.rings_seed),
        PinForces(on_pins.pressure, on_pins.friction),
    )
    pins = places.pins
    scatter(real, pins.thickness_product, pins.cells, found.film_thickness)
    scatter(real, pins.sliding_product, pins.cells, found.circumferential_velocity)
    return found.change


# ---- entries


@compiled
def start(real: np.ndarray, integer: np.ndarray, memory: np.ndarray, numbers: np.ndarray):
    """State and outputs at the start; `numbers` unused."""
    faults = part(memory, FAULTS_AT)
    faults[0] = 0.0
    given = given_of(memory)
    prepare(real, integer, given)
    p = settings_of(given)
    lacks_gas = p.gas_source == GAS_TABLE and len(given.gas.angle) == 0
    check(given.fit, p, lacks_gas, faults)
    if faults[0] > 0.0:
        return
    given.evaluations[0] = 0.0
    given.tangents[0] = 0.0
    x = given.constants
    position = given.start_position.copy()
    crank_angle = x.start_angle
    if not x.start_given:
        position[LATERAL] = p.start_lateral_displacement
        position[ROCKING] = p.start_rocking_angle
        crank_angle = p.start_crank_angle
    at_rest = np.zeros(len(position))
    before = Motion(position, given.start_velocity, at_rest)
    speed = float(real[given.places.crank_speed])
    crank = CrankMotion(crank_angle, speed, 0.0)
    now = coefficients(0.0, p.spectral_radius)
    solve(real, integer, memory, now, before, at_rest, End(crank, 0.0, 0))


@compiled
def advance(real: np.ndarray, integer: np.ndarray, memory: np.ndarray, numbers: np.ndarray):
    """One step; numbers: its length [s]."""
    part(memory, FAULTS_AT)[0] = 0.0
    step = numbers[0]
    state = state_of(memory)
    given = given_of(memory)
    crank = driven(crank_of(state), step, real[given.places.crank_speed])
    c = step_coefficients(state, step, settings_of(given).spectral_radius)
    end = End(crank, state.time + step, state.steps + 1)
    solve(real, integer, memory, c, motion_of(state), state.auxiliary, end)


@compiled
def tangent(real: np.ndarray, integer: np.ndarray, memory: np.ndarray, numbers: np.ndarray):
    """Products of the seeds among the variables (Eq. (D7)); `numbers` unused."""
    part(memory, FAULTS_AT)[0] = 0.0
    given = given_of(memory)
    system = system_of(given)
    last = last_of(memory)
    places = given.places
    if has_pins(given):
        change = change_with_pin(real, given, system, last)
    else:
        change = change_of_tied(real, memory, given, system, last)
    skirt = places.skirt
    scatter(real, skirt.thickness_product, skirt.cells, change.film_thickness)
    scatter(real, skirt.sliding_product, skirt.cells, change.sliding_velocity)
    products = places.products
    real[products.lateral_velocity] = change.lateral_velocity
    real[products.rocking_velocity] = change.rocking_velocity
    real[products.piston_velocity] = change.piston_velocity
    if is_mounted(given):
        carried = carried_at(real, places.carrier_seed)
        unbalance = settings_of(given).crank_unbalance
        force = force_change(system, unbalance, last, change, carried)
        put_block_force(real, products, force)


PART = NativePart(
    entries=tuple(Entry(kernel) for kernel in (size, start, advance, tangent)),
    given=given,
    uncovered=uncovered,
    covered=COVERED,
    faults=FAULTS,
    refusal="",
    uncovered_ahead=uncovered,
)
