"""Pictures of a design: effects of variables, profile of a skirt with its map, and convergence."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.colors import Normalize

from .figures import COLOURS, PALETTE, save, subplots

MOST_BARS = 20
"""Number of variables in a panel; those with the smallest changes are omitted."""


def draw_effects(
    effects: Mapping[str, Mapping[str, tuple[float, float]]], steps: Mapping[str, str], path: Path
) -> Path:
    """Draw the change of each figure with a step of each variable, in percent of the figure.

    Parameters
    ----------
    effects : mapping
        Figure in words -> variable -> change and spread, in percent.
    steps : mapping
        Variable -> its step in words.
    path : Path
    """
    rows = min(MOST_BARS, max(map(len, effects.values())))
    columns = min(3, len(effects))
    lines = -(-len(effects) // columns)
    drawn, panels = subplots(
        lines, columns, figsize=(4.2 * columns, lines * (1.1 + 0.3 * rows)), squeeze=False
    )
    for panel, (figure, bars) in zip(panels.flat, effects.items()):
        order = sorted(bars, key=lambda name: abs(bars[name][0]), reverse=True)[:MOST_BARS]
        changes, spreads = np.array([bars[name] for name in order]).T
        colours = [PALETTE[0] if c > 0.0 else PALETTE[1] for c in changes]
        panel.barh(range(len(order)), changes, xerr=spreads, color=colours, ecolor="0.3", capsize=2)
        panel.set_yticks(
            range(len(order)), [f"{name}, {steps[name]}" for name in order], fontsize=8
        )
        panel.invert_yaxis()
        panel.axvline(0.0, color="0.3", linewidth=0.8)
        panel.grid(axis="x", alpha=0.3)
        panel.set_title(figure, fontsize=10)
        panel.set_xlabel("change [%]")
    for panel in panels.flat[len(effects) :]:
        panel.set_visible(False)
    return save(drawn, path)


def draw_maps(
    maps: Mapping[str, np.ndarray], angles: np.ndarray, heights: np.ndarray, path: Path
) -> Path:
    """Draw developed maps of a skirt, one panel each, with a scale about zero.

    Parameters
    ----------
    maps : mapping of str to ndarray, shape (heights, angles)
        Title with the unit -> values.
    angles : ndarray
        From the pin axis towards the thrust side [deg].
    heights : ndarray
        Above the pin [mm].
    path : Path
    """
    columns = 1 if len(maps) <= 3 else 2
    lines = -(-len(maps) // columns)
    size = {"figsize": (7.5 * columns, 2.6 * lines), "squeeze": False}
    drawn, panels = subplots(lines, columns, sharex=True, sharey=True, **size)
    ends = (angles[0], 360.0, heights[0], heights[-1])
    for panel, (title, values) in zip(panels.flat, maps.items()):
        largest = np.abs(values).max() or 1.0
        image = panel.imshow(
            np.column_stack([values, values[:, 0]]),
            cmap=COLOURS["change"],
            norm=Normalize(-largest, largest),
            extent=ends,
            origin="lower",
            aspect="auto",
            interpolation="bilinear",
        )
        drawn.colorbar(image, ax=panel)
        panel.set_title(title, fontsize=10)
        panel.set_xticks([0, 90, 180, 270, 360])
    for panel in panels.flat[len(maps) :]:
        panel.set_visible(False)
    for panel in panels[:, 0]:
        panel.set_ylabel("height above the pin [mm]", fontsize=8)
    for panel in panels.flat[len(maps) - columns : len(maps)]:
        panel.tick_params(labelbottom=True)
        panel.set_xlabel("angle from the pin axis [deg]; thrust 90, anti-thrust 270")
    return save(drawn, path)


def draw_search(history: Sequence[tuple[float, float]], tolerance: float, path: Path) -> Path:
    """Draw the goal of every design, relative to the case, in percent.

    Parameters
    ----------
    history : sequence of (float, float)
        Objective, 1 or -1 for the case, and the largest excess over a limit (negative or 0).
    tolerance : float
        Excess up to which a design keeps its limits.
    path : Path
    """
    drawn, panel = subplots(figsize=(7.0, 3.6))
    value = 100.0 * np.array([abs(one) for one, _ in history])
    feasible = np.array([slack >= -tolerance for _, slack in history])
    number = np.arange(len(history))
    shown = value <= 3.0 * value[0]
    for mask, colour, label in (
        (feasible, PALETTE[0], "keeps all limits"),
        (~feasible, PALETTE[1], "exceeds a limit"),
    ):
        panel.plot(number[mask & shown], value[mask & shown], "o", color=colour, label=label)
    panel.set_xlabel("design")
    panel.set_ylabel("goal [% of the case]")
    panel.xaxis.get_major_locator().set_params(integer=True)
    panel.grid(alpha=0.3)
    panel.legend(fontsize=8, frameon=False)
    return save(drawn, path)
