"""Interface Newton-Krylov: the fixed point of a macro step by directional derivatives."""

from dataclasses import dataclass, replace

import numpy as np

from .krylov import RecycledGmres
from .probing import ProbedStep
from .solution import NotConverged, Solution, step_length


@dataclass(frozen=True)
class Newton:
    """Interface Newton-Krylov on directional derivatives.

    Eq. (C1):  (I - J) dx = G(x) - x,   J = dG/dx,   G(x) = the feedback wires after a sweep from x

    J comes as products, one directional derivative of every participant each; GMRES needs few of
    them because it starts from what it learned in the last solves.

    Parameters
    ----------
    max_iterations : int
        Sweeps a macro step.
    largest_krylov_space : int
        Products a linear solve.
    accuracy : float
        GMRES stops at this share of the tolerance ...
    forcing : float
        ... or at this share of the right-hand side, whichever is larger: the next nonlinear
        residual spoils the rest.
    differences : bool
        Products by differences of sweeps (rollback), also where the participants offer derivatives.
    """

    max_iterations: int = 20
    largest_krylov_space: int = 120
    accuracy: float = 0.1
    forcing: float = 1e-6
    differences: bool = False

    def memory(self):
        return RecycledGmres(self.largest_krylov_space)

    def solve(self, macro_step, guess, memory):
        if self.differences:
            solution = self._iterate(ProbedStep(macro_step), guess, memory)
            return replace(solution, products=0, probes=solution.products)
        return self._iterate(macro_step, guess, memory)

    def _iterate(self, macro_step, guess, memory):
        interface, x, history, products = macro_step.interface, guess, [], 0
        for jacobians in range(self.max_iterations):
            used, y, residual = macro_step.sweep(x)
            history.append(interface.measure(residual, y))
            if history[-1] <= 1.0:
                return Solution(used, tuple(history), jacobians, products)
            if not np.isfinite(history[-1]):
                raise NotConverged(
                    "a participant's output is not finite", interface, residual, y, history
                )
            if len(history) > 3 and history[-1] > 1e3 * min(history):
                raise NotConverged("the residual grows", interface, residual, y, history)
            change, count = self._update(macro_step, y - used, interface.allowed(y), memory)
            products += count
            x = used + step_length(interface, used, change) * change
        raise NotConverged(
            f"no convergence in {self.max_iterations} iterations", interface, residual, y, history
        )

    def _update(self, macro_step, residual, allowed, memory):
        """Newton update of the whole vector, Eq. (C1), and the number of products it took."""
        interface, feedback = macro_step.interface, macro_step.interface.feedback
        scale = interface.nominal[feedback]

        def sweep(reduced):
            change = np.zeros(interface.size)
            change[feedback] = reduced * scale
            return macro_step.linear_sweep(change)

        right = residual[feedback] / scale
        tolerance = max(
            self.accuracy * np.min(allowed[feedback] / scale), self.forcing * np.linalg.norm(right)
        )
        solution, count = memory.solve(lambda v: v - sweep(v)[feedback] / scale, right, tolerance)
        change = sweep(solution)
        change[feedback] = solution * scale
        return change, count + 1
