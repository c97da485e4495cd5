"""A macro step to its fixed point as machine code, as `methods.newton`, where the equations are."""

from typing import NamedTuple

import numpy as np

from ..fmi.block import keep
from ..fmi.compiled import compiled
from ..fmi.noted import refuse
from .evaluation import Evaluation
from .methods.krylov import Goal, learn, length, minimise
from .native_block import FAULT, Rules, rules_of, state_of
from .native_system import (
    System,
    derivative,
    evaluate,
    gather,
    measure,
    moved,
    note_worst,
    scatter,
    system_of,
    tolerances,
)


class Update(NamedTuple):
    """Products of a Newton update: those of all wires, by direction; change : room for another."""

    system: System
    products: np.ndarray
    change: np.ndarray


@compiled
def product(update: Update, k: int, direction: np.ndarray, out: np.ndarray):
    """The k-th product of I - J into `out`; whether all participants answered."""
    scatter(update.system, direction, update.change)
    if not derivative(update.system, update.change, update.products[k]):
        return False
    gather(update.system, update.products[k], out)
    keep(out, direction - out)
    return True


@compiled
def update(memory: np.ndarray, system: System, rules: Rules, at: Evaluation, change: np.ndarray):
    """Newton update of the whole vector into `change`; whether all participants answered."""
    pairs = state_of(memory).pairs
    right = np.empty(pairs.images.shape[1])
    gather(system, at.outputs - at.used, right)
    limits = np.empty(len(right))
    tolerances(system, change)
    gather(system, change, limits)
    goal = Goal(rules.accuracy * limits, rules.forcing * length(right))
    products = np.empty((max(rules.space, 1), len(change)))
    asked = Update(system, products, np.zeros(len(change)))
    solved = minimise(product, asked, right, goal, pairs, rules.space)  # Eq. (Q1)
    count = len(solved.weights)
    if not solved.is_answered:
        return False
    if count == 0 and not product(asked, count, right, np.empty(len(right))):
        return False
    learn(pairs, solved.space, count)
    keep(change, solved.weights @ products[:count] if count > 0 else products[0])
    scatter(system, solved.x, change)
    return True


@compiled
def converge(memory: np.ndarray, guess: np.ndarray, time: float, step: float, x: np.ndarray):
    """The macro step at its fixed point, as `Newton.solve`: the wires into `x`; False where it is
    not found, what failed put down.
    """
    system = system_of(memory)
    rules = rules_of(memory)
    n = len(guess)
    at = Evaluation(np.empty(n), np.empty(n), np.empty(n))
    change = np.empty(n)
    system.trail.evaluations[0] = 0.0
    system.trail.products[0] = 0.0
    if not evaluate(system, guess, time, step, at):
        return False
    now = measure(system, at.residual)
    best = now
    done = 1
    while not now <= 1.0:
        trouble = -1.0
        if not np.isfinite(now):
            trouble = FAULT.not_finite
        elif done > 3 and now > 1e3 * best:
            trouble = FAULT.grows
        elif done == rules.iterations:
            trouble = FAULT.too_many
        if trouble >= 0.0:
            refuse(system.failures, trouble, float(done), 0.0, now, best, 0.0)
            note_worst(system, at.residual)
            return False
        if not update(memory, system, rules, at, change):
            return False
        if not evaluate(system, moved(system, at.used, change), time, step, at):
            return False
        now = measure(system, at.residual)
        best = min(best, now)
        done += 1
    keep(x, at.used)
    return True
