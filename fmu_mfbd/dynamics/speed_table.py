"""Crank speed as a table over time or over crank angle, integrated exactly.

The angle does not depend on the steps.
"""

from typing import Annotated, Literal, NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable
from ..mechanism.slider_crank import CrankMotion
from .tables import Column, Rows, TableFault, closed, two_columns


class SpeedTable(NamedTuple):
    """Crank speed, linear between its points; empty if there is none.

    Parameters
    ----------
    over_angle : bool
        Whether `at` is the crank angle, not the time.
    at : ndarray, shape (n,)
        Time [s] or crank angle [rad], rising.
    speed : ndarray, shape (n,)
        [rad/s]
    passed : ndarray, shape (n,)
        The angle turned [rad] up to each point of a table over time, the time passed [s] up to each
        point of one over angle.
    """

    over_angle: bool
    at: Annotated[np.ndarray, "points"]
    speed: Annotated[np.ndarray, "points"]
    passed: Annotated[np.ndarray, "points"]


def speed_table(
    rows: Rows, over: Literal["time", "angle"], cycle: float, unit: float, speed_unit: float
) -> SpeedTable:
    """Return the table of crank speed over time or crank angle.

    Parameters
    ----------
    rows : Rows
    over : {"time", "angle"}
    cycle : float
        Angle after which a table over angle repeats [rad].
    unit, speed_unit : float
        Size of 1 in the columns: [s] or [rad], and [rad/s].

    Returns
    -------
    SpeedTable

    Raises
    ------
    TableFault
        Where the first column does not rise, a speed is negative (over angle: not positive), a
        table over angle does not close, or one over time has one row.
    """
    at, speed = two_columns(rows, Column(over, unit), Column("crank speed", speed_unit))
    bad = np.flatnonzero(speed < 0.0 if over == "time" else speed <= 0.0)
    if len(bad):
        raise TableFault(
            f"{rows.row_names[bad[0]]}: expected a crank speed "
            f"{'of at least' if over == 'time' else 'above'} 0 rad/s, got {speed[bad[0]]:g} rad/s"
        )
    if over == "angle":
        at, speed = closed(rows, at, speed, cycle, "speed {:g} rad/s")
        segments = np.diff(at) / _logarithmic_mean(speed[:-1], speed[1:])
    elif len(at) < 2:
        raise TableFault(f"{rows.row_names[0]}: expected at least two rows over time, got one")
    else:
        segments = np.diff(at) * ((speed[1:] + speed[:-1]) / 2)
    return SpeedTable(over == "angle", at, speed, np.append(0.0, np.cumsum(segments)))


def _logarithmic_mean(a, b):
    """Return (b - a)/ln(b/a), the mean speed of a rise that is linear in angle."""
    rise = np.log(b / a)
    return np.where(np.abs(rise) < 1e-9, (a + b) / 2, (b - a) / np.where(rise == 0.0, 1.0, rise))


@compilable
def crank_motion(table: SpeedTable, angle: float, time: float, step: float) -> CrankMotion:
    """Return the motion of the crank a step after an angle.

    Eq. (I3):  over time:   phi = phi_0 + S(t + h) - S(t),  S = S_i + w_i tau + k tau^2/2,
                            k = dw/dt in segment i; the outermost speeds continue beyond the ends
    Eq. (I4):  over angle:  t_i to a point of segment i: tau = ln(1 + k (phi - phi_i)/w_i)/k,
                            k = dw/dphi;  back: phi = phi_i + w_i (exp(k tau) - 1)/k,
                            w = w_i exp(k tau),  w' = k w

    Parameters
    ----------
    table : SpeedTable
    angle, time, step : float
        At the start of the step [rad], [s]; [s].

    Returns
    -------
    CrankMotion
        Where two segments meet the acceleration is that of the earlier one.
    """
    if not table.over_angle:
        begin = turned(table, time)
        end = turned(table, time + step)
        return CrankMotion(angle + end.angle - begin.angle, end.speed, end.acceleration)  # Eq. (I3)
    cycle = table.at[-1] - table.at[0]
    turns, ahead = divmod(angle - table.at[0], cycle)
    clock = time_to(table, table.at[0] + ahead) + step
    more_turns, clock = divmod(clock, table.passed[-1])
    k = segment(table.passed, clock)
    slope = slope_of(table, k)
    tau = clock - table.passed[k]
    # Eq. (I4)
    speed = table.speed[k] * np.exp(slope * tau)
    climb = table.speed[k] * (np.expm1(slope * tau) / slope if slope != 0.0 else tau)
    end_angle = table.at[k] + climb + (turns + more_turns) * cycle
    return CrankMotion(float(end_angle), float(speed), float(slope * speed))


@compilable
def time_to(table: SpeedTable, angle: float) -> float:
    """Return the time from the table's first angle to another (Eq. (I4)) [s]."""
    k = segment(table.at, angle)
    slope = slope_of(table, k)
    ahead = angle - table.at[k]
    speed = table.speed[k]
    straight = ahead / speed
    took = np.log1p(slope * straight) / slope if slope != 0.0 else straight
    return float(table.passed[k] + took)


@compilable
def turned(table: SpeedTable, time: float) -> CrankMotion:
    """Return the motion since the table's first time (Eq. (I3))."""
    inside = min(max(time, table.at[0]), table.at[-1])
    k = segment(table.at, inside)
    slope = slope_of(table, k)
    tau = inside - table.at[k]
    speed = table.speed[k] + slope * tau
    # Eq. (I3)
    angle = table.passed[k] + tau * (table.speed[k] + speed) / 2 + (time - inside) * speed
    return CrankMotion(float(angle), float(speed), float(slope) if time == inside else 0.0)


@compilable
def slope_of(table: SpeedTable, k: int) -> float:
    """Return the slope of the speed in segment k."""
    return (table.speed[k + 1] - table.speed[k]) / (table.at[k + 1] - table.at[k])


@compilable
def segment(points: np.ndarray, value: float) -> int:
    """Return the number of the segment that contains a value, the earlier one at a common point."""
    return min(max(int(np.searchsorted(points, value)) - 1, 0), len(points) - 2)
