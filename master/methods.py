"""Ways to the fixed point of a macro step: interface Newton-Krylov, Aitken's relaxation, constant relaxation.

A method is a value with `solve(interface, guess, time, step, saved)`. It returns a `Solution` in which every element of
every wire agrees to its tolerance, or raises `NotConverged`; it never returns anything else.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse.linalg import LinearOperator, gmres


@dataclass(frozen=True)
class Solution:
    """A converged macro step.

    x : what the inputs were set to; residual : outputs minus inputs; history : largest residual / tolerance of every
    iteration; jacobians : linearisations; products : directional derivatives of the whole sweep.
    """

    x: np.ndarray
    residual: np.ndarray
    history: tuple
    jacobians: int = 0
    products: int = 0

    @property
    def iterations(self):
        return len(self.history)


class NotConverged(RuntimeError):
    """The macro step did not reach its fixed point; carries where the worst residual is and the residual history."""

    def __init__(self, reason, interface, residual, history):
        self.iterations = len(history)
        trail = " ".join(f"{value:.2g}" for value in history)
        super().__init__(f"{reason}; worst {interface.worst(residual)}; residual/tolerance per iteration: {trail}")


def _measure(interface, residual):
    """Largest residual in units of its tolerance; NaN if any element is not finite."""
    return float(np.max(np.abs(residual) / interface.tolerance)) if residual.size else 0.0


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
        The linear residual is brought below this share of the tolerance, and of the square of the residual where that
        is larger: no more accuracy than the next nonlinear residual can use.
    """

    max_iterations: int = 20
    largest_krylov_space: int = 120
    accuracy: float = 0.1

    def solve(self, interface, guess, time, step, saved):
        x, history, products = guess, [], 0
        for jacobians in range(self.max_iterations):
            _, y = interface.sweep(x, time, step, saved, sequential=False)
            residual = y - x
            history.append(_measure(interface, residual))
            if history[-1] <= 1.0:
                return Solution(x, residual, tuple(history), jacobians, products)
            if not np.isfinite(history[-1]):
                raise NotConverged("a participant's output is not finite", interface, residual, history)
            if len(history) > 3 and history[-1] > 1e3 * min(history):
                raise NotConverged("the residual grows", interface, residual, history)
            change, count = self._update(interface, residual, history[-1])
            products += count
            x = x + step_length(interface, x, change) * change
        raise NotConverged(f"no convergence in {self.max_iterations} iterations", interface, residual, history)

    def _update(self, interface, residual, measure):
        """Newton update of the whole vector and the number of products it took."""
        feedback, scale = interface.feedback, interface.nominal[interface.feedback]
        nothing, count = np.zeros(interface.size), 1
        right = interface.linear_sweep(nothing, residual)[feedback] / scale

        def apply(v):
            nonlocal count
            count += 1
            change = nothing.copy()
            change[feedback] = v * scale
            return v - interface.linear_sweep(change, nothing)[feedback] / scale

        tight = self.accuracy * np.min(interface.tolerance[feedback] / scale)
        solution, _ = gmres(LinearOperator((right.size, right.size), apply, dtype=float), right, rtol=0.0,
                            atol=max(tight, self.loosest * np.linalg.norm(right)), restart=self.largest_krylov_space, maxiter=1)
        change = nothing.copy()
        change[feedback] = solution * scale
        full = interface.linear_sweep(change, residual)
        full[feedback] = change[feedback]
        return full, count + 1

    loosest: float = 1e-6


@dataclass(frozen=True)
class Relaxation:
    """Fixed-point iteration with relaxation, participants one after the other.

    Eq. (C2):  x_{k+1} = x_k + w_k r_k,   r_k = G(x_k) - x_k on the feedback wires
    Eq. (C3):  w_{k+1} = -w_k r_k.(r_{k+1} - r_k) / |r_{k+1} - r_k|^2   with dynamic relaxation (Aitken), scaled by nominals

    Parameters
    ----------
    factor : float
        w_0, and all w_k without dynamic relaxation.
    dynamic : bool
        Aitken's factor.
    max_iterations : int
        Sweeps a macro step.

    References
    ----------
    Kuettler and Wall (2008), Computational Mechanics 43, 61-72.
    """

    factor: float
    dynamic: bool
    max_iterations: int

    def solve(self, interface, guess, time, step, saved):
        x, factor, previous, before, history = guess, self.factor, None, None, []
        feedback = interface.feedback
        for _ in range(self.max_iterations):
            used, y = interface.sweep(x, time, step, saved, sequential=True)
            residual = np.where(feedback, y - used, np.inf if before is None else used - before)
            before = used
            history.append(_measure(interface, residual))
            if history[-1] <= 1.0:
                return Solution(used, residual, tuple(history))
            if not np.isfinite(y).all():
                raise NotConverged("a participant's output is not finite", interface, residual, history)
            r = ((y - used) / interface.nominal)[feedback]
            if self.dynamic and previous is not None:
                difference = r - previous
                factor *= -(previous @ difference) / (difference @ difference)      # Eq. (C3)
            previous, change = r, np.where(feedback, factor * (y - used), 0.0)      # Eq. (C2)
            x = used + step_length(interface, used, change) * change
        raise NotConverged(f"no convergence in {self.max_iterations} iterations", interface, residual, history)


def step_length(interface, x, change):
    """Largest share <= 1 of `change` that respects every wire's `largest_decrease`.

    The smallest element m of such a wire may go down to m - s max(m, nominal/10), s = largest_decrease.
    """
    share = 1.0
    for connection, part in zip(interface.connections, interface.parts):
        down = change[part] < 0
        if connection.largest_decrease is None or not down.any():
            continue
        smallest = x[part].min()
        floor = smallest - connection.largest_decrease * max(smallest, connection.nominal / 10)
        share = min(share, float(np.min((x[part] - floor)[down] / -change[part][down])))
    return share


def method_of(coupling):
    """The method a case's coupling table asks for."""
    if coupling.method == "newton":
        return Newton(coupling.max_iterations, coupling.largest_krylov_space)
    return Relaxation(coupling.relaxation, coupling.method == "aitken", coupling.max_iterations)
