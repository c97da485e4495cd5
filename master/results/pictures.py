"""Pictures of one or several runs, as the case file describes them; converts units."""

import textwrap
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.colors import Normalize
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke

from ..case.shown import ENVELOPE
from ..fmi.errors import BadInput
from ..fmi.quantities import to_si
from .charts import DASHES, Chart, Curve, line_charts
from .coordinates import CRANK_ANGLE
from .figures import (
    COLOURS,
    NO_FILM,
    PALETTE,
    PAPER,
    PAPER_RESOLUTION,
    PAPER_SCALE,
    RESOLUTION,
    RUPTURE,
    add_legend,
    save,
    stack,
    subplots,
)
from .instants import instant, instant_text
from .maps import STYLE, FieldMap, MapRow, Mark, field_map, map_row
from .words import labelled, name_of, scaled

PALETTE_DARK = ("#2f8fd0", "#f27d33", "#12c494", "#e59ac4", "#f2c14e", "#a6d8f7", "#e8ecef")
"""Lighter colours for a dark background."""
WINDOW = "#009e73"
MOST_TICKED = 1440
"""Longest range of crank angle with a tick every 90 deg [deg]."""
LETTERS_PER_INCH = 9
"""Number of letters per inch of a title; longer titles have a second line."""


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
        figure.suptitle(textwrap.fill(picture.title, int(LETTERS_PER_INCH * width)))
        yield picture, figure


LINES = dict(zip(DASHES, ("-", "--", ":", "-.")))
"""Line styles of matplotlib by the dashes of a chart."""


def draw_lines(case, picture, runs):
    """Draw a panel for each entry of `y`, with a colour for each run and shaded windows.

    The variables of a panel differ in line style. A path in a plane (a length over a length) has
    equal scales.
    """
    first = next(iter(runs.values()))
    plane = all(first.series(port).unit == "m" for port in (picture.x, *sum(picture.y, [])))
    charts = line_charts(case, picture, runs, picture.units.get(picture.x))
    figure, panels = stack(len(charts), 6.0 if plane else 2.3)
    known = set()
    for panel, chart in zip(panels, charts):
        draw_chart(panel, chart)
        if plane:
            panel.set_aspect("equal")
        handles, labels = panel.get_legend_handles_labels()
        if not {*labels} <= known:  # other curves than above
            known.clear()
        new = {label: handle for label, handle in zip(labels, handles) if label not in known}
        if new:
            add_legend(panel, new)
        known.update(new)
    unit = scaled(0.0, first.series(picture.x).unit, picture.units.get(picture.x))[1]
    label_abscissa(panels[-1], picture.x, unit)
    return figure


def draw_chart(panel, chart: Chart):
    """Draw the curves and bands of a chart; curves of points have lines as well."""
    for curve in chart.curves:
        colour = PALETTE[curve.run % len(PALETTE)]
        style = ("." if curve.points else "") + LINES[curve.dash]
        panel.plot(curve.x, curve.y, style, color=colour, lw=1.2, ms=4, label=curve.name)
    for band in chart.bands:
        panel.axhspan(band.low, band.high, color=WINDOW, alpha=0.16, lw=0, label=band.text)
    for one in chart.extremes:
        panel.plot(one.x, one.y, SIGNS[one.sign][0], mfc="none", mec="black", ms=8, mew=1.4)
        colour = PALETTE[one.run % len(PALETTE)]
        anchor = ANCHORS[one.anchor]
        _write(panel, one.text, (one.x, one.y), anchor, one.sign == "cross", color=colour)
    if chart.extremes:
        panel.margins(y=0.18)  # for the values
    panel.set_ylabel(chart.y)


ANCHORS = {"start": "left", "middle": "center", "end": "right"}


def _write(panel, text, at, anchor, is_above, **style):
    """Write a value above or below a mark."""
    aside = {"left": 6, "center": 0, "right": -6}[anchor]
    panel.annotate(
        text,
        at,
        (aside, 8 if is_above else -8),
        textcoords="offset points",
        ha=anchor,
        va="bottom" if is_above else "top",
        fontsize=8,
        fontweight="bold",
        path_effects=[HALO],
        **style,
    )


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


FILM = "#28323c"
"""Colour of the contours of the film thickness."""
HALO = withStroke(linewidth=3, foreground="white")
FAINT = withStroke(linewidth=2, foreground="white", alpha=0.35)
"""Edges of lines, which are visible on dark colours."""
SIGNS = {"ring": ("o", "thinnest film"), "cross": ("+", "highest pressure")}
"""Marker and legend of each mark."""
LABEL_MARGIN = 0.04
"""Distance of labels from the frame of a map, relative to its size."""
LABEL_DISTANCE = (0.10, 0.06)
"""Least distance of the labels of contours, relative to the size of a map."""


def draw_maps(case, picture, runs):
    """Draw a row for each field, and a column for each run; a row has one colour scale."""
    rows = [
        map_row([field_map(case, own, port, picture.time, picture.units) for own in runs.values()])
        for port in picture.fields
    ]
    figure, panels = map_figure(rows)
    for panel, label, one in zip(panels[0], runs, rows[-1].maps):
        panel.set_title(f"{label}, {one.when}", fontsize="medium")
    return figure


def map_figure(rows: list[MapRow], columns: int | None = None):
    """Return a figure of maps and its panels, with a legend of lines and marks.

    `columns` is the number of maps of each row that are drawn (default: all).
    """
    columns = columns or max(len(row.maps) for row in rows)
    size = (1.5 + 4.6 * columns, 1.4 + 2.9 * len(rows))
    figure, panels = subplots(len(rows), columns, squeeze=False, figsize=size)
    for line, row in zip(panels, rows):
        for panel, one in zip(line, row.maps):
            draw_map(panel, one, row)
        figure.colorbar(line[0].images[0], ax=list(line), label=row.maps[0].label)
    every = [one for row in rows for one in row.maps]
    if all(one.axes == every[0].axes for one in every):
        for panel in panels.flat:
            panel.label_outer()
    if handles := _legend(rows):
        count = min(len(handles), 2 if columns == 1 else 5)
        style = {"loc": "outside lower center", "ncols": count, "frameon": False}
        figure.legend(handles=handles, fontsize="small", **style)
    return figure, panels


def _legend(rows):
    """Return the legend of the lines and marks of maps."""
    maps = [one for row in rows for one in row.maps]
    handles = []
    if any(row.levels for row in rows):
        unit = next(one.layers["thickness"].unit for one in maps if "thickness" in one.layers)
        handles.append(Line2D([], [], color=FILM, lw=0.8, label=labelled("film thickness", unit)))
    signs = {mark.sign for one in maps for mark in one.marks}
    for sign, (marker, words) in SIGNS.items():
        if sign in signs:
            line = Line2D([], [], marker=marker, linestyle="none", label=words)
            line.set(markerfacecolor="none", markeredgecolor="black")
            handles.append(line)
    if any(_ruptures(one) for one in maps):
        words = f"film ruptures (film fraction {STYLE['rupture']})"
        handles.append(Line2D([], [], color=RUPTURE, ls="--", lw=1.3, label=words))
    if any(np.ma.getmaskarray(one.values).any() for one in maps):
        handles.append(Patch(color=NO_FILM, label="no film"))
    return handles


def _ruptures(one):
    """Return whether the film of a map is ruptured somewhere and full elsewhere."""
    fraction = one.values_of("fraction")
    return fraction is not None and fraction.min() < STYLE["rupture"] < fraction.max()


def draw_map(panel, one: FieldMap, row: MapRow):
    """Draw one field over its axes, interpolated, with contours and marks."""
    panel.set_xlabel(one.axes.first.title)
    panel.set_ylabel(one.axes.second.title)
    for drawn, axis in ((panel.xaxis, one.axes.first), (panel.yaxis, one.axes.second)):
        _mark(drawn, axis, *axis.range)
    draw_values(panel, one, row)
    panel.set_xlim(one.axes.first.range)


def draw_values(panel, one: FieldMap, row: MapRow):
    """Draw colours, contours and marks of a map into a panel that has its labels.

    On a closed axis the first cell follows the last.
    """
    first, second = one.axes.first, one.axes.second
    around, along = first.positions(len(one.values)), second.positions(len(one.values.T))
    left, right = first.ends(len(one.values))
    cells = slice(None)
    if first.centred is not None:
        cell = (right - left) / len(one.values)
        around = np.concatenate([[around[0] - cell], around, [around[-1] + cell]])
        cells, left, right = np.r_[-1, : len(one.values), 0], left - cell, right + cell
    panel.imshow(
        one.values[cells].T,
        origin="lower",
        aspect="auto",
        extent=(left, right, *second.ends(len(one.values.T))),
        norm=Normalize(row.low, row.high),
        cmap=COLOURS[one.kind],
        interpolation="bilinear",
    )
    box = np.array([first.range, second.ends(len(one.values.T))])
    marks = _placed_marks(one, box)
    film = one.values_of("thickness")
    if film is not None:
        levels = [level for level in row.levels if film.min() < level < film.max()]
        if levels:
            style = {"colors": FILM, "alpha": 0.6, "linewidths": 0.8}
            drawn = panel.contour(around, along, film[cells].T, levels, **style)
            drawn.set_path_effects([FAINT])
            _label_contours(panel, drawn, box, [mark.share for mark in marks])
    if _ruptures(one):
        style = {"colors": RUPTURE, "linestyles": "--", "linewidths": 1.3}
        fraction = one.layers["fraction"].values[cells].T
        drawn = panel.contour(around, along, fraction, [STYLE["rupture"]], **style)
        drawn.set_path_effects([FAINT])
    for mark in marks:
        mark.draw(panel)


def _label_contours(panel, drawn, box, taken):
    """Label each contour once, apart from the frame, the marks and other labels.

    The marks are given as shares of the box, and their values have a width.
    """
    low, size = box[:, 0], np.ptp(box, axis=1)
    placed = [share + (x, y) for share in taken for x in (-0.06, 0, 0.06) for y in (-0.07, 0, 0.07)]
    for k, (level, path) in enumerate(zip(drawn.levels, drawn.get_paths())):
        points = (path.vertices - low) / size
        inside = ((points > LABEL_MARGIN) & (points < 1 - LABEL_MARGIN)).all(axis=1)
        free = [
            point
            for point in points[inside]
            if all((np.abs(point - other) > LABEL_DISTANCE).any() for other in placed)
        ]
        if not free:
            continue
        distance = 0.15 + 0.11 * (k % 3)
        chosen = min(free, key=lambda point: abs(point[0] - distance))
        placed.append(chosen)
        style = {"fontsize": 7, "color": FILM, "ha": "center", "va": "center", "clip_on": True}
        panel.text(*(low + chosen * size), f"{level:g}", path_effects=[HALO], **style)


@dataclass(frozen=True)
class _PlacedMark:
    """Mark of a map: its position, also as share of the map, and whether its value is above."""

    mark: Mark
    at: tuple[float, float]
    share: np.ndarray
    is_above: bool

    def draw(self, panel):
        marker, _ = SIGNS[self.mark.sign]
        style = {"mfc": "none", "mec": "black", "ms": 9, "mew": 1.4, "path_effects": [HALO]}
        panel.plot(*self.at, marker, clip_on=False, **style)
        anchor = "left" if self.share[0] < 0.12 else "right" if self.share[0] > 0.88 else "center"
        _write(panel, self.mark.text, self.at, anchor, self.is_above)


def _placed_marks(one, box) -> list[_PlacedMark]:
    """Return the marks of a map; the value of the upper one is above it."""
    low, size = box[:, 0], np.ptp(box, axis=1)
    around = one.axes.first.positions(len(one.values))
    along = one.axes.second.positions(len(one.values.T))
    placed = []
    for mark in sorted(one.marks, key=lambda mark: -mark.cell[1]):
        at = float(around[mark.cell[0]]), float(along[mark.cell[1]])
        share = (np.array(at) - low) / size
        is_above = share[1] < 0.1 or (not placed and share[1] < 0.9)
        placed.append(_PlacedMark(mark, at, share, is_above))
    return placed


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
        unit, curves = "", []
        for k, (label, results) in enumerate(runs.items()):
            field = results.field(port, instant(results, picture.time))
            columns = field.values.shape[1]
            line = field.values[:, min(int(picture.height * columns), columns - 1)]
            line, unit = scaled(line, field.unit, picture.units.get(port))
            position = axis.positions(line.size)
            inside = (position >= begin) & (position <= end)
            name = f"{label}, {instant_text(results, field.time)}"
            curves.append(Curve(name, k, position[inside], line[inside], points=True))
        draw_chart(panel, Chart("", axis.title, labelled(name_of(port), unit), curves))
        panel.set_xlim(begin, end)
    add_legend(panels[0])
    panels[-1].set_xlabel(axis.title)
    _mark(panels[-1].xaxis, axis, begin, end)
    return figure


DRAWN = {"lines": draw_lines, "map": draw_maps, "section": draw_sections}
"""Functions that draw each kind of picture, of the case, the picture and label -> Results."""
