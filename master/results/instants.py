"""Instants of a run, asked for as a time, as a crank angle, or by the extreme of an output."""

from typing import NamedTuple

import numpy as np

from ..case.contract import players
from ..case.tables import reduced
from ..fmi.errors import BadInput, unknown
from ..fmi.quantities import is_angle, short, to_si

CRANK_ANGLE = "crank_angle"
"""Output that the contract has of a participant in the role `bodies`."""
EXTREMES = {"min": np.argmin, "max": np.argmax}
"""Row of the smallest and the largest value; of equal ones the first."""


class CrankAngle(NamedTuple):
    """Crank angle over the macro steps, [rad] at [s], rising."""

    time: np.ndarray
    angle: np.ndarray


def crank_angle(results) -> CrankAngle | None:
    """Crank angle of a run, where a participant in the role `bodies` says it."""
    for name in players(results.case, "bodies"):
        port = f"{name}.{CRANK_ANGLE}"
        if port in results.ports:
            angle = results.series(port).values
            # the crank may swing about its start before it turns
            return CrankAngle(results.time, np.maximum.accumulate(angle))
    return None


def instant(results, text: str) -> float:
    """Time [s] of "18 ms" or of "648 deg", or of "max bodies.side_force", where a scalar output is
    largest in the last period, likewise smallest.

    A time or crank angle is one of those that the results show: with several periods it goes on
    over the first one, 24 deg after firing of the second being 744 deg. One before or after them
    is moved into the last period by whole periods.

    Parameters
    ----------
    results : Results
    text : str

    Raises
    ------
    BadInput
        If it is none of them, or one that the run does not come by or has not recorded.
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
        except ValueError:
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
    wanted = to_si(text, "rad")
    first, *_, last = crank.angle
    if not first - 1e-9 <= wanted <= last + 1e-9:
        wanted = _moved(wanted, results, crank.angle)
    if not first - 1e-9 <= wanted <= last + 1e-9:
        low, high = np.degrees([first, last])
        ends = f"{low:.6g} to {high:.6g} deg"
        raise BadInput(f"time: expected a crank angle of the run, {ends}, got {text!r}")
    return float(np.interp(wanted, crank.angle, crank.time))


def _moved(wanted, results, values):
    """A time or angle that takes these values, moved by whole periods to the last one; as it is if
    the run holds none.
    """
    if not results.period or np.ptp(results.last.time) < results.period * (1 - 1e-6):
        return wanted
    begin, *_, end = values[-len(results.last.time) :]
    return float(begin + (wanted - begin) % (end - begin))


def told(results, time: float) -> str:
    """An instant [s] in words: "18 ms, 648 deg"."""
    crank = crank_angle(results)
    shown = f"{time * 1e3:.6g} ms"
    if crank is None:
        return shown
    return f"{shown}, {np.degrees(np.interp(time, crank.time, crank.angle)):.6g} deg"
