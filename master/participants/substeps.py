"""Participant with several steps in a macro step, between which its inputs vary."""

from math import ceil

import numpy as np

from ..fmi.errors import Discard, Finished
from .derivatives import RepeatedStep
from .participant import FieldByField, Wrapper

STEP_TOLERANCE = 1e-9
"""Tolerance of a macro step that must be a multiple of a fixed step, relative to that step."""


def shifted(course, by):
    """Return value and derivatives of a polynomial at another point.

    Eq. (P6):  u^(i)(s) = sum over j >= i of u^(j)(0) s^(j-i) / (j-i)!

    course : ndarray, shape (order + 1, *shape), value first; by : s [s].

    >>> shifted(np.array([1.0, 2.0, 6.0]), 1.0)
    array([6., 8., 6.])
    """
    coefficients = np.zeros_like(course)
    for i in range(len(course)):
        term = 1.0
        for j in range(i, len(course)):
            coefficients[i] += course[j] * term  # Eq. (P6)
            term *= by / (j - i + 1)
    return coefficients


class Substeps(RepeatedStep, FieldByField, Wrapper):
    """Participant that takes equal steps of limited length inside a macro step.

    Interpolated inputs vary from step to step. If the participant can interpolate, it receives
    their derivatives, otherwise their value at the end of each of its steps. Other inputs are
    constant during the macro step.

    Parameters
    ----------
    participant : Participant
    length : float
        Longest step [s]. None means the macro step, which must be set before the start.
    fixed : bool
        Whether all steps have this length. Then macro steps that are no multiple are discarded.
    """

    has_derivatives = False  # the FMU's own would be that of the last substep
    can_interpolate = True

    def __init__(self, participant, length, fixed=False):
        super().__init__(participant)
        self.length, self.fixed = length, fixed
        self._courses: dict[str, np.ndarray] = {}

    def __repr__(self):
        return repr(self.participant)

    def another(self):
        """Return a second instance, see `FmuParticipant.another`."""
        one = self.participant.another()
        return one and Substeps(one, self.length, self.fixed)

    def set_course(self, name, course):
        """Set an input and its time derivatives at the beginning of the next macro step."""
        self._courses[name] = np.array(course, dtype=float)

    def step(self, time, step):
        """Take a macro step [s]."""
        self._last_step = time, step
        count = self._count(step)
        length = self.length if self.fixed else step / count
        for k in range(count):
            self._move_inputs(step * k / count, length)
            self.participant.step(time + step * k / count, length)
            if self.participant.ended and k < count - 1:
                raise Finished(self.participant.ended)

    def _count(self, step):
        """Return the number of steps in a macro step."""
        if not self.fixed:
            return max(1, ceil(step / self.length - STEP_TOLERANCE))
        count = round(step / self.length)
        if count < 1 or abs(step - count * self.length) > STEP_TOLERANCE * self.length:
            raise Discard(
                f"{self.name}: expected a multiple of {self.length:g} s, got a step of {step:g} s"
            )
        return count

    def _move_inputs(self, at, length):
        """Set the interpolated inputs for the substep from `at` [s]."""
        for name, course in self._courses.items():
            if self.participant.can_interpolate:
                self.participant.set_course(name, shifted(course, at))
            else:
                self.participant.set(name, shifted(course, at + length)[0])
