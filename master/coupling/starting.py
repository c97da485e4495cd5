"""Start and end of all participants together."""

import warnings
from collections.abc import Callable, Generator, Iterable, Mapping
from contextlib import contextmanager
from typing import Any

import numpy as np

from ..fmi.errors import BadInput, ParticipantFault, collecting
from ..participants.participant import Participant
from .interface import Evaluation, Interface
from .methods import Newton, NotConverged
from .methods.newton import SINGULAR_RATIO
from .methods.probing import jacobian
from .wiring import System, Wire, carry

START_ITERATIONS = 50
"""Evaluations of a start loop; Newton needs two where outputs are linear in inputs."""
LARGEST_CHECKED = 20
"""Unknowns of a start loop that is checked for being singular: an evaluation for each."""


def start(system: System) -> None:
    """Initialise the participants with start values that agree.

    In Initialization Mode outputs follow inputs, so that the wires are iterated there as in a macro
    step. The inputs of the first macro step are the outputs at the start.

    Parameters
    ----------
    system : System
        The participants start in its order.

    Raises
    ------
    BadInput
        With all faults of the participants, or if no start values agree.
    """
    for participant in system.participants.values():
        if getattr(participant, "runs_apart", False):
            participant.launch()
    faults: list[str] = []
    entered = _each(
        system.participants,
        lambda name: system.participants[name].enter(
            system.parameters[name], system.begin, system.stop
        ),
        faults,
    )
    if faults:
        raise BadInput(faults)
    readable = [wire for wire in system.wires if not _is_clocked(entered, wire)]
    _agree(Interface(entered, readable))
    started: dict[str, Participant] = {}

    def leave(name: str) -> None:
        for variable, value in _fed(system, name, started).items():
            entered[name].set(variable, value)
        entered[name].leave()
        started[name] = entered[name]

    _each(entered, leave, faults)
    if not faults:
        carry(started, system.held)
    for c in system.wires:
        if c.source[0] in started and c.target[0] in started:
            started[c.target[0]].set(c.target[1], started[c.source[0]].get(c.source[1]))
    if faults:
        raise BadInput(faults)


def _each(
    participants: Mapping[str, Participant], action: Callable[[str], object], faults: list[str]
) -> dict[str, Participant]:
    """Return the participants for which the action succeeds; append the others' faults."""
    succeeded: dict[str, Participant] = {}
    for name, participant in participants.items():
        with collecting(faults):
            action(name)
            succeeded[name] = participant
    return succeeded


def _fed(system: System, name: str, started: Mapping[str, Participant]) -> dict[str, Any]:
    """Return outputs of started participants, by the input of `name` they are wired to."""
    return {
        c.target[1]: started[c.source[0]].get(c.source[1])
        for c in (*system.wires, *system.held)
        if c.target[0] == name and c.source[0] in started
    }


def _is_clocked(participants: Mapping[str, Participant], wire: Wire) -> bool:
    """Return whether the source of a wire has no value before its clock ticks."""
    owner, name = wire.source
    return bool(getattr(participants[owner].fields[name], "clocked", False))


def _agree(interface: Interface) -> None:
    """Bring the wires of participants in Initialization Mode to agreement, if there are loops."""
    if not interface.feedback.any():
        return
    newton = Newton(START_ITERATIONS, differences=True)
    begin = Start(interface)
    try:
        first = begin.evaluate(interface.read())
        solution = newton.solve(begin, first.outputs, newton.memory())
    except NotConverged as failure:
        raise BadInput(
            f"wires: expected start values that agree, got none: {failure.explained()}; give "
            "values nearer to a solution in participants.NAME.parameters"
        ) from None
    if names := _undetermined(begin, solution.x):
        raise BadInput(
            f"{', '.join(names)}: expected a loop that determines its values, got a singular one; "
            "break the loop or change one of its equations"
        )


def _undetermined(begin: "Start", x: np.ndarray) -> list[str]:
    """Return the inputs on unknown wires that the start loop leaves open.

    Eq. (Q12):  (I - J) v = s v',   singular where s < SINGULAR_RATIO,   J by differences

    Loops of more than LARGEST_CHECKED unknowns are not checked.
    """
    interface = begin.interface
    unknowns = np.flatnonzero(interface.feedback)
    if not 0 < len(unknowns) <= LARGEST_CHECKED:
        return []
    matrix = jacobian(begin, x)
    begin.evaluate(x)
    _, sizes, directions = np.linalg.svd(np.eye(len(unknowns)) - matrix)  # Eq. (Q12)
    open_ones = np.abs(directions[sizes < SINGULAR_RATIO]).max(axis=0, initial=0.0)
    named = {int(unknowns[k]) for k in np.flatnonzero(open_ones > 0.1)}
    return [
        ".".join(wire.target)
        for wire, part in zip(interface.wires, interface.parts)
        if named & set(range(part.start, part.stop))
    ]


class Start:
    """Initialization Mode as a macro step: outputs follow inputs without a step."""

    def __init__(self, interface: Interface):
        self.interface = interface

    def evaluate(self, x: np.ndarray) -> Evaluation:
        """Set the inputs of every participant, later ones to the outputs of earlier ones."""
        return self.interface.evaluate(x)

    def derivative(self, change: np.ndarray) -> np.ndarray:
        """Raise: Newton uses differences here."""
        raise NotImplementedError


@contextmanager
def closing(
    participants: Iterable[Participant], say: Callable[[str], object] = warnings.warn
) -> Generator[None, None, None]:
    """Close all participants at the end.

    Report those that fail to close after all are closed, unless another fault came before.
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
    for fault in faults:
        say(str(fault))
