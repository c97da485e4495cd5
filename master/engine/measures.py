"""Table of the measures of a run: the figures that lines, checks, report, sweep and study show.

Every value refers to the last period of the run. A measure is omitted if the run lacks its outputs.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from ..case.contract import contract, players
from ..case.schema import Case
from ..case.tables import reduced
from ..fmi.quantities import numbers_text, short
from ..results.file import Results
from ..results.instants import crank_angle, length_text
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
from .peaks import LEAST_DISTANCE, LEAST_EXCESS, side_peaks
from .places import CellPosition, highest_position, thinnest_position
from .uncertainty import (
    CAUSES,
    DIVERGES,
    EXACT,
    LEAST_PART,
    UNKNOWN,
    Uncertainty,
    at_least,
    combined,
    display_unit,
    entry_of,
)

DESIGN = {
    "minimum_film_thickness_m": "raise",
    "friction_mean_effective_pressure_pa": "lower",
    "slap_energy_j": "lower",
    "largest_rocking_angle_rad": "lower",
    "contact_share": "lower",
}
"""Measures of a design -> whether lower or higher values are better. A name ends with the unit."""
NEGLIGIBLE_CONTACT = 1e-6
"""Share up to which contact counts as none."""
LEAST_SHARE = 5e-5
"""Uncertainty of a share below which the share is displayed alone: half of its last digit."""
NO_IMPACT, NO_CONTACT = "no impact", "no contact"
"""Texts of the slap energy of a piston without impacts, and of contact that does not occur."""
POWER = "mean_friction_power_w", "mean friction power"
"""Key and label of the friction of a film, and of all films."""


@dataclass(frozen=True, repr=False)
class Measure:
    """Figure of the last period of a run.

    key : name, which ends with its unit; label : name in words; value : in the SI unit `unit`;
    owner : participant, "" for all of them; row, place : macro step and cell of an extreme value;
    before, note : words before and after the value; shown : text that replaces the value; scale :
    part of the value that depends on the film, default: the value; course : values over the macro
    steps that the figure is made of.
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

    def __repr__(self) -> str:
        return f"<{self.label}: {self.text}>"

    @property
    def figure(self) -> str:
        """Value with its uncertainty and unit."""
        if self.shown:
            return self.shown
        factor, label = display_unit(self.unit, max(abs(self.value), self.uncertainty.value or 0.0))
        text = f"{self.number(factor)} {label}".rstrip()
        if self.uncertainty.reason == DIVERGES:
            return f"{text} ({DIVERGES})"
        spread = self.uncertainty.value or 0.0
        if not 0.0 < self.value < spread or (self.unit == "1" and spread < LEAST_SHARE):
            return text
        most = numbers_text(factor * (self.value + spread), factor * spread).partition(" ")[0]
        cause = self.uncertainty.contributor
        return f"{text} (not resolved by the {cause}; at most {most} {label})".replace(" )", ")")

    def number(self, factor: float) -> str:
        """Return value and uncertainty times a factor, in digits that fit each other."""
        spread = self.uncertainty.value or 0.0
        if self.unit == "1" and spread < LEAST_SHARE:
            spread = 0.0
        return numbers_text(factor * self.value, factor * spread)

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
    """All measures of a run.

    films, bodies : participants, in the order of the case; length : of the last period.
    """

    films: list[str] = field(default_factory=list[str])
    bodies: list[str] = field(default_factory=list[str])
    all: list[Measure] = field(default_factory=list[Measure])
    length: str = ""

    def of(self, key: str, owner: str = "") -> Measure | None:
        """Return the measure of a participant, None if the run lacks it."""
        return next((one for one in self.all if (one.key, one.owner) == (key, owner)), None)

    def worst(self, key: str, owners: list[str] | None = None) -> Measure | None:
        """Return the worst value of a measure of participants, by default of any participant."""
        known = [m for m in self.all if m.key == key and (owners is None or m.owner in owners)]
        extreme = min if DESIGN.get(key) == "raise" else max
        return extreme(known, key=lambda one: one.value, default=None)

    def named(self, one: Measure) -> Measure:
        """Return a measure whose label names its participant, if several have such a measure."""
        others = [m for m in self.all if m.key == one.key and m.owner]
        several = one.owner and len(others) > 1
        return replace(one, label=f"{one.label}, {one.owner}") if several else one

    @property
    def estimated(self) -> list[Measure]:
        """Measures that have an uncertainty, or a reason why it is unknown."""
        return [one for one in self.all if one.uncertainty not in (UNKNOWN, EXACT)]

    @property
    def design(self) -> dict[str, float]:
        """Worst value of each measure of a design."""
        figures = {key: self.worst(key) for key in DESIGN}
        return {key: one.value for key, one in figures.items() if one}


def unknown_in_words(known: list[Measure]) -> list[str]:
    """Return a sentence for each reason why uncertainties are unknown."""
    labels: dict[str, list[str]] = {}
    for one in known:
        if one.uncertainty.reason not in ("", DIVERGES):
            labels.setdefault(one.uncertainty.reason, []).append(one.label)
    names = {why: own[0] if len(own) == 1 else f"{len(own)} figures" for why, own in labels.items()}
    return [f"The uncertainty of {name} is unknown: {why}." for why, name in names.items()]


def measures(case: Case, results: Results) -> Measures:
    """Return the measures of a finished run.

    The largest loss of the piston's own kinetic energy in an impact is the slap energy. The
    contact share is the fraction of the friction work.
    """
    results = results.last
    films, bodies = (players(results.case, role) for role in ("lubrication", "bodies"))
    run = _Run(case, results)
    figures = [
        *(one for film in films for one in _of_film(run, film)),
        *_of_friction(run),
        *(one for body in bodies for one in _of_body(run, body, (films or [""])[0])),
    ]
    cells = {
        one.owner: one.place.index
        for one in figures
        if one.key == "minimum_film_thickness_m" and one.place
    }
    indicator = Indicator(results, films, cells)
    known = [_estimated(one, indicator, results, films) for one in figures]
    return Measures(films, bodies, known, length_text(results))


def _estimated(measure: Measure, indicator: Indicator, results: Results, films) -> Measure:
    """Return a measure with its uncertainty: the parts of `run --uncertainty`, or estimates."""
    if measure.shown in (NO_IMPACT, NO_CONTACT):
        return replace(measure, uncertainty=EXACT)
    if measure.key not in GRID or measure.shown:
        return measure
    film = indicator.film_of(measure.owner)
    if measure.key == "maximum_pressure_pa" and film and film.narrow:
        return replace(measure, uncertainty=Uncertainty(None, "grid", DIVERGES))
    summary, parts = results.summary or {}, indicator.parts(measure)
    known = {
        cause: at_least(summary[name], LEAST_PART * parts.get(cause, 0.0))
        for cause in CAUSES
        if (name := entry_of(cause, measure.name)) in summary
    }
    if "grid" not in parts | known:
        own = [measure.owner] if measure.owner in films else films
        return replace(measure, uncertainty=Uncertainty(None, "", reason(results, own)))
    return replace(measure, uncertainty=combined(parts | known, signed=bool(known)))


def directions(case: Case) -> dict[str, str]:
    """Return the measures and summary entries of a design -> "raise", "lower" or "none".

    The contract declares the directions of outputs. Outputs that it names as numerical errors are
    omitted.
    """
    declared = {
        name: goal for role in contract().values() for name, goal in role.directions.items()
    }
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

    def figure(
        self, owner: str, output: str, key: str, label: str, unit: str, reduce: Reduction, **words
    ) -> Measure:
        """Return the figure that a reduction makes of a scalar output; `words` : of `Measure`."""
        port = f"{owner}.{output}"
        course = Course(self.results.whole.series(port).values, reduce)
        value = float(reduce(self.results.time, self.results.series(port).values))
        return Measure(key, label, value, unit, owner, course=course, **words)

    def at(self, row: int) -> str:
        """Return a row as a crank angle, or as a time if the run has no crank angle."""
        crank = crank_angle(self.results)
        if crank is None:
            return f"at {short(self.results.time[row], 's')}"
        return f"at {round(np.degrees(crank.angle[row]), 6):z.4g} deg"


EXTREMES = (
    ("minimum_film_thickness", "m", np.argmin, thinnest_position, of_extreme(np.min)),
    ("maximum_pressure", "Pa", np.argmax, highest_position, of_extreme(np.max)),
)
"""Outputs of a film whose extreme over the period is a measure, with its position."""


def _of_film(run: _Run, film: str) -> Iterator[Measure]:
    for output, unit, row_of, position, reduce in EXTREMES:
        values = run.values(film, output)
        if values is not None:
            row, place = int(row_of(values)), position(run.case, run.results, film)
            key, label = f"{output}_{unit.lower()}", output.replace("_", " ")
            note = ", ".join(filter(None, [run.at(row), place and place.brief]))
            words = {"row": row, "place": place, "note": note}
            yield run.figure(film, output, key, label, unit, reduce, **words)
    yield from _peaks(run, film)
    power = run.values(film, "friction_power")
    if power is not None and len(power) > 1:
        yield run.figure(film, "friction_power", *POWER, "W", mean_over)
    share, area = contact_share(run.results, film), run.values(film, "contact_area_fraction")
    if share is not None:
        dry = area is not None and not area.max() > 0.0
        note, shown = ("", NO_CONTACT) if dry else ("of the friction work", "")
        label = "contact share"
        share = share if share > NEGLIGIBLE_CONTACT else 0.0
        yield Measure("contact_share", label, share, "1", film, note=note, shown=shown)
    if area is not None and area.max() > 0.0:
        what = "skirt" if run.values(film, "friction_torque") is None else "bearing"
        label, note = "area of contact", f"of the {what}"
        size, row = float(area.max()), int(area.argmax())
        yield Measure(
            key="contact_area",
            label=label,
            value=size,
            unit="1",
            owner=film,
            row=row,
            place=None,
            before="on at most",
            note=note,
        )
    if balance := oil_balance(run.results, film):
        before = f"net {_net(balance)} per period; throughput"
        label, through = "oil throughput per period", balance.throughput
        yield Measure("oil_throughput_m3", label, through, "m3", film, before=before)


def _net(balance):
    """Return the net volumes through the edges of a film in words."""
    ways = {"lower edge": balance.lower, "upper edge": balance.upper, "cut-outs": balance.openings}
    net = ", ".join(
        f"{1e9 * abs(volume):.3g} mm³ {'in' if volume > 0.0 else 'out'} through the {boundary}"
        for boundary, volume in ways.items()
        if volume
    )
    return net or "0 mm³"


def _peaks(run, film) -> Iterator[Measure]:
    """Yield the distances of the pressure peaks from the lines of a skirt."""
    port = f"{film}.pressure"
    # the load line of a bearing rotates
    if port not in run.results.recorded or run.values(film, "friction_torque") is not None:
        return
    axis = run.case.axes_of(port).first
    for peak in side_peaks(axis, run.results.dataset(port)[:]):
        shown = f"on the {peak.side} line"
        if peak.distance >= LEAST_DISTANCE:
            shown = f"{peak.distance:.0f} {axis.unit} from the {peak.side} line"
            excess, above, share = (
                f"{100 * x:.0f} %" for x in (peak.excess, LEAST_EXCESS, peak.share)
            )
            shown += (
                f", {excess} higher than on it (at least {above} in {share} of loaded instants)"
            )
        label = f"distance of the pressure peak from the {peak.side} line"
        value = float(np.radians(peak.distance))
        side = re.sub(r"\W+", "_", peak.side)
        yield Measure(f"peak_distance_{side}_rad", label, value, "rad", film, shown=shown)


def _of_friction(run: _Run) -> Iterator[Measure]:
    """Yield the friction of all films."""
    power, whole = friction_power(run.results), friction_power(run.results.whole)
    if power is None or whole is None or len(power) < 2:
        return
    mean = mean_over(run.results.time, power)
    yield Measure(*POWER, mean, "W", before="mean", course=Course(whole, mean_over))
    pressure, crank = friction_pressure(run.results), crank_angle(run.results)
    if pressure is not None and crank is not None:
        yield Measure(
            "friction_mean_effective_pressure_pa",
            "friction mean effective pressure",
            pressure,
            "Pa",
            before="FMEP",
            note=f"over {length_text(run.results)}",
            course=Course(whole, of_work(pressure, run.results.time, power)),
        )


def _of_body(run: _Run, body: str, film: str) -> Iterator[Measure]:
    demand = run.values(body, "side_force_demand")
    for output, what, before in (
        ("side_force", "side force", ""),
        ("side_force_demand", "side-force demand", "demand"),
    ):
        force = run.values(body, output)
        if force is None:
            continue
        row = int(np.abs(force).argmax())
        note = f"on the {'thrust' if force[row] >= 0.0 else 'anti-thrust'} side {run.at(row)}"
        scale = None if demand is None else abs(largest(force) - largest(demand))
        words = {"row": row, "before": before, "note": note, "scale": scale}
        reduce = of_extreme(largest)
        yield run.figure(body, output, f"{output}_n", f"maximum {what}", "N", reduce, **words)
    all_impacts = impacts(run.results, body)
    if all_impacts is not None:
        worst = max(all_impacts, key=lambda impact: impact.loss, default=None)
        words = {"shown": NO_IMPACT}
        if worst:
            words = {"note": _slap(run, worst, film), "row": worst.row}
        own = "slap_energy_j", "slap energy", "J"
        yield run.figure(body, "piston_kinetic_energy", *own, hardest, **words)
    for output, unit in (("lateral_displacement", "m"), ("rocking_angle", "rad")):
        values = run.values(body, output)
        if values is None:
            continue
        for word, row, reduce in (
            ("minimum", int(values.argmin()), np.min),
            ("maximum", int(values.argmax()), np.max),
            ("range", None, np.ptp),
            ("largest", int(np.abs(values).argmax()), largest),
        ):
            label = f"{word} {'of ' if row is None else ''}{output.replace('_', ' ')}"
            key, extreme = f"{word}_{output}_{unit}", of_extreme(reduce)
            yield run.figure(body, output, key, label, unit, extreme, row=row)


def _slap(run, impact, film):
    """Return instant, edge, velocity, side and height of an impact."""
    axis = run.case.axes_of(f"{film}.pressure").second
    height = f"{axis.label} {axis.range[impact.edge == 'upper']:.3g} {axis.unit}".rstrip()
    speed = short(abs(impact.velocity), "m/s")
    edge = f"{impact.edge} edge at {speed} on the {impact.side} side, {height}"
    return f"lost {run.at(impact.row)}, {edge}"
