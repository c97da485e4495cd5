"""Charts as data: curves and maps of one instant, in sections.

The layers above choose them. The script of a page draws them (templates/page.js), and `pictures`.
"""

from collections.abc import Sequence
from dataclasses import dataclass, is_dataclass, replace
from typing import Any, Literal

import numpy as np

from ..case.shown import Axes
from ..case.tables import reduced
from ..fmi.quantities import to_si
from .coordinates import crank_angle_port
from .maps import contour_levels
from .packing import Columns, packed_frames
from .words import common_words, labelled, name_of, names_of, scaled

Dash = Literal["solid", "dash", "dot", "dashdot"]
DASHES: tuple[Dash, ...] = ("solid", "dash", "dot", "dashdot")
NO_RUN = -1
"""Number of the run for curves that belong to no run."""


@dataclass(frozen=True)
class Curve:
    """Values over an abscissa, in the units of its chart.

    run : number of the run, which determines the colour, or NO_RUN.
    """

    name: str
    run: int
    x: np.ndarray
    y: np.ndarray
    dash: Dash = "solid"
    points: bool = False


@dataclass(frozen=True)
class Band:
    """Shaded range of the ordinate, and its label."""

    low: float
    high: float
    text: str


@dataclass(frozen=True)
class Extreme:
    """Lowest or highest point of a curve: `sign` "ring" or "cross", number of the run, value.

    anchor : part of the text that is at the point.
    """

    sign: str
    run: int
    x: float
    y: float
    text: str
    anchor: Literal["start", "middle", "end"] = "middle"


@dataclass(frozen=True)
class Corridor:
    """Shaded range of the ordinate along the abscissa, and its label."""

    x: np.ndarray
    low: np.ndarray
    high: np.ndarray
    text: str


@dataclass(frozen=True)
class Chart:
    """Curves over one abscissa.

    cursor : whether the abscissa is that of the page's cursor; around : whether the ordinate is
    an angle of a full revolution.
    """

    title: str
    x: str
    y: str
    curves: Sequence[Curve]
    cursor: bool = False
    logarithmic: bool = False
    bands: Sequence[Band] = ()
    extremes: Sequence[Extreme] = ()
    corridor: Corridor | None = None
    around: bool = False


@dataclass(frozen=True)
class StillMap:
    """Field without time for every run (None if a run has none), over the axes of the case.

    cells : whether each cell exists, for every run, see `field_data`.
    """

    title: str
    unit: str
    axes: Axes
    fields: Sequence[np.ndarray | None]
    cells: Sequence[np.ndarray | None]


Drawn = Chart | StillMap


@dataclass(frozen=True)
class Section:
    """Charts under a heading, with a sentence or two."""

    title: str
    drawn: Sequence[Drawn]
    text: str = ""
    phases: "Sequence[CyclePhase] | None" = None
    """Parts of the cursor's abscissa. Default: those of the page."""


@dataclass(frozen=True)
class CyclePhase:
    """Named part of the cursor's abscissa, from `begin` to `end` in its unit.

    mark : label of its beginning, "" if there is none.
    """

    begin: float
    end: float
    name: str
    mark: str = ""


def picture_section(case, runs) -> Section:
    """Return the case's pictures of kind `lines`, a chart for each panel."""
    drawn: list[Drawn] = []
    for picture in case.pictures:
        if picture.kind == "lines":
            drawn += line_charts(case, picture, runs, shown_unit(case, picture.x, picture.units))
    return Section("Curves", drawn)


def line_charts(case, picture, runs, x_unit) -> list[Chart]:
    """Return a chart for each entry of `y` of a picture, for pages and pictures.

    An output that is zero is omitted if another one of its panel is not, or another run. A panel
    whose outputs no run has is omitted.

    Parameters
    ----------
    case : Case
    picture : Picture
        Picture of kind `lines`.
    runs : dict of str to Results
    x_unit : str or None
        Unit of the abscissa. Default: SI.
    """
    alone = names_of([ports[0] for ports in picture.y if len(ports) == 1])
    charts = [
        _line_chart(case, picture, ports, runs, x_unit, alone.get(ports[0], common_words(ports)))
        for ports in picture.y
    ]
    return [chart for chart in charts if chart.curves]


def _line_chart(case, picture, ports, runs, x_unit, title):
    having = {
        port: [one for one in runs.values() if {port, picture.x} <= {*one.ports, "time"}]
        for port in ports
    }
    is_zero = {
        port: not any(one.series(port).values.any() for one in own_runs)
        for port, own_runs in having.items()
    }
    ports = [port for port in ports if not is_zero[port]] or ports
    own, curves, extremes, shown, unit = _own_words(ports), [], [], "", ""
    for k, (label, results) in enumerate(runs.items()):
        for dash, port in zip(DASHES, ports):
            if results not in having[port]:
                continue
            x, si, _ = results.series(picture.x)
            x, shown = scaled(x, si, x_unit)
            y, si, _ = results.series(port)
            y, unit = scaled(y, si, picture.units.get(port))
            parts = [label] * (len(ports) == 1 or len(runs) > 1) + own[port]
            if y.any() or is_zero[port]:
                curves.append(Curve(", ".join(parts), k, x, y, dash))
                extremes += _extremes(port, k, x, y, unit) if len(ports) == 1 else []
    is_course = picture.x in ("time", crank_angle_port(case))
    return Chart(
        title=title if is_course else f"{title} over {name_of(picture.x)}",
        x=labelled(name_of(picture.x), shown),
        y=labelled(title, unit),
        curves=curves,
        extremes=_anchored(extremes, curves),
        cursor=picture.x == (crank_angle_port(case) or "time"),
        bands=_bands(ports, case.window, picture.units, next(iter(runs.values()))),
    )


def _extremes(port, run, x, y, unit) -> list[Extreme]:
    """Return the lowest point of a minimum, or the highest point of a maximum."""
    name = port.rpartition(".")[2]
    sign = "ring" if name.startswith("minimum_") else "cross" if name.startswith("maximum_") else ""
    if not sign:
        return []
    k = int(y.argmin() if sign == "ring" else y.argmax())
    return [Extreme(sign, run, float(x[k]), float(y[k]), f"{y[k]:.3g} {unit}".strip())]


TEXT_DISTANCE = 0.15, 0.2
"""Distance of two points whose texts would meet, relative to width and height of a chart."""


def _anchored(extremes, curves) -> list[Extreme]:
    """Return extremes with texts inside the chart, on both sides of two points that are near."""
    if not extremes:
        return []
    x = np.concatenate([curve.x for curve in curves])
    y = np.concatenate([curve.y for curve in curves])
    width, height = np.ptp(x) or 1.0, np.ptp(y) or 1.0
    placed = []
    for k, one in enumerate(extremes):
        others = [
            (other.x, n)
            for n, other in enumerate(extremes)
            if n != k
            and abs(other.x - one.x) < TEXT_DISTANCE[0] * width
            and abs(other.y - one.y) < TEXT_DISTANCE[1] * height
        ]
        share = (one.x - x.min()) / width
        is_left = share > 0.88 or (share > 0.12 and any(other > (one.x, k) for other in others))
        is_right = share < 0.12 or bool(others)
        placed.append(replace(one, anchor="end" if is_left else "start" if is_right else "middle"))
    return placed


def _own_words(ports):
    """Return what follows the shared words in each name, as a list; empty for one port."""
    names, shared = names_of(ports), common_words(ports)
    if len(ports) == 1:
        return dict.fromkeys(ports, [])
    return {port: [name.removeprefix(shared).strip(", ") or name] for port, name in names.items()}


REDUCED = {"min": "lowest", "max": "highest", "mean": "mean", "last": "last"}
"""Kinds of values with an expected range, in words."""


def _bands(ports, window, units, results) -> list[Band]:
    """Return the expected ranges of a chart's values in the units shown; equal ones are one."""
    words: dict[tuple[float, float], list[str]] = {}
    for text, pair in window.items():
        kind, port = reduced(text)
        if port in ports:
            si = results.series(port)[1]
            low, high = (float(scaled(to_si(v, si), si, units.get(port))[0]) for v in pair)
            words.setdefault((low, high), []).append(REDUCED[kind])
    return [
        Band(*limits, f"expected for the {' and '.join(kinds)} value")
        for limits, kinds in words.items()
    ]


def shown_unit(case, port, units):
    """Return the unit of an abscissa: the one of the cursor for crank angle and time."""
    cursor = crank_angle_port(case) or "time"
    return ("ms" if cursor == "time" else "deg") if port == cursor else units.get(port)


def health_section(runs) -> Section:
    """Return charts of iterations, derivative products and residual of every macro step."""
    names = ("iterations", "derivative_products", "residual")
    return Section(
        "Coupling health",
        [
            Chart(
                title=name.replace("_", " "),
                x="time [ms]",
                y="residual / tolerance" if name == "residual" else "a macro step",
                curves=[
                    Curve(
                        label,
                        k,
                        results.time[1:] * 1e3,
                        results.series(f"coupling.{name}").values[1:],
                        points=True,
                    )
                    for k, (label, results) in enumerate(runs.items())
                ],
                logarithmic=name == "residual",
                bands=[Band(1.0, 1.0, "tolerance")] if name == "residual" else [],
            )
            for name in names
        ],
    )


def as_data(part: Any, columns: Columns) -> Any:
    """Return a section or a part of it for the page's script, and add its numbers to `columns`."""
    if isinstance(part, np.ndarray):
        return columns.add(part)
    if isinstance(part, StillMap):
        stacks = [None if values is None else values[None] for values in part.fields]
        return {"kind": "map"} | field_data(part.title, part.unit, part.axes, stacks, part.cells)
    if is_dataclass(part):
        return {name: as_data(value, columns) for name, value in vars(part).items()}
    if isinstance(part, (list, tuple)):
        return [as_data(one, columns) for one in part]
    return part


def field_data(name, unit, axes, stacks, cells) -> dict[str, Any]:
    """Return the frames of a field for every run; None for a run that lacks it.

    Parameters
    ----------
    name, unit : str
    axes : Axes
    stacks : sequence of ndarray, shape (frames, n, m), or None
        In `unit`.
    cells : sequence of ndarray of bool, shape (n, m), or None
        Whether each cell of a run's field exists. None: all do.

    Returns
    -------
    dict
        low, high : range over all instants, cells and runs; runs : packed frames and shape of the
        grid for each run.
    """
    shown = [
        stack[:, exists] if exists is not None else stack
        for stack, exists in zip(stacks, cells)
        if stack is not None
    ]
    runs = [
        None
        if stack is None
        else packed_frames(stack)
        | {
            "shape": list(stack.shape[1:]),
            "cells": None if exists is None else "".join(map(str, exists.astype(int).ravel())),
            "ends": [list(axes.first.ends(stack.shape[1])), list(axes.second.ends(stack.shape[2]))],
        }
        for stack, exists in zip(stacks, cells)
    ]
    low = float(min(np.nanmin(one) for one in shown))
    high = float(max(np.nanmax(one) for one in shown))
    return {
        "name": name,
        "unit": unit,
        "low": low,
        "high": high,
        "levels": contour_levels(low, high),
        "axes": [_axis(axes.first), _axis(axes.second)],
        "runs": runs,
    }


def _axis(axis):
    closed = axis.centred is not None
    return {"label": axis.label, "unit": axis.unit, "marks": axis.marks, "closed": closed}
