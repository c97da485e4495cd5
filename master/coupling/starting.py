"""How participants start together, and are closed."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import numpy as np

from ..fmi.errors import BadInput, ParticipantFault
from ..participants.interpolated import InterpolatedParticipant
from ..participants.participant import Participant
from .interface import Evaluation, Interface
from .methods import Newton, NotConverged
from .wiring import System, carry

START_ITERATIONS = 50
"""Evaluations of a start loop; Newton needs two where outputs are linear in inputs."""


def start(
    system: System, trial: Callable[[Participant], Iterable[str]] = lambda participant: ()
) -> None:
    """Initialise the participants in the system's order; inputs fed by an already started one
    begin with its outputs.

    Where inputs are interpolated the first step begins with what is there at the start, so that
    start values which depend on one another are solved for: in Initialization Mode outputs follow
    inputs, and the wires are iterated as in a macro step. Held inputs are set anew before the first
    step; where all are held those against that order keep the start values they were
    given, from which the shipped engine begins at rest.

    `trial` is called with each participant that has started, and returns what is wrong with it.
    Raises BadInput with all that is refused, or if no start values agree.
    """
    for participant in system.participants.values():
        if getattr(participant, "runs_apart", False):
            participant.launch()
    if any(isinstance(one, InterpolatedParticipant) for one in system.participants.values()):
        faults, started = _solved(system)
    else:
        faults, started = _one_by_one(system)
    if not faults:
        carry(started, system.held)
    # where inputs are interpolated the first step begins with what its sources say
    for c in system.wires:
        if c.source[0] in started and c.target[0] in started:
            started[c.target[0]].set(c.target[1], started[c.source[0]].get(c.source[1]))
    faults += [fault for participant in started.values() for fault in trial(participant)]
    if faults:
        raise BadInput(faults)


def _one_by_one(system: System) -> tuple[list[str], dict[str, Participant]]:
    """Faults, and the participants that have started, each fed by those before it."""
    faults: list[str] = []
    started: dict[str, Participant] = {}
    for name, participant in system.participants.items():
        fed = _fed(system, name, started)
        try:
            participant.start({**system.parameters[name], **fed}, system.begin, system.stop)
            started[name] = participant
        except BadInput as error:
            faults += error.faults
    return faults, started


def _solved(system: System) -> tuple[list[str], dict[str, Participant]]:
    """The same with all wires in agreement before any participant leaves Initialization Mode."""
    faults: list[str] = []
    entered: dict[str, Participant] = {}
    for name, participant in system.participants.items():
        try:
            participant.enter(system.parameters[name], system.begin, system.stop)
            entered[name] = participant
        except BadInput as error:
            faults += error.faults
    if faults:
        return faults, {}
    _agree(Interface(entered, system.wires))
    started: dict[str, Participant] = {}
    for name, participant in entered.items():
        for variable, value in _fed(system, name, started).items():
            participant.set(variable, value)
        try:
            participant.leave()
            started[name] = participant
        except BadInput as error:
            faults += error.faults
    return faults, started


def _fed(system: System, name: str, started: Mapping[str, Participant]) -> dict[str, Any]:
    """Outputs of the participants that have started, by the input of `name` they are wired to."""
    return {
        c.target[1]: started[c.source[0]].get(c.source[1])
        for c in (*system.wires, *system.held)
        if c.target[0] == name and c.source[0] in started
    }


def _agree(interface: Interface) -> None:
    """Bring the wires of participants in Initialization Mode to agreement."""
    newton = Newton(START_ITERATIONS, differences=True)
    try:
        newton.solve(Start(interface), interface.read(), newton.memory())
    except NotConverged as failure:
        raise BadInput(
            f"no start values of the wires agree with one another: {failure}; give start values "
            "nearer to a solution in participants.NAME.parameters, or hold the inputs"
        ) from None


class Start:
    """Initialization Mode as a method sees it, in place of a macro step: outputs follow inputs
    without a step.
    """

    def __init__(self, interface: Interface):
        self.interface = interface

    def evaluate(self, x: np.ndarray) -> Evaluation:
        """Set every participant's inputs, later ones to what earlier ones say."""
        return self.interface.answer(x, lambda stage: None)

    def derivative(self, change: np.ndarray) -> np.ndarray:
        """Never asked for: Newton takes differences here."""
        raise NotImplementedError


@contextmanager
def closing(participants: Iterable[Participant]) -> Iterator[None]:
    """Close all participants at the end.

    What goes wrong while they are closed is raised once all are, and only where nothing went wrong
    before: it is a consequence then.
    """
    faults: list[ParticipantFault] = []
    try:
        yield
    finally:
        for participant in participants:
            try:
                participant.close()
            except ParticipantFault as fault:
                faults.append(fault)
    if faults:
        raise faults[0]
