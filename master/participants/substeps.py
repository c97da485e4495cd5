"""A participant with a step of its own: several of its steps make a macro step, its inputs moving
from one to the next.
"""

from math import ceil
from typing import Any

import numpy as np

from ..fmi.errors import Discard, Finished
from .derivatives import difference
from .participant import FieldByField

EXACT = 1e-9
"""Of a step: how far a macro step may be off a whole number of steps of one length."""


def shifted(course, by):
    """A polynomial's value and derivatives at another point.

    Eq. (P6):  u^(i)(s) = sum over j >= i of u^(j)(0) s^(j-i) / (j-i)!

    course : ndarray, shape (order + 1, *shape), value first; by : s [s].
    """
    found = np.zeros_like(course)
    for i in range(len(course)):
        term = 1.0
        for j in range(i, len(course)):
            found[i] += course[j] * term  # Eq. (P6)
            term *= by / (j - i + 1)
    return found


class Substeps(FieldByField):
    """A participant that takes equal steps no longer than its own inside a macro step.

    Inputs that are interpolated move from step to step, whatever the participant can do: it is told
    their course where it follows one, else their value at the end of each of its steps. The others
    are held over the macro step.

    Parameters
    ----------
    participant : Participant
    length : float
        Its own step [s]; None for the macro step, to be filled in before the start.
    fixed : bool
        It takes steps of this length alone; a macro step that is none of several is discarded.
    """

    has_derivatives = False  # the FMU's own would be that of the last of its steps
    can_interpolate = True

    def __init__(self, participant, length, fixed=False):
        self.participant, self.length, self.fixed = participant, length, fixed
        self._courses: dict[str, np.ndarray] = {}
        self._begin: Any = None
        self._last_step: Any = None

    def __getattr__(self, name):
        return getattr(self.participant, name)

    def __repr__(self):
        return repr(self.participant)

    def another(self):
        """See `FmuParticipant.another`."""
        one = self.participant.another()
        return one and Substeps(one, self.length, self.fixed)

    def set_course(self, name, course):
        """Set an input and its time derivatives at the beginning of the next macro step."""
        self._courses[name] = np.array(course, dtype=float)

    def step(self, time, step):
        """One macro step [s]."""
        self._last_step = time, step
        count = self._count(step)
        length = self.length if self.fixed else step / count
        for k in range(count):
            self._move_inputs(step * k / count, length)
            self.participant.step(time + step * k / count, length)
            if self.participant.ended and k < count - 1:
                raise Finished(self.participant.ended)

    def _count(self, step):
        """How many steps make a macro step."""
        if not self.fixed:
            return max(1, ceil(step / self.length - EXACT))
        count = round(step / self.length)
        if count < 1 or abs(step - count * self.length) > EXACT * self.length:
            raise Discard(
                f"{self.name}: takes steps of {self.length:g} s alone, {step:g} s is no multiple"
            )
        return count

    def _move_inputs(self, at, length):
        """Tell the participant what interpolated inputs do in the step from `at` [s]."""
        for name, course in self._courses.items():
            if self.participant.can_interpolate:
                self.participant.set_course(name, shifted(course, at))
            else:
                self.participant.set(name, shifted(course, at + length)[0])

    def restore(self, saved):
        """Go back to a saved state; the next macro step counts from it."""
        self._begin = saved
        self.participant.restore(saved)

    def derivative(self, seeds, products):
        """Directional derivative of the last macro step, as a difference of two."""
        begin = self._begin
        try:
            whole: Any = self  # what is not defined here is the inner participant's
            return difference(whole, begin, self._last_step, seeds, products)
        finally:
            self._begin = begin
