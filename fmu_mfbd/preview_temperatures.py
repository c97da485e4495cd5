"""Temperatures of skirt and bore before a run: figures, growth of both walls, and messages."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from ..master.fmi.preview import Figure, Message
from ..master.fmi.quantities import short
from .dynamics.build_options import BuildOptions, WallTemperature
from .dynamics.clearance import warmth
from .dynamics.parameters import REFERENCE, Parameters, settings_of
from .dynamics.thermal_growth import Radii, free_radii, wall_growth
from .geometry.profile import linear_growth
from .variables import WALL_FIELDS, WALL_LEVELS, WALL_TEMPERATURES

PARTS = {"skirt": "piston", "bore": "block"}
"""Body of each wall."""


class WarmWalls(NamedTuple):
    """Temperatures and growth of both walls at the start.

    Parameters
    ----------
    skirt, bore : ndarray, shapes (c, a), (c, s)
        On the film grid, and at the heights of the bore's table [K].
    skirt_edges : ndarray, shape (c, 2)
        At the lower and upper edge; of a field input, in the first and last row [K].
    skirt_growth, bore_growth : ndarray
        Radial growth there [m], 0 for a wall that does not grow.
    free : Radii
        Radii of both walls, also of those that do not grow [m].
    """

    skirt: np.ndarray
    bore: np.ndarray
    skirt_edges: np.ndarray
    skirt_growth: np.ndarray
    bore_growth: np.ndarray
    free: Radii


def warm_walls(
    prepared: BuildOptions,
    chosen: Parameters,
    values: Mapping[str, Any],
    grid: tuple[np.ndarray, np.ndarray, np.ndarray],
    ends: tuple[float, float],
    radii: Radii,
) -> WarmWalls | None:
    """Return the temperatures of both walls, or None if the case has none.

    Parameters
    ----------
    prepared : BuildOptions
    chosen : Parameters
    values : mapping
        Parameters of the case by name, also those that are not in `Parameters`, in SI.
    grid : (angle, height, bore_height)
        Lines of the film grid, and heights of the bore's table [rad], [m].
    ends : (float, float)
        Lower and upper edge of the skirt [m].
    radii : Radii
        Radii of both walls [m].
    """
    walls = prepared.temperatures
    if walls is None and not {*WALL_LEVELS.values()} & values.keys():
        return None
    angle, height, heights = grid

    def field(name: str, rows: np.ndarray, low: float, high: float) -> np.ndarray:
        even = WallTemperature(float(values.get(WALL_LEVELS[name], REFERENCE)))
        wall = getattr(walls, name) if walls else even
        shape = (len(angle), len(rows))
        if wall.varies:
            start = np.asarray(values.get(WALL_FIELDS[name], wall.level))
            return start.reshape(shape) if start.size == np.prod(shape) else np.full(shape, start)
        half = float(values.get(f"{name}_temperature_rise", wall.rise)) / 2
        line = linear_growth(rows, low, high, -half, half)
        return wall.level + warmth(wall, angle, rows) + np.zeros(shape) + line

    skirt = field("skirt", height, *ends)
    bore = field("bore", heights, float(heights[0]), float(heights[-1]))
    varies = walls is not None and walls.skirt.varies
    edges = skirt[:, [0, -1]] if varies else field("skirt", np.array(ends), *ends)
    p = settings_of(chosen)
    hot = prepared.piston.is_hot, prepared.block.is_hot
    cold = Radii(*(0.0 if one else radius for one, radius in zip(hot, radii)))
    growing = free_radii(cold, walls is not None, p)
    above = p.reference_temperature
    return WarmWalls(
        skirt=skirt,
        bore=bore,
        skirt_edges=edges,
        skirt_growth=wall_growth(p.piston_expansion, growing.skirt, skirt - above),
        bore_growth=wall_growth(p.bore_expansion, growing.bore, bore - above),
        free=radii,
    )


def figures_of_walls(
    walls: WarmWalls, pin_height: np.ndarray, ends: tuple[float, float], bore_height: np.ndarray
) -> list[Figure]:
    """Return the temperatures of both walls and of the oil at their edges, means around.

    Temperatures of the oil are means over the stroke, at positions `pin_height` of the pin [m].
    `ends` are the heights of the edges of the skirt [m].
    """
    inner, outer = walls.skirt_edges.mean(axis=0), walls.bore.mean(axis=0)
    oil = [
        (own + np.interp(pin_height + edge, bore_height, outer).mean()) / 2
        for own, edge in zip(inner, ends)
    ]
    figures = {
        "skirt_temperature": inner,
        "bore_temperature": (outer[0], outer[-1]),
        "oil_temperature": oil,
    }
    return [
        Figure("walls", f"{name}_{edge}_edge", float(value), "K")
        for name, pair in figures.items()
        for edge, value in zip(("lower", "upper"), pair)
    ]


def messages_on_walls(
    prepared: BuildOptions, chosen: Parameters, values: Mapping[str, Any], walls: WarmWalls
) -> list[Message]:
    """Return messages on temperatures that contradict other values of the case."""
    out: list[Message] = []
    fields = {"skirt": walls.skirt, "bore": walls.bore}
    low, high = WALL_TEMPERATURES
    for name, field in fields.items():
        twice = {WALL_LEVELS[name], f"{name}_temperature_rise"} & values.keys()
        for key in sorted(twice) if prepared.temperatures else ():
            text = (
                f"parameters.{key}: expected nothing with build.temperatures.{name}, got "
                f"{values[key]:g} K; give the temperature once"
            )
            out.append(Message("fault", text))
        if prepared.temperatures and not (low <= field.min() and field.max() <= high):
            got = field.min() if field.min() < low else field.max()
            text = f"temperatures.{name}: expected {low:g} to {high:g} K, got {got:g} K"
            out.append(Message("fault", text))
        out += _on_growth(name, prepared, chosen, walls)
    return out


def _on_growth(
    name: str, prepared: BuildOptions, chosen: Parameters, walls: WarmWalls
) -> list[Message]:
    """Return messages on the growth of a wall that the case gives twice, with both values."""
    part = PARTS[name]
    expansion = chosen.piston_expansion if name == "skirt" else chosen.bore_expansion
    above = getattr(walls, name).mean(axis=0) - chosen.reference_temperature
    free = wall_growth(expansion, getattr(walls.free, name), above)
    growth = f"free growth by the temperatures of the {name}: {_um(free[0])} to {_um(free[-1])}"
    keys = f"{name}_growth_lower", f"{name}_growth_upper"
    lower, upper = (getattr(chosen, key) for key in keys)
    body = getattr(prepared, part)
    if body.is_hot:
        key = "hot shape" if body.hot else "shape = 'hot'"
        return [Message("remark", f"{part}: {key} replaces the {growth}")]
    if lower or upper:
        does = "replace the" if prepared.temperatures else "add to the"
        off = f"{_um(lower - free[0])} and {_um(upper - free[-1])}"
        text = (
            f"{keys[0]} = {_um(lower)}, {keys[1]} = {_um(upper)}: {does} {growth}; difference {off}"
        )
        return [Message("warning", text)]
    return []


def messages_on_shapes(build: Any, has_walls: bool) -> list[Message]:
    """Return a remark for each profile of a warm wall that may be cold or hot."""
    return [
        Message("remark", f"{part}.shape not set: the profile of the {name} counts as cold")
        for name, part in PARTS.items()
        if has_walls and getattr(build, part).shape is None
    ]


def _um(length: float) -> str:
    """Return a length [m] as text."""
    return short(float(length), "m") if length else "0 \N{MICRO SIGN}m"
