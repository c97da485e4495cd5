"""A macro step to its fixed point, as loops for machine code: `interface`, `methods.newton`, where
the equations stand, on participants that are entries and a block of memory.
"""

from typing import NamedTuple

import numpy as np

from ..fmi.block import keep, part
from ..fmi.compiled import compiled
from ..fmi.noted import refuse, take_over
from . import native_calls
from .methods.krylov import Goal, Pairs, learn, length, minimise
from .native_block import (
    ACCURACY,
    COLUMNS,
    CONSTANTS,
    DIFFERENCES,
    ELEMENTS,
    EVALUATIONS,
    FAILURES,
    FAULTS_AT,
    FIRST,
    FORCING,
    GRAM,
    GROWS,
    HIGH,
    IMAGES,
    INTEGER,
    INTEGERS,
    ITERATIONS,
    KEPT,
    LARGEST_DECREASE,
    LOW,
    MEMORY,
    MUST_BE_FINITE,
    NO_MEMORY,
    NOMINAL,
    NOT_FINITE,
    NOWHERE,
    OF_TRAIL,
    OLDEST,
    ORDER,
    OUT_OF_RANGE,
    OWN_FAULT,
    OWN_STATE,
    OWN_STATES,
    PARTICIPANTS,
    PRODUCTS,
    REAL,
    REALS,
    SAVED,
    SENTENCE,
    SOURCE,
    SOURCE_PLACE,
    SPACE,
    STANDS,
    TARGET,
    TARGET_PLACE,
    TOLERANCE,
    TOO_MANY,
    TRAIL,
    UNKNOWN,
    UNKNOWNS,
    VARIABLES,
    WIRE_COUNT,
    WIRE_PRODUCT,
    WIRE_SEED,
    WIRE_SENTENCE,
    WORST,
    clear,
    count,
    row_of,
    wire_of,
)
from .native_calls import ADVANCE, TANGENT
from .native_journal import overwrite

USED, OUTPUTS, RESIDUAL = range(3)
"""Of an evaluation: what inputs were set to, what outputs are, how far the iterate is off."""

# ---- participants


@compiled
def real_of(memory: np.ndarray, p: int):
    """Real variables of the p-th participant, seeds and products behind them."""
    row = row_of(memory, p)
    first = int(row[REAL])
    return memory[first : first + int(row[REALS])]


@compiled
def integer_of(memory: np.ndarray, p: int):
    """Its integer variables."""
    row = row_of(memory, p)
    first = int(row[INTEGER])
    return memory[first : first + int(row[INTEGERS])].view(np.int64)


@compiled
def state_of(memory, p):
    """The state in its own memory."""
    row = row_of(memory, p)
    first = int(row[MEMORY]) + int(row[OWN_STATE])
    return memory[first : first + int(row[OWN_STATES])]


@compiled
def save(memory: np.ndarray, where: int):
    """Keep variables and states of all participants in a part: STANDING or SAVED."""
    to = part(memory, where)
    for p in range(count(memory, PARTICIPANTS)):
        row = row_of(memory, p)
        at = int(row[STANDS])
        variables = int(row[VARIABLES])
        keep(to[at : at + variables], real_of(memory, p)[:variables])
        keep(to[at + variables : at + variables + int(row[OWN_STATES])], state_of(memory, p))


@compiled
def restore_one(memory, p, where):
    """Put a participant back to what a part keeps of it."""
    kept = part(memory, where)
    row = row_of(memory, p)
    at = int(row[STANDS])
    variables = int(row[VARIABLES])
    keep(real_of(memory, p)[:variables], kept[at : at + variables])
    keep(state_of(memory, p), kept[at + variables : at + variables + int(row[OWN_STATES])])


@compiled
def restore(memory: np.ndarray, where: int):
    """The same for all of them."""
    for p in range(count(memory, PARTICIPANTS)):
        restore_one(memory, p, where)


@compiled
def answered(memory: np.ndarray, p: int, status: int, faults: np.ndarray):
    """Whether an entry of a participant went well; else its faults are put down. A remark, below 0
    in the place of its first fault, is handed on.
    """
    if status != 0:
        refuse(faults, NO_MEMORY, 0.0, 0.0, 0.0, 0.0, 0.0)
        return False
    row = row_of(memory, p)
    first = int(row[MEMORY]) + int(row[OWN_FAULT])
    found = int(memory[first])
    take_over(faults, memory[first:], row[SENTENCE])
    own = part(memory, FAULTS_AT)
    if found == 0 and own[0] == 0.0 and memory[first + 1] < 0.0:
        own[1] = memory[first + 1] - row[SENTENCE]
    return found == 0


@compiled
def is_fed_well(memory: np.ndarray, w: int, faults: np.ndarray):
    """Whether what a wire has set is finite and allowed; else its first fault is put down."""
    wire = wire_of(memory, w)
    at = int(wire[TARGET_PLACE])
    columns = int(wire[COLUMNS])
    values = real_of(memory, int(wire[TARGET]))[at : at + int(wire[ELEMENTS])]
    low = wire[LOW]
    high = wire[HIGH]
    for k in range(len(values)):
        x = values[k]
        if np.isfinite(x) and low <= x <= high:
            continue
        i = float(k // columns + 1)
        j = float(k % columns + 1)
        if not np.isfinite(x):
            refuse(faults, wire[WIRE_SENTENCE] + MUST_BE_FINITE, i, j, x, 0.0, 0.0)
        else:
            refuse(faults, wire[WIRE_SENTENCE] + OUT_OF_RANGE, i, j, x, low, high)
        return False
    return True


# ---- all wires as one vector


@compiled
def read(memory: np.ndarray, y: np.ndarray):
    """What the sources say now into `y`."""
    for w in range(count(memory, WIRE_COUNT)):
        hear(memory, w, y)


@compiled
def hear(memory, w, y):
    """What the source of a wire says into its part of `y`."""
    wire = wire_of(memory, w)
    at = int(wire[SOURCE_PLACE])
    first = int(wire[FIRST])
    n = int(wire[ELEMENTS])
    keep(y[first : first + n], real_of(memory, int(wire[SOURCE]))[at : at + n])


@compiled
def feed(memory, w, x):
    """A wire's part of `x` into its target."""
    wire = wire_of(memory, w)
    at = int(wire[TARGET_PLACE])
    first = int(wire[FIRST])
    n = int(wire[ELEMENTS])
    keep(real_of(memory, int(wire[TARGET]))[at : at + n], x[first : first + n])


@compiled
def evaluate(memory: np.ndarray, x: np.ndarray, numbers: np.ndarray, outcome: np.ndarray):
    """Step every participant once from what is saved, as `Interface.evaluate`; whether all of them
    took the step.

    Parameters
    ----------
    memory : ndarray
    x : ndarray, shape (size,)
        Iterate.
    numbers : ndarray, shape (4,)
        Length and time of the macro step [s].
    outcome : ndarray, shape (3, size)
        Overwritten: what the inputs were set to, what the outputs are, the residual.
    """
    used = outcome[USED]
    y = outcome[OUTPUTS]
    residual = outcome[RESIDUAL]
    keep(used, x)
    faults = part(memory, FAILURES)
    wires = count(memory, WIRE_COUNT)
    order = part(memory, ORDER)
    for k in range(len(order)):
        p = int(order[k])
        restore_one(memory, p, SAVED)
        for w in range(wires):
            if int(wire_of(memory, w)[TARGET]) == p:
                feed(memory, w, used)
                if not is_fed_well(memory, w, faults):
                    return False
        if not answered(memory, p, native_calls.call(memory, p, ADVANCE, numbers), faults):
            return False
        for w in range(wires):
            wire = wire_of(memory, w)
            if int(wire[SOURCE]) == p:
                hear(memory, w, y)
                if wire[UNKNOWN] == NOWHERE:
                    first = int(wire[FIRST])
                    end = first + int(wire[ELEMENTS])
                    keep(used[first:end], y[first:end])
    for w in range(wires):
        wire = wire_of(memory, w)
        first = int(wire[FIRST])
        is_along = wire[UNKNOWN] == NOWHERE
        for k in range(first, first + int(wire[ELEMENTS])):
            residual[k] = used[k] - x[k] if is_along else y[k] - used[k]
    return True


@compiled
def derivative(memory: np.ndarray, change: np.ndarray, result: np.ndarray):
    """The evaluation linearised at the last step of every participant, as `Interface.derivative`;
    whether all of them answered.
    """
    seen = np.empty(len(change))
    wires = count(memory, WIRE_COUNT)
    for w in range(wires):
        wire = wire_of(memory, w)
        first = int(wire[FIRST])
        end = first + int(wire[ELEMENTS])
        clear(result[first:end])
        if wire[UNKNOWN] == NOWHERE:
            clear(seen[first:end])
        else:
            keep(seen[first:end], change[first:end])
    part(memory, TRAIL)[PRODUCTS] += 1.0
    numbers = np.zeros(4)
    order = part(memory, ORDER)
    for k in range(len(order)):
        p = int(order[k])
        real = real_of(memory, p)
        reads = False
        writes = False
        clear(real[int(row_of(memory, p)[VARIABLES]) :])
        for w in range(wires):
            wire = wire_of(memory, w)
            first = int(wire[FIRST])
            n = int(wire[ELEMENTS])
            if int(wire[SOURCE]) == p:
                writes = True
            if int(wire[TARGET]) == p:
                reads = True
                at = int(wire[WIRE_SEED])
                if at >= 0:
                    keep(real[at : at + n], seen[first : first + n])
        if not (reads and writes):
            continue  # nothing depends on it, or it depends on nothing
        status = native_calls.call(memory, p, TANGENT, numbers)
        if not answered(memory, p, status, part(memory, FAILURES)):
            return False
        for w in range(wires):
            wire = wire_of(memory, w)
            if int(wire[SOURCE]) == p:
                first = int(wire[FIRST])
                n = int(wire[ELEMENTS])
                at = int(wire[WIRE_PRODUCT])
                keep(result[first : first + n], real[at : at + n])
                if wire[UNKNOWN] == NOWHERE:
                    keep(seen[first : first + n], result[first : first + n])
    return True


@compiled
def measure(memory: np.ndarray, residual: np.ndarray):
    """Largest share of an element's residual in its wire's tolerance: converged at 1 and below, NaN
    if any is not finite. The largest of every wire goes to the trail; where that is full, in the
    place of the last.
    """
    wires = count(memory, WIRE_COUNT)
    trail = part(memory, TRAIL)
    room = (len(trail) - len(OF_TRAIL)) // max(wires, 1)
    row = min(int(trail[EVALUATIONS]), room - 1)
    trail[EVALUATIONS] += 1.0
    found = 0.0
    for w in range(wires):
        wire = wire_of(memory, w)
        first = int(wire[FIRST])
        largest = 0.0
        for k in range(first, first + int(wire[ELEMENTS])):
            size = abs(residual[k])
            if not size <= largest:
                largest = size
                if largest != largest:
                    break
        largest /= wire[TOLERANCE]
        if largest != largest:
            return largest
        trail[len(OF_TRAIL) + row * wires + w] = largest
        found = max(found, largest)
    return found


@compiled
def note_worst(memory, residual):
    """Put down which wire is worst, and its largest residual."""
    largest = -1.0
    worst = 0
    element = 0
    for w in range(count(memory, WIRE_COUNT)):
        wire = wire_of(memory, w)
        first = int(wire[FIRST])
        for k in range(int(wire[ELEMENTS])):
            share = abs(residual[first + k]) / wire[TOLERANCE]
            share = np.inf if share != share else share
            if share > largest:
                largest = share
                worst = w
                element = k
    wire = wire_of(memory, worst)
    columns = int(wire[COLUMNS])
    x = residual[int(wire[FIRST]) + element]
    i = float(element // columns + 1)
    j = float(element % columns + 1)
    refuse(part(memory, FAILURES), wire[WIRE_SENTENCE] + WORST, i, j, x, wire[TOLERANCE], 0.0)


@compiled
def step_length(memory: np.ndarray, x: np.ndarray, change: np.ndarray):
    """Largest share of `change` that respects every wire's `largest_decrease`, as
    `methods.step_length`.
    """
    share = 1.0
    for w in range(count(memory, WIRE_COUNT)):
        wire = wire_of(memory, w)
        if wire[LARGEST_DECREASE] == NOWHERE:
            continue
        first = int(wire[FIRST])
        end = first + int(wire[ELEMENTS])
        smallest = np.inf
        for k in range(first, end):
            smallest = min(smallest, x[k])
        floor = smallest - wire[LARGEST_DECREASE] * max(smallest, wire[NOMINAL] / 10)
        for k in range(first, end):
            if change[k] < 0.0:
                share = min(share, (x[k] - floor) / -change[k])
    return share


@compiled
def moved(memory, x, change):
    """x + share * change, no further than `step_length` allows."""
    share = step_length(memory, x, change)
    result = np.empty(len(x))
    for k in range(len(x)):
        result[k] = x[k] + share * change[k]
    return result


# ---- Newton


@compiled
def scattered(memory: np.ndarray, reduced: np.ndarray, change: np.ndarray):
    """Scaled unknowns as a change of the whole vector; elsewhere it stays as it is."""
    for w in range(count(memory, WIRE_COUNT)):
        wire = wire_of(memory, w)
        if wire[UNKNOWN] != NOWHERE:
            first = int(wire[FIRST])
            at = int(wire[UNKNOWN])
            nominal = wire[NOMINAL]
            for k in range(int(wire[ELEMENTS])):
                change[first + k] = reduced[at + k] * nominal


@compiled
def gathered(memory: np.ndarray, whole: np.ndarray, reduced: np.ndarray):
    """Unknowns among the whole vector, scaled."""
    for w in range(count(memory, WIRE_COUNT)):
        wire = wire_of(memory, w)
        if wire[UNKNOWN] != NOWHERE:
            first = int(wire[FIRST])
            at = int(wire[UNKNOWN])
            nominal = wire[NOMINAL]
            for k in range(int(wire[ELEMENTS])):
                reduced[at + k] = whole[first + k] / nominal


@compiled
def allowed(memory: np.ndarray, limits: np.ndarray):
    """Tolerance of every unknown over its nominal value."""
    for w in range(count(memory, WIRE_COUNT)):
        wire = wire_of(memory, w)
        if wire[UNKNOWN] != NOWHERE:
            at = int(wire[UNKNOWN])
            for k in range(int(wire[ELEMENTS])):
                limits[at + k] = wire[TOLERANCE] / wire[NOMINAL]


class Update(NamedTuple):
    """Products of a Newton update: those of all wires, by direction; change : room for another."""

    memory: np.ndarray
    products: np.ndarray
    change: np.ndarray


@compiled
def product(update: Update, k: int, direction: np.ndarray, out: np.ndarray):
    """The k-th product of I - J into `out`; whether all participants answered."""
    scattered(update.memory, direction, update.change)
    if not derivative(update.memory, update.change, update.products[k]):
        return False
    gathered(update.memory, update.products[k], out)
    keep(out, direction - out)
    return True


@compiled
def pairs_of(memory: np.ndarray):
    """What GMRES remembers."""
    kept = count(memory, KEPT)
    shape = (kept, count(memory, UNKNOWNS))
    return Pairs(
        part(memory, IMAGES).reshape(shape),
        part(memory, DIFFERENCES).reshape(shape),
        part(memory, GRAM).reshape((kept, kept)),
        part(memory, OLDEST),
    )


@compiled
def update(memory: np.ndarray, outcome: np.ndarray, change: np.ndarray):
    """Newton update of the whole vector into `change`; whether all participants answered."""
    n = count(memory, UNKNOWNS)
    right = np.empty(n)
    gathered(memory, outcome[OUTPUTS] - outcome[USED], right)
    constants = part(memory, CONSTANTS)
    limits = np.empty(n)
    allowed(memory, limits)
    goal = Goal(constants[ACCURACY] * limits, constants[FORCING] * length(right))
    pairs = pairs_of(memory)
    most = count(memory, SPACE)
    asked = Update(memory, np.empty((max(most, 1), len(change))), np.zeros(len(change)))
    solved = minimise(product, asked, right, goal, pairs, most)  # Eq. (Q1)
    if not solved.is_answered:
        return False
    products = len(solved.weights)
    overwrite(memory, products)
    learn(pairs, solved.space, products)
    if products > 0:
        keep(change, solved.weights @ asked.products[:products])
    elif not product(asked, 0, right, solved.x.copy()):
        return False
    else:
        keep(change, asked.products[0])
    scattered(memory, solved.x, change)
    return True


@compiled
def converge(memory: np.ndarray, guess: np.ndarray, numbers: np.ndarray, x: np.ndarray):
    """The macro step at its fixed point, as `Newton.solve`: the wires into `x`; False where it is
    not found, what failed put down.
    """
    n = len(guess)
    outcome = np.empty((3, n))
    change = np.empty(n)
    failures = part(memory, FAILURES)
    trail = part(memory, TRAIL)
    trail[EVALUATIONS] = 0.0
    trail[PRODUCTS] = 0.0
    if not evaluate(memory, guess, numbers, outcome):
        return False
    now = measure(memory, outcome[RESIDUAL])
    best = now
    done = 1
    while not now <= 1.0:
        trouble = -1
        if not np.isfinite(now):
            trouble = NOT_FINITE
        elif done > 3 and now > 1e3 * best:
            trouble = GROWS
        elif done == count(memory, ITERATIONS):
            trouble = TOO_MANY
        if trouble >= 0:
            refuse(failures, float(trouble), float(done), 0.0, now, best, 0.0)
            note_worst(memory, outcome[RESIDUAL])
            return False
        if not update(memory, outcome, change):
            return False
        if not evaluate(memory, moved(memory, outcome[USED], change), numbers, outcome):
            return False
        now = measure(memory, outcome[RESIDUAL])
        best = min(best, now)
        done += 1
    keep(x, outcome[USED])
    return True
