"""Pictures of one or several runs, as the case file describes them; converts units."""

import textwrap
from collections.abc import Sequence
from itertools import cycle
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib import rc_context
from matplotlib.colors import LogNorm, Normalize
from matplotlib.ticker import LogLocator, MaxNLocator

from ..case.shown import ENVELOPE
from ..case.tables import reduced
from ..fmi.errors import BadInput
from ..fmi.quantities import from_si, one_micro, registry, to_si
from .coordinates import CRANK_ANGLE
from .figures import (
    COLOURS,
    PALETTE,
    PAPER,
    PAPER_RESOLUTION,
    PAPER_SCALE,
    RESOLUTION,
    add_legend,
    save,
    stack,
    subplots,
)
from .instants import instant, instant_text

PALETTE_DARK = ("#2f8fd0", "#f27d33", "#12c494", "#e59ac4", "#f2c14e", "#a6d8f7", "#e8ecef")
"""Lighter colours for a dark background."""
WINDOW = "#009e73"
MOST_TICKED = 1440
"""Longest range of crank angle with a tick every 90 deg [deg]."""
LETTERS = 9
"""Number of letters per inch of a title; longer titles have a second line."""
WITH_PREFIX = ("m", "Pa", "N", "W", "J", "s", "m/s")
"""SI units that are shown with a prefix by default."""
MICRO = ("um", "urad", "us", "uN", "uW", "uJ", "um/s")
"""Units without a micro sign, as in a case file."""


def draw(case, runs, folder, kind=None, paper=False):
    """Draw every picture of the case that the runs have data for.

    Parameters
    ----------
    case : Case
    runs : dict of str to Results
        Label -> results, all drawn into the same pictures.
    folder : Path
    kind : str, optional
        png, svg or pdf. Default: the suffix of the case's file names.
    paper : bool
        Whether the pictures have the size and fonts of a publication, and no title.

    Returns
    -------
    list of Path
        The files.
    """
    Path(folder).mkdir(parents=True, exist_ok=True)
    drawn = []
    with rc_context(PAPER if paper else None):
        for picture, figure in figures(case, runs):
            file = Path(folder) / picture.file
            if paper:
                figure.suptitle("")
                figure.set_size_inches(PAPER_SCALE * figure.get_size_inches())
            file = file.with_suffix(f".{kind}") if kind else file
            drawn.append(save(figure, file, PAPER_RESOLUTION if paper else RESOLUTION))
    return drawn


def left_out(case, runs):
    """Return why pictures of the case cannot be drawn: file of the picture -> sentence."""
    reasons = {}
    for picture in case.pictures:
        for label, results in runs.items():
            lacking = [port for port in picture.fields if port not in results.recorded]
            if lacking:
                reasons[picture.file] = (
                    f"{label} has not recorded {', '.join(lacking)}; name it in record.fields"
                )
            elif picture.time == ENVELOPE:
                without = [port for port in picture.fields if results.envelope(port) is None]
                if without:
                    reasons[picture.file] = f"{label} has no envelope of {', '.join(without)}"
            elif picture.time and not _is_passed(results, picture.time):
                reasons[picture.file] = f"{label} does not reach {picture.time}"
    return reasons


def _is_passed(results, text):
    """Return whether a run reaches an instant."""
    try:
        instant(results, text)
    except BadInput:
        return False
    return True


def figures(case, runs):
    """Yield every picture of the case that the runs have data for, with its figure.

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
    """Return values in the wanted unit, from SI `unit`, and the label of the unit."""
    shown = unit_shown(unit, wanted)
    if not wanted:
        return values, shown
    zero = from_si(0.0, unit, wanted)  # not 0 for degC
    return np.asarray(values) * (from_si(1.0, unit, wanted) - zero) + zero, shown


def unit_shown(unit: str, wanted: str | None) -> str:
    """Return the label of the wanted unit; default: the SI `unit`, "" for pure numbers."""
    shown = (wanted or ("" if unit == "1" else unit)).replace(".", " ")
    return f"\N{MICRO SIGN}{shown[1:]}" if shown in MICRO else shown


def labelled(text: str, unit: str) -> str:
    """Return a text with its unit, if there is one."""
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
"""Suffixes of summary entries that have a unit, and the unit."""


def entry_in_words(name: str) -> str:
    """Return a summary entry in words: mean_friction_power_w -> "mean friction power [W]"."""
    words, unit = _with_unit(name)
    return labelled(words, unit)


def _with_unit(name):
    """Return a summary's entry in words, and its unit or nothing."""
    ending = next((one for one in ENDINGS if name.endswith(one)), "")
    return name.removesuffix(ending).replace("_", " "), ENDINGS.get(ending, "")


def entry_shown(name: str, values: Sequence[float]) -> tuple[str, np.ndarray]:
    """Return a summary entry in words with a unit that suits its values, and the values in it."""
    array = np.asarray(values, float)
    words, unit = _with_unit(name)
    largest = max(np.abs(array[np.isfinite(array)]), default=0.0)
    shown, label = scaled(array, unit, "deg" if unit == "rad" else handy_unit(unit, largest))
    return labelled(words, label), shown


def handy_unit(unit: str, largest: float) -> str | None:
    """Return the prefixed unit that suits a value in the SI `unit`, None if that is as good."""
    if unit not in WITH_PREFIX or not np.isfinite(largest) or largest == 0.0:
        return None
    compact = registry().Quantity(float(abs(largest)), unit).to_compact()
    return one_micro(f"{compact.units:~}").replace("\N{MICRO SIGN}", "u")


def name_of(port: str) -> str:
    """Return the variable of "participant.variable" in words, with its film surface; or "time"."""
    *where, name = port.partition(".")[2].split(".")
    surface = f" ({', '.join(where)})" if where else ""
    return (name + surface).replace("_", " ") or port


def names_of(ports: Sequence[str]) -> dict[str, str]:
    """Return the names of several variables; equal ones with their participants."""
    words = [name_of(port) for port in ports]
    owner = {port: port.partition(".")[0].replace("_", " ") for port in ports}
    return {
        port: f"{name}, {owner[port]}" if words.count(name) > 1 else name
        for port, name in zip(ports, words)
    }


def draw_lines(case, picture, runs):
    """Draw a panel for each entry of `y`, with a colour for each run and shaded windows.

    The variables of a panel differ in line style. A path in a plane (a length over a length) has
    equal scales.
    """
    first = next(iter(runs.values()))
    plane = all(first.series(port).unit == "m" for port in (picture.x, *sum(picture.y, [])))
    figure, panels = stack(len(picture.y), 6.0 if plane else 2.3)
    x_unit = ""
    known = set()
    alone = names_of([ports[0] for ports in picture.y if len(ports) == 1])
    for panel, ports in zip(panels, picture.y):
        y_unit = ""
        title = alone.get(ports[0], _common(ports))
        ports = [port for port in ports if _is_drawn(port, runs.values())] or ports
        own = _own_words(ports)
        for colour, (label, results) in zip(cycle(PALETTE), runs.items()):
            x, si, _ = results.series(picture.x)
            x, x_unit = scaled(x, si, picture.units.get(picture.x))
            for style, port in zip(("-", "--", ":", "-."), ports):
                y, si, _ = results.series(port)
                y, y_unit = scaled(y, si, picture.units.get(port))
                parts = [label] * (len(ports) == 1 or len(runs) > 1) + own[port]
                if y.any() or not _is_drawn(port, runs.values()):
                    panel.plot(x, y, style, color=colour, lw=1.2, label=", ".join(parts))
        if plane:
            panel.set_aspect("equal")
        _shade(panel, windows_of(ports, case.window, picture.units, first))
        panel.set_ylabel(labelled(title, y_unit))
        handles, labels = panel.get_legend_handles_labels()
        if not {line.get_label() for line in panel.lines} <= known:  # other curves than above
            known.clear()
        new = {label: handle for label, handle in zip(labels, handles) if label not in known}
        if new:
            add_legend(panel, new)
        known.update(new)
    label_abscissa(panels[-1], picture.x, x_unit)
    return figure


def _is_drawn(port, runs):
    """Return whether an output is not zero in a run."""
    return any(results.series(port).values.any() for results in runs)


def _own_words(ports):
    """Return what follows the shared words in each name, as a list; empty for one port."""
    names, shared = names_of(ports), _common(ports)
    if len(ports) == 1:
        return dict.fromkeys(ports, [])
    return {port: [name.removeprefix(shared).strip(", ") or name] for port, name in names.items()}


def label_abscissa(panel, port, unit):
    """Label the abscissa of a panel, with TDC and BDC for crank angles.

    Crank angles have ticks every 90 deg, or every 360 deg for many cycles.
    """
    panel.set_xlabel(labelled(name_of(port), unit))
    if port.rpartition(".")[2] == CRANK_ANGLE and unit == "deg":
        tick_degrees(panel)


def tick_degrees(panel):
    """Tick the crank angle of a panel, with TDC and BDC."""
    low, high = panel.get_xlim()
    step = 90 if high - low <= MOST_TICKED else 360
    ticks = (
        np.arange(np.ceil(low / step - 1e-6), np.floor(high / step + 1e-6) + 1) * step + 0.0
    )  # no -0
    words = {0: "\nTDC", 180: "\nBDC"}
    panel.set_xticks(ticks, [f"{tick:g}{words.get(tick % 360, '')}" for tick in ticks])


def windows_of(ports, window, units, results):
    """Return the limits of a panel's curves in the units shown, by kind of value."""
    limits = {}
    for text, pair in window.items():
        kind, port = reduced(text)
        if port in ports:
            si = results.series(port)[1]
            limits[kind] = tuple(scaled(to_si(v, si), si, units.get(port))[0] for v in pair)
    return limits


def _shade(panel, windows):
    """Shade the expected ranges of a curve's values; equal ranges are shaded once."""
    words = {"min": "lowest", "max": "highest", "mean": "mean", "last": "last"}
    for limits in dict.fromkeys(windows.values()):
        kinds = " and ".join(words[kind] for kind, other in windows.items() if other == limits)
        panel.axhspan(
            *limits, color=WINDOW, alpha=0.16, lw=0, label=f"expected for the {kinds} value"
        )


def _common(ports):
    """Return the words that the variables' names share, or else all names."""
    words = [port.partition(".")[2].split("_") for port in ports]
    shared = [column[0] for column in zip(*words) if len(set(column)) == 1]
    return " ".join(shared) or ", ".join(name_of(port) for port in ports)


def draw_maps(case, picture, runs):
    """Draw a row for each field, and a column for each run; a row has one colour scale."""
    rows = {}
    for port in picture.fields:
        shown = [shown_field(results, port, picture.time) for results in runs.values()]
        wanted = picture.units.get(port)
        images = [
            masked(scaled(field.values, field.unit, wanted)[0], results.there(port))
            for field, results in zip(shown, runs.values())
        ]
        label = labelled(name_of(port), unit_shown(shown[0].unit, wanted))
        rows[port] = MapRow(label, images, colour_norm(images))
    figure, panels = map_figure(case, rows)
    for panel, label, field in zip(panels[0], runs, shown):
        panel.set_title(f"{label}, {field.when}", fontsize="medium")
    return figure


class ShownField(NamedTuple):
    """Values of a field in its SI unit, and their instant as text."""

    values: np.ndarray
    unit: str
    when: str


def shown_field(results, port, time) -> ShownField:
    """Return a field at the recorded instant nearest to the time of a picture, or its envelope."""
    if time != ENVELOPE:
        field = results.field(port, instant(results, time))
        return ShownField(field.values, field.unit, instant_text(results, field.time))
    envelope = results.envelope(port)
    steps = "all steps" if envelope.every_step else "recorded instants"
    return ShownField(envelope.values, envelope.unit, f"extremes of {steps} of the last period")


class MapRow(NamedTuple):
    """Maps of one field for several runs, with their label and the norm of their colours."""

    label: str
    images: Sequence[np.ma.MaskedArray]
    norm: Normalize


def map_figure(case, rows):
    """Return a figure of maps and its panels, from the rows by port."""
    columns = max(len(row.images) for row in rows.values())
    size = (1.5 + 4.6 * columns, 1 + 2.9 * len(rows))
    figure, panels = subplots(len(rows), columns, squeeze=False, figsize=size)
    for line, (port, row) in zip(panels, rows.items()):
        for panel, image in zip(line, row.images):
            draw_map(panel, image, row.norm, case.axes_of(port))
        figure.colorbar(line[0].images[0], ax=list(line), label=row.label)
    if all(case.axes_of(port) == case.axes_of(next(iter(rows))) for port in rows):
        for panel in panels.flat:
            panel.label_outer()
    return figure, panels


def masked(image, there):
    """Mask the cells that the field does not have."""
    return np.ma.array(image, mask=np.zeros(np.shape(image), bool) if there is None else ~there)


FLOOR = 1e-4
"""Lower end of logarithmic colours, relative to the largest value."""
SPAN = 30.0
"""Ratio of two values above which a colour scale is logarithmic."""


def colour_norm(images):
    """Return the colour scale of all images.

    It is logarithmic if the largest value exceeds `SPAN` times the median of the positive ones,
    as in contact of a single cell.
    """
    low = min(float(image.min()) for image in images)
    high = max(float(image.max()) for image in images)
    positive = np.concatenate([np.ma.compressed(image[image > 0]) for image in images])
    if low < 0 or not len(positive) or high <= SPAN * np.median(positive):
        return Normalize(low, high)
    return LogNorm(max(high * FLOOR, min(float(positive.min()), high / 2)), high, clip=True)


def draw_map(panel, image, norm, axes):
    """Draw one field over its axes, interpolated, with contours."""
    panel.set_xlabel(axes.first.title)
    panel.set_ylabel(axes.second.title)
    for drawn, axis in ((panel.xaxis, axes.first), (panel.yaxis, axes.second)):
        _mark(drawn, axis, *axis.range)
    draw_values(panel, image, norm, axes)
    panel.set_xlim(axes.first.range)


def draw_values(panel, image, norm, axes):
    """Draw the values of a field as colours and contours into a panel that has its labels.

    On a closed axis the first cell follows the last.
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
        cmap=COLOURS,
        interpolation="bilinear",
    )
    logs = isinstance(norm, LogNorm)
    locator = LogLocator() if logs else MaxNLocator(7)
    low = max(norm.vmin, image.min())
    levels = [x for x in locator.tick_values(norm.vmin, norm.vmax) if low < x < image.max()]
    if levels:
        drawn = panel.contour(around, along, image.T, levels, colors="white", linewidths=0.5)
        panel.clabel(drawn, fontsize=6, fmt="%.3g")


def _mark(drawn, axis, low, high):
    """Tick the quarters of an axis that has marks, and label the marks."""
    if not axis.marks:
        return
    words = {position: f"\n{word}" for word, position in axis.marks.items()}
    inside = [position for position in words if low <= position <= high]
    positions = sorted({*np.linspace(low, high, 5).tolist(), *inside})
    drawn.set_ticks(positions, [f"{x:g}{words.get(x, '')}" for x in positions])


def draw_sections(case, picture, runs):
    """Draw a panel for each field, with all runs.

    The curve is the field along its first index, at one position of the second and one instant.
    """
    figure, panels = stack(len(picture.fields))
    axis = case.axes_of(picture.fields[0]).first
    low, high = axis.range
    begin, end = (low + (high - low) * to_si(text, "rad") / (2 * np.pi) for text in picture.angles)
    for panel, port in zip(panels, picture.fields):
        unit = ""
        for colour, (label, results) in zip(cycle(PALETTE), runs.items()):
            field = results.field(port, instant(results, picture.time))
            columns = field.values.shape[1]
            line = field.values[:, min(int(picture.height * columns), columns - 1)]
            line, unit = scaled(line, field.unit, picture.units.get(port))
            position = axis.positions(line.size)
            inside = (position >= begin) & (position <= end)
            panel.plot(
                position[inside],
                line[inside],
                ".-",
                color=colour,
                lw=1.2,
                ms=4,
                label=f"{label}, {instant_text(results, field.time)}",
            )
        panel.set_ylabel(labelled(name_of(port), unit))
        panel.set_xlim(begin, end)
    add_legend(panels[0])
    panels[-1].set_xlabel(axis.title)
    _mark(panels[-1].xaxis, axis, begin, end)
    return figure


DRAWN = {"lines": draw_lines, "map": draw_maps, "section": draw_sections}
"""Functions that draw each kind of picture, of the case, the picture and label -> Results."""
