"""Instants at which clocks tick: macro steps end there, and ticks trigger other clocks."""

from collections.abc import Mapping, Sequence
from typing import Any

from ..fmi.errors import Discard
from .wiring import HeldWire, carry

LARGEST_ITERATION = 1000
"""Maximum number of rounds of ticks at an instant, and of macro steps with ticks in an interval."""
TIME_TOLERANCE = 1e-9
"""Share of a step that counts as zero."""


class EndlessEvents(RuntimeError):
    """Clocks that trigger one another, or tick, without end."""


class Events:
    """Clocks of all participants.

    Before the macro step from an instant t:

    1. Held wires carry their values, so that clocked inputs sample them.
    2. Clocks tick that are due by their interval.
    3. Wires of clocks carry all ticks since the last instant to the clocks that they trigger. This
       repeats, with the values at that time, until no clock ticks.

    The macro step ends at the next tick at the latest. If a wired clock ticks within it, the macro
    step is repeated up to this tick.

    Parameters
    ----------
    participants : dict of str to Participant
    held : sequence of HeldWire
        Wires of the system that are not iterated.
    clocks : sequence of HeldWire
        From output clocks to triggered input clocks.
    """

    def __init__(
        self,
        participants: Mapping[str, Any],
        held: Sequence[HeldWire],
        clocks: Sequence[HeldWire],
    ):
        self.participants, self.held, self.clocks = participants, held, clocks
        self.timed = [p for p in participants.values() if getattr(p, "has_clocks", False)]
        if all(getattr(p, "can_redo", True) for p in participants.values()):
            for owner in dict.fromkeys(wire.source[0] for wire in clocks):
                names = [wire.source[1] for wire in clocks if wire.source[0] == owner]
                participants[owner].stop_at(names)

    def __bool__(self) -> bool:
        return bool(self.timed)

    def length(self, time: float, step: float) -> float:
        """Process the ticks at `time` [s]; return the length of the next macro step [s].

        It is at most `step`. Raises EndlessEvents if the ticks do not come to an end.
        """
        try:
            carry(self.participants, self.held)
            for participant in self.timed:
                participant.tick(time, step)
            self._trigger(time)
        except Discard as refusal:
            raise EndlessEvents(str(refusal)) from None
        tick = min(participant.next_tick() for participant in self.timed)
        return tick - time if tick < time + step * (1.0 - TIME_TOLERANCE) else step

    def _trigger(self, time: float) -> None:
        """Hand ticks on along the wires of clocks."""
        sources = dict.fromkeys(wire.source for wire in self.clocks)
        for _ in range(LARGEST_ITERATION):
            ticked = [port for port in sources if self.participants[port[0]].get(port[1])]
            triggered = [wire for wire in self.clocks if wire.source in ticked]
            if not triggered:
                return
            pairs = {(wire.source[0], wire.target[0]) for wire in triggered}
            to_tick = [w for w in self.held if (w.source[0], w.target[0]) in pairs]
            carry(self.participants, to_tick)
            for owner, name in dict.fromkeys(wire.target for wire in triggered):
                self.participants[owner].set(name, True)
        raise EndlessEvents(f"t = {time:.6g} s: clocks trigger one another without end")
