"""Extrapolation of slow members of the state from cycle to cycle.

Motion forgets its start within a few cycles. An amount that each cycle changes by a hundredth, such
as a worn deposit, does not. Participants name such members in their saved states
(`fmi.state_bytes`). Between two cycles, the secant of the last two cycles extrapolates them to no
change, which is Anderson's method of depth one:

Eq. (Y3):  x <- g_k - c (g_k - g_{k-1}),   c = f_k.(f_k - f_{k-1}) / |f_k - f_{k-1}|^2,   f = g - x

x and g are a member at the beginning and at the end of a cycle. c is at most 1 and at least
-MOST_CHANGES. A member that does not slow down (c > 1 or no secant) takes c = -MOST_CHANGES. A
member without negative values stays so.

If a member then repeats worse than before the extrapolation, all participants return to the end of
the previous cycle. After the second such return, there are no more extrapolations.

References
----------
[Walker2011] H. F. Walker, P. Ni, Anderson acceleration for fixed-point iterations, SIAM J. Numer.
Anal. 49 (2011) 1715-1735.
"""

from collections.abc import Mapping

import numpy as np

from ..fmi.state_bytes import slow_members, with_members

MOST_CHANGES = 30.0
"""Largest extrapolation, in changes of a cycle. A member whose change falls by 3 % per cycle
reaches its end at once."""
ROUND_OFF = 1e-10
"""Round-off relative to a member. Smaller changes are ignored."""
MOST_REJECTIONS = 2
"""Number of rejected extrapolations after which no more are made."""

Member = tuple[str, str]
"""Participant and member of its state."""
Members = dict[Member, np.ndarray]


class Extrapolation:
    """Slow members of the participants over the cycles.

    Attributes
    ----------
    made, taken_back : int
        Numbers of extrapolations.
    """

    def __init__(self):
        self.made = 0
        self.taken_back = 0
        self.begun: Members = {}
        self.ended: Members = {}
        self.changes: Members = {}
        self.before: Members = {}
        self.changes_before: Members = {}
        self.saved_states: dict[str, bytes] = {}
        self.distance = np.inf
        self.distance_before = np.inf

    def begin(self, participants: Mapping) -> None:
        """Begin a cycle at the current state of the participants."""
        self.begun = _members(_states(participants))

    def end(self, participants: Mapping) -> None:
        """End the cycle."""
        self.before = self.ended
        self.changes_before = self.changes
        self.ended = _members(_states(participants))
        self.changes = {
            port: value - self.begun[port]
            for port, value in self.ended.items()
            if port in self.begun
        }
        self.distance_before = self.distance
        self.distance = max(
            (_apart(self.begun[port], self.ended[port]) for port in self.changes), default=0.0
        )

    def proceed(self, participants: Mapping) -> str:
        """Set the participants to the start of the next cycle; return a message, or ""."""
        if self.saved_states and self.distance > self.distance_before:
            return self._take_back(participants)
        self.saved_states = {}
        if self.taken_back >= MOST_REJECTIONS:
            return ""
        moved = {
            port: extrapolated(
                (self.before[port], value), (self.changes_before[port], self.changes[port])
            )
            for port, value in self.ended.items()
            if port in self.changes_before and port in self.before
        }
        moved = {port: value for port, value in moved.items() if _size(value - self.ended[port])}
        if not moved:
            return ""
        self.saved_states = _states(participants)
        for owner in {owner for owner, _ in moved}:
            members = {name: value for (one, name), value in moved.items() if one == owner}
            _restore(participants[owner], with_members(self.saved_states[owner], members))
        self.made += 1
        factors = (
            f"{'.'.join(port)} by {_size(value - self.ended[port]) / _size(self.changes[port]):.2g}"
            for port, value in moved.items()
        )
        return f"extrapolated by multiples of the last period's change: {', '.join(factors)}"

    def _take_back(self, participants):
        for owner, data in self.saved_states.items():
            _restore(participants[owner], data)
        self.taken_back += 1
        change = f"relative change {self.distance:.2g} instead of {self.distance_before:.2g}"
        self.ended, self.changes, self.saved_states, self.distance = {}, {}, {}, np.inf
        return f"rejected the extrapolation and its period: {change}"


def extrapolated(
    ends: tuple[np.ndarray, np.ndarray], changes: tuple[np.ndarray, np.ndarray]
) -> np.ndarray:
    """Return the value that a member tends to, by Eq. (Y3).

    Parameters
    ----------
    ends : (ndarray, ndarray)
        g_{k-1}, g_k.
    changes : (ndarray, ndarray)
        f_{k-1}, f_k.

    Returns
    -------
    ndarray
        With the shape of the member.
    """
    end_before, end = ends
    change_before, change = changes
    turn = change - change_before
    if _size(change) <= ROUND_OFF * _size(end):
        return end
    length = float(np.vdot(turn, turn))
    share = float(np.vdot(change, turn)) / length if length else np.inf
    if not -MOST_CHANGES <= share <= 1.0:
        share = -MOST_CHANGES
        moved = end - share * change
    else:
        moved = end - share * (end - end_before)  # Eq. (Y3)
    if min(end.min(), end_before.min()) >= 0.0:
        moved = np.maximum(moved, 0.0)
    return moved


def _states(participants):
    """Return the serialised states of all participants."""
    states = {}
    for name, participant in participants.items():
        saved = participant.save()
        states[name] = bytes(participant.serialise(saved))
        participant.free(saved)
    return states


def _members(states):
    """Return the slow members in serialised states that are not empty."""
    return {
        (owner, name): value
        for owner, data in states.items()
        for name, value in slow_members(data).items()
        if value.size
    }


def _restore(participant, data):
    saved = participant.deserialise(data)
    participant.restore(saved)
    participant.free(saved)


def _apart(begun, ended):
    """Return the change over a cycle, relative to the larger value."""
    size = max(_size(begun), _size(ended))
    return _size(ended - begun) / size if size else 0.0


def _size(values):
    """Return the root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))
