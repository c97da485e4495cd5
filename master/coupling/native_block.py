"""Memory of a coupled FMU without Python: rows of named tuples, see `master.fmi.block`."""

from math import inf
from typing import Annotated, NamedTuple

import numpy as np

from ..fmi.block import (
    alike,
    checker,
    flatten,
    given_part,
    is_finite,
    is_head,
    parts,
    reader,
    room_of,
)
from ..fmi.compiled import compilable, compiled
from ..fmi.noted import DAMAGED_STATE, ROOM, numbers_of
from .methods import iteration
from .methods.krylov import KEPT, Pairs, no_pairs
from .stepping import WITHOUT_PARTS
from .vector import TOO_LONG, Layout

Array = np.ndarray
Vector = Annotated[Array, "n"]
Number = Annotated[Array, "1"]
"""An array of one, for what changes."""

SENTENCES = {
    **iteration.SENTENCES,
    "no_halving": "t = {a} s, step {b} s, and no halving is left",
    "no_memory": "there is not enough memory for a participant's step",
    "no_step": "there was no step to take a derivative of",
    "other_state": DAMAGED_STATE,
    "too_long": TOO_LONG,
    "without_parts": WITHOUT_PARTS,
}
FAULT = numbers_of(SENTENCES)
"""Numbers of the coupling's sentences."""
WIRE_SENTENCES = ("worst", "must_be_finite", "out_of_range")
ON_WIRE = numbers_of(WIRE_SENTENCES)
"""Numbers of the sentences of a wire, after its first one."""

# ---- what is given


Count = Annotated[int, "x >= 0"]


class ParticipantRow(NamedTuple):
    """Participant; front/parts.c reads the first seven numbers.

    code : number of its code;
    real, reals, integer, integers, memory, memories : positions and lengths of its variables and
    its memory in the part `inside`;
    first_state, states, first_fault : positions in its memory, and length of the state;
    sentence : number of its first sentence;
    variables : number of real variables without seeds and products;
    given, contents : length of the first part of its memory, and position in
    `CoupledSetup.contents`;
    standing : position in `CoupledState.standing`.
    """

    code: Count
    real: Annotated[int, "x == begin"] = 0
    reals: Count = 0
    integer: Annotated[int, "x == real + reals"] = 0
    integers: Count = 0
    memory: Annotated[int, "x == integer + integers"] = 0
    memories: Count = 0
    first_state: Annotated[int, "has_room(x, states, memories)"] = 0
    states: Count = 0
    first_fault: Annotated[int, f"has_room(x, {ROOM}, memories)"] = 0
    sentence: Count = 0
    variables: Annotated[int, "0 <= x <= reals"] = 0
    given: Annotated[int, "0 <= x <= memories"] = 0
    contents: Annotated[int, "x == filled"] = 0
    standing: Annotated[int, "x == stood"] = 0


class WireRow(NamedTuple):
    """Wire.

    source_place, target_place, seed, product : positions among the real variables of both
    participants, NOWHERE if there is none; first, elements : its part of the vector; low, high :
    range of the input; columns : length of the last axis; sentence : number of its first sentence.
    """

    source: Annotated[int, "0 <= x < len(participants)"]
    source_place: Annotated[int, "has_room(x, elements, reals_of(participants, source))"]
    target: Annotated[int, "0 <= x < len(participants)"]
    target_place: Annotated[int, "has_room(x, elements, reals_of(participants, target))"]
    seed: Annotated[int, "x == -1 or has_room(x, elements, reals_of(participants, target))"]
    product: Annotated[
        int,
        "x == -1 and not is_fed or has_room(x, elements, reals_of(participants, source))",
    ]
    first: Annotated[int, "x == begin"]
    elements: Annotated[int, "x >= 0 and first + x == end"]
    is_unknown: bool
    low: Annotated[float, "not np.isnan(x)"] = -inf
    high: Annotated[float, "not np.isnan(x)"] = inf
    columns: Annotated[int, "x > 0"] = 1
    sentence: Count = 0


class ExposedRow(NamedTuple):
    """Variable of the coupled FMU.

    place, own_place : positions among its variables and among those of the participant `owner`;
    reserved : position of its seed or product, NOWHERE if there is none.
    """

    is_integer: bool
    place: Annotated[int, "has_room(x, length, integers if is_integer else reals)"]
    owner: Annotated[int, "0 <= x < len(participants)"]
    own_place: Annotated[int, "has_room(x, length, own_end(participants, owner, is_integer))"]
    length: Count
    reserved: Annotated[int, "x == -1 or not is_integer and has_room(x, length, reals)"]
    nominal: float


class Rules(NamedTuple):
    """Options of `Coupled`, `Stepper` and `Newton`.

    predicted : largest number of vectors of the predictor.
    """

    step: float
    lenience: float
    nudge: float
    predicted: Annotated[int, "0 < x <= 10"]
    halvings: Annotated[int, "0 <= x <= 30"]
    max_iterations: Annotated[int, "0 < x <= 10000"]
    largest_krylov_space: Annotated[int, "0 <= x <= 10000"]
    accuracy: float
    forcing: float


ExposedRows = Annotated[Array, "n, m", "are_exposed(x, participants, reals, integers)"]


class ExposedVariables(NamedTuple):
    """Rows of the variables of the coupled FMU; limits : outputs as of `wiring.System`."""

    parameters: ExposedRows
    inputs: ExposedRows
    outputs: ExposedRows
    limits: ExposedRows


class CoupledSetup(NamedTuple):
    """First part of the memory.

    standing, pairs : elements of `CoupledState.standing`; pairs of GMRES.
    order, starting : participants;
    participants, wires : rows; contents : of participants' memories and variables.
    """

    rules: Rules
    layout: Layout
    standing: Count
    pairs: Annotated[int, f"x == min({KEPT}, len(layout.unknowns))"]
    order: Annotated[Array, "count", "within(x, 0.0, count)"]
    starting: Annotated[Array, "count", "within(x, 0.0, count)"]
    participants: Annotated[Array, "count, m", "are_participants(x, standing, contents)"]
    wires: Annotated[Array, "n, m", "are_wires(x, participants, layout.ends, layout.size)"]
    exposed: ExposedVariables
    contents: Annotated[Array, "n", "True"]


# ---- what changes


class CoupledState(NamedTuple):
    """State between macro steps.

    standing : variables and states of all participants; times, past : accepted vectors, the oldest
    first, of which the first `known` are valid; pairs : the last member, which a saved state omits.
    """

    standing: Annotated[Array, "standing"]
    known: Number
    times: Annotated[Array, "predicted"]
    past: Annotated[Array, "predicted, size"]
    pairs: Pairs


class LastMacroStep(NamedTuple):
    """Last step, or start, of which a derivative is computed.

    is_there : whether there is one; step : 0 for a start; real : variables of the coupled FMU.
    """

    is_there: bool
    time: float
    step: float
    real: Annotated[Array, "reals"]


class CoupledMemory(NamedTuple):
    """Parts of the memory.

    They are rows of `CoupledSetup`, `CoupledState` and `LastMacroStep`, and others.
    inside : variables and memories of the participants; before : state at the begin of the step.
    """

    given: Vector
    inside: Vector
    state: Vector
    before: Vector
    last: Vector
    failures: Vector
    faults: Vector


parts_of = parts(CoupledMemory)
_, participant_from = flatten(ParticipantRow)
_, wire_from = flatten(WireRow)
_, exposed_from = flatten(ExposedRow)
given_from = reader(CoupledSetup)
put_state, state_from = flatten(CoupledState)
_has_lengths = alike(CoupledState)
put_last, last_from = flatten(LastMacroStep)


# ---- what a file may hold


@compilable
def own_end(participants: Array, p: int, is_integer: bool):
    """Return the number of real or integer variables of a participant."""
    one = participant_from(participants[p])
    return one.integers if is_integer else one.reals


@compilable
def reals_of(participants: Array, p: int):
    """Return the number of real variables of a participant, 0 if there is none of this number."""
    return own_end(participants, p, False) if 0 <= p < len(participants) else 0


_check_participant = checker(ParticipantRow, "begin, filled, stood")
_check_wire = checker(WireRow, "participants, is_fed, begin, end", reals_of=reals_of)
_check_exposed = checker(ExposedRow, "participants, reals, integers", own_end=own_end)


@compilable
def are_participants(rows: Array, standing: int, contents: Array):
    """Return whether all `ParticipantRow` are consecutive, and their real variables finite."""
    begin = 0
    filled = 0
    stood = 0
    for p in range(len(rows)):
        if _check_participant(rows[p], begin, filled, stood) != rows.shape[1]:
            return False
        one = participant_from(rows[p])
        begin = one.memory + one.memories
        first = filled + one.given
        filled = first + one.reals + one.integers
        stood += one.variables + one.states
        if filled > len(contents) or not is_finite(contents[first : first + one.reals]):
            return False
    return begin > 0 and filled == len(contents) and stood == standing


@compilable
def are_wires(rows: Array, participants: Array, ends: Array, size: int):
    """Return whether all `WireRow` are consecutive."""
    begin = 0
    if len(rows) != len(ends):
        return False
    for w in range(len(rows)):
        is_fed = False
        for other in range(len(rows)):
            is_fed = is_fed or rows[other, TARGET] == rows[w, 0]
        end = int(ends[w])
        if _check_wire(rows[w], participants, is_fed, begin, end) != rows.shape[1]:
            return False
        begin = end
    return begin == size


TARGET = WireRow._fields.index("target")


@compilable
def are_exposed(rows: Array, participants: Array, reals: int, integers: int):
    """Return whether all `ExposedRow` point to variables."""
    for k in range(len(rows)):
        if _check_exposed(rows[k], participants, reals, integers) != rows.shape[1]:
            return False
    return True


@compilable
def lengths_of(given: CoupledSetup, inside: int, reals: int):
    """Return the lengths of all parts after the first one, and the end that is not saved.

    inside : length of the part of this name; reals : number of real variables.
    """
    size, unknowns = len(given.layout.nominal), len(given.layout.unknowns)
    state = _room_of_state(given.standing, given.rules.predicted, size, given.pairs, unknowns)
    lengths = inside, state, state, _room_of_last(reals), int(ROOM), int(ROOM)
    return lengths, _room_of_pairs(given.pairs, unknowns)


_check = checker(
    CoupledSetup,
    "reals, integers",
    are_participants=are_participants,
    are_wires=are_wires,
    are_exposed=are_exposed,
)
SOLVED, FOUND = 2, 3
"""Positions in the numbers of `native.iterate`, behind step and time: 1 if there is a solution, and
the first of what `find` notes.
"""
PARTS = float(len(CoupledMemory._fields))
_room_of_state = room_of(CoupledState, "standing, predicted, size, pairs, unknowns")
_room_of_pairs = room_of(Pairs, "pairs, unknowns")
_room_of_last = room_of(LastMacroStep, "reals")


@compilable
def is_sound(real: Array, integer: Array, memory: Array):
    """Return whether a memory from a file has no position or length out of range.

    The contents of the participants are not checked.
    """
    row = given_part(memory, PARTS, _check, len(real), len(integer))
    if len(row) == 0:
        return False
    given = given_from(row)
    end = participant_from(given.participants[len(given.participants) - 1])
    lengths, unsaved = lengths_of(given, end.memory + end.memories, len(real))
    return is_head(memory, lengths, 1.0, unsaved)


@compilable
def nothing_yet(given: CoupledSetup):
    """Return `CoupledState` before a start."""
    return CoupledState(
        np.zeros(given.standing),
        np.zeros(1),
        np.zeros(given.rules.predicted),
        np.zeros((given.rules.predicted, len(given.layout.nominal))),
        no_pairs(len(given.layout.unknowns)),
    )


@compiled
def is_state(row: np.ndarray, other: np.ndarray):
    """Return whether a row is that of a `CoupledState` as `other`, whose positions are valid."""
    if not _has_lengths(row, other):
        return False
    state = state_from(row)
    return 1.0 <= state.known[0] <= len(state.times)


@compiled
def given_of(memory: np.ndarray):
    """Return `CoupledSetup`."""
    return given_from(parts_of(memory).given)


@compiled
def rules_of(memory: np.ndarray):
    """Return `Rules`; kernels that need no more compile faster."""
    return given_of(memory).rules


@compiled
def state_of(memory: np.ndarray):
    """Return `CoupledState`."""
    return state_from(parts_of(memory).state)
