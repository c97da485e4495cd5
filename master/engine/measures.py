"""Table of the measures of a run: the figures that lines, checks, report, sweep and study show.

Every value refers to the last period of the run. A measure is omitted if the run lacks its outputs.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..case.contract import contract, players
from ..case.schema import Case
from ..case.tables import reduced
from ..fmi.quantities import short
from ..results.file import Results
from ..results.instants import crank_angle
from ..results.judgement import mean_over
from .friction import contact_share, friction_power, friction_pressure
from .impacts import impacts
from .indicator import (
    GRID,
    Course,
    Indicator,
    Reduction,
    hardest,
    largest,
    of_extreme,
    of_work,
    reason,
)
from .oil_balance import oil_balance
from .peaks import ABOVE, BESIDE, side_peaks
from .places import CellPosition, highest_position, thinnest_position
from .uncertainty import (
    CAUSES,
    DISPLAYED,
    DIVERGES,
    LUCK,
    UNKNOWN,
    Uncertainty,
    at_least,
    combined,
    entry_of,
    spread_text,
)

DESIGN = {
    "minimum_film_thickness_m": "raise",
    "friction_mean_effective_pressure_pa": "lower",
    "slap_energy_j": "lower",
    "largest_rocking_angle_rad": "lower",
    "contact_share": "lower",
}
"""Measures of a design and where it wants them; each name ends with its unit."""
CHECKS = {"minimum_film_thickness_m": ("film",), "maximum_pressure_pa": ("pressure", "grid")}
"""Measure -> checks about it, without the name of its film."""
TRACE = 1e-6
"""Share that is displayed as 0."""
LEAST_SHARE = 5e-5
"""Uncertainty of a share below which the share is displayed alone: half of its last digit."""
NO_IMPACT = "no impact"
"""Text of the slap energy of a piston without impacts."""


@dataclass(frozen=True)
class Measure:
    """Figure of the last period of a run.

    Parameters
    ----------
    key : str
        Name, which ends with its unit.
    label : str
        Name in words.
    value : float
        In the SI unit `unit`.
    owner : str
        Participant, "" for all of them.
    row : int or None
        Macro step of an extreme value.
    place : CellPosition or None
        Cell of an extreme value.
    before, note : str
        Words before and after the value.
    shown : str
        Text that replaces the value.
    scale : float or None
        Part of the value that depends on the film, default: the value.
    course : Course or None
        Values over the macro steps that the figure is made of.
    uncertainty : Uncertainty
    """

    key: str
    label: str
    value: float
    unit: str
    owner: str = ""
    row: int | None = None
    place: CellPosition | None = None
    before: str = ""
    note: str = ""
    shown: str = ""
    scale: float | None = None
    course: Course | None = None
    uncertainty: Uncertainty = UNKNOWN

    @property
    def figure(self) -> str:
        """Value with its uncertainty and unit."""
        spread = self.uncertainty.value
        if self.shown:
            return self.shown
        if spread and (self.unit != "1" or spread >= LEAST_SHARE):
            return spread_text(self.value, spread, self.unit)
        text = value_text(self.value, self.unit)
        return f"{text} ({DIVERGES})" if self.uncertainty.reason == DIVERGES else text

    @property
    def text(self) -> str:
        """Value with its uncertainty and unit, between the words about it."""
        return " ".join(filter(None, [self.before, self.figure, self.note]))

    @property
    def name(self) -> str:
        """Key with the participant, by which summaries and tables name the measure."""
        return f"{self.key}_{self.owner}" if self.owner else self.key


@dataclass(frozen=True)
class Measures:
    """All measures of a run; films, bodies : participants, in the order of the case."""

    films: list[str] = field(default_factory=list[str])
    bodies: list[str] = field(default_factory=list[str])
    all: list[Measure] = field(default_factory=list[Measure])

    def of(self, key: str, owner: str = "") -> Measure | None:
        """Return the measure of a participant, None if the run lacks it."""
        return next((one for one in self.all if (one.key, one.owner) == (key, owner)), None)

    def worst(self, key: str, owners: list[str] | None = None) -> Measure | None:
        """Return the worst value of a measure of participants, by default of any participant."""
        known = [m for m in self.all if m.key == key and (owners is None or m.owner in owners)]
        way = min if DESIGN.get(key) == "raise" else max
        return way(known, key=lambda one: one.value, default=None)

    @property
    def estimated(self) -> list[Measure]:
        """Measures that have an uncertainty, or a reason why it is unknown."""
        return [one for one in self.all if one.uncertainty is not UNKNOWN]

    @property
    def design(self) -> dict[str, float]:
        """Worst value of each measure of a design."""
        found = {key: self.worst(key) for key in DESIGN}
        return {key: one.value for key, one in found.items() if one}


def value_text(value: float, unit: str) -> str:
    """Return a value with three digits: shares in percent, volumes in mm³, angles in degrees."""
    if unit == "1":
        return f"{value:.2%}"
    if unit not in DISPLAYED:
        return short(value, unit)
    factor, label = DISPLAYED[unit]
    return f"{factor * value:.3g} {label}"


def without_trace(share: float) -> float:
    """Return a share, 0 if it is a trace."""
    return share if share > TRACE else 0.0


def measures(case: Case, results: Results) -> Measures:
    """Return the measures of a finished run.

    The largest loss of the piston's own kinetic energy in an impact is the slap energy. The
    contact share is the fraction of the friction work.
    """
    results = results.last
    films, bodies = (players(results.case, role) for role in ("lubrication", "bodies"))
    run = _Run(case, results)
    found = [
        *(one for film in films for one in _of_film(run, film)),
        *_of_friction(run),
        *(one for body in bodies for one in _of_body(run, body, (films or [""])[0])),
    ]
    cells = {
        one.owner: one.place.index
        for one in found
        if one.key == "minimum_film_thickness_m" and one.place
    }
    indicator = Indicator(results, films, cells)
    return Measures(films, bodies, [_estimated(one, indicator, results, films) for one in found])


def _estimated(measure: Measure, indicator: Indicator, results: Results, films) -> Measure:
    """Return a measure with its uncertainty: the parts of `run --uncertainty`, or estimates."""
    summary = results.summary or {}
    parts = indicator.parts(measure)
    entries = {cause: entry_of(cause, measure.name) for cause in CAUSES}
    known = {
        cause: at_least(summary[name], LUCK * parts.get(cause, 0.0))
        for cause, name in entries.items()
        if name in summary
    }
    parts |= known
    film = indicator.film_of(measure.owner)
    if measure.key not in GRID or measure.shown:
        return measure
    if measure.key == "maximum_pressure_pa" and film and film.narrow:
        return replace(measure, uncertainty=Uncertainty(None, "grid", DIVERGES))
    if "grid" not in parts:
        return replace(measure, uncertainty=Uncertainty(None, "", reason(results, films)))
    return replace(measure, uncertainty=combined(parts, signed=bool(known)))


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
    return DESIGN | entries


@dataclass(frozen=True)
class _Run:
    """Case and results of one period."""

    case: Case
    results: Results

    def values(self, owner: str, output: str) -> np.ndarray | None:
        """Return a scalar output over the macro steps, or None if the run lacks it."""
        port = f"{owner}.{output}"
        return self.results.series(port).values if port in self.results.ports else None

    def course(self, owner: str, output: str, reduce: Reduction) -> Course:
        """Return a scalar output of the whole run, and the function that makes a figure of it."""
        return Course(self.results.whole.series(f"{owner}.{output}").values, reduce)

    def at(self, row: int) -> str:
        """Return a row as a crank angle, or as a time if the run has no crank angle."""
        crank = crank_angle(self.results)
        if crank is None:
            return f"at {short(self.results.time[row], 's')}"
        return f"at {np.degrees(crank.angle[row]):.4g} deg"


EXTREMES = (
    ("minimum_film_thickness", "m", np.argmin, thinnest_position, of_extreme(np.min)),
    ("maximum_pressure", "Pa", np.argmax, highest_position, of_extreme(np.max)),
)
"""Outputs of a film whose extreme over the period is a measure, with its position."""


def _of_film(run: _Run, film: str) -> Iterator[Measure]:
    for output, unit, row_of, position, reduce in EXTREMES:
        values = run.values(film, output)
        if values is not None:
            row = int(row_of(values))
            place = position(run.case, run.results, film)
            note = ", ".join(filter(None, [run.at(row), place and place.brief]))
            key, label = f"{output}_{unit.lower()}", output.replace("_", " ")
            value, course = float(values[row]), run.course(film, output, reduce)
            yield Measure(key, label, value, unit, film, row, place, note=note, course=course)
    yield from _peaks(run, film)
    power = run.values(film, "friction_power")
    if power is not None and len(power) > 1:
        mean, course = (
            mean_over(run.results.time, power),
            run.course(film, "friction_power", mean_over),
        )
        label = "mean friction power"
        yield Measure("mean_friction_power_w", label, mean, "W", film, course=course)
    share, area = contact_share(run.results, film), run.values(film, "contact_area_fraction")
    if share is not None:
        label = "friction work by asperity contact"
        dry = area is not None and not area.max() > 0.0
        note, shown = ("", "no contact") if dry else ("of the friction work", "")
        yield Measure("contact_share", label, share, "1", film, note=note, shown=shown)
    if area is not None and area.max() > 0.0:
        what = "skirt" if run.values(film, "friction_torque") is None else "bearing"
        words: dict[str, Any] = {"before": "on at most", "note": f"of the {what}"}
        row = int(area.argmax())
        yield Measure(
            "contact_area", "area of contact", float(area[row]), "1", film, row, None, **words
        )
    if balance := oil_balance(run.results, film):
        before = f"net {_net(balance)} per period; throughput"
        label, through = "oil throughput per period", balance.throughput
        yield Measure("oil_throughput_m3", label, through, "m3", film, before=before)


def _net(balance):
    """Return the net volumes through the edges of a film in words."""
    ways = {"lower edge": balance.lower, "upper edge": balance.upper, "cut-outs": balance.openings}
    net = ", ".join(
        f"{value_text(abs(volume), 'm3')} {'in' if volume > 0.0 else 'out'} through the {way}"
        for way, volume in ways.items()
        if volume
    )
    return net or value_text(0.0, "m3")


def _peaks(run, film) -> Iterator[Measure]:
    """Yield the distances of the pressure peaks from the lines of a skirt."""
    port = f"{film}.pressure"
    # the load line of a bearing rotates
    if port not in run.results.recorded or run.values(film, "friction_torque") is not None:
        return
    axis = run.case.axes_of(port).first
    for peak in side_peaks(axis, run.results.dataset(port)[:]):
        shown, note = f"on the {peak.side} line", ""
        if peak.distance >= BESIDE:
            shown = f"{peak.distance:.0f} {axis.unit} from the {peak.side} line"
            note = f", {peak.excess:.0%} higher than on it (at least {ABOVE:.0%} higher in "
            shown, note = f"{shown}{note}{peak.share:.0%} of loaded instants)", ""
        label = f"distance of the pressure peak from the {peak.side} line"
        value = float(np.radians(peak.distance))
        yield Measure("peak_distance_rad", label, value, "rad", film, note=note, shown=shown)


def _of_friction(run: _Run) -> Iterator[Measure]:
    """Yield the friction of all films."""
    power, whole = friction_power(run.results), friction_power(run.results.whole)
    if power is None or whole is None or len(power) < 2:
        return
    mean = mean_over(run.results.time, power)
    words: dict[str, Any] = {"before": "mean", "course": Course(whole, mean_over)}
    yield Measure("mean_friction_power_w", "mean friction power", mean, "W", **words)
    pressure, crank = friction_pressure(run.results), crank_angle(run.results)
    if pressure is not None and crank is not None:
        begin, *_, end = np.degrees(crank.angle)
        yield Measure(
            "friction_mean_effective_pressure_pa",
            "friction mean effective pressure",
            pressure,
            "Pa",
            before="FMEP",
            note=f"over {end - begin:.4g} deg",
            course=Course(whole, of_work(pressure, run.results.time, power)),
        )


def _of_body(run: _Run, body: str, film: str) -> Iterator[Measure]:
    for output, label, before in (
        ("side_force", "maximum side force", ""),
        ("side_force_demand", "maximum side-force demand", "demand"),
    ):
        force = run.values(body, output)
        if force is not None:
            row = int(np.abs(force).argmax())
            side = "thrust" if force[row] >= 0.0 else "anti-thrust"
            words: dict[str, Any] = {"before": before, "note": f"on the {side} side {run.at(row)}"}
            words["course"] = run.course(body, output, of_extreme(largest))
            size = float(abs(force[row]))
            demand = run.values(body, "side_force_demand")
            words["scale"] = None if demand is None else abs(size - largest(demand))
            yield Measure(f"{output}_n", label, size, "N", body, row, None, **words)
    found = impacts(run.results, body)
    if found is not None:
        worst = max(found, key=lambda impact: impact.loss, default=None)
        size, row = (worst.loss, worst.row) if worst else (0.0, None)
        words = {"note": _slap(run, worst, film)} if worst else {"shown": NO_IMPACT}
        words["course"] = run.course(body, "piston_kinetic_energy", hardest)
        label = "energy lost in the hardest impact"
        yield Measure("slap_energy_j", label, size, "J", body, row, None, **words)
    for output, label, unit in (
        ("lateral_displacement", "lateral displacement", "m"),
        ("rocking_angle", "rocking angle", "rad"),
    ):
        values = run.values(body, output)
        if values is None:
            continue
        for word, row, reduce in (
            ("minimum", int(values.argmin()), np.min),
            ("maximum", int(values.argmax()), np.max),
            ("range of", None, np.ptp),
            ("largest", int(np.abs(values).argmax()), largest),
        ):
            key = f"{word.removesuffix(' of')}_{output}_{unit}"
            course = run.course(body, output, of_extreme(reduce))
            size = float(reduce(values))
            yield Measure(key, f"{word} {label}", size, unit, body, row, course=course)


def _slap(run, impact, film):
    """Return instant, edge, velocity, side and height of an impact."""
    axis = run.case.axes_of(f"{film}.pressure").second
    height = f"{axis.label} {axis.range[impact.edge == 'upper']:.3g} {axis.unit}".rstrip()
    speed = short(abs(impact.velocity), "m/s")
    edge = f"{impact.edge} edge at {speed} on the {impact.side} side, {height}"
    return f"lost {run.at(impact.row)}, {edge}"
