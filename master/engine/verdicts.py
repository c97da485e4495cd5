"""A finished run as an engineer reads it: what is amber or red, and where the worst places lie."""

from typing import Literal, NamedTuple

import numpy as np

from ..case.contract import players
from ..fmi.quantities import short, to_si
from ..results.instants import crank_angle, told

LAMBDA_AMBER, LAMBDA_RED = 3.0, 1.0
"""Thinnest film over composite roughness: below 3 asperities begin to touch, below 1 they carry."""
PRESSURE_AMBER, PRESSURE_RED = 50e6, 100e6
"""Film pressure [Pa], by what a hot aluminium skirt bears: our own choice, half of it and all."""
APART_AMBER, APART_RED = 0.02, 0.1
"""Distance of the last cycle from the one before, root mean square over its range."""
CYCLE = 4 * np.pi
"""Of a four-stroke engine [rad]."""
WORK_AMBER, WORK_RED = 1e-3, 1e-2
"""Of the interface work: by how much both sides' accounts of it may differ."""


class Verdict(NamedTuple):
    """One judgement: its colour, what is judged, and a sentence with value and limit."""

    colour: Literal["green", "amber", "red"]
    what: str
    said: str


def verdicts(case, results) -> list[Verdict]:
    """Judge a finished run; what it does not say is not judged.

    Parameters
    ----------
    case : Case
    results : Results
    """
    summary = results.summary or {}
    found = [*_of_summary(summary)]
    for name in players(results.case, "lubrication"):
        found += _of_film(case, results, name)
    if "periodic" in summary:
        return [*found, _of_repetition(summary)]
    for name in players(results.case, "bodies"):
        found += _of_cycle(results, name)
    return found


def _colour(value, amber, red):
    """Green up to `amber`, red above `red`; one that is no number is red."""
    if value <= amber:
        return "green"
    return "amber" if value <= red else "red"


def _of_summary(summary):
    """Convergence, and the account of the interface work."""
    if "unconverged_steps" in summary:
        count = summary["unconverged_steps"]
        steps = summary.get("steps", 0)
        colour = "red" if count else "green"
        yield Verdict(colour, "convergence", f"{count} of {steps} macro steps did not converge")
    if "interface_work_imbalance" in summary:
        share = abs(summary["interface_work_imbalance"])
        yield Verdict(
            _colour(share, WORK_AMBER, WORK_RED),
            "energy",
            f"both sides' interface work differs by {share:.2g} of it, allowed {WORK_AMBER:g}",
        )


def _of_repetition(summary):
    """Of a run that repeated its cycle until it was periodic, or had to stop before."""
    count = summary["cycles"]
    said = f"after {count} cycles the last is {summary['cycle_distance']:.2g} from the one before"
    return Verdict("green" if summary["periodic"] else "amber", "periodic", said)


def _of_film(case, results, name):
    """Film and pressure of a participant in the role `lubrication`."""
    thinnest, highest = f"{name}.minimum_film_thickness", f"{name}.maximum_pressure"
    given = results.case["participants"][name].get("parameters", {})
    if thinnest in results.ports:
        values = results.series(thinnest).values
        k = int(values.argmin())
        film = f"thinnest film {short(values[k], 'm')} at {told(results, results.time[k])}"
        rough = to_si(given.get("roughness_rms", "0 m"), "m")
        if rough > 0.0:
            ratio = values[k] / rough
            colour = "red" if ratio < LAMBDA_RED else "amber" if ratio < LAMBDA_AMBER else "green"
            film += f", {ratio:.3g} times the roughness, wanted {LAMBDA_AMBER:g}"
        else:
            colour = "red" if values[k] <= 0.0 else "green"
        place = worst_place(case, results, _film_field(results), lowest=True)
        yield Verdict(colour, "film", f"{film}{place}")
    if highest in results.ports:
        values = results.series(highest).values
        k = int(values.argmax())
        place = worst_place(case, results, f"{name}.pressure", lowest=False)
        yield Verdict(
            _colour(values[k], PRESSURE_AMBER, PRESSURE_RED),
            "pressure",
            f"highest pressure {short(values[k], 'Pa')} at {told(results, results.time[k])}, "
            f"allowed {short(PRESSURE_AMBER, 'Pa')}{place}",
        )


def _film_field(results):
    """Film thickness as the bodies give it."""
    names = players(results.case, "bodies")
    return f"{names[0]}.film_thickness" if names else ""


def worst_place(case, results, port, lowest):
    """Where a recorded field has its smallest or largest value, as a clause with side, angle and
    height; empty where it was not recorded.
    """
    if port not in results.recorded:
        return ""
    values = results.dataset(port)[:]
    at = values.argmin() if lowest else values.argmax()
    k, i, j = np.unravel_index(at, values.shape)
    axes = case.axes_of(port)
    around = float(axes.first.positions(values.shape[1])[i])
    along = float(axes.second.positions(values.shape[2])[j])
    low, high = axes.first.range
    turn = high - low
    marks = axes.first.marks
    apart = {word: abs((around - at + turn / 2) % turn - turn / 2) for word, at in marks.items()}
    side = f"{min(apart, key=lambda word: apart[word])} side, " if apart else ""
    return (
        f"; of the recorded fields' instants worst at {told(results, results.instants[k])}: {side}"
        f"{axes.first.label} {around:.4g} {axes.first.unit}, "
        f"{axes.second.label} {along:.3g} {axes.second.unit}".rstrip()
    )


def _of_cycle(results, name):
    """How far the last cycle is from the one before."""
    crank = crank_angle(results)
    port = f"{name}.lateral_displacement"
    if crank is None or port not in results.ports:
        return
    first, *_, last = crank.angle
    if last - first < CYCLE * (2 - 1e-6):
        yield Verdict(
            "amber",
            "periodic",
            f"{np.degrees(last - first):.4g} deg computed: whether the cycle repeats shows from "
            f"{np.degrees(2 * CYCLE):g} deg on",
        )
        return
    values = results.series(port).values
    here = np.linspace(last - CYCLE, last, 721)
    now = np.interp(here, crank.angle, values)
    before = np.interp(here - CYCLE, crank.angle, values)
    apart = float(np.sqrt(np.mean((now - before) ** 2)) / max(np.ptp(now), 1e-12))
    yield Verdict(
        _colour(apart, APART_AMBER, APART_RED),
        "periodic",
        f"lateral displacement of the last cycle is {apart:.2g} of its range from the one before, "
        f"allowed {APART_AMBER:g}",
    )
