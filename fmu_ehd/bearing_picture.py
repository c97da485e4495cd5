"""A picture of a journal bearing in balance: its section with the pressure, and both fields."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

DRAWN_CLEARANCE = 0.35
"""Drawn clearance over the drawn radius of the shell, 1."""
DRAWN_PRESSURE = 0.7
"""Drawn maximum pressure."""
PRESSURE, FILM, BODY = "#b5442e", "#1b4f8a", "#d9d9d9"
DEGREE = "\N{DEGREE SIGN}"


def picture(bearing: Any) -> Figure:
    """Return the section of a bearing, and pressure and film thickness over the angle.

    Parameters
    ----------
    bearing : Bearing

    Returns
    -------
    matplotlib.figure.Figure
    """
    figure = Figure(figsize=(10.0, 4.6), layout="constrained")
    section, curves = figure.subplots(1, 2, width_ratios=(1.0, 1.35))
    order = np.argsort(bearing.film["angle"])
    angle = bearing.film["angle"][order]
    fields = {}
    for name in ("pressure", "film_thickness"):
        values = bearing.film[name][order]
        fields[name] = values[:, values.shape[1] // 2]
    _draw_section(section, bearing, angle, fields["pressure"])
    _draw_curves(curves, bearing, angle, fields)
    figure.suptitle(
        f"S = {bearing.sommerfeld_number:.3g}, e/C = {bearing.eccentricity_ratio:.3f}, "
        f"attitude {np.degrees(bearing.attitude_angle):.1f}{DEGREE}"
    )
    return figure


def _points(angle: Any, radius: Any) -> tuple[Any, Any]:
    """Return x and y of angles from the load, which points down."""
    return radius * np.sin(angle), -radius * np.cos(angle)


def _draw_section(panel: Axes, bearing: Any, angle: Any, pressure: Any) -> None:
    """Draw shell and journal with the clearance enlarged, the pressure, the load and the speed."""
    around = np.append(angle, angle[0] + 2.0 * np.pi)
    height = DRAWN_PRESSURE * np.maximum(pressure, 0.0) / pressure.max()
    outside = _points(around, 1.0 + np.append(height, height[0]))
    shell = _points(around, np.ones(around.size))
    panel.fill(*outside, color=PRESSURE, alpha=0.3, linewidth=0.0)
    panel.plot(*outside, color=PRESSURE, linewidth=1.0)
    panel.fill(*shell, color="white")
    panel.plot(*shell, color="black", linewidth=1.5)
    x, y = DRAWN_CLEARANCE * bearing.film["position"]
    journal = _points(around, (1.0 - DRAWN_CLEARANCE) * np.ones(around.size))
    panel.fill(x + journal[0], y + journal[1], color=BODY)
    panel.plot(x + journal[0], y + journal[1], color="black", linewidth=1.0)
    panel.plot([0.0, x], [0.0, y], "o-", color=FILM, markersize=4.0)
    arrow = dict(arrowstyle="-|>", color="black", linewidth=1.5)
    panel.annotate("", (x, y - 0.55), (x, y), arrowprops=arrow)
    panel.text(x + 0.05, y - 0.5, "load", va="center")
    turn = arrow | dict(connectionstyle="arc3,rad=0.4")
    start, end = (_points(a, 0.4) for a in (2.2, 3.3))
    panel.annotate("", (x + end[0], y + end[1]), (x + start[0], y + start[1]), arrowprops=turn)
    panel.set_aspect("equal")
    panel.set_xlim(-1.05 - DRAWN_PRESSURE, 1.05 + DRAWN_PRESSURE)
    panel.set_ylim(outside[1].min() - 0.05, max(outside[1].max(), 1.0) + 0.05)
    panel.set_axis_off()
    panel.set_title("section, clearance enlarged", fontsize="medium")


def _draw_curves(panel: Axes, bearing: Any, angle: Any, fields: dict[str, Any]) -> None:
    """Draw pressure and film thickness at mid-length, with their extremes."""
    degrees = np.degrees(angle)
    panel.plot(degrees, fields["pressure"] / 1e6, color=PRESSURE)
    panel.set_xlabel(f"angle from the load in the direction of rotation [{DEGREE}]")
    panel.set_ylabel("pressure at mid-length [MPa]", color=PRESSURE)
    panel.set_xlim(-180.0, 180.0)
    panel.set_xticks(range(-180, 181, 60))
    panel.set_ylim(0.0, 1.2 * bearing.maximum_pressure / 1e6)
    top = np.degrees(bearing.maximum_pressure_angle), bearing.maximum_pressure / 1e6
    panel.plot(*top, "o", color=PRESSURE)
    text = f"{top[1]:.3g} MPa"
    panel.annotate(text, top, (-8, 6), textcoords="offset points", ha="right", color=PRESSURE)
    other = panel.twinx()
    other.plot(degrees, 1e6 * fields["film_thickness"], color=FILM)
    other.set_ylabel("film thickness [\N{MICRO SIGN}m]", color=FILM)
    other.set_ylim(0.0, 1.2e6 * fields["film_thickness"].max())
    low = np.degrees(bearing.attitude_angle), 1e6 * bearing.minimum_film_thickness
    other.plot(*low, "o", color=FILM)
    text = f"{low[1]:.3g} \N{MICRO SIGN}m"
    other.annotate(text, low, (6, -2), textcoords="offset points", va="top", color=FILM)
    panel.grid(alpha=0.3)
