"""Times of a run: start, stop and macro step, from times or crank angles."""

from math import floor
from typing import NamedTuple

from ..fmi.errors import BadInput
from ..fmi.quantities import quantity, to_si
from .schema import Case, Time

MOST_PERIODS = 20
"""Periods of a run with `until_periodic` and without `stop`."""


def record_interval(case: Case, speed: float | None) -> float:
    """Return the interval between records of the fields [s], 0 if it counts macro steps.

    `speed` is that of `times`.
    """
    every = case.record.every
    try:
        return 0.0 if isinstance(every, int) else _seconds(every, speed)
    except ValueError as error:
        raise BadInput(f"record.every: {error}") from None


class Clock(NamedTuple):
    """Start, latest stop, macro step, smallest one, period (0: unknown) and earliest stop [s]."""

    start: float
    stop: float
    step: float
    smallest_step: float
    period: float
    earliest: float


def times(case: Case, speed: float | None) -> Clock:
    """Return the times of the run; `speed` converts angles to times [rad/s]."""
    faults: list[str] = []
    values: dict[str, float] = {}
    texts = {key: getattr(case.time, key) for key in ("stop", "step", "smallest_step")}
    texts["period"] = case.period
    for key, text in texts.items():
        if text is None:
            continue
        try:
            values[key] = _seconds(text, speed)
            if key != "stop" and not values[key] > 0:
                faults.append(f"time.{key}: expected a positive value, got {text!r}")
        except ValueError as error:
            faults.append(f"time.{key}: {error}")
    if faults:
        raise BadInput(faults)
    begin, step, period = start_time(case, speed), values["step"], values.get("period", 0.0)
    if case.time.until_periodic and not period:
        raise BadInput("time.period: expected a time with time.until_periodic, got nothing")
    if fault := period and _whole_fault("time.period", case.period, None, period / step, case.time):
        if case.time.period or case.time.until_periodic:
            raise BadInput(str(fault))
        period = 0.0  # a default that is no multiple of the macro step
    stop = values.get("stop", begin + MOST_PERIODS * period)
    steps = (stop - begin) / step
    if fault := _whole_fault("time.stop", case.time.stop, case.time.start, steps, case.time):
        raise BadInput(fault)
    earliest = begin + 2 * period if case.time.until_periodic else stop
    smallest = values.get("smallest_step", step / 64)
    return Clock(
        start=begin,
        stop=stop,
        step=step,
        smallest_step=smallest,
        period=period,
        earliest=min(stop, earliest),
    )


def start_time(case: Case, speed: float | None) -> float:
    """Return the start of the run [s]; `speed` is that of `times`."""
    try:
        return 0.0 if case.time.start is None else _seconds(case.time.start, speed)
    except ValueError as error:
        raise BadInput(f"time.start: {error}") from None


def _seconds(text: str, speed: float | None) -> float:
    """Convert a time, or an angle at a speed [rad/s], to seconds."""
    if speed is None:
        return to_si(text, "s")
    if not speed:
        raise ValueError("expected an angular speed above 0 with crank angles, got 0 rad/s")
    return to_si(text, "rad") / speed


def _whole_fault(key: str, text: str | None, start: str | None, steps: float, time: Time) -> str:
    """Return the fault of a time that is no positive number of macro steps after `start`.

    The tolerance covers the round-off of two units.
    """
    whole = round(steps)
    if whole >= 1 and abs(steps - whole) <= 1e-9 * whole:
        return ""
    if steps < 1:
        return f"{key}: expected at least one step of {time.step}, got {text!r}"
    step = quantity(time.step)
    begin = quantity(start) if start else 0 * step
    nearest = [f"{begin + count * step:.10g~P}" for count in (floor(steps), floor(steps) + 1)]
    return (
        f"{key}: expected a multiple of time.step = {time.step}, got {text!r}; "
        f"the nearest are {nearest[0]} and {nearest[1]}"
    )
