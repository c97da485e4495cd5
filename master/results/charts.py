"""Charts of a report as data: curves and maps of one instant, in sections.

The layers above choose them, and the page's script draws them (templates/page.js).
"""

from collections.abc import Sequence
from dataclasses import dataclass, is_dataclass
from typing import Any, Literal

import numpy as np

from ..case.shown import Axes
from .coordinates import crank_angle_port
from .packing import Columns, packed_frames
from .pictures import (
    labelled,
    name_of,
    names_of,
    scaled,
    windows_of,
)

Dash = Literal["solid", "dash", "dot", "dashdot"]
DASHES: tuple[Dash, ...] = ("solid", "dash", "dot", "dashdot")
MEASURED = -1
"""Number of the run for curves that belong to no run."""


@dataclass(frozen=True)
class Curve:
    """Values over an abscissa, in the units of its chart.

    run : number of the run, which determines the colour, or MEASURED.
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
    said: str


@dataclass(frozen=True)
class Corridor:
    """Shaded range of the ordinate along the abscissa, and its label."""

    x: np.ndarray
    low: np.ndarray
    high: np.ndarray
    said: str


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
    corridor: Corridor | None = None
    around: bool = False


@dataclass(frozen=True)
class StillMap:
    """Field without time for every run (None if a run has none), over the axes of the case."""

    title: str
    unit: str
    axes: Axes
    fields: Sequence[np.ndarray | None]
    there: Sequence[np.ndarray | None]


Drawn = Chart | StillMap


@dataclass(frozen=True)
class Section:
    """Charts under a heading, with a sentence or two."""

    title: str
    drawn: Sequence[Drawn]
    said: str = ""
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
            panels = [_panel(case, picture, ports, runs) for ports in picture.y]
            drawn += [panel for panel in panels if panel.curves]
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
    is_course = picture.x in ("time", crank_angle_port(case))
    over = "" if is_course else f" over {name_of(picture.x)}"
    return Chart(
        title=words + over if len(ports) == 1 else picture.title,
        x=labelled(name_of(picture.x), x_unit),
        y=labelled("" if len(ports) > 1 else words, y_unit),
        curves=curves,
        cursor=picture.x == (crank_angle_port(case) or "time"),
        bands=[Band(low, high, f"expected for {kinds}") for (low, high), kinds in expected.items()],
    )


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
        return {"kind": "map"} | field_data(part.title, part.unit, part.axes, stacks, part.there)
    if is_dataclass(part):
        return {name: as_data(value, columns) for name, value in vars(part).items()}
    if isinstance(part, (list, tuple)):
        return [as_data(one, columns) for one in part]
    return part


def field_data(name, unit, axes, stacks, there) -> dict[str, Any]:
    """Return the frames of a field for every run; None for a run that lacks it.

    Parameters
    ----------
    name, unit : str
    axes : Axes
    stacks : sequence of ndarray, shape (frames, n, m), or None
        In `unit`.
    there : sequence of ndarray of bool, shape (n, m), or None
        Cells that exist in a run's field. None: all.

    Returns
    -------
    dict
        low, high : range over all instants, cells and runs; runs : packed frames and shape of the
        grid for each run.
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
