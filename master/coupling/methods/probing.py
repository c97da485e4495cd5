"""Derivatives by differences, for participants without derivatives or on request."""

from collections.abc import Callable

import numpy as np

from ..interface import Evaluation
from .solution import Tried


class ProbedStep:
    """Macro step whose derivative is a difference of two evaluations; each calls `learn`."""

    def __init__(
        self,
        macro_step: Tried,
        learn: Callable[[np.ndarray, np.ndarray], None] = lambda change, residual_change: None,
    ):
        self.macro_step = macro_step
        self.learn = learn
        self.interface = macro_step.interface
        self.base: Evaluation | None = None

    def evaluate(self, x: np.ndarray) -> Evaluation:
        """Evaluate as `MacroStep`, and save the result for probes."""
        self.base = self.macro_step.evaluate(x)
        return self.base

    def derivative(self, change: np.ndarray) -> np.ndarray:
        """Return the change of all outputs, (G(x + s dx) - G(x)) / s."""
        assert self.base is not None, "a derivative is asked for before an evaluation"
        used, y, _ = self.base
        feedback = self.interface.feedback
        nominal = self.interface.nominal
        largest = np.max(np.abs(change[feedback] / nominal[feedback]), initial=0.0)
        share = self.interface.difference / max(largest, np.finfo(float).tiny)
        moved, result, _ = self.macro_step.evaluate(np.where(feedback, used + share * change, used))
        steps = (moved - used) / share
        products = (result - y) / share
        self.learn((steps / nominal)[feedback], ((products - steps) / nominal)[feedback])
        return products


def jacobian(macro_step: Tried, x: np.ndarray) -> np.ndarray:
    """Return J of the unknowns at x in nominals, by differences, an evaluation for each."""
    interface = macro_step.interface
    scale = interface.nominal[interface.feedback]
    probed = ProbedStep(macro_step)
    probed.evaluate(x)
    columns: list[np.ndarray] = []
    for k in np.flatnonzero(interface.feedback):
        change = np.zeros(interface.size)
        change[k] = interface.nominal[k]
        columns.append(probed.derivative(change)[interface.feedback] / scale)
    return np.array(columns).T
