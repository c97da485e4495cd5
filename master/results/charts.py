"""What a report draws besides fields, as data: charts of curves, carpets, maps of one instant, in
sections. Rooms above say which; the page's script draws them (templates/page.js).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from ..case.shown import Axes
from .coordinates import crank_angle_port
from .judgement import loop_curve, loop_work
from .packing import Columns, packed_frames
from .pictures import (
    handy_unit,
    labelled,
    name_of,
    names_of,
    scaled,
    windows_of,
)

Dash = Literal["solid", "dash", "dot", "dashdot"]
DASHES: tuple[Dash, ...] = ("solid", "dash", "dot", "dashdot")


MEASURED = -1
"""Number of the run of a curve that is none's."""


@dataclass(frozen=True)
class Curve:
    """Values over an abscissa, in the units of its chart; `run` is the number of the run, which
    gives the colour, or MEASURED.
    """

    name: str
    run: int
    x: np.ndarray
    y: np.ndarray
    dash: Dash = "solid"
    points: bool = False


@dataclass(frozen=True)
class Band:
    """A range of the ordinate that is shaded, and what it says."""

    low: float
    high: float
    said: str


@dataclass(frozen=True)
class Corridor:
    """A range of the ordinate along the abscissa that is shaded, and what it says."""

    x: np.ndarray
    low: np.ndarray
    high: np.ndarray
    said: str


@dataclass(frozen=True)
class Chart:
    """Curves over one abscissa.

    cursor : it is that of the page's cursor; around : the ordinate is an angle of a whole turn.
    """

    title: str
    x: str
    y: str
    curves: Sequence[Curve]
    cursor: bool = False
    logarithmic: bool = False
    bands: Sequence[Band] = ()
    corridor: Corridor | None = None
    around: bool = False


@dataclass(frozen=True)
class StillMap:
    """A field without time for every run (None where it has none), over the axes of the case."""

    title: str
    unit: str
    axes: Axes
    fields: Sequence[np.ndarray | None]
    there: Sequence[np.ndarray | None]


Drawn = Chart | StillMap


@dataclass(frozen=True)
class Section:
    """Drawn things under a heading, with a sentence or two."""

    title: str
    drawn: Sequence[Drawn]
    said: str = ""
    phases: "Sequence[Phase] | None" = None
    """Parts of the cursor's abscissa that are its own, in place of the page's."""


@dataclass(frozen=True)
class Phase:
    """A named part of the cursor's abscissa, from `begin` to `end` in its unit; `mark` is what its
    beginning is called, "" where it is not marked.
    """

    begin: float
    end: float
    name: str
    mark: str = ""


def picture_section(case, runs) -> Section:
    """The case's pictures of kind `lines`, a chart a panel; then its loops."""
    drawn: list[Drawn] = []
    for picture in case.pictures:
        if picture.kind == "lines":
            panels = [_panel(case, picture, ports, runs) for ports in picture.y]
            drawn += [panel for panel in panels if panel.curves]
    drawn += [_loop(case, name, runs) for name in case.report.loops]
    return Section("Curves", drawn)


def _panel(case, picture, ports, runs):
    curves = []
    x_unit = y_unit = ""
    for k, (label, results) in enumerate(runs.items()):
        for dash, port in zip(DASHES, ports):
            if not {port, picture.x} <= {*results.ports, "time"}:
                continue
            x, si, _ = results.series(picture.x)
            x, x_unit = scaled(x, si, shown_unit(case, picture.x, picture.units))
            y, si, _ = results.series(port)
            y, y_unit = scaled(y, si, picture.units.get(port))
            name = label if len(ports) == 1 else f"{label}, {names_of(ports)[port]}"
            curves.append(Curve(name, k, x, y, dash))
    windows = windows_of(ports, case.window, picture.units, next(iter(runs.values())))
    expected = {
        limits: " and ".join(kind for kind, other in windows.items() if other == limits)
        for limits in windows.values()
    }
    words = " + ".join(name_of(port) for port in ports)
    over = "" if _is_course(case, picture.x) else f" over {name_of(picture.x)}"
    return Chart(
        title=words + over if len(ports) == 1 else picture.title,
        x=labelled(name_of(picture.x), x_unit),
        y=labelled("" if len(ports) > 1 else words, y_unit),
        curves=curves,
        cursor=picture.x == (crank_angle_port(case) or "time"),
        bands=[Band(low, high, f"expected for {kinds}") for (low, high), kinds in expected.items()],
    )


def _is_course(case, port):
    """Whether an abscissa is the time or the crank angle."""
    return port in ("time", crank_angle_port(case))


def shown_unit(case, port, units):
    """Return the unit of an abscissa: the one of the cursor for crank angle and time."""
    cursor = crank_angle_port(case) or "time"
    return ("ms" if cursor == "time" else "deg") if port == cursor else units.get(port)


def _loop(case, name, runs):
    loop = case.report.loops[name]
    curves = []
    x_unit = y_unit = ""
    words = name.replace("_", " ")
    handy = None
    for k, (label, results) in enumerate(runs.items()):
        x, si, y, y_unit = loop_curve(case, results, loop)
        handy = handy or handy_unit(si, float(np.abs(x).max()))
        x, x_unit = scaled(x, si, handy)
        work = f"{label}: {words} = {loop_work(case, results, loop):.4g} {loop.unit}"
        curves.append(Curve(work, k, x, y))
    return Chart(
        title=f"{words}, last {loop.period}",
        x=labelled(name_of(loop.x), x_unit),
        y=labelled(" + ".join(name_of(port) for port in loop.y), y_unit),
        curves=curves,
    )


def health_section(runs) -> Section:
    """Iterations, derivative products and residual of every macro step."""
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


def as_data(section: Section, columns: Columns) -> dict[str, Any]:
    """A section for the page's script; numbers go into `columns`."""
    return {
        "title": section.title,
        "said": section.said,
        "phases": None if section.phases is None else [vars(phase) for phase in section.phases],
        "drawn": [_DATA[type(one)](one, columns) for one in section.drawn],
    }


def _chart_data(chart: Chart, columns: Columns):
    return {
        "kind": "chart",
        "title": chart.title,
        "x": chart.x,
        "y": chart.y,
        "cursor": chart.cursor,
        "around": chart.around,
        "logarithmic": chart.logarithmic,
        "bands": [vars(band) for band in chart.bands],
        "corridor": _corridor_data(chart.corridor, columns),
        "curves": [
            vars(curve) | {"x": columns.add(curve.x), "y": columns.add(curve.y)}
            for curve in chart.curves
        ],
    }


def _corridor_data(corridor, columns):
    if corridor is None:
        return None
    arrays = {name: columns.add(getattr(corridor, name)) for name in ("x", "low", "high")}
    return arrays | {"said": corridor.said}


def _map_data(still: StillMap, columns: Columns):
    return {"kind": "map"} | field_data(
        still.title,
        still.unit,
        still.axes,
        [None if values is None else values[None] for values in still.fields],
        still.there,
    )


_DATA: dict[type, Any] = {Chart: _chart_data, StillMap: _map_data}


def field_data(name, unit, axes, stacks, there) -> dict[str, Any]:
    """Frames of a field for every run; None where a run has none.

    Parameters
    ----------
    name, unit : str
    axes : Axes
    stacks : sequence of ndarray, shape (frames, n, m), or None
        In `unit`.
    there : sequence of ndarray of bool, shape (n, m), or None
        Cells that a run's field has; None: all.

    Returns
    -------
    dict
        low, high : range over all instants, cells and runs; runs : of each run the frames, packed,
        and the shape of its grid.
    """
    shown = [
        stack[:, cells] if cells is not None else stack
        for stack, cells in zip(stacks, there)
        if stack is not None
    ]
    runs = [
        None
        if stack is None
        else packed_frames(stack)
        | {
            "shape": list(stack.shape[1:]),
            "there": None if cells is None else "".join(map(str, cells.astype(int).ravel())),
            "ends": [list(axes.first.ends(stack.shape[1])), list(axes.second.ends(stack.shape[2]))],
        }
        for stack, cells in zip(stacks, there)
    ]
    return {
        "name": name,
        "unit": unit,
        "low": float(min(np.nanmin(one) for one in shown)),
        "high": float(max(np.nanmax(one) for one in shown)),
        "axes": [_axis(axes.first), _axis(axes.second)],
        "runs": runs,
    }


def _axis(axis):
    closed = axis.centred is not None
    return {"label": axis.label, "unit": axis.unit, "marks": axis.marks, "closed": closed}
