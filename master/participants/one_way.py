"""FMU without rollback, or one whose rollback is not trusted: each step is taken once."""

from contextlib import contextmanager

from ..fmi.errors import Discard, ParticipantFault
from .participant import Wrapper


class OneWayParticipant(Wrapper):
    """Participant whose states are not restored.

    Parameters
    ----------
    participant : Participant

    Raises
    ------
    ParticipantFault
        By `step` if the FMU discards it, and by `restore` after a step.
    """

    can_redo = can_serialise = False

    def __init__(self, participant):
        super().__init__(participant)
        self._steps = 0

    def step(self, time, step):
        """Take a step [s]."""
        self._steps += 1
        with self._once():
            self.participant.step(time, step)

    def begin_step(self, time, step):
        self._steps += 1
        self.participant.begin_step(time, step)

    def end_step(self):
        with self._once():
            self.participant.end_step()

    @contextmanager
    def _once(self):
        """Convert `Discard` to a fault, because the step cannot be repeated."""
        try:
            yield
        except Discard as refusal:
            raise ParticipantFault(f"{refusal}; {self._message}") from None

    @property
    def _message(self):
        return "it cannot save and restore its state, so the step cannot be taken again"

    def save(self):
        """Return the number of steps so far, which stands for the state."""
        if begin_here := getattr(self.participant, "begin_here", None):
            begin_here()
        return self._steps

    def restore(self, saved):
        """Do nothing if no step was taken since; else raise `ParticipantFault`."""
        if saved != self._steps:
            raise ParticipantFault(f"{self.name}: {self._message}")

    def free(self, saved):
        """Do nothing, because nothing is saved."""
