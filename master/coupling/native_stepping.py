"""Macro steps of a coupled slave without Python: predict, converge, accept or halve; as `stepping`
and `coupled`.
"""

import numpy as np

from ..fmi.block import keep
from ..fmi.compiled import compiled
from ..fmi.noted import refuse, take_over
from .native_block import FAULT, State, faults_of, rules_of, state_of
from .native_system import find, restore, save, system_of
from .vector import extrapolate, moved

MOST_STEPS = 1e6
"""In one communication step: 1400 cycles of the shipped cases."""


@compiled
def forget_products(state: State):
    """Clear the memory of GMRES."""
    pairs = state.pairs
    keep(pairs.gram.reshape(pairs.gram.size), np.zeros(pairs.gram.size))
    pairs.oldest[0] = 0.0


@compiled
def accept(state: State, time: float, x: np.ndarray):
    """Note an accepted vector."""
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
def forget_past(state: State):
    """Forget all accepted vectors but the last."""
    last = int(state.known[0]) - 1
    state.times[0] = state.times[last]
    keep(state.past[0], state.past[last])
    state.known[0] = 1.0


@compiled
def macro_step(memory: np.ndarray, time: float, step: float):
    """One macro step or halves of it, as `Stepper._step`; False where no halving is left, why put
    down among the faults.
    """
    system = system_of(memory)
    state = state_of(memory)
    halvings = rules_of(memory).halvings
    begins = np.empty(halvings + 2)
    lengths = np.empty(halvings + 2)
    left = np.empty(halvings + 2)
    begins[0] = time
    lengths[0] = step
    left[0] = halvings
    waiting = 1
    x = np.empty(state.past.shape[1])
    while waiting > 0:
        waiting -= 1
        begin = begins[waiting]
        length = lengths[waiting]
        system.failures[0] = 0.0
        save(system)
        known = int(state.known[0])
        last = state.past[known - 1]
        guess = extrapolate(state.times[:known], state.past[:known], begin + length)
        guess = moved(system.layout, last, guess - last)
        if find(memory, guess, begin, length, x):
            accept(state, begin + length, x)
            continue
        restore(system)
        forget_past(state)
        forget_products(state)
        if left[waiting] == 0.0:
            refuse(system.faults, FAULT.no_halving, 0.0, 0.0, begin, length, 0.0)
            take_over(system.faults, system.failures, 0.0)
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
def reach(memory: np.ndarray, time: float, step: float):
    """Macro steps up to time + step, as `Coupled.advance`; False where one of them failed, or where
    there would be more than can be meant.
    """
    rules = rules_of(memory)
    asked = np.ceil(step / rules.step / (1.0 + rules.lenience))
    if not asked <= MOST_STEPS:
        refuse(faults_of(memory), FAULT.too_long, 0.0, 0.0, step, float(MOST_STEPS), rules.step)
        return False
    steps = int(asked)
    for k in range(steps):
        before = time + step * k / steps
        after = time + step * (k + 1) / steps
        if not macro_step(memory, before, after - before):
            return False
    return True
