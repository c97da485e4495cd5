"""Checks of the participants' saved states and derivatives at the start of a run."""

from dataclasses import replace

from ..fmi.errors import BadInput, collecting
from ..participants.derivatives import Differenced, objection
from ..participants.one_way import OneWayParticipant
from ..participants.rollback import rollback_fault
from .components import rolled_back
from .methods import Method, Newton
from .wiring import System


def untrusted(system: System, iterates: bool = True) -> dict[str, str]:
    """Return why the saved states of a participant are not used, by participant.

    Participants whose steps are never repeated are not checked: some FMUs go on differently from a
    state that is restored. `iterates` tells whether the method iterates loops.

    Raises
    ------
    BadInput
        If there is one where the length of all steps follows from a local error, and if instances
        of an FMU disturb one another.
    """
    reasons: dict[str, str] = {}
    faults: list[str] = []
    for name in rolled_back(system, iterates):
        inputs = [w.target[1] for w in (*system.wires, *system.held) if w.target[0] == name]
        with collecting(faults):
            fault = rollback_fault(system.participants[name], inputs, system.step, system.begin)
            if fault:
                reasons[name] = fault
    if any(wire.local_error is not None for wire in system.wires):
        faults += [
            f"participants.{name}: expected a restored state with local_error, got {why}"
            for name, why in reasons.items()
        ]
    if faults:
        raise BadInput(faults)
    return reasons


def without_rollback(system: System, reasons: dict[str, str]) -> System:
    """Return the system in which participants with a reason are never restored."""
    return replace(
        system,
        participants={
            name: OneWayParticipant(participant) if name in reasons else participant
            for name, participant in system.participants.items()
        },
    )


def objections(system: System, method: Method) -> dict[str, str]:
    """Return why a participant's derivative is not used, by participant; empty if it is used.

    Participants are missing if they offer no derivative or the method needs none.

    Parameters
    ----------
    system : System
        Its participants must have been started; they are left as they were.
    method : Method
    """
    if not isinstance(method, Newton) or method.differences:
        return {}
    reasons: dict[str, str] = {}
    for name in rolled_back(system):
        participant = system.participants[name]
        inputs = [w.target[1] for w in system.wires if w.target[0] == name]
        outputs = [w.source[1] for w in system.wires if w.source[0] == name]
        if participant.has_derivatives and participant.can_redo and inputs and outputs:
            reasons[name] = objection(
                participant, inputs, list(dict.fromkeys(outputs)), system.step, system.begin
            )
    return reasons


def by_differences(system: System, objected: dict[str, str]) -> System:
    """Return the system with derivatives by differences where there is an objection."""
    return replace(
        system,
        participants={
            name: Differenced(participant) if objected.get(name) else participant
            for name, participant in system.participants.items()
        },
    )


def sentences(objected: dict[str, str]) -> list[str]:
    """Return the messages about them."""
    return [
        f"{name}: uses finite differences instead of its directional derivative: {why}"
        for name, why in objected.items()
        if why
    ]
