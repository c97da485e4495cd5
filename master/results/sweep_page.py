"""Page of a sweep: Pareto front, response or map, parallel coordinates, and links to reports."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..fmi.quantities import are_compatible, quantity
from .pages import write_page
from .words import entry_shown, labelled, unit_shown

FIRST = ("friction", "minimum_film_thickness", "slap")
"""Parts of the names of the outputs that a front shows by default: abscissa, ordinate, colour."""
MAPPED = ("minimum_film_thickness", "maximum_pressure", "friction", "slap")
"""Parts of the names of the outputs of the panels."""
ZERO_TOLERANCE = 1e-12
"""Values up to this size are zero, in SI units."""
CONSTANT_RANGE = 1e-6
"""Relative range below which an output counts as constant: the accuracy of macro steps."""
OUTCOMES = ("pass", "warning", "fail")
"""Results of a check, with which the entry `worst_check` of a row begins."""


@dataclass(frozen=True)
class SweptPoint:
    """Row of a sweep's table, and the relative path of its report ("" if there is none).

    Optional entries of the row: `worst_check`, such as "fail: grid", and for any output
    `OUTPUT_uncertainty`, a number in its SI unit or a text.
    """

    row: dict
    report: str


def write_sweep_page(
    points: list[SweptPoint],
    axes: list[str],
    directions: Mapping[str, str],
    path: Path,
    sentence: str = "",
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
    sentence : str
        Comparison of two points.
    """
    done = [point for point in points if point.row["status"] == "done"]
    entries = _drawn_entries([point.row for point in done], directions)
    data = {
        "inputs": [_input(name, done) for name in axes],
        "outputs": [_output(name, done, directions[name]) for name in entries],
        "reports": [point.report for point in done],
        "checks": [_check(point.row) for point in done],
        "chosen": _chosen(entries, FIRST),
        "panels": _chosen(entries, MAPPED),
    }
    return write_page(
        path,
        "sweep.html",
        data,
        title=path.parent.name.removeprefix("sweep_").replace("_", " "),
        done=len(done),
        total=len(points),
        sentence=sentence,
        linked=any(point.report for point in done),
    )


def _drawn_entries(rows, entries) -> list[str]:
    """Return the entries that all rows have as numbers and that vary by more than round-off."""
    drawn = []
    for entry in entries:
        values = [value for row in rows if (value := _number(row, entry)) is not None]
        size = max(map(abs, values), default=0.0)
        if (
            len(values) == len(rows)
            and size > ZERO_TOLERANCE
            and np.ptp(values) > CONSTANT_RANGE * size
        ):
            drawn.append(entry)
    return drawn


def _number(row, entry):
    """Return the value of an entry, or None if the row has no finite number for it."""
    value = row.get(entry)
    return value if isinstance(value, (int, float)) and np.isfinite(value) else None


def _chosen(entries, words):
    """Return the numbers of the outputs with these parts of names, filled up with other outputs.

    If there are too few outputs, the last one is repeated.
    """
    matches = [next((name for name in entries if word in name), None) for word in words]
    order = list(dict.fromkeys([*filter(None, matches), *entries]))
    return [entries.index(order[min(k, len(order) - 1)]) for k in range(len(words)) if order]


def _output(name, done, direction):
    """Return an output with its unit, values and uncertainties (None without one)."""
    known = [point.row.get(f"{name}_uncertainty") for point in done]
    sizes = [_number({"": one}, "") for one in known]
    numbers = [np.nan if size is None else size for size in sizes]
    shown = entry_shown(name, [*(point.row[name] for point in done), *numbers])
    values, scaled = shown.values[: len(done)].tolist(), shown.values[len(done) :].tolist()
    texts = [one if isinstance(one, str) and one else None for one in known]
    errors = [text if size is None else own for text, size, own in zip(texts, sizes, scaled)]
    if not any(error is not None for error in errors):
        errors = []
    return {"name": shown.label, "direction": direction, "values": values, "uncertainties": errors}


def _check(row):
    """Return the worst outcome of a row's checks and its text; "" if it was not checked."""
    text = str(row.get("worst_check") or "")
    outcome = next((word for word in OUTCOMES if text.startswith(word)), "")
    return {"outcome": outcome, "text": text}


def _input(name, done):
    """Return a varied key with its unit and its values, or their positions if they are names."""
    entries = [point.row[name] for point in done]
    texts = [str(value) for value in entries]
    words = _key_in_words(name)
    known = [one for value in entries if (one := _quantity(value)) is not None]
    first = known[0].units if known else None
    if len(known) < len(entries) or not all(are_compatible(one.units, first) for one in known):
        order = list(dict.fromkeys(texts))
        values = [float(order.index(text)) for text in texts]
        return {"name": words, "values": values, "texts": texts, "named": True}
    values = [float(one.to(first).magnitude) for one in known]
    unit = next((text.lstrip("+-.0123456789eE").strip() for text in texts), "")
    shown = [f"{value:g}" for value in values]
    label = labelled(words, unit_shown(unit, unit))
    return {"name": label, "values": values, "texts": shown, "named": False}


def _key_in_words(name):
    """Return the last part of a key in words; of a file with what it contains."""
    parts = [part for part in name.split(".") if not part.isdecimal()]
    return " ".join(parts[-2 if parts[-1] == "file" else -1 :]).replace("_", " ")


def _quantity(value) -> Any | None:
    """Return a number or a text with a unit as quantity, None for a name."""
    if isinstance(value, bool) or not isinstance(value, (int, float, str)):
        return None
    try:
        return quantity(str(value))
    except ValueError:
        return None
