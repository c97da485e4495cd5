"""No iteration: the loose coupling of most co-simulation tools."""

from dataclasses import dataclass

import numpy as np

from .solution import NotConverged, Solution


@dataclass(frozen=True)
class Explicit:
    """One sweep from the predicted iterate, accepted as it is; its residual tells how far the wires
    are from agreeing. The next step is predicted from what the outputs then say.

    Stable only where the coupling is weak: film and piston amplify an error some hundred-fold a
    step.
    """

    def memory(self):
        return None

    def solve(self, macro_step, guess, memory=None):
        interface = macro_step.interface
        used, y, residual = macro_step.sweep(guess)
        history = (interface.measure(residual, y),)
        if not np.isfinite(y).all():
            raise NotConverged(
                "a participant's output is not finite", interface, residual, y, history
            )
        return Solution(y, history, held=used)
