"""Main results of a finished run in ten lines: film, forces, motion and oil.

Every value refers to the last period of the run. A line is omitted if the run lacks its outputs.
"""

from typing import NamedTuple

import numpy as np

from ..case.contract import contract, players
from ..case.schema import Case
from ..case.tables import reduced
from ..fmi.quantities import short, to_si
from ..results.file import Results
from ..results.instants import crank_angle
from ..results.judgement import mean_over
from .impacts import impacts
from .oil_balance import oil_balance
from .peaks import ABOVE, BESIDE, side_peaks
from .places import film_body, highest_position, thinnest_position


class Headline(NamedTuple):
    """Name of a result and its text."""

    name: str
    said: str


class Run(NamedTuple):
    """Run: case, results, and the names of film and bodies ("" if there is none)."""

    case: Case
    results: Results
    film: str
    bodies: str

    def values(self, port):
        """Return a scalar output over the macro steps, or None if the run lacks it."""
        return self.results.series(port).values if port in self.results.ports else None


def headlines(case, results) -> list[Headline]:
    """Return the lines of a run, none without a piston and its film.

    Parameters
    ----------
    case : Case
    results : Results
    """
    results = results.last
    films, bodies = (players(results.case, role) for role in ("lubrication", "bodies"))
    if not films or not bodies:
        return []
    runs = [Run(case, results, film, bodies[0]) for film in films]
    pistons = [Run(case, results, films[0], body) for body in bodies]
    lines = [
        *_of_each(runs, "minimum film", lambda run: _extreme_text(thinnest(run))),
        *_of_each(runs, "maximum pressure", lambda run: _extreme_text(highest(run))),
        *_of_each(runs, "pressure peak", _peaks),
        ("friction", _friction(runs[0])),
        *_of_each(runs, "asperity contact", _asperities),
        *_of_each(pistons, "side force", _side_force, "bodies"),
        *_of_each(pistons, "slap", _slap, "bodies"),
        *_of_each(pistons, "lateral motion", _lateral, "bodies"),
        *_of_each(pistons, "rocking angle", _rocking, "bodies"),
        *_of_each(runs, "oil", _oil),
    ]
    return [Headline(name, said) for name, said in lines if said]


def _of_each(runs, name, line, of="film"):
    """Return a line of each film or piston, with its participant's name if there are several."""
    alone = len(runs) == 1
    return [(name if alone else f"{name}, {getattr(run, of)}", line(run)) for run in runs]


def friction_power(results) -> np.ndarray | None:
    """Return the friction power of all films at each macro step [W], or None if a film lacks it."""
    ports = [f"{film}.friction_power" for film in players(results.case, "lubrication")]
    if not ports or not {*ports} <= {*results.ports}:
        return None
    return np.sum([results.series(port).values for port in ports], axis=0)


def _at(run, k):
    """Return row `k` as a crank angle, or as a time if the run has no crank angle."""
    crank = crank_angle(run.results)
    if crank is None:
        return f"at {short(run.results.time[k], 's')}"
    return f"at {np.degrees(crank.angle[k]):.4g} deg"


class Extreme(NamedTuple):
    """Extreme value in its SI unit, with its instant and position in words."""

    value: float
    unit: str
    where: str


def thinnest(run) -> Extreme | None:
    """Return the minimum film thickness, or None if the run lacks it."""
    return _extreme(run, "minimum_film_thickness", "m", np.argmin, thinnest_position)


def highest(run) -> Extreme | None:
    """Return the maximum pressure, or None if the run lacks it."""
    return _extreme(run, "maximum_pressure", "Pa", np.argmax, highest_position)


def _extreme(run, output, unit, row_of, position):
    values = run.values(f"{run.film}.{output}")
    if values is None:
        return None
    k = int(row_of(values))
    place = position(run.case, run.results, run.film)
    where = f", {place.brief}" if place else ""
    return Extreme(float(values[k]), unit, f"{_at(run, k)}{where}")


def _extreme_text(located):
    return f"{short(located.value, located.unit)} {located.where}" if located else ""


class Cycle(NamedTuple):
    """Friction mean effective pressure [Pa] of the period that ends at a crank angle [rad]."""

    end: float
    pressure: float


def friction_pressure(case, results) -> float | None:
    """Return the friction mean effective pressure [Pa] of the last period, Eq. (X12).

    Returns None if the run is shorter or lacks the outputs.
    """
    found = friction_pressures(case, results)
    return found[-1].pressure if found else None


def friction_pressures(case, results) -> list[Cycle]:
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
    found = []
    for k in reversed(range(count)):
        last, near = end - k * length, 1e-6 * length
        within = (time >= last - length - near) & (time <= last + near)
        volume = sum(np.pi * one.radius**2 * np.ptp(one.height[within]) for one in cylinders if one)
        # Eq. (X12)
        now = power[within]
        work = float((np.diff(time[within]) * (now[1:] + now[:-1]) / 2.0).sum())
        found.append(Cycle(float(crank.angle[within][-1]), work / volume))
    return found


class _Cylinder(NamedTuple):
    """Radius of a bore [m], and height of the pin over the macro steps [m]."""

    radius: float
    height: np.ndarray


def _cylinder(results, body):
    """Return the cylinder of participant `body`, or None if the run lacks its data."""
    films = players(results.case, "lubrication")
    own = [film for film in films if film_body(results, film) == body] or films
    given = results.case["participants"][own[0]].get("parameters", {}) if own else {}
    port = f"{body}.piston_position"
    if port not in results.ports or "bore_radius" not in given:
        return None
    return _Cylinder(to_si(given["bore_radius"], "m"), results.series(port).values)


def _friction(run):
    power = friction_power(run.results)
    if power is None:
        return ""
    said = f"mean {short(mean_over(run.results.time, power), 'W')}"
    pressure = friction_pressure(run.case, run.results)
    if pressure is None:
        return said
    begin, *_, end = np.degrees(run.results.crank_angle)
    return f"{said}, FMEP {short(pressure, 'Pa')} over {end - begin:.4g} deg"


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


def _peaks(run):
    port = f"{run.film}.pressure"
    bearing = f"{run.film}.friction_torque" in run.results.ports  # its load line rotates
    if bearing or port not in run.results.recorded:
        return ""
    axis = run.case.axes_of(port).first
    peaks = side_peaks(axis, run.results.dataset(port)[:])
    return "; ".join(
        f"{peak.distance:.0f} {axis.unit} from the {peak.side} line, {peak.excess:.0%} higher than "
        f"on it (at least {ABOVE:.0%} higher in {peak.share:.0%} of loaded instants)"
        if peak.distance >= BESIDE
        else f"on the {peak.side} line"
        for peak in peaks
    )


def _asperities(run):
    share = contact_share(run.results, run.film)
    area = run.values(f"{run.film}.contact_area_fraction")
    if share is None or area is None:
        return ""
    if not area.max() > 0.0:
        return "no contact"
    torque = run.values(f"{run.film}.friction_torque")
    what = "skirt" if torque is None else "bearing"
    return f"{share:.2%} of the friction work, on at most {area.max():.2%} of the {what}"


def _side_force(run):
    force = run.values(f"{run.bodies}.side_force")
    demand = run.values(f"{run.bodies}.side_force_demand")
    if force is None:
        return ""
    said = _sided(run, force)
    return said if demand is None else f"{said}; demand {_sided(run, demand)}"


def _sided(run, force):
    """Return the largest side force with its side and instant."""
    k = int(np.abs(force).argmax())
    side = "thrust" if force[k] >= 0.0 else "anti-thrust"
    return f"{short(abs(force[k]), 'N')} on the {side} side {_at(run, k)}"


def _slap(run):
    found = impacts(run.results, run.bodies)
    if not found:
        return ""
    worst = max(found, key=lambda impact: impact.loss)
    return (
        f"{short(worst.loss, 'J')} lost {_at(run, worst.row)}, {worst.edge} edge at "
        f"{short(abs(worst.velocity), 'm/s')} on the {worst.side} side{_edge_height(run, worst)}"
    )


def _edge_height(run, impact):
    """Return the height of the edge that strikes, in the coordinate of the maps."""
    axis = run.case.axes_of(f"{run.film}.pressure").second
    return f", {axis.label} {axis.range[impact.edge == 'upper']:.3g} {axis.unit}".rstrip()


def _lateral(run):
    return _range(run.values(f"{run.bodies}.lateral_displacement"), lambda x: short(x, "m"))


def _rocking(run):
    turn = run.values(f"{run.bodies}.rocking_angle")
    return _range(turn, lambda x: f"{np.degrees(x):.3g} deg")


def _range(values, as_text):
    return "" if values is None else f"{as_text(values.min())} to {as_text(values.max())}"


def _oil(run):
    balance = oil_balance(run.results, run.film)
    if balance is None:
        return ""
    ways = {"lower edge": balance.lower, "upper edge": balance.upper, "cut-outs": balance.openings}
    net = ", ".join(
        f"{1e9 * abs(volume):.3g} mm³ {'in' if volume > 0.0 else 'out'} through the {way}"
        for way, volume in ways.items()
        if volume
    )
    return f"net {net or '0 mm³'} per period; throughput {1e9 * balance.throughput:.3g} mm³"


MEASURES = {
    "minimum_film_thickness_m": "raise",
    "friction_mean_effective_pressure_pa": "lower",
    "slap_energy_j": "lower",
    "largest_rocking_angle_rad": "lower",
    "contact_share": "lower",
}
"""Measures of a design and where it wants them; each name ends with its unit."""


def directions(case: Case) -> dict[str, str]:
    """Return the measures and summary entries of a design -> "raise", "lower" or "none".

    The contract declares the directions of outputs. Outputs that it names as numerical errors are
    omitted.
    """
    declared = {name: way for role in contract().values() for name, way in role.directions.items()}
    errors = {name for role in contract().values() for name in role.numerical_errors}
    outputs = {entry: reduced(text).port.rpartition(".")[2] for entry, text in case.summary.items()}
    entries = {
        entry: declared.get(output, "none")
        for entry, output in outputs.items()
        if output not in errors
    }
    return MEASURES | entries


def measures(case, path) -> dict[str, float]:
    """Return the measures of a design over the last period of a results file.

    The names are those of `MEASURES`. Slap energy is the largest loss of the piston's own kinetic
    energy in an impact. The contact share is the fraction of the friction work. A measure is
    omitted if the run lacks its outputs.
    """
    with Results(path) as run:
        return _measured(case, run.last)


def _measured(case, results):
    """Return the measures of results of one period."""
    films, bodies = (players(results.case, role) for role in ("lubrication", "bodies"))

    def values(names, output):
        ports = [f"{name}.{output}" for name in names]
        return [results.series(port).values for port in ports if port in results.ports]

    thickness = values(films, "minimum_film_thickness")
    struck = [found for body in bodies if (found := impacts(results, body)) is not None]
    rocking = values(bodies[:1], "rocking_angle")
    found = {
        "minimum_film_thickness_m": min((one.min() for one in thickness), default=None),
        "friction_mean_effective_pressure_pa": friction_pressure(case, results),
        "slap_energy_j": max((one.loss for found in struck for one in found), default=0.0)
        if struck
        else None,
        "largest_rocking_angle_rad": max((np.abs(one).max() for one in rocking), default=None),
        "contact_share": contact_share(results, films[0]) if films else None,
    }
    return {name: float(value) for name, value in found.items() if value is not None}
