"""Interface quasi-Newton with an inverse Jacobian from least squares (IQN-ILS, Anderson acceleration)."""

from dataclasses import dataclass, field

import numpy as np

from .filtering import filtered
from .solution import NotConverged, Solution, step_length


@dataclass
class Secants:
    """Secant pairs, newest first: differences of residuals (columns of V) and of sweep results (columns of W).

    `past` holds those of the last accepted macro steps, `now` those of the running one.
    """

    now: list = field(default_factory=list)
    past: list = field(default_factory=list)

    def columns(self):
        return self.now + [pair for window in self.past for pair in window]

    def close(self, windows):
        """The macro step is accepted: keep its pairs among those of the last `windows` steps."""
        self.past, self.now = ([self.now, *self.past] if self.now else self.past)[:windows], []


@dataclass(frozen=True)
class QuasiNewton:
    """IQN-ILS, participants one after the other.

    Eq. (C4):  x_{k+1} = x_k + (W - V) c + m (r_k + V c),   c = argmin |V c + r_k|,   r_k = G(x_k) - x_k on the feedback wires
               V = [.., r_k - r_{k-1}, ..],  W = [.., G(x_k) - G(x_{k-1}), ..], this macro step's and some earlier ones'

    With the mixing factor m = 1 this is IQN-ILS, with m < 1 Anderson's mixing: what the secants do not explain, r_k + V c,
    is relaxed instead of taken whole, which matters where many directions amplify.

    The least squares run in scaled values: nominals first, then each wire divided by its share of the residuals seen in
    this macro step, so that no field drowns another.

    Parameters
    ----------
    relaxation : float
        Factor of the first update, while there are no secants.
    mixing : float
        m.
    windows : int
        Accepted macro steps whose secants are used again.
    limit : float
        Filter: a column is dropped if less than this share of it is new (QR2), or its share of the whole of R (QR1).
    rule : {"QR1", "QR2"}
    max_iterations : int
        Sweeps a macro step.

    References
    ----------
    Degroote, Bathe, Vierendeels (2009), Computers and Structures 87, 793-801. Filters: Haelterman et al. (2016),
    Computers and Structures 171, 9-17.
    """

    relaxation: float = 0.1
    mixing: float = 1.0
    windows: int = 3
    limit: float = 1e-2
    rule: str = "QR2"
    max_iterations: int = 50

    def memory(self):
        return Secants()

    def solve(self, macro_step, guess, memory):
        interface, x, history = macro_step.interface, guess, []
        feedback, scale = interface.feedback, interface.nominal[interface.feedback]
        memory.now, last, shares = [], None, 0.0
        for _ in range(self.max_iterations):
            used, y, residual = macro_step.sweep(x)
            history.append(interface.measure(residual, y))
            if history[-1] <= 1.0:
                memory.close(self.windows)
                return Solution(used, tuple(history))
            if not np.isfinite(y).all():
                raise NotConverged("a participant's output is not finite", interface, residual, y, history)
            r, result = (y - used)[feedback] / scale, y[feedback] / scale
            if last is not None:
                memory.now.insert(0, (r - last[0], result - last[1]))
            last, shares = (r, result), shares + self._shares(interface, r)
            change = np.zeros(interface.size)
            change[feedback] = self._update(memory.columns(), r, 1.0 / np.sqrt(shares)) * scale
            x = used + step_length(interface, used, change) * change
        raise NotConverged(f"no convergence in {self.max_iterations} iterations", interface, residual, y, history)

    def _update(self, columns, r, weight):
        """x_{k+1} - x_k in nominals, Eq. (C4)."""
        chosen, q, triangle = filtered([weight * v for v, _ in columns], self.limit, self.rule)
        if not chosen:
            return self.relaxation * r
        factors = np.linalg.solve(triangle, -(q.T @ (weight * r)))
        explained = sum(factor * columns[k][0] for factor, k in zip(factors, chosen))
        moved = sum(factor * columns[k][1] for factor, k in zip(factors, chosen))
        return moved - explained + self.mixing * (r + explained)

    @staticmethod
    def _shares(interface, r):
        """Share of each wire in the squared residual, spread over its elements."""
        full = np.zeros(interface.size)
        full[interface.feedback] = r
        total = max(r @ r, np.finfo(float).tiny)
        for part in interface.parts:
            full[part] = max(full[part] @ full[part] / total, 1e-16)
        return full[interface.feedback]
