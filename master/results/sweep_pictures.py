"""Pictures of a sweep: results over the first axis, a curve for each combination of others."""

import numpy as np

from ..fmi.quantities import registry
from .figures import PALETTE, add_legend, save, subplots
from .pictures import entry_shown

ROUNDING = 1e-12
"""Values up to this size are zero, in SI units."""
SAME = 1e-6
"""Relative range below which an output counts as constant: the accuracy of macro steps."""


def magnitude(value):
    """Return the number of a quantity in its own unit, or of a number; None for others."""
    if isinstance(value, (int, float)):
        return value
    try:
        return registry().Quantity(value).magnitude
    except Exception:
        return None


def draw_sweep(rows, axes, entries, path):
    """Draw the `entries` of the finished rows.

    Parameters
    ----------
    rows : list of dict
        As `sweep.sweep` returns them.
    axes : list of Axis
    entries : iterable of str
        Columns to draw; those that do not vary are omitted.
    path : Path
        The picture.

    Returns
    -------
    Path
    """
    first = axes[0]
    others = [axis.name for axis in axes[1:]]
    names = [name.split(".")[-1].replace("_", " ") for name in others]
    done = [row for row in rows if row["status"] == "done"]
    entries = drawn_entries(done, entries)
    lines = max(1, -(-len(entries) // 2))
    figure, panels = subplots(lines, 2, squeeze=False, figsize=(11, 1 + 2.6 * lines))
    for panel in panels.flat[len(entries) :]:
        panel.remove()
    for panel, entry in zip(panels.flat, entries):
        title, shown = entry_shown(entry, [row[entry] for row in done])
        keys = [tuple(str(row[name]) for name in others) for row in done]
        for k, key in enumerate(dict.fromkeys(keys)):
            chosen = [n for n, other in enumerate(keys) if other == key]
            positions = [magnitude(done[n][first.name]) for n in chosen]
            named = None in positions
            panel.plot(
                [str(done[n][first.name]) for n in chosen] if named else positions,
                shown[chosen],
                "o-",
                ms=4,
                lw=1.2,
                color=PALETTE[k % len(PALETTE)],
                label=", ".join(map(" ".join, zip(names, key))),
            )
        panel.set_title(title, fontsize="small")
        panel.grid(alpha=0.3)
    if others and len(entries):
        add_legend(panels[0, 1] if len(entries) > 1 else panels[0, 0])
    figure.supxlabel(_heading(first))
    return save(figure, path)


def drawn_entries(rows, entries) -> list[str]:
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


def _heading(axis):
    """Return the name of an axis with its unit."""
    try:
        unit = (
            f"{registry().Quantity(axis.values[0]).units:~P}"
            if isinstance(axis.values[0], str)
            else ""
        )
    except Exception:
        unit = ""
    name = axis.name.split(".")[-1].replace("_", " ")
    return f"{name} [{unit}]" if unit else name
