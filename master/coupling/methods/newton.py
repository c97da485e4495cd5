"""Interface Newton-Krylov: the fixed point of a macro step by directional derivatives."""

from dataclasses import dataclass
from functools import partial

import numpy as np

from .krylov import Goal, RecycledGmres
from .probing import ProbedStep
from .solution import NotConverged, Solution, Tried, check_finite, step_length

SINGULAR = 1e-8
"""Largest |(I - J) dx| / |dx| of a loop that counts as singular; differences are good to 1e-11."""
STALLED = 0.5
"""The second half of an iteration that stays above this share of the first half's best has stalled.
"""


@dataclass(frozen=True)
class Newton:
    """Interface Newton-Krylov on directional derivatives.

    Eq. (Q1):  (I - J) dx = G(x) - x,   J = dG/dx,   G(x): the feedback wires evaluated at x

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
    accuracy: float = 0.01
    forcing: float = 1e-6
    differences: bool = False

    def memory(self) -> RecycledGmres:
        return RecycledGmres(self.largest_krylov_space)

    def solve(self, macro_step: Tried, guess: np.ndarray, memory: RecycledGmres) -> Solution:
        if self.differences:
            solution = self._iterate(ProbedStep(macro_step), guess, memory)
            return solution._replace(products=0, probes=solution.products)
        return self._iterate(macro_step, guess, memory)

    def _iterate(self, macro_step: Tried, guess: np.ndarray, memory: RecycledGmres) -> Solution:
        interface = macro_step.interface
        at = macro_step.evaluate(guess)
        history = [interface.measure(at.residual, at.outputs)]
        products = 0
        first = None
        while history[-1] > 1.0 or np.isnan(history[-1]):
            check_finite(interface, at, history)
            if failure := self._failure(history):
                stop = NotConverged(failure, interface, at, history)
                stop.cause = partial(_cause, macro_step, guess, first, history)
                raise stop
            allowed = interface.allowed(at.outputs)
            change, count = self._update(macro_step, at.outputs - at.used, allowed, memory)
            products += count
            first = change if first is None else first
            at = macro_step.evaluate(at.used + step_length(interface, at.used, change) * change)
            history.append(interface.measure(at.residual, at.outputs))
        return Solution(at.used, tuple(history), len(history) - 1, products)

    def _failure(self, history: list[float]) -> str | None:
        """Return why the iteration ends without a solution, or None."""
        if len(history) > 3 and history[-1] > 1e3 * min(history):
            return "the residual grows"
        if len(history) == self.max_iterations:
            return f"no convergence in {self.max_iterations} iterations"
        return None

    def _update(
        self,
        macro_step: Tried,
        residual: np.ndarray,
        allowed: np.ndarray,
        memory: RecycledGmres,
    ) -> tuple[np.ndarray, int]:
        """Newton update of the whole vector, and the number of products it took."""
        interface = macro_step.interface
        unknowns = interface.unknowns
        scale = interface.nominal[unknowns]
        seed = np.zeros(interface.size)
        changes: list[np.ndarray] = []

        def directional(reduced: np.ndarray) -> np.ndarray:
            seed[unknowns] = reduced * scale
            changes.append(macro_step.derivative(seed))
            return reduced - changes[-1][unknowns] / scale

        right = residual[unknowns] / scale
        if right.size == 1:
            pivot = directional(np.ones(1))
            solution = right / pivot if pivot[0] else np.zeros(1)  # Eq. (Q1)
            change = solution * changes[0]
            change[unknowns] = solution * scale
            return change, 1
        goal = Goal(
            self.accuracy * allowed[unknowns] / scale,
            self.forcing * float(np.linalg.norm(right)),
        )
        solution, weights, *_ = memory.solve(directional, right, goal)  # Eq. (Q1)
        if len(weights):
            change = weights @ np.array(changes)
        else:
            directional(solution)
            change = changes[0]
        change[unknowns] = solution * scale
        return change, len(changes)


def _cause(
    macro_step: Tried, guess: np.ndarray, first: np.ndarray | None, history: list[float]
) -> str:
    """Return the likely cause of a failure, from the first update and the history."""
    half = len(history) // 2
    if first is None or not half:
        return "there was no update"
    unknowns = macro_step.interface.unknowns
    scale = macro_step.interface.nominal[unknowns]
    macro_step.evaluate(guess)
    left = first[unknowns] - macro_step.derivative(first)[unknowns]
    if np.linalg.norm(left / scale) <= SINGULAR * np.linalg.norm(first[unknowns] / scale):
        return "the loop has no solution near here, its equations are singular"
    if min(history[half:]) > STALLED * min(history[:half]):
        return "the residual stalls; an output jumps, or the loop has no solution"
    return "the loop is far from its solution; take a shorter macro step"
