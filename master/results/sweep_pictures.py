"""Pictures of a sweep: every summary entry of the case over the first axis, a curve for each
combination of the others.
"""

from ..fmi.quantities import registry
from .figures import subplots
from .pictures import PALETTE, entry_in_words


def magnitude(value):
    """Number on an axis: quantities in their own unit, numbers as they are, anything else None."""
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
        Columns to draw.
    path : Path
        The picture.

    Returns
    -------
    Path
    """
    first = axes[0]
    others = [axis.name for axis in axes[1:]]
    done = [row for row in rows if row["status"] == "done"]
    entries = [entry for entry in entries if done]
    lines = max(1, -(-len(entries) // 2))
    figure, panels = subplots(lines, 2, squeeze=False, figsize=(11, 1 + 2.6 * lines))
    for panel, entry in zip(panels.flat, entries):
        for k, key in enumerate(
            dict.fromkeys(tuple(str(row[name]) for name in others) for row in done)
        ):
            chosen = [row for row in done if tuple(str(row[name]) for name in others) == key]
            positions = [magnitude(row[first.name]) for row in chosen]
            named = None in positions
            panel.plot(
                range(len(chosen)) if named else positions,
                [row[entry] for row in chosen],
                "o-",
                ms=4,
                lw=1.2,
                color=PALETTE[k % len(PALETTE)],
                label=", ".join(key),
            )
            if named:
                panel.set_xticks(
                    range(len(chosen)), [str(row[first.name]) for row in chosen], fontsize="small"
                )
        panel.set_title(entry_in_words(entry), fontsize="small")
        panel.grid(alpha=0.3)
    for panel in panels[-1]:
        panel.set_xlabel(_heading(first))
    if others and len(entries):
        panels[0, 0].legend(
            title=", ".join(name.split(".")[-1].replace("_", " ") for name in others),
            fontsize="small",
            frameon=False,
        )
    figure.savefig(path, dpi=130)
    return path


def _heading(axis):
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
