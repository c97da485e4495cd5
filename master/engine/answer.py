"""What a run answers, for the first screen and the report: its lines and its verdicts."""

import re
from dataclasses import dataclass

import numpy as np

from ..case.schema import reduced
from ..fmi.quantities import short
from ..results.instants import crank_angle
from .headlines import Headline, headlines
from .verdicts import RANK, WORDS, Verdict, verdicts


@dataclass(frozen=True)
class Answer:
    """Lines that an engineer reads first, and every verdict."""

    lines: list[Headline]
    verdicts: list[Verdict]

    def said(self, name: str) -> str:
        """What the line of that name says, nothing without one."""
        return next((line.said for line in self.lines if line.name == name), "")


def answer(case, results) -> Answer:
    """The answer of a finished run: of a piston on its film the lines of `headlines`, of any other
    case the entries of its own summary; how far it went, and how many verdicts are good.

    Parameters
    ----------
    case : Case
    results : Results
    """
    lines = headlines(case, results) or _own_summary(case, results)
    judged = verdicts(case, results)
    if settled := _settled(results):
        lines.append(Headline("settled", settled))
    lines.append(Headline("computed", _computed(results.whole)))
    if judged:
        lines.append(Headline("checks", _counted(judged)))
    return Answer(lines, judged)


def _own_summary(case, results):
    """The case's summary entries."""
    summary = results.summary or {}
    return [
        _in_words(name, text, summary[name], results)
        for name, text in case.summary.items()
        if name in summary
    ]


def _in_words(name, text, value, results):
    """An entry with its unit, which its name need not say then; a bare number where it is not that
    of an output.
    """
    port = reduced(text).port
    if port not in results.ports:
        return Headline(name.replace("_", " "), f"{value:.6g}")
    unit = results.series(port).unit
    spelt = "_" + re.sub(r"\W+", "_", unit).lower()
    return Headline(name.removesuffix(spelt).replace("_", " "), short(value, unit, 4))


def _settled(results):
    """How far the last period is from the one before; nothing of a run without periods."""
    summary = results.summary or {}
    if "settled" not in summary:
        return ""
    count = summary["periods"]
    if count < 2:
        return "not known: fewer than two periods were run"
    apart = f"last period differs from the one before by {summary['period_distance']:.2g}"
    return f"{'' if summary['periodic'] else 'no: '}{apart}"


def _computed(results):
    """How far the run went, in how many periods, and how long it took."""
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
        reach += f", {summary['periods']} periods,"
    return f"{reach} in {steps} steps, {summary.get('wall_time_s', 0.0):.3g} s"


def _counted(judged):
    """How many passed, warn and failed."""
    colours = [one.colour for one in judged]
    counts = [f"{colours.count(colour)} {WORDS[colour]}" for colour in RANK if colour in colours]
    return ", ".join(counts)
