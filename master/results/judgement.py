"""Numbers from a results file: values with their expected ranges, and work of loops."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..case.tables import reduced
from ..coupling.wiring import port_of
from ..fmi.errors import BadInput
from ..fmi.quantities import pint_unit, registry, to_si


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


def angular_speed(case):
    """Return the angular speed that converts angles to times [rad/s], None if there is none."""
    if case.time.angular_speed is None:
        return None
    owner, name = port_of(case.time.angular_speed)
    return to_si(case.participants[owner].parameters[name], "rad/s")


def last_period(case, results, period):
    """Return the mask of the rows in the last `period`, which is a time or an angle as text."""
    speed = angular_speed(case)
    try:
        length = to_si(period, "s") if speed is None else to_si(period, "rad") / speed
    except ValueError as error:
        raise BadInput(f"period: {error}") from None
    return results.time >= results.time[-1] - length * (1 + 1e-9)


class LoopCurve(NamedTuple):
    """x and summed y of a loop, with their SI units."""

    x: np.ndarray
    x_unit: str
    y: np.ndarray
    y_unit: str


def loop_curve(case, results, loop):
    """Return the loop over its last period."""
    mask = last_period(case, results, loop.period)
    x, x_unit, _ = results.series(loop.x)
    columns = [results.series(port) for port in loop.y]
    y = np.sum([column.values for column in columns], axis=0)
    return LoopCurve(x[mask], x_unit, y[mask], columns[0].unit)


def loop_work(case, results, loop):
    """Return the work of a loop, in its unit.

    Eq. (X4):  W = |closed integral of y dx|  by the trapezoidal rule between recorded steps, second
               order in the step
    """
    x, x_unit, y, y_unit = loop_curve(case, results, loop)
    # Eq. (X4)
    work = abs(float(np.sum(0.5 * (y[1:] + y[:-1]) * np.diff(x))))
    quantity = registry().Quantity(work, f"{pint_unit(y_unit)} * {pint_unit(x_unit)}")
    return float(quantity.to(loop.unit).magnitude)
