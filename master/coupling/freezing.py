"""Stepper and participants as bytes.

The bytes contain everything that further steps depend on. Equal content has equal bytes.
"""

from collections.abc import Iterable

from ..participants.plain import NotPlain, pack, unpack
from .methods.explicit import Growth
from .methods.krylov import Pairs, RecycledGmres
from .methods.quasi_newton import Memory
from .methods.secants import LeastSquares, Pair
from .step_control import StepControl
from .stepping import Stepper

REMEMBERED = (
    Growth,
    LeastSquares,
    Memory,
    Pair,
    Pairs,
    RecycledGmres,
    StepControl,
)
"""Classes of the memories of methods and step control; a new one must be listed here."""


def freeze(stepper: Stepper) -> bytes:
    """Return a stepper as bytes.

    They contain the states of all participants, the accepted vectors, the memory of the method and
    step control.
    """
    states: dict[str, bytes] = {}
    for name, participant in stepper.interface.participants.items():
        saved = participant.save()
        states[name] = participant.serialise(saved)
        participant.free(saved)
    whole = (states, stepper.predictor.past, stepper.memory, stepper.control)
    return pack(whole, remembered(stepper))


def remembered(stepper: Stepper) -> tuple[type, ...]:
    """Return the classes of the memories of a stepper, including those of other packages."""
    parts = (stepper.method, stepper.control)
    own: Iterable[tuple[type, ...]] = (getattr(part, "remembered", ()) for part in parts)
    return (*REMEMBERED, *(kind for kinds in own for kind in kinds))


def thaw(stepper: Stepper, data: bytes) -> None:
    """Restore a started stepper and its participants from the bytes of `freeze`.

    Raises NotPlain if the bytes are those of another system.
    """
    states, past, memory, control = unpack(data, remembered(stepper))
    others = {type(memory), type(control)} != {type(stepper.memory), type(stepper.control)}
    others |= {x.shape for _, x in past} != {(stepper.interface.size,)}
    if others or states.keys() != stepper.interface.participants.keys():
        raise NotPlain("it is of other participants or of another method")
    stepper.predictor.past = past
    stepper.memory = memory
    stepper.control = control
    for name, participant in stepper.interface.participants.items():
        saved = participant.deserialise(states[name])
        participant.restore(saved)
        participant.free(saved)
