"""First screen of a report: one sentence, main results of all runs, conditions, films and checks.

Every value refers to the last period of a run.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..case.contract import players
from ..case.schema import Case
from ..fmi.quantities import short, to_si
from ..results.file import Results
from ..results.judgement import mean_over
from ..results.pictures import handy_unit, scaled
from .headlines import Run, contact_share, friction_power, friction_pressure, highest, thinnest
from .impacts import impacts
from .oil_balance import oil_balance

LEAST_CHANGE = 0.005
"""Relative change below which the sentence names no change."""


class Result(NamedTuple):
    """Result of one run: name, value, unit, and a note."""

    name: str
    value: float
    unit: str
    note: str = ""


class Comparison(NamedTuple):
    """Result of every run in one unit. A run that lacks it has None and an empty note."""

    name: str
    unit: str
    values: list[float | None]
    notes: list[str]

    def text(self, run: int) -> str:
        """Return the value of a run with three digits."""
        value = self.values[run]
        return "" if value is None else f"{value:.3g}"

    def change(self, run: int) -> str:
        """Return the relative difference of the first run from another one, in percent."""
        first, other = self.values[0], self.values[run]
        if first is None or not other:
            return ""
        return f"{100 * (first - other) / abs(other):+.0f} %".replace("-", "\N{MINUS SIGN}")

    def share(self, run: int) -> float:
        """Return the value of a run relative to the largest one, in percent."""
        largest = max(abs(value) for value in self.values if value is not None)
        return 100 * abs(self.values[run] or 0.0) / (largest or 1.0)


@dataclass(frozen=True)
class Overview:
    """First screen of the page.

    figures : minimum film thickness, maximum pressure and friction of all films; rows : further
    results; films : the figures of each film, worst film first, empty for one film.
    """

    sentence: str
    conditions: list[str]
    figures: list[Comparison]
    rows: list[Comparison]
    films: dict[str, list[Comparison]]


def overview(case: Case, runs: dict[str, Results]) -> Overview | None:
    """Return the first screen of runs, or None without a film."""
    first = next(iter(runs.values()))
    films = players(first.case, "lubrication")
    if not films:
        return None
    periods = [results.last for results in runs.values()]
    figures = _figures([list(_of_films(case, results, films)) for results in periods])
    rows = _figures([list(_of_motion(case, results, films)) for results in periods])
    own = {
        film: _figures([list(_of_films(case, results, [film])) for results in periods])
        for film in films
    }
    ordered = sorted(own, key=lambda film: _margin(first, film))
    return Overview(
        _sentence(list(runs), figures),
        conditions(first, films),
        figures,
        rows,
        {film: own[film] for film in ordered} if len(films) > 1 else {},
    )


def _figures(results: list[list[Result]]) -> list[Comparison]:
    """Return the results of all runs for comparison, in suitable units."""
    named = [{one.name: one for one in own} for own in results]
    found = []
    for name in dict.fromkeys(name for own in named for name in own):
        known = [own.get(name) for own in named]
        values = [one.value for one in known if one]
        unit = next(one.unit for one in known if one)
        wanted = "deg" if unit == "rad" else handy_unit(unit, float(np.abs(values).max()))
        factor, label = scaled(1.0, unit, wanted)
        shown = [float(one.value * factor) if one else None for one in known]
        found.append(Comparison(name, label, shown, [one.note if one else "" for one in known]))
    return found


def _of_films(case, results, films) -> Iterator[Result]:
    """Yield minimum film thickness, maximum pressure and friction of films."""
    runs = [Run(case, results, film, "") for film in films]
    for name, located, worst in (
        ("minimum film thickness", thinnest, min),
        ("maximum pressure", highest, max),
    ):
        known = [(one, run.film) for run in runs if (one := located(run))]
        if known:
            one, film = worst(known, key=lambda pair: pair[0].value)
            named = f", {film}" if len(films) > 1 else ""
            yield Result(name, one.value, one.unit, f"{one.where}{named}")
    if len(films) == 1:
        power = runs[0].values(f"{films[0]}.friction_power")
    else:
        power = friction_power(results)
    if power is None or len(results.time) < 2:
        return
    notes = []
    pressure = friction_pressure(case, results)
    if pressure is not None and len(films) == len(players(results.case, "lubrication")):
        notes.append(f"FMEP {short(pressure, 'Pa')}")
    share = contact_share(results, films[0]) if len(films) == 1 else None
    if share is not None:
        notes.append(f"{_percent(share):.2g} % by asperity contact")
    yield Result("mean friction power", mean_over(results.time, power), "W", ", ".join(notes))


def _of_motion(case, results, films) -> Iterator[Result]:
    """Yield FMEP, side force, impacts and motion. For one film, yield contact and oil."""
    pressure = friction_pressure(case, results)
    if pressure is not None:
        yield Result("friction mean effective pressure", pressure, "Pa")
    bodies = players(results.case, "bodies")
    for body in bodies:
        run = Run(case, results, films[0], body)
        of = f", {body}" if len(bodies) > 1 else ""
        force = run.values(f"{body}.side_force")
        if force is not None:
            yield Result(f"maximum side force{of}", float(np.abs(force).max()), "N")
        if struck := impacts(results, body):
            worst = max(struck, key=lambda impact: impact.loss)
            yield Result(f"energy lost in the hardest impact{of}", worst.loss, "J")
        for port, name, unit in (
            ("lateral_displacement", "range of lateral displacement", "m"),
            ("rocking_angle", "range of rocking angle", "rad"),
        ):
            values = run.values(f"{body}.{port}")
            if values is not None:
                yield Result(f"{name}{of}", float(np.ptp(values)), unit)
    if len(films) > 1:
        return
    share = contact_share(results, films[0])
    if share is not None:
        yield Result("friction work by asperity contact", _percent(share), "%")
    if balance := oil_balance(results, films[0]):
        yield Result("oil throughput per period", 1e9 * balance.throughput, "mm³")


def _percent(share):
    """Return a share in percent; less than a millionth is 0."""
    return 100 * share if share > 1e-6 else 0.0


def _margin(results, film):
    """Return film thickness over roughness of a film, or the thickness in µm if it is smooth."""
    port = f"{film}.minimum_film_thickness"
    if port not in results.ports:
        return np.inf
    given = results.case["participants"][film].get("parameters", {})
    rough = to_si(given.get("roughness_rms", "0 m"), "m")
    return results.last.series(port).values.min() / (rough or 1e-6)


def conditions(results: Results, films: list[str]) -> list[str]:
    """Return speed, bore, clearance, oil, grid, modes and period of a run."""
    participants = results.case["participants"]
    bodies = players(results.case, "bodies")
    film = participants[films[0]]
    given = film.get("parameters", {})
    body = participants[bodies[0]] if bodies else {}
    own, build = body.get("parameters", {}), body.get("build", {})
    found = []
    if "crank_speed" in own:
        found.append(str(own["crank_speed"]))
    if "bore_radius" in given:
        found.append(f"bore {2e3 * to_si(given['bore_radius'], 'm'):.4g} mm")
    if "radial_clearance" in own:
        found.append(_clearances(results, bodies[0], to_si(own["radial_clearance"], "m")))
    if "oil" in film.get("build", {}):
        found.append(f"oil {film['build']['oil']}")
    elif "viscosity" in given:
        found.append(f"oil {1e3 * to_si(given['viscosity'], 'Pa.s'):.3g} mPa s")
    if "grid" in film.get("build", {}):
        found.append("{} × {} cells".format(*film["build"]["grid"]))
    modes = [build[name].get("modes") for name in ("piston", "block") if name in build]
    if any(modes):
        found.append(f"{' + '.join(str(count or 0) for count in modes)} modes")
    hot = [
        surface
        for name, surface in (("piston", "skirt"), ("block", "bore"))
        if {"hot_shape", "temperature_field"} & {*build.get(name, {})}
    ]
    if hot:
        found.append(f"hot shape of {' and '.join(hot)}")
    summary = results.summary or {}
    if summary.get("periods", 0) > 1:
        found.append(f"last of {summary['periods']} periods")
    return found


def _clearances(results: Results, body: str, cold: float) -> str:
    """Return the radial clearance, and that between walls of the last levels of temperature."""
    port = f"{body}.thermal_opening"
    opening = results.series(port).values[-1] if port in results.ports else 0.0
    text = f"radial clearance {short(cold, 'm')}"
    return f"{text} cold, {short(cold + opening, 'm')} hot" if opening else text


def _sentence(labels, figures) -> str:
    """Return the main results as one sentence: of the first run, compared with the second."""
    known = [one for one in figures if one.values[0] is not None]
    if not known:
        return ""
    if len(labels) < 2 or any(one.values[1] is None for one in known):
        said = _listed([f"the {one.name} is {one.text(0)} {one.unit}" for one in known])
        return f"{said[0].upper()}{said[1:]}."
    changes = [_change(one) for one in known]
    grouped = [
        f"{verb} {_listed([what for other, what in changes if other == verb])}"
        for verb in dict.fromkeys(verb for verb, _ in changes)
    ]
    return f"{labels[0][0].upper()}{labels[0][1:]} instead of {labels[1]} {_listed(grouped)}."


def _listed(texts) -> str:
    """Return texts joined by commas, the last one by "and"."""
    *most, last = texts
    return f"{', '.join(most)} and {last}" if most else last


def _change(figure) -> tuple[str, str]:
    """Return verb and object of the change of a result from the second run to the first one."""
    new, old = figure.values[:2]
    share = abs(new - old) / abs(old) if old else np.inf
    if share < LEAST_CHANGE:
        return "keeps", f"the {figure.name} at {figure.text(0)} {figure.unit}"
    verb = "raises" if new > old else "lowers"
    if figure.name == "minimum film thickness" or not old:
        return verb, f"the {figure.name} from {figure.text(1)} to {figure.text(0)} {figure.unit}"
    return verb, f"the {figure.name} by {100 * share:.0f} %"
