"""An FMU that cannot go back: it takes every step once, and a step that would have to be repeated
ends the run.
"""

from ..fmi.errors import Discard, ParticipantFault


class OneWayParticipant:
    """A participant without saved states, where nothing is iterated; everything else is its own.

    Parameters
    ----------
    participant : Participant

    Raises
    ------
    ParticipantFault
        By `step` where the FMU discards it, and by `restore` after a step.
    """

    def __init__(self, participant):
        self.participant = participant
        self._steps = 0

    def __getattr__(self, name):
        return getattr(self.participant, name)

    def step(self, time, step):
        """One step [s]."""
        self._steps += 1
        try:
            self.participant.step(time, step)
        except Discard as refusal:
            raise ParticipantFault(f"{refusal}; {self._words}") from None

    @property
    def _words(self):
        return "it cannot save and restore its state, so the step cannot be taken again"

    def save(self):
        """How many steps have been taken: all that can be known of the state."""
        return self._steps

    def restore(self, saved):
        """Nothing, where no step has been taken since."""
        if saved != self._steps:
            raise ParticipantFault(f"{self.name}: {self._words}")

    def free(self, saved):
        """Nothing is kept."""
