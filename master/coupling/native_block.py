"""Memory of a coupled FMU without Python: rows of named tuples, see `master.fmi.block`."""

from collections.abc import Mapping, Sequence
from math import inf
from typing import Annotated, NamedTuple

import numpy as np

from ..fmi.block import (
    alike,
    flatten,
    parts,
    reader,
    room_of,
)
from ..fmi.compiled import compilable, compiled
from ..fmi.native_parts import NOWHERE, NativePart
from ..fmi.noted import DAMAGED_STATE, ROOM, numbers_of
from .methods import iteration
from .methods.krylov import KEPT_OF_COORDINATES, NOISE_OF_COORDINATES, Pairs, no_pairs
from .stepping import WITHOUT_PARTS
from .vector import TOO_LONG, Layout
from .wiring import Wire

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


class ParticipantRow(NamedTuple):
    """Participant; front/parts.c reads the first seven numbers.

    code : number of its code;
    real, reals, integer, integers, memory, memories : positions and lengths of its variables and
    its memory in the part `inside`;
    first_state, states, first_fault : positions in its memory, and length of the state;
    sentence : number of its first sentence;
    variables : number of real variables without seeds and products;
    setup, contents : length of the first part of its memory, and position in
    `CoupledSetup.contents`;
    saved : position in `CoupledState.saved`;
    first_coordinate, coordinates : position in its memory, and number of coordinates.
    """

    code: int
    real: int = 0
    reals: int = 0
    integer: int = 0
    integers: int = 0
    memory: int = 0
    memories: int = 0
    first_state: int = 0
    states: int = 0
    first_fault: int = 0
    sentence: int = 0
    variables: int = 0
    setup: int = 0
    contents: int = 0
    saved: int = 0
    first_coordinate: int = 0
    coordinates: int = 0


class WireRow(NamedTuple):
    """Wire.

    source_place, target_place, seed, product : positions among the real variables of both
    participants, NOWHERE if there is none; first, elements : its part of the vector; low, high :
    range of the input; columns : length of the last axis; sentence : number of its first sentence.
    """

    source: int
    source_place: int
    target: int
    target_place: int
    seed: int
    product: int
    first: int
    elements: int
    is_unknown: bool
    low: float = -inf
    high: float = inf
    columns: int = 1
    sentence: int = 0


class ExposedRow(NamedTuple):
    """Variable of the coupled FMU.

    place, own_place : positions among its variables and among those of the participant `owner`;
    reserved : position of its seed or product, NOWHERE if there is none.
    """

    is_integer: bool
    place: int
    owner: int
    own_place: int
    length: int
    reserved: int
    nominal: float


class Rules(NamedTuple):
    """Options of `Coupled`, `Stepper` and `Newton`.

    predicted : largest number of vectors of the predictor.
    """

    step: float
    lenience: float
    nudge: float
    predicted: int
    halvings: int
    max_iterations: int
    largest_krylov_space: int
    accuracy: float
    forcing: float


ExposedRows = Annotated[Array, "n, m"]


class ExposedVariables(NamedTuple):
    """Rows of the variables of the coupled FMU; limits : outputs as of `wiring.System`."""

    parameters: ExposedRows
    inputs: ExposedRows
    outputs: ExposedRows
    limits: ExposedRows


class CoupledSetup(NamedTuple):
    """First part of the memory.

    saved : number of elements of `CoupledState.saved`.
    owner : participant whose coordinates determine all unknowns, `NOWHERE` for none.
    order, starting : participants;
    participants, wires : rows; contents : of participants' memories and variables.
    """

    rules: Rules
    layout: Layout
    saved: int
    owner: int
    order: Annotated[Array, "count"]
    starting: Annotated[Array, "count"]
    participants: Annotated[Array, "count, m"]
    wires: Annotated[Array, "n, m"]
    exposed: ExposedVariables
    contents: Annotated[Array, "n"]


# ---- what changes


class CoupledState(NamedTuple):
    """State between macro steps.

    saved : variables and states of all participants; times, past : accepted vectors, the oldest
    first, of which the first `known` are valid; scale : of the owner's coordinates, 0 before it is
    computed; pairs : the last member, which a saved state omits.
    """

    saved: Annotated[Array, "saved"]
    known: Number
    times: Annotated[Array, "predicted"]
    past: Annotated[Array, "predicted, size"]
    scale: Annotated[Array, "coordinates"]
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

    setup: Vector
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
setup_from = reader(CoupledSetup)
put_state, state_from = flatten(CoupledState)
_has_lengths = alike(CoupledState)
put_last, last_from = flatten(LastMacroStep)


def lengths_of(setup: CoupledSetup, inside: int, reals: int):
    """Return the lengths of all parts after the first one, and the end that is not saved.

    inside : length of the part of this name; reals : number of real variables.
    """
    size, coordinates = len(setup.layout.nominal), coordinates_of(setup)
    pairs = nothing_yet(setup).pairs.products.shape
    state = _room_of_state(setup.saved, setup.rules.predicted, size, coordinates, *pairs)
    lengths = inside, state, state, _room_of_last(reals), ROOM, ROOM
    return lengths, _room_of_pairs(*pairs)


SOLVED, FOUND = 2, 3
"""Positions in the numbers of `native.iterate`, behind step and time: 1 if there is a solution, and
the first of what `find` notes.
"""
_room_of_state = room_of(CoupledState, "saved, predicted, size, coordinates, pairs, unknowns")
_room_of_pairs = room_of(Pairs, "pairs, unknowns")
_room_of_last = room_of(LastMacroStep, "reals")


def owner_of(wires: Sequence[Wire], layout: Layout, parts: Mapping[str, NativePart]) -> int:
    """Return the participant whose coordinates determine all unknowns, `NOWHERE` for none.

    Other elements follow from one evaluation to the next, unless they have a tolerance.

    parts : of all participants, in order.
    """
    unknown = [wire for wire, end in zip(wires, layout.ends) if end - 1 in layout.unknowns]
    owners = {wire.source[0] for wire in unknown}
    if len(owners) != 1 or np.isfinite(np.delete(layout.tolerance, layout.unknowns)).any():
        return NOWHERE
    (owner,) = owners
    part = parts[owner]
    has_all = part.coordinates != NOWHERE and not {w.source[1] for w in unknown} & {*part.direct}
    return list(parts).index(owner) if has_all else NOWHERE


@compilable
def coordinates_of(setup: CoupledSetup) -> int:
    """Return the number of coordinates of the owner, 0 without one."""
    owner = setup.owner
    return participant_from(setup.participants[owner]).coordinates if owner >= 0 else 0


def with_coordinates(layout: Layout, count: int) -> Layout:
    """Return a layout with elements for coordinates behind those of all wires."""
    nominal = np.concatenate([layout.nominal, np.ones(count)])
    tolerance = np.concatenate([layout.tolerance, np.full(count, inf)])
    return layout._replace(nominal=nominal, tolerance=tolerance)


@compilable
def nothing_yet(setup: CoupledSetup):
    """Return `CoupledState` before a start."""
    coordinates = coordinates_of(setup)
    pairs = no_pairs(len(setup.layout.unknowns))
    if coordinates > 0:
        pairs = no_pairs(coordinates, KEPT_OF_COORDINATES, NOISE_OF_COORDINATES)
    return CoupledState(
        saved=np.zeros(setup.saved),
        known=np.zeros(1),
        times=np.zeros(setup.rules.predicted),
        past=np.zeros((setup.rules.predicted, len(setup.layout.nominal))),
        scale=np.zeros(coordinates),
        pairs=pairs,
    )


@compiled
def is_state(row: np.ndarray, other: np.ndarray):
    """Return whether a row is that of a `CoupledState` as `other`, whose positions are valid."""
    if not _has_lengths(row, other):
        return False
    state = state_from(row)
    return 1.0 <= state.known[0] <= len(state.times)


@compiled
def setup_of(memory: np.ndarray):
    """Return `CoupledSetup`."""
    return setup_from(parts_of(memory).setup)


@compiled
def rules_of(memory: np.ndarray):
    """Return `Rules`; kernels that need no more compile faster."""
    return setup_of(memory).rules


@compiled
def state_of(memory: np.ndarray):
    """Return `CoupledState`."""
    return state_from(parts_of(memory).state)
