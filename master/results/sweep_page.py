"""The page of a sweep: parallel coordinates, response surface, Pareto front; every point links to
its report.
"""

import json
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jinja2 import Environment, FileSystemLoader
from matplotlib import colormaps

from .pictures import entry_shown
from .sweep_pictures import magnitude

WORDS = ("friction", "slap", "contact")
"""What a front is first drawn of: entries whose names hold these."""


@dataclass(frozen=True)
class SweptPoint:
    """A row of a sweep's table, and where its report is seen from the page ("" without one)."""

    row: dict
    report: str


def write_sweep_page(
    points: list[SweptPoint],
    axes: list[str],
    weighed: list[str],
    path: Path,
    larger: Collection[str] = (),
) -> Path:
    """Write the page of a sweep's points that are done.

    Parameters
    ----------
    points : list of SweptPoint
    axes : list of str
        Columns that were varied.
    weighed : list of str
        Columns that designs are judged by: those that vary are drawn, the others of a row are not.
    path : Path
    larger : collection of str
        Columns of which large values are good. Small values are good of all others.
    """
    done = [point for point in points if point.row["status"] == "done"]
    entries = [
        name
        for name in dict.fromkeys(weighed)
        if all(isinstance(point.row.get(name), (int, float)) for point in done)
        and np.ptp([float(point.row[name]) for point in done]) > 0
    ]
    shown = [entry_shown(name, [point.row[name] for point in done]) for name in entries]
    chosen = [next((name for name in entries if word in name), None) for word in WORDS]
    colours = (colormaps["viridis"](np.linspace(0, 1, 64))[:, :3] * 255).round().astype(int)
    data = {
        "axes": [_axis(name, done) for name in axes],
        "entries": entries,
        "said": [label for label, _ in shown],
        "larger": [name in larger for name in entries],
        "chosen": [name for name in chosen if name],
        "points": [
            {
                "report": point.report,
                "values": [float(values[k]) for _, values in shown],
                "axes": [str(point.row[name]) for name in axes],
            }
            for k, point in enumerate(done)
        ],
        "colours": colours.tolist(),
    }
    templates = Environment(
        loader=FileSystemLoader(Path(__file__).parent / "templates"), autoescape=True
    )
    text = templates.get_template("sweep.html").render(
        title=path.parent.name,
        left_out=len(points) - len(done),
        linked=any(point.report for point in done),
        data=json.dumps(data).replace("<", "\\u003c"),
    )
    path.write_text(text, encoding="utf-8")
    return path


def _axis(name, done):
    """A varied key with its unit: its values as positions, numbered where they are no numbers."""
    texts = [str(point.row[name]) for point in done]
    numbers = [magnitude(point.row[name]) for point in done]
    order = list(dict.fromkeys(texts))
    known = [number for number in numbers if number is not None]
    values = known if len(known) == len(numbers) else [order.index(text) for text in texts]
    units = {text.lstrip("+-.0123456789eE").strip() for text in texts}
    unit = f" [{units.pop()}]" if len(known) == len(numbers) and len(units) == 1 else ""
    short = name.split(".")[-1].replace("_", " ") + (unit if unit != " []" else "")
    return {"name": short, "values": [float(value) for value in values]}
