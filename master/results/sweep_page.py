"""Page of a sweep: Pareto front, response, parallel coordinates, and links to reports."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..fmi.quantities import quantity
from .pages import write_page
from .pictures import entry_shown, unit_shown

FIRST = ("friction", "minimum_film_thickness", "slap")
"""Parts of the names of the outputs that a front shows by default: abscissa, ordinate, colour."""
ROUNDING = 1e-12
"""Values up to this size are zero, in SI units."""
SAME = 1e-6
"""Relative range below which an output counts as constant: the accuracy of macro steps."""


@dataclass(frozen=True)
class SweptPoint:
    """Row of a sweep's table, and the relative path of its report ("" if there is none)."""

    row: dict
    report: str


def write_sweep_page(
    points: list[SweptPoint], axes: list[str], directions: Mapping[str, str], path: Path
) -> Path:
    """Write the page of a sweep's finished points.

    Parameters
    ----------
    points : list of SweptPoint
    axes : list of str
        Columns that were varied.
    directions : mapping of str to {"raise", "lower", "none"}
        Columns of outputs, and the direction of a better design. Constant ones are omitted.
    path : Path
    """
    done = [point for point in points if point.row["status"] == "done"]
    entries = _drawn_entries([point.row for point in done], directions)
    data = {
        "inputs": [_input(name, done) for name in axes],
        "outputs": [_output(name, done, directions[name]) for name in entries],
        "reports": [point.report for point in done],
        "chosen": _chosen(entries),
    }
    return write_page(
        path,
        "sweep.html",
        data,
        title=path.parent.name.removeprefix("sweep_").replace("_", " "),
        done=len(done),
        total=len(points),
        linked=any(point.report for point in done),
    )


def _drawn_entries(rows, entries) -> list[str]:
    """Return the entries that all rows have as numbers and that vary by more than round-off."""
    found = []
    for entry in entries:
        values = [value for row in rows if (value := _number(row, entry)) is not None]
        size = max(map(abs, values), default=0.0)
        if len(values) == len(rows) and size > ROUNDING and np.ptp(values) > SAME * size:
            found.append(entry)
    return found


def _number(row, entry):
    """Return the value of an entry, or None if the row has no finite number for it."""
    value = row.get(entry)
    return value if isinstance(value, (int, float)) and np.isfinite(value) else None


def _chosen(entries):
    """Return the numbers of the three default outputs; without a third one, the first again."""
    found = [next((name for name in entries if word in name), None) for word in FIRST]
    order = list(dict.fromkeys([*filter(None, found), *entries]))
    return [entries.index(order[min(k, len(order) - 1)]) for k in range(3)] if order else []


def _output(name, done, direction):
    label, values = entry_shown(name, [point.row[name] for point in done])
    return {"name": label, "direction": direction, "values": values.tolist()}


def _magnitude(value):
    """Return the number of a quantity in its own unit, or of a number; None for others."""
    if isinstance(value, (int, float)):
        return value
    try:
        return quantity(str(value)).magnitude
    except ValueError:
        return None


def _input(name, done):
    """Return a varied key with its unit and its values, or their numbers if they are texts."""
    texts = [str(point.row[name]) for point in done]
    numbers = [_magnitude(point.row[name]) for point in done]
    order = list(dict.fromkeys(texts))
    known = [number for number in numbers if number is not None]
    values = known if len(known) == len(numbers) else [order.index(text) for text in texts]
    units = {text.lstrip("+-.0123456789eE").strip() for text in texts}
    unit = units.pop() if len(known) == len(numbers) and len(units) == 1 else ""
    words = name.split(".")[-1].replace("_", " ")
    label = f"{words} [{unit_shown(unit, unit)}]" if unit else words
    shown = [f"{value:g}" for value in values] if unit else texts
    return {"name": label, "values": np.asarray(values, float).tolist(), "texts": shown}
