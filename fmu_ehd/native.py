"""The lubrication slave as a library that needs no Python: its entries, the memory they work on,
and what it covers.

An entry takes the slave's real and integer variables, as `master.fmi.slave` lays them out, and its
block of float64 numbers. A block begins with what is given: the grid, where in the variables each
number lies, tables that depend on no parameter.
"""

from collections.abc import Iterable
from typing import Any

import numpy as np

from ..master.fmi.compiled import compiled
from ..master.fmi.native_parts import Entry, NativePart
from ..master.fmi.slave import PRODUCT, SEED, reserved
from . import native_step
from .asperity import CONTACT_LAWS, contact_table
from .faults import FAULTS, ROOM
from .grid import Array
from .native_step import (
    CHOSEN,
    COLUMNS,
    COUNTERS,
    FIELD_INPUTS,
    FIELD_OUTPUTS,
    FILM_THICKNESS,
    GIVEN_HEAD,
    LAST_FIELDS,
    LAST_NUMBERS,
    LAW_NUMBERS,
    LINEAR_FIELDS,
    NUMBERS,
    OIL_TEMPERATURE,
    ROWS,
    SCALARS,
    SLIDING_VELOCITY,
    STATE_FIELDS,
    STATE_NUMBERS,
    TABLE,
    Block,
    Inputs,
    Outputs,
    check_surroundings,
    filled,
    place_openings,
    roughen,
    warm_by_edges,
    warm_by_field,
)
from .options import BuildOptions
from .piezoviscosity import TABLE as LAW_TABLE
from .roughness import TABLE as FACTORS
from .summary import halves
from .variables import DERIVATIVE_INPUTS, DERIVATIVE_OUTPUTS

COVERED: dict[str, tuple[str, ...] | float] = {
    "oil_supply": ("edges",),
}
"""Choices, or the only value of a number, that are in the library; all else is free."""

WIDEST = 192  # cells around: beyond, sparse solvers of scipy are faster

# ---- where things lie: numbers in the variables, then parts of the block

PLACED = (*NUMBERS, *CHOSEN, *FIELD_INPUTS, *FIELD_OUTPUTS, *SCALARS, *COUNTERS)
PLACES = len(PLACED)
OF_CHOSEN = len(NUMBERS)
OF_INPUTS = OF_CHOSEN + len(CHOSEN)
OF_OUTPUTS = OF_INPUTS + len(FIELD_INPUTS)
OF_SCALARS = OF_OUTPUTS + len(FIELD_OUTPUTS)
OF_COUNTERS = OF_SCALARS + len(SCALARS)
OF_SEEDS = PLACES
OF_PRODUCTS = OF_SEEDS + 2
FOLLOWED = OF_PRODUCTS + 2  # 1 for each of NUMBERS that is an input
TABLES = GIVEN_HEAD + FOLLOWED + len(NUMBERS)
HALVES = TABLES + 2 * TABLE[0] * TABLE[1]
NOWHERE = -1.0
WHOLE, FIRST_STATE, STATES, FIRST_FAULT = range(4)  # what `size` tells


def given(slave: Any) -> Array:
    """What the block of a slave begins with.

    Parameters
    ----------
    slave : slave.Ehd
    """
    n_c, n_a = slave.options["grid"]
    places = [slave.references.get(name, NOWHERE) for name in PLACED]
    directions = [
        slave.references[reserved(kind, name)]
        for kind, names in ((SEED, DERIVATIVE_INPUTS), (PRODUCT, DERIVATIVE_OUTPUTS))
        for name in names
    ]
    followed = [float(name in slave.options["inputs"]) for name in NUMBERS]
    tables = [contact_table(law) for law in CONTACT_LAWS]
    mask = slave.options["mask"] or np.ones((n_c, n_a))
    whole = [[n_c, n_a], places, directions, followed, *tables, *halves(n_c), mask]
    return np.concatenate([np.asarray(part, dtype=float).ravel() for part in whole])


def uncovered(options: dict[str, Any]) -> Iterable[str]:
    """Sentences on build options that the library does not cover."""
    built = BuildOptions.read(options)
    n_c, _ = built.grid
    if built.surface != "skirt":
        yield f"surface = {built.surface}: a native FMU covers skirt"
    if n_c > WIDEST:
        yield f"grid = {n_c} x {built.grid[1]}: a native FMU covers {WIDEST} cells around"


# ---- the block


@compiled(inline="always")
def _state(n_c, n_a):
    """Where the state begins, and its length."""
    first = HALVES + 2 * n_c + len(NUMBERS) + len(CHOSEN) + 4 * n_c * n_a
    length = STATE_FIELDS * n_c * n_a + 2 * n_c * (n_a + 1) + STATE_NUMBERS
    return first, length


@compiled
def whole_size(n_c: int, n_a: int):
    """Length of a block."""
    first, length = _state(n_c, n_a)
    fields = (LAST_FIELDS + LINEAR_FIELDS) * n_c * n_a + n_c * (n_a + 1) + LAST_NUMBERS
    factors = n_a * n_c * (n_c + 2) + n_a + 1
    laws = FACTORS[0] * FACTORS[1] + LAW_NUMBERS + LAW_TABLE[0] * LAW_TABLE[1]
    return first + length + fields + factors + laws + ROOM


@compiled
def block_of(memory: Array):
    """`Block` on the memory of a slave."""
    n_c = int(memory[COLUMNS])
    n_a = int(memory[ROWS])
    n = n_c * n_a
    a = HALVES
    share = memory[a : a + n_c]
    a += n_c
    sine = memory[a : a + n_c]
    a += n_c
    mask = memory[a : a + n].reshape((n_c, n_a))
    a += n
    beside = memory[a : a + n].reshape((n_c, n_a))
    a += n
    numbers = memory[a : a + len(NUMBERS)]
    a += len(NUMBERS)
    chosen = memory[a : a + len(CHOSEN)]
    a += len(CHOSEN)
    temperature = memory[a : a + n].reshape((n_c, n_a))
    a += n
    viscosity = memory[a : a + n].reshape((n_c, n_a))
    a += n
    # the state, in one piece
    fields = memory[a : a + STATE_FIELDS * n].reshape((STATE_FIELDS, n_c, n_a))
    a += STATE_FIELDS * n
    faces = memory[a : a + 2 * (n + n_c)].reshape((2, n_c, n_a + 1))
    a += 2 * (n + n_c)
    counts = memory[a : a + STATE_NUMBERS]
    a += STATE_NUMBERS
    last = memory[a : a + LAST_FIELDS * n].reshape((LAST_FIELDS, n_c, n_a))
    a += LAST_FIELDS * n
    last_faces = memory[a : a + n + n_c].reshape((n_c, n_a + 1))
    a += n + n_c
    last_numbers = memory[a : a + LAST_NUMBERS]
    a += LAST_NUMBERS
    linear = memory[a : a + LINEAR_FIELDS * n].reshape((LINEAR_FIELDS, n_c, n_a))
    a += LINEAR_FIELDS * n
    columns = memory[a : a + n * n_c].reshape((n_a, n_c, n_c))
    a += n * n_c
    diagonals = memory[a : a + n].reshape((n_a, n_c))
    a += n
    orders = memory[a : a + n].reshape((n_a, n_c))
    a += n
    sizes = memory[a : a + n_a]
    a += n_a
    direction = memory[a : a + 1]
    a += 1
    flow_factors = memory[a : a + FACTORS[0] * FACTORS[1]].reshape(FACTORS)
    a += FACTORS[0] * FACTORS[1]
    law = memory[a : a + LAW_NUMBERS]
    a += LAW_NUMBERS
    law_table = memory[a : a + LAW_TABLE[0] * LAW_TABLE[1]].reshape(LAW_TABLE)
    a += LAW_TABLE[0] * LAW_TABLE[1]
    faults = memory[a : a + ROOM]
    tables = memory[TABLES:HALVES].reshape((2, TABLE[0], TABLE[1]))
    return Block(
        numbers,
        chosen,
        tables,
        faults,
        share,
        sine,
        mask,
        beside,
        temperature,
        viscosity,
        flow_factors,
        law,
        law_table,
        fields,
        faces,
        counts,
        last,
        last_faces,
        last_numbers,
        linear,
        columns,
        diagonals,
        orders,
        sizes,
        direction,
    )


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
def inputs_of(real: Array, memory: Array, shape: tuple[int, int]):
    """Fields that a step is given."""
    return Inputs(
        _field(real, _place(memory, OF_INPUTS + FILM_THICKNESS), shape),
        _field(real, _place(memory, OF_INPUTS + SLIDING_VELOCITY), shape),
    )


@compiled
def take_numbers(real, integer, memory, block, all_of_them):
    """Take parameters from the variables, or those alone that are inputs; note what contradicts."""
    changed = all_of_them
    for k in range(len(NUMBERS)):
        follows = memory[GIVEN_HEAD + FOLLOWED + k] != 0.0
        if all_of_them or follows:
            block.numbers[k] = real[_place(memory, k)]
            changed = True
    if all_of_them:
        for k in range(len(CHOSEN)):
            block.chosen[k] = float(integer[_place(memory, OF_CHOSEN + k)])
        place_openings(block)
        roughen(block)
    if changed:
        check_surroundings(block)
    field = _place(memory, OF_INPUTS + OIL_TEMPERATURE)
    if field >= 0:
        warm_by_field(block, filled(block, _field(real, field, block.viscosity.shape)))
    elif changed:
        warm_by_edges(block)


@compiled
def new_outputs(shape: tuple[int, int]):
    """Room for what a step gives."""
    n_c, n_a = shape
    return Outputs(np.empty((len(FIELD_OUTPUTS), n_c, n_a)), np.empty(len(SCALARS)))


@compiled
def publish(outputs, iterations, real, integer, memory):
    """Outputs into the variables."""
    shape = outputs.fields[0].shape
    for k in range(len(FIELD_OUTPUTS)):
        place = _place(memory, OF_OUTPUTS + k)
        if place >= 0:
            native_step.keep(_field(real, place, shape), outputs.fields[k])
    for k in range(len(SCALARS)):
        real[_place(memory, OF_SCALARS + k)] = outputs.scalars[k]
    integer[_place(memory, OF_COUNTERS)] = iterations


# ---- entries


@compiled
def size(real: Array, integer: Array, memory: Array, numbers: Array):
    """Lengths for the grid that a block begins with: of the whole, where its state begins and how
    long that is, where faults are.

    Parameters
    ----------
    real, integer : ndarray
        Unused.
    memory : ndarray
        At least what is given.
    numbers : ndarray, shape (4,)
        Overwritten.
    """
    n_c = int(memory[COLUMNS])
    n_a = int(memory[ROWS])
    first, length = _state(n_c, n_a)
    numbers[WHOLE] = whole_size(n_c, n_a)
    numbers[FIRST_STATE] = first
    numbers[STATES] = length
    numbers[FIRST_FAULT] = whole_size(n_c, n_a) - ROOM


@compiled
def start(real: Array, integer: Array, memory: Array, numbers: Array):
    """State and outputs at the start; `numbers` unused."""
    block = block_of(memory)
    block.faults[0] = 0.0
    block.last_numbers[native_step.EULER_LENGTH] = 0.0
    take_numbers(real, integer, memory, block, True)
    shape = block.viscosity.shape
    outputs = new_outputs(shape)
    native_step.start(block, inputs_of(real, memory, shape), outputs)
    if block.faults[0] == 0.0:
        publish(outputs, 0, real, integer, memory)


@compiled
def advance(real: Array, integer: Array, memory: Array, numbers: Array):
    """One step; numbers: its length [s]."""
    block = block_of(memory)
    block.faults[0] = 0.0
    take_numbers(real, integer, memory, block, False)
    shape = block.viscosity.shape
    outputs = new_outputs(shape)
    iterations = native_step.advance(block, inputs_of(real, memory, shape), numbers[0], outputs)
    if block.faults[0] == 0.0:
        publish(outputs, iterations, real, integer, memory)


@compiled
def tangent(real: Array, integer: Array, memory: Array, numbers: Array):
    """Products of the seeds among the variables; `numbers` unused."""
    block = block_of(memory)
    block.faults[0] = 0.0
    n_c, n_a = block.viscosity.shape
    n = n_c * n_a
    first = _place(memory, OF_SEEDS)
    seeds = real[first : first + 2 * n].reshape((2, 1, n_c, n_a))
    first = _place(memory, OF_PRODUCTS)
    products = real[first : first + 2 * n].reshape((2, 1, n_c, n_a))
    native_step.tangent(block, seeds, products)


PART = NativePart(
    entries=tuple(Entry(kernel) for kernel in (size, start, advance, tangent)),
    given=given,
    uncovered=uncovered,
    covered=COVERED,
    faults=FAULTS,
    refusal="lubrication step to t = {a} s: ",
)
