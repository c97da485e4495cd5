"""FMU without saved states that is restarted instead, for checks before a run."""

from collections.abc import Mapping
from typing import Any

from .participant import Wrapper


class RestartedParticipant(Wrapper):
    """Participant whose only state is its start.

    Parameters
    ----------
    participant : Participant
        Started.
    values : mapping
        Its parameters and the values of its inputs.
    begin, end : float
        Start and stop time of its start [s].
    """

    def __init__(self, participant: Any, values: Mapping[str, Any], begin: float, end: float):
        super().__init__(participant)
        self.start_arguments = values, begin, end

    def save(self):
        """Do nothing, because there is only one state."""

    def restore(self, saved):
        """Restart the participant."""
        self.participant.close()
        self.participant.start(*self.start_arguments)
        self.participant.save()  # interpolated inputs begin here

    def free(self, saved):
        """Do nothing, because nothing is saved."""
