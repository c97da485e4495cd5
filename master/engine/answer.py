"""Main results and checks of a run, for the terminal and the report."""

import re
from collections import Counter
from dataclasses import dataclass, field

import numpy as np

from ..case.tables import reduced
from ..fmi.quantities import short
from ..results.file import Results
from ..results.instants import crank_angle
from .headlines import Headline, headlines
from .measures import Measures, measures
from .uncertainty import DIVERGES, UNKNOWN
from .verdicts import RANK, WORDS, Verdict, verdicts


@dataclass(frozen=True)
class Answer:
    """Lines of the main results, every check, the measures of the run, and their uncertainty."""

    lines: list[Headline]
    verdicts: list[Verdict]
    table: Measures = field(default_factory=Measures)
    uncertainty: str = ""

    def said(self, name: str) -> str:
        """Return the text of the line of that name, "" if there is none."""
        return next((line.said for line in self.lines if line.name == name), "")


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
    if settled := _settled(results):
        lines.append(Headline("periodicity", settled))
    lines.append(Headline("run", _computed(results.whole)))
    if judged:
        lines.append(Headline("checks", _counted(judged)))
    return Answer(lines, judged, table, uncertainty_text(table, results.summary or {}))


def row_of(case, path) -> dict[str, float | str]:
    """Return the columns of a finished run in the table of a sweep.

    They are the measures of a design, `NAME_uncertainty` of them and of equal summary entries, and
    the check with the worst result. An unknown uncertainty is a text with the reason.
    """
    with Results(path) as run:
        one = answer(case, run)
    found: dict[str, float | str] = {**one.table.design}
    for key in dict.fromkeys([*found, *case.summary]):
        if (measure := one.table.worst(key)) and measure.uncertainty is not UNKNOWN:
            known = measure.uncertainty
            found[f"{key}_uncertainty"] = known.reason if known.value is None else known.value
    return found | {"worst_check": worst_check(one.verdicts)}


def worst_check(checks: list[Verdict]) -> str:
    """Return the worst outcome of checks and the names of those that have it: "fail: grid"."""
    if not checks:
        return ""
    worst = RANK[max(RANK.index(one.colour) for one in checks)]
    names = ", ".join(dict.fromkeys(one.what for one in checks if one.colour == worst))
    return WORDS[worst] if worst == RANK[0] else f"{WORDS[worst]}: {names}"


def uncertainty_text(table: Measures, summary: dict) -> str:
    """Return sentences about the uncertainties of a run, "" if it has none."""
    known = [one for one in table.estimated if one.uncertainty.value is not None]
    said = []
    if known:
        computed = any(name.startswith("uncertainty_grid_") for name in summary)
        how = "from a second grid and doubled steps" if computed else "estimates from this run"
        parts = Counter(one.uncertainty.contributor for one in known)
        cause, count = parts.most_common(1)[0]
        said = [f"Uncertainties are {how}. The largest part of {count} of {len(known)} is {cause}."]
    for reason in dict.fromkeys(one.uncertainty.reason for one in table.estimated):
        names = [one.label for one in table.estimated if one.uncertainty.reason == reason]
        if reason and reason != DIVERGES:
            of = names[0] if len(names) == 1 else f"{len(names)} figures"
            said.append(f"The uncertainty of {of} is unknown: {reason}.")
    if why := summary.get("uncertainty_reason"):
        said.append(f"A second grid is not possible: {why}.")
    return " ".join(said)


def _own_summary(case, results):
    """Return the summary entries of the case."""
    summary = results.summary or {}
    return [
        _in_words(name, text, summary[name], results)
        for name, text in case.summary.items()
        if name in summary
    ]


def _in_words(name, text, value, results):
    """Return an entry with its unit, removed from its name. An entry of no output has no unit."""
    port = reduced(text).port
    if port not in results.ports:
        return Headline(name.replace("_", " "), f"{value:.6g}")
    unit = results.series(port).unit
    spelt = "_" + re.sub(r"\W+", "_", unit).lower()
    return Headline(name.removesuffix(spelt).replace("_", " "), short(value, unit, 4))


def _settled(results):
    """Return the change between the last two periods, "" for a run without periods."""
    summary = results.summary or {}
    if "settled" not in summary:
        return ""
    count = summary["periods"]
    if count < 2:
        return "unknown, because the run has fewer than two periods"
    apart = f"change of {summary['period_distance']:.2g} between the last two periods"
    return apart if summary["periodic"] else f"not periodic: {apart}"


def _computed(results):
    """Return length, number of periods and steps, and wall time of the run."""
    crank = crank_angle(results)
    if crank is None:
        begin, *_, end = results.time
        reach = short(end - begin, "s")
    else:
        begin, *_, end = crank.angle
        reach = f"{np.degrees(end - begin):.4g} deg"
    summary = results.summary or {}
    steps = summary.get("steps", len(results.time) - 1)
    if summary.get("periods", 0) > 1:
        reach += f" ({summary['periods']} periods)"
    return f"{reach} in {steps} steps, wall time {summary.get('wall_time_s', 0.0):.3g} s"


def _counted(judged):
    """Return the numbers of checks that pass, warn and fail."""
    colours = [one.colour for one in judged]
    counts = [f"{colours.count(colour)} {WORDS[colour]}" for colour in RANK if colour in colours]
    return ", ".join(counts)
