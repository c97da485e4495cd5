"""Participants and wires of a coupled FMU without Python, as `interface`."""

from typing import NamedTuple

import numpy as np
from numba import types

from ..fmi.block import keep
from ..fmi.compiled import compiled
from ..fmi.noted import refuse, take_over
from .native_block import (
    FAULT,
    ON_WIRE,
    WireRow,
    participant_from,
    parts_of,
    setup_of,
    state_of,
    wire_from,
)
from .vector import Layout

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
    """Participants and wires; order : stepping order; saved : saved variables and states.

    owner, scale : participant whose coordinates determine all unknowns, `NOWHERE` for none, and
    their scale.
    """

    layout: Layout
    participants: np.ndarray
    wires: np.ndarray
    order: np.ndarray
    owner: int
    inside: np.ndarray
    saved: np.ndarray
    scale: np.ndarray
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
        owner=setup.owner,
        inside=parts.inside,
        saved=state_of(memory).saved,
        scale=state_of(memory).scale,
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
