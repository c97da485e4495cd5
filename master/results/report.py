"""A report of one or several runs: one HTML page that needs nothing else, and its figures as PNG
and SVG.
"""

import base64
import csv
import hashlib
import json
import mimetypes
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment, FileSystemLoader
from markdown_it import MarkdownIt
from matplotlib import colormaps
from plotly.offline import get_plotlyjs

from ..case.schema import reduced
from ..fmi.quantities import short
from .charts import Phase, Section, as_data, field_data, health_section, picture_section
from .coordinates import crank_angle_port
from .figures import subplots
from .instants import crank_angle
from .judgement import Extreme, Window, extremes, loop_curve, loop_work, windows
from .packing import Columns, packed
from .pictures import (
    PALETTE,
    PALETTE_DARK,
    entry_in_words,
    handy_unit,
    name_of,
    names_of,
    scaled,
)
from .pictures import figures as drawn_figures
from .solids import Solid, solids_data

COLOURS = "viridis"
"""Of fields: even steps in lightness, told apart by colour-blind readers."""
DIFFERENCES = "RdBu_r"
"""Of differences, white at zero: red and blue are told apart by colour-blind readers."""


@dataclass(frozen=True)
class Special:
    """What only the kind of machine knows, for a report of it.

    Parameters
    ----------
    sections : sequence of Section
        Shown before the case's own curves.
    phases : sequence of Phase
        Named parts of the cursor's abscissa.
    strip : dict of str to str
        Ports drawn beneath the cursor, and their units; the page opens where the last is largest.
    solids : dict of str to list of Solid
        Label -> bodies on their meshes.
    """

    sections: Sequence[Section] = ()
    phases: Sequence[Phase] = ()
    strip: Mapping[str, str] = field(default_factory=dict)
    solids: Mapping[str, list[Solid]] = field(default_factory=dict)


PLAIN = Special()


def write_report(
    case, runs, folder, notes=None, studies=(), answers=None, special=PLAIN, figures=True
):
    """Write `<folder>/report.html` and, if wanted, the figures.

    Parameters
    ----------
    case : Case
        Of the first run.
    runs : dict of str to Results
        Label -> results.
    folder : Path
    notes : Path, optional
        Markdown file, for example the case's README. The page embeds its pictures.
    studies : sequence of Path
        Tables of studies (study.csv): what grid, step, modes and tolerance are worth.
    answers : dict, optional
        Label -> what is said of the run first: `lines` (name, said) and `verdicts` (colour, what,
        said).
    special : Special
        What only the kind of machine knows.
    figures : bool
        Whether the figures are wanted.

    Returns
    -------
    Path
        The page.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    if figures:
        _save_figures(case, runs, folder)
    templates = Environment(
        loader=FileSystemLoader(Path(__file__).parent / "templates"), autoescape=True
    )
    templates.filters["words"] = words
    templates.filters["entry"] = entry_in_words
    page = templates.get_template("report.html").render(
        case=case,
        runs=[judged(case, label, results) for label, results in runs.items()],
        answers=answers or {},
        names=list(
            dict.fromkeys(line.name for one in (answers or {}).values() for line in one.lines)
        ),
        data=json.dumps(page_data(case, runs, special)).replace("<", "\\u003c"),
        plotter=packed(get_plotlyjs().encode()),
        notes=notes_html(notes) if notes else "",
        studies=[study_table(path) for path in studies],
        tree=json.dumps(next(iter(runs.values())).case, indent=1),
        made=datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
    )
    path = folder / "report.html"
    path.write_text(page, encoding="utf-8")
    return path


def notes_html(path: Path) -> str:
    """Return a Markdown file as HTML with its pictures inside; HTML in it stays text."""
    markdown = MarkdownIt("commonmark", {"html": False}).enable("table")
    tokens = markdown.parse(path.read_text(encoding="utf-8"))
    for token in (child for block in tokens for child in block.children or []):
        picture = path.parent / str(token.attrGet("src") or "")
        if token.type == "image" and picture.is_file():
            kind = mimetypes.guess_type(picture)[0] or "image/png"
            data = base64.b64encode(picture.read_bytes()).decode()
            token.attrSet("src", f"data:{kind};base64,{data}")
    return markdown.renderer.render(tokens, markdown.options, {})


def _save_figures(case, runs, folder):
    """The case's pictures but maps, its loops and the coupling's health, as PNG and SVG."""
    for picture, figure in drawn_figures(case, runs):
        if picture.kind != "map":
            _save(figure, folder / Path(picture.file).stem)
    for name in case.report.loops:
        _save(draw_loop(case, runs, name), folder / f"loop_{name}")
    _save(draw_health(runs), folder / "coupling")


def study_table(path):
    """The table of a study, named after its folder; numbers to four digits."""
    with open(path, newline="") as file:
        header, *rows = csv.reader(file)
    heads = [name.split(".")[-1].replace("_", " ") for name in header]
    return StudyTable(path.parent.name, heads, [[_digits(value) for value in row] for row in rows])


def _digits(text):
    try:
        return f"{float(text):.4g}"
    except ValueError:
        return text


@dataclass(frozen=True)
class Judged:
    """What the page says of one run in words and numbers.

    summary : empty where the run has not finished; worst_residual : over its tolerance [-];
    loops : name -> work with its unit; versions : of the packages it was made with;
    digest : SHA-256 of the results file.
    """

    label: str
    summary: dict
    finished: bool
    steps: int
    worst_residual: float
    extremes: list[Extreme]
    windows: list[Window]
    loops: dict[str, str]
    versions: dict[str, str]
    file: str
    digest: str


@dataclass(frozen=True)
class StudyTable:
    """The table of a study as text."""

    name: str
    heads: list[str]
    rows: list[list[str]]


def judged(case, label, results) -> Judged:
    """What there is to say of one run."""
    summary = results.summary
    residual = results.series("coupling.residual").values[1:]
    return Judged(
        label=label,
        summary=summary or {},
        finished=summary is not None,
        steps=len(residual),
        worst_residual=float(residual.max(initial=0.0)),
        extremes=extremes(case, results),
        windows=windows(case, results),
        loops={
            name: f"{loop_work(case, results, loop):.4g} {loop.unit}"
            for name, loop in case.report.loops.items()
        },
        versions=json.loads(results.file.attrs["versions"]),
        file=results.path.name,
        digest=digest(results.path),
    )


def words(value, unit):
    """A value with a handy unit; angles in degrees."""
    return f"{np.degrees(value):.4g} deg" if unit == "rad" else short(value, unit)


def digest(path):
    """SHA-256 of a file."""
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()


def _save(figure, stem):
    """Save a figure as PNG and SVG, and close it."""
    figure.savefig(stem.with_suffix(".png"), dpi=130)
    figure.savefig(stem.with_suffix(".svg"))


def draw_loop(case, runs, name):
    """The loop `name` of every run."""
    loop = case.report.loops[name]
    figure, panel = subplots(figsize=(7, 4.5))
    x_unit = y_unit = ""
    for colour, (label, results) in zip(cycle(PALETTE), runs.items()):
        x, x_unit, y, y_unit = loop_curve(case, results, loop)
        panel.plot(
            x,
            y,
            color=colour,
            lw=1.2,
            label=f"{label}: {name} = {loop_work(case, results, loop):.4g} {loop.unit}",
        )
    panel.set_xlabel(f"{name_of(loop.x)} [{x_unit}]")
    panel.set_ylabel(
        " + ".join(name_of(port) for port in loop.y) + f" [{y_unit}]",
        fontsize="small",
    )
    panel.grid(alpha=0.3)
    panel.legend(frameon=False)
    return figure


def draw_health(runs):
    """Iterations, derivative products and residual over time."""
    names = ("iterations", "derivative_products", "residual")
    figure, panels = subplots(3, 1, sharex=True, figsize=(11, 6))
    for colour, (label, results) in zip(cycle(PALETTE), runs.items()):
        for panel, name in zip(panels, names):
            panel.plot(
                results.time[1:] * 1e3,
                results.series(f"coupling.{name}")[0][1:],
                ".",
                ms=2,
                color=colour,
                label=label,
                rasterized=True,
            )
    for panel, name in zip(panels, names):
        panel.set_ylabel(name.replace("_", " "))
        panel.grid(alpha=0.3)
    lowest = panels[-1]  # residual
    lowest.set_yscale("log")
    lowest.axhline(1.0, color="black", lw=0.8)
    lowest.set_ylabel("residual / tolerance")
    lowest.set_xlabel("time [ms]")
    panels[0].legend(frameon=False, markerscale=4)
    return figure


@dataclass(frozen=True)
class Cursor:
    """Where the page's cursor can stand: every instant at which any run recorded fields.

    positions : rising, in `unit` (crank angle where every run says one, else time);
    frames, rows : of each run the nearest recorded instant and the nearest macro step;
    recorded : of each run where its recorded instants are, in `unit`.
    """

    label: str
    unit: str
    positions: np.ndarray
    frames: list[np.ndarray] = field(default_factory=list)
    rows: list[np.ndarray] = field(default_factory=list)
    recorded: list[np.ndarray] = field(default_factory=list)


def cursor_of(runs) -> Cursor:
    """The cursor of several runs."""
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
    return Cursor(
        label,
        unit,
        positions,
        [nearest(own, positions) for own in recorded],
        [nearest(steps, positions) for _, steps in scales],
        recorded,
    )


def nearest(sorted_values, wanted):
    """Index of the value nearest to each wanted one; of two equally near the first."""
    after = np.searchsorted(sorted_values, wanted).clip(1, len(sorted_values) - 1)
    if len(sorted_values) == 1:
        return np.zeros(len(wanted), int)
    back = wanted - sorted_values[after - 1] <= sorted_values[after] - wanted
    return after - back


def page_data(case, runs, special) -> dict[str, Any]:
    """What the page's script draws: the cursor with its words, field frames, bodies, charts,
    a colour table.
    """
    cursor = cursor_of(runs)
    columns = Columns()
    lanes = special.strip or {reduced(text).port: "" for text in case.monitor.values()}
    named = names_of(list(lanes))
    strip = [
        _strip(case, port, named[port], unit, runs, cursor)
        for port, unit in lanes.items()
        if port != crank_angle_port(case)
    ]
    fields = names_of(drawn_fields(case, runs))
    units = field_units(case, runs, list(fields))
    sections = [*special.sections, picture_section(case, runs), health_section(runs)]
    return {
        "labels": list(runs),
        "palette": PALETTE,
        "palette_dark": PALETTE_DARK,
        "colours": _table(COLOURS),
        "diverging": _table(DIFFERENCES),
        "cursor": {
            "label": cursor.label,
            "unit": cursor.unit,
            "positions": columns.add(cursor.positions),
            "frames": [frames.tolist() for frames in cursor.frames],
            "recorded": [columns.add(own) for own in cursor.recorded],
            "start": _telling(strip if special.strip else [], cursor),
        },
        "words": [
            monitor_words(case, results, rows) for results, rows in zip(runs.values(), cursor.rows)
        ],
        "phases": [vars(phase) for phase in special.phases],
        "strip": [lane | {"runs": [columns.add(own) for own in lane["runs"]]} for lane in strip],
        "fields": [
            field_frames(case, port, units[port], runs)
            | {"name": name, "variable": port.rpartition(".")[2].replace("_", " ")}
            for port, name in fields.items()
        ],
        "solids": solids_data(
            [special.solids.get(label, []) for label in runs], columns, list(fields)
        ),
        "sections": [as_data(section, columns) for section in sections],
        "columns": columns.text(),
    }


def _table(name):
    """256 colours of a map of matplotlib's, 0 to 255."""
    return (colormaps[name](np.linspace(0, 1, 256))[:, :3] * 255).round(3).tolist()


def monitor_words(case, results, rows):
    """What the monitor shows of a run at each of the cursor's positions."""
    ports = {name: reduced(text).port for name, text in case.monitor.items()}
    shown = {name: results.series(port) for name, port in ports.items() if port in results.ports}
    return [
        "  ".join(
            [f"t = {short(float(results.time[k]), 's')}"]
            + [f"{name} {words(own.values[k], own.unit)}" for name, own in shown.items()]
        )
        for k in rows
    ]


def _telling(strip, cursor) -> int:
    """Where the page opens: where what the strip shows last is largest in the first run that has
    it; halfway without one.
    """
    lanes = [own for lane in strip[-1:] for own in lane["runs"] if len(own)]
    return int(np.abs(lanes[0]).argmax()) if lanes else len(cursor.positions) // 2


def _strip(case, port, name, unit, runs, cursor):
    """A port of every run at the cursor's positions, [] where a run has it not; in the unit of the
    case's pictures, or else `unit`, or one of handy size.
    """
    shown = [results for results in runs.values() if port in results.ports]
    largest = max((np.abs(own.series(port).values).max() for own in shown), default=0.0)
    handy = handy_unit(shown[0].series(port).unit, largest) if shown else None
    wanted = shown_units(case).get(port) or unit or handy
    values = [
        scaled(results.series(port).values[rows], results.series(port).unit, wanted)[0]
        if port in results.ports
        else []
        for results, rows in zip(runs.values(), cursor.rows)
    ]
    unit = scaled(0.0, shown[0].series(port).unit, wanted)[1] if shown else ""
    return {"name": name, "unit": unit, "runs": values}


def shown_units(case):
    """Units in which the case's pictures show ports."""
    return {port: unit for picture in case.pictures for port, unit in picture.units.items()}


def drawn_fields(case, runs):
    """Recorded fields over two indices, in the case's order; those that some run has."""
    return [
        port
        for port in case.record.fields
        if any(
            port in results.recorded and results.dataset(port).ndim == 3
            for results in runs.values()
        )
    ]


def field_units(case, runs, ports) -> dict[str, str | None]:
    """Units fields are shown in: those the case says, else one of handy size, the same for all that
    have a variable's name.
    """
    largest, said = {}, {}
    for port in ports:
        name = port.rpartition(".")[2]
        for results in runs.values():
            if port in results.recorded:
                dataset = results.dataset(port)
                said[port] = said.get(port) or field_unit(case, results, port)
                own = float(np.nanmax(np.abs(dataset[:]), initial=0.0))
                unit, most = largest.get(name, (dataset.attrs["unit"], 0.0))
                largest[name] = unit, max(most, own)
    return {port: said[port] or handy_unit(*largest[port.rpartition(".")[2]]) for port in ports}


def field_frames(case, port, wanted, runs):
    """Frames of a field of every run at all its recorded instants, over one common range."""
    stacks, there = [], []
    unit = ""
    for results in runs.values():
        if port not in results.recorded:
            stacks.append(None)
            there.append(None)
            continue
        dataset = results.dataset(port)
        values, unit = scaled(dataset[:], dataset.attrs["unit"], wanted)
        stacks.append(values)
        there.append(results.there(port))
    return field_data(name_of(port), unit, case.axes_of(port), stacks, there)


def field_unit(case, results, port):
    """Unit a field is shown in: that of the case's pictures, or of a field of the same SI unit."""
    known = shown_units(case)
    si = results.dataset(port).attrs["unit"]
    alike = [
        other
        for other in (port, *case.record.fields)
        if other in known
        and other in results.recorded
        and results.dataset(other).attrs["unit"] == si
    ]
    return known[alike[0]] if alike else None
