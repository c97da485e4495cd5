"""A finished run as an engineer reads it: what is amber or red, and where the worst places lie."""

from typing import Any, Literal, NamedTuple

import numpy as np

from ..case.contract import players
from ..fmi.quantities import short, to_si
from ..results.instants import told
from .places import thinnest_place, worst_place

LAMBDA_AMBER, LAMBDA_RED = 3.0, 1.0
"""Thinnest film over composite roughness: below 3 asperities begin to touch, below 1 they carry."""
PRESSURE_AMBER, PRESSURE_RED = 50e6, 100e6
"""Film pressure [Pa], by what a hot aluminium skirt bears: our own choice, half of it and all."""
TRUNCATION_AMBER, TRUNCATION_RED = 0.02, 0.1
"""Missing gap over film thickness: its cube is the film's conductance (decision 15)."""
WORK_AMBER, WORK_RED = 1e-3, 1e-2
"""Of the interface work: by how much both sides' accounts of it may differ."""
SHARE_AMBER = 0.05
"""Of what passed in a step: energy that an accepted one made. Half of what is refused."""
MADE_AMBER, MADE_RED = 1e-3, 1e-2
"""Of what was exchanged over the run: energy that came from nowhere, as `WORK_AMBER`: our own
choice."""


FORCE_AMBER, FORCE_RED = 0.25, 0.75
"""Distance of the side force from what gas and inertia ask for, root mean square over a cycle of
the latter's."""
PEAK_AMBER, PEAK_RED = 4, 2
"""Cells across the pressure peak at half its height: the nearest centre misses the top of a
parabola by up to 1/(2 n^2) of it, 3 % with 4 cells and 12 % with 2."""
OPENING = 3
"""Cells that an opening in the skirt is wide at least, for its edges to lie within half of them."""


Colour = Literal["green", "amber", "red"]
RANK: tuple[Colour, ...] = ("green", "amber", "red")
"""From good to bad."""
WORDS: dict[Colour, str] = {"green": "pass", "amber": "warning", "red": "fail"}
"""Outcome of a check, as it is shown."""


class Verdict(NamedTuple):
    """One judgement: its colour, what is judged, and a sentence with value and limit."""

    colour: Colour
    what: str
    said: str

    @property
    def outcome(self) -> str:
        """The colour in words: pass, warning or fail."""
        return WORDS[self.colour]


def verdicts(case, results) -> list[Verdict]:
    """Judge the last period of a finished run; what it does not say is not judged.

    Parameters
    ----------
    case : Case
    results : Results
    """
    results = results.last
    summary = results.summary or {}
    found = [*_of_summary(summary), *_of_truncation(summary)]
    films = players(results.case, "lubrication")
    for name in films:
        own = [*_of_film(case, results, name), *_of_grid(case, results, name)]
        of = f" of {name}" if len(films) > 1 else ""
        found += [one._replace(what=f"{one.what}{of}") for one in own]
    found += _of_each(results, _of_side_force)
    if "settled" in summary:
        colour = "green" if summary["periodic"] else "amber"
        found.append(Verdict(colour, "settled", summary["settled"]))
    return found


def _of_each(results, judge):
    """Verdicts on every piston, named after its participant where there are several."""
    names = players(results.case, "bodies")
    for name in names:
        of = f" of {name}" if len(names) > 1 else ""
        for one in judge(results, name):
            yield one._replace(what=f"{one.what}{of}")


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
    if "energy_refused_steps" in summary:
        yield _of_ledger(summary)


def _of_ledger(summary):
    """Energy from nowhere: in a step, and over the run.

    Eq. (X16):  made = sum over participants of E_i / max |E_i|     E_i: what each took over the run

    Heat that no account counts makes it negative in a right run.
    """
    count = summary["energy_refused_steps"]
    share = max(summary["energy_created_share_max"], 0.0)
    taken = [value for key, value in summary.items() if key.startswith("energy_taken_")]
    whole = max(map(abs, taken), default=0.0)
    made = sum(taken) / whole if whole > 0.0 else 0.0  # Eq. (X16)
    colour = _colour(made, MADE_AMBER, MADE_RED)
    if colour == "green" and (count or share > SHARE_AMBER):
        colour = "amber"
    return Verdict(
        colour,
        "energy ledger",
        f"{count} steps in which energy came from nowhere were refused and halved; of the accepted "
        f"ones none made more than {share:.2g} of what passed to and fro, allowed {SHARE_AMBER:g}; "
        f"over the run {max(made, 0.0):.2g} of what was exchanged, allowed {MADE_AMBER:g}",
    )


def _of_truncation(summary):
    """What the flexible bodies' modes leave out of the gap, by the film thickness."""
    bodies = [body for body in ("piston", "block") if f"truncation_error_{body}" in summary]
    if not bodies:
        return
    shares = " and ".join(f"{summary[f'truncation_error_{body}']:.2g} ({body})" for body in bodies)
    share = summary.get("truncation_error_film")
    if share is None:
        yield Verdict(
            "amber",
            "truncation",
            f"the modes miss {shares} of the deflection over the run; record film_thickness of the "
            "bodies (record.fields) to compare the missing gap with it",
        )
        return
    colour = _colour(share, TRUNCATION_AMBER, TRUNCATION_RED)
    keys = " and ".join(f"{one}.modes" for one in bodies)
    hint = "" if colour == "green" else f"; increase {keys}"
    yield Verdict(
        colour,
        "truncation",
        f"the modes miss at most {share:.2g} of the local film thickness at any recorded instant, "
        f"allowed {TRUNCATION_AMBER:g}; {shares} of the deflection over the run"
        f"{hint}",
    )


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
        place = thinnest_place(case, results, name)
        yield Verdict(colour, "film", f"{film}{place.clause if place else ''}")
    # the limit is that of a skirt: a bearing, which tells its torque, has none here
    if highest in results.ports and f"{name}.friction_torque" not in results.ports:
        values = results.series(highest).values
        k = int(values.argmax())
        place = worst_place(case, results, f"{name}.pressure", lowest=False)
        yield Verdict(
            _colour(values[k], PRESSURE_AMBER, PRESSURE_RED),
            "pressure",
            f"highest pressure {short(values[k], 'Pa')} at {told(results, results.time[k])}, "
            f"allowed {short(PRESSURE_AMBER, 'Pa')}{place.clause if place else ''}",
        )


def _of_grid(case, results, name):
    """Whether the cells can show what was found: pressure peak, openings, both thrust lines."""
    port = f"{name}.pressure"
    peak = worst_place(case, results, port, lowest=False)
    if peak is None:
        return
    pressure = results.dataset(port)[:]
    widths = peak_width(pressure[peak.row], peak.index)
    narrow = min(widths)
    remarks = [
        f"the pressure peak is {widths.around} cells around and {widths.along} along at half its "
        f"height, wanted {PEAK_AMBER}"
    ]
    colours: list[Colour] = [
        "red" if narrow < PEAK_RED else "amber" if narrow < PEAK_AMBER else "green"
    ]
    around, _ = pressure.shape[1:]
    if around % 2:
        colours.append("amber")
        remarks.append(
            f"{around} cells around: of an odd number none has its centre on the anti-thrust line"
        )
    fraction = f"{name}.film_fraction"
    if fraction in results.recorded:
        closed = without_film(pressure, results.dataset(fraction)[:])
        thin = narrowest_opening(closed)
        if thin and thin < OPENING:
            colours.append("amber")
            cells = "cell" if thin == 1 else "cells"
            remarks.append(f"an opening in the film is {thin} {cells} wide, wanted {OPENING}")
    yield Verdict(max(colours, key=RANK.index), "grid", "; ".join(remarks))


class Widths(NamedTuple):
    """Cells across a peak."""

    around: int
    along: int


def peak_width(field: np.ndarray, index: tuple[int, int]) -> Widths:
    """Cells beside one another that hold at least half of the value at `index`, around (a ring) and
    along.
    """
    i, j = index
    high = field >= field[i, j] / 2
    ring = np.roll(high[:, j], -i)
    line = high[i]
    around = len(ring) if ring.all() else _run(ring) + _run(ring[::-1])
    return Widths(around, _run(line[j:]) + _run(line[: j + 1][::-1]) - 1)


def _run(flags):
    """True values in front of the first false one."""
    return len(flags) if flags.all() else int(np.argmin(flags))


def without_film(pressure: np.ndarray, fraction: np.ndarray) -> np.ndarray:
    """Cells whose pressure and film fraction never change: openings in the skirt hold those of what
    is around it.
    """
    still = np.ptp(pressure, axis=0) == 0.0
    return still & (np.ptp(fraction, axis=0) == 0.0)


def narrowest_opening(closed: np.ndarray) -> int:
    """Cells around of the widest place of the narrowest opening, 0 without one."""
    if not closed.any():
        return 0
    from scipy import ndimage  # slow to import, and most films have no opening

    pieces: Any = ndimage.label(np.concatenate([closed, closed]))  # of a ring: turned twice
    numbered, count = pieces
    widths = {k: int((numbered == k).sum(axis=0).max()) for k in range(1, count + 1)}
    # what is cut off at either end is there as a whole, too
    ends = {*np.unique(numbered[0]).tolist(), *np.unique(numbered[-1]).tolist()}
    return min((width for k, width in widths.items() if k not in ends), default=0)


def _of_side_force(results, name):
    """Side force beside what gas and inertia ask for: a piston that strikes has both apart."""
    force, demand = f"{name}.side_force", f"{name}.side_force_demand"
    if not {force, demand} <= {*results.ports}:
        return
    found, asked = (results.series(port).values for port in (force, demand))
    size = float(np.sqrt(np.mean(asked**2)))
    if not size > 0.0:
        return
    apart = float(np.sqrt(np.mean((found - asked) ** 2))) / size
    yield Verdict(
        _colour(apart, FORCE_AMBER, FORCE_RED),
        "side force",
        f"side force is {apart:.2g} of what gas and inertia ask for away from it, root mean square "
        f"over the period, allowed {FORCE_AMBER:g}",
    )
