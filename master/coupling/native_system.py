"""Participants and wires of a coupled FMU without Python, as `interface`."""

from typing import NamedTuple

import numpy as np
from numba import types

from ..fmi.block import keep
from ..fmi.compiled import compiled
from ..fmi.native_parts import NOWHERE
from ..fmi.noted import refuse, take_over
from .methods.iteration import NONE, Answer, converge
from .native_block import (
    FAULT,
    ON_WIRE,
    WireRow,
    participant_from,
    parts_of,
    rules_of,
    setup_of,
    state_of,
    wire_from,
)
from .vector import Evaluation, Layout, largest

START, ADVANCE, TANGENT = map(float, range(3))
"""Entries by their number."""

native_part = types.ExternalFunction(
    "native_part",
    types.int32(
        types.int64,
        types.CPointer(types.float64),
        types.CPointer(types.float64),
        types.CPointer(types.float64),
    ),
)
"""Function of the library that runs an entry of a participant (front/parts.c)."""


class System(NamedTuple):
    """Participants and wires; order : stepping order; saved : saved variables and states."""

    layout: Layout
    participants: np.ndarray
    wires: np.ndarray
    order: np.ndarray
    inside: np.ndarray
    saved: np.ndarray
    failures: np.ndarray
    faults: np.ndarray


@compiled
def system_of(memory: np.ndarray):
    """Return `System`."""
    parts = parts_of(memory)
    setup = setup_of(memory)
    return System(
        layout=setup.layout,
        participants=setup.participants,
        wires=setup.wires,
        order=setup.order,
        inside=parts.inside,
        saved=state_of(memory).saved,
        failures=parts.failures,
        faults=parts.faults,
    )


# ---- participants


@compiled
def call(system: System, p: int, entry: float, numbers: np.ndarray, faults: np.ndarray):
    """Run an entry of the p-th participant with four numbers; return False and note its faults.

    A warning, which is a negative number at its first fault, is noted too.
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
    """Return the real variables of the p-th participant, then seeds and products."""
    one = participant_from(system.participants[p])
    return system.inside[one.real : one.real + one.reals]


@compiled
def integer_of(system: System, p: int):
    """Return the integer variables of the p-th participant."""
    one = participant_from(system.participants[p])
    return system.inside[one.integer : one.integer + one.integers].view(np.int64)


@compiled
def saved_of(system: System, p: int):
    """Return variables and state of the p-th participant, and the saved ones."""
    one = participant_from(system.participants[p])
    first = one.memory + one.first_state
    middle = one.saved + one.variables
    return (
        system.inside[one.real : one.real + one.variables],
        system.inside[first : first + one.states],
        system.saved[one.saved : middle],
        system.saved[middle : middle + one.states],
    )


@compiled
def save(system: System):
    """Save variables and states of all participants."""
    for p in range(len(system.participants)):
        variables, state, saved_variables, saved_state = saved_of(system, p)
        keep(saved_variables, variables)
        keep(saved_state, state)


@compiled
def restore_one(system: System, p: int):
    """Restore a participant."""
    variables, state, saved_variables, saved_state = saved_of(system, p)
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
    """Return the part of a wire in a vector."""
    return x[wire.first : wire.first + wire.elements]


@compiled
def variable_of(system: System, wire: WireRow, p: int, place: int):
    """Return the variable of a participant at a position, with the wire's elements."""
    return real_of(system, p)[place : place + wire.elements]


@compiled
def read(system: System, wire: WireRow, y: np.ndarray):
    """Copy the output of the source into `y`."""
    keep(of_wire(wire, y), variable_of(system, wire, wire.source, wire.source_place))


@compiled
def feed(system: System, wire: WireRow, x: np.ndarray):
    """Set the target to its part of `x`."""
    keep(variable_of(system, wire, wire.target, wire.target_place), of_wire(wire, x))


@compiled
def is_fed_well(system: System, wire: WireRow, faults: np.ndarray):
    """Return whether the input of a wire is finite and in its range; note its first fault."""
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
    """Note a fault of the k-th element of a wire."""
    i, j = k // wire.columns + 1, k % wire.columns + 1
    refuse(faults, wire.sentence + which, float(i), float(j), a, b, c)


class Step(NamedTuple):
    """Macro step of a system: begin and length [s].

    trail : ndarray, shape (evaluations, wires), measures of the wires; evaluations beyond are not
    recorded. evaluations : ndarray, shape (1,), their number so far.
    """

    system: System
    time: float
    length: float
    trail: np.ndarray
    evaluations: np.ndarray


@compiled
def step_all(step: Step, used: np.ndarray, outputs: np.ndarray):
    """Step every participant once from its saved state, as `Interface.evaluate`.

    Parameters
    ----------
    step : Step
    used : ndarray, shape (size,)
        Iterate; the elements that are no unknowns are set to the outputs.
    outputs : ndarray, shape (size,)
        Written.

    Returns
    -------
    bool
        Whether all participants took the step.
    """
    system = step.system
    numbers = np.zeros(4)
    numbers[0] = step.length
    numbers[1] = step.time
    for k in range(len(system.order)):
        p = int(system.order[k])
        restore_one(system, p)
        for w in range(len(system.wires)):
            wire = wire_of(system, w)
            if wire.target == p:
                feed(system, wire, used)
                if not is_fed_well(system, wire, system.failures):
                    return False
        if not call(system, p, ADVANCE, numbers, system.failures):
            return False
        for w in range(len(system.wires)):
            wire = wire_of(system, w)
            if wire.source == p:
                read(system, wire, outputs)
                if not wire.is_unknown:
                    keep(of_wire(wire, used), of_wire(wire, outputs))
    return True


@compiled
def evaluate(step: Step, x: np.ndarray):
    """Return the `Answer` of all participants to an iterate."""
    used = x.copy()
    outputs = np.zeros(len(x))
    is_answered = step_all(step, used, outputs)
    # an element that is fed back was used as in x, another one as in the outputs
    at = Evaluation(used, outputs, outputs - x)
    tolerance = step.system.layout.tolerance
    shares = np.abs(at.residual) / tolerance
    measure = largest(shares) if is_answered else -1.0
    k = int(step.evaluations[0])
    if is_answered and k < len(step.trail):
        begin = 0
        for w, end in enumerate(step.system.layout.ends):
            step.trail[k, w] = largest(shares[begin:end])
            begin = end
        step.evaluations[0] = k + 1.0
    return Answer(at, measure, tolerance)


@compiled
def derivative(step: Step, change: np.ndarray, result: np.ndarray):
    """Linearise an evaluation, as `Interface.derivative`; return whether all of them answered."""
    system = step.system
    input_change = np.zeros(len(change))
    keep(result, input_change)
    for w in range(len(system.wires)):
        wire = wire_of(system, w)
        if wire.is_unknown:
            keep(of_wire(wire, input_change), of_wire(wire, change))
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
                    keep(variable_of(system, wire, p, wire.seed), of_wire(wire, input_change))
        if not (reads and writes):
            continue  # nothing depends on it, or it depends on nothing
        if not call(system, p, TANGENT, numbers, system.failures):
            return False
        for w in range(len(system.wires)):
            wire = wire_of(system, w)
            if wire.source == p:
                keep(of_wire(wire, result), variable_of(system, wire, p, wire.product))
                if not wire.is_unknown:
                    keep(of_wire(wire, input_change), of_wire(wire, result))
    return True


@compiled
def note_worst(system: System, residual: np.ndarray):
    """Note the fault of the wire with the largest residual."""
    shares = np.abs(residual) / system.layout.tolerance
    shares[np.isnan(shares)] = np.inf
    k = np.argmax(shares)
    for w in range(len(system.wires)):
        wire = wire_of(system, w)
        if 0 <= k - wire.first < wire.elements:
            x, allowed = float(residual[k]), float(system.layout.tolerance[k])
            refuse_element(system.failures, wire, k - wire.first, ON_WIRE.worst, x, allowed, 0.0)


@compiled
def find(memory: np.ndarray, x: np.ndarray, time: float, length: float, noted: np.ndarray):
    """Replace a guess by the fixed point of a macro step; return False and note why if none.

    noted : ndarray, written: evaluations, products, and the measures of all wires by evaluation;
    nothing if it is empty.
    """
    system = system_of(memory)
    system.failures[0] = 0.0
    wires = len(system.wires)
    rows = (len(noted) - 2) // wires if len(noted) > 0 and wires > 0 else 0
    trail = noted[len(noted) - rows * wires :].reshape((rows, wires))
    counts = noted[:2] if rows > 0 else np.zeros(2)
    step = Step(system, time, length, trail, counts)
    pairs = state_of(memory).pairs
    rules = rules_of(memory)
    end = converge(evaluate, derivative, step, x, rules, system.layout, pairs)
    counts[1] = end.products
    if end.is_converged:
        keep(x, end.at.used)
    if end.failure != NONE:
        count, best, last = len(end.history), np.min(end.history), end.history[-1]
        refuse(system.failures, end.failure, float(count), 0.0, last, best, 0.0)
        note_worst(system, end.at.residual)
    return end.is_converged
