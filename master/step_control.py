"""How long the next macro step is: by an embedded estimate of the local error, and by how hard the last step was."""

from dataclasses import dataclass
from math import ceil

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
    the order of the lubrication step. A step with e > 1 is rolled back and taken again with H', unless it is the smallest
    already: that one is accepted and counted.

    Parameters
    ----------
    allowed : ndarray, shape (n,)
        Local error allowed per element of the interface vector; infinite where none is watched.
    smallest : float
        Macro step [s] to begin with, and never to go below.
    """

    allowed: np.ndarray
    smallest: float
    step: float = 0.0
    error: float = 0.0
    at_smallest: int = 0

    def length(self, remaining):
        """Next macro step [s], and whether it ends the remaining time, which is cut into equal parts."""
        parts = ceil(remaining / max(self.step, self.smallest) - 1e-9)
        return remaining / parts, parts == 1

    def accepts(self, past, time, step, solution):
        """Whether the local error of a step is small enough; sets the next macro step.

        Parameters
        ----------
        past : list of (float, ndarray)
            Accepted times [s] and vectors before the step, newest last.
        time, step : float
            Start and length of the step [s].
        solution : Solution
        """
        self.error = self._error(past, time + step, solution.x)
        factor = LARGEST_FACTOR if self.error == 0.0 else \
            min(LARGEST_FACTOR, max(SMALLEST_FACTOR, SAFETY * self.error**-0.5))                                # Eq. (S2)
        self.step = step * (min(factor, 1.0) if solution.iterations >= HARD else factor)
        small = step <= self.smallest * (1 + 1e-9)
        self.at_smallest += small and self.error > 1.0
        return small or self.error <= 1.0

    def _error(self, past, time, x):
        if len(past) < 2:
            return 0.0
        (before, older), (last, newer) = past[-2:]
        linear = newer + (time - last) / (last - before) * (newer - older)
        return float(np.max(np.abs(x - linear) / self.allowed)) * (time - last) / (time - before)               # Eq. (S1)

    def halve(self, step):
        """After a step that failed: the next one is half as long; False if that is below the smallest."""
        self.step = step / 2
        return self.step >= self.smallest


def step_control(connections, smallest):
    """StepControl of the wires with a `local_error`; None if no wire has one: every step is as long as asked then."""
    if all(c.local_error is None for c in connections):
        return None
    allowed = [np.full(int(np.prod(c.shape)), np.inf if c.local_error is None else c.local_error) for c in connections]
    return StepControl(np.concatenate(allowed), smallest)
