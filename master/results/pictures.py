"""Pictures of one or several runs side by side, as the case file describes them. Units converted
here, at the edge.
"""

import textwrap
from collections.abc import Sequence
from itertools import cycle
from pathlib import Path

import numpy as np
from matplotlib.colors import LogNorm, Normalize
from matplotlib.ticker import LogLocator, MaxNLocator

from ..case.schema import reduced
from ..fmi.errors import BadInput
from ..fmi.quantities import one_micro, pint_unit, registry, to_si
from .coordinates import CRANK_ANGLE
from .figures import subplots
from .instants import instant, told

PALETTE = ("#1b4f8a", "#c8553d", "#3a7d44", "#8a6d1b", "#6b4c9a", "#1f8a8a", "#b0458a", "#5b6770")
PALETTE_DARK = (
    *("#7fb2ea", "#f0896f", "#7cc98a", "#d8b85a"),
    *("#b79be0", "#5cc8c8", "#e58cc4", "#a9b5bf"),
)
"""The same on a dark ground."""
WINDOW = "#3a7d44"
MOST_TICKED = 1440
"""Longest range of crank angle with a tick every 90 deg [deg]."""
LETTERS = 9
"""Of a title to an inch: a longer one goes on in a second line."""
WITH_PREFIX = ("m", "Pa", "N", "W", "J", "s", "m/s")
"""SI units that are shown with a prefix where the case does not say in what."""
MICRO = ("um", "urad", "us", "uN", "uW", "uJ", "um/s")
"""Units written without a micro sign, as a case file may."""


def draw(case, runs, folder, kind=None):
    """Draw every picture of the case that can be drawn of the runs.

    Parameters
    ----------
    case : Case
    runs : dict of str to Results
        Label -> results, all drawn into the same pictures.
    folder : Path
    kind : str, optional
        png, svg or pdf, in place of what the case's file names end with.

    Returns
    -------
    list of Path
        The files.
    """
    Path(folder).mkdir(parents=True, exist_ok=True)
    drawn = []
    for picture, figure in figures(case, runs):
        file = Path(folder) / picture.file
        drawn.append(file.with_suffix(f".{kind}") if kind else file)
        figure.savefig(drawn[-1], dpi=130)
    return drawn


def left_out(case, runs):
    """Why pictures of the case cannot be drawn of these runs: the picture's file -> a sentence."""
    reasons = {}
    for picture in case.pictures:
        for label, results in runs.items():
            lacking = [port for port in picture.fields if port not in results.recorded]
            if lacking:
                reasons[picture.file] = (
                    f"{label} has not recorded {', '.join(lacking)}; name it in record.fields"
                )
            elif picture.time and not _is_passed(results, picture.time):
                reasons[picture.file] = f"{label} does not come by {picture.time}"
    return reasons


def _is_passed(results, text):
    """Whether a run comes by an instant."""
    try:
        instant(results, text)
    except BadInput:
        return False
    return True


def figures(case, runs):
    """Yield every picture of the case that can be drawn of the runs, with its figure.

    `left_out` returns the reasons for the others.
    """
    without = left_out(case, runs)
    for picture in case.pictures:
        if picture.file in without:
            continue
        figure = DRAWN[picture.kind](case, picture, runs)
        width, _ = figure.get_size_inches()
        figure.suptitle(textwrap.fill(picture.title, int(LETTERS * width)))
        yield picture, figure


def scaled(values, unit: str, wanted: str | None):
    """`values` from SI `unit` in the unit the picture asks for, and its label."""
    shown = unit_shown(unit, wanted)
    if not wanted:
        return values, shown
    quantity = registry().Quantity(1.0, pint_unit(unit))
    return np.asarray(values) * quantity.to(wanted).magnitude, shown


def unit_shown(unit: str, wanted: str | None) -> str:
    """Label of the unit a picture asks for; the SI `unit` without one, nothing for pure numbers."""
    shown = wanted or ("" if unit == "1" else unit)
    return f"\N{MICRO SIGN}{shown[1:]}" if shown in MICRO else shown


def labelled(text: str, unit: str) -> str:
    """Text with a unit behind it, if there is one."""
    return f"{text} [{unit}]" if unit else text


ENDINGS = {
    "_m3_s": "m³/s",
    "_m_s": "m/s",
    "_nm": "N m",
    "_pa": "Pa",
    "_w": "W",
    "_j": "J",
    "_rad": "rad",
    "_n": "N",
    "_m": "m",
    "_s": "s",
}
"""How a summary's entries end that have a unit, and the unit."""


def entry_in_words(name: str) -> str:
    """A summary's entry in words: mean_friction_power_w -> "mean friction power [W]"."""
    for ending, unit in ENDINGS.items():
        if name.endswith(ending):
            return labelled(name.removesuffix(ending).replace("_", " "), unit)
    return name.replace("_", " ")


def entry_shown(name: str, values: Sequence[float]) -> tuple[str, np.ndarray]:
    """Return a summary entry in words with a unit that suits its values, and the values in it."""
    array = np.asarray(values, float)
    for ending, unit in ENDINGS.items():
        if name.endswith(ending):
            finite = np.abs(array[np.isfinite(array)])
            wanted = "deg" if unit == "rad" else handy_unit(unit, max(finite, default=0.0))
            shown, label = scaled(array, unit, wanted)
            return labelled(name.removesuffix(ending).replace("_", " "), label), shown
    return name.replace("_", " "), array


def handy_unit(unit: str, largest: float) -> str | None:
    """Unit of a size that suits a value in the SI `unit`, None where that is as good."""
    if unit not in WITH_PREFIX or not np.isfinite(largest) or largest == 0.0:
        return None
    compact = registry().Quantity(float(abs(largest)), unit).to_compact()
    return one_micro(f"{compact.units:~}").replace("\N{MICRO SIGN}", "u")


def name_of(port: str) -> str:
    """The variable of "participant.variable" in words, behind it the surface that it is of; of
    "time" just this.
    """
    *where, name = port.partition(".")[2].split(".")
    surface = f" ({', '.join(where)})" if where else ""
    return (name + surface).replace("_", " ") or port


def names_of(ports: Sequence[str]) -> dict[str, str]:
    """The same of several, with the participant's name where two would be called alike."""
    words = [name_of(port) for port in ports]
    owner = {port: port.partition(".")[0].replace("_", " ") for port in ports}
    return {
        port: f"{name}, {owner[port]}" if words.count(name) > 1 else name
        for port, name in zip(ports, words)
    }


def draw_lines(case, picture, runs):
    """One panel per entry of `y`; runs differ in colour, the variables of a panel in line style;
    windows are shaded. A way in a plane (a length over a length) is drawn to one scale.
    """
    first = next(iter(runs.values()))
    plane = all(first.series(port).unit == "m" for port in (picture.x, *sum(picture.y, [])))
    figure, panels = subplots(
        len(picture.y),
        1,
        sharex=True,
        squeeze=False,
        figsize=(11, 1.2 + (6.0 if plane else 2.3) * len(picture.y)),
    )
    x_unit = ""
    known: set[tuple[str, ...]] = set()
    for panel, ports in zip(panels[:, 0], picture.y):
        y_unit = ""
        ports = _not_zero(ports, runs)
        for colour, (label, results) in zip(cycle(PALETTE), runs.items()):
            x, si, _ = results.series(picture.x)
            x, x_unit = scaled(x, si, picture.units.get(picture.x))
            for style, port in zip(("-", "--", ":", "-."), ports):
                y, si, _ = results.series(port)
                y, y_unit = scaled(y, si, picture.units.get(port))
                name = label if len(ports) == 1 else f"{label}, {names_of(ports)[port]}"
                panel.plot(x, y, style, color=colour, lw=1.2, label=name)
        if plane:
            panel.set_aspect("equal")
        _shade(panel, windows_of(ports, case.window, picture.units, first))
        panel.set_ylabel(labelled(_common(ports), y_unit))
        panel.grid(alpha=0.3)
        panel.margins(x=0)
        shown = tuple(panel.get_legend_handles_labels()[1])
        if shown not in known:  # one legend for panels with the same curves
            panel.legend(
                fontsize="small", frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0)
            )
        known.add(shown)
    panels[-1, 0].set_xlabel(labelled(name_of(picture.x), x_unit))
    if picture.x.rpartition(".")[2] == CRANK_ANGLE and x_unit == "deg":
        _mark_dead_centres(panels[-1, 0].xaxis)
    return figure


def _not_zero(ports, runs):
    """Return the ports of a panel that are not zero in all runs, or all ports if all are zero."""
    return [
        port for port in ports if any(own.series(port).values.any() for own in runs.values())
    ] or ports


def _mark_dead_centres(axis):
    """Tick an axis of crank angles every 90 deg, or every 360 deg for many cycles."""
    low, high = axis.get_view_interval()
    step = 90 if high - low <= MOST_TICKED else 360
    ticks = (
        np.arange(np.ceil(low / step - 1e-6), np.floor(high / step + 1e-6) + 1) * step + 0.0
    )  # no -0
    words = {0: "\nTDC", 180: "\nBDC"}
    axis.set_ticks(ticks, [f"{tick:g}{words.get(tick % 360, '')}" for tick in ticks])


def windows_of(ports, window, units, results):
    """Limits of a panel's curves in the units shown, by the kind of value they are for."""
    limits = {}
    for text, pair in window.items():
        kind, port = reduced(text)
        if port in ports:
            si = results.series(port)[1]
            limits[kind] = tuple(scaled(to_si(v, si), si, units.get(port))[0] for v in pair)
    return limits


def _shade(panel, windows):
    """The ranges where a curve's lowest, highest, mean or last values are expected; equal ranges
    are shaded once.
    """
    words = {"min": "lowest", "max": "highest", "mean": "mean", "last": "last"}
    for limits in dict.fromkeys(windows.values()):
        kinds = " and ".join(words[kind] for kind, other in windows.items() if other == limits)
        panel.axhspan(
            *limits, color=WINDOW, alpha=0.16, lw=0, label=f"expected for the {kinds} value"
        )


def _common(ports):
    """The words that the variables' names share, or all names; of one variable its name."""
    words = [port.partition(".")[2].split("_") for port in ports]
    shared = [column[0] for column in zip(*words) if len(set(column)) == 1]
    return " ".join(shared) or ", ".join(name_of(port) for port in ports)


def draw_maps(case, picture, runs):
    """One row per field, one column per run, one colour scale per row; axes are what the case says
    the field's two indices run along.
    """
    figure, panels = subplots(
        len(picture.fields),
        len(runs),
        squeeze=False,
        figsize=(1.5 + 4.6 * len(runs), 1 + 3.1 * len(picture.fields)),
    )
    for row, port in zip(panels, picture.fields):
        shown = [results.field(port, instant(results, picture.time)) for results in runs.values()]
        wanted = picture.units.get(port)
        images = [
            where_there(scaled(field.values, field.unit, wanted)[0], results.there(port))
            for field, results in zip(shown, runs.values())
        ]
        unit = unit_shown(shown[0].unit, wanted)
        norm = colour_norm(images)
        axes = case.axes_of(port)
        for panel, (label, results), image, field in zip(row, runs.items(), images, shown):
            draw_map(panel, image, norm, axes)
            panel.set_title(f"{label}, {told(results, field.time)}", fontsize="medium")
        figure.colorbar(row[0].images[0], ax=list(row), label=labelled(name_of(port), unit))
    return figure


def where_there(image, there):
    """The cells that the field has; the others are masked, and stay blank."""
    return np.ma.array(image, mask=np.zeros(np.shape(image), bool) if there is None else ~there)


PRESSURES = ("Pa", "kPa", "MPa", "bar")
FLOOR = 1e-4
"""Logarithmic colours reach down to this share of the largest value."""
SPAN = 30.0
"""Ratio of two values above which a colour scale is logarithmic."""


def logarithmic(unit, low, high):
    """Whether the colours of a field over a whole run are logarithmic: pressures, wide ranges."""
    return high > 0 and ((unit in PRESSURES and low >= 0) or 0 < low < high / SPAN)


def colour_norm(images):
    """One colour scale for all images: logarithmic if the largest value exceeds `SPAN` times the
    median of the positive ones, as a single cell in contact does.
    """
    low = min(float(image.min()) for image in images)
    high = max(float(image.max()) for image in images)
    positive = np.concatenate([np.ma.compressed(image[image > 0]) for image in images])
    if low < 0 or not len(positive) or high <= SPAN * np.median(positive):
        return Normalize(low, high)
    return LogNorm(max(high * FLOOR, min(float(positive.min()), high / 2)), high, clip=True)


def draw_map(panel, image, norm, axes):
    """One field over its axes, interpolated; contours where there is something to contour. An axis
    that is a whole turn is closed: the first cell follows the last.
    """
    around, along = axes.first.positions(len(image)), axes.second.positions(len(image.T))
    left, right = axes.first.ends(len(image))
    if axes.first.centred is not None:
        cell = (right - left) / len(image)
        around = np.concatenate([[around[0] - cell], around, [around[-1] + cell]])
        image, left, right = image[np.r_[-1, : len(image), 0]], left - cell, right + cell
    panel.imshow(
        image.T,
        origin="lower",
        aspect="auto",
        extent=(left, right, *axes.second.ends(len(image.T))),
        norm=norm,
        cmap="viridis",
        interpolation="bilinear",
    )
    if image.min() < image.max():
        logs = isinstance(norm, LogNorm)
        locator = LogLocator(subs=(1, 3)) if logs else MaxNLocator(8)
        levels = [x for x in locator.tick_values(norm.vmin, norm.vmax) if norm.vmin < x < norm.vmax]
        if levels:
            drawn = panel.contour(around, along, image.T, levels, colors="white", linewidths=0.5)
            panel.clabel(drawn, fontsize=6, fmt="%.3g")
    panel.set_xlabel(axes.first.title)
    panel.set_ylabel(axes.second.title)
    _mark(panel.xaxis, axes.first)
    _mark(panel.yaxis, axes.second)
    panel.set_xlim(axes.first.range)


def _mark(drawn, axis):
    """Write an axis' marks beside its quarters."""
    if not axis.marks:
        return
    words = {position: f"\n{word}" for word, position in axis.marks.items()}
    positions = sorted({*np.linspace(axis.range[0], axis.range[1], 5).tolist(), *words})
    drawn.set_ticks(positions, [f"{x:g}{words.get(x, '')}" for x in positions])


def draw_sections(case, picture, runs):
    """One panel per field, runs in one panel: the field along its first index at one share of the
    second and one instant.
    """
    figure, panels = subplots(
        len(picture.fields),
        1,
        sharex=True,
        squeeze=False,
        figsize=(9, 1.2 + 2.6 * len(picture.fields)),
    )
    begin, end = (to_si(text, "rad") / (2 * np.pi) for text in picture.angles)
    axis = case.axes_of(picture.fields[0]).first
    for panel, port in zip(panels[:, 0], picture.fields):
        unit = ""
        for colour, (label, results) in zip(cycle(PALETTE), runs.items()):
            field = results.field(port, instant(results, picture.time))
            columns = field.values.shape[1]
            line = field.values[:, min(int(picture.height * columns), columns - 1)]
            line, unit = scaled(line, field.unit, picture.units.get(port))
            position = axis.positions(line.size)
            low, high = axis.range
            share = (position - low) / (high - low)
            inside = (share >= begin) & (share <= end)
            panel.plot(
                position[inside],
                line[inside],
                ".-",
                color=colour,
                lw=1.2,
                ms=4,
                label=f"{label}, {told(results, field.time)}",
            )
        panel.set_ylabel(labelled(name_of(port), unit))
        panel.grid(alpha=0.3)
    panels[0, 0].legend(fontsize="small", frameon=False)
    panels[-1, 0].set_xlabel(axis.marked)
    return figure


DRAWN = {"lines": draw_lines, "map": draw_maps, "section": draw_sections}
"""How each kind of picture is drawn: of the case, the picture and label -> Results."""
