"""An FMU that cannot go back, or that is not trusted to: it takes every step once, and a step that
would have to be repeated ends the run.
"""

from contextlib import contextmanager

from ..fmi.errors import Discard, ParticipantFault


class OneWayParticipant:
    """A participant whose states are not restored; everything else is its own.

    Parameters
    ----------
    participant : Participant

    Raises
    ------
    ParticipantFault
        By `step` where the FMU discards it, and by `restore` after a step.
    """

    can_redo = can_serialise = False

    def __init__(self, participant):
        self.participant = participant
        self._steps = 0

    def __getattr__(self, name):
        return getattr(self.participant, name)

    def step(self, time, step):
        """One step [s]."""
        self._steps += 1
        with self._once():
            self.participant.step(time, step)

    def begin_step(self, time, step):
        """The same as far as it can be sent away; see `IsolatedParticipant.begin_step`."""
        self._steps += 1
        self.participant.begin_step(time, step)

    def end_step(self):
        """Wait for the end of the step that was begun."""
        with self._once():
            self.participant.end_step()

    @contextmanager
    def _once(self):
        """A step that is discarded cannot be taken again."""
        try:
            yield
        except Discard as refusal:
            raise ParticipantFault(f"{refusal}; {self._words}") from None

    @property
    def _words(self):
        return "it cannot save and restore its state, so the step cannot be taken again"

    def save(self):
        """How many steps have been taken: all that can be known of the state."""
        if begin_here := getattr(self.participant, "begin_here", None):
            begin_here()
        return self._steps

    def restore(self, saved):
        """Nothing, where no step has been taken since."""
        if saved != self._steps:
            raise ParticipantFault(f"{self.name}: {self._words}")

    def free(self, saved):
        """Nothing is kept."""
