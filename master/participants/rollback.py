"""Trial of an FMU's rollback before the run: a step taken, undone and taken again must give the
same bytes.
"""

import numpy as np
from fmpy.fmi1 import FMICallException

from ..fmi.errors import Discard


def rollback_faults(participant, step, begin=0.0):
    """What is wrong with saving and restoring a started participant's state; it is left as it was.

    Parameters
    ----------
    participant : Participant
    step : float
        Macro step [s] to try.
    begin : float
        Where the participant stands [s].

    Returns
    -------
    list of str
        Sentences; empty if all is well, or if the participant refuses this step, which the run will
        then hear.
    """
    try:
        saved = participant.save()
        try:
            first = _outcome(participant, saved, begin, step)
            second = _outcome(participant, saved, begin, step)
        except Discard:
            return []
        finally:
            participant.restore(saved)
            participant.free(saved)
    except FMICallException as error:
        return [f"{participant.name}: its state cannot be saved and restored: {error}"]
    different = [name for name, value in first.items() if value != second[name]]
    if not different:
        return []
    return [
        f"{participant.name}: a step taken again from its saved state gives another "
        f"{', '.join(different)}"
    ]


def _outcome(participant, saved, begin, step):
    """Bytes of every real output after a step from a saved state."""
    participant.restore(saved)
    participant.step(begin, step)
    return {
        name: np.asarray(participant.get(name)).tobytes()
        for name, field in participant.fields.items()
        if field.causality == "output" and field.type == "Real"
    }
