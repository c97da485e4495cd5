"""Interface Newton-Krylov: the fixed point of a macro step by directional derivatives."""

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from .iteration import FAILURES, NO_FAILURE, SENTENCES, Answer, Update, converge, field_update
from .krylov import RecycledGmres
from .probing import ProbedStep
from .solution import NotConverged, Solution, Tried, check_finite

SINGULAR_RATIO = 1e-8
"""Largest |(I - J) dx| / |dx| of a loop that counts as singular. The error of differences is
1e-11."""
STALL_RATIO = 0.5
"""The second half of an iteration that stays above this share of the first half's best has stalled.
"""


@dataclass(frozen=True)
class Newton:
    """Interface Newton-Krylov on directional derivatives, see `iteration.converge`.

    J comes as products, one directional derivative of every participant each; GMRES needs few of
    them because it starts from what it learned in the last solves.

    Parameters
    ----------
    max_iterations : int
        Evaluations a macro step.
    largest_krylov_space : int
        Products a linear solve.
    accuracy : float
        GMRES stops where no element is larger than this share of its tolerance ...
    forcing : float
        ... or at this share of the right-hand side: the next nonlinear residual spoils the rest.
    differences : bool
        Products by differences of evaluations (rollback), also where the participants offer
        derivatives.
    """

    max_iterations: int = 20
    largest_krylov_space: int = 120
    accuracy: float = 0.1
    forcing: float = 1e-6
    differences: bool = False

    def memory(self) -> RecycledGmres:
        return RecycledGmres()

    def solve(self, macro_step: Tried, guess: np.ndarray, memory: RecycledGmres) -> Solution:
        if self.differences:
            solution = self._iterate(ProbedStep(macro_step), guess, memory)
            return solution._replace(products=0, probes=solution.products)
        return self._iterate(macro_step, guess, memory)

    def _iterate(self, macro_step: Tried, guess: np.ndarray, memory: RecycledGmres) -> Solution:
        interface = macro_step.interface
        pairs = memory.pairs_of(len(interface.unknowns))
        end: Any = converge(_evaluate, _update, macro_step, guess, self, interface.layout, pairs)
        history = end.history.tolist()
        if end.failure == FAILURES.not_finite:
            check_finite(interface, end.at, history)
        if end.failure != NO_FAILURE:
            reason = tuple(SENTENCES.values())[int(end.failure)].partition(":")[0]
            stop = NotConverged(reason.format(i=len(history)), interface, end.at, history)
            stop.cause = partial(_cause, macro_step, guess, end.first, history)
            raise stop
        return Solution(end.at.used, tuple(history), len(history) - 1, end.products)


def _evaluate(macro_step: Tried, x: np.ndarray) -> Answer:
    """Return the answer of a macro step to an iterate."""
    interface = macro_step.interface
    at = macro_step.evaluate(x)
    measure = interface.measure(at.residual, at.outputs)
    return Answer(at, measure, interface.allowed(at.outputs))


def _update(macro_step: Tried, *arguments: Any) -> Update:
    """Return the Newton update at an evaluation."""
    return field_update(_derivative, macro_step, *arguments)


def _derivative(macro_step: Tried, change: np.ndarray, out: np.ndarray) -> bool:
    """Write the derivative of a macro step in a direction."""
    out[:] = macro_step.derivative(change)
    return True


def _cause(macro_step: Tried, guess: np.ndarray, first: np.ndarray, history: list[float]) -> str:
    """Return the likely cause of a failure, from the first update and the history."""
    half = len(history) // 2
    if not len(first) or not half:
        return "there was no update"
    unknowns = macro_step.interface.unknowns
    scale = macro_step.interface.nominal[unknowns]
    macro_step.evaluate(guess)
    left = first[unknowns] - macro_step.derivative(first)[unknowns]
    if np.linalg.norm(left / scale) <= SINGULAR_RATIO * np.linalg.norm(first[unknowns] / scale):
        return "the loop has no solution near here, its equations are singular"
    if min(history[half:]) > STALL_RATIO * min(history[:half]):
        return "the residual stalls; an output jumps, or the loop has no solution"
    return "the loop is far from its solution; take a shorter macro step"
