"""Inputs in another unit than the wire's: set in the wire's, given to the FMU in its own."""

from typing import NamedTuple

import numpy as np

from .participant import FieldByField


class Conversion(NamedTuple):
    """From the wire's unit to the input's.

    Eq. (P5):  (value in the input's unit) = gain (value in the wire's unit) + offset
    """

    gain: float
    offset: float

    def __call__(self, value):
        return self.gain * np.asarray(value) + self.offset  # Eq. (P5)

    def back(self, value):
        """A value in the input's unit, in the wire's."""
        return (value - self.offset) / self.gain


class ConvertedParticipant(FieldByField):
    """A participant some of whose inputs are fed in another unit; everything else is its own.

    Parameters
    ----------
    participant : Participant
    conversions : dict of str to Conversion
        By input.
    """

    def __init__(self, participant, conversions):
        self.participant, self.conversions = participant, conversions

    def __getattr__(self, name):
        return getattr(self.participant, name)

    def start(self, parameters, start_time, stop_time):
        """See `FmuParticipant.start`; converted inputs begin in the wire's unit too."""
        self.enter(parameters, start_time, stop_time)
        self.leave()

    def enter(self, parameters, start_time, stop_time):
        """First half of `start`."""
        values = {name: self._given(name, value) for name, value in parameters.items()}
        self.participant.enter(values, start_time, stop_time)

    def _given(self, name, value):
        conversion = self.conversions.get(name)
        return value if conversion is None else conversion(value)

    def set(self, name, value):
        """Set a field; a converted input in the wire's unit."""
        self.participant.set(name, self._given(name, value))

    def set_course(self, name, course):
        """Set an input and its time derivatives at the beginning of the next step."""
        if name in self.conversions:
            conversion = self.conversions[name]
            course = np.concatenate([conversion(course[:1]), conversion.gain * course[1:]])
        self.participant.set_course(name, course)

    def get(self, name):
        """Value of a field; of a converted input in the wire's unit."""
        value = self.participant.get(name)
        conversion = self.conversions.get(name)
        return value if conversion is None else conversion.back(value)

    def derivative(self, seeds, products):
        """Directional derivative of the last step by inputs in the wires' units."""
        changes = {
            name: change * self.conversions[name].gain if name in self.conversions else change
            for name, change in seeds.items()
        }
        return self.participant.derivative(changes, products)
