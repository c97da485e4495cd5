"""Participants and wires of a coupled slave without Python, as `interface` on rows of named tuples:
one evaluation of all participants, and its derivative.
"""

from typing import NamedTuple

import numpy as np
from numba import types

from ..fmi.block import keep
from ..fmi.compiled import compiled
from ..fmi.native_parts import CALL
from ..fmi.noted import refuse, take_over
from .evaluation import Evaluation
from .native_block import (
    FAULT,
    NOWHERE,
    ON_WIRE,
    Trail,
    WireRow,
    given_of,
    participant_from,
    parts_of,
    state_from,
    trail_from,
    wire_from,
)

START, ADVANCE, TANGENT = map(float, range(1, 4))
"""Entries by their number; 0 is size."""

native_part = types.ExternalFunction(
    CALL,
    types.int32(
        types.int64,
        types.CPointer(types.float64),
        types.CPointer(types.float64),
        types.CPointer(types.float64),
    ),
)
"""The one thing that a coupled slave's machine code asks of its library: an entry of a participant
(front/parts.c)."""


class System(NamedTuple):
    """Participants, in their stepping `order`, and wires; `standing` : where evaluations begin."""

    participants: np.ndarray
    wires: np.ndarray
    order: np.ndarray
    inside: np.ndarray
    standing: np.ndarray
    trail: Trail
    failures: np.ndarray
    faults: np.ndarray


@compiled
def system_of(memory: np.ndarray):
    """Return `System`."""
    parts = parts_of(memory)
    given = given_of(memory)
    return System(
        given.participants,
        given.wires,
        given.order,
        parts.inside,
        state_from(parts.state).standing,
        trail_from(parts.trail),
        parts.failures,
        parts.faults,
    )


# ---- participants


@compiled
def call(system: System, p: int, entry: float, numbers: np.ndarray, faults: np.ndarray):
    """Run an entry of the p-th participant, with four numbers; whether that went well, else its
    faults are put down. A remark, below 0 in the place of its first fault, is handed on.
    """
    row = system.participants[p]
    status = native_part(int(entry), row.ctypes, system.inside.ctypes, numbers.ctypes)
    if status != 0:
        refuse(faults, FAULT.no_memory, 0.0, 0.0, 0.0, 0.0, 0.0)
        return False
    one = participant_from(row)
    own = system.inside[one.memory + one.first_fault :]
    take_over(faults, own, float(one.sentence))
    if own[0] == 0.0 and system.faults[0] == 0.0 and own[1] < 0.0:
        system.faults[1] = own[1] - one.sentence
    return own[0] == 0.0


@compiled
def real_of(system: System, p: int):
    """Return real variables of the p-th participant, seeds and products behind them."""
    one = participant_from(system.participants[p])
    return system.inside[one.real : one.real + one.reals]


@compiled
def integer_of(system: System, p: int):
    """Return its integer variables."""
    one = participant_from(system.participants[p])
    return system.inside[one.integer : one.integer + one.integers].view(np.int64)


@compiled
def standing_of(system: System, p: int):
    """Return its variables and its state, and where both are saved."""
    one = participant_from(system.participants[p])
    first = one.memory + one.first_state
    middle = one.standing + one.variables
    return (
        system.inside[one.real : one.real + one.variables],
        system.inside[first : first + one.states],
        system.standing[one.standing : middle],
        system.standing[middle : middle + one.states],
    )


@compiled
def save(system: System):
    """Save variables and states of all participants."""
    for p in range(len(system.participants)):
        variables, state, saved_variables, saved_state = standing_of(system, p)
        keep(saved_variables, variables)
        keep(saved_state, state)


@compiled
def restore_one(system: System, p: int):
    """Restore a participant."""
    variables, state, saved_variables, saved_state = standing_of(system, p)
    keep(variables, saved_variables)
    keep(state, saved_state)


@compiled
def restore(system: System):
    """Restore all participants."""
    for p in range(len(system.participants)):
        restore_one(system, p)


# ---- wires


@compiled
def wire_of(system: System, w: int):
    """Return the w-th `WireRow`."""
    return wire_from(system.wires[w])


@compiled
def of_wire(wire: WireRow, x: np.ndarray):
    """Return its part of the vector of all wires."""
    return x[wire.first : wire.first + wire.elements]


@compiled
def variable_of(system: System, wire: WireRow, p: int, place: int):
    """Return the variable of a participant that begins at a place and has the wire's elements."""
    return real_of(system, p)[place : place + wire.elements]


@compiled
def read(system: System, wire: WireRow, y: np.ndarray):
    """Read what the source says into `y`."""
    keep(of_wire(wire, y), variable_of(system, wire, wire.source, wire.source_place))


@compiled
def feed(system: System, wire: WireRow, x: np.ndarray):
    """Set the target to its part of `x`."""
    keep(variable_of(system, wire, wire.target, wire.target_place), of_wire(wire, x))


@compiled
def is_fed_well(system: System, wire: WireRow, faults: np.ndarray):
    """Whether what a wire has set is finite and allowed; else its first fault is put down."""
    values = variable_of(system, wire, wire.target, wire.target_place)
    for k in range(len(values)):
        x = values[k]
        if not np.isfinite(x):
            refuse_element(faults, wire, k, ON_WIRE.must_be_finite, x, 0.0, 0.0)
            return False
        if not wire.low <= x <= wire.high:
            refuse_element(faults, wire, k, ON_WIRE.out_of_range, x, wire.low, wire.high)
            return False
    return True


@compiled
def refuse_element(
    faults: np.ndarray, wire: WireRow, k: int, which: float, a: float, b: float, c: float
):
    """Put down a fault of the k-th element of a wire."""
    i, j = k // wire.columns + 1, k % wire.columns + 1
    refuse(faults, wire.sentence + which, float(i), float(j), a, b, c)


@compiled
def evaluate(system: System, x: np.ndarray, time: float, step: float, at: Evaluation):
    """Step every participant once from what is saved, as `Interface.evaluate`; whether all of them
    took the step.

    Parameters
    ----------
    system : System
    x : ndarray, shape (size,)
        Iterate.
    time, step : float
        Of the macro step [s].
    at : Evaluation
        Overwritten.
    """
    keep(at.used, x)
    numbers = np.zeros(4)
    numbers[0] = step
    numbers[1] = time
    for k in range(len(system.order)):
        p = int(system.order[k])
        restore_one(system, p)
        for w in range(len(system.wires)):
            wire = wire_of(system, w)
            if wire.target == p:
                feed(system, wire, at.used)
                if not is_fed_well(system, wire, system.failures):
                    return False
        if not call(system, p, ADVANCE, numbers, system.failures):
            return False
        for w in range(len(system.wires)):
            wire = wire_of(system, w)
            if wire.source == p:
                read(system, wire, at.outputs)
                if wire.unknown == NOWHERE:
                    keep(of_wire(wire, at.used), of_wire(wire, at.outputs))
    # an element that is fed back was used as in x, another one as in the outputs
    keep(at.residual, at.outputs - x)
    return True


@compiled
def derivative(system: System, change: np.ndarray, result: np.ndarray):
    """The evaluation linearised at the last step of every participant, as `Interface.derivative`;
    whether all of them answered.
    """
    system.trail.products[0] += 1.0
    seen = np.zeros(len(change))
    keep(result, seen)
    for w in range(len(system.wires)):
        wire = wire_of(system, w)
        if wire.unknown != NOWHERE:
            keep(of_wire(wire, seen), of_wire(wire, change))
    numbers = np.zeros(4)
    for k in range(len(system.order)):
        p = int(system.order[k])
        real = real_of(system, p)
        seeds = real[participant_from(system.participants[p]).variables :]
        keep(seeds, np.zeros(len(seeds)))
        reads = False
        writes = False
        for w in range(len(system.wires)):
            wire = wire_of(system, w)
            writes = writes or wire.source == p
            if wire.target == p:
                reads = True
                if wire.seed != NOWHERE:
                    keep(variable_of(system, wire, p, wire.seed), of_wire(wire, seen))
        if not (reads and writes):
            continue  # nothing depends on it, or it depends on nothing
        if not call(system, p, TANGENT, numbers, system.failures):
            return False
        for w in range(len(system.wires)):
            wire = wire_of(system, w)
            if wire.source == p:
                keep(of_wire(wire, result), variable_of(system, wire, p, wire.product))
                if wire.unknown == NOWHERE:
                    keep(of_wire(wire, seen), of_wire(wire, result))
    return True


# ---- norms


@compiled
def measure(system: System, residual: np.ndarray):
    """Largest share of an element's residual in its wire's tolerance: converged at 1 and below, NaN
    if any is not finite. The largest of every wire goes to the trail; where that is full, in the
    place of the last.
    """
    trail = system.trail
    row = min(int(trail.evaluations[0]), len(trail.measures) - 1)
    trail.evaluations[0] += 1.0
    found = 0.0
    for w in range(len(system.wires)):
        wire = wire_of(system, w)
        largest = np.max(np.abs(of_wire(wire, residual))) / wire.tolerance
        if np.isnan(largest):
            return largest
        trail.measures[row, w] = largest
        found = max(found, largest)
    return found


@compiled
def note_worst(system: System, residual: np.ndarray):
    """Put down which wire is worst, and its largest residual."""
    largest = -1.0
    worst = wire_of(system, 0)
    element = 0
    for w in range(len(system.wires)):
        wire = wire_of(system, w)
        values = of_wire(wire, residual)
        for k in range(len(values)):
            share = abs(values[k]) / wire.tolerance
            share = np.inf if np.isnan(share) else share
            if share > largest:
                largest = share
                worst = wire
                element = k
    x = float(residual[worst.first + element])
    refuse_element(system.failures, worst, element, ON_WIRE.worst, x, worst.tolerance, 0.0)


@compiled
def moved(system: System, x: np.ndarray, change: np.ndarray):
    """x + share * change, no further than `largest_decrease` of the wires allows, as
    `methods.step_length`.
    """
    share = 1.0
    for w in range(len(system.wires)):
        wire = wire_of(system, w)
        if wire.largest_decrease == NOWHERE:
            continue
        values = of_wire(wire, x)
        moves = of_wire(wire, change)
        smallest = np.min(values)
        floor = smallest - wire.largest_decrease * max(smallest, wire.nominal / 10)
        for k in range(len(values)):
            if moves[k] < 0.0:
                share = min(share, (values[k] - floor) / -moves[k])
    return x + share * change


# ---- unknowns


@compiled
def scatter(system: System, reduced: np.ndarray, change: np.ndarray):
    """Set the unknowns among a change of the whole vector to scaled ones."""
    for w in range(len(system.wires)):
        wire = wire_of(system, w)
        if wire.unknown != NOWHERE:
            own = reduced[wire.unknown : wire.unknown + wire.elements]
            keep(of_wire(wire, change), own * wire.nominal)


@compiled
def gather(system: System, whole: np.ndarray, reduced: np.ndarray):
    """Set scaled unknowns to those among the whole vector."""
    for w in range(len(system.wires)):
        wire = wire_of(system, w)
        if wire.unknown != NOWHERE:
            own = reduced[wire.unknown : wire.unknown + wire.elements]
            keep(own, of_wire(wire, whole) / wire.nominal)


@compiled
def tolerances(system: System, whole: np.ndarray):
    """Set every element of the vector to its wire's tolerance."""
    for w in range(len(system.wires)):
        wire = wire_of(system, w)
        own = of_wire(wire, whole)
        keep(own, np.full(len(own), wire.tolerance))
