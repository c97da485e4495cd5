"""Bodies that need no Python: their entries, their memory and their limits.

The entries compose the kernels and functions of `dynamics`, as `model` does.
"""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Annotated, Any, NamedTuple

import numpy as np

from ..master.fmi.block import (
    alike,
    flatten,
    keep,
    length_of,
    memory_of,
    parts,
    room_of,
    row_of,
)
from ..master.fmi.compiled import compiled, packed
from ..master.fmi.errors import BadInput
from ..master.fmi.native_parts import (
    FROM_COORDINATES,
    MEASURE,
    PLACE,
    READ,
    TO_COORDINATES,
    NativePart,
    get_each,
    positions_of,
    put_each,
)
from ..master.fmi.noted import ROOM, refuse, remark
from ..master.fmi.slave import PRODUCT, SEED
from ..master.fmi.symmetry import AUTOMATIC, WHOLE
from .dynamics.assembly import (
    BodySetup,
    assembled,
    load_bodies,
    setup_of,
)
from .dynamics.block_force import BlockForce
from .dynamics.contradictions import FAULT, FAULTS, check
from .dynamics.drive import Scalars
from .dynamics.element_laws import SWITCHES
from .dynamics.half_films import check_even, check_half
from .dynamics.instant import of_bearings, slides_at
from .dynamics.model import MOTION
from .dynamics.model_faults import body_faults
from .dynamics.parameters import Parameters, Settings, settings_of
from .dynamics.pin_outputs import PIN_NAMES
from .dynamics.response import FIELDS, StepEnd, StepInputs
from .dynamics.state import PistonState, problem_of, step_coefficients
from .dynamics.step import (
    GAS,
    START_PASSES,
    BodyModel,
    at_rest,
    coordinate_change,
    coordinates_of,
    crank_after,
    crank_at_start,
    film_measures,
    films_at,
    instant_of,
    is_started,
    modes_of,
    moved_by,
    others_at,
    response_to,
    result_of,
    set_damping,
    warning_of,
)
from .dynamics.system import RingForce
from .dynamics.thermal_growth import FieldInputs, warm_walls
from .geometry.film import NodalForces
from .geometry.pin import PinForces
from .mechanism.carrier import FIXED, block_motion_from
from .mechanism.generalised_alpha import coefficients
from .mechanism.piston_motion import LATERAL, RIGID, ROCKING
from .mechanism.slider_crank import CrankMotion
from .native_fields import forces_at, gathered, put_films, put_stacked, scatter
from .native_walls import WallPositions, growths_of, wall_positions
from .variables import BLOCK, FILM, FORCES, PIN_FILM, PIN_FORCES, RINGS

INTEGERS = ("gas_source", "crank_free", "film_symmetry")
"""Settings that are integers."""
CHOSEN_GAS, FREE, SYMMETRY = map(Settings._fields.index, INTEGERS)
"""Their numbers."""
NEEDS = Parameters(top_ring_height=1.0, bore_growth_lower=1.0, film_symmetry="automatic")
"""Parameters with the largest memory: gas on the wall, a bore that grows, and half films."""


def uncovered(options: Mapping[str, Any]) -> Iterable[str]:
    """Yield sentences on build options that the library does not cover."""
    as_in_case_or_build = ("motion_in_space", "in_space")  # an empty table chooses it
    if any(options.get(name) is not None for name in as_in_case_or_build):
        yield "motion_in_space: expected nothing in a native FMU, got a motion in space"
    if (options.get("block") or {}).get("bore_from_outside") is not None:
        yield "block.bore_from_outside: expected nothing in a native FMU, got a table"


# ---- memory

OfFilms = Annotated[np.ndarray, "films"]


class OutputPlaces(NamedTuple):
    """Positions of outputs that are not scalars of a step."""

    modal_coordinate: int
    modal_velocity: int
    bearing_coordinate: int
    bearing_velocity: int
    residual_evaluations: int
    jacobian_evaluations: int


class FieldPlaces(NamedTuple):
    """First positions of the fields of films, and their numbers of cells: arrays over surfaces.

    push, drag : nodal forces, normal and tangential; work_error : the output of this name. For a
    tangent the forces are seeds, thickness and sliding are products.
    """

    push: OfFilms
    drag: OfFilms
    thickness: OfFilms
    sliding: OfFilms
    work_error: OfFilms
    cells: OfFilms


OfRings = Annotated[np.ndarray, f"{len(RingForce._fields)}"]
OfCarrier = Annotated[np.ndarray, f"{len(FIXED)}"]
OfBlock = Annotated[np.ndarray, f"{len(BlockForce._fields)}"]


class VariablePlaces(NamedTuple):
    """Positions among the variables, -1 if there is none.

    settings, scalars, pin_scalars : of `Settings`, `Scalars` and `PIN_NAMES`, in their order;
    inputs : of the numbers of `StepInputs`;
    rings, carrier : of `variables.RINGS` and `variables.BLOCK`; on_block : of the forces on a
    mounted block; motion : of the derivatives `model.MOTION`.
    """

    settings: Annotated[np.ndarray, f"{len(Settings._fields)}"]
    scalars: Annotated[np.ndarray, f"{len(Scalars._fields)}"]
    pin_scalars: Annotated[np.ndarray, f"{len(PIN_NAMES)}"]
    gas_source: int
    crank_free: int
    film_symmetry: int
    crank_speed: int
    inputs: Annotated[np.ndarray, f"{len(StepInputs._fields) - len(FIELDS)}"]
    rings: OfRings
    rings_seed: OfRings
    carrier: OfCarrier
    carrier_seed: OfCarrier
    on_block: OfBlock
    on_block_product: OfBlock
    motion_product: Annotated[np.ndarray, "3"]
    outputs: OutputPlaces
    skirt: FieldPlaces
    skirt_tangent: FieldPlaces
    pins: FieldPlaces
    pins_tangent: FieldPlaces
    walls: WallPositions
    slides: Annotated[np.ndarray, "slides"]


class NativeSetup(NamedTuple):
    """Constant part of a memory that only a start reads.

    start_given, start_angle, start_speed, start_position, start_velocity : start of the build
    options, if there is one.
    """

    bodies: BodySetup
    start_given: bool
    start_angle: float
    start_speed: float
    start_position: Annotated[np.ndarray, "coordinates"]
    start_velocity: Annotated[np.ndarray, "coordinates"]


class BodyMemory(NamedTuple):
    """Parts of the memory.

    They are rows of `VariablePlaces`, `NativeSetup`, `BodyModel`, `PistonState`, that at the start,
    and `StepEnd`, the faults, the numbers of evaluations and tangents so far, and the coordinates
    or their change.
    """

    places: np.ndarray
    setup: np.ndarray
    model: np.ndarray
    state: np.ndarray
    begun: np.ndarray
    last: np.ndarray
    faults: np.ndarray
    counts: np.ndarray
    coordinates: np.ndarray


parts_of = parts(BodyMemory)
_, settings_from = packed(Settings)
_, rings_from = packed(RingForce)
_, step_inputs_from = packed(StepInputs, *FIELDS)
_, places_from = flatten(VariablePlaces)
_, setup_from = flatten(NativeSetup)
put_model, model_from = flatten(BodyModel)
put_state, state_from = flatten(PistonState)
is_state = alike(PistonState)
put_last, last_from = flatten(StepEnd)
length_of_model = length_of(BodyModel)
_room_of_state = room_of(PistonState, "n, w, s, g")
_room_of_last = room_of(StepEnd, "n, m, f")


def lengths_of(setup: NativeSetup, walls: WallPositions, model: BodyModel):
    """Return the lengths of all parts that change, for the largest model."""
    n = len(setup.start_position)
    m = max(n, len(FIXED))
    state = _room_of_state(n, 0, 0, growths_of(setup.bodies, walls))
    last = _room_of_last(m, m, len(model.parts.chain.laws.kind))
    return length_of_model(model), state, state, last, ROOM, 2, n


def setup_row(slave: Any) -> np.ndarray:
    """Return the constant part of the memory of an FMU: head and parts without parameters.

    Parameters
    ----------
    slave : slave.Mfbd
        Its resources hold the reduced bodies.
    """
    options = slave.built
    bodies = load_bodies(slave.resources, options)
    if wrong := body_faults(bodies, options):
        raise BadInput(wrong)
    body_setup = setup_of(bodies, options, NEEDS)
    needs = settings_of(replace(NEEDS, film_symmetry="none"))
    model = assembled(body_setup, needs._replace(**dict.fromkeys(SWITCHES, 1.0)))
    n = coordinates_of(model)
    begin, joints = options.start, model.parts.chain.joints.tip.shape[1] - RIGID
    setup = NativeSetup(
        bodies=body_setup,
        start_given=begin is not None,
        start_angle=begin.crank_angle if begin else 0.0,
        start_speed=begin.rotation_speed if begin else 0.0,
        start_position=begin.position(joints) if begin else np.zeros(n),
        start_velocity=begin.velocity(joints) if begin else np.zeros(n),
    )
    places = _places(slave)
    lengths = lengths_of(setup, places.walls, model)
    first = {"places": row_of(places), "setup": row_of(setup)}
    return memory_of(first, dict(zip(BodyMemory._fields[len(first) :], lengths)))


def _places(slave) -> VariablePlaces:
    """Return the positions of all variables of an FMU instance."""

    def each(names, kind=""):
        return positions_of(slave, names, kind)

    def fields(films, names, kinds=("",) * 4):
        columns = zip((*names, "interface_work_error"), (*kinds, ""))
        return FieldPlaces(
            *(each([f"{film.prefix}{name}" for film in films], kind) for name, kind in columns),
            cells=np.array([np.prod(film.shape) for film in films], dtype=float),
        )

    skirt, pins = slave.built.film_grids(), slave.built.pin_grids()
    of_tangent = SEED, SEED, PRODUCT, PRODUCT
    return VariablePlaces(
        settings=each("" if name in INTEGERS else name for name in Settings._fields),
        scalars=each(Scalars._fields),
        pin_scalars=each(PIN_NAMES),
        **{name: slave.references[name] for name in (*INTEGERS, "crank_speed")},
        inputs=each(name for name in StepInputs._fields if name not in FIELDS),
        rings=each(RINGS),
        rings_seed=each(RINGS, SEED),
        carrier=each(BLOCK),
        carrier_seed=each(BLOCK, SEED),
        on_block=each(BlockForce._fields),
        on_block_product=each(BlockForce._fields, PRODUCT),
        motion_product=each(MOTION, PRODUCT),
        outputs=OutputPlaces(*each(OutputPlaces._fields)),
        skirt=fields(skirt, (*FORCES, *FILM)),
        skirt_tangent=fields(skirt, (*FORCES, *FILM), of_tangent),
        pins=fields(pins, (*PIN_FORCES, *PIN_FILM)),
        pins_tangent=fields(pins, (*PIN_FORCES, *PIN_FILM), of_tangent),
        walls=wall_positions(slave),
        slides=each(slave.built.slides),
    )


# ---- a step


@compiled
def inputs_of(real, places):
    """Return `StepInputs`."""
    return step_inputs_from(
        get_each(real, places.inputs),
        NodalForces(*forces_at(real, places.skirt)),
        PinForces(*forces_at(real, places.pins)),
        rings_from(get_each(real, places.rings)),
        block_motion_from(get_each(real, places.carrier)),
        FieldInputs(
            gathered(real, places.walls.skirt, places.walls.skirt_cells),
            gathered(real, places.walls.bore, places.walls.bore_cells),
        ),
    )


@compiled
def seeds_of(real, places):
    """Return the seeds as `StepInputs`; the block's motion is not among them."""
    return step_inputs_from(
        np.zeros(len(places.inputs)),
        NodalForces(*forces_at(real, places.skirt_tangent)),
        PinForces(*forces_at(real, places.pins_tangent)),
        rings_from(get_each(real, places.rings_seed)),
        FIXED,
        FieldInputs(np.zeros(0), np.zeros(0)),
    )


@compiled
def publish(real, integer, counts, places, model, result):
    """Write the outputs and the numbers of evaluations into the variables."""
    outputs = places.outputs
    now = result.instant
    put_each(real, places.scalars, result.scalars)
    put_each(real, places.pin_scalars, now.pin_scalars)
    put_each(real, places.on_block, now.on_block)
    put_films(real, places.skirt, now.films.film_thickness, now.films.sliding_velocity)
    put_films(real, places.pins, now.pin_film_thickness, now.circumferential_velocity)
    scatter(real, places.walls.oil, places.walls.oil_cells, result.oil_temperature)
    put_each(real, places.skirt.work_error, now.films.work_error)
    put_each(real, places.pins.work_error, now.pin_work_error)
    first, last = modes_of(model)
    put_stacked(real, outputs.modal_coordinate, now.end.position[first:last])
    put_stacked(real, outputs.modal_velocity, now.next_start.velocity[first:last])
    parts = model.parts
    put_stacked(real, outputs.bearing_coordinate, of_bearings(parts, now.end.position))
    put_stacked(real, outputs.bearing_velocity, of_bearings(parts, now.next_start.velocity))
    put_each(real, places.slides, slides_at(parts, now.end.position, len(places.slides)))
    counts[0] += now.evaluations
    counts[1] += now.tangents
    integer[outputs.residual_evaluations] = int(counts[0])
    integer[outputs.jacobian_evaluations] = int(counts[1])


@compiled
def solve(real, integer, memory, places, model, c, before, crank):
    """Solve a step as `model.PistonInBore._solve`, and write its state and outputs.

    If the step is rejected, the fault is noted and the state stays.
    """
    parts = parts_of(memory)
    faults = parts.faults
    if not np.isfinite(crank.angle):
        refuse(faults, FAULT.no_angle, 0.0, 0.0, crank.angle, 0.0, 0.0)
        return
    inputs = inputs_of(real, places)
    remark(faults, warning_of(model, inputs))
    surfaces = model.parts.surfaces
    warm_walls(surfaces, model.cold, model.radii, model.settings, inputs.fields)
    others = others_at(model, inputs, crank)
    step = problem_of(c, before, crank, others)
    now = instant_of(model, step, inputs)
    if now.evaluations == 0:
        refuse(faults, FAULT.not_solved, 0.0, 0.0, crank.angle, now.change, 0.0)
    else:
        check_even(model.parts.surfaces, inputs.skirt, faults)
    if faults[0] > 0.0:
        return
    result = result_of(model, before, step, before.time + c.step, now, inputs)
    publish(real, integer, parts.counts, places, model, result)
    put_last(parts.last, result.last)
    put_state(parts.state, result.state)


# ---- entries


@compiled
def start(real: np.ndarray, integer: np.ndarray, memory: np.ndarray, numbers: np.ndarray):
    """Write state and outputs at the start; `numbers` unused."""
    parts = parts_of(memory)
    faults = parts.faults
    faults[0] = 0.0
    setup, places = setup_from(parts.setup), places_from(parts.places)
    numbers_of_settings = get_each(real, places.settings)
    numbers_of_settings[CHOSEN_GAS] = float(integer[places.gas_source])
    numbers_of_settings[FREE] = float(integer[places.crank_free])
    numbers_of_settings[SYMMETRY] = float(integer[places.film_symmetry])
    p = settings_from(numbers_of_settings)
    lacks_gas = p.gas_source == GAS.table and len(setup.bodies.gas.angle) == 0
    check(setup.bodies.fit, p, lacks_gas, faults)
    if faults[0] > 0.0:
        return
    model = assembled(setup.bodies, p)
    check_half(model.parts.surfaces, p, faults)
    if faults[0] > 0.0:
        return
    if p.film_symmetry == AUTOMATIC:
        odd = np.zeros(ROOM)
        forces = inputs_of(real, places).skirt
        check_even(model.parts.surfaces, forces, odd)
        if odd[0] > 0.0:
            numbers_of_settings[SYMMETRY] = WHOLE
            model = assembled(setup.bodies, settings_from(numbers_of_settings))
    if length_of_model(model) > len(parts.model):
        refuse(faults, FAULT.other_state, 0.0, 0.0, 0.0, 0.0, 0.0)
        return
    put_model(parts.model, model)
    model = model_from(parts.model)
    parts.counts[0], parts.counts[1] = 0.0, 0.0
    position = setup.start_position.copy()
    crank_angle = setup.start_angle
    speed = float(real[places.crank_speed])
    if setup.start_given and p.crank_free != 0.0:
        speed = setup.start_speed
    if not setup.start_given:
        position[LATERAL] = p.start_lateral_displacement
        position[ROCKING] = p.start_rocking_angle
        crank_angle = p.start_crank_angle
    crank = crank_at_start(model, crank_angle, speed)
    now = coefficients(0.0, p.spectral_radius)
    for _ in range(START_PASSES):
        before = at_rest(crank, position, setup.start_velocity)
        solve(real, integer, memory, places, model, now, before, crank)
        state = state_from(parts.state.copy())
        keep(parts.begun, parts.state)
        if faults[0] > 0.0 or is_started(p, crank, state):
            return
        crank = CrankMotion(crank.angle, crank.speed, state.crank_acceleration)


@compiled
def advance(real: np.ndarray, integer: np.ndarray, memory: np.ndarray, numbers: np.ndarray):
    """Take a step; the first of `numbers` is its length [s]."""
    parts = parts_of(memory)
    parts.faults[0] = 0.0
    if not is_state(parts.state, parts.begun):
        refuse(parts.faults, FAULT.other_state, 0.0, 0.0, 0.0, 0.0, 0.0)
        return
    step = numbers[0]
    state = state_from(parts.state.copy())
    model, places = model_from(parts.model), places_from(parts.places)
    set_damping(model, settings_from(get_each(real, places.settings)))
    crank = crank_after(model, state, step, float(real[places.crank_speed]))
    c = step_coefficients(state, step, model.settings.spectral_radius)
    solve(real, integer, memory, places, model, c, state, crank)


@compiled
def place(real, memory, step):
    """Write the films at coordinates after a step [s] from the state."""
    parts = parts_of(memory)
    model, places = model_from(parts.model), places_from(parts.places)
    before, inputs = state_from(parts.state), inputs_of(real, places)
    crank = crank_after(model, before, step, float(real[places.crank_speed]))
    c = step_coefficients(before, step, model.settings.spectral_radius)
    surfaces = model.parts.surfaces
    warm_walls(surfaces, model.cold, model.radii, model.settings, inputs.fields)
    films = films_at(model, before, c, crank, inputs, parts.coordinates)
    put_films(real, places.skirt, films.skirt.film_thickness, films.skirt.sliding_velocity)
    put_films(real, places.pins, films.pins.film_thickness, films.pins.sliding_velocity)


@compiled
def tangent(real: np.ndarray, integer: np.ndarray, memory: np.ndarray, numbers: np.ndarray):
    """Write the products of the seeds among the variables, or what the numbers say.

    See `native_parts.WHOLE`.
    """
    parts = parts_of(memory)
    parts.faults[0] = 0.0
    if numbers[0] == READ:
        keep(parts.coordinates, state_from(parts.state).position)
        return
    if numbers[0] == PLACE:
        place(real, memory, numbers[1])
        return
    model, places = model_from(parts.model), places_from(parts.places)
    last, is_exact = last_from(parts.last), numbers[1] == 0.0
    if numbers[0] == MEASURE:
        keep(parts.coordinates, film_measures(model, last))
    elif numbers[0] == TO_COORDINATES:
        keep(parts.coordinates, coordinate_change(model, last, seeds_of(real, places), is_exact))
    elif numbers[0] == FROM_COORDINATES:
        by = moved_by(model, last, parts.coordinates, is_exact)
        put_films(real, places.skirt_tangent, by.skirt.film_thickness, by.skirt.sliding_velocity)
        put_films(real, places.pins_tangent, by.pins.film_thickness, by.pins.sliding_velocity)
        motion = by.moved.velocity[LATERAL], by.moved.velocity[ROCKING], by.rising
        put_each(real, places.motion_product, motion)
    else:
        carried = get_each(real, places.carrier_seed)
        change = response_to(model, last, seeds_of(real, places), carried)
        put_films(real, places.skirt_tangent, change.film_thickness, change.sliding_velocity)
        pins = change.pin_film_thickness, change.circumferential_velocity
        put_films(real, places.pins_tangent, *pins)
        motion = change.lateral_velocity, change.rocking_velocity, change.piston_velocity
        put_each(real, places.motion_product, motion)
        if model.mounted:
            put_each(real, places.on_block_product, change.on_block)


PART = NativePart(
    entries=(start, advance, tangent),
    setup=setup_row,
    uncovered=uncovered,
    faults=FAULTS,
    refusal="",
    coordinates=BodyMemory._fields.index("coordinates"),
    direct=BlockForce._fields,
)
