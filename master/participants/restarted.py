"""An FMU without saved states that goes back to its start by being started again: for questions
that are asked before a run.
"""

from collections.abc import Mapping
from typing import Any


class RestartedParticipant:
    """A participant whose only state is that of its start; everything else is its own.

    Parameters
    ----------
    participant : Participant
        Started.
    values : mapping
        Its parameters and the values of its inputs.
    begin, end : float
        What it was started with [s].
    """

    def __init__(self, participant: Any, values: Mapping[str, Any], begin: float, end: float):
        self.participant = participant
        self.given = values, begin, end

    def __getattr__(self, name):
        return getattr(self.participant, name)

    def save(self):
        """Nothing: there is one state."""

    def restore(self, saved):
        """Start again."""
        self.participant.close()
        self.participant.start(*self.given)
        self.participant.save()  # interpolated inputs begin here

    def free(self, saved):
        """Nothing is kept."""
