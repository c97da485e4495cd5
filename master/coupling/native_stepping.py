"""Macro steps of a coupled slave without Python: predict, converge, accept or halve; as `stepping`
and `coupled`.
"""

import numpy as np

from ..fmi.block import keep, part
from ..fmi.compiled import compiled
from ..fmi.noted import refuse, take_over
from .native_block import (
    CONSTANTS,
    DIFFERENCES,
    FAILURES,
    FAULTS_AT,
    GRAM,
    HALVINGS,
    IMAGES,
    KEPT,
    LENIENCE,
    NO_HALVING,
    OLDEST,
    PAST,
    REMEMBERED,
    SAVED,
    SIZE,
    STEP,
    TIMES,
    TOO_LONG,
    clear,
    count,
)
from .native_journal import overwrite
from .native_newton import converge, moved, restore, save

MOST_STEPS = 1e6
"""In one communication step: 1400 cycles of the shipped cases."""


@compiled
def forget_products(memory: np.ndarray):
    """Begin the Krylov method's memory anew."""
    overwrite(memory, count(memory, KEPT))
    for which in (OLDEST, IMAGES, DIFFERENCES, GRAM):
        clear(part(memory, which))


@compiled
def past_of(memory, k):
    """The k-th of the accepted vectors, the oldest first."""
    n = count(memory, SIZE)
    return part(memory, PAST)[k * n : (k + 1) * n]


@compiled
def accept(memory: np.ndarray, time: float, x: np.ndarray):
    """Note an accepted vector; `times` begins with how many there are."""
    times = part(memory, TIMES)
    known = int(times[0])
    if known == count(memory, REMEMBERED):
        for k in range(1, known):
            times[k] = times[k + 1]
            keep(past_of(memory, k - 1), past_of(memory, k))
        known -= 1
    times[known + 1] = time
    keep(past_of(memory, known), x)
    times[0] = known + 1.0


@compiled
def forget_past(memory):
    """Forget all accepted vectors but the last."""
    times = part(memory, TIMES)
    last = int(times[0]) - 1
    if last > 0:
        times[1] = times[last + 1]
        keep(past_of(memory, 0), past_of(memory, last))
    times[0] = 1.0


@compiled
def predicted(memory: np.ndarray, time: float):
    """Guess at `time` [s], as `Predictor`, no further from the last vector than is allowed."""
    times = part(memory, TIMES)
    known = int(times[0])
    last = past_of(memory, known - 1)
    change = np.zeros(len(last))
    if known == 1:
        return last.copy()
    for a in range(known):
        weight = 1.0
        for b in range(known):
            if times[b + 1] != times[a + 1]:
                weight *= (time - times[b + 1]) / (times[a + 1] - times[b + 1])
        x = past_of(memory, a)
        for k in range(len(change)):
            change[k] += x[k] * weight
    for k in range(len(change)):
        change[k] -= last[k]
    return moved(memory, last, change)


@compiled
def macro_step(memory: np.ndarray, time: float, step: float):
    """One macro step or halves of it, as `Stepper._step`; False where no halving is left, why put
    down among the faults.
    """
    halvings = count(memory, HALVINGS)
    begins = np.empty(halvings + 2)
    lengths = np.empty(halvings + 2)
    left = np.empty(halvings + 2)
    begins[0] = time
    lengths[0] = step
    left[0] = halvings
    waiting = 1
    numbers = np.zeros(4)
    x = np.empty(count(memory, SIZE))
    failures = part(memory, FAILURES)
    while waiting > 0:
        waiting -= 1
        begin = begins[waiting]
        length = lengths[waiting]
        numbers[0] = length
        numbers[1] = begin
        failures[0] = 0.0
        save(memory, SAVED)
        if converge(memory, predicted(memory, begin + length), numbers, x):
            accept(memory, begin + length, x)
            continue
        restore(memory, SAVED)
        forget_past(memory)
        forget_products(memory)
        if left[waiting] == 0.0:
            report(memory, begin, length)
            return False
        left[waiting] -= 1.0
        left[waiting + 1] = left[waiting]
        lengths[waiting] = length / 2
        lengths[waiting + 1] = length / 2
        begins[waiting] = begin + length / 2
        begins[waiting + 1] = begin
        waiting += 2
    return True


@compiled
def report(memory, time, step):
    """Why a macro step failed, among the faults."""
    faults = part(memory, FAULTS_AT)
    failures = part(memory, FAILURES)
    refuse(faults, float(NO_HALVING), 0.0, 0.0, time, step, 0.0)
    take_over(faults, failures, 0.0)


@compiled
def reach(memory: np.ndarray, time: float, step: float):
    """Macro steps up to time + step, as `Coupled.advance`; False where one of them failed, or where
    there would be more than can be meant.
    """
    constants = part(memory, CONSTANTS)
    asked = np.ceil(step / constants[STEP] / (1.0 + constants[LENIENCE]))
    if not asked <= MOST_STEPS:
        faults = part(memory, FAULTS_AT)
        refuse(faults, float(TOO_LONG), 0.0, 0.0, step, float(MOST_STEPS), constants[STEP])
        return False
    steps = int(asked)
    for k in range(steps):
        before = time + step * k / steps
        after = time + step * (k + 1) / steps
        if not macro_step(memory, before, after - before):
            return False
    return True
