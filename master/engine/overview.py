"""First screen of a report: one sentence, main results of all runs, conditions, films and checks.

Every value refers to the last period of a run.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from ..case.contract import players
from ..fmi.quantities import short, to_si
from ..results.file import Results
from .comparison import (
    NOT_DISTINGUISHABLE,
    changes,
    difference,
    differing,
    have_equal_grids,
    listed,
    unequal_lengths,
)
from .measures import NO_IMPACT, Measure, Measures
from .places import parameter
from .uncertainty import DIVERGES, display_unit

MOST_PERCENT = 10.0
"""Relative difference above which the ratio is displayed instead."""
MOTION = ["side_force_n", "slap_energy_j"]
MOTION += ["range_lateral_displacement_m", "range_rocking_angle_rad"]
"""Keys of the measures of bodies that the page compares."""
SURFACES = {"piston": "skirt", "block": "bore"}


@dataclass(frozen=True)
class Comparison:
    """Measure of every run in one unit, None for a run that lacks it.

    alike : whether a run has the grids and steps of the first one.
    """

    cells: list[Measure | None]
    alike: list[bool]

    @cached_property
    def known(self) -> list[Measure]:
        """Measures of the runs that have it."""
        return [one for one in self.cells if one]

    @property
    def name(self) -> str:
        """Name of the measure."""
        return self.known[0].label

    @cached_property
    def scale(self) -> tuple[float, str]:
        """Factor from SI to the unit of the values, and its label."""
        return display_unit(self.known[0].unit, max(abs(one.value) for one in self.known))

    def text(self, run: int) -> str:
        """Return the value of a run with its uncertainty."""
        one = self.cells[run]
        return one.number(self.scale[0]) if one else ""

    def note(self, run: int) -> str:
        """Return the note of a run, "" if it has none."""
        one = self.cells[run]
        diverges = one and one.uncertainty.reason == DIVERGES
        return ", ".join(filter(None, [one.note, DIVERGES if diverges else ""])) if one else ""

    def change(self, run: int) -> str:
        """Return the relative difference of the first run from another one, and what limits it."""
        first, other = self.cells[0], self.cells[run]
        if not (first and other and other.value):
            return ""
        share = (first.value - other.value) / abs(other.value)
        change = f"{100 * share:+.0f} %".replace("-", "\N{MINUS SIGN}")
        if share > MOST_PERCENT:
            change = f"{first.value / other.value:.3g} times"
        text = difference(first, other, self.alike[run]).text
        return f"{change}, {text}" if text in (NOT_DISTINGUISHABLE, DIVERGES) else change

    def share(self, run: int) -> float:
        """Return the value of a run relative to the largest one, in percent."""
        one, largest = self.cells[run], max(abs(one.value) for one in self.known)
        return 100 * abs(one.value) / (largest or 1.0) if one else 0.0


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

    alike = [have_equal_grids(first.case, results.case) for results in runs.values()]

    def rows(choose) -> list[Comparison]:
        named = [{one.label: one for one in choose(table)} for table in tables.values()]
        labels = dict.fromkeys(label for own in named for label in own)
        return [Comparison([own.get(label) for own in named], alike) for label in labels]

    own = {film: rows(partial(_of_films, films=[film])) for film in films}
    ordered = sorted(own, key=lambda film: _margin(first, next(iter(tables.values())), film))
    figures = rows(partial(_of_films, films=films))
    return Overview(
        _sentence(runs, tables, figures, alike),
        conditions(first, films),
        figures,
        rows(_of_motion),
        {film: own[film] for film in ordered} if len(films) > 1 else {},
    )


def _sentence(runs, tables, figures, alike) -> str:
    """Return the figures of the first run, or what changes from the second run to the first one."""
    pairs = [(one.cells[0], one.cells[1]) for one in figures if len(runs) > 1]
    known = [difference(one, other, alike[1]) for one, other in pairs if one and other]
    own = [f"the {cell.label} is {cell.figure}" for one in figures if (cell := one.cells[0])]
    if not own:
        return ""
    if not known or len(known) < len(figures):
        return f"T{listed(own)[1:]}."
    trees = [results.case for results in runs.values()]
    names = differing(trees[0], trees[1], list(runs))
    return f"{changes(names, known)} {unequal_lengths(names, [*tables.values()])}".rstrip()


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
    notes = [f"FMEP {pressure.figure}"] if pressure else []
    if share:
        notes.append(share.shown or f"{share.figure} by asperity contact")
    yield replace(power, note=", ".join(notes))


def _of_motion(table) -> Iterator[Measure]:
    """Yield FMEP, side force, impacts and motion. For one film, yield contact and oil."""
    if pressure := table.of("friction_mean_effective_pressure_pa"):
        yield replace(pressure, note="")
    for key in MOTION:
        for one in (table.of(key, body) for body in table.bodies):
            if one and one.shown != NO_IMPACT:
                yield replace(table.named(one), note="")
    for key in ("contact_share", "oil_throughput_m3") if len(table.films) == 1 else ():
        if one := table.of(key, table.films[0]):
            yield replace(one, note="")


def _margin(results, table, film):
    """Return film thickness over roughness of a film, or the thickness in µm if it is smooth."""
    thinnest = table.of("minimum_film_thickness_m", film)
    if thinnest is None:
        return np.inf
    return thinnest.value / (parameter(results, film, "roughness_rms", "m") or 1e-6)


def conditions(results: Results, films: list[str]) -> list[str]:
    """Return speed, bore, clearance, oil, grid, modes and period of a run."""
    participants = results.case["participants"]
    bodies = players(results.case, "bodies")
    film = participants[films[0]]
    parameters = film.get("parameters", {})
    body = participants[bodies[0]] if bodies else {}
    own, build = body.get("parameters", {}), body.get("build", {})
    texts = []
    if "crank_speed" in own:
        texts.append(str(own["crank_speed"]))
    if "bore_radius" in parameters:
        texts.append(f"bore {2e3 * to_si(parameters['bore_radius'], 'm'):.4g} mm")
    if "radial_clearance" in own:
        texts.append(_clearances(results, bodies[0], to_si(own["radial_clearance"], "m")))
    if "oil" in film.get("build", {}):
        texts.append(f"oil {film['build']['oil']}")
    elif "viscosity" in parameters:
        texts.append(f"oil {1e3 * to_si(parameters['viscosity'], 'Pa.s'):.3g} mPa s")
    if "grid" in film.get("build", {}):
        texts.append("{} × {} cells".format(*film["build"]["grid"]))
    parts = [(build[name], word) for name, word in SURFACES.items() if name in build]
    if any(part.get("modes") for part, _ in parts):
        texts.append(f"{' + '.join(str(part.get('modes') or 0) for part, _ in parts)} modes")
    hot = [word for part, word in parts if {"hot_shape", "temperature_field"} & {*part}]
    if hot:
        texts.append(f"hot shape of {' and '.join(hot)}")
    summary = results.summary or {}
    if summary.get("periods", 0) > 1:
        texts.append(f"last of {summary['periods']} periods")
    return texts


def _clearances(results: Results, body: str, cold: float) -> str:
    """Return the radial clearance, and that between walls of the last levels of temperature."""
    port = f"{body}.thermal_opening"
    opening = results.series(port).values[-1] if port in results.ports else 0.0
    text = f"radial clearance {short(cold, 'm')}"
    return f"{text} cold, {short(cold + opening, 'm')} hot" if opening else text
