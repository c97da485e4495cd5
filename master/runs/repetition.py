"""Periods of a run, and the change from each to the next.

The compared quantities are all wires of real numbers, and the `repeats` of the contract's roles:
film, motion and oil.

Motion and a flooded film forget their start by about a factor of ten in 720 deg. If a run ends
once it is periodic, slower quantities that a participant declares are extrapolated between
periods (`extrapolation`). Not every engine repeats: with little oil, a slapping piston may move
differently in each period. Then the change stops decreasing, and the run reports it.
"""

from collections.abc import Iterable, Mapping

import numpy as np

from ..case.contract import contract, players
from ..coupling.wiring import port_of, rms
from ..fmi.errors import BadInput
from .extrapolation import Extrapolation
from .extremes import Extremes, Port

USUAL_TOLERANCE = 1e-3
"""Tolerance of the change between two periods in a run with a fixed stop time."""
NO_NEARER = 3
"""Periods without a smaller change after which the change is reported as no longer decreasing. A
rejected extrapolation costs one period, and the change may increase in single periods.
"""
MOST_LISTED = 4
"""Number of fields that are listed if a run is not periodic."""


class Repetition:
    """Periods of a run.

    Eq. (Y2):  d = max over fields of  |q_1 - q_0| / |max_t q - min_t q|

    q_0, q_1 are a field at the beginning and at the end of the period. The range is that of every
    cell over the accepted steps of the period. |.| is the root mean square over the cells. d has no
    unit, and is 0 for a constant field.

    Parameters
    ----------
    compared : sequence of (participant, variable)
        The fields of Eq. (Y2).
    tolerance : float
        Tolerance of d.
    ends : bool
        Whether the run ends once it is periodic. Otherwise it continues to its stop time.
    extrapolation : Extrapolation, optional
        Extrapolation of slow members. Default: none.

    Attributes
    ----------
    count : int
        Number of finished periods that were not rejected.
    distances : list of float
        d of each period [-].
    furthest : (participant, variable)
        Field with the largest distance in the last period.
    distance_of : dict of (participant, variable) to float
        Distance of each field over the last period [-].
    """

    def __init__(
        self,
        compared: Iterable[Port],
        tolerance: float,
        ends: bool = True,
        extrapolation: Extrapolation | None = None,
    ):
        self.extremes = Extremes(compared)
        self.tolerance = tolerance
        self.ends = ends
        self.extrapolation = extrapolation
        self.count = 0
        self.distances: list[float] = []
        self.furthest = ("", "")
        self.distance_of: dict[Port, float] = {}

    @property
    def is_periodic(self) -> bool:
        """True if the last period repeats the previous one within the tolerance."""
        return len(self.distances) > 1 and self.distances[-1] <= self.tolerance

    @property
    def is_over(self) -> bool:
        """True if no further period is needed."""
        return self.ends and self.is_periodic

    @property
    def taken(self) -> int:
        """Number of periods that were run."""
        return self.count + (self.extrapolation.taken_back if self.extrapolation else 0)

    def begin(self, participants: Mapping) -> None:
        """Begin a period at the current state of the participants."""
        self.extremes.begin(participants)
        if self.extrapolation:
            self.extrapolation.begin(participants)

    def note(self, participants: Mapping) -> None:
        """Add the outputs of an accepted step."""
        self.extremes.add(participants)

    def end(self, participants: Mapping) -> float:
        """End a period; return its distance from the previous one, by Eq. (Y2)."""
        of_period = self.extremes
        change = of_period.read(participants) - of_period.start
        both = change, of_period.high - of_period.low
        changes, extents = (of_period.fields(participants, one) for one in both)
        self.count += 1
        self.distance_of = {port: distance(changes[port], extents[port]) for port in changes}
        self.furthest = max(self.distance_of, key=self.distance_of.__getitem__)
        self.distances.append(self.distance_of[self.furthest])
        if self.extrapolation:
            self.extrapolation.end(participants)
        return self.distances[-1]

    def proceed(self, participants: Mapping) -> str:
        """Set the participants to the start of the next period; return a message, or ""."""
        if self.extrapolation is None:
            return ""
        before = self.extrapolation.taken_back
        message = self.extrapolation.proceed(participants)
        self.count -= self.extrapolation.taken_back - before
        return message

    def sentence(self) -> str:
        """Return a description of the last period."""
        before = "the previous period" if self.taken > 1 else "the start"
        text = (
            f"period {self.taken}: relative change {self.distances[-1]:.2g} since {before} "
            f"({'.'.join(self.furthest)}), tolerance {self.tolerance:g}"
        )
        if not self.is_periodic and self.no_nearer >= NO_NEARER:
            text += f"; no decrease for {self.no_nearer} periods, minimum {min(self.distances):.2g}"
        return text

    def verdict(self) -> str:
        """Return whether the last period repeats the previous one, and what to set if not."""
        if len(self.distances) > 1:
            change = f"{self.distances[-1]:.2g} (tolerance {self.tolerance:g})"
            text = f"the relative change between the last two of {self.taken} periods is {change}"
        else:
            text = f"the run has {self.taken or 'less than one'} period, the check needs two"
        if self.is_periodic:
            return text[0].upper() + text[1:]
        why = f". {self._why()}" if len(self.distances) > 1 else ""
        advice = (
            "Set a later time.stop"
            if self.ends
            else f"Set time.until_periodic = {self.tolerance:g}, and increase or remove time.stop"
        )
        return f"Not periodic: {text}{why}. {advice}"

    @property
    def no_nearer(self) -> int:
        """Number of periods since the one with the smallest change."""
        if not self.distances:
            return 0
        return len(self.distances) - 1 - self.distances.index(min(self.distances))

    def _why(self):
        """Return the quantities that do not repeat, and whether the change still decreases."""
        farthest = sorted(self.distance_of, key=self.distance_of.__getitem__, reverse=True)
        fields = ", ".join(
            f"{'.'.join(port)} {self.distance_of[port]:.2g}"
            for port in farthest[:MOST_LISTED]
            if self.distance_of[port] > self.tolerance
        )
        rest = sum(value > self.tolerance for value in self.distance_of.values()) - MOST_LISTED
        fields += f" and {rest} more" if rest > 0 else ""
        if self.no_nearer >= NO_NEARER:
            return f"The change no longer decreases: {fields}"
        return f"The change still decreases: {fields}"

    def summary(self) -> dict[str, object]:
        """Return the summary entries."""
        slow = self.extrapolation
        entries: dict[str, object] = {
            "periods": self.taken,
            "periodic": self.is_periodic,
            "settled": self.verdict(),
        }
        if self.distances:
            entries["period_distance"] = self.distances[-1]
            entries["period_distance_least"] = min(self.distances)
        if slow and slow.made:
            entries["extrapolated_periods"] = slow.made
            entries["taken_back_periods"] = slow.taken_back
        return entries


def distance(change: np.ndarray, extent: np.ndarray) -> float:
    """Return d of a field for its change and its range by cell, Eq. (Y2)."""
    whole = rms(extent)
    return rms(change) / whole if whole else 0.0  # Eq. (Y2)


def repetition(case, tree, system) -> Repetition | None:
    """Return the repetition of a case with a period, None for other cases.

    It compares all wires and the `repeats` of the contract's roles.

    Raises
    ------
    BadInput
        If the case ends once it is periodic, and there is nothing to compare.
    """
    time = case.time
    ends = time.until_periodic > 0.0
    if not system.period:
        return None
    compared: dict[Port, None] = {wire.source: None for wire in system.wires}
    for role, terms in contract().items():
        for name in players(tree, role):
            known = system.participants[name].fields
            compared |= {(name, one): None for one in terms.repeats if one in known}
    for port in turning(tree, system.participants):
        compared.pop(port_of(port), None)
    if not compared:
        if not ends:
            return None
        raise BadInput(
            "time.until_periodic: expected a wire of real numbers or a participant with a role, "
            "got neither"
        )
    storable = all(getattr(p, "can_serialise", False) for p in system.participants.values())
    slow = Extrapolation() if ends and storable else None
    tolerance = time.until_periodic or USUAL_TOLERANCE
    return Repetition(compared, tolerance, ends, slow)


def turning(tree, participants) -> list[str]:
    """Return the outputs "participant.name" that grow from period to period, by the contract."""
    return [
        f"{name}.{one}"
        for role, terms in contract().items()
        for name in players(tree, role)
        for one in terms.turning
        if one in participants[name].fields
    ]
