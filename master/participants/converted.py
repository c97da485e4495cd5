"""Inputs with another unit than their wire."""

from typing import NamedTuple

import numpy as np

from .participant import FieldByField, Wrapper


class Conversion(NamedTuple):
    """Conversion from the wire's unit to the input's.

    Eq. (P5):  (value in the input's unit) = gain (value in the wire's unit) + offset
    """

    gain: float
    offset: float

    def __call__(self, value):
        return self.gain * np.asarray(value) + self.offset  # Eq. (P5)

    def back(self, value):
        """Convert a value from the input's unit to the wire's."""
        return (value - self.offset) / self.gain


class ConvertedParticipant(FieldByField, Wrapper):
    """Participant with inputs that are set in the wire's unit.

    Parameters
    ----------
    participant : Participant
    conversions : dict of str to Conversion
        By input.
    """

    def __init__(self, participant, conversions):
        super().__init__(participant)
        self.conversions = conversions

    def enter(self, parameters, start_time, stop_time):
        """Run the first half of `start`; converted inputs have the wire's unit."""
        values = {name: self._converted_value(name, value) for name, value in parameters.items()}
        self.participant.enter(values, start_time, stop_time)

    def _converted_value(self, name, value):
        conversion = self.conversions.get(name)
        return value if conversion is None else conversion(value)

    def set(self, name, value):
        """Set a field; converted inputs have the wire's unit."""
        self.participant.set(name, self._converted_value(name, value))

    def set_course(self, name, course):
        """Set an input and its time derivatives at the beginning of the next step."""
        if name in self.conversions:
            conversion = self.conversions[name]
            course = np.concatenate([conversion(course[:1]), conversion.gain * course[1:]])
        self.participant.set_course(name, course)

    def get(self, name):
        """Return the value of a field; converted inputs have the wire's unit."""
        value = self.participant.get(name)
        conversion = self.conversions.get(name)
        return value if conversion is None else conversion.back(value)

    def derivative(self, seeds, products):
        """Return the directional derivative of the last step; inputs have the wires' units."""
        changes = {
            name: change * self.conversions[name].gain if name in self.conversions else change
            for name, change in seeds.items()
        }
        return self.participant.derivative(changes, products)
