"""First screen of a report: one sentence, main results of all runs, conditions, films and checks.

Every value refers to the last period of a run.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..case.contract import players
from ..fmi.quantities import short, to_si
from ..results.file import Results
from .comparison import NOT_DISTINGUISHABLE, difference, differing, grids, listed
from .measures import NO_IMPACT, Measure, Measures, value_text, without_trace
from .uncertainty import display_unit

LEAST_CHANGE = 0.005
"""Relative change below which the sentence names no change."""


class Comparison(NamedTuple):
    """Result of every run in one unit. A run that lacks it has None and an empty note.

    spreads : uncertainty of every run, None if it is unknown; clear : whether the difference of the
    first run from each run is larger than its uncertainty, or the uncertainty is unknown;
    computed : whether all uncertainties come from `run --uncertainty`.
    """

    name: str
    unit: str
    values: list[float | None]
    notes: list[str]
    spreads: list[float | None]
    clear: list[bool]
    computed: bool

    def number(self, run: int) -> str:
        """Return the value of a run with three digits."""
        value = self.values[run]
        return "" if value is None else f"{value:.3g}"

    def text(self, run: int) -> str:
        """Return the value of a run with three digits and its uncertainty with two."""
        spread = self.spreads[run]
        return f"{self.number(run)} +- {spread:.2g}" if spread else self.number(run)

    def change(self, run: int) -> str:
        """Return the relative difference of the first run from another one, in percent."""
        first, other = self.values[0], self.values[run]
        if first is None or not other:
            return ""
        change = f"{100 * (first - other) / abs(other):+.0f} %".replace("-", "\N{MINUS SIGN}")
        return change if self.clear[run] else f"{change}, {NOT_DISTINGUISHABLE}"

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


def overview(runs: dict[str, Results], tables: dict[str, Measures]) -> Overview | None:
    """Return the first screen of runs and their measures, or None without a film."""
    first = next(iter(runs.values()))
    films = next(iter(tables.values())).films
    if not films:
        return None

    steps = [grids(results.case) for results in runs.values()]
    alike = [one == steps[0] for one in steps]

    def compared(results):
        return _figures([list(results(table)) for table in tables.values()], alike)

    figures = compared(lambda table: _of_films(table, films))
    own = {film: compared(lambda table, film=film: _of_films(table, [film])) for film in films}
    ordered = sorted(own, key=lambda film: _margin(first, next(iter(tables.values())), film))
    return Overview(
        _sentence(_names(runs), figures),
        conditions(first, films),
        figures,
        compared(_of_motion),
        {film: own[film] for film in ordered} if len(films) > 1 else {},
    )


def _names(runs: dict[str, Results]) -> list[str]:
    """Return the names of two runs: what differs in their cases, if these have one label."""
    trees = [results.case for results in runs.values()]
    names = list(runs)
    if len(runs) != 2 or trees[0].get("label") != trees[1].get("label"):
        return names
    return list(differing(trees[0], trees[1], names))


def _figures(results: list[list[Measure]], alike: list[bool]) -> list[Comparison]:
    """Return the measures of all runs for comparison, in suitable units."""
    named = [{one.label: one for one in own} for own in results]
    found = []
    for name in dict.fromkeys(name for own in named for name in own):
        known = [own.get(name) for own in named]
        values = [one.value for one in known if one]
        unit = next(one.unit for one in known if one)
        factor, label = display_unit(unit, max(map(abs, values)))
        shown = [one.value * factor if one else None for one in known]
        spreads = [one.uncertainty.value if one else None for one in known]
        scaled = [spread and spread * factor for spread in spreads]
        first = known[0]
        clear = [
            not (first and one) or difference(first, one, same).text != NOT_DISTINGUISHABLE
            for one, same in zip(known, alike)
        ]
        notes = [one.note if one else "" for one in known]
        computed = all(one is not None and one.uncertainty.signed for one in known)
        found.append(Comparison(name, label, shown, notes, scaled, clear, computed))
    return found


def _of_films(table, films) -> Iterator[Measure]:
    """Yield minimum film thickness, maximum pressure and friction of films."""
    for key in ("minimum_film_thickness_m", "maximum_pressure_pa"):
        if worst := table.worst(key, films):
            named = f", {worst.owner}" if len(films) > 1 else ""
            yield replace(worst, note=f"{worst.note}{named}")
    alone = len(films) == 1
    power = table.of("mean_friction_power_w", films[0] if alone else "")
    if power is None:
        return
    pressure = table.of("friction_mean_effective_pressure_pa") if films == table.films else None
    share = table.of("contact_share", films[0]) if alone else None
    notes = [f"FMEP {value_text(pressure.value, 'Pa')}"] if pressure else []
    if share:
        notes.append(f"{100 * without_trace(share.value):.2g} % by asperity contact")
    yield replace(power, note=", ".join(notes))


def _of_motion(table) -> Iterator[Measure]:
    """Yield FMEP, side force, impacts and motion. For one film, yield contact and oil."""
    if pressure := table.of("friction_mean_effective_pressure_pa"):
        yield replace(pressure, note="")
    keys = ("side_force_n", "slap_energy_j", "range_lateral_displacement_m")
    for body in table.bodies:
        named = f", {body}" if len(table.bodies) > 1 else ""
        for key in (*keys, "range_rocking_angle_rad"):
            one = table.of(key, body)
            if one and one.shown != NO_IMPACT:
                yield replace(one, label=f"{one.label}{named}", note="")
    if len(table.films) == 1:
        share = table.of("contact_share", table.films[0])
        if share:
            yield replace(share, value=without_trace(share.value), note="")
        if through := table.of("oil_throughput_m3", table.films[0]):
            yield through


def _margin(results, table, film):
    """Return film thickness over roughness of a film, or the thickness in µm if it is smooth."""
    thinnest = table.of("minimum_film_thickness_m", film)
    if thinnest is None:
        return np.inf
    given = results.case["participants"][film].get("parameters", {})
    rough = to_si(given.get("roughness_rms", "0 m"), "m")
    return thinnest.value / (rough or 1e-6)


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
        said = listed([f"the {one.name} is {one.number(0)} {one.unit}" for one in known])
        return f"{said[0].upper()}{said[1:]}."
    changes = [_change(one) for one in known]
    grouped = [
        f"{verb} {listed([what for other, what in changes if other == verb])}"
        for verb in dict.fromkeys(verb for verb, _ in changes)
    ]
    begin = labels[0] if "." in labels[0] else f"{labels[0][0].upper()}{labels[0][1:]}"
    return f"{begin} instead of {labels[1]} {listed(grouped)}."


def _change(figure) -> tuple[str, str]:
    """Return verb and object of the change of a result from the second run to the first one."""
    new, old = figure.values[:2]
    share = abs(new - old) / abs(old) if old else np.inf
    if share < LEAST_CHANGE:
        return "keeps", f"the {figure.name} at {figure.number(0)} {figure.unit}"
    if not figure.clear[1] and figure.computed:
        return "does not clearly change", f"the {figure.name}"
    verb = "raises" if new > old else "lowers"
    if figure.name == "minimum film thickness" or not old:
        return (
            verb,
            f"the {figure.name} from {figure.number(1)} to {figure.number(0)} {figure.unit}",
        )
    return verb, f"the {figure.name} by {100 * share:.0f} %"
