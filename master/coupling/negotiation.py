"""Which participants' own derivatives Newton may use: negotiated at the start of a run, not
believed.
"""

from dataclasses import replace

from ..participants.derivatives import Differenced, objection
from .methods import Method, Newton
from .wiring import System


def objections(system: System, method: Method) -> dict[str, str]:
    """Why a participant's own derivative is not used, by participant; empty for those it is used
    of. The others offer none, or the method asks for none.

    Parameters
    ----------
    system : System
        Its participants must have been started; they are left as they were.
    method : Method
    """
    if not isinstance(method, Newton) or method.differences:
        return {}
    reasons = {}
    for name in system.order:
        participant = system.participants[name]
        inputs = [w.target[1] for w in system.wires if w.target[0] == name]
        outputs = [w.source[1] for w in system.wires if w.source[0] == name]
        if participant.has_derivatives and participant.can_redo and inputs and outputs:
            reasons[name] = objection(
                participant, inputs, list(dict.fromkeys(outputs)), system.step
            )
    return reasons


def by_differences(system: System, objected: dict[str, str]) -> System:
    """The system with derivatives by differences of steps where there is an objection."""
    return replace(
        system,
        participants={
            name: Differenced(participant) if objected.get(name) else participant
            for name, participant in system.participants.items()
        },
    )


def sentences(objected: dict[str, str]) -> list[str]:
    """What the run says of them."""
    return [
        f"{name}: its own directional derivative is not used, {why}; differences of steps are"
        for name, why in objected.items()
        if why
    ]
