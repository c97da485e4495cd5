"""A report of one or several runs: one HTML page that needs nothing else, and its figures as PNG
and SVG.
"""

import base64
import csv
import hashlib
import io
import json
from dataclasses import dataclass
from datetime import UTC, datetime
from itertools import cycle
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from jinja2 import Environment, FileSystemLoader
from markdown_it import MarkdownIt

from ..fmi.quantities import short, to_si
from .judgement import Extreme, Window, extremes, loop_curve, loop_work, monitored, windows
from .pictures import PALETTE, figures, name_of, scaled

FRAMES = 120  # at most so many instants of the fields: about 3 kB a field, instant and run
LEVELS = 65535


def write_report(case, runs, folder, notes="", studies=(), answers=None):
    """Write `<folder>/report.html` and the figures.

    Parameters
    ----------
    case : Case
        Of the first run.
    runs : dict of str to Results
        Label -> results.
    folder : Path
    notes : str
        Markdown, for example the case's README with the sources of its numbers.
    studies : sequence of Path
        Tables of studies (study.csv): what grid, step, modes and tolerance are worth.
    answers : dict, optional
        Label -> what is said of the run first: `lines` (name, said) and `verdicts` (colour, what,
        said).

    Returns
    -------
    Path
        The page.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    pictures = [
        _save(figure, folder / Path(picture.file).stem, picture.title)
        for picture, figure in figures(case, runs)
        if picture.kind != "map"
    ]
    pictures += [
        _save(draw_loop(case, runs, name), folder / f"loop_{name}", f"Loop: {name}")
        for name in case.report.loops
    ]
    health = _save(
        draw_health(runs),
        folder / "coupling",
        "Iterations, derivative products and residual of every macro step",
    )
    templates = Environment(
        loader=FileSystemLoader(Path(__file__).parent / "templates"), autoescape=True
    )
    templates.filters["words"] = words
    page = templates.get_template("report.html").render(
        case=case,
        runs=[judged(case, label, results) for label, results in runs.items()],
        answers=answers or {},
        names=list(
            dict.fromkeys(line.name for one in (answers or {}).values() for line in one.lines)
        ),
        pictures=pictures,
        health=health,
        data=json.dumps(moving_data(case, runs)).replace("<", "\\u003c"),
        notes=MarkdownIt("commonmark", {"html": False}).enable("table").render(notes),
        studies=[study_table(path) for path in studies],
        tree=json.dumps(next(iter(runs.values())).case, indent=1),
        made=datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
    )
    path = folder / "report.html"
    path.write_text(page, encoding="utf-8")
    return path


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
class Drawing:
    """A figure in the page: its title and the SVG as a data address."""

    title: str
    address: str


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


def _save(figure, stem, title):
    """Save a figure as PNG and SVG; the SVG also as a data address for the page."""
    figure.savefig(stem.with_suffix(".png"), dpi=130)
    text = io.StringIO()
    figure.savefig(text, format="svg")
    stem.with_suffix(".svg").write_text(text.getvalue())
    plt.close(figure)
    packed = base64.b64encode(text.getvalue().encode()).decode()
    return Drawing(title, f"data:image/svg+xml;base64,{packed}")


def draw_loop(case, runs, name):
    """The loop `name` of every run."""
    loop = case.report.loops[name]
    figure, panel = plt.subplots(figsize=(7, 4.5), layout="constrained")
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
    figure, panels = plt.subplots(3, 1, sharex=True, figsize=(11, 6), layout="constrained")
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


def moving_data(case, runs):
    """What the page's script draws: instants with their monitor words, field frames, the moving
    body, a colour table.
    """
    first = next(iter(runs.values()))
    stored = first.instants
    instants = stored[
        np.unique(np.linspace(0, len(stored) - 1, min(FRAMES, len(stored))).round().astype(int))
    ]
    rows = np.searchsorted(first.time, instants - 1e-12)
    words = [
        "  ".join(
            [f"t = {short(float(first.time[k]), 's')}"]
            + [f"{name} {short(q.value, q.unit)}" for name, q in monitored(case, first, k).items()]
        )
        for k in rows
    ]
    units = {port: unit for picture in case.pictures for port, unit in picture.units.items()}
    ports = [port for port in case.record.fields if len(first.dataset(port).shape) == 3]
    colours = (plt.get_cmap("viridis")(np.linspace(0, 1, 256))[:, :3] * 255).astype(int).tolist()
    return {
        "words": words,
        "labels": list(runs),
        "colours": colours,
        "fields": [
            field_frames(port, runs, instants, units.get(port)) | {"axes": axes_words(case, port)}
            for port in ports
        ],
        "motion": motion_frames(case.report.motion, runs, instants) if case.report.motion else None,
    }


def axes_words(case, port):
    """What a field's axes run along, as a line below its map."""
    axes = case.axes_of(port)
    low, high = axes.first.range
    return f"{low:g} to {high:g} {axes.first.marked} (to the right), {axes.second.marked} (upwards)"


def field_frames(port, runs, instants, wanted):
    """Frames of a field at the instants for every run: 16-bit whole numbers over one common range,
    packed as base64.
    """
    stacks = []
    unit = ""
    for results in runs.values():
        dataset = results.dataset(port)
        stored = results.instants
        nearest = np.abs(stored[None, :] - instants[:, None]).argmin(axis=1)
        values, unit = scaled(dataset[:][nearest], dataset.attrs["unit"], wanted)
        stacks.append(values)
    low = min(float(stack.min()) for stack in stacks)
    high = max(float(stack.max()) for stack in stacks)
    levels = [((s - low) / ((high - low) or 1.0) * LEVELS).round().astype("<u2") for s in stacks]
    return {
        "name": name_of(port),
        "unit": unit,
        "low": low,
        "high": high,
        "shape": list(stacks[0].shape[1:]),
        "frames": [base64.b64encode(level.tobytes()).decode() for level in levels],
    }


def motion_frames(motion, runs, instants):
    """Outline, lines and the three motions at the instants, in SI."""

    def point(pair):
        return [to_si(text, "m") for text in pair]

    tracks = []
    for results in runs.values():
        rows = np.searchsorted(results.time, instants - 1e-12)
        tracks.append(
            {
                key: results.series(getattr(motion, key))[0][rows].tolist()
                for key in ("across", "along", "rotation")
            }
        )
    return {
        "outline": [point(p) for p in motion.outline],
        "lines": [[point(p) for p in line] for line in motion.lines],
        "exaggeration": motion.exaggeration,
        "tracks": tracks,
    }
