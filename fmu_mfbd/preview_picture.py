"""A picture of skirt and bore before anything is computed: developed, around and along."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib import colormaps
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke

from .preview_temperatures import WarmWalls

UM = 1e6
MM = 1e3
CELSIUS = 1.0, "\N{DEGREE SIGN}C"
"""Factor and unit of a temperature in a picture."""
LEGEND_POSITION = (0.5, -0.2)
"""Position of a legend below its panel, where it covers no curve."""
SIDES = {"thrust": 90.0, "anti-thrust": 270.0, "pin": 0.0}
COLOURS = {"thrust": "#0072b2", "anti-thrust": "#d55e00", "pin": "#009e73"}
"""Colours of Okabe and Ito (2008), which differ for all kinds of colour vision."""
HEIGHTS = {0.1: "#d55e00", 0.5: "#0072b2", 0.9: "#009e73"}
"""Heights of the sections around as fractions of the skirt, and their colours."""


class Shapes(NamedTuple):
    """Both surfaces on the film grid, c x a cells, and the bore's at its own heights.

    Parameters
    ----------
    angle, height : ndarray, shapes (c,), (a,)
        theta [rad] from the pin axis towards the thrust side; y' above the pin [m].
    film : ndarray of bool, shape (c, a)
        Cells with the skirt under them.
    skirt_cold, skirt_hot : ndarray, shape (c, a)
        Clearance and profile of the concentric skirt in a cylinder [m].
    bore_height : ndarray, shape (s,)
        Above the crank axis [m].
    bore_cold, bore_hot : ndarray, shape (c, s)
        Widening of the bore [m].
    pin_height : ndarray, shape (p,)
        Heights of the pin above the crank axis along the stroke [m].
    walls : WarmWalls, optional
        Temperatures of both surfaces.
    """

    angle: np.ndarray
    height: np.ndarray
    film: np.ndarray
    skirt_cold: np.ndarray
    skirt_hot: np.ndarray
    bore_height: np.ndarray
    bore_cold: np.ndarray
    bore_hot: np.ndarray
    pin_height: np.ndarray
    walls: WarmWalls | None = None

    def clearance(self, hot: bool) -> np.ndarray:
        """Return the smallest clearance of each cell over the stroke [m], shape (c, a).

        The piston is concentric and undeformed.
        """
        skirt = self.skirt_hot if hot else self.skirt_cold
        bore = self.bore_hot if hot else self.bore_cold
        widening = [
            [np.interp(place + self.height, self.bore_height, line) for line in bore]
            for place in self.pin_height
        ]
        return skirt + np.min(widening, axis=0)


def draw_shapes(shapes: Shapes, path: Path | str) -> None:
    """Draw skirt and bore, cold and hot: developed with grey openings, around and along.

    Sections are at three heights and on three sides. The suffix of the path is the type of the
    picture.
    """
    rows = 3 if shapes.walls else 2
    figure = Figure(figsize=(12, 4 * rows))
    FigureCanvasAgg(figure)  # a file only, without pyplot, which is slow to import
    grid = figure.add_gridspec(rows, 2)
    figure.subplots_adjust(0.06, 0.28 / rows, 0.98, 0.97, wspace=0.2, hspace=0.35)
    is_cylinder = not shapes.bore_hot.any()
    developed = figure.add_subplot(grid[0, :] if is_cylinder else grid[0, 0])
    gap = np.ma.masked_where(~shapes.film, shapes.clearance(hot=True))
    draw_developed(figure, developed, shapes.angle, shapes.height, gap)
    _mark_smallest(developed, shapes, gap)
    title = f"smallest clearance over the stroke, hot; {shapes.film.mean():.0%} has a film"
    title += "; the hot bore is a cylinder" if is_cylinder else ""
    developed.set(title=title, ylabel="height above the pin [mm]")
    if not is_cylinder:
        bore = figure.add_subplot(grid[0, 1])
        draw_developed(figure, bore, shapes.angle, shapes.bore_height, shapes.bore_hot)
        bore.set(title="widening of the bore, hot", ylabel="height above the crank axis [mm]")
    if shapes.walls:
        _temperatures(figure, [figure.add_subplot(grid[1, k]) for k in range(2)], shapes)
    _around(figure.add_subplot(grid[-1, 0]), shapes)
    _along(figure.add_subplot(grid[-1, 1]), shapes)
    figure.savefig(path, dpi=110 if Path(path).suffix == ".png" else 72)


def _mark_smallest(panel, shapes, gap):
    """Mark the cell of the smallest clearance by a ring, with its value."""
    i, j = np.unravel_index(gap.argmin(), gap.shape)
    at = np.degrees(shapes.angle[i]) % 360.0, MM * shapes.height[j]
    halo = [withStroke(linewidth=3, foreground="white")]
    panel.plot(*at, "o", mfc="none", mec="black", ms=9, path_effects=halo)
    text = f"{UM * gap[i, j]:.3g} \N{MICRO SIGN}m"
    shift = (10, 0) if at[0] < 300.0 else (-10, 0)
    side = "left" if at[0] < 300.0 else "right"
    panel.annotate(
        text, at, shift, textcoords="offset points", ha=side, va="center", path_effects=halo
    )


def _temperatures(figure, panels, shapes):
    """Draw the temperatures of skirt and bore."""
    angle, walls = shapes.angle, shapes.walls
    skirt = np.ma.masked_where(~shapes.film, walls.skirt - 273.15)
    sides = (
        ("skirt", "pin", shapes.height, skirt),
        ("bore", "crank axis", shapes.bore_height, walls.bore - 273.15),
    )
    for panel, (name, origin, height, field) in zip(panels, sides):
        draw_developed(figure, panel, angle, height, field, CELSIUS)
        title = f"temperature of the {name} at the start"
        panel.set(title=title, ylabel=f"height above the {origin} [mm]")


def draw_developed(figure, panel, angle, height, values, scale=(UM, "\N{MICRO SIGN}m")):
    """Draw a developed surface with contours; the first cell follows the last.

    `scale` is a factor and the unit of its product.
    """
    factor, unit = scale
    values = factor * values[np.r_[: len(values), 0]].T
    degrees = np.degrees(angle[0]) + 360.0 / len(angle) * np.arange(len(angle) + 1)
    half = 180.0 / len(angle)
    step = (height[1] - height[0]) / 2
    around = (degrees[0] - half, degrees[-1] + half)
    along = MM * (height[0] - step), MM * (height[-1] + step)
    image = panel.imshow(
        values,
        origin="lower",
        aspect="auto",
        extent=(*around, *along),
        cmap=colormaps["viridis"].with_extremes(bad="#d5dade"),
        interpolation="bilinear",
    )
    if values.min() < values.max():
        lines = panel.contour(degrees, MM * height, values, 6, colors="white", linewidths=0.5)
        panel.clabel(lines, fontsize=6, fmt="%.3g")
    figure.colorbar(image, ax=panel, label=unit)
    mark_angles(panel)


def mark_angles(panel):
    panel.set_xticks(
        [0, 90, 180, 270, 360], ["0\npin", "90\nthrust", "180", "270\nanti-thrust", "360\npin"]
    )
    panel.set_xlim(0, 360)
    panel.set_xlabel("angle from the pin axis [deg]")


def _around(panel, shapes):
    """Draw the skirt's clearance around, at its lower and upper quarter and in the middle."""
    closed = np.r_[: len(shapes.angle), 0]
    degrees = np.degrees(shapes.angle[0]) + np.linspace(0.0, 360.0, len(closed))
    count = len(shapes.height)
    hot, cold = shapes.clearance(hot=True), shapes.clearance(hot=False)
    for share, colour in HEIGHTS.items():
        j = min(int(share * count), count - 1)
        name = f"{MM * shapes.height[j]:.3g} mm above the pin"
        panel.plot(degrees, UM * hot[closed, j], color=colour, label=name)
        if (hot != cold).any():
            panel.plot(degrees, UM * cold[closed, j], "--", color=colour, lw=0.8)
    panel.set(title=_section("around", hot, cold), ylabel="clearance [\N{MICRO SIGN}m]")
    mark_angles(panel)
    panel.grid(alpha=0.3)
    panel.legend(
        fontsize="small", frameon=False, ncols=3, loc="upper center", bbox_to_anchor=LEGEND_POSITION
    )


def _section(way, hot, cold):
    """Return the title of a section, with the meaning of dashed curves if there are any."""
    return f"section {way}" + (" (dashed: cold)" if (hot != cold).any() else "")


def _along(panel, shapes):
    """Draw the skirt's clearance along the thrust faces and above the pin.

    The curve of the thrust face is wide, so that it is visible behind an equal other one.
    """
    degrees = np.degrees(shapes.angle) % 360
    hot, cold = shapes.clearance(hot=True), shapes.clearance(hot=False)
    for name, where in SIDES.items():
        i = int(np.argmin(np.abs((degrees - where + 180) % 360 - 180)))
        height, width = MM * shapes.height, 4.0 if name == "thrust" else 1.5
        panel.plot(UM * hot[i], height, color=COLOURS[name], lw=width, label=name)
        if (hot != cold).any():
            panel.plot(UM * cold[i], height, "--", color=COLOURS[name], lw=width / 2)
    panel.set(
        title=_section("along", hot, cold),
        xlabel="clearance [\N{MICRO SIGN}m]",
        ylabel="height above the pin [mm]",
    )
    panel.grid(alpha=0.3)
    panel.legend(
        fontsize="small", frameon=False, ncols=3, loc="upper center", bbox_to_anchor=LEGEND_POSITION
    )
