"""Numbers from a results file: values with their expected ranges."""

from dataclasses import dataclass

import numpy as np

from ..case.tables import reduced
from ..fmi.quantities import to_si


def mean_over(time: np.ndarray, values: np.ndarray) -> float:
    """Return the mean over time, weighted by step lengths: Eq. (Z8)."""
    return float(np.diff(time) @ values[1:] / (time[-1] - time[0]))


REDUCTIONS = {
    "min": lambda time, values: values.min(),
    "max": lambda time, values: values.max(),
    "mean": mean_over,
    "last": lambda time, values: values[-1],
}


@dataclass(frozen=True)
class Window:
    """A value and its expected range, in SI; the range includes its ends."""

    name: str
    unit: str
    value: float
    low: float
    high: float

    @property
    def inside(self) -> bool:
        return self.low <= self.value <= self.high


def windows(case, results) -> list[Window]:
    """Return every entry of the case's window, for the last period."""
    results = results.last
    judged = []
    for text, limits in case.window.items():
        kind, port = reduced(text)
        values, unit, _ = results.series(port)
        low, high = (to_si(limit, unit) for limit in limits)
        judged.append(Window(text, unit, float(REDUCTIONS[kind](results.time, values)), low, high))
    return judged
