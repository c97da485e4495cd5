"""Entries of a coupled FMU that needs no Python, as `coupled` and `stepping`.

Their memory contains all participants, see `native_block`.
"""

from typing import NamedTuple

import numpy as np

from ..fmi.block import keep
from ..fmi.compiled import compiled
from ..fmi.native_parts import NOWHERE, NativePart
from ..fmi.noted import refuse, remark, take_over
from .methods.krylov import forget
from .native_block import (
    FAULT,
    FOUND,
    SENTENCES,
    SOLVED,
    CoupledState,
    LastMacroStep,
    exposed_from,
    is_state,
    last_from,
    nothing_yet,
    participant_from,
    parts_of,
    put_last,
    put_state,
    rules_of,
    setup_of,
    state_of,
)
from .native_iteration import find, read_coordinates
from .native_system import (
    START,
    System,
    call,
    feed,
    integer_of,
    is_fed_well,
    read,
    real_of,
    restore,
    save,
    system_of,
    wire_of,
)
from .stepping import REPETITIONS
from .vector import MOST_STEPS, extrapolate, is_longer, joined, macro_step_end, moved

# ---- between the outside and the participants


OUTWARD, INWARD = 1.0, 0.0
"""Directions of `carry`; numba compiles a kernel anew for every literal that is no float."""


@compiled
def carry(
    real: np.ndarray, integer: np.ndarray, system: System, rows: np.ndarray, direction: float
):
    """Copy variables of the FMU to the participants, or from them."""
    for k in range(len(rows)):
        one = exposed_from(rows[k])
        for i in range(one.length):
            outer, inner = one.place + i, one.own_place + i
            if one.is_integer and direction == OUTWARD:
                integer[outer] = integer_of(system, one.owner)[inner]
            elif one.is_integer:
                integer_of(system, one.owner)[inner] = integer[outer]
            elif direction == OUTWARD:
                real[outer] = real_of(system, one.owner)[inner]
            else:
                real_of(system, one.owner)[inner] = real[outer]


@compiled
def remember(real: np.ndarray, memory: np.ndarray, time: float, step: float):
    """Save what a derivative of the last step starts from."""
    put_last(parts_of(memory).last, LastMacroStep(True, time, step, real))


# ---- macro steps


@compiled
def accept(state: CoupledState, time: float, x: np.ndarray):
    """Add an accepted vector."""
    known = int(state.known[0])
    if known == len(state.times):
        for k in range(1, known):
            state.times[k - 1] = state.times[k]
            keep(state.past[k - 1], state.past[k])
        known -= 1
    state.times[known] = time
    keep(state.past[known], x)
    state.known[0] = known + 1.0


@compiled
def forget_past(state: CoupledState):
    """Remove all accepted vectors but the last."""
    last = int(state.known[0]) - 1
    state.times[0] = state.times[last]
    keep(state.past[0], state.past[last])
    state.known[0] = 1.0


@compiled
def longest_step(system: System, limits: np.ndarray) -> float:
    """Return the longest step that resolves the motion, as `Stepper._longest_step` [s]."""
    longest = np.inf
    for k in range(len(limits)):
        one = exposed_from(limits[k])
        longest = min(longest, float(real_of(system, one.owner)[one.own_place]))
    return longest


class StepBegin(NamedTuple):
    """Members of `CoupledState` at the begin of a macro step, but the pairs."""

    saved: np.ndarray
    known: np.ndarray
    times: np.ndarray
    past: np.ndarray


@compiled
def begin_of(state: CoupledState):
    """Return copies of the state at the begin of a macro step, which is saved."""
    return StepBegin(state.saved.copy(), state.known.copy(), state.times.copy(), state.past.copy())


@compiled
def return_to(begin: StepBegin, system: System, state: CoupledState):
    """Return to the begin of a macro step, and forget the products of its parts."""
    keep(state.saved, begin.saved)
    keep(state.known, begin.known)
    keep(state.times, begin.times)
    for k in range(len(state.past)):
        keep(state.past[k], begin.past[k])
    restore(system)
    forget(state.pairs)


@compiled
def attempt(memory: np.ndarray, x: np.ndarray, time: float, length: float):
    """Save the participants and solve a part of a macro step; return whether it converged.

    x : ndarray, shape (size,), written: the solution. A failed attempt is not rolled back.
    """
    system = system_of(memory)
    state = state_of(memory)
    save(system)
    known = int(state.known[0])
    last = state.past[known - 1]
    guess = extrapolate(state.times[:known], state.past[:known], time + length)
    keep(x, moved(system.layout, last, guess - last))
    return find(memory, x, time, length, np.zeros(0))


@compiled
def give_up(system: System, state: CoupledState):
    """Roll back a failed part, and forget all vectors but the last and all products."""
    restore(system)
    forget_past(state)
    forget(state.pairs)


@compiled
def take_resolved_parts(memory: np.ndarray, time: float, step: float, most: int):
    """Take a macro step in parts that resolve the motion, as `Stepper._take_resolved_parts`."""
    system = system_of(memory)
    state = state_of(memory)
    limits = setup_of(memory).exposed.limits
    x = np.zeros(len(system.layout.nominal))
    longest = longest_step(system, limits)
    nothing = np.zeros(0)
    start = StepBegin(nothing, nothing, nothing, np.zeros((0, 0)))
    depth = done = 0  # halvings, and parts of this length that are done
    while done < 1 << depth:
        while depth < most and is_longer(step / (1 << depth), longest):
            done *= 2
            depth += 1
        length = step / (1 << depth)
        begin = time + done * length
        is_solved = attempt(memory, x, begin, length)
        longest = longest_step(system, limits)
        is_accepted = is_solved and not (depth < most and is_longer(length, longest))
        if len(start.known) == 0 and not (is_accepted and depth == 0):
            start = begin_of(state)
        if is_accepted:
            accept(state, begin + length, x)
            done, depth = joined(done + 1, depth)
        elif is_solved:
            restore(system)
        elif depth == most:
            return_to(start, system, state)
            remark(system.faults, FAULT.without_parts)
            return False
        else:
            give_up(system, state)
            longest = longest_step(system, limits)
            done *= 2
            depth += 1
    return True


@compiled
def take_macro_step(memory: np.ndarray, time: float, step: float):
    """Take a macro step, as `Stepper._take_macro_step`; return False and note why if it fails."""
    system = system_of(memory)
    state = state_of(memory)
    halvings = rules_of(memory).halvings
    most = min(REPETITIONS, halvings) if len(setup_of(memory).exposed.limits) > 0 else 0
    if most > 0 and take_resolved_parts(memory, time, step, most):
        return True
    x = np.zeros(len(system.layout.nominal))
    depth = done = 0
    while done < 1 << depth:
        length = step / (1 << depth)
        begin = time + done * length
        if attempt(memory, x, begin, length):
            accept(state, begin + length, x)
            done, depth = joined(done + 1, depth)
            continue
        give_up(system, state)
        if depth == halvings:
            refuse(system.faults, FAULT.no_halving, 0.0, 0.0, begin, length, 0.0)
            take_over(system.faults, system.failures, 0.0)
            return False
        done *= 2
        depth += 1
    return True


@compiled
def take_macro_steps(memory: np.ndarray, time: float, step: float):
    """Take macro steps up to time + step, as `Coupled.advance`; return False if one fails.

    More than `MOST_STEPS` are rejected.
    """
    rules = rules_of(memory)
    asked = np.ceil(step / rules.step / (1.0 + rules.lenience))
    if not asked <= MOST_STEPS:
        refuse(
            parts_of(memory).faults, FAULT.too_long, 0.0, 0.0, step, float(MOST_STEPS), rules.step
        )
        return False
    steps = int(asked)
    for k in range(steps):
        before = macro_step_end(time, step, k / steps, rules.step)
        after = macro_step_end(time, step, (k + 1) / steps, rules.step)
        if not take_macro_step(memory, before, after - before):
            return False
    return True


# ---- start and step

WAS_SAVED = 2
"""Position in the numbers of a step: 1 if a state was saved or restored since the last step."""


@compiled
def load(system: System, contents: np.ndarray, p: int):
    """Reset the memory of a participant, not its variables."""
    one = participant_from(system.participants[p])
    own = system.inside[one.memory : one.memory + one.memories]
    keep(own, np.zeros(len(own)))
    keep(own[: one.setup], contents[one.contents : one.contents + one.setup])


@compiled
def load_variables(system: System, contents: np.ndarray, p: int):
    """Set the variables of a participant to their start values."""
    one = participant_from(system.participants[p])
    first = one.contents + one.setup
    middle = first + one.reals
    keep(real_of(system, p), contents[first:middle])
    keep(integer_of(system, p), contents[middle : middle + one.integers].view(np.int64))


@compiled
def begin(real: np.ndarray, integer: np.ndarray, memory: np.ndarray):
    """Start every participant, as `starting.start`; return False and note all faults if one fails.

    They start twice: a film's forces at the start follow from the gap of the bodies, whose
    accelerations follow from these forces, and nothing else at a start depends on an input.
    """
    setup = setup_of(memory)
    system = system_of(memory)
    for p in range(len(system.participants)):
        load_variables(system, setup.contents, p)
    carry(real, integer, system, setup.exposed.parameters, INWARD)
    carry(real, integer, system, setup.exposed.inputs, INWARD)
    y = np.zeros(len(setup.layout.nominal))
    started = np.zeros(len(system.participants))
    numbers = np.zeros(4)
    for _ in range(2):
        for k in range(len(setup.starting)):
            p = int(setup.starting[k])
            load(system, setup.contents, p)
            is_fed = True
            for w in range(len(system.wires)):
                wire = wire_of(system, w)
                if wire.target == p:
                    if started[wire.source] != 0.0:
                        read(system, wire, y)
                        feed(system, wire, y)
                    is_fed = is_fed_well(system, wire, system.faults) and is_fed
            if is_fed and call(system, p, START, numbers, system.faults):
                started[p] = 1.0
        if system.faults[0] != 0.0:
            return False
    for w in range(len(system.wires)):
        read(system, wire_of(system, w), y)
    for w in range(len(system.wires)):
        feed(system, wire_of(system, w), y)
    if not read_coordinates(system, y):
        return False
    state = state_of(memory)
    state.known[0] = 0.0
    accept(state, 0.0, y)
    forget(state.pairs)
    save(system)
    return True


@compiled
def take_communication_step(
    real: np.ndarray, integer: np.ndarray, memory: np.ndarray, numbers: np.ndarray
):
    """Advance as `Coupled.advance`; return False and keep the state if it fails.

    numbers : length of the step, its begin [s], and `WAS_SAVED`, after which the step uses no
    earlier products, because a saved state has none.
    """
    parts = parts_of(memory)
    if not is_state(parts.state, parts.before):
        refuse(parts.faults, FAULT.other_state, 0.0, 0.0, 0.0, 0.0, 0.0)
        return False
    if numbers[WAS_SAVED] != 0.0:
        forget(state_of(memory).pairs)
    keep(parts.before, parts.state)
    system = system_of(memory)
    restore(system)
    exposed = setup_of(memory).exposed
    carry(real, integer, system, exposed.parameters, INWARD)  # tunable ones may have changed
    carry(real, integer, system, exposed.inputs, INWARD)
    if take_macro_steps(memory, numbers[1], numbers[0]):
        save(system)
        return True
    keep(parts.state, parts.before)
    return False


# ---- entries


@compiled
def clear(memory: np.ndarray):
    """Initialise the parts of the memory that change."""
    parts = parts_of(memory)
    parts.last[0] = 0.0
    state = nothing_yet(setup_of(memory))
    put_state(parts.state, state)
    put_state(parts.before, state)


@compiled
def start(real: np.ndarray, integer: np.ndarray, memory: np.ndarray, numbers: np.ndarray):
    """Compute state and outputs at the start; `numbers` is unused."""
    parts_of(memory).faults[0] = 0.0
    clear(memory)
    if begin(real, integer, memory):
        carry(real, integer, system_of(memory), setup_of(memory).exposed.outputs, OUTWARD)
        remember(real, memory, 0.0, 0.0)


@compiled
def advance(real: np.ndarray, integer: np.ndarray, memory: np.ndarray, numbers: np.ndarray):
    """Take a communication step; numbers : as of `take_communication_step`."""
    parts_of(memory).faults[0] = 0.0
    if take_communication_step(real, integer, memory, numbers):
        carry(real, integer, system_of(memory), setup_of(memory).exposed.outputs, OUTWARD)
        remember(real, memory, numbers[1], numbers[0])


@compiled
def nudge_of(real: np.ndarray, inputs: np.ndarray, last: LastMacroStep, nudge: float):
    """Return e of Eq. (Y4), 0 if all seeds are 0."""
    largest = 0.0
    for k in range(len(inputs)):
        one = exposed_from(inputs[k])
        if one.reserved != NOWHERE:
            size = one.nominal
            moves = 0.0
            for i in range(one.length):
                size = max(size, abs(last.real[one.place + i]))
                moves = max(moves, abs(real[one.reserved + i]))
            largest = max(largest, moves / (size if size != 0.0 else 1.0))
    return float(nudge / largest) if largest > 0.0 else 0.0


@compiled
def nudged(real: np.ndarray, inputs: np.ndarray, last: LastMacroStep, length: float):
    """Return the variables with the inputs of the last step, moved along the seeds."""
    moved = real.copy()
    for k in range(len(inputs)):
        one = exposed_from(inputs[k])
        for i in range(one.length if one.reserved != NOWHERE else 0):
            moves = length * real[one.reserved + i]
            moved[one.place + i] = last.real[one.place + i] + moves
    return moved


@compiled
def repeat_last_step(
    real: np.ndarray, integer: np.ndarray, memory: np.ndarray, last: LastMacroStep
):
    """Repeat the last step, or the start; return whether it succeeded."""
    if last.step == 0.0:
        return begin(real, integer, memory)
    parts = parts_of(memory)
    keep(parts.state, parts.before)
    numbers = np.zeros(4)
    numbers[0] = last.step
    numbers[1] = last.time
    return take_communication_step(real, integer, memory, numbers)


@compiled
def differ(
    real: np.ndarray, system: System, outputs: np.ndarray, last: LastMacroStep, length: float
):
    """Write the products: change of the outputs over a length, 0 if the length is 0."""
    for k in range(len(outputs)):
        one = exposed_from(outputs[k])
        if one.reserved != NOWHERE:
            now = real_of(system, one.owner)
            for i in range(one.length):
                change = now[one.own_place + i] - last.real[one.place + i]
                real[one.reserved + i] = change / length if length > 0.0 else 0.0  # Eq. (Y4)


@compiled
def tangent(real: np.ndarray, integer: np.ndarray, memory: np.ndarray, numbers: np.ndarray):
    """Write the products of the seeds, as `Coupled.directional_derivative`.

    This repeats the step. `numbers` is unused.
    """
    parts = parts_of(memory)
    last = last_from(parts.last)
    exposed = setup_of(memory).exposed
    parts.faults[0] = 0.0
    if not last.is_there:
        refuse(parts.faults, FAULT.no_step, 0.0, 0.0, 0.0, 0.0, 0.0)
        return
    length = nudge_of(real, exposed.inputs, last, rules_of(memory).nudge)
    state, before = parts.state.copy(), parts.before.copy()
    if length == 0.0 or repeat_last_step(
        nudged(real, exposed.inputs, last, length), integer, memory, last
    ):
        differ(real, system_of(memory), exposed.outputs, last, length)
    keep(parts.state, state)
    keep(parts.before, before)


@compiled
def iterate(real: np.ndarray, integer: np.ndarray, memory: np.ndarray, numbers: np.ndarray):
    """Iterate a macro step of `run` to its fixed point.

    real : guess, then the solution; numbers : length of the step and its begin [s], then written:
    1 if there is a solution, else 0, and what `find` notes. `integer` is unused.
    """
    numbers[SOLVED] = 0.0
    numbers[FOUND] = 0.0
    if find(memory, real, numbers[1], numbers[0], numbers[FOUND:]):
        numbers[SOLVED] = 1.0


PART = NativePart(
    entries=(start, advance, tangent, iterate),
    setup=np.asarray,  # native_given.coupled_inside has laid it out
    faults=tuple(SENTENCES.values()),
    refusal="",
)
