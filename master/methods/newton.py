"""Interface Newton-Krylov: the fixed point of a macro step by directional derivatives."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse.linalg import LinearOperator, gmres

from .solution import NotConverged, Solution, step_length


@dataclass(frozen=True)
class Newton:
    """Interface Newton-Krylov on directional derivatives.

    Eq. (C1):  (I - J) dx = G(x) - x,   J = dG/dx,   G(x) = outputs of all participants stepped with inputs x

    All participants read the same iterate, so the residual of every wire is measured, not implied. The linear system is
    reduced to the feedback wires by one linearised sweep and solved by GMRES without a matrix.

    Parameters
    ----------
    max_iterations : int
        Sweeps a macro step.
    largest_krylov_space : int
        Products a linear solve.
    accuracy : float
        GMRES stops at this share of the tolerance ...
    forcing : float
        ... or at this share of the right-hand side, whichever is larger: the next nonlinear residual spoils the rest.
    """

    max_iterations: int = 20
    largest_krylov_space: int = 120
    accuracy: float = 0.1
    forcing: float = 1e-6

    def memory(self):
        return None

    def solve(self, macro_step, guess, memory=None):
        interface, x, history, products = macro_step.interface, guess, [], 0
        for jacobians in range(self.max_iterations):
            _, y = macro_step.sweep(x, sequential=False)
            residual = y - x
            history.append(interface.measure(residual, y))
            if history[-1] <= 1.0:
                return Solution(x, tuple(history), jacobians, products)
            if not np.isfinite(history[-1]):
                raise NotConverged("a participant's output is not finite", interface, residual, y, history)
            if len(history) > 3 and history[-1] > 1e3 * min(history):
                raise NotConverged("the residual grows", interface, residual, y, history)
            change, count = self._update(interface, residual, interface.allowed(y))
            products += count
            x = x + step_length(interface, x, change) * change
        raise NotConverged(f"no convergence in {self.max_iterations} iterations", interface, residual, y, history)

    def _update(self, interface, residual, allowed):
        """Newton update of the whole vector, Eq. (C1), and the number of products it took."""
        feedback, nothing = interface.feedback, np.zeros(interface.size)
        scale, products = interface.nominal[feedback], 0

        def sweep(reduced, source):
            nonlocal products
            products += 1
            change = nothing.copy()
            change[feedback] = reduced * scale
            return interface.linear_sweep(change, source)

        def apply(reduced):
            return reduced - sweep(reduced, nothing)[feedback] / scale

        right = sweep(np.zeros(scale.size), residual)[feedback] / scale
        tight = self.accuracy * np.min(allowed[feedback] / scale)
        solution, _ = gmres(LinearOperator((right.size, right.size), apply, dtype=float), right, rtol=0.0,
                            atol=max(tight, self.forcing * np.linalg.norm(right)), restart=self.largest_krylov_space, maxiter=1)
        change = sweep(solution, residual)
        change[feedback] = solution * scale
        return change, products
