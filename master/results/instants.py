"""Instants of a run: from a time, a crank angle, or the extreme of an output."""

from typing import NamedTuple

import numpy as np

from ..case.contract import players
from ..case.tables import reduced
from ..fmi.errors import BadInput, unknown
from ..fmi.quantities import is_angle, short, to_si

CRANK_ANGLE = "crank_angle"
"""Crank angle output of the role `bodies` in the contract."""
EXTREMES = {"min": np.argmin, "max": np.argmax}
"""Functions that return the row of the smallest or the largest value, the first of equal ones."""


class CrankAngle(NamedTuple):
    """Crank angle over the macro steps, [rad] at [s], rising."""

    time: np.ndarray
    angle: np.ndarray


def crank_angle(results) -> CrankAngle | None:
    """Return the crank angle of a run, None if no participant with the role `bodies` has it."""
    for name in players(results.case, "bodies"):
        port = f"{name}.{CRANK_ANGLE}"
        if port in results.ports:
            angle = results.series(port).values
            # the crank may oscillate about its start before it turns
            return CrankAngle(results.time, np.maximum.accumulate(angle))
    return None


def length_text(results) -> str:
    """Return the length of the times shown: crank angle, or time without one."""
    crank = crank_angle(results)
    if crank is None:
        return short(results.time[-1] - results.time[0], "s")
    return f"{np.degrees(crank.angle[-1] - crank.angle[0]):.4g} deg"


def instant(results, text: str) -> float:
    """Return the time [s] of "18 ms", "648 deg", or "max bodies.side_force".

    The latter is where a scalar output is largest (min: smallest) in the last period. Times and
    crank angles are those that the results show: they continue over several periods, so 24 deg
    after firing of the second one is 744 deg. Values outside are moved into the last period by
    whole periods.

    Parameters
    ----------
    results : Results
    text : str

    Raises
    ------
    BadInput
        If it is none of them, or if the run does not reach it or has not recorded it.
    """
    kind, port = reduced(text)
    if kind in EXTREMES:
        if port not in results.ports:
            raise BadInput(f"time: {unknown('variable', port, results.ports)}")
        last = results.last
        return float(last.time[EXTREMES[kind](last.series(port).values)])
    if not is_angle(text):
        try:
            time = to_si(text, "s")
        except ValueError as error:
            if "," in text:
                raise BadInput(f"time: {error}") from None
            raise BadInput(
                f"time: expected a time, a crank angle or min|max participant.variable, "
                f"got {text!r}; write for example '24 deg'"
            ) from None
        begin, *_, end = results.time
        if not begin - 1e-9 * end <= time <= end * (1 + 1e-9):
            time = _moved(time, results, results.time)
        if not begin - 1e-9 * end <= time <= end * (1 + 1e-9):
            ends = f"{short(begin, 's')} to {short(end, 's')}"
            raise BadInput(f"time: expected a time of the run, {ends}, got {text!r}")
        return time
    crank = crank_angle(results)
    if crank is None:
        raise BadInput(f"time: expected a time such as '18 ms', got {text!r} without crank angles")
    angle = to_si(text, "rad")
    first, *_, last = crank.angle
    if not first - 1e-9 <= angle <= last + 1e-9:
        angle = _moved(angle, results, crank.angle)
    if not first - 1e-9 <= angle <= last + 1e-9:
        low, high = np.degrees([first, last])
        ends = f"{low:.6g} to {high:.6g} deg"
        raise BadInput(f"time: expected a crank angle of the run, {ends}, got {text!r}")
    return float(np.interp(angle, crank.angle, crank.time))


def _moved(wanted, results, values):
    """Move a time or angle by whole periods into the last one.

    Returns it unchanged if the run has no whole period.
    """
    if not results.period or np.ptp(results.last.time) < results.period * (1 - 1e-6):
        return wanted
    begin, *_, end = values[-len(results.last.time) :]
    return float(begin + (wanted - begin) % (end - begin))


def instant_text(results, time: float) -> str:
    """Return an instant [s] as text: "18 ms, 648 deg"."""
    crank = crank_angle(results)
    shown = f"{time * 1e3:.6g} ms"
    if crank is None:
        return shown
    angle = np.degrees(np.interp(time, crank.time, crank.angle))
    return f"{shown}, {round(angle, 6):z.6g} deg"
