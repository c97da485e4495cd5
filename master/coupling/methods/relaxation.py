"""Fixed-point iteration with constant or Aitken's relaxation."""

from dataclasses import dataclass

import numpy as np

from .solution import NotConverged, Solution, step_length


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

    def memory(self):
        return None

    def solve(self, macro_step, guess, memory=None):
        interface, x, factor, history = macro_step.interface, guess, self.factor, []
        feedback, previous = interface.feedback, None
        for _ in range(self.max_iterations):
            used, y, residual = macro_step.sweep(x)
            history.append(interface.measure(residual, y))
            if history[-1] <= 1.0:
                return Solution(used, tuple(history))
            if not np.isfinite(y).all():
                raise NotConverged(
                    "a participant's output is not finite", interface, residual, y, history
                )
            r = ((y - used) / interface.nominal)[feedback]
            if self.dynamic and previous is not None:
                difference = r - previous
                factor *= -(previous @ difference) / (difference @ difference)  # Eq. (C3)
            previous, change = r, np.where(feedback, factor * (y - used), 0.0)  # Eq. (C2)
            x = used + step_length(interface, used, change) * change
        raise NotConverged(
            f"no convergence in {self.max_iterations} iterations", interface, residual, y, history
        )
