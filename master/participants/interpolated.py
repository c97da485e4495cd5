"""Inputs that vary during a macro step: as a polynomial, or as the mean of both ends."""

from typing import Any

import numpy as np

from ..fmi.fields import Field
from .derivatives import RepeatedStep
from .participant import FieldByField, Wrapper
from .plain import pack, unpack


def slope_of(name):
    """Return the name of the input that takes the end-of-step time derivative of input `name`."""
    return f"der({name})"


def linear(begin, end, step):
    """Return value and first derivative at the beginning of the step.

    Eq. (P2):  u(s) = u0 + (u1 - u0) s / H,   0 <= s <= H
    """
    return np.stack([begin, (end - begin) / step])  # Eq. (P2)


def hermite(begin, end, begin_slope, end_slope, step):
    """Return value and three derivatives, at the beginning of a step, of the Hermite cubic.

    Eq. (P3):  u(s) = u0 + u0' s + (3 d - 2 u0' - u1') s^2/H + (u0' + u1' - 2 d) s^3/H^2,
               d = (u1 - u0)/H

    Parameters
    ----------
    begin, end : ndarray
        u0, u1.
    begin_slope, end_slope : ndarray, same shape
        u0', u1' [1/s].
    step : float
        H [s].

    Returns
    -------
    ndarray, shape (4, *shape)
    """
    d = (end - begin) / step
    return np.stack(
        [
            begin,
            begin_slope,
            2 * (3 * d - 2 * begin_slope - end_slope) / step,
            6 * (begin_slope + end_slope - 2 * d) / step**2,
        ]
    )  # Eq. (P3)


class InterpolatedParticipant(RepeatedStep, FieldByField, Wrapper):
    """Participant with inputs that vary from their old to their new value during a macro step.

    Setting such an input sets its value at the end of the step. An input of the kind "mean" is
    constant at the mean of both ends, which needs no capability of the FMU. After the step, it is
    set to its end value before outputs are read.

    Eq. (P10):  u(s) = (u0 + u1)/2,   0 <= s < H,   u(H) = u1

    Inputs with a cubic have a companion input `der(name)`: the slope at the end. Values and slopes
    at the beginning are those of the saved state from which the step starts.

    Parameters
    ----------
    participant : Participant
        With `can_interpolate` if an input is "linear" or "hermite".
    interpolation : dict of str to {"mean", "linear", "hermite"}
        By input.
    """

    has_derivatives = False  # the FMU's own would be with respect to inputs at the beginning

    def __init__(self, participant, interpolation):
        super().__init__(participant)
        self.interpolation = interpolation
        self.fields = participant.fields | {
            slope_of(name): _slope(participant.fields[name])
            for name, kind in interpolation.items()
            if kind == "hermite"
        }
        inputs = [*interpolation, *(name for name in self.fields if name not in participant.fields)]
        self.now = {name: np.zeros(self.fields[name].shape) for name in inputs}
        self._begin: Any = None
        self._initialising = False
        self._last_step: Any = None

    def enter(self, parameters, start_time, stop_time):
        """Run the first half of `start`; interpolated inputs begin with their start values.

        In Initialization Mode, `set` sets inputs directly.
        """
        known = self.participant.fields
        self.participant.enter(
            {k: v for k, v in parameters.items() if k in known}, start_time, stop_time
        )
        self._initialising = True
        for name in self.interpolation:
            self.now[name] = np.array(self.participant.get(name))

    def leave(self):
        """Run the second half of `start`."""
        self._initialising = False
        self.participant.leave()

    def set(self, name, value):
        """Set a field; for an interpolated input, its value at the end of the next step."""
        if name in self.now:
            self.now[name] = np.array(value, dtype=float)
        if name not in self.now or (self._initialising and name in self.participant.fields):
            self.participant.set(name, value)

    def get(self, name):
        """Return the value of a field; for an interpolated input, the value that was set last."""
        return self.now[name].copy() if name in self.now else self.participant.get(name)

    def step(self, time, step):
        """Take a step [s] with interpolated inputs."""
        self._set_courses(time, step)
        self.participant.step(time, step)
        self._set_ends()

    def begin_step(self, time, step):
        self._set_courses(time, step)
        self.participant.begin_step(time, step)

    def end_step(self):
        self.participant.end_step()
        self._set_ends()

    def _set_ends(self):
        """Set mean inputs to their values at the end of the step."""
        for name, kind in self.interpolation.items():
            if kind == "mean":
                self.participant.set(name, self.now[name])

    def _set_courses(self, time, step):
        """Set the courses of all interpolated inputs for the next step."""
        self._last_step = time, step
        begin = self._begin[1]
        for name, kind in self.interpolation.items():
            if kind == "mean":
                self.participant.set(name, (begin[name] + self.now[name]) / 2)  # Eq. (P10)
                continue
            if kind == "hermite":
                slope = slope_of(name)
                course = hermite(begin[name], self.now[name], begin[slope], self.now[slope], step)
            else:
                course = linear(begin[name], self.now[name], step)
            self.participant.set_course(name, course)

    def save(self):
        """Return a handle of the state and the ends of the last step, where the next one begins."""
        self._begin = self.participant.save(), dict(self.now)
        return self._begin

    def begin_here(self):
        """Begin the next step with the current inputs, without a saved state."""
        self._begin = None, dict(self.now)

    def restore(self, saved):
        """Restore a saved state, where the next step begins."""
        self._begin, self.now = saved, dict(saved[1])
        self.participant.restore(saved[0])

    def free(self, saved):
        self.participant.free(saved[0])

    def serialise(self, saved):
        """Return the saved state as bytes."""
        return pack((self.participant.serialise(saved[0]), saved[1]))

    def deserialise(self, data):
        """Return a handle of the state in bytes of `serialise`."""
        inner, now = unpack(data)
        return self.participant.deserialise(inner), now


def _slope(field):
    """Return the field of the companion input."""
    return Field(
        name=slope_of(field.name),
        shape=field.shape,
        references=(),
        type="Real",
        causality="input",
        unit=f"{field.unit}/s",
        nominal=None,
        minimum=None,
        maximum=None,
        start=None,
        description=f"Time derivative of {field.name} at the end of a step",
    )
