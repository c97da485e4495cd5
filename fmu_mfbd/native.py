"""Native entries of the bodies, which need no Python, and their limits.

The entries compose the kernels and functions of `dynamics`, as `model` does.
"""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ..master.fmi.block import keep, part
from ..master.fmi.compiled import compiled, packed
from ..master.fmi.native_parts import Entry, NativePart, tell_size
from ..master.fmi.noted import refuse, remark
from .dynamics.assembly import assembled, with_inertia
from .dynamics.block_force import force_change
from .dynamics.carrier import FIXED, carrier_from
from .dynamics.contradictions import FAULT, FAULTS, check
from .dynamics.generalised_alpha import coefficients
from .dynamics.parameters import Settings
from .dynamics.pin_coordinates import COORDINATES, layout, of_eye
from .dynamics.piston_motion import LATERAL, RIGID, ROCKING
from .dynamics.slider_crank import CrankMotion
from .dynamics.state import motion_of, step_coefficients
from .dynamics.step import (
    FIELDS,
    GAS,
    START_PASSES,
    StepInputs,
    at_rest,
    crank_after,
    crank_at_start,
    has_pins,
    instant_of,
    is_gas_twice,
    is_started,
    linearised,
    others_at,
    response_to,
    result_of,
    set_damping,
)
from .dynamics.system import RingForce, StepProblem
from .geometry.film import NodalForces
from .geometry.pin import PinForces
from .native_block import (
    PART_OF,
    common_of,
    given_of,
    is_sound,
    is_state,
    last_of,
    length_of_model,
    model_of,
    put_common,
    put_last,
    put_model,
    put_state,
    settings_from,
    state_of,
)
from .native_given import given

CHOSEN_GAS, FREE = map(Settings._fields.index, ("gas_source", "crank_free"))
"""Numbers of the settings that are integers."""
IN_SPACE = ("motion_in_space", "in_space")
"""Build option that is not covered, as a case and as build.json has it; an empty table chooses it.
"""


def uncovered(options: Mapping[str, Any]) -> Iterable[str]:
    """Yield sentences on build options that the library does not cover."""
    if any(options.get(name) is not None for name in IN_SPACE):
        yield "motion_in_space: expected nothing in a native FMU, got a motion in space"
    if (options.get("block") or {}).get("bore_from_outside") is not None:
        yield "block.bore_from_outside: expected nothing in a native FMU, got a table"
    if shapes := dict(options.get("floating_pin") or {}).get("pin_shapes"):
        yield f"floating_pin.pin_shapes: expected 0 in a native FMU, got {shapes}"


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
def put_films(real, places, thickness, sliding):
    """Write the motion of all films into the variables, or its products."""
    scatter(real, places.thickness, places.cells, thickness)
    scatter(real, places.sliding, places.cells, sliding)


_, rings_from = packed(RingForce)
_, step_inputs_from = packed(StepInputs, *FIELDS)


@compiled
def inputs_of(real, places):
    """Return `StepInputs`."""
    return step_inputs_from(
        get_each(real, places.inputs),
        forces_at(real, places.skirt),
        pin_forces_at(real, places.pins),
        rings_from(get_each(real, places.rings)),
        carrier_from(get_each(real, places.carrier)),
    )


@compiled
def seeds_of(real, places):
    """Return the seeds as `StepInputs`; the block's motion is not among them."""
    return step_inputs_from(
        np.zeros(len(places.inputs)),
        forces_at(real, places.skirt_tangent),
        pin_forces_at(real, places.pins_tangent),
        rings_from(get_each(real, places.rings_seed)),
        FIXED,
    )


@compiled
def publish(real, integer, given, model, result):
    """Write the outputs and the numbers of evaluations into the variables."""
    places = given.places
    outputs = places.outputs
    instant = result.instant
    now = instant.now
    put_each(real, places.scalars, result.scalars)
    put_each(real, places.pin_scalars, instant.scalars)
    put_each(real, places.on_block, result.on_block)
    put_films(real, places.skirt, now.films.film_thickness, now.films.sliding_velocity)
    put_films(real, places.pins, instant.film_thickness, instant.circumferential_velocity)
    put_each(real, places.skirt.work_error, now.films.work_error)
    put_each(real, places.pins.work_error, instant.work_error)
    first = COORDINATES if has_pins(model) else RIGID
    last = first + len(given.bodies.piston_omega) + len(given.bodies.block_omega)
    put_stacked(real, outputs.modal_coordinate, now.end.position[first:last])
    put_stacked(real, outputs.modal_velocity, now.kept.velocity[first:last])
    at = layout(model.parts.bodies)
    if at.big_end_shell > at.eye:
        put_stacked(real, outputs.small_end_modal_coordinate, of_eye(at, now.end.position))
        put_stacked(real, outputs.small_end_modal_velocity, of_eye(at, now.kept.velocity))
    real[outputs.cylinder_pressure] = result.others.wall.chamber
    real[outputs.side_force_demand] = result.side_force_demand
    given.evaluations[0] += now.evaluations
    given.tangents[0] += now.tangents
    integer[outputs.residual_evaluations] = int(given.evaluations[0])
    integer[outputs.jacobian_evaluations] = int(given.tangents[0])


@compiled
def solve(real, integer, memory, c, before, crank, time):
    """Solve a step as `model.PistonInBore._solve`, and write its state and outputs.

    If the step is rejected, the fault is noted and the state stays.
    """
    faults = part(memory, PART_OF.faults)
    if not np.isfinite(crank.angle):
        refuse(faults, FAULT.no_angle, 0.0, 0.0, crank.angle, 0.0, 0.0)
        return
    given = given_of(memory)
    model = model_of(memory)
    inputs = inputs_of(real, given.places)
    if is_gas_twice(model, inputs):
        remark(faults, FAULT.gas_twice)
    others = others_at(model, inputs, crank)
    step = StepProblem(c, motion_of(before), before.auxiliary, crank, others)
    instant = instant_of(model, step, inputs)
    now = instant.now
    if now.evaluations == 0:
        refuse(faults, FAULT.not_solved, 0.0, 0.0, crank.angle, now.change, 0.0)
        return
    result = result_of(model, before, step, time, instant, inputs)
    publish(real, integer, given, model, result)
    put_last(part(memory, PART_OF.last), result.last)
    put_state(part(memory, PART_OF.state), result.state)
    given.has_common[0] = 0.0


# ---- entries


@compiled
def size(real: np.ndarray, integer: np.ndarray, memory: np.ndarray, numbers: np.ndarray):
    """Write the head of the memory into `numbers`, as `tell_size`."""
    tell_size(memory, numbers, is_sound(real, integer, memory))


@compiled
def start(real: np.ndarray, integer: np.ndarray, memory: np.ndarray, numbers: np.ndarray):
    """Write state and outputs at the start; `numbers` unused."""
    faults = part(memory, PART_OF.faults)
    faults[0] = 0.0
    given = given_of(memory)
    numbers_of_settings = get_each(real, given.places.settings)
    numbers_of_settings[CHOSEN_GAS] = float(integer[given.places.gas_source])
    numbers_of_settings[FREE] = float(integer[given.places.crank_free])
    p = settings_from(numbers_of_settings)
    lacks_gas = p.gas_source == GAS.table and len(given.bodies.gas.angle) == 0
    check(given.bodies.fit, p, lacks_gas, faults)
    if faults[0] > 0.0:
        return
    model = assembled(given.bodies, p)
    if has_pins(model):
        model = with_inertia(model)
    if length_of_model(model) > len(part(memory, PART_OF.model)):
        refuse(faults, FAULT.other_state, 0.0, 0.0, 0.0, 0.0, 0.0)
        return
    put_model(part(memory, PART_OF.model), model)
    given.evaluations[0] = 0.0
    given.tangents[0] = 0.0
    position = given.start_position.copy()
    crank_angle = given.start_angle
    speed = float(real[given.places.crank_speed])
    if given.start_given and p.crank_free != 0.0:
        speed = given.start_speed
    if not given.start_given:
        position[LATERAL] = p.start_lateral_displacement
        position[ROCKING] = p.start_rocking_angle
        crank_angle = p.start_crank_angle
    crank = crank_at_start(model, crank_angle, speed)
    now = coefficients(0.0, p.spectral_radius)
    for _ in range(START_PASSES):
        before = at_rest(crank, position, given.start_velocity)
        solve(real, integer, memory, now, before, crank, 0.0)
        state = state_of(memory)
        keep(part(memory, PART_OF.begun), part(memory, PART_OF.state))
        if faults[0] > 0.0 or is_started(p, crank, state):
            return
        crank = CrankMotion(crank.angle, crank.speed, state.crank_acceleration)


@compiled
def advance(real: np.ndarray, integer: np.ndarray, memory: np.ndarray, numbers: np.ndarray):
    """Take a step; the first of `numbers` is its length [s]."""
    faults = part(memory, PART_OF.faults)
    faults[0] = 0.0
    if not is_state(part(memory, PART_OF.state), part(memory, PART_OF.begun)):
        refuse(faults, FAULT.other_state, 0.0, 0.0, 0.0, 0.0, 0.0)
        return
    step = numbers[0]
    state = state_of(memory)
    model = model_of(memory)
    places = given_of(memory).places
    set_damping(model, settings_from(get_each(real, places.settings)))
    crank = crank_after(model, state, step, float(real[places.crank_speed]))
    c = step_coefficients(state, step, model.settings.spectral_radius)
    solve(real, integer, memory, c, state, crank, state.time + step)


@compiled
def tangent(real: np.ndarray, integer: np.ndarray, memory: np.ndarray, numbers: np.ndarray):
    """Write the products of the seeds among the variables; `numbers` unused."""
    part(memory, PART_OF.faults)[0] = 0.0
    given = given_of(memory)
    model = model_of(memory)
    last = last_of(memory)
    places = given.places
    if given.has_common[0] == 0.0 and not has_pins(model):
        put_common(part(memory, PART_OF.common), linearised(model, last))
        given.has_common[0] = 1.0
        given.tangents[0] += 1.0
    carried = get_each(real, places.carrier_seed)
    found = response_to(model, last, common_of(memory), seeds_of(real, places), carried)
    change = found.change
    put_films(real, places.skirt_tangent, change.film_thickness, change.sliding_velocity)
    put_films(real, places.pins_tangent, found.film_thickness, found.circumferential_velocity)
    motion = change.lateral_velocity, change.rocking_velocity, change.piston_velocity
    put_each(real, places.motion_product, motion)
    if model.mounted:
        unbalance = model.settings.crank_unbalance
        force = force_change(model.parts.system, unbalance, last, change, carried)
        put_each(real, places.on_block_product, force)


PART = NativePart(
    entries=tuple(Entry(kernel) for kernel in (size, start, advance, tangent)),
    given=given,
    uncovered=uncovered,
    faults=FAULTS,
    refusal="",
    uncovered_ahead=uncovered,
)
