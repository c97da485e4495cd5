"""How long the next macro step is: by an embedded estimate of the local error, and by how hard the last step was."""

from dataclasses import dataclass

import numpy as np

SAFETY, SMALLEST_FACTOR, LARGEST_FACTOR = 0.9, 0.2, 2.0
"""Of the new step: aim below the allowed error; never change by more than these factors at once."""
HARD = 12
"""A step that took this many iterations is not followed by a longer one."""


@dataclass
class StepControl:
    """Macro step from the local error of the wires that have one allowed.

    Eq. (S1):  e = max |x - x_lin| / allowed  H / (H + H_last),   x_lin through the last two accepted vectors
    Eq. (S2):  H' = H min(2, max(0.2, 0.9 e^(-1/2)))

    |x - x_lin| is H (H + H_last) / 2 times the second derivative, so e is the local error H^2 |x''| / 2 of backward Euler,
    the order of the lubrication step. A step with e > 1 is rolled back and taken again with H'.

    Parameters
    ----------
    allowed : ndarray, shape (n,)
        Local error allowed per element of the interface vector; infinite where none is watched.
    step : float
        Next macro step [s].
    """

    allowed: np.ndarray
    step: float

    def error(self, past, time, x):
        """Local error of the step that ends at `time` with x, Eq. (S1); None with fewer than two vectors to go by.

        Parameters
        ----------
        past : list of (float, ndarray)
            Accepted times [s] and vectors, newest last.
        """
        if len(past) < 2:
            return None
        (before, older), (last, newer) = past[-2:]
        linear = newer + (time - last) / (last - before) * (newer - older)
        return float(np.max(np.abs(x - linear) / self.allowed)) * (time - last) / (time - before)

    def choose(self, step, error, iterations=0):
        """Set the next macro step [s] after one of `step` with `error`, Eq. (S2)."""
        factor = LARGEST_FACTOR if error is None or error == 0.0 else \
            min(LARGEST_FACTOR, max(SMALLEST_FACTOR, SAFETY * error**-0.5))
        self.step = step * (min(factor, 1.0) if iterations >= HARD else factor)


def step_control(connections, first_step):
    """StepControl of the wires with a `local_error`; None if no wire has one: steps are fixed then."""
    if all(c.local_error is None for c in connections):
        return None
    allowed = [np.full(int(np.prod(c.shape)), np.inf if c.local_error is None else c.local_error) for c in connections]
    return StepControl(np.concatenate(allowed), first_step)
