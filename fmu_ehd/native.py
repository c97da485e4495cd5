"""Lubrication FMU that needs no Python: its entries, its memory and its limits.

An entry takes the slave's real and integer variables, as `master.fmi.slave` lays them out, and its
memory of float64 numbers (`native_step`).
"""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ..master.fmi.block import memory_of, room, row_of
from ..master.fmi.compiled import compiled
from ..master.fmi.native_parts import Entry, NativePart, tell_size
from ..master.fmi.noted import ROOM
from ..master.fmi.slave import PRODUCT, SEED, reserved
from . import state, step, step_tangent
from .balance.grid import Array, keep
from .balance.oil_layer import skirt_edges
from .contradictions import FROM_EDGES, FULL_TURN
from .faults import FAULT, FAULTS, refuse
from .laws.asperity import CONTACT_LAWS, contact_table
from .laws.piezoviscosity import PressureLaw
from .laws.roughness import TABLE as FACTOR_TABLE
from .native_step import (
    INITIAL_FILM_FRACTION,
    ROOM_ON_BORE,
    SECTOR_ANGLE,
    STROKES,
    FilmSetup,
    InputPositions,
    Solver,
    VariablePositions,
    block_of,
    check_supply,
    clear_solver,
    domain_of,
    factors_of,
    filled,
    fixed_of,
    is_memory,
    is_sound,
    last_of,
    linear_of,
    memory_of_state,
    parts_of,
    put_last,
    put_linear,
    put_memory,
    set_up,
    surroundings_of,
    warm,
)
from .options import BuildOptions
from .parameters import CHOICES, CHOSEN, NUMBERS, TUNABLE
from .state import Fields, Inputs, Scalars
from .step_tangent import FORCE, Directions
from .summary import halves

NOWHERE = -1
COUNTS = np.array([len(CHOICES[name]) for name in CHOSEN], float)
"""Numbers of alternatives of each choice, which a file may exceed."""
WIDEST = 192  # cells around: beyond, sparse solvers of scipy are faster

# ---- what the memory begins with


def given(slave: Any) -> Array:
    """Return the constant part of the memory of an FMU.

    Parameters
    ----------
    slave : slave.Ehd
    """
    built = BuildOptions.read(slave.options)
    n_c, n_a = built.grid
    cut = built.open_cells
    faces = skirt_edges(np.zeros((n_c, n_a), dtype=bool) if cut is None else cut)
    field = np.zeros((n_c, n_a))
    lengths = dict(n_c=n_c, n_a=n_a, n_e=len(faces), n_b=ROOM_ON_BORE * n_a)
    block = FilmSetup(
        places=_places(slave),
        follows=np.array([float(name in TUNABLE) for name in NUMBERS]),
        bearing=built.surface == "bearing",
        tables=np.array([contact_table(law) for law in CONTACT_LAWS]),
        share=halves(n_c).share,
        sine=halves(n_c).sine,
        mask=field + 1.0 if cut is None else (~cut).astype(float),
        faces=faces,
        beside=field,
        numbers=np.zeros(len(NUMBERS)),
        chosen=np.zeros(len(CHOSEN)),
        temperature=field,
        viscosity=field,
        factors=np.zeros(FACTOR_TABLE),
        law=np.zeros(room(PressureLaw)),
        has_last=np.zeros(1),
        has_linear=np.zeros(1),
    )
    return memory_of(
        {"given": row_of(block)},
        {
            "state": room(state.Memory, **lengths),
            "begun": room(state.Memory, **lengths),
            "last": room(state.LastStep, **lengths),
            "linear": room(step_tangent.Linearisation, **lengths),
            "solver": room(Solver, **lengths),
            "faults": ROOM,
        },
    )


def _places(slave) -> VariablePositions:
    """Return where everything lies among a slave's variables."""

    def place(name, kind=""):
        return slave.references.get(reserved(kind, name) if kind else name, NOWHERE)

    def each(names):
        return np.array([place(name) for name in names], dtype=float)

    return VariablePositions(
        each(NUMBERS),
        each(CHOSEN),
        InputPositions(*(place(name) for name in InputPositions._fields)),
        each(Fields._fields),
        each(Scalars._fields),
        place("solver_iterations"),
        place(slave.derivative_inputs[0], SEED),
        place(slave.derivative_outputs[0], PRODUCT),
    )


def uncovered(options: Mapping[str, Any]) -> Iterable[str]:
    """Sentences on build options, checked or as given, that the library does not cover."""
    match options.get("grid"):
        case [int(n_c), int(n_a)] if n_c > WIDEST:
            yield f"grid: expected at most {WIDEST} cells around in a native FMU, got {n_c} x {n_a}"


def uncovered_values(values: Mapping[str, Any]) -> Iterable[str]:
    """Sentences on parameters that the library has no room for."""
    room = STROKES * values["skirt_length"]
    if values["oil_supply"] != FROM_EDGES and values["stroke"] > room:
        yield (
            f"stroke: expected at most {room:g} m for skirt_length = {values['skirt_length']:g} m "
            f"in a native FMU, got {values['stroke']:g} m"
        )


# ---- between variables and block


@compiled
def _field(real, place, shape):
    """Return a field among the variables."""
    n_c, n_a = shape
    return real[place : place + n_c * n_a].reshape((n_c, n_a))


@compiled
def _input(real, block, place, domain):
    """Return an input field, without values in cells that have no film."""
    n_c, n_a = block.mask.shape
    field = _field(real, place, block.mask.shape)
    return filled(block, field.reshape((1, n_c, n_a)), domain)[0]


@compiled
def inputs_of(real, block, domain, length):
    """`state.Inputs` for a step of a length [s]."""
    places = block.places.inputs
    turning = np.zeros(block.mask.shape)
    if block.bearing:
        turning = _input(real, block, places.circumferential_velocity, domain)
    return Inputs(
        _input(real, block, places.film_thickness, domain),
        _input(real, block, places.sliding_velocity, domain),
        turning,
        surroundings_of(block),
        length,
    )


@compiled
def take_numbers(real, integer, block, length, faults):
    """Take parameters from the variables, and note what contradicts.

    For a step of a length [s] only those that may change are taken.
    """
    faults[0] = 0.0
    faults[1] = 0.0  # no remark
    block.has_last[0] = 0.0  # a refused step has no tangent
    places = block.places
    all_of_them = length == 0.0
    changed = all_of_them
    for k in range(len(NUMBERS)):
        place = int(places.numbers[k])
        if place >= 0 and (all_of_them or block.follows[k] != 0.0):
            block.numbers[k] = real[place]
            changed = True
    if all_of_them:
        if places.numbers[SECTOR_ANGLE] < 0.0:
            block.numbers[SECTOR_ANGLE] = FULL_TURN
        for k in range(len(CHOSEN)):
            chosen = float(integer[int(places.chosen[k])])
            block.chosen[k] = min(max(chosen, 1.0), COUNTS[k])
        set_up(block, faults)
    if changed:
        check_supply(block, faults)
    if places.inputs.oil_temperature >= 0:
        warm(block, _input(real, block, places.inputs.oil_temperature, domain_of(block)))
    elif changed:
        warm(block, np.zeros((0, 0)))


@compiled
def publish(fields, scalars, iterations, real, integer, places):
    """Write the outputs into the variables."""
    shape = fields[0].shape
    for k in range(len(fields)):
        if places.fields[k] >= 0.0:
            keep(_field(real, int(places.fields[k]), shape), fields[k])
    for k in range(len(scalars)):
        if places.scalars[k] >= 0.0:
            real[int(places.scalars[k])] = scalars[k]
    integer[places.solver_iterations] = int(iterations)


# ---- entries


@compiled
def size(real: Array, integer: Array, memory: Array, numbers: Array):
    """Write the head of the memory into `numbers`, as `tell_size`."""
    tell_size(memory, numbers, is_sound(real, integer, memory))


@compiled
def start(real: Array, integer: Array, memory: Array, numbers: Array):
    """State and outputs at the start; `numbers` unused."""
    parts = parts_of(memory)
    faults = parts.faults
    block = block_of(memory)
    clear_solver(memory, block)
    take_numbers(real, integer, block, 0.0, faults)
    if faults[0] > 0.0:
        return
    fixed = fixed_of(block, True)
    inputs = inputs_of(real, block, fixed.domain, 0.0)
    initial = block.numbers[INITIAL_FILM_FRACTION]
    begun, fields, scalars = step.start(fixed, inputs, initial, faults)
    if faults[0] > 0.0:
        return
    put_memory(parts.state, begun)
    keep(parts.begun, parts.state)
    publish(fields, scalars, 0.0, real, integer, block.places)


@compiled
def advance(real: Array, integer: Array, memory: Array, numbers: Array):
    """Take a step; the first of `numbers` is its length [s].

    If the step is rejected, the fault is noted and the state stays.
    """
    parts = parts_of(memory)
    faults = parts.faults
    block = block_of(memory)
    take_numbers(real, integer, block, numbers[0], faults)
    if faults[0] > 0.0:
        return
    fixed = fixed_of(block, True)
    inputs = inputs_of(real, block, fixed.domain, numbers[0])
    if not is_memory(parts.state, parts.begun):
        refuse(faults, FAULT.other_state, 0, 0, 0.0, 0.0, 0.0)
        return
    before = memory_of_state(parts.state.copy())
    begun = step.begin(fixed, before, inputs, faults)
    if faults[0] > 0.0:
        return
    solved = step.solve(fixed, before, inputs, begun, factors_of(memory), faults)
    if faults[0] > 0.0:
        return
    ended = step.end(fixed, before, inputs, begun, solved, faults)
    if faults[0] > 0.0:
        return
    put_memory(parts.state, ended.memory)
    put_last(parts.last, ended.last)
    block.has_last[0] = 1.0
    block.has_linear[0] = 0.0
    iterations = float(ended.iterations)
    publish(ended.fields, ended.scalars, iterations, real, integer, block.places)


@compiled
def tangent(real: Array, integer: Array, memory: Array, numbers: Array):
    """Products of the seeds among the variables; `numbers` unused."""
    parts = parts_of(memory)
    faults = parts.faults
    faults[0] = 0.0
    block = block_of(memory)
    if block.has_last[0] == 0.0:
        refuse(faults, FAULT.no_tangent, 0, 0, 0.0, 0.0, 0.0)
        return
    fixed = fixed_of(block, False)
    last = last_of(parts.last)
    if block.has_linear[0] == 0.0:
        put_linear(parts.linear, step_tangent.linearise(fixed, last))
        block.has_linear[0] = 1.0
    linear = linear_of(parts.linear)
    n_c, n_a = block.mask.shape
    directions = 3 if block.bearing else 2
    n = directions * n_c * n_a
    first = block.places.seeds
    seeds = real[first : first + n].reshape((directions, 1, n_c, n_a))
    first = block.places.products
    products = real[first : first + n].reshape((directions, 1, n_c, n_a))
    domain = fixed.domain
    turning = np.zeros((0, 0, 0))
    if block.bearing:
        turning = filled(block, seeds[FORCE.around], domain)
    seeded = Directions(
        filled(block, seeds[FORCE.normal], domain),
        filled(block, seeds[FORCE.along], domain),
        turning,
    )
    right = np.empty((1, n_c, n_a))
    step_tangent.changes(fixed, last, linear, seeded, factors_of(memory), right, products)


PART = NativePart(
    entries=tuple(Entry(kernel) for kernel in (size, start, advance, tangent)),
    given=given,
    uncovered=uncovered,
    faults=FAULTS,
    refusal="lubrication step to t = {a} s: ",
    uncovered_ahead=uncovered,
    uncovered_values=uncovered_values,
)
