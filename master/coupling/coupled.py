"""The coupled system as one slave: participants, wires and iteration inside, scalars outside."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from math import ceil
from types import SimpleNamespace
from typing import Any

import numpy as np

from ..fmi.errors import Discard
from ..fmi.slave import FieldSlave, Fmi2Status
from ..fmi.variables import Variable
from ..participants.derivatives import NEGLIGIBLE
from ..participants.local import LocalParticipant
from .freezing import freeze, thaw
from .methods import method_of
from .methods.krylov import RecycledGmres
from .starting import start
from .stepping import StepFailed, Stepper
from .vector import MOST_STEPS, TOO_LONG, macro_step_end
from .wiring import Port, System, Wire


@dataclass(frozen=True)
class CoupledState:
    """States of all participants and memory of the method, as bytes."""

    data: np.ndarray


@dataclass(frozen=True)
class Options:
    """Content of build.json of a coupled FMU; `case.export` writes it.

    name         : model identifier
    title        : the case's
    participants : package of its code and slave in it ("module:class") by name, in the order of
                   their start
    order        : stepping order
    step         : macro step [s]
    wires        : those of the system
    coupling     : the case's table, see `case.schema.Coupling`
    variables    : the table seen from outside
    parameter, input, output : (participant, variable) inside by the name outside
    limits       : those of the system
    """

    name: str
    title: str
    participants: dict[str, tuple[str, str]]
    order: tuple[str, ...]
    step: float
    wires: tuple[Wire, ...]
    coupling: SimpleNamespace
    variables: tuple[Variable, ...]
    parameter: dict[str, Port]
    input: dict[str, Port]
    output: dict[str, Port]
    limits: tuple[Port, ...]

    @staticmethod
    def read(tree: Mapping[str, Any]) -> "Options":
        """Return the options from JSON, which has no tuples."""
        return Options(
            tree["name"],
            tree["title"],
            {name: (code, slave) for name, code, slave in tree["participants"]},
            tuple(tree["order"]),
            tree["step"],
            tuple(_read_wire(entry) for entry in tree["wires"]),
            SimpleNamespace(
                **tree["coupling"] | {"advanced": SimpleNamespace(**tree["coupling"]["advanced"])}
            ),
            tuple(
                Variable(**entry | {key: tuple(entry[key]) for key in ("shape", "choices")})
                for entry in tree["variables"]
            ),
            *(
                {name: (owner, variable) for name, (owner, variable) in tree[causality].items()}
                for causality in ("parameter", "input", "output")
            ),
            limits=tuple((owner, name) for owner, name in tree["limits"]),
        )


def _read_wire(entry: Mapping[str, Any]) -> Wire:
    tuples: dict[str, Any] = {key: tuple(entry[key]) for key in ("source", "target", "shape")}
    return Wire(**{**entry, **tuples})


def _size(variable: Variable, value: Any) -> float:
    """Return the size of an input: its nominal value, its largest value, or 1."""
    return max(variable.nominal or 0.0, float(np.max(np.abs(value)))) or 1.0


LENIENCE = 0.01
"""Share by which a macro step may be longer than the case's; clocks that count whole nanoseconds
are off by 1e-5, errors of second order in time grow by 2 %.
"""


NUDGE = 1e-3
"""Change of an input for a difference, relative to its size.

A macro step converges to about 1e-6 of the nominal values. The error of a difference is therefore
about 1e-3 of a product of nominal size, and a percent or more of a much smaller one.
"""


Again = Callable[[dict[str, Any]], tuple[CoupledState, dict[str, Any]]]


@dataclass(frozen=True)
class LastMacroStep:
    """The last step, or the start: what it was given, what came out, and how to take it again."""

    values: dict[str, Any]
    outputs: dict[str, Any]
    again: Again


class Coupled(FieldSlave):
    """Participants of a case as one FMU, which iterates its macro steps.

    A communication step consists of equal macro steps. Their number is the smallest for which they
    are at most LENIENCE longer than those of the case: an importer's clock may round, and steps of
    half the length are another run. Inputs are held over the communication step. `case.export`
    writes build.json. The directional derivative is that of the step, of all real outputs for all
    real inputs.
    """

    name = "coupled"
    description = "Participants of a co-simulation, coupled inside"
    state_type = CoupledState

    def __init__(self, **kwargs: Any):
        super().__init__(**kwargs)
        self.inside = Options.read(self.options)
        self.name = self.modelName = self.inside.name
        self.description = self.inside.title

    @property
    def derivative_inputs(self):  # pyright: ignore[reportIncompatibleVariableOverride]
        """Return all real inputs."""
        return tuple(v.name for v in self.inputs if v.type == "Real")

    @property
    def derivative_outputs(self):  # pyright: ignore[reportIncompatibleVariableOverride]
        """Return all real outputs, none without inputs."""
        real = [v.name for v in self.table if v.causality == "output" and v.type == "Real"]
        return tuple(real) if self.derivative_inputs else ()

    @staticmethod
    def variables(options: dict[str, Any]):
        """Return the variables that were chosen at export."""
        return list(Options.read(options).variables)

    def start(self, values: dict[str, Any]):
        """Start every participant; raise BadInput if one cannot start."""
        options = self.inside
        parameters: dict[str, dict[str, Any]] = {name: {} for name in options.participants}
        for exposed, (owner, name) in (options.parameter | options.input).items():
            parameters[owner][name] = values[exposed]
        participants = {
            name: LocalParticipant(name, self._slave(name, *place))
            for name, place in options.participants.items()
        }
        coupling = options.coupling
        self.system = System(
            participants=participants,
            order=options.order,
            wires=options.wires,
            parameters=parameters,
            stop=np.inf,
            step=options.step,
            parallel=coupling.parallel,
            limits=options.limits,
        )
        start(self.system)
        self.stepper = Stepper(
            self.system, method_of(coupling), coupling.advanced.halvings, order=coupling.predictor
        )
        return self._reached(values, self.start)

    def _slave(self, name: str, code: str, path: str) -> Any:
        tree = import_module(f"{code}.master.fmi.tree")
        return tree.slave_class(path)(instance_name=name, resources=str(self.resources / name))

    def advance(self, state: CoupledState, values: dict[str, Any], time: float, step: float):
        """Take macro steps up to time + step; if one fails, discard all and keep the state."""
        asked = step / self.system.step / (1.0 + LENIENCE)
        if not asked <= MOST_STEPS:
            a, b, c = (f"{x:g}" for x in (step, MOST_STEPS, self.system.step))
            raise Discard(TOO_LONG.format(a=a, b=b, c=c))
        if state is not self.current:
            thaw(self.stepper, state.data.tobytes())
        self.current = None
        ports = self.inside.input | self.inside.parameter
        for v in self.given_to_steps:
            owner, name = ports[v.name]
            self.system.participants[owner].set(name, values[v.name])
        count = ceil(asked)
        try:
            for k in range(count):
                before, after = (
                    macro_step_end(time, step, share, self.system.step)
                    for share in (k / count, (k + 1) / count)
                )
                self.stepper.advance(before, after - before)
        except StepFailed as failure:
            raise Discard(str(failure)) from None

        def again(inputs: dict[str, Any]):
            return self.advance(state, inputs, time, step)

        return self._reached(values, again)

    def _reached(self, values: dict[str, Any], again: Again) -> tuple[CoupledState, dict[str, Any]]:
        """Return the present state and outputs, and note how to repeat the step."""
        self._pass_on()
        self.current = self._state()
        outputs = self._outputs()
        self.last = LastMacroStep(values, outputs, again)
        return self.current, outputs

    def _pass_on(self):
        """Log the warnings of the participants and wires."""
        for name, participant in self.system.participants.items():
            queue = participant.slave.log_queue
            for message in queue:
                if message.status == Fmi2Status.warning:
                    self.log(f"{name}: {message.msg}", Fmi2Status.warning)
            queue.clear()
        for name, warning in self.stepper.warned():
            self.log(f"{name}: {warning.text}", Fmi2Status.warning)
        self.stepper.warnings.clear()

    def directional_derivative(self, seeds: dict[str, np.ndarray]):
        """Return the change of all real outputs of the last step for a change of its inputs.

        The step, or the start, is repeated with changed inputs.

        Eq. (Y4):  dy = (y(u + e v) - y(u)) / e,   e = NUDGE / max |v| / size(u)

        Parameters
        ----------
        seeds : dict of str to ndarray
            v, by input [its unit].

        Returns
        -------
        dict of str to ndarray
            dy, by output [its unit].
        """
        last = self.last
        shares = [
            np.max(np.abs(seeds[v.name])) / _size(v, last.values[v.name])
            for v in self.inputs
            if v.name in seeds
        ]
        largest = max(shares)
        if largest <= NEGLIGIBLE:
            return {name: np.zeros(self.views[name].shape) for name in self.derivative_outputs}
        length = NUDGE / largest
        moved = {name: last.values[name] + length * seed for name, seed in seeds.items()}
        try:
            _, outputs = last.again({**last.values, **moved})
        finally:
            self.last = last
        return {  # Eq. (Y4)
            name: (outputs[name] - np.asarray(last.outputs[name])) / length
            for name in self.derivative_outputs
        }

    def _outputs(self):
        return {
            exposed: self.system.participants[owner].get(name)
            for exposed, (owner, name) in self.inside.output.items()
        }

    def _state(self):
        """Return everything that a further step depends on."""
        return CoupledState(np.frombuffer(freeze(self.stepper), dtype=np.uint8))

    def _get_fmu_state(self) -> Any:
        """Return the state without earlier products, which this instance forgets too.

        A step from the saved state then has the same bits as the next step of this instance.
        """
        if self.state is not None:
            if self.state is not self.current:
                thaw(self.stepper, self.state.data.tobytes())
            gmres = getattr(self.stepper.memory, "krylov", self.stepper.memory)
            if isinstance(gmres, RecycledGmres):
                gmres.pairs = None
            self.state = self.current = self._state()
        return super()._get_fmu_state()

    def _restored(self, members: dict[str, Any]):
        """Return the state with these members, which everything inside has taken over."""
        try:
            state = CoupledState(**members)
            thaw(self.stepper, state.data.tobytes())
        except (AttributeError, TypeError, ValueError) as error:
            return self._refuse(f"expected a state of this FMU, got another: {error}")
        self.current = state
        return state
