"""No iteration: the loose coupling of most co-simulation tools."""

from dataclasses import dataclass

import numpy as np

from .solution import Solution, Tried, check_finite


@dataclass(frozen=True)
class Explicit:
    """One evaluation from the predicted iterate, accepted as it is; its residual tells how far the
    wires are from agreeing. The next step is predicted from what the outputs then say.

    Stable only where the coupling is weak: film and piston amplify an error some hundred-fold a
    step.
    """

    def memory(self) -> None:
        return None

    def solve(self, macro_step: Tried, guess: np.ndarray, memory: None = None) -> Solution:
        interface = macro_step.interface
        at = macro_step.evaluate(guess)
        history = (interface.measure(at.residual, at.outputs),)
        check_finite(interface, at, history)
        return Solution(at.outputs, history, held=at.used)
