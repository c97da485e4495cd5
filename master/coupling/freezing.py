"""A stepper and its participants as bytes: what every further step depends on, equal content giving
equal bytes.
"""

import pickle
from io import BytesIO

import numpy as np


class ArrayPickler(pickle.Pickler):
    """Equal content gives equal bytes: NumPy's own way writes a shared dtype once, and loses the
    sharing when it is read.
    """

    def reducer_override(self, thing):
        return (
            (_array, (thing.tobytes(), thing.dtype.str, thing.shape))
            if type(thing) is np.ndarray
            else NotImplemented
        )


def _array(data, dtype, shape):
    return np.frombuffer(data, dtype).reshape(shape).copy()


def freeze(stepper):
    """States of all participants, the predictor's history, what the method remembers and step
    control, as bytes.
    """
    states = {}
    for name, participant in stepper.interface.participants.items():
        saved = participant.save()
        states[name] = participant.serialise(saved)
        participant.free(saved)
    buffer = BytesIO()
    ArrayPickler(buffer).dump((states, stepper.predictor.past, stepper.memory, stepper.control))
    return buffer.getvalue()


def thaw(stepper, data):
    """Put a started stepper and its participants where `freeze` found them."""
    states, stepper.predictor.past, stepper.memory, stepper.control = pickle.loads(data)
    for name, participant in stepper.interface.participants.items():
        saved = participant.deserialise(states[name])
        participant.restore(saved)
        participant.free(saved)
