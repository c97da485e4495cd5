"""Fixed-point iteration with constant or Aitken's relaxation."""

from dataclasses import dataclass

import numpy as np

from ..vector import moved
from .iteration import accepted_of
from .solution import NotConverged, Solution, Tried, check_finite


@dataclass(frozen=True)
class Relaxation:
    """Fixed-point iteration with relaxation, participants one after the other.

    Eq. (Q2):  x_{k+1} = x_k + w_k r_k,   r_k = G(x_k) - x_k on the feedback wires
    Eq. (Q3):  w_{k+1} = -w_k r_k.(r_{k+1} - r_k) / |r_{k+1} - r_k|^2
               with dynamic relaxation (Aitken), scaled by nominals

    Parameters
    ----------
    factor : float
        w_0, and all w_k without dynamic relaxation.
    dynamic : bool
        Aitken's factor.
    max_iterations : int
        Evaluations a macro step.

    References
    ----------
    [Kuettler2008] U. Kuettler, W. A. Wall, Computational Mechanics 43, 61-72.
    """

    factor: float
    dynamic: bool
    max_iterations: int

    def memory(self) -> None:
        return None

    def solve(self, macro_step: Tried, guess: np.ndarray, memory: None = None) -> Solution:
        interface = macro_step.interface
        feedback = interface.feedback
        at = macro_step.evaluate(guess)
        history = [interface.measure(at.residual, at.outputs)]
        factor = self.factor
        previous = None
        while not history[-1] <= accepted_of(len(history), self.max_iterations):
            check_finite(interface, at, history)
            if len(history) == self.max_iterations:
                raise NotConverged(
                    f"no convergence in {self.max_iterations} iterations", interface, at, history
                )
            mismatch = at.outputs - at.used
            r = (mismatch / interface.nominal)[feedback]
            if self.dynamic and previous is not None:
                difference = r - previous
                factor *= -(previous @ difference) / (difference @ difference)  # Eq. (Q3)
            previous = r
            change = np.where(feedback, factor * mismatch, 0.0)  # Eq. (Q2)
            at = macro_step.evaluate(moved(interface.layout, at.used, change))
            history.append(interface.measure(at.residual, at.outputs))
        return Solution(at.used, tuple(history))
