"""A cycle repeated until it is periodic: how far its end is from the end of the one before.

From `time.start` to `time.stop` is one cycle. What is compared are all wires that carry reals, and
what the contract says an FMU of a role `repeats`: together film, motion and oil.

Cycles are plainly repeated. With flooded edges each is nearer by a factor of ten (numerical
example, rigid, 16 x 12 cells, from rest: 0.88, 0.013, 1.4e-3, 1.3e-4, 5e-6), which leaves nothing
to gain by extrapolation. Where oil on the bore is followed, its amount is slower (data sheet,
12 x 8 cells, a layer of 5 um, steps of 4 deg: 0.04 in the fifth, 0.03 in the eighth cycle), and on
so coarse a grid motion jumps about by as much: extrapolating that would not be safe.
"""

from collections.abc import Iterable, Mapping

import numpy as np

from ..case.contract import contract, players
from ..fmi.errors import BadInput

Port = tuple[str, str]
"""Participant and variable."""


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
        Cycles at most.

    Attributes
    ----------
    cycles : int
        Finished ones.
    distances : list of float
        d of each [-].
    furthest : (participant, variable)
        Field that the last one is of.
    """

    def __init__(
        self, compared: Iterable[Port], turning: Iterable[Port], tolerance: float, most: int
    ):
        self.compared = list(compared)
        self.turning = list(turning)
        self.tolerance = tolerance
        self.most = most
        self.cycles = 0
        self.distances: list[float] = []
        self.furthest = self.compared[0]
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
        return self.is_periodic or self.cycles >= self.most

    def begin(self, participants: Mapping) -> None:
        """A cycle begins where the participants stand."""
        self.start = self._read(participants)
        self.low = dict(self.start)
        self.high = dict(self.start)
        self.begun = {
            (owner, name): float(participants[owner].get(name)) for owner, name in self.turning
        }
        self.first = self.first or self.begun

    def note(self, participants: Mapping) -> None:
        """A step is accepted."""
        for port, value in self._read(participants).items():
            self.low[port] = np.minimum(self.low[port], value)
            self.high[port] = np.maximum(self.high[port], value)

    def end(self, participants: Mapping) -> float:
        """The cycle is over: how far it is from the one before, by Eq. (Y2)."""
        now = self._read(participants)
        self.cycles += 1
        apart = {port: self._apart(port, now[port]) for port in self.compared}
        self.furthest = max(apart, key=apart.__getitem__)
        self.distances.append(apart[self.furthest])
        return self.distances[-1]

    def turned(self, port: Port) -> float:
        """By how much an output has grown from the first cycle's beginning to this one's."""
        return self.begun[port] - self.first[port] if port in self.begun else 0.0

    def sentence(self) -> str:
        """The last cycle in words."""
        text = (
            f"cycle {self.cycles}: its end is {self.distances[-1]:.2g} from its beginning "
            f"({'.'.join(self.furthest)}), wanted {self.tolerance:g}"
        )
        if self.is_over and not self.is_periodic:
            text += f"; not periodic after {self.cycles} cycles (time.most_cycles)"
        return text

    def summary(self) -> dict[str, object]:
        """Summary entries."""
        return {
            "cycles": self.cycles,
            "cycle_distance": self.distances[-1] if self.distances else float("nan"),
            "periodic": self.is_periodic,
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
    return Repetition(compared, turning, case.time.until_periodic, case.time.most_cycles)
