"""A stepper and its participants as bytes: what every further step depends on, equal content giving
equal bytes.
"""

from ..participants.plain import NotPlain, pack, unpack
from .methods.explicit import Growth
from .methods.krylov import Pairs, RecycledGmres
from .methods.quasi_newton import Memory
from .methods.secants import (
    Ageing,
    AgeingMemory,
    Decomposed,
    LeastSquares,
    LeastSquaresMemory,
    MultiVector,
    MultiVectorMemory,
    Pair,
    Rings,
)
from .step_control import StepControl

REMEMBERED = (
    Ageing,
    AgeingMemory,
    Decomposed,
    Growth,
    LeastSquares,
    LeastSquaresMemory,
    Memory,
    MultiVector,
    MultiVectorMemory,
    Pair,
    Pairs,
    RecycledGmres,
    Rings,
    StepControl,
)
"""Classes of what methods and step control remember; a new one has to be named here."""


def freeze(stepper):
    """States of all participants, the predictor's history, what the method remembers and step
    control, as bytes.
    """
    states = {}
    for name, participant in stepper.interface.participants.items():
        saved = participant.save()
        states[name] = participant.serialise(saved)
        participant.free(saved)
    whole = (states, stepper.predictor.past, stepper.memory, stepper.control)
    return pack(whole, remembered(stepper))


def remembered(stepper):
    """Classes of what a stepper's method and step control remember, those of other packages too."""
    own = (getattr(part, "remembered", ()) for part in (stepper.method, stepper.control))
    return (*REMEMBERED, *(kind for kinds in own for kind in kinds))


def thaw(stepper, data):
    """Put a started stepper and its participants where `freeze` found them; NotPlain if the bytes
    are of another system.
    """
    states, past, memory, control = unpack(data, remembered(stepper))
    others = {type(memory), type(control)} != {type(stepper.memory), type(stepper.control)}
    if others or states.keys() != stepper.interface.participants.keys():
        raise NotPlain("it is of other participants or of another method")
    stepper.predictor.past = past
    stepper.memory = memory
    stepper.control = control
    for name, participant in stepper.interface.participants.items():
        saved = participant.deserialise(states[name])
        participant.restore(saved)
        participant.free(saved)
