"""Native entries of the bodies, which need no Python, and their limits.

The entries compose the kernels and functions of `dynamics`, as `model` does.
"""

from collections import namedtuple
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ..master.fmi.block import keep, part
from ..master.fmi.compiled import compiled, packed
from ..master.fmi.native_parts import Entry, NativePart, size
from ..master.fmi.noted import refuse, remark
from .dynamics.account import account
from .dynamics.block_force import by_carrier, carried_force, force_at, force_change
from .dynamics.carrier import FIXED, carrier_from
from .dynamics.clearance import machined_gap
from .dynamics.contradictions import FAULTS, GIVEN_TWICE, NO_ANGLE, NOT_SOLVED, check, pin_radius
from .dynamics.drive import End, Scalars, demand_of, others_of, scalars_of
from .dynamics.elimination import no_factors
from .dynamics.generalised_alpha import Motion, coefficients
from .dynamics.instant import end_of_step
from .dynamics.modal_damping import modal_springs
from .dynamics.parameters import GAS_SOURCES
from .dynamics.pin_coordinates import COORDINATES, layout, of_eye
from .dynamics.pin_inertia import inertia, inertia_with_rod
from .dynamics.pin_instant import end_of_pin_step
from .dynamics.pin_response import respond_pin
from .dynamics.pin_shells import EYE
from .dynamics.piston_motion import LATERAL, RIGID, ROCKING
from .dynamics.response import linearise, response, step_end
from .dynamics.slider_crank import CrankMotion, driven
from .dynamics.state import crank_of, motion_of, state_at, step_coefficients
from .dynamics.system import RingForce, StepProblem
from .dynamics.tables import gas_pressure
from .geometry.film import NodalForces
from .geometry.pin import PinForces, PinSurface
from .geometry.profile import linear_growth
from .geometry.surfaces import (
    count_of,
    pin_surface_at,
    pins_of,
    put_pin_surface,
    row_at,
    surface_at,
)
from .native_block import (
    PART_OF,
    SETTING,
    Direction,
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
from .native_given import given

COVERED: dict[str, tuple[str, ...] | float] = {"crank_free": 0.0, "quasi_static_frequency": 1e9}
"""The only value of a number that is in the library; all else is free."""

GAS = namedtuple("GasSource", GAS_SOURCES)(*range(1, 5))
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
    """Yield sentences on build options that the library does not cover."""
    for name, what in OPTIONS.items():
        if options.get(name) or (name in ON_WHEN_EMPTY and options.get(name) == {}):
            yield f"{name}: expected nothing in a native FMU, got {what}"
    if (options.get("block") or {}).get("bore_from_outside"):
        yield "block.bore_from_outside: expected nothing in a native FMU, got a table"
    if shapes := dict(options.get("floating_pin") or {}).get("pin_shapes"):
        yield f"floating_pin.pin_shapes: expected 0 in a native FMU, got {shapes}"


# ---- a start


@compiled
def machine(given, p):
    """Write the gaps of all surfaces, as `clearance.skirt_gap`."""
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
    """Write radii and clearances of pin and crank, and the inertia, as `pin_surfaces`."""
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
    put_matrix(given.inertia, inertia(bodies))
    put_matrix(given.with_rod, inertia_with_rod(bodies))


@compiled
def widen(given, p):
    """Write the widening of the bore, as `clearance.bore_shape`; all surfaces share one bore."""
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
    keep(given.settings, get_each(real, given.places.settings))
    given.settings[CHOSEN_GAS] = float(integer[given.places.gas_source])
    p = settings_of(given)
    machine(given, p)
    widen(given, p)
    system = given.system
    keep(system.piston.damping, modal_springs(given.piston_omega, p).damping)
    keep(system.block.damping, modal_springs(given.block_omega, p).damping)
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
def get_each(real, places):
    """Return the numbers at these positions, 0 if there is none."""
    numbers = np.zeros(len(places))
    for k in range(len(places)):
        if places[k] >= 0.0:
            numbers[k] = real[int(places[k])]
    return numbers


@compiled
def forces_at(real, places):
    """Return normal and tangential forces of films, or their seeds."""
    push = gathered(real, places.push, places.cells)
    return NodalForces(push, gathered(real, places.drag, places.cells))


@compiled
def pin_forces_at(real, places):
    """Return the forces of films of pin and crank, or their seeds."""
    forces = forces_at(real, places)
    return PinForces(forces.pressure, forces.friction)


@compiled
def is_mounted(given):
    """Return whether the block moves."""
    return given.places.carrier[0] >= 0.0


@compiled
def put_matrix(to, matrix):
    """Copy a matrix."""
    keep(to.reshape(to.size), matrix.reshape(matrix.size))


@compiled
def put_films(real, places, thickness, sliding):
    """Write the motion of all films into the variables, or its products."""
    scatter(real, places.thickness, places.cells, thickness)
    scatter(real, places.sliding, places.cells, sliding)


@compiled
def publish(real, integer, given, now, scalars):
    """Write the outputs and the numbers of evaluations into the variables."""
    places = given.places
    put_each(real, places.scalars, scalars)
    put_films(real, places.skirt, now.films.film_thickness, now.films.sliding_velocity)
    put_each(real, places.skirt.work_error, now.films.work_error)
    if len(given.piston_omega) + len(given.block_omega):
        first = COORDINATES if has_pins(given) else RIGID
        last = first + len(given.piston_omega) + len(given.block_omega)
        put_stacked(real, places.outputs.modal_coordinate, now.end.position[first:last])
        put_stacked(real, places.outputs.modal_velocity, now.kept.velocity[first:last])
    given.evaluations[0] += now.evaluations
    given.tangents[0] += now.tangents
    integer[places.outputs.residual_evaluations] = int(given.evaluations[0])
    integer[places.outputs.jacobian_evaluations] = int(given.tangents[0])


@compiled
def publish_pin(real, given, bodies, found):
    """Write the outputs of pin and crank into the variables."""
    places = given.places
    put_films(real, places.pins, found.film_thickness, found.circumferential_velocity)
    put_each(real, places.pins.work_error, found.work_error)
    put_each(real, places.pin_scalars, found.scalars)
    if len(bodies.eye.stiffness):
        first = layout(bodies)
        at = places.outputs.small_end_modal_coordinate
        put_stacked(real, at, of_eye(first, found.now.end.position))
        at = places.outputs.small_end_modal_velocity
        put_stacked(real, at, of_eye(first, found.now.kept.velocity))


_, rings_from = packed(RingForce)


@compiled
def crown_pressure(real, memory, given, p, crank_angle):
    """Return the gas pressure from input and table [Pa], with a remark if both are given."""
    by_input = real[given.places.gas_pressure]
    has_table = len(given.gas.angle) > 0
    if has_table and by_input != 0.0 and p.gas_source == GAS.either:
        remark(part(memory, PART_OF.faults), GIVEN_TWICE)
    pressure = 0.0 if p.gas_source == GAS.table else by_input
    if has_table and p.gas_source != GAS.input:
        pressure += gas_pressure(given.gas, crank_angle)
    return pressure


@compiled
def solve(real, integer, memory, c, before, auxiliary, at):
    """Solve a step as `model.PistonInBore._solve`, and write its state and outputs.

    If the step is rejected, the fault is noted and the state stays.
    """
    crank = at.crank
    if not np.isfinite(crank.angle):
        refuse(part(memory, PART_OF.faults), NO_ANGLE, 0.0, 0.0, crank.angle, 0.0, 0.0)
        return
    given = given_of(memory)
    places = given.places
    p = settings_of(given)
    system = system_of(given)
    pressure = crown_pressure(real, memory, given, p, crank.angle)
    others = others_of(
        np.pi * given.constants.bore_radius**2,
        pressure,
        rings_from(get_each(real, places.rings)),
        real[places.land_pressure],
        carrier_from(get_each(real, places.carrier)),
    )
    step = StepProblem(c, before, auxiliary, crank, others)
    skirt = forces_at(real, places.skirt)
    factors = no_factors()
    if has_pins(given):
        of = pin_system_of(given, system)
        found_with_pin = end_of_pin_step(of, step, skirt, pin_forces_at(real, places.pins))
        now = found_with_pin.now
        factors = found_with_pin.factors
        if now.evaluations > 0:
            publish_pin(real, given, of.bodies, found_with_pin)
    else:
        now = end_of_step(system, step, skirt)
    if now.evaluations == 0:
        refuse(part(memory, PART_OF.faults), NOT_SOLVED, 0.0, 0.0, crank.angle, now.change, 0.0)
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
    n = len(now.end.position) if has_pins(given) else RIGID + len(given.piston_omega)
    last = step_end(c, now, crank, n, factors)
    put_last(part(memory, PART_OF.last), last)
    given.has_linear[0] = 0.0
    if is_mounted(given):
        put_each(real, places.on_block, force_at(system, p.crank_unbalance, last))
    put_state(part(memory, PART_OF.state), state)


@compiled
def make_direction(memory, given, system, last):
    """Write the derivatives that all directions of a tied pin share into the memory."""
    found = linearise(system, last)
    columns = np.zeros((len(FIXED), 0))
    if is_mounted(given):
        columns = by_carrier(system, last)
    put_direction(part(memory, PART_OF.direction), Direction(found, columns))
    given.has_linear[0] = 1.0
    given.tangents[0] += 1.0


@compiled
def change_of_tied(real, memory, given, system, last):
    """Return the response of a tied pin to the seeds."""
    if given.has_linear[0] == 0.0:
        make_direction(memory, given, system, last)
    direction = direction_of(memory)
    places = given.places
    on_piston = np.zeros(RIGID + len(given.piston_omega))
    if is_mounted(given):
        on_piston = carried_force(direction.by_carrier, get_each(real, places.carrier_seed))
    forces = forces_at(real, places.skirt_tangent)
    rings = rings_from(get_each(real, places.rings_seed))
    return response(system, last.guided, direction.linear, forces, rings, on_piston)


@compiled
def change_with_pin(real, given, system, last):
    """Return the response of a floating pin to the seeds, and write that of its films."""
    places = given.places
    found = respond_pin(
        pin_system_of(given, system),
        last,
        forces_at(real, places.skirt_tangent),
        rings_from(get_each(real, places.rings_seed)),
        pin_forces_at(real, places.pins_tangent),
    )
    put_films(real, places.pins_tangent, found.film_thickness, found.circumferential_velocity)
    return found.change


# ---- entries


@compiled
def start(real: np.ndarray, integer: np.ndarray, memory: np.ndarray, numbers: np.ndarray):
    """Write state and outputs at the start; `numbers` unused."""
    faults = part(memory, PART_OF.faults)
    faults[0] = 0.0
    given = given_of(memory)
    prepare(real, integer, given)
    p = settings_of(given)
    lacks_gas = p.gas_source == GAS.table and len(given.gas.angle) == 0
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
    """Take a step; the first of `numbers` is its length [s]."""
    part(memory, PART_OF.faults)[0] = 0.0
    step = numbers[0]
    state = state_of(memory)
    given = given_of(memory)
    crank = driven(crank_of(state), step, real[given.places.crank_speed])
    c = step_coefficients(state, step, settings_of(given).spectral_radius)
    end = End(crank, state.time + step, state.steps + 1)
    solve(real, integer, memory, c, motion_of(state), state.auxiliary, end)


@compiled
def tangent(real: np.ndarray, integer: np.ndarray, memory: np.ndarray, numbers: np.ndarray):
    """Write the products of the seeds among the variables (Eq. (D7)); `numbers` unused."""
    part(memory, PART_OF.faults)[0] = 0.0
    given = given_of(memory)
    system = system_of(given)
    last = last_of(memory)
    places = given.places
    if has_pins(given):
        change = change_with_pin(real, given, system, last)
    else:
        change = change_of_tied(real, memory, given, system, last)
    put_films(real, places.skirt_tangent, change.film_thickness, change.sliding_velocity)
    motion = change.lateral_velocity, change.rocking_velocity, change.piston_velocity
    put_each(real, places.motion_product, motion)
    if is_mounted(given):
        carried = get_each(real, places.carrier_seed)
        unbalance = settings_of(given).crank_unbalance
        force = force_change(system, unbalance, last, change, carried)
        put_each(real, places.on_block_product, force)


PART = NativePart(
    entries=tuple(Entry(kernel) for kernel in (size, start, advance, tangent)),
    given=given,
    uncovered=uncovered,
    covered=COVERED,
    faults=FAULTS,
    refusal="",
    uncovered_ahead=uncovered,
)
