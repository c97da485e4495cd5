"""Computed figures beside what they should be: what each part's verification yields."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Literal, SupportsFloat


@dataclass(frozen=True)
class Check:
    """One figure, its reference and how far apart they may be.

    case, quantity : what is computed, with its unit in brackets;
    computed, reference : in that unit; no reference where the figure itself is an error or a count;
    tolerance : of the distance over the reference ("relative", [-]), of the distance ("absolute")
    or of the figure itself ("at most"), both in the quantity's unit;
    source : of the reference; reason : of the tolerance.
    """

    case: str
    quantity: str
    computed: SupportsFloat
    reference: SupportsFloat | None
    tolerance: float
    kind: Literal["relative", "absolute", "at most"]
    source: str
    reason: str

    @property
    def error(self) -> float:
        """What is held against the tolerance."""
        computed = float(self.computed)
        if self.reference is None:
            return computed
        reference = float(self.reference)
        scale = abs(reference) if self.kind == "relative" else 1.0
        return abs(computed - reference) / scale

    @property
    def passed(self) -> bool:
        """Whether the error is within the tolerance; one that is no number is not."""
        return self.error <= self.tolerance

    def __str__(self):
        return (
            f"{self.case}: {self.quantity}: {float(self.computed):.8g}, off by {self.error:.2g}, "
            f"allowed {self.tolerance:.2g} {self.kind}: {self.reason}"
        )


def at_most(
    case: str, quantity: str, computed: SupportsFloat, tolerance: float, source: str, reason: str
) -> Check:
    """Return the check of an error, a count or a cost, which is at most `tolerance`."""
    return Check(case, quantity, computed, None, tolerance, "at most", source, reason)


def compared(
    case: str,
    rows: Iterable[tuple[str, SupportsFloat, SupportsFloat, float]],
    source: str,
    reason: str,
    kind: Literal["relative", "absolute"] = "relative",
) -> Iterator[Check]:
    """Figures of one source; rows : quantity, computed value, reference and tolerance.

    A quantity without a unit is dimensionless.
    """
    for name, computed, reference, tolerance in rows:
        quantity = name if "[" in name else f"{name} [-]"
        yield Check(case, quantity, computed, reference, tolerance, kind, source, reason)


def ordered(
    case: str, what: str, order: SupportsFloat, tolerance: float, reason: str
) -> Iterator[Check]:
    """Observed order of a method of second order."""
    row = (f"observed order of the {what}", order, 2.0, tolerance)
    return compared(case, [row], "theory", reason, "absolute")


def conserved(
    case: str, quantity: str, imbalance: SupportsFloat, tolerance: float = 1e-12
) -> Check:
    """Imbalance of a quantity that is conserved to round-off."""
    return at_most(case, quantity, imbalance, tolerance, "conservation", "round-off")


def bounded(
    case: str, rows: Iterable[tuple[str, SupportsFloat, float]], source: str, reason: str
) -> Iterator[Check]:
    """Figures without a reference; rows : dimensionless quantity, computed value and tolerance."""
    for name, computed, tolerance in rows:
        yield at_most(case, f"{name} [-]", computed, tolerance, source, reason)
