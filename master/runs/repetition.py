"""A cycle repeated until it is periodic: how far its end is from the end of the one before.

From `time.start` to `time.stop` is one cycle. What is compared are all wires that carry reals, and
what the contract says an FMU of a role `repeats`: together film, motion and oil.

Motion and a flooded film forget their start by a factor of ten a cycle (numerical example, rigid,
16 x 12 cells, from rest: 0.88, 0.013, 1.4e-3, 1.3e-4, 5e-6). What a participant says is slower is
extrapolated between two cycles, `extrapolation`. Not every engine repeats: a piston that slaps on
scarce oil may take another course in each cycle. Then distances stop falling, and a run says so.
"""

from collections.abc import Iterable, Mapping

import numpy as np

from ..case.contract import contract, players
from ..fmi.errors import BadInput
from .extrapolation import Extrapolation

Port = tuple[str, str]
"""Participant and variable."""

NO_NEARER = 3
"""Cycles after which a distance that has not become smaller is said to have stopped falling: an
extrapolation that is taken back costs one, and a distance need not fall in every cycle.
"""
SHOWN = 4
"""Fields that are named where a run does not become periodic."""


class Repetition:
    """What a run knows of its cycles.

    Eq. (Y2):  d = max over fields of  |q_1 - q_0| / |max_t q - min_t q|

    q_0, q_1 are a field at the beginning and at the end of the cycle, the range is that of every
    cell over the accepted steps of the cycle, |.| is the root mean square over the cells. So d is
    without unit, and 0 for a field that does not move.

    Parameters
    ----------
    compared : sequence of (participant, variable)
        The fields of Eq. (Y2).
    turning : sequence of (participant, variable)
        Outputs that grow from cycle to cycle: results count them from the beginning of the cycle.
    tolerance : float
        On d.
    most : int
        Cycles at most, those taken back included.
    extrapolation : Extrapolation, optional
        Of what is slow; without it cycles are plainly repeated.

    Attributes
    ----------
    cycles : int
        Finished ones that stand.
    distances : list of float
        d of each [-].
    furthest : (participant, variable)
        Field that the last one is of.
    apart : dict of (participant, variable) to float
        Of each field over the last cycle [-].
    """

    def __init__(
        self,
        compared: Iterable[Port],
        turning: Iterable[Port],
        tolerance: float,
        most: int,
        extrapolation: Extrapolation | None = None,
    ):
        self.compared = list(compared)
        self.turning = list(turning)
        self.tolerance = tolerance
        self.most = most
        self.extrapolation = extrapolation
        self.cycles = 0
        self.distances: list[float] = []
        self.furthest = self.compared[0]
        self.apart: dict[Port, float] = {}
        self.first: dict[Port, float] = {}
        self.begun: dict[Port, float] = {}
        self.start: dict[Port, np.ndarray] = {}
        self.low: dict[Port, np.ndarray] = {}
        self.high: dict[Port, np.ndarray] = {}

    @property
    def is_periodic(self) -> bool:
        """Whether the last cycle repeats the one before to the tolerance."""
        return bool(self.distances) and self.distances[-1] <= self.tolerance

    @property
    def is_over(self) -> bool:
        """Whether no further cycle is to be run."""
        return self.is_periodic or self.taken >= self.most

    @property
    def taken(self) -> int:
        """Cycles that were run."""
        return self.cycles + (self.extrapolation.taken_back if self.extrapolation else 0)

    def begin(self, participants: Mapping) -> None:
        """A cycle begins where the participants stand."""
        self.start = self._read(participants)
        self.low = dict(self.start)
        self.high = dict(self.start)
        self.begun = {
            (owner, name): float(participants[owner].get(name)) for owner, name in self.turning
        }
        self.first = self.first or self.begun
        if self.extrapolation:
            self.extrapolation.begin(participants)

    def note(self, participants: Mapping) -> None:
        """A step is accepted."""
        for port, value in self._read(participants).items():
            self.low[port] = np.minimum(self.low[port], value)
            self.high[port] = np.maximum(self.high[port], value)

    def end(self, participants: Mapping) -> float:
        """The cycle is over: how far it is from the one before, by Eq. (Y2)."""
        now = self._read(participants)
        self.cycles += 1
        self.apart = {port: self._apart(port, now[port]) for port in self.compared}
        self.furthest = max(self.apart, key=self.apart.__getitem__)
        self.distances.append(self.apart[self.furthest])
        if self.extrapolation:
            self.extrapolation.end(participants)
        return self.distances[-1]

    def proceed(self, participants: Mapping) -> str:
        """Put the participants where the next cycle begins; what was done, in words, or nothing."""
        if self.extrapolation is None:
            return ""
        before = self.extrapolation.taken_back
        said = self.extrapolation.proceed(participants)
        self.cycles -= self.extrapolation.taken_back - before
        return said

    def turned(self, port: Port) -> float:
        """By how much an output has grown from the first cycle's beginning to this one's."""
        return self.begun[port] - self.first[port] if port in self.begun else 0.0

    def sentence(self) -> str:
        """The last cycle in words."""
        text = (
            f"cycle {self.taken}: its end is {self.distances[-1]:.2g} from its beginning "
            f"({'.'.join(self.furthest)}), wanted {self.tolerance:g}"
        )
        if not self.is_periodic and self.no_nearer >= NO_NEARER:
            text += f"; no nearer for {self.no_nearer} cycles than {min(self.distances):.2g}"
        if self.is_over and not self.is_periodic:
            text += f"; not periodic after {self.taken} cycles (time.most_cycles): {self._why()}"
        return text

    @property
    def no_nearer(self) -> int:
        """Cycles since the one that was nearest to repeating."""
        if not self.distances:
            return 0
        return len(self.distances) - 1 - self.distances.index(min(self.distances))

    def _why(self):
        """What does not repeat, the farthest first, and whether more cycles promise anything."""
        farthest = sorted(self.apart, key=self.apart.__getitem__, reverse=True)
        fields = ", ".join(
            f"{'.'.join(port)} {self.apart[port]:.2g}"
            for port in farthest[:SHOWN]
            if self.apart[port] > self.tolerance
        )
        rest = sum(value > self.tolerance for value in self.apart.values()) - SHOWN
        fields += f" and {rest} more" if rest > 0 else ""
        if self.no_nearer >= NO_NEARER:
            return f"the distances have stopped falling, {fields} do not repeat from cycle to cycle"
        return f"still coming nearer, {fields} would need more cycles"

    def summary(self) -> dict[str, object]:
        """Summary entries."""
        slow = self.extrapolation
        counted: dict[str, object] = {}
        if slow and slow.made:
            counted = {"extrapolated_cycles": slow.made, "taken_back_cycles": slow.taken_back}
        return {
            "cycles": self.taken,
            "cycle_distance": self.distances[-1] if self.distances else float("nan"),
            "cycle_distance_least": min(self.distances, default=float("nan")),
            "periodic": self.is_periodic,
            **counted,
        }

    def _read(self, participants):
        return {
            (owner, name): np.array(participants[owner].get(name), dtype=float)
            for owner, name in self.compared
        }

    def _apart(self, port, now):
        change = np.sqrt(np.mean((now - self.start[port]) ** 2))
        extent = np.sqrt(np.mean((self.high[port] - self.low[port]) ** 2))
        return float(change / extent) if extent else 0.0  # Eq. (Y2)


def repetition(case, tree, system) -> Repetition | None:
    """Of a case that asks for it: what its wires carry, and what the contract's roles repeat.

    Raises
    ------
    BadInput
        If there is nothing to compare.
    """
    if case.time.until_periodic is None:
        return None
    compared: dict[Port, None] = {wire.source: None for wire in system.wires}
    turning: dict[Port, None] = {}
    for role, terms in contract().items():
        for name in players(tree, role):
            known = system.participants[name].fields
            compared |= {(name, one): None for one in terms.repeats if one in known}
            turning |= {(name, one): None for one in terms.turning if one in known}
    compared = {port: None for port in compared if port not in turning}
    if not compared:
        raise BadInput(
            "time.until_periodic: nothing tells whether a cycle repeats: the case has no wire of "
            "reals, and no participant with a role of the contract"
        )
    time = case.time
    storable = all(getattr(p, "can_serialise", False) for p in system.participants.values())
    slow = Extrapolation() if storable else None
    return Repetition(compared, turning, time.until_periodic, time.most_cycles, slow)
