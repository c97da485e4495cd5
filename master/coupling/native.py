"""A coupled system as a slave that needs no Python: its entries, on one block of memory that holds
all participants (`native_block`). They do what `coupled` does.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..fmi.block import FIRST_STATE, STATES, keep, part
from ..fmi.compiled import compiled
from ..fmi.native_parts import CALL, Entry, NativePart, size
from ..fmi.noted import refuse
from . import native_calls
from .native_block import (
    A_START,
    A_STEP,
    BEFORE,
    CAUSALITY,
    CONSTANTS,
    CONTENT,
    CONTENT_OF_MEMORY,
    CONTENTS,
    EXPOSED_COUNT,
    FAILURES,
    FAULTS_AT,
    FOUND,
    INTEGERS,
    INTEGRAL,
    IS_INPUT,
    IS_OUTPUT,
    IS_PARAMETER,
    KEPT_AT,
    LAST_INPUTS,
    LAST_KIND,
    LAST_NUMBERS,
    LAST_OUTPUTS,
    LAST_PRINT,
    LAST_STEP,
    LAST_TIME,
    LENGTH,
    MARKS,
    MEMORIES,
    MEMORY,
    NO_STEP,
    NOWHERE,
    NUDGE,
    OUTER_NOMINAL,
    OWN_FAULTS,
    OWN_PLACE,
    OWNER,
    PARTICIPANTS,
    PLACE,
    REALS,
    RESERVED,
    SIZE,
    SOURCE,
    STANDING,
    STARTING,
    TARGET,
    TIMES,
    WIRE_COUNT,
    clear,
    count,
    exposed_of,
    given,
    row_of,
    wire_of,
)
from .native_calls import START
from .native_journal import open_journal, print_of, take_back
from .native_newton import (
    answered,
    converge,
    feed,
    hear,
    integer_of,
    is_fed_well,
    read,
    real_of,
    restore,
    save,
)
from .native_stepping import accept, forget_products, reach

# ---- between the outside and the participants


@compiled
def take(real, integer, memory, which):
    """Variables of a causality into the participants."""
    for k in range(count(memory, EXPOSED_COUNT)):
        row = exposed_of(memory, k)
        if row[CAUSALITY] != which:
            continue
        p = int(row[OWNER])
        outer = int(row[PLACE])
        inner = int(row[OWN_PLACE])
        n = int(row[LENGTH])
        if row[INTEGRAL] != 0.0:
            own = integer_of(memory, p)
            for i in range(n):
                own[inner + i] = integer[outer + i]
        else:
            keep(real_of(memory, p)[inner : inner + n], real[outer : outer + n])


@compiled
def publish(real, integer, memory):
    """The participants' outputs into the variables."""
    for k in range(count(memory, EXPOSED_COUNT)):
        row = exposed_of(memory, k)
        if row[CAUSALITY] != IS_OUTPUT:
            continue
        p = int(row[OWNER])
        outer = int(row[PLACE])
        inner = int(row[OWN_PLACE])
        n = int(row[LENGTH])
        if row[INTEGRAL] != 0.0:
            own = integer_of(memory, p)
            for i in range(n):
                integer[outer + i] = own[inner + i]
        else:
            keep(real[outer : outer + n], real_of(memory, p)[inner : inner + n])


@compiled
def kept_of(real, memory, row, to_memory):
    """Keep an input or a real output of the last step, or put the input back."""
    if row[KEPT_AT] == NOWHERE:
        return
    n = int(row[LENGTH])
    at = int(row[KEPT_AT])
    kept = part(memory, LAST_INPUTS if row[CAUSALITY] == IS_INPUT else LAST_OUTPUTS)
    outer = int(row[PLACE])
    if to_memory:
        keep(kept[at : at + n], real[outer : outer + n])
    else:
        keep(real[outer : outer + n], kept[at : at + n])


@compiled
def remember(real, memory, kind, time, step):
    """What a derivative of the last step starts from: what was given and what came out."""
    last = part(memory, LAST_NUMBERS)
    last[LAST_KIND] = kind
    last[LAST_TIME] = time
    last[LAST_STEP] = step
    last[LAST_PRINT] = print_of(memory)
    for k in range(count(memory, EXPOSED_COUNT)):
        kept_of(real, memory, exposed_of(memory, k), True)


@compiled
def state_in(memory):
    """The state, in one piece."""
    first = int(memory[FIRST_STATE])
    return memory[first : first + int(memory[STATES])]


# ---- start and step


@compiled
def load(memory, p):
    """Memory of a participant as before its start; its variables stay."""
    row = row_of(memory, p)
    at = int(row[CONTENT])
    first = int(row[MEMORY])
    given_length = int(row[CONTENT_OF_MEMORY])
    own = memory[first : first + int(row[MEMORIES])]
    clear(own)
    keep(own[:given_length], part(memory, CONTENTS)[at : at + given_length])


@compiled
def load_variables(memory, p):
    """Start values of a participant's variables."""
    row = row_of(memory, p)
    contents = part(memory, CONTENTS)
    at = int(row[CONTENT]) + int(row[CONTENT_OF_MEMORY])
    reals = int(row[REALS])
    keep(real_of(memory, p), contents[at : at + reals])
    at += reals
    integers = int(row[INTEGERS])
    own = integer_of(memory, p)
    start_integer = contents[at : at + integers].view(np.int64)
    for k in range(integers):
        own[k] = start_integer[k]


@compiled
def start_each(memory, started, y):
    """Start every participant, fed by those that have started."""
    faults = part(memory, FAULTS_AT)
    starting = part(memory, STARTING)
    numbers = np.zeros(4)
    for k in range(count(memory, PARTICIPANTS)):
        p = int(starting[k])
        load(memory, p)
        is_fed = True
        for w in range(count(memory, WIRE_COUNT)):
            wire = wire_of(memory, w)
            if int(wire[TARGET]) == p:
                if started[int(wire[SOURCE])] != 0.0:
                    hear(memory, w, y)
                    feed(memory, w, y)
                if not is_fed_well(memory, w, faults):
                    is_fed = False
        if is_fed and answered(memory, p, native_calls.call(memory, p, START, numbers), faults):
            started[p] = 1.0


@compiled
def begin(real, integer, memory):
    """Start every participant, as `starting.start`; False where one of them refuses, all that is
    refused put down.

    They start twice: a film's forces at the start follow from the gap of the bodies, whose
    accelerations follow from these forces, and nothing else at a start depends on an input.
    """
    for p in range(count(memory, PARTICIPANTS)):
        load_variables(memory, p)
    take(real, integer, memory, IS_PARAMETER)
    take(real, integer, memory, IS_INPUT)
    y = np.zeros(count(memory, SIZE))
    started = np.zeros(count(memory, PARTICIPANTS))
    for _ in range(2):
        start_each(memory, started, y)
        if part(memory, FAULTS_AT)[0] != 0.0:
            return False
    read(memory, y)
    for w in range(count(memory, WIRE_COUNT)):
        feed(memory, w, y)
    part(memory, TIMES)[0] = 0.0
    accept(memory, 0.0, y)
    forget_products(memory)
    save(memory, STANDING)
    return True


@compiled
def go_on(real, integer, memory, time, step):
    """From where the participants stand to time + step, as `Coupled.advance`; False where that
    cannot be, and the state stays.
    """
    open_journal(memory)
    restore(memory, STANDING)
    take(real, integer, memory, IS_INPUT)
    if reach(memory, time, step):
        save(memory, STANDING)
        return True
    take_back(memory)
    return False


# ---- entries


@compiled
def start(real: np.ndarray, integer: np.ndarray, memory: np.ndarray, numbers: np.ndarray):
    """State and outputs at the start; `numbers` unused."""
    part(memory, FAULTS_AT)[0] = 0.0
    part(memory, LAST_NUMBERS)[LAST_KIND] = 0.0
    if begin(real, integer, memory):
        publish(real, integer, memory)
        remember(real, memory, A_START, 0.0, 0.0)


@compiled
def advance(real: np.ndarray, integer: np.ndarray, memory: np.ndarray, numbers: np.ndarray):
    """One communication step; numbers: its length and its begin [s]."""
    part(memory, FAULTS_AT)[0] = 0.0
    step = numbers[0]
    time = numbers[1]
    if go_on(real, integer, memory, time, step):
        publish(real, integer, memory)
        remember(real, memory, A_STEP, time, step)


@compiled
def nudge_of(real, memory):
    """Length of the nudge, Eq. (Y4); 0 where nothing is nudged."""
    largest = 0.0
    for k in range(count(memory, EXPOSED_COUNT)):
        row = exposed_of(memory, k)
        if row[CAUSALITY] != IS_INPUT or row[RESERVED] == NOWHERE:
            continue
        seed = int(row[RESERVED])
        last = part(memory, LAST_INPUTS)
        at = int(row[KEPT_AT])
        whole = 0.0
        moves = 0.0
        for i in range(int(row[LENGTH])):
            whole = max(whole, abs(last[at + i]))
            moves = max(moves, abs(real[seed + i]))
        whole = max(row[OUTER_NOMINAL], whole)
        largest = max(largest, moves / (whole if whole != 0.0 else 1.0))
    return part(memory, CONSTANTS)[NUDGE] / largest if largest > 0.0 else 0.0


@compiled
def nudge(real, memory, length):
    """Inputs of the last step, moved along the seeds."""
    for k in range(count(memory, EXPOSED_COUNT)):
        row = exposed_of(memory, k)
        if row[CAUSALITY] == IS_INPUT:
            kept_of(real, memory, row, False)
            if row[RESERVED] != NOWHERE:
                seed = int(row[RESERVED])
                at = int(row[PLACE])
                for i in range(int(row[LENGTH])):
                    real[at + i] += length * real[seed + i]


@compiled
def differ(real, memory, length):
    """Products: what the participants say now beside the last step, over a length."""
    last = part(memory, LAST_OUTPUTS)
    for k in range(count(memory, EXPOSED_COUNT)):
        row = exposed_of(memory, k)
        if row[CAUSALITY] == IS_OUTPUT and row[RESERVED] != NOWHERE:
            product = int(row[RESERVED])
            at = int(row[KEPT_AT])
            inner = int(row[OWN_PLACE])
            own = real_of(memory, int(row[OWNER]))
            for i in range(int(row[LENGTH])):
                real[product + i] = (
                    (own[inner + i] - last[at + i]) / length if length > 0.0 else 0.0
                )


@compiled
def tangent(real: np.ndarray, integer: np.ndarray, memory: np.ndarray, numbers: np.ndarray):
    """Products of the seeds among the variables, as `Coupled.directional_derivative`: the step is
    taken again; `numbers` unused.
    """
    faults = part(memory, FAULTS_AT)
    faults[0] = 0.0
    last = part(memory, LAST_NUMBERS)
    if last[LAST_KIND] == 0.0:
        refuse(faults, float(NO_STEP), 0.0, 0.0, 0.0, 0.0, 0.0)
        return
    length = nudge_of(real, memory)
    if length == 0.0:
        differ(real, memory, 0.0)
        return
    state = state_in(memory)
    before = part(memory, BEFORE)
    marks = part(memory, MARKS)
    now = state.copy()
    begun = before.copy()
    marked = marks.copy()
    asked = real.copy()
    nudge(real, memory, length)
    if last[LAST_KIND] == A_START:
        found = begin(real, integer, memory)
    else:
        is_another = last[LAST_PRINT] != print_of(memory)
        take_back(memory)
        if is_another:  # a state was set since: its pairs are not those of the last step
            forget_products(memory)
        found = go_on(real, integer, memory, last[LAST_TIME], last[LAST_STEP])
    keep(real, asked)
    if found:
        differ(real, memory, length)  # Eq. (Y4)
    keep(state, now)
    keep(before, begun)
    keep(marks, marked)


@compiled
def iterate(real: np.ndarray, integer: np.ndarray, memory: np.ndarray, numbers: np.ndarray):
    """A macro step of `run` to its fixed point (`methods.compiled_newton`): `real` is the guess,
    then the wires; numbers: length of the step and its begin [s], then 1 where it was found, else
    0, and what is remembered is as before. `integer` unused.
    """
    part(memory, FAILURES)[0] = 0.0
    open_journal(memory)
    numbers[FOUND] = 1.0
    if not converge(memory, real, numbers, real):
        take_back(memory)
        numbers[FOUND] = 0.0


def given_of(contents: tuple[Mapping[str, np.ndarray], Mapping[str, int]]) -> np.ndarray:
    """What the memory begins with, `native_block.given`."""
    return given(*contents)


def uncovered(options: Mapping[str, Any]) -> tuple[str, ...]:
    """Nothing: `native_given` says what is not covered."""
    return ()


PART = NativePart(
    entries=tuple(Entry(kernel) for kernel in (size, start, advance, tangent, iterate)),
    given=given_of,
    uncovered=uncovered,
    covered={},
    faults=OWN_FAULTS,
    refusal="",
    asks=frozenset({CALL}),
)
