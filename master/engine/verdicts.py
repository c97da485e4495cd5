"""Checks of a finished run against limits, with the positions of the extreme values."""

from functools import partial
from itertools import chain
from typing import Any, Literal, NamedTuple

import numpy as np

from ..case.contract import players
from ..fmi.quantities import short
from ..results.file import Results
from ..results.instants import instant_text
from .indicator import bdf2_error
from .measures import Measures
from .peaks import peak_width, run_length
from .places import film_body, parameter

LAMBDA_AMBER, LAMBDA_RED = 3.0, 1.0
"""Minimum film thickness over composite roughness: asperities touch below 3 and carry below 1."""
PRESSURE_LIMITS = 50e6, 100e6
"""Film pressure [Pa]: half and all of what a hot aluminium skirt withstands, an assumption."""
TRUNCATION_LIMITS = 0.02, 0.1
"""Truncation error over film thickness, whose cube is the film's conductance (decision 15)."""
ODD_PART = TRUNCATION_LIMITS[0], TRUNCATION_LIMITS[0]
"""Odd part of the film over film thickness, if modes assume a symmetric film."""
WORK_LIMITS = 1e-3, 1e-2
"""Relative difference of the interface work between both participants."""
SPURIOUS_STEP = 0.05
"""Spurious energy of an accepted step over the energy exchanged in it: half the rejection limit."""
SPURIOUS_LIMITS = 1e-3, 1e-2
"""Spurious energy over the energy exchanged over the run, an assumption as for `WORK_LIMITS`."""
SIDE_FORCE = 0.25, 0.75
"""Rms difference of side force and side-force demand over a period, relative to the rms demand."""
PEAK_CELLS = 4, 2
"""Cells across the pressure peak at half its height: the nearest centre misses the top of a
parabola by up to 1/(2 n^2) of it, 3 % with 4 cells and 12 % with 2."""
FULL_CELLS = 10
"""Minimum length of the full film along the axis in cells, where cavities limit it: a load on a
thin layer is 2 % low with 12 cells (docs/measurements/limits.md)."""
LEAST_OPENING_CELLS = 3
"""Minimum width of an opening in cells, for which its edges are accurate to half of the width."""
PLAY_LIMITS = 0.02, 0.1
"""Estimated error in time of the play of a pin over its range, as for `TRUNCATION_LIMITS`."""
MEMORY_STEPS = 4
"""Steps whose local errors add up in a film: the largest error of `floating_pin` at 1 deg is 0.8 to
3.7 of the largest local one (docs/measurements/floating_pin.md)."""
LEAST_PERCENT = 1e-5
"""Share below which only this bound is displayed."""
RIGID = (
    " A rigid skirt does not yield, so it overstates the pressure. Make it flexible: "
    "`piston-cosim new --piston slipper`, or a mesh and modes in build.piston."
)
"""Sentences of the pressure check for a rigid piston."""
PLAYS = ("pin_displacement", "small_end_displacement")
"""Outputs of bodies with a floating pin, without the axis."""


Colour = Literal["green", "amber", "red"]
RANK: tuple[Colour, ...] = ("green", "amber", "red")
"""Colours from best to worst."""
WORDS: dict[Colour, str] = {"green": "pass", "amber": "warning", "red": "fail"}
"""Displayed result of a check."""


class Verdict(NamedTuple):
    """Check: its colour, its name, and a sentence with value and limit."""

    colour: Colour
    what: str
    text: str

    @property
    def outcome(self) -> str:
        """Result of the check: pass, warning or fail."""
        return WORDS[self.colour]


def verdicts(results: Results, table: Measures) -> list[Verdict]:
    """Return the checks of the last period of a finished run, whose measures are `table`.

    Missing outputs are not checked.
    """
    results = results.last
    summary = results.summary or {}
    all_verdicts = [*_of_summary(summary), *_of_conjugates(results.case), *_of_truncation(summary)]
    all_verdicts += _of_each(results, "lubrication", partial(_of_film, table), _of_grid)
    all_verdicts += _of_each(results, "bodies", _of_side_force)
    all_verdicts += _of_each(results, "bodies", _of_play)
    if "settled" in summary:
        colour = "green" if summary["periodic"] else "amber"
        all_verdicts.append(Verdict(colour, "periodicity", f"{summary['settled']}."))
    return all_verdicts


def _of_each(results, role, *judges):
    """Yield the checks of every film or piston, with its name if there are several."""
    names = players(results.case, role)
    for name in names:
        of = f" of {name}" if len(names) > 1 else ""
        for one in chain(*(judge(results, name) for judge in judges)):
            yield one._replace(what=f"{one.what}{of}")


def _colour(value, amber, red) -> Colour:
    """Return green up to `amber`, amber up to `red`, and red above it or for NaN."""
    if value <= amber:
        return "green"
    return "amber" if value <= red else "red"


def _percent(share):
    """Return a fraction in percent."""
    return "<0.001 %" if 0.0 < share < LEAST_PERCENT else f"{100 * share:.2g} %"


def _share(what, share, limits, text) -> Verdict:
    """Return the check of a fraction; `text` has {} for it and for its limit."""
    return Verdict(_colour(share, *limits), what, text.format(_percent(share), _percent(limits[0])))


def _of_summary(summary):
    """Yield the checks of convergence and energy."""
    if "unconverged_steps" in summary:
        count = summary["unconverged_steps"]
        steps = summary.get("steps", 0)
        unsettled = summary.get("unsettled_steps", 0)
        colour = "red" if count else "amber" if unsettled else "green"
        text = f"{count} of {steps} macro steps did not converge."
        text += f" {unsettled} held a discrete value that does not settle." if unsettled else ""
        yield Verdict(colour, "convergence", text)
    if "interface_work_imbalance" in summary:
        text = "The interface work of both participants differs by {} (limit {})."
        yield _share("interface work", abs(summary["interface_work_imbalance"]), WORK_LIMITS, text)
    if "energy_refused_steps" in summary:
        yield _of_ledger(summary)


def _of_ledger(summary):
    """Return the check of spurious energy, in a step and over the run.

    Eq. (X16):  made = sum over participants of E_i / max |E_i|,   E_i: energy received over the run

    It is negative by dissipation that an energy balance omits, as of the time integrator.
    """
    count = summary["energy_refused_steps"]
    share = max(summary["energy_created_share_max"], 0.0)
    taken = [value for key, value in summary.items() if key.startswith("energy_taken_")]
    whole = max(map(abs, taken), default=0.0)
    created = sum(taken) / whole if whole > 0.0 else 0.0  # Eq. (X16)
    colour = _colour(created, *SPURIOUS_LIMITS)
    if colour == "green" and (count or share > SPURIOUS_STEP):
        colour = "amber"
    return Verdict(
        colour,
        "energy balance",
        f"The spurious energy over the run is {_percent(max(created, 0.0))} of the energy "
        f"exchanged (limit {_percent(SPURIOUS_LIMITS[0])}). In an accepted step it is at most "
        f"{_percent(share)} (limit {_percent(SPURIOUS_STEP)}). The run rejected and halved "
        f"{count} steps.",
    )


def _of_conjugates(tree):
    """Warn if films and bodies have no energy balance, because no wire has a conjugate."""
    films = players(tree, "lubrication")
    coupled = films and players(tree, "bodies")
    if coupled and not any("conjugate" in wire for wire in tree["wires"]):
        yield Verdict(
            "amber",
            "energy balance",
            "The run has no energy balance, because no wire has a conjugate. Add conjugate, e.g. "
            f'"{films[0]}.nodal_pressure_force" to the wire of film_thickness.',
        )


def _of_truncation(summary):
    """Yield the check of the truncation error of the flexible bodies."""
    if why := summary.get("truncation_error"):
        yield Verdict("amber", "truncation", f"The truncation error of the modes is {why}.")
    bodies = [body for body in ("piston", "block") if f"truncation_error_{body}" in summary]
    if not bodies:
        return
    shares = " and ".join(
        f"{_percent(summary[f'truncation_error_{body}'])} of the {body} deflection"
        for body in bodies
    )
    text = "The truncation error of the modes is"
    share = summary.get("truncation_error_film")
    if share is None:
        hint = "Record film_thickness of the bodies (record.fields) to compare it with the film"
        yield Verdict("amber", "truncation", f"{text} {shares}. {hint} thickness.")
        return
    text += f" at most {{}} of the local film thickness (limit {{}}). It is {shares}."
    if share > TRUNCATION_LIMITS[0]:
        text += f" Increase {' and '.join(f'{one}.modes' for one in bodies)}."
    if (edge := summary.get("truncation_error_edge")) is not None:
        narrow = "Under a narrow patch at an edge of the skirt"
        text += f" {narrow}, the modes miss up to {_percent(edge)}."
    yield _share("truncation", share, TRUNCATION_LIMITS, text)
    if (odd := summary.get("odd_part_film")) is not None:
        text = "The odd part of the film about the thrust plane is at most {} of the local film "
        text += "thickness (limit {}). The modes assume a symmetric film."
        yield _share("symmetry", odd, ODD_PART, text)


def _of_film(table, results, name):
    """Yield the checks of film thickness and pressure of a lubrication participant."""
    if thinnest := table.of("minimum_film_thickness_m", name):
        film = f"The minimum film thickness is {_located(results, thinnest, 'm')}"
        rough = parameter(results, name, "roughness_rms", "m")
        if rough > 0.0:
            ratio = thinnest.value / rough
            colour = _colour(-ratio, -LAMBDA_AMBER, -LAMBDA_RED)
            film += f", {ratio:.3g} times the roughness (limit {LAMBDA_AMBER:g})"
        else:
            colour = "red" if thinnest.value <= 0.0 else "green"
        yield Verdict(colour, "film", f"{film}.{_clause(thinnest)}")
    # the limit applies to skirts, and only bearings have a friction torque
    highest = table.of("maximum_pressure_pa", name)
    if highest and f"{name}.friction_torque" not in results.ports:
        colour = _colour(highest.value, *PRESSURE_LIMITS)
        film = f"The maximum pressure is {_located(results, highest, 'Pa')}"
        film += f" (limit {short(PRESSURE_LIMITS[0], 'Pa')}).{_clause(highest)}"
        if colour != "green" and _is_rigid(results, film_body(results, name)):
            film += RIGID
        yield Verdict(colour, "pressure", film)


def _located(results, measure, unit):
    """Return the value of a measure with its instant."""
    return f"{short(measure.value, unit)} at {instant_text(results, results.time[measure.row])}"


def _clause(measure):
    """Return a sentence about the position of a measure, "" if it is unknown."""
    return measure.place.clause if measure.place else ""


def _is_rigid(results, body):
    """Return whether the piston of a participant has no modes; False if it is unknown."""
    build = results.case["participants"].get(body, {}).get("build", {})
    piston = build.get("piston", {})
    return "rigid" in piston or piston.get("modes") == 0


def _of_grid(results, name):
    """Yield the check of the grid: it must resolve pressure peak, openings and thrust lines."""
    port = f"{name}.pressure"
    if port not in results.recorded:
        return
    pressure = results.dataset(port)[:]
    instant, *cell = np.unravel_index(pressure.argmax(), pressure.shape)
    widths = peak_width(pressure[instant], cell)
    remarks = [
        f"The pressure peak spans {_cells(widths.around)} around and {widths.along} along at half "
        f"its height (minimum {PEAK_CELLS[0]})"
    ]
    colours: list[Colour] = [_colour(-min(widths), -PEAK_CELLS[0], -PEAK_CELLS[1])]
    around, _ = pressure.shape[1:]
    if around % 2:
        colours.append("amber")
        remarks.append(
            f"The grid has no cell on the anti-thrust line, because {around} cells around are odd"
        )
    fraction = f"{name}.film_fraction"
    if fraction in results.recorded:
        fractions = results.dataset(fraction)[:]
        row = fractions[instant, cell[0]]
        full = row >= 1.0
        length = run_length(full[cell[1] :]) + run_length(full[: cell[1] + 1][::-1]) - 1
        if not full[[0, -1]].any() and 0 < length < FULL_CELLS:
            colours.append("amber")
            remarks.append(
                f"The full film at the peak is {length} cells long (minimum {FULL_CELLS})"
            )
        closed = without_film(pressure, fractions)
        thin = narrowest_opening(closed)
        if thin and thin < LEAST_OPENING_CELLS:
            colours.append("amber")
            remarks.append(
                f"An opening in the film is {_cells(thin)} wide (minimum {LEAST_OPENING_CELLS})"
            )
    yield Verdict(max(colours, key=RANK.index), "grid", " ".join(f"{one}." for one in remarks))


def _cells(count):
    """Return a number of cells in words."""
    return f"{count} cell{'' if count == 1 else 's'}"


def without_film(pressure: np.ndarray, fraction: np.ndarray) -> np.ndarray:
    """Return the cells with constant pressure and film fraction, as in openings of the skirt."""
    still = np.ptp(pressure, axis=0) == 0.0
    return still & (np.ptp(fraction, axis=0) == 0.0)


def narrowest_opening(closed: np.ndarray) -> int:
    """Return the largest width in cells of the narrowest opening, 0 if there is none."""
    if not closed.any():
        return 0
    from scipy import ndimage  # slow to import, and most films have no opening

    pieces: Any = ndimage.label(np.concatenate([closed, closed]))  # twice around the ring
    numbered, count = pieces
    widths = {k: int((numbered == k).sum(axis=0).max()) for k in range(1, count + 1)}
    # each opening that an end cuts also exists as a whole
    ends = {*np.unique(numbered[0]).tolist(), *np.unique(numbered[-1]).tolist()}
    return min((width for k, width in widths.items() if k not in ends), default=0)


def _of_side_force(results, name):
    """Yield the check of side force against its demand. Both differ if the piston strikes."""
    force, demand = f"{name}.side_force", f"{name}.side_force_demand"
    if not {force, demand} <= {*results.ports}:
        return
    actual, asked = (results.series(port).values for port in (force, demand))
    size = float(np.sqrt(np.mean(asked**2)))
    if not size > 0.0:
        return
    deviation = float(np.sqrt(np.mean((actual - asked) ** 2))) / size
    text = "The side force differs from the side-force demand by {} rms (limit {})."
    yield _share("side force", deviation, SIDE_FORCE, text)


def _of_play(results, name):
    """Yield the check of the play of a floating pin, which BDF2 integrates."""
    ports = [f"{name}.{play}_{axis}" for play in PLAYS for axis in "xy"]
    if not {*ports} <= {*results.ports} or len(results.time) < 4:
        return
    error = size = 0.0
    for port in ports:
        play = results.series(port).values
        error = max(error, MEMORY_STEPS * float(np.abs(bdf2_error(results.time, play)).max()))
        size = max(size, float(np.ptp(play)))
    if size > 0.0:
        text = f"The estimated error of the play due to the step is at most {short(error, 'm')}, "
        text += f"{{}} of the range of {short(size, 'm')} (limit {{}})."
        yield _share("play of the pin", error / size, PLAY_LIMITS, text)
