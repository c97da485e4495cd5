"""Lubrication FMU that needs no Python: its entries, its memory and its limits.

An entry takes the real and integer variables of the FMU, in the layout of `master.fmi.slave`, and
its memory of float64 numbers. It runs the source of the model, so every number has the same bits.
Viscosities differ by the last bit of exp and log if the C library does.
"""

from collections.abc import Iterable, Mapping
from typing import Annotated, Any, NamedTuple

import numpy as np

from ..master.fmi.block import (
    alike,
    flatten,
    memory_of,
    parts,
    room_of,
    row_of,
)
from ..master.fmi.compiled import compiled, packed
from ..master.fmi.native_parts import NativePart, positions_of, put_each
from ..master.fmi.noted import ROOM
from ..master.fmi.slave import PRODUCT, SEED
from ..master.fmi.symmetry import AUTOMATIC, THRUST_PLANE, WHOLE
from . import constants, contradictions, step, step_tangent
from .common.faults import FAULT, FAULTS, count_rows_from, refuse
from .common.grid import Array, keep
from .contradictions import FROM_EDGES, FULL_TURN
from .options import BuildOptions
from .parameters import CHOICES, CHOSEN, NUMBERS, TUNABLE, Chosen, Numbers, has_image
from .solvers.blocks import Factors, no_factors
from .state import Fields, Inputs, LastStep, Memory, Scalars
from .step_tangent import FORCE, Directions, Linearisation
from .surroundings import surroundings_of, temperature_between_edges

SECTOR_ANGLE = NUMBERS.index("sector_angle")
INITIAL_FILM_FRACTION = NUMBERS.index("initial_film_fraction")
FILM_SYMMETRY = CHOSEN.index("film_symmetry")
COUNTS = np.array([len(CHOICES[name]) for name in CHOSEN], float)
"""Numbers of alternatives of each choice, which a saved state may exceed."""
MOST_CELLS_AROUND = 192  # cells around: beyond, sparse solvers of scipy are faster
STROKES = 6  # lengths of the skirt for which there is room on the bore, both ways
ROOM_ON_BORE = 1 + 2 * STROKES

# ---- memory

Vector = Annotated[Array, "n"]
Number = Annotated[Array, "1"]
"""An array of one, for what changes."""


class InputPositions(NamedTuple):
    """Positions of the input fields."""

    film_thickness: int
    sliding_velocity: int
    circumferential_velocity: int
    oil_temperature: int


class VariablePositions(NamedTuple):
    """Positions of everything among the variables; -1 if it does not exist.

    numbers, chosen, fields, scalars : of `NUMBERS`, `CHOSEN`, `step.Fields` and `step.Scalars`;
    seeds, products : where those of all directions begin.
    """

    numbers: Annotated[Array, f"{len(NUMBERS)}"]
    chosen: Annotated[Array, f"{len(CHOSEN)}"]
    inputs: InputPositions
    fields: Annotated[Array, f"{len(Fields._fields)}"]
    scalars: Annotated[Array, f"{len(Scalars._fields)}"]
    solver_iterations: int
    seeds: int
    products: int


class FilmSetup(NamedTuple):
    """Constant part of a memory, and parameters of the last step.

    follows : 1 for each of `NUMBERS` that may change; tables, half : of the whole film, and of one
    half if there is one; numbers, chosen : `NUMBERS` and `CHOSEN`;
    has_last, has_linear : whether there is one of the last step.
    """

    places: VariablePositions
    follows: Annotated[Array, f"{len(NUMBERS)}"]
    tables: constants.Tables
    half: constants.Tables
    numbers: Annotated[Array, f"{len(NUMBERS)}"]
    chosen: Annotated[Array, f"{len(CHOSEN)}"]
    has_last: Number
    has_linear: Number


class FilmMemory(NamedTuple):
    """Parts of the memory.

    They are rows of `FilmSetup`, `step.Memory`, that at the start, `step.LastStep`,
    `step_tangent.Linearisation` and `blocks.Factors`, and the faults.
    """

    setup: Vector
    state: Vector
    begun: Vector
    last: Vector
    linear: Vector
    solver: Vector
    faults: Vector


IS_SHARED = tuple(name.startswith("nodal_") for name in Fields._fields)
"""Whether the images of a cell share a field, `constants.on_film`."""
parts_of = parts(FilmMemory)
_, numbers_from = packed(Numbers)
_, chosen_from = packed(Chosen)
_, setup_from = flatten(FilmSetup)
put_factors, factors_from = flatten(Factors)
put_memory, memory_of_state = flatten(Memory)
is_memory = alike(Memory)
put_last, last_of = flatten(LastStep)
put_linear, linear_of = flatten(Linearisation)
_room_of_memory = room_of(Memory, "n_c, n_a, n_e, n_b")
_room_of_last = room_of(LastStep, "n_c, n_a")
_room_of_linear = room_of(Linearisation, "n_c, n_a")
_room_of_factors = room_of(Factors, "n_c, n_a")


def lengths_of(tables: constants.Tables):
    """Return the lengths of all parts after the first one."""
    n_c, n_a = tables.open_cells.shape
    state = _room_of_memory(n_c, n_a, len(tables.faces), ROOM_ON_BORE * n_a)
    last, linear = _room_of_last(n_c, n_a), _room_of_linear(n_c, n_a)
    return state, state, last, linear, _room_of_factors(n_c, n_a), ROOM


def setup_row(slave: Any) -> Array:
    """Return the constant part of the memory of an FMU.

    Parameters
    ----------
    slave : slave.Ehd
    """
    built = BuildOptions.read(slave.options)
    cut = built.open_cells
    open_cells = np.zeros(built.grid, dtype=bool) if cut is None else cut
    places = VariablePositions(
        positions_of(slave, NUMBERS),
        positions_of(slave, CHOSEN),
        InputPositions(*positions_of(slave, InputPositions._fields)),
        positions_of(slave, Fields._fields),
        positions_of(slave, Scalars._fields),
        *positions_of(slave, ("solver_iterations",)),
        *positions_of(slave, slave.derivative_inputs[:1], SEED),
        *positions_of(slave, slave.derivative_outputs[:1], PRODUCT),
    )
    bearing = built.surface == "bearing"
    setup = FilmSetup(
        places,
        follows=np.array([float(name in TUNABLE) for name in NUMBERS]),
        tables=constants.tables_of(open_cells, bearing),
        half=constants.tables_of(
            open_cells, bearing, mirrored=has_image(built.grid, cut, built.surface)
        ),
        numbers=np.zeros(len(NUMBERS)),
        chosen=np.zeros(len(CHOSEN)),
        has_last=np.zeros(1),
        has_linear=np.zeros(1),
    )
    lengths = dict(zip(FilmMemory._fields[1:], lengths_of(setup.tables)))
    return memory_of({"setup": row_of(setup)}, lengths)


def uncovered(options: Mapping[str, Any]) -> Iterable[str]:
    """Yield a sentence for each build option, checked or not, that the library does not cover."""
    match options.get("grid"):
        case [int(n_c), int(n_a)] if n_c > MOST_CELLS_AROUND:
            yield (
                f"grid: expected at most {MOST_CELLS_AROUND} cells around in a native FMU, "
                f"got {n_c} x {n_a}"
            )


def uncovered_values(values: Mapping[str, Any]) -> Iterable[str]:
    """Yield a sentence for each parameter that the library does not cover."""
    room = STROKES * values["skirt_length"]
    if values["oil_supply"] != FROM_EDGES and values["stroke"] > room:
        yield (
            f"stroke: expected at most {room:g} m for skirt_length = {values['skirt_length']:g} m "
            f"in a native FMU, got {values['stroke']:g} m"
        )


# ---- between variables and memory


@compiled
def tables_in(setup: FilmSetup):
    """Return the tables of the grid on which the film is computed."""
    return setup.half if setup.chosen[FILM_SYMMETRY] == THRUST_PLANE else setup.tables


@compiled
def constants_of(setup: FilmSetup, on_bore: bool):
    """Return `constants.FilmConstants`; a tangent needs no bore."""
    x, chosen = numbers_from(setup.numbers), chosen_from(setup.chosen)
    return constants.fixed_of(x, chosen, tables_in(setup), on_bore)


@compiled
def _field(real, place, shape):
    """Return a field among the variables."""
    n_c, n_a = shape
    return real[place : place + n_c * n_a].reshape((n_c, n_a))


@compiled
def _input(real, tables, place, has_openings, fault, faults):
    """Return an input field on the grid; note the fault of this number if it is not symmetric."""
    n_f, n_a = len(tables.rows), tables.open_cells.shape[1]
    field = _field(real, place, (n_f, n_a))
    constants.check_even(tables, field, fault, faults)
    return constants.on_grid(tables, has_openings, field.reshape((1, n_f, n_a)))[0]


@compiled
def inputs_of(real: Array, setup: FilmSetup, has_openings: bool, length: float, faults: Array):
    """Return the `state.Inputs` for a step of a length [s]; note where they are not symmetric."""
    places, tables = setup.places.inputs, tables_in(setup)
    x = numbers_from(setup.numbers)
    turning = np.zeros(tables.open_cells.shape)
    if tables.bearing:
        turning = _input(real, tables, places.circumferential_velocity, has_openings, -1.0, faults)
    if places.oil_temperature >= 0:
        odd = FAULT.odd_oil_temperature
        temperature = _input(real, tables, places.oil_temperature, has_openings, odd, faults)
    else:
        temperature = temperature_between_edges(x, tables.open_cells.shape)
    thickness, sliding = FAULT.odd_film_thickness, FAULT.odd_sliding_velocity
    images = constants.images_of(tables)
    return Inputs(
        _input(real, tables, places.film_thickness, has_openings, thickness, faults),
        _input(real, tables, places.sliding_velocity, has_openings, sliding, faults),
        turning,
        surroundings_of(x, chosen_from(setup.chosen), temperature, images),
        length,
    )


@compiled
def _has_even_inputs(real, setup):
    """Return whether the film can be computed by halves, with the inputs at its start."""
    if not constants.is_mirrored(setup.half):
        return False
    setup.chosen[FILM_SYMMETRY] = THRUST_PLANE
    noted = np.zeros(ROOM)
    inputs_of(real, setup, False, 0.0, noted)
    return noted[0] == 0.0


@compiled
def take_numbers(real: Array, integer: Array, setup: FilmSetup, length: float, faults: Array):
    """Take parameters from the variables, and note what contradicts.

    For a step of a length [s] only those that may change are taken.
    """
    faults[0] = 0.0
    faults[1] = 0.0  # no remark
    setup.has_last[0] = 0.0  # a refused step has no tangent
    places = setup.places
    is_start = length == 0.0
    for k in range(len(NUMBERS)):
        place = int(places.numbers[k])
        if place >= 0 and (is_start or setup.follows[k] != 0.0):
            setup.numbers[k] = real[place]
    if places.numbers[SECTOR_ANGLE] < 0.0:
        setup.numbers[SECTOR_ANGLE] = FULL_TURN
    for k in range(len(CHOSEN) if is_start else 0):
        place = int(places.chosen[k])
        chosen = float(integer[place]) if place >= 0 else 1.0
        setup.chosen[k] = min(max(chosen, 1.0), COUNTS[k])
    if setup.chosen[FILM_SYMMETRY] == AUTOMATIC:
        is_even = _has_even_inputs(real, setup)
        setup.chosen[FILM_SYMMETRY] = THRUST_PLANE if is_even else WHOLE
    x, chosen = numbers_from(setup.numbers), chosen_from(setup.chosen)
    if is_start:
        tables = tables_in(setup)
        constants.fill(x, chosen, tables)
        cut_outs = bool(tables.open_cells.any())
        mirrors = constants.is_mirrored(setup.half)
        contradictions.check_parameters(x, chosen, tables.bearing, cut_outs, mirrors, faults)
        room = STROKES * x.skirt_length
        if chosen.oil_supply != FROM_EDGES and x.stroke > room:
            refuse(faults, FAULT.stroke_too_long, 0, 0, x.stroke, x.skirt_length, room)
    contradictions.check_supply(x, chosen, faults)


@compiled
def publish(fields, scalars, iterations, real, integer, places, tables):
    """Write the outputs into the variables."""
    n_c, n_a = tables.open_cells.shape
    for k in range(len(fields)):
        if places.fields[k] >= 0.0:
            whole = constants.on_film(tables, fields[k].reshape((1, n_c, n_a)), IS_SHARED[k])[0]
            keep(_field(real, int(places.fields[k]), whole.shape), whole)
    put_each(real, places.scalars, scalars)
    integer[places.solver_iterations] = int(iterations)


# ---- entries


@compiled
def start(real: Array, integer: Array, memory: Array, numbers: Array):
    """Compute state and outputs at the start; `numbers` is unused."""
    _start(real, integer, memory)
    _show_rows(memory)


@compiled
def _show_rows(memory):
    """Count the cells of the faults from the first row of the film."""
    parts = parts_of(memory)
    count_rows_from(parts.faults, constants.first_row(tables_in(setup_from(parts.setup))))


@compiled
def _start(real, integer, memory):
    """Compute state and outputs at the start, unless a fault is noted."""
    parts = parts_of(memory)
    faults = parts.faults
    setup = setup_from(parts.setup)
    take_numbers(real, integer, setup, 0.0, faults)
    if faults[0] > 0.0:
        return
    fixed = constants_of(setup, True)
    tables = tables_in(setup)
    put_factors(parts.solver, no_factors(tables.open_cells.shape))
    inputs = inputs_of(real, setup, fixed.domain.has_openings, 0.0, faults)
    initial = setup.numbers[INITIAL_FILM_FRACTION]
    begun, fields, scalars = step.start(fixed, inputs, initial, faults)
    if faults[0] > 0.0:
        return
    put_memory(parts.state, begun)
    keep(parts.begun, parts.state)
    publish(fields, scalars, 0.0, real, integer, setup.places, tables)


@compiled
def advance(real: Array, integer: Array, memory: Array, numbers: Array):
    """Take a step; the first of `numbers` is its length [s].

    If the step is rejected, the fault is noted and the state does not change.
    """
    _advance(real, integer, memory, numbers)
    _show_rows(memory)


@compiled
def _advance(real, integer, memory, numbers):
    """Take a step, unless a fault is noted."""
    parts = parts_of(memory)
    faults = parts.faults
    setup = setup_from(parts.setup)
    take_numbers(real, integer, setup, numbers[0], faults)
    if faults[0] > 0.0:
        return
    fixed = constants_of(setup, True)
    odd = np.zeros(ROOM)
    inputs = inputs_of(real, setup, fixed.domain.has_openings, numbers[0], odd)
    if not is_memory(parts.state, parts.begun):
        refuse(faults, FAULT.other_state, 0, 0, 0.0, 0.0, 0.0)
        return
    before = memory_of_state(parts.state.copy())
    begun = step.begin(fixed, before, inputs, faults)
    if faults[0] > 0.0:
        return
    solved = step.solve(fixed, before, inputs, begun, factors_from(parts.solver), faults)
    if faults[0] > 0.0:
        return
    ended = step.end(fixed, before, inputs, begun, solved, faults)
    if faults[0] == 0.0 and odd[0] > 0.0:
        keep(faults, odd)
    if faults[0] > 0.0:
        return
    put_memory(parts.state, ended.memory)
    put_last(parts.last, ended.last)
    setup.has_last[0] = 1.0
    setup.has_linear[0] = 0.0
    iterations = float(ended.iterations)
    tables = tables_in(setup)
    publish(ended.fields, ended.scalars, iterations, real, integer, setup.places, tables)


@compiled
def tangent(real: Array, integer: Array, memory: Array, numbers: Array):
    """Write the products of the seeds among the variables; `numbers` is unused."""
    parts = parts_of(memory)
    faults = parts.faults
    faults[0] = 0.0
    setup = setup_from(parts.setup)
    if setup.has_last[0] == 0.0:
        refuse(faults, FAULT.no_tangent, 0, 0, 0.0, 0.0, 0.0)
        return
    tables = tables_in(setup)
    fixed = constants_of(setup, False)
    last = last_of(parts.last)
    if setup.has_linear[0] == 0.0:
        put_linear(parts.linear, step_tangent.linearise(fixed, last))
        setup.has_linear[0] = 1.0
    linear = linear_of(parts.linear)
    n_c, n_a = tables.open_cells.shape
    n_f = len(tables.rows)
    directions = 3 if tables.bearing else 2
    n = directions * n_f * n_a
    first = setup.places.seeds
    seeds = real[first : first + n].reshape((directions, 1, n_f, n_a))
    first = setup.places.products
    products = real[first : first + n].reshape((directions, 1, n_f, n_a))
    has_openings = fixed.domain.has_openings
    turning = np.zeros((0, 0, 0))
    if tables.bearing:
        turning = constants.on_grid(tables, has_openings, seeds[FORCE.around])
    seeded = Directions(
        constants.on_grid(tables, has_openings, seeds[FORCE.normal]),
        constants.on_grid(tables, has_openings, seeds[FORCE.along]),
        turning,
    )
    right = np.empty((1, n_c, n_a))
    forces = np.empty((directions, 1, n_c, n_a))
    factors = factors_from(parts.solver)
    step_tangent.changes(fixed, last, linear, seeded, factors, right, forces)
    for k in range(directions):
        keep(products[k], constants.on_film(tables, forces[k], True))


PART = NativePart(
    entries=(start, advance, tangent),
    setup=setup_row,
    uncovered=uncovered,
    faults=FAULTS,
    refusal="lubrication step to t = {a} s: ",
    uncovered_values=uncovered_values,
)
