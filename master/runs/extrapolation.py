"""What changes little from cycle to cycle, extrapolated to where it would stay.

Motion forgets its start within a few cycles; an amount that is only handed on, such as a deposit
that each cycle wears down by a hundredth, does not. Participants name such members in their saved
states (`fmi.state_bytes`), and between two cycles they are set to where the secant of the last two
cycles vanishes, which is Anderson's method of depth one:

Eq. (Y3):  x <- g_k - c (g_k - g_{k-1}),   c = f_k.(f_k - f_{k-1}) / |f_k - f_{k-1}|^2,   f = g - x

x and g are a member at the beginning and at the end of a cycle. c is 1 at most and not below
-FARTHEST; a member that moves on as fast as before, which asks for c > 1 or has no secant, takes
c = -FARTHEST. A member that was nowhere negative does not become so.

A cycle after which a member is farther from repeating than it was before the extrapolation is taken
back: all participants return to the end of the cycle before. After the second time cycles are
plainly repeated.

References
----------
[Walker2011] H. F. Walker, P. Ni, Anderson acceleration for fixed-point iterations, SIAM J. Numer.
Anal. 49 (2011) 1715-1735.
"""

from collections.abc import Mapping

import numpy as np

from ..fmi.state_bytes import slow_members, with_members

FARTHEST = 30.0
"""Changes of a cycle that a member is moved on by at most: one that falls by 3 % a cycle goes all
of its way at once.
"""
ROUND_OFF = 1e-10
"""Of a member: changes up to here say nothing."""
REFUSALS = 2
"""Extrapolations taken back until no more are made."""

Member = tuple[str, str]
"""Participant and member of its state."""
Members = dict[Member, np.ndarray]


class Extrapolation:
    """Slow members of the participants over the cycles.

    Attributes
    ----------
    made, taken_back : int
        Extrapolations.
    """

    def __init__(self):
        self.made = 0
        self.taken_back = 0
        self.begun: Members = {}
        self.ended: Members = {}
        self.changes: Members = {}
        self.before: Members = {}
        self.changes_before: Members = {}
        self.kept: dict[str, bytes] = {}
        self.apart = np.inf
        self.apart_before = np.inf

    def begin(self, participants: Mapping) -> None:
        """A cycle begins where the participants stand."""
        self.begun = _members(_states(participants))

    def end(self, participants: Mapping) -> None:
        """The cycle is over."""
        self.before = self.ended
        self.changes_before = self.changes
        self.ended = _members(_states(participants))
        self.changes = {
            port: value - self.begun[port]
            for port, value in self.ended.items()
            if port in self.begun
        }
        self.apart_before = self.apart
        self.apart = max(
            (_apart(self.begun[port], self.ended[port]) for port in self.changes), default=0.0
        )

    def proceed(self, participants: Mapping) -> str:
        """Set the participants to the start of the next cycle; return a message, or ""."""
        if self.kept and self.apart > self.apart_before:
            return self._take_back(participants)
        self.kept = {}
        if self.taken_back >= REFUSALS:
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
        self.kept = _states(participants)
        for owner in {owner for owner, _ in moved}:
            members = {name: value for (one, name), value in moved.items() if one == owner}
            _restore(participants[owner], with_members(self.kept[owner], members))
        self.made += 1
        told = (
            f"{'.'.join(port)} by {_size(value - self.ended[port]) / _size(self.changes[port]):.2g}"
            for port, value in moved.items()
        )
        return f"extrapolated by multiples of the last period's change: {', '.join(told)}"

    def _take_back(self, participants):
        for owner, data in self.kept.items():
            _restore(participants[owner], data)
        self.taken_back += 1
        said = f"relative change {self.apart:.2g} instead of {self.apart_before:.2g}"
        self.ended, self.changes, self.kept, self.apart = {}, {}, {}, np.inf
        return f"rejected the extrapolation and its period: {said}"


def extrapolated(
    ends: tuple[np.ndarray, np.ndarray], changes: tuple[np.ndarray, np.ndarray]
) -> np.ndarray:
    """Where a member would stay, by Eq. (Y3).

    Parameters
    ----------
    ends : (ndarray, ndarray)
        g_{k-1}, g_k.
    changes : (ndarray, ndarray)
        f_{k-1}, f_k.

    Returns
    -------
    ndarray
        Of the shape of the member.
    """
    end_before, end = ends
    change_before, change = changes
    turn = change - change_before
    if _size(change) <= ROUND_OFF * _size(end):
        return end
    length = float(np.vdot(turn, turn))
    share = float(np.vdot(change, turn)) / length if length else np.inf
    if not -FARTHEST <= share <= 1.0:
        share = -FARTHEST
        moved = end - share * change
    else:
        moved = end - share * (end - end_before)  # Eq. (Y3)
    if min(end.min(), end_before.min()) >= 0.0:
        moved = np.maximum(moved, 0.0)
    return moved


def _states(participants):
    """Serialised states of all participants."""
    states = {}
    for name, participant in participants.items():
        saved = participant.save()
        states[name] = bytes(participant.serialise(saved))
        participant.free(saved)
    return states


def _members(states):
    """Slow members in serialised states, those that hold anything."""
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
    """Change over a cycle, as a share of the larger one."""
    size = max(_size(begun), _size(ended))
    return _size(ended - begun) / size if size else 0.0


def _size(values):
    """Root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))
