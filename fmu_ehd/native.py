"""The lubrication slave as a library that needs no Python: its entries, the memory they work on,
and what it covers.

An entry takes the slave's real and integer variables, as `master.fmi.slave` lays them out, and its
block of float64 numbers. A block begins with what is given: the grid, where in the variables each
number lies, tables that depend on no parameter.
"""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ..master.fmi.compiled import compiled
from ..master.fmi.native_parts import Entry, NativePart
from ..master.fmi.slave import PRODUCT, SEED, reserved
from . import step
from .asperity import CONTACT_LAWS, contact_table
from .contradictions import FULL_TURN, check_supply
from .faults import FAULTS, NO_TANGENT, refuse
from .grid import Array, keep
from .native_step import (
    CHOSEN,
    EDGES,
    GIVEN_HEAD,
    INITIAL_FILM_FRACTION,
    NUMBERS,
    SECTOR_ANGLE,
    STROKES,
    check_parameters,
    domain_of,
    factors_of,
    filled,
    fixed_of,
    laid_out,
    last_of,
    linear_of,
    memory_of,
    place_openings,
    put_last,
    put_linear,
    put_memory,
    roughen,
    supply_of,
    surroundings_of,
    warm_by_edges,
    warm_by_field,
)
from .oil_layer import skirt_edges
from .options import BuildOptions
from .step import ALONG, AROUND, NORMAL, Directions, Fields, Inputs, Scalars
from .summary import halves

WIDEST = 192  # cells around: beyond, sparse solvers of scipy are faster

# ---- where things lie: numbers in the variables, then parts of the block

FIELD_INPUTS = (
    "film_thickness",
    "sliding_velocity",
    "circumferential_velocity",
    "oil_temperature",
)
FILM_THICKNESS, SLIDING_VELOCITY, CIRCUMFERENTIAL_VELOCITY, OIL_TEMPERATURE = 0.0, 1.0, 2.0, 3.0
FIELD_OUTPUTS = Fields._fields
SCALARS = Scalars._fields
COUNTERS = ("solver_iterations",)
PLACED = (*NUMBERS, *CHOSEN, *FIELD_INPUTS, *FIELD_OUTPUTS, *SCALARS, *COUNTERS)
PLACES = len(PLACED)
OF_CHOSEN = len(NUMBERS)
OF_INPUTS = OF_CHOSEN + len(CHOSEN)
OF_OUTPUTS = OF_INPUTS + len(FIELD_INPUTS)
OF_SCALARS = OF_OUTPUTS + len(FIELD_OUTPUTS)
OF_COUNTERS = OF_SCALARS + len(SCALARS)
OF_SEEDS = PLACES  # the first of them; the others follow
OF_PRODUCTS = OF_SEEDS + 1
FOLLOWED = OF_PRODUCTS + 1  # 1 for each of NUMBERS that is an input
NOWHERE = -1.0

block_of, measure = laid_out(GIVEN_HEAD + FOLLOWED + len(NUMBERS))


def given(slave: Any) -> Array:
    """What the block of a slave begins with.

    Parameters
    ----------
    slave : slave.Ehd
    """
    built = BuildOptions.read(slave.options)
    n_c, n_a = built.grid
    cut = built.open_cells
    faces = skirt_edges(np.zeros((n_c, n_a), dtype=bool) if cut is None else cut)
    mask = np.ones((n_c, n_a)) if cut is None else ~cut
    head = [n_c, n_a, len(faces), built.surface == "bearing"]
    places = [slave.references.get(name, NOWHERE) for name in PLACED]
    directions = [
        slave.references[reserved(kind, names[0])]
        for kind, names in ((SEED, slave.derivative_inputs), (PRODUCT, slave.derivative_outputs))
    ]
    followed = [float(name in built.inputs) for name in NUMBERS]
    tables = [contact_table(law) for law in CONTACT_LAWS]
    whole = [head, places, directions, followed, *tables, *halves(n_c), mask, faces]
    return np.concatenate([np.asarray(part, dtype=float).ravel() for part in whole])


def uncovered(options: Mapping[str, Any]) -> Iterable[str]:
    """Sentences on build options, checked or as given, that the library does not cover."""
    match options.get("grid"):
        case [int(n_c), int(n_a)] if n_c > WIDEST:
            yield f"grid: expected at most {WIDEST} cells around in a native FMU, got {n_c} x {n_a}"


def uncovered_values(values: Mapping[str, Any]) -> Iterable[str]:
    """Sentences on parameters that the library has no room for."""
    room = STROKES * values["skirt_length"]
    if values["oil_supply"] != EDGES and values["stroke"] > room:
        yield (
            f"stroke: expected at most {room:g} m for skirt_length = {values['skirt_length']:g} m "
            f"in a native FMU, got {values['stroke']:g} m"
        )


# ---- between variables and block


@compiled
def _place(memory, k):
    """Where in the variables the k-th of `PLACED` and what follows lies; -1 for nowhere."""
    return int(memory[GIVEN_HEAD + k])


@compiled
def _field(real, place, shape):
    """A field among the variables."""
    n_c, n_a = shape
    return real[place : place + n_c * n_a].reshape((n_c, n_a))


@compiled
def _input(real, memory, block, which, domain):
    """A field of `FIELD_INPUTS`, whatever stands in cells without a film."""
    n_c, n_a = block.mask.shape
    field = _field(real, _place(memory, OF_INPUTS + int(which)), block.mask.shape)
    return filled(block, field.reshape((1, n_c, n_a)), domain)[0]


@compiled
def inputs_of(real, memory, block, domain, length):
    """`step.Inputs` for a step of a length [s]."""
    turning = np.zeros(block.mask.shape)
    if block.bearing:
        turning = _input(real, memory, block, CIRCUMFERENTIAL_VELOCITY, domain)
    return Inputs(
        _input(real, memory, block, FILM_THICKNESS, domain),
        _input(real, memory, block, SLIDING_VELOCITY, domain),
        turning,
        surroundings_of(block),
        length,
    )


@compiled
def take_numbers(real, integer, memory, block, length):
    """Take parameters from the variables, for a step of a length [s] those alone that are inputs;
    note what contradicts.
    """
    all_of_them = length == 0.0
    changed = all_of_them
    for k in range(len(NUMBERS)):
        follows = memory[GIVEN_HEAD + FOLLOWED + k] != 0.0
        place = _place(memory, k)
        if place >= 0 and (all_of_them or follows):
            block.numbers[k] = real[place]
            changed = True
    if all_of_them:
        if _place(memory, SECTOR_ANGLE) < 0:
            block.numbers[SECTOR_ANGLE] = FULL_TURN
        for k in range(len(CHOSEN)):
            block.chosen[k] = float(integer[_place(memory, OF_CHOSEN + k)])
        place_openings(block)
        roughen(block)
        check_parameters(block)
    if changed:
        check_supply(supply_of(block), block.faults)
    if _place(memory, OF_INPUTS + int(OIL_TEMPERATURE)) >= 0:
        domain = domain_of(block)
        warm_by_field(block, _input(real, memory, block, OIL_TEMPERATURE, domain))
    elif changed:
        warm_by_edges(block)


@compiled
def publish(fields, scalars, iterations, real, integer, memory):
    """Outputs into the variables."""
    shape = fields[0].shape
    for k in range(len(fields)):
        place = _place(memory, OF_OUTPUTS + k)
        if place >= 0:
            keep(_field(real, place, shape), fields[k])
    for k in range(len(scalars)):
        place = _place(memory, OF_SCALARS + k)
        if place >= 0:
            real[place] = scalars[k]
    integer[_place(memory, OF_COUNTERS)] = int(iterations)


# ---- entries


@compiled
def size(real: Array, integer: Array, memory: Array, numbers: Array):
    """Lengths for what a block begins with: of the whole, where its state begins and how long that
    is, where faults are.

    Parameters
    ----------
    real, integer : ndarray
        Unused.
    memory : ndarray
        At least what is given.
    numbers : ndarray, shape (4,)
        Overwritten.
    """
    measure(memory, numbers)


@compiled
def start(real: Array, integer: Array, memory: Array, numbers: Array):
    """State and outputs at the start; `numbers` unused."""
    block = block_of(memory)
    faults = block.faults
    faults[0] = 0.0
    faults[1] = 0.0  # no remark
    block.has_last[0] = 0.0
    take_numbers(real, integer, memory, block, 0.0)
    if faults[0] > 0.0:
        return
    fixed = fixed_of(block, 1.0)
    inputs = inputs_of(real, memory, block, fixed.domain, 0.0)
    initial = block.numbers[INITIAL_FILM_FRACTION]
    begun, fields, scalars = step.start(fixed, inputs, initial, faults)
    if faults[0] > 0.0:
        return
    put_memory(block.state, begun)
    publish(fields, scalars, 0.0, real, integer, memory)


@compiled
def advance(real: Array, integer: Array, memory: Array, numbers: Array):
    """One step; numbers: its length [s]. Where it is refused the fault is noted and the state
    stays.
    """
    block = block_of(memory)
    faults = block.faults
    faults[0] = 0.0
    faults[1] = 0.0  # no remark
    block.has_last[0] = 0.0  # a refused step has no tangent
    take_numbers(real, integer, memory, block, numbers[0])
    if faults[0] > 0.0:
        return
    fixed = fixed_of(block, 1.0)
    inputs = inputs_of(real, memory, block, fixed.domain, numbers[0])
    before = memory_of(block.state.copy())
    begun = step.begin(fixed, before, inputs, faults)
    if faults[0] > 0.0:
        return
    solved = step.solve(fixed, before, inputs, begun, factors_of(block), faults)
    if faults[0] > 0.0:
        return
    ended = step.end(fixed, before, inputs, begun, solved, faults)
    if faults[0] > 0.0:
        return
    put_memory(block.state, ended.memory)
    put_last(block.last, ended.last)
    block.has_last[0] = 1.0
    block.has_linear[0] = 0.0
    publish(ended.fields, ended.scalars, float(ended.iterations), real, integer, memory)


@compiled
def tangent(real: Array, integer: Array, memory: Array, numbers: Array):
    """Products of the seeds among the variables; `numbers` unused."""
    block = block_of(memory)
    block.faults[0] = 0.0
    if block.has_last[0] == 0.0:
        refuse(block.faults, NO_TANGENT, 0, 0, 0.0, 0.0, 0.0)
        return
    fixed = fixed_of(block, 0.0)
    last = last_of(block.last)
    if block.has_linear[0] == 0.0:
        put_linear(block.linear, step.linearise(fixed, last))
        block.has_linear[0] = 1.0
    n_c, n_a = block.mask.shape
    directions = 3 if block.bearing else 2
    n = directions * n_c * n_a
    first = _place(memory, OF_SEEDS)
    seeds = real[first : first + n].reshape((directions, 1, n_c, n_a))
    first = _place(memory, OF_PRODUCTS)
    products = real[first : first + n].reshape((directions, 1, n_c, n_a))
    domain = fixed.domain
    turning = np.zeros((0, 0, 0))
    if block.bearing:
        turning = filled(block, seeds[AROUND], domain)
    seeded = Directions(
        filled(block, seeds[NORMAL], domain), filled(block, seeds[ALONG], domain), turning
    )
    right = np.empty((1, n_c, n_a))
    linear = linear_of(block.linear)
    step.changes(fixed, last, linear, seeded, factors_of(block), right, products)


PART = NativePart(
    entries=tuple(Entry(kernel) for kernel in (size, start, advance, tangent)),
    given=given,
    uncovered=uncovered,
    covered={},
    faults=FAULTS,
    refusal="lubrication step to t = {a} s: ",
    uncovered_ahead=uncovered,
    uncovered_values=uncovered_values,
)
