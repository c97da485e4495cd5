"""Crank speed as a table over time or over crank angle, integrated exactly: however the steps fall,
the angle is the same.
"""

import numpy as np

from .tables import TableFault, closed, two_columns


def speed_table(rows, over, cycle, unit, speed_unit):
    """Table of crank speed, linear between its points.

    Parameters
    ----------
    rows : Rows
        Two columns: time or crank angle, and speed.
    over : str
        "time" or "angle".
    cycle : float
        Angle after which a table over angle repeats [rad].
    unit, speed_unit : float
        What 1 in the columns means [s] or [rad], [rad/s].

    Returns
    -------
    dict
        over, at [s] or [rad], speed [rad/s] (lists), and `passed`: the angle turned [rad] up to
        each point of a table over time, the time passed [s] up to each point of one over angle.

    Raises
    ------
    TableFault
        Where the first column does not rise, a speed is negative (over angle: not positive), or a
        table over angle does not close.
    """
    at, speed = two_columns(rows, over, "crank speed", unit, speed_unit)
    bad = np.flatnonzero(speed < 0.0 if over == "time" else speed <= 0.0)
    if len(bad):
        raise TableFault(
            f"{rows.places[bad[0]]}: crank speed {speed[bad[0]]:g} rad/s must "
            f"{'not be negative' if over == 'time' else 'be positive'}"
        )
    if over == "angle":
        at, speed = closed(rows, at, speed, cycle, "speed {:g} rad/s")
    mean = (speed[1:] + speed[:-1]) / 2
    passed = (
        np.diff(at) * mean
        if over == "time"
        else np.diff(at) / _logarithmic_mean(speed[:-1], speed[1:])
    )
    return {
        "over": over,
        "at": at.tolist(),
        "speed": speed.tolist(),
        "passed": np.append(0.0, np.cumsum(passed)).tolist(),
    }


def _logarithmic_mean(a, b):
    """(b - a)/ln(b/a), a where both are equal: the mean speed of a rise that is linear in angle."""
    rise = np.log(b / a)
    return np.where(np.abs(rise) < 1e-9, (a + b) / 2, (b - a) / np.where(rise == 0.0, 1.0, rise))


def crank_motion(table, angle, time, step):
    """Angle, speed and acceleration of the crank a step after it stood at an angle.

    Eq. (T1):  over time:   phi = phi_0 + S(t + h) - S(t),  S = S_i + w_i tau + k tau^2/2,  k = dw/dt in segment i; the outermost
                            speeds are held beyond the ends
    Eq. (T2):  over angle:  t_i to a point of segment i: tau = ln(1 + k (phi - phi_i)/w_i)/k,  k = dw/dphi;  back:
                            phi = phi_i + w_i (exp(k tau) - 1)/k,  w = w_i exp(k tau),  w' = k w

    Parameters
    ----------
    table : dict
        `speed_table`.
    angle, time, step : float
        At the start of the step [rad], [s]; [s].

    Returns
    -------
    angle, speed, acceleration : float
        [rad], [rad/s], [rad/s2]; where two segments meet the acceleration is that of the earlier
        one.
    """
    at, speed, passed = (np.asarray(table[key]) for key in ("at", "speed", "passed"))
    if table["over"] == "time":
        end, now, turn = _turned(at, speed, passed, time + step)
        return angle + end - _turned(at, speed, passed, time)[0], now, turn
    cycle = at[-1] - at[0]
    turns, ahead = divmod(angle - at[0], cycle)
    more, clock = divmod(_time_to(at, speed, passed, at[0] + ahead) + step, passed[-1])
    k = _segment(passed, clock)
    tau, slope = clock - passed[k], (speed[k + 1] - speed[k]) / (at[k + 1] - at[k])
    now = speed[k] * np.exp(slope * tau)
    climb = speed[k] * (np.expm1(slope * tau) / slope if slope else tau)  # Eq. (T2)
    return float(at[k] + climb + (turns + more) * cycle), float(now), float(slope * now)


def _time_to(at, speed, passed, angle):
    """Time from the table's first angle to another (Eq. (T2)) [s]."""
    k = _segment(at, angle)
    slope, ahead = (speed[k + 1] - speed[k]) / (at[k + 1] - at[k]), angle - at[k]
    return passed[k] + (np.log1p(slope * ahead / speed[k]) / slope if slope else ahead / speed[k])


def _turned(at, speed, passed, time):
    """Angle turned since the table's first time, speed and acceleration (Eq. (T1)) [rad, rad/s,
    rad/s2].
    """
    inside = np.clip(time, at[0], at[-1])
    k = _segment(at, inside)
    tau, slope = inside - at[k], (speed[k + 1] - speed[k]) / (at[k + 1] - at[k])
    now = speed[k] + slope * tau
    angle = passed[k] + tau * (speed[k] + now) / 2 + (time - inside) * now  # Eq. (T1)
    return float(angle), float(now), float(slope) if time == inside else 0.0


def _segment(points, value):
    """Number of the segment that holds a value, the earlier one where two meet."""
    return int(np.clip(np.searchsorted(points, value) - 1, 0, len(points) - 2))
