"""The coupled system as one slave: participants, wires and iteration inside, scalars outside."""

from dataclasses import dataclass
from math import ceil
from types import SimpleNamespace

import numpy as np

from ..fmi.errors import Discard
from ..fmi.slave import FieldSlave
from ..fmi.tree import slave_class
from ..fmi.variables import Variable
from ..participants.local import LocalParticipant
from .freezing import freeze, thaw
from .methods import method_of
from .stepping import StepFailed, Stepper
from .wiring import Connection, System, start


@dataclass(frozen=True)
class State:
    """States of all participants and what the method remembers, as bytes."""

    data: np.ndarray


class Coupled(FieldSlave):
    """A case's participants stepped together: inside, macro steps iterated to agreement; outside,
    any step.

    A communication step is cut into equal macro steps no longer than the case's; inputs are held
    over it. What build.json holds is written by `master.export`.
    """

    name = "coupled"
    description = "Participants of a co-simulation, coupled inside"
    state_type = State

    @staticmethod
    def variables(options):
        """The exposed variables, as chosen at export."""
        return [
            Variable(**entry | {"shape": tuple(entry["shape"])}) for entry in options["variables"]
        ]

    def start(self, values):
        """Start every participant; BadInput with what the first of them refuses."""
        options = self.options
        parameters = {name: {} for name in options["participants"]}
        for exposed, (owner, name) in (options["parameter"] | options["input"]).items():
            parameters[owner][name] = values[exposed]
        participants = {
            name: LocalParticipant(name, self._slave(name, place))
            for name, place in options["participants"].items()
        }
        connections = tuple(_connection(entry) for entry in options["connections"])
        self.system = System(
            participants,
            tuple(options["order"]),
            connections,
            parameters,
            np.inf,
            options["step"],
            parallel=options["coupling"]["parallel"],
        )
        start(self.system)
        coupling = SimpleNamespace(**options["coupling"])
        self.stepper = Stepper(
            self.system, method_of(coupling), coupling.halvings, order=coupling.predictor
        )
        self.standing = self._state()
        return self.standing, self._outputs()

    def _slave(self, name, place):
        return slave_class(place)(instance_name=name, resources=str(self.resources / name))

    def advance(self, state, values, time, step):
        """Macro steps up to time + step; discarded, everything as before, if one of them fails."""
        if state is not self.standing:
            self._restore(state)
        self.standing = None
        for exposed, (owner, name) in self.options["input"].items():
            self.system.participants[owner].set(name, values[exposed])
        count = ceil(step / self.system.step * (1 - 1e-9))
        try:
            for k in range(count):
                before, after = time + step * k / count, time + step * (k + 1) / count
                self.stepper.advance(before, after - before)
        except StepFailed as failure:
            raise Discard(str(failure)) from None
        self.standing = self._state()
        return self.standing, self._outputs()

    def _outputs(self):
        return {
            exposed: self.system.participants[owner].get(name)
            for exposed, (owner, name) in self.options["output"].items()
        }

    def _state(self):
        """Everything a further step depends on."""
        return State(np.frombuffer(freeze(self.stepper), dtype=np.uint8))

    def _restore(self, state):
        thaw(self.stepper, state.data.tobytes())


def _connection(entry):
    """Connection from JSON, which knows no tuples."""
    return Connection(
        **{key: tuple(value) if isinstance(value, list) else value for key, value in entry.items()}
    )
