"""Report of one or several runs: one HTML page without external files."""

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib import colormaps

from .charts import (
    Chart,
    CyclePhase,
    Section,
    as_data,
    field_data,
    health_section,
    picture_section,
)
from .compare import Agreement
from .instants import crank_angle
from .judgement import Window, windows
from .packing import Columns
from .pages import write_page
from .solids import Solid, solids_data
from .words import handy_unit, name_of, scaled

UNITS = {"pressure": "MPa", "thickness": "um", "contact": "MPa"}
"""Units of the layers of a film."""


class Orbit(NamedTuple):
    """Orbit of a bearing.

    Parameters
    ----------
    clearance : float
        Radial clearance [µm].
    at : list of ndarray
        Positions of the cursor, for each run.
    paths : list of (ndarray, ndarray)
        Displacement along x and y at these positions [µm], for each run.
    """

    clearance: float
    at: list[np.ndarray]
    paths: list[tuple[np.ndarray, ...]]


class FilmView(NamedTuple):
    """Film on the page.

    Parameters
    ----------
    title : str
    layers : dict of str to str
        "pressure", "thickness", "fraction", "contact" or "field" -> port. Missing ones are omitted.
    curves : sequence of Chart
        Curves below the maps.
    orbit : Orbit or None
    """

    title: str
    layers: Mapping[str, str]
    curves: Sequence[Chart] = ()
    orbit: Orbit | None = None


@dataclass(frozen=True)
class Special:
    """Content of a report that depends on the kind of machine.

    Parameters
    ----------
    sections : sequence of Section
        Shown among the details before the curves of the case.
    phases : sequence of CyclePhase
        Named parts of the abscissa of the cursor.
    films : sequence of FilmView
        Films in the order of the case.
    solids : dict of str to list of Solid
        Label -> bodies on their meshes.
    overview : engine.overview.Overview or None
        First screen.
    measured : Agreement or None
        Measured values.
    """

    sections: Sequence[Section] = ()
    phases: Sequence[CyclePhase] = ()
    films: Sequence[FilmView] = ()
    solids: Mapping[str, list[Solid]] = field(default_factory=dict)
    overview: Any = None
    measured: Agreement | None = None


PLAIN = Special()


def write_report(case, runs, folder, answers=None, special=PLAIN):
    """Write `<folder>/report.html`.

    Parameters
    ----------
    case : Case
        Case of the first run.
    runs : dict of str to Results
        Label -> results.
    folder : Path
    answers : dict, optional
        Label -> main results `lines` (name -> text) and checks `verdicts` (colour, what, text).
    special : Special
        Content that depends on the kind of machine.

    Returns
    -------
    Path
        The page.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    judged = {label: one.verdicts for label, one in (answers or {}).items()}
    return write_page(
        folder / "report.html",
        "report.html",
        page_data(case, runs, special),
        case=case,
        runs=[run_text(case, label, results) for label, results in runs.items()],
        answers=answers or {},
        names=list(dict.fromkeys(name for one in (answers or {}).values() for name in one.lines)),
        overview=special.overview,
        checks=checks(judged),
        films=[film.title for film in views(case, runs, special)],
        bodies=any(special.solids.values()),
        measured=special.measured,
        tree=json.dumps(next(iter(runs.values())).case, indent=1),
        made=datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
    )


class Check(NamedTuple):
    """Check of one or several runs with the same outcome; text : label -> sentence."""

    colour: str
    outcome: str
    what: str
    text: dict[str, str]


def checks(judged) -> list[Check]:
    """Return the checks of all runs, worst first. Runs that pass the same check share an entry.

    Parameters
    ----------
    judged : dict of str to sequence of Verdict
    """
    rank = ("red", "amber", "green")
    merged: dict[tuple[str, str], Check] = {}
    for label, verdicts in judged.items():
        for one in verdicts:
            check = Check(one.colour, one.outcome, one.what, {})
            merged.setdefault((one.colour, one.what), check).text[label] = one.text
    return sorted(merged.values(), key=lambda check: rank.index(check.colour))


@dataclass(frozen=True)
class RunText:
    """Text about one run.

    summary : empty if the run has not finished; versions : of the packages; digest : SHA-256 of
    the results file.
    """

    label: str
    summary: dict
    finished: bool
    steps: int
    windows: list[Window]
    versions: dict[str, str]
    file: str
    digest: str


def run_text(case, label, results) -> RunText:
    """Return the text about one run."""
    summary = results.summary
    return RunText(
        label=label,
        summary=summary or {},
        finished=summary is not None,
        steps=len(results.time) - 1,
        windows=windows(case, results),
        versions=json.loads(results.file.attrs["versions"]),
        file=results.path.name,
        digest=digest(results.path),
    )


def digest(path):
    """Return the SHA-256 of a file."""
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()


@dataclass(frozen=True)
class Cursor:
    """Positions of the cursor: every instant at which any run recorded fields.

    positions : rising, in `unit` (crank angle if every run has one, else time); frames : nearest
    recorded instant of each run.
    """

    label: str
    unit: str
    positions: np.ndarray
    frames: list[np.ndarray] = field(default_factory=list)


def cursor_of(runs) -> Cursor:
    """Return the cursor of several runs."""
    cranks = [crank_angle(results) for results in runs.values()]
    if all(crank is not None for crank in cranks):
        label, unit = "crank angle", "deg"
        scales = [(crank.time, np.degrees(crank.angle)) for crank in cranks if crank is not None]
    else:
        label, unit = "time", "ms"
        scales = [(results.time, results.time * 1e3) for results in runs.values()]
    recorded = [
        np.interp(results.instants, *scale) for results, scale in zip(runs.values(), scales)
    ]
    positions = np.unique(np.concatenate(recorded).round(6))
    return Cursor(label, unit, positions, [nearest(own, positions) for own in recorded])


def nearest(sorted_values, wanted):
    """Return the index of the value nearest to each wanted one, the first of two equally near."""
    after = np.searchsorted(sorted_values, wanted).clip(1, len(sorted_values) - 1)
    if len(sorted_values) == 1:
        return np.zeros(len(wanted), int)
    back = wanted - sorted_values[after - 1] <= sorted_values[after] - wanted
    return after - back


def views(case, runs, special) -> Sequence[FilmView]:
    """Return the films with maps. Without a film, every recorded field has its own maps."""
    recorded = {port for results in runs.values() for port in results.recorded}
    if special.films:
        return [film for film in special.films if recorded.intersection(film.layers.values())]
    curves = [one for one in picture_section(case, runs).drawn if isinstance(one, Chart)]
    fields = [
        port
        for port in case.record.fields
        if any(
            port in results.recorded and results.dataset(port).ndim == 3
            for results in runs.values()
        )
    ]
    return [
        FilmView(name_of(port), {"field": port}, [one for one in curves if one.cursor][:4])
        for port in fields
    ]


def page_data(case, runs, special) -> dict[str, Any]:
    """Return the data that the script of the page draws."""
    cursor = cursor_of(runs)
    columns = Columns()
    films = views(case, runs, special)
    layers = [
        {
            kind: _layer(case, kind, port, runs)
            for kind, port in film.layers.items()
            if any(port in results.recorded for results in runs.values())
        }
        for film in films
    ]
    sections = [*special.sections, picture_section(case, runs), health_section(runs)]
    ports = [film.layers[kind] for film, own in zip(films, layers) for kind in own]
    return {
        "labels": list(runs),
        "colours": (colormaps["viridis"](np.linspace(0, 1, 256))[:, :3] * 255).round(3).tolist(),
        "cursor": {
            "label": cursor.label,
            "unit": cursor.unit,
            "positions": columns.add(cursor.positions),
            "frames": [frames.tolist() for frames in cursor.frames],
            "start": _start(films, cursor),
        },
        "phases": [vars(phase) for phase in special.phases],
        "films": [
            {
                "title": film.title,
                "layers": own,
                "curves": as_data(Section("", film.curves), columns)["drawn"],
                "orbit": _orbit_data(film.orbit, columns),
            }
            for film, own in zip(films, layers)
        ],
        "solids": solids_data([special.solids.get(label, []) for label in runs], columns, ports),
        "sections": [as_data(section, columns) for section in sections],
        "measured": special.measured and as_data(special.measured.section, columns),
        "columns": columns.text(),
    }


def _start(films, cursor) -> int:
    """Return the position at which the page opens: the maximum pressure of the first run."""
    curves = [curve for film in films[:1] for chart in film.curves[1:2] for curve in chart.curves]
    if not curves:
        return len(cursor.positions) // 2
    at = curves[0].x[np.argmax(curves[0].y)]
    return int(nearest(cursor.positions, np.array([at]))[0])


def _orbit_data(orbit, columns):
    if orbit is None:
        return None
    runs = [
        {"at": columns.add(at), "x": columns.add(x), "y": columns.add(y)}
        for at, (x, y) in zip(orbit.at, orbit.paths)
    ]
    return {"clearance": orbit.clearance, "runs": runs}


def _layer(case, kind, port, runs):
    """Return the frames of a field of every run at all recorded instants."""
    holders = [results if port in results.recorded else None for results in runs.values()]
    datasets = [results.dataset(port) if results else None for results in holders]
    si = next(dataset.attrs["unit"] for dataset in datasets if dataset is not None)
    stacks = [None if dataset is None else dataset[:] for dataset in datasets]
    largest = max(float(np.nanmax(np.abs(own))) for own in stacks if own is not None)
    pictured = {name: unit for one in case.pictures for name, unit in one.units.items()}
    target_unit = UNITS.get(kind) or pictured.get(port) or handy_unit(si, largest)
    _, unit = scaled(0.0, si, target_unit)
    shown = [None if own is None else scaled(own, si, target_unit)[0] for own in stacks]
    cells = [results.existing_cells(port) if results else None for results in holders]
    variable = port.rpartition(".")[2].replace("_", " ")
    data = field_data(name_of(port), unit, case.axes_of(port), shown, cells)
    return data | {"variable": variable}
