"""Linearised sweeps by differences, for participants whose derivatives are missing or not
wanted.
"""

import numpy as np

PROBE = 1e-5
"""Largest element of a probe, in nominals: far above round-off, far below what bends the step
map.
"""


class ProbedStep:
    """A macro step whose linearised sweep is a difference of two sweeps; `learn` is told of
    each.
    """

    def __init__(self, macro_step, learn=lambda change, residual_change: None):
        self.macro_step, self.learn, self.interface, self.base = (
            macro_step,
            learn,
            macro_step.interface,
            None,
        )

    def sweep(self, x):
        """`MacroStep.sweep`; probes start from the last one."""
        used, y, residual = self.macro_step.sweep(x)
        self.base = used, y
        return used, y, residual

    def linear_sweep(self, change):
        """Change of all outputs, (G(x + s dx) - G(x)) / s."""
        (used, y), feedback, nominal = self.base, self.interface.feedback, self.interface.nominal
        share = PROBE / max(
            np.max(np.abs(change[feedback] / nominal[feedback])), np.finfo(float).tiny
        )
        moved, result, _ = self.macro_step.sweep(np.where(feedback, used + share * change, used))
        steps, products = (moved - used) / share, (result - y) / share
        self.learn((steps / nominal)[feedback], ((products - steps) / nominal)[feedback])
        return products
