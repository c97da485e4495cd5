"""Model class as a participant without FMI, for models inside one FMU or in this process."""

import numpy as np
from pythonfmu.enums import Fmi2Status

from ..fmi.errors import BadInput, Discard, ParticipantFault
from ..fmi.slave import COURSE, reserved
from .participant import StartedInHalves


class LocalParticipant(StartedInHalves):
    """Participant of a `FieldSlave`, with the methods of `participant.Participant`.

    Parameters
    ----------
    name : str
        Name in the system.
    slave : FieldSlave
    """

    can_redo = can_serialise = declares_units = True

    def __init__(self, name, slave):
        self.name, self.slave = name, slave
        self.fields = {v.name: v for v in slave.table}
        self.has_derivatives, self.can_interpolate = (
            bool(slave.derivative_inputs),
            bool(slave.courses),
        )

    def enter(self, parameters, start_time, stop_time):
        """Run the first half of `start`, up to Initialization Mode.

        In that mode, outputs follow the inputs that are set.
        """
        for name, value in parameters.items():
            self.set(name, value)
        self.slave.enter_initialization_mode()

    def leave(self):
        """Run the second half of `start`; raise `BadInput` with the faults of the model."""
        self.slave.exit_initialization_mode()
        if self.slave.fault:
            raise BadInput(
                [f"participants.{self.name}, {line}" for line in self.slave.fault.splitlines()]
            )

    def set(self, name, value):
        """Set a field, or a scalar of any type."""
        if self.fields[name].type == "String":
            self.slave.string[self.slave.references[name]] = value
        else:
            number = self.fields[name].number(value) if isinstance(value, str) else value
            self.slave.views[name][...] = number

    def set_course(self, name, course):
        """Set an input and its derivatives at the beginning of the next step.

        course : shape (order + 1, *shape), value first.
        """
        self.slave.views[name][...] = course[0]
        self.slave.views[reserved(COURSE, name)][: len(course) - 1] = course[1:]

    def get_many(self, names):
        """Return the values of several scalars by name."""
        return {name: self.get(name) for name in names}

    def get(self, name):
        """Return an array of the field's shape, or a number."""
        self.slave.show_start()
        if self.fields[name].type == "String":
            return self.slave.string[self.slave.references[name]]
        view = self.slave.views[name]
        return view.copy() if self.fields[name].shape else view.item()

    def step(self, time, step):
        """Take a step [s]; raise `Discard` or `ParticipantFault` with the model's last message."""
        if self.slave.do_step(time, step):
            return
        status, messages = self.slave.verdict()
        _, _, last_words = messages[-1]
        text = f"{self.name}: {last_words}"
        raise Discard(text) if status == Fmi2Status.discard else ParticipantFault(text)

    def save(self):
        return self.slave._get_fmu_state()

    def restore(self, saved):
        self.slave._set_fmu_state(saved)
        if self.slave.fault:
            raise BadInput(f"participants.{self.name}: {self.slave.fault}")

    def free(self, saved):
        """Do nothing, because a saved state is a Python object."""

    def serialise(self, saved):
        """Return the saved state as bytes."""
        return self.slave._fmu_state_to_bytes(saved)

    def deserialise(self, data):
        """Return the state in bytes of `serialise`."""
        return self.slave._fmu_state_from_bytes(data)

    def derivative(self, seeds, products):
        """Return the directional derivative of the last step by field."""
        slave = self.slave
        whole = {
            name: seeds[name] if name in seeds else np.zeros(self.fields[name].shape)
            for name in slave.derivative_inputs
        }
        return slave.directional_derivative(whole)

    def close(self):
        """Do nothing, because there is nothing to free."""
