"""Main results and checks of a run, for the terminal and the report."""

import re
from collections import Counter
from dataclasses import dataclass, field
from math import isclose

from ..case.tables import reduced
from ..fmi.quantities import short
from ..results.file import Results
from ..results.instants import length_text
from .measures import Measure, Measures, measures, unknown_in_words
from .uncertainty import UNKNOWN, display_unit
from .verdicts import RANK, WORDS, Verdict, verdicts

ENDS, RANGE = ("minimum", "maximum"), " to "
LINES = (
    ("minimum film", "films", ["minimum_film_thickness_m"], ""),
    ("maximum pressure", "films", ["maximum_pressure_pa"], ""),
    ("pressure peak", "films", ["peak_distance_"], "; "),
    ("friction", "", ["mean_friction_power_w", "friction_mean_effective_pressure_pa"], ", "),
    ("asperity contact", "films", ["contact_share", "contact_area"], ", "),
    ("side force", "bodies", ["side_force_n", "side_force_demand_n"], "; "),
    ("slap", "bodies", ["slap_energy_j"], ""),
    ("lateral motion", "bodies", [f"{end}_lateral_displacement_m" for end in ENDS], RANGE),
    ("rocking angle", "bodies", [f"{end}_rocking_angle_rad" for end in ENDS], RANGE),
    ("oil", "films", ["oil_throughput_m3"], ""),
)
"""Name of a line, its participants, the beginnings of its measures' keys, and the text between.

A line of "" is about all participants.
"""


@dataclass(frozen=True)
class Answer:
    """Main results of a run as texts by name, its checks, measures, and their uncertainty."""

    lines: dict[str, str]
    verdicts: list[Verdict]
    table: Measures = field(default_factory=Measures)
    uncertainty: str = ""


def answer(case, results) -> Answer:
    """Return the answer of a finished run.

    The lines are those of `headlines` for a piston on its film, otherwise the summary entries of
    the case. Run length and numbers of checks follow.

    Parameters
    ----------
    case : Case
    results : Results
    """
    table = measures(case, results)
    lines = headlines(table) or _own_summary(case, results)
    judged = verdicts(results, table)
    lines |= {"periodicity": _settled(results), "run": _computed(results.whole)}
    lines["checks"] = _counted(judged)
    text = uncertainty_text(table, results.summary or {})
    return Answer({name: words for name, words in lines.items() if words}, judged, table, text)


def headlines(table: Measures) -> dict[str, str]:
    """Return the main results of a run by name, none without a piston and its film."""
    if not table.films or not table.bodies:
        return {}
    owners = {"films": table.films, "bodies": table.bodies, "": [""]}
    lines = {}
    for name, kind, keys, between in LINES:
        for owner in owners[kind]:
            known = [
                one for one in table.all if one.owner == owner and one.key.startswith(tuple(keys))
            ]
            alone = len(owners[kind]) == 1
            text = in_one_unit(known) if between == RANGE else between.join(m.text for m in known)
            lines[name if alone else f"{name}, {owner}"] = text
    return {name: words for name, words in lines.items() if words}


def in_one_unit(known: list[Measure]) -> str:
    """Return the ends of a range in one unit."""
    if not known:
        return ""
    factor, label = display_unit(known[0].unit, max(abs(one.value) for one in known))
    return f"{RANGE.join(one.number(factor) for one in known)} {label}"


def row_of(case, path) -> dict[str, float | str]:
    """Return the columns of a finished run in the table of a sweep.

    They are the measures of a design, `NAME_uncertainty` of them and of equal summary entries, and
    the check with the worst result. An unknown uncertainty is a text with the reason. Contact and
    impacts that do not occur are exactly zero.
    """
    with Results(path) as run:
        one = answer(case, run)
        chosen = {key: one.table.worst(key) for key in one.table.design}
        chosen |= {
            key: _equal_measure(one.table, run, key, text) for key, text in case.summary.items()
        }
    row: dict[str, float | str] = {**one.table.design}
    for key, measure in chosen.items():
        known = measure.uncertainty if measure else UNKNOWN
        if known is not UNKNOWN:
            row[f"{key}_uncertainty"] = known.reason if known.value is None else known.value
    return row | {"worst_check": worst_check(one.verdicts)}


def _equal_measure(table, results, key, text) -> Measure | None:
    """Return the measure of a summary entry: that of its name, or of its owner, unit and size."""
    if named := table.worst(key):
        return named
    port, value = reduced(text).port, (results.summary or {}).get(key)
    if port not in results.ports or not value:
        return None
    owner, unit = port.partition(".")[0], results.series(port).unit
    return next(
        (
            one
            for one in table.estimated
            if (one.owner, one.unit) == (owner, unit) and isclose(abs(one.value), abs(value))
        ),
        None,
    )


def worst_check(checks: list[Verdict]) -> str:
    """Return the worst outcome of checks and the names of those that have it: "fail: grid"."""
    if not checks:
        return ""
    worst = RANK[max(RANK.index(one.colour) for one in checks)]
    names = ", ".join(dict.fromkeys(one.what for one in checks if one.colour == worst))
    return WORDS[worst] if worst == RANK[0] else f"{WORDS[worst]}: {names}"


def failed_checks(checks: list[Verdict]) -> list[str]:
    """Return the names of the checks that fail."""
    return [*dict.fromkeys(one.what for one in checks if one.colour == RANK[-1])]


def uncertainty_text(table: Measures, summary: dict) -> str:
    """Return sentences about the uncertainties of a run, "" if it has none."""
    known = [one for one in table.estimated if one.uncertainty.value is not None]
    sentences = []
    if known:
        computed = any(name.startswith("uncertainty_grid_") for name in summary)
        source = "from a second grid and doubled steps" if computed else "estimates from this run"
        parts = Counter(one.uncertainty.contributor for one in known)
        cause, count = parts.most_common(1)[0]
        largest = f"The largest part of {count} of {len(known)} is that of the {cause}."
        sentences = [f"Uncertainties are {source}. {largest}"]
    sentences += unknown_in_words(table.estimated)
    if own_grids := summary.get("uncertainty_kept"):
        sentences.append(f"These participants keep their grid: {own_grids}.")
    if why := summary.get("uncertainty_reason"):
        sentences.append(f"A second grid with doubled steps is not possible: {why}.")
    return " ".join(sentences)


def _own_summary(case, results):
    """Return the summary entries of the case in words, with the units of their outputs."""
    summary, entries = results.summary or {}, {}
    for name, text in case.summary.items():
        port = reduced(text).port
        if name in summary and port in results.ports:
            unit = results.series(port).unit
            spelt = "_" + re.sub(r"\W+", "_", unit).lower()
            words = name.removesuffix(spelt).replace("_", " ")
            entries[words] = short(summary[name], unit, 4)
        elif name in summary:
            entries[name.replace("_", " ")] = f"{summary[name]:.6g}"
    return entries


def _settled(results):
    """Return the change between the last two periods, "" for a run without periods."""
    summary = results.summary or {}
    if "settled" not in summary:
        return ""
    count = summary["periods"]
    if count < 2:
        return "unknown, because the run has fewer than two periods"
    change = f"change of {summary['period_distance']:.2g} between the last two periods"
    return change if summary["periodic"] else f"not periodic: {change}"


def _computed(results):
    """Return length, number of periods and steps, and wall time of the run."""
    reach, summary = length_text(results), results.summary or {}
    steps = summary.get("steps", len(results.time) - 1)
    if summary.get("periods", 0) > 1:
        reach += f" ({summary['periods']} periods)"
    return f"{reach} in {steps} steps, wall time {summary.get('wall_time_s', 0.0):.3g} s"


def _counted(judged):
    """Return the numbers of checks that pass, warn and fail."""
    colours = [one.colour for one in judged]
    counts = [f"{colours.count(colour)} {WORDS[colour]}" for colour in RANK if colour in colours]
    return ", ".join(counts)
