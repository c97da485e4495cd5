"""Friction of all films of a run: power, mean effective pressure, and the share of contact."""

from typing import NamedTuple

import numpy as np

from ..case.contract import players
from ..results.instants import crank_angle
from .places import film_body, parameter


def friction_power(results) -> np.ndarray | None:
    """Return the friction power of all films at each macro step [W], or None if a film lacks it."""
    ports = [f"{film}.friction_power" for film in players(results.case, "lubrication")]
    if not ports or not {*ports} <= {*results.ports}:
        return None
    return np.sum([results.series(port).values for port in ports], axis=0)


class Cycle(NamedTuple):
    """Friction mean effective pressure [Pa] of the period that ends at a crank angle [rad]."""

    end: float
    pressure: float


def friction_pressure(results) -> float | None:
    """Return the friction mean effective pressure [Pa] of the last period, Eq. (X12).

    Returns None if the run is shorter or lacks the outputs.
    """
    cycles = friction_pressures(results)
    return cycles[-1].pressure if cycles else None


def friction_pressures(results) -> list[Cycle]:
    """Return the friction mean effective pressure of every whole period, counted from the end.

    The list is empty if the run is shorter or lacks the outputs.

    Eq. (X12):  FMEP = int P dt / V,   V = sum over cylinders of pi R^2 (max Y - min Y)
                P is the friction power of all films (trapezoidal rule), R the bore's radius, Y the
                pin's height
    """
    bodies = players(results.case, "bodies")
    power = friction_power(results)
    crank = crank_angle(results)
    cylinders = [_cylinder(results, body) for body in bodies]
    if power is None or crank is None or not bodies or None in cylinders:
        return []
    time, length = results.time, results.period
    begin, *_, end = time
    count = int((end - begin) / length + 1e-6) if length else 0
    cycles = []
    for k in reversed(range(count)):
        last, near = end - k * length, 1e-6 * length
        within = (time >= last - length - near) & (time <= last + near)
        volume = sum(np.pi * one.radius**2 * np.ptp(one.height[within]) for one in cylinders if one)
        # Eq. (X12)
        now = power[within]
        work = float((np.diff(time[within]) * (now[1:] + now[:-1]) / 2.0).sum())
        cycles.append(Cycle(float(crank.angle[within][-1]), work / volume))
    return cycles


class _Cylinder(NamedTuple):
    """Radius of a bore [m], and height of the pin over the macro steps [m]."""

    radius: float
    height: np.ndarray


def _cylinder(results, body):
    """Return the cylinder of participant `body`, or None if the run lacks its data."""
    films = players(results.case, "lubrication")
    own = [film for film in films if film_body(results, film) == body] or films
    radius = parameter(results, own[0], "bore_radius", "m") if own else 0.0
    port = f"{body}.piston_position"
    known = radius and port in results.ports
    return _Cylinder(radius, results.series(port).values) if known else None


def contact_share(results, film) -> float | None:
    """Return the contact fraction of the friction work of the last period, None if unknown.

    Eq. (X20):  (s_1 W_1 - s_0 W_0) / (W_1 - W_0),   W_i = sum of H_k P(t_k) from the start on
                s is the share since the start, P the friction power, 0 and 1 the period's ends
    """
    ports = f"{film}.boundary_friction_share", f"{film}.friction_power"
    if ports[0] not in results.ports:
        return None
    since = results.whole
    share = since.series(ports[0]).values
    if ports[1] not in results.ports:
        return float(share[-1])
    steps = np.diff(since.time) * since.series(ports[1]).values[1:]
    work = np.concatenate([[0.0], np.cumsum(steps)])
    first = len(share) - len(results.last.time)
    spent = work[-1] - work[first]
    # Eq. (X20)
    return float((share[-1] * work[-1] - share[first] * work[first]) / spent) if spent else 0.0
