"""Uncertainty of a figure: its parts, the rule that combines them, and its text.

Eq. (X47):  u = sqrt(u_grid^2 + u_step^2 + u_modes^2 + u_period^2)

The parts have different causes and no common sign, so their squares add up. A part that is unknown
is missing, and the text names the largest known one.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import copysign, hypot

from ..results.words import handy_unit, scaled

DISPLAYED = {"1": (100.0, "%"), "m3": (1e9, "mm³"), "rad": (57.29577951308232, "deg")}
"""SI unit -> factor to the displayed unit, and its label."""
DIVERGES = "does not converge with the grid"
"""Reason of a missing uncertainty that is printed with the figure."""


@dataclass(frozen=True)
class Uncertainty:
    """Uncertainty of a figure.

    Parameters
    ----------
    value : float or None
        In the SI unit of the figure, None if it is unknown.
    contributor : str
        "grid", "step", "modes" or "period": the largest part.
    reason : str
        Why it is unknown.
    parts : mapping of str to float
        Parts by cause.
    signed : bool
        Whether the parts of grid and step are those of `run --uncertainty`, with their signs.
    """

    value: float | None = None
    contributor: str = ""
    reason: str = "the run has no data for an estimate"
    parts: Mapping[str, float] = field(default_factory=dict[str, float])
    signed: bool = False


UNKNOWN = Uncertainty()
EXACT = Uncertainty(0.0, "", "")
"""Uncertainty of contact and impacts that do not occur."""
LEAST_PART = 1.0 / 3.0
"""Smallest part of `run --uncertainty` over the estimate of the run alone, which is right within a
factor of about 3: a difference of two runs may vanish by chance."""
PART_PREFIX = "uncertainty_"
"""Beginning of the summary entries of the parts of uncertainties."""
CAUSES = ("grid", "step", "modes", "period")


def entry_of(cause: str, name: str) -> str:
    """Return the summary entry of a part of the uncertainty of a measure."""
    return f"{PART_PREFIX}{cause}_{name}"


def combined(parts: Mapping[str, float], signed: bool = False) -> Uncertainty:
    """Return the uncertainty of parts by cause, unknown without any part.

    >>> both = combined({"grid": 3.0, "step": -4.0})
    >>> both.value, both.contributor
    (5.0, 'step')
    """
    if not parts:
        return UNKNOWN
    largest = max(parts, key=lambda cause: abs(parts[cause]))
    return Uncertainty(hypot(*parts.values()), largest, "", dict(parts), signed)  # Eq. (X47)


def at_least(value: float, size: float) -> float:
    """Return a value with its sign and at least a size."""
    return copysign(max(abs(value), size), value)


def display_unit(unit: str, largest: float) -> tuple[float, str]:
    """Return the factor from an SI unit to one that suits a value, and the label of that unit.

    >>> display_unit("Pa", 3e6)
    (1e-06, 'MPa')
    """
    if unit in DISPLAYED:
        return DISPLAYED[unit]
    factor, label = scaled(1.0, unit, handy_unit(unit, largest))
    return float(factor), label
