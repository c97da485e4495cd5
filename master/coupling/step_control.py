"""Length of the next macro step, from the local error and the effort of the last one.

References
----------
[Hairer1993] E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd
ed., Springer 1993, sections II.4 (step size control) and III.5 (variable-step BDF).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import ceil

import numpy as np

from .methods.solution import Solution
from .vector import is_longer
from .wiring import Wire

SAFETY_FACTOR = 0.9
SMALLEST_FACTOR = 0.2
LARGEST_FACTOR = 2.0
"""Factors of the new step: `SAFETY_FACTOR` aims below the allowed error, the others are bounds.

BDF2 is zero-stable only while steps grow by less than 1 + sqrt(2).
"""
ROUND_OFF = 1e-9
"""Relative difference between lengths of steps that is ignored."""
HARD_ITERATIONS = 12
"""A step that took this many iterations is not followed by a longer one."""


@dataclass
class StepControl:
    """Macro step from the local error of the wires that have one allowed.

    Eq. (S2):  e = max over wires of rms(x - x_quad) / allowed
                   H (H + H_1) / ((2 H + H_1) (H + H_1 + H_2)),
               x_quad through the last three accepted vectors, H_1 and H_2 the steps between them,
               newest first
    Eq. (S3):  H' = H min(2, max(0.2, 0.9 e^(-1/3)))

    x - x_quad is H (H + H_1) (H + H_1 + H_2) x'''/6, so e is the local error of variable-step BDF2
    over the allowed one: H^2 (H + H_1)^2 |x'''| / (6 (2 H + H_1)), in equal steps 2/9 H^3 |x'''|.
    Any method of second order has a local error proportional to H^3 x''' while steps change little,
    so this serves participants of second order; for one of first order the estimate is too small.
    The mean over a wire follows the motion of the whole field, a maximum would follow the few
    elements where something switches.

    A step with e > 1 is rolled back and taken again with H', unless it is the smallest already:
    that one is accepted and counted. The first two steps have no estimate: the smallest one, and at
    most twice that.

    Parameters
    ----------
    watched : list of (slice, float)
        Part of the interface vector and the rms local error allowed in it, in the unit of its wire,
        > 0.
    smallest : float
        Macro step [s] to begin with, and never to go below.
    """

    watched: list[tuple[slice, float]]
    smallest: float
    step: float = 0.0
    error: float = 0.0
    at_smallest: int = 0
    past: list[tuple[float, np.ndarray]] = field(default_factory=list[tuple[float, np.ndarray]])

    def length(self, remaining: float) -> tuple[float, bool]:
        """Return the next macro step [s], and whether it ends the remaining time.

        The remaining time is divided into equal parts.
        """
        parts = ceil(remaining / max(self.step, self.smallest) - ROUND_OFF)
        return remaining / parts, parts == 1

    def accepts(
        self, last: tuple[float, np.ndarray], time: float, step: float, solution: Solution
    ) -> bool:
        """Return whether the local error of a step is small enough; set the next macro step.

        Parameters
        ----------
        last : (float, ndarray)
            Time [s] and interface vector that were accepted before the step.
        time, step : float
            Start and length of the step [s].
        solution : Solution
        """
        self._keep(*last)
        self.error = self._error(time + step, solution.x)
        factor = LARGEST_FACTOR
        if self.error > 0.0:
            growth = SAFETY_FACTOR * self.error ** (-1 / 3)
            factor = min(LARGEST_FACTOR, max(SMALLEST_FACTOR, growth))  # Eq. (S3)
        self.step = step * (min(factor, 1.0) if solution.iterations >= HARD_ITERATIONS else factor)
        small = step <= self.smallest * (1 + ROUND_OFF)
        self.at_smallest += small and self.error > 1.0
        return small or self.error <= 1.0

    def _keep(self, time: float, x: np.ndarray) -> None:
        """Keep an accepted vector, once for all attempts at the step after it.

        The predictor may keep fewer than three.
        """
        if not self.past or time > self.past[-1][0]:
            self.past = [*self.past, (time, x)][-3:]

    def _error(self, time: float, x: np.ndarray) -> float:
        if len(self.past) < 3:
            return 0.0
        (t3, x3), (t2, x2), (t1, x1) = self.past
        slope = (x1 - x2) / (t1 - t2)
        slope_before = (x2 - x3) / (t2 - t3)
        deviation = (
            x - x1 - (time - t1) * (slope + (time - t2) * (slope - slope_before) / (t1 - t3))
        )
        share = (time - t1) * (time - t2) / ((2 * time - t1 - t2) * (time - t3))
        # Eq. (S2)
        return share * max(
            float(np.sqrt(np.mean(deviation[part] ** 2))) / allowed
            for part, allowed in self.watched
        )

    def resolves(self, step: float, longest: float) -> bool:
        """Return whether a step resolves the motion, or is the smallest; limit the next one."""
        small = step <= self.smallest * (1 + ROUND_OFF)
        if small or not is_longer(step, longest):
            return True
        self.step = step
        self.limit(longest)
        return False

    def limit(self, longest: float) -> None:
        """Limit the next step to the longest one that resolves the motion [s]."""
        self.step = min(self.step, max(longest, self.smallest))

    def halve(self, step: float) -> bool:
        """Halve the step after a failure; return False if it is below the smallest."""
        self.step = step / 2
        return self.step >= self.smallest * (1 - ROUND_OFF)


def step_control(wires: Sequence[Wire], smallest: float) -> StepControl | None:
    """Return the StepControl of the wires with a `local_error`, None if no wire has one."""
    ends = np.cumsum([int(np.prod(c.shape)) for c in wires], dtype=int)
    watched = [
        (slice(int(end) - int(np.prod(c.shape)), int(end)), c.local_error)
        for c, end in zip(wires, ends)
        if c.local_error is not None
    ]
    return StepControl(watched, smallest) if watched else None
