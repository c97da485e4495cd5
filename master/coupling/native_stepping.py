"""Macro steps of a coupled FMU without Python, as `stepping` and `coupled`."""

import numpy as np

from ..fmi.block import keep
from ..fmi.compiled import compiled
from ..fmi.noted import refuse, take_over
from .native_block import FAULT, CoupledState, parts_of, rules_of, state_of
from .native_system import find, restore, save, system_of
from .vector import MOST_STEPS, extrapolate, macro_step_end, moved


@compiled
def forget_products(state: CoupledState):
    """Clear the memory of GMRES."""
    pairs = state.pairs
    for table in (pairs.gram, pairs.images, pairs.differences):
        keep(table.reshape(table.size), np.zeros(table.size))
    pairs.oldest[0] = 0.0


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
def macro_step(memory: np.ndarray, time: float, step: float):
    """Take a macro step or halves of it, as `Stepper._step`; return False and note why if none."""
    system = system_of(memory)
    state = state_of(memory)
    halvings = rules_of(memory).halvings
    depth = done = 0  # halvings, and parts of this length that are done
    while done < 1 << depth:
        length = step / (1 << depth)
        begin = time + done * length
        save(system)
        known = int(state.known[0])
        last = state.past[known - 1]
        x = extrapolate(state.times[:known], state.past[:known], begin + length)
        x = moved(system.layout, last, x - last)
        if find(memory, x, begin, length):
            accept(state, begin + length, x)
            done += 1
            while depth > 0 and done % 2 == 0:
                done //= 2
                depth -= 1
            continue
        restore(system)
        forget_past(state)
        forget_products(state)
        if depth == halvings:
            refuse(system.faults, FAULT.no_halving, 0.0, 0.0, begin, length, 0.0)
            take_over(system.faults, system.failures, 0.0)
            return False
        done *= 2
        depth += 1
    return True


@compiled
def reach(memory: np.ndarray, time: float, step: float):
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
        if not macro_step(memory, before, after - before):
            return False
    return True
