"""Temperatures of skirt and bore: free growth of both walls, its work, and the oil between them.

The temperature of a wall is its level, an input, plus a field. Without build options it is uniform.
A field of the build options does not change. A field of an input may change between steps.
"""

from typing import Any, NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable, compiled
from ..geometry.arrays import Matrix, Vector
from ..geometry.film import by_rows, on_rows
from ..geometry.profile import linear_growth
from ..geometry.surfaces import count_of, surface_at
from .contradictions import Fit
from .parameters import Settings
from .skirt_films import cells_of, stack_film, window_of


class Radii(NamedTuple):
    """Radii of skirt and bore at the reference temperature [m], 0 for a wall that does not grow."""

    skirt: float
    bore: float


class FieldInputs(NamedTuple):
    """Temperatures of walls as field inputs, without elements for a wall that has none [K].

    Parameters
    ----------
    skirt : ndarray, shape (cells,)
        On all films of the skirt, stacked.
    bore : ndarray, shape (c * s,)
        At the angles of the film grid and equally spaced heights of the bore, C order.
    """

    skirt: Vector
    bore: Vector


class ColdWalls(NamedTuple):
    """Walls whose temperature is a field input, without their growth; no elements otherwise.

    Parameters
    ----------
    gap : ndarray, shape (cells,)
        Gap h_0 of all skirt grids without growth, stacked [m].
    shape : ndarray, shape (knots, c)
        As of `BoreSplines` [m].
    rule : ndarray, shape (knots, s)
        From heights of the bore to spline coefficients, Eq. (H3).
    """

    gap: Vector
    shape: Matrix
    rule: Matrix


@compilable
def free_radii(radii: Radii, is_given: bool, p: Settings) -> Radii:
    """Return the radii of the walls that grow freely with their temperature.

    Parameters
    ----------
    radii : Radii
        0 for a wall whose profile is that of the running engine.
    is_given : bool
        Whether build options give the temperatures. Then the growth of a wall that parameters give
        replaces its free growth, otherwise they add up.
    p : Settings
    """
    skirt, bore = radii.skirt, radii.bore
    if is_given and (p.skirt_growth_lower != 0.0 or p.skirt_growth_upper != 0.0):
        skirt = 0.0
    if is_given and (p.bore_growth_lower != 0.0 or p.bore_growth_upper != 0.0):
        bore = 0.0
    return Radii(skirt, bore)


@compilable
def thermal_opening(
    radii: Radii, piston_temperature: float, bore_temperature: float, p: Settings
) -> float:
    """Return the change of the film thickness on the skirt with the levels of temperature [K].

    Eq. (I12):  w = alpha_b R_b (T_b - T_0) - alpha_p R_p (T_p - T_0)

    Piston and bore grow freely. The mechanism and the films of pin and crank do not change.
    `wall_growth` adds what differs from the level.
    """
    bore = p.bore_expansion * radii.bore * (bore_temperature - p.reference_temperature)
    skirt = p.piston_expansion * radii.skirt * (piston_temperature - p.reference_temperature)
    return bore - skirt  # Eq. (I12)


@compilable
def wall_growth(expansion: float, radius: float, temperature):
    """Return the radial growth of a wall by the difference of its temperature from the level [m].

    Eq. (I20):  u_r(theta, y) = alpha R (T(theta, y) - T_level)

    Every part of the wall grows freely, as if its neighbours had the same temperature. With the
    growth of the level, Eq. (I12), it is alpha R (T - T_0).

    Parameters
    ----------
    expansion : float
        alpha [1/K].
    radius : float
        R [m], 0 for a wall that does not grow.
    temperature : float or ndarray
        T - T_level, at cells of a skirt or as spline coefficients of a bore [K].

    >>> print(f"{1e6 * wall_growth(21e-6, 0.04, 50.0):.0f} um")
    42 um
    """
    return expansion * radius * temperature  # Eq. (I20)


@compilable
def warm(surfaces: np.ndarray, fit: Fit, p: Settings) -> None:
    """Add the rise from edge to edge to the temperatures of walls that are given.

    Eq. (I21):  T - T_level = rise (2 y - y_l - y_u) / (2 (y_u - y_l))
    """
    count = count_of(surfaces)
    bore = surface_at(surfaces, 0).bore
    if len(bore.temperature) == 0:
        return
    half = p.skirt_temperature_rise / 2
    for s in range(count):
        skirt = surface_at(surfaces, s).skirt
        c, a = skirt.temperature.shape
        for j in range(a):
            rise = linear_growth(skirt.height[j], fit.skirt_lower, fit.skirt_upper, -half, half)
            for i in range(c):
                skirt.temperature[i, j] += rise  # Eq. (I21)
    half = p.bore_temperature_rise / 2
    knots, c = bore.temperature.shape
    for k in range(knots):
        height = bore.lowest + k * bore.spacing
        rise = linear_growth(height, fit.bore_lower, fit.bore_upper, -half, half)
        for i in range(c):
            bore.temperature[k, i] += rise  # splines have the values of a line as coefficients


@compilable
def widen(surfaces: np.ndarray, p: Settings, radii: Radii) -> None:
    """Add the growth of both walls by differences from their levels, Eq. (I20)."""
    bore = surface_at(surfaces, 0).bore
    if len(bore.temperature) == 0:
        return
    for s in range(count_of(surfaces)):
        skirt = surface_at(surfaces, s).skirt
        c, a = skirt.temperature.shape
        for i in range(c):
            for j in range(a):
                warmth = skirt.temperature[i, j]
                skirt.gap[i, j] -= wall_growth(p.piston_expansion, radii.skirt, warmth)
    knots, c = bore.temperature.shape
    for k in range(knots):
        for i in range(c):
            bore.shape[k, i] += wall_growth(p.bore_expansion, radii.bore, bore.temperature[k, i])


@compilable
def cold_walls(surfaces: np.ndarray, fields: tuple[bool, bool], rule: np.ndarray) -> ColdWalls:
    """Return the walls that field inputs warm, of surfaces with no growth yet.

    Parameters
    ----------
    surfaces : ndarray
        Block of all film surfaces.
    fields : (bool, bool)
        Whether the temperatures of skirt and bore are field inputs.
    rule : ndarray
        As of `ColdWalls`.
    """
    of_skirt, of_bore = fields
    count = count_of(surfaces)
    cells = 0
    for s in range(count):
        cells += surface_at(surfaces, s).skirt.gap.size
    gap = np.zeros(cells if of_skirt else 0)
    first = 0
    for s in range(count if of_skirt else 0):
        own = surface_at(surfaces, s).skirt.gap
        for i in range(own.shape[0]):
            for j in range(own.shape[1]):
                gap[first] = own[i, j]
                first += 1
    shape = surface_at(surfaces, 0).bore.shape
    knots, around = shape.shape
    cold = np.zeros((knots if of_bore else 0, around))
    for k in range(len(cold)):
        for i in range(around):
            cold[k, i] = shape[k, i]
    return ColdWalls(gap, cold, rule)


@compiled
def level_of(field: np.ndarray, even: float) -> float:
    """Return the level of a wall's temperature [K]: the mean of a field, or the even one."""
    if len(field) == 0:
        return even
    total = 0.0
    for value in field:
        total += value
    return total / len(field)


@compiled
def warm_walls(
    surfaces: np.ndarray, cold: ColdWalls, radii: Radii, p: Settings, fields: FieldInputs
) -> None:
    """Overwrite temperature and growth of the walls that have a field input.

    Everything follows from the fields, so that a repeated step has the same bits.
    """
    level = level_of(fields.skirt, 0.0)
    first = 0
    for s in range(count_of(surfaces) if len(fields.skirt) else 0):
        skirt = surface_at(surfaces, s).skirt
        c, a = skirt.gap.shape
        for i in range(c):
            for j in range(a):
                difference = fields.skirt[first] - level
                skirt.temperature[i, j] = difference
                growth = wall_growth(p.piston_expansion, radii.skirt, difference)
                skirt.gap[i, j] = cold.gap[first] - growth
                first += 1
    if len(fields.bore) == 0:
        return
    level = level_of(fields.bore, 0.0)
    bore = surface_at(surfaces, 0).bore
    knots, around = bore.temperature.shape
    stations = cold.rule.shape[1]
    for k in range(knots):
        for i in range(around):
            total = 0.0
            for s in range(stations):
                total += cold.rule[k, s] * (fields.bore[i * stations + s] - level)
            bore.temperature[k, i] = total
            growth = wall_growth(p.bore_expansion, radii.bore, total)
            bore.shape[k, i] = cold.shape[k, i] + growth


@compiled
def field_growth(
    surfaces: np.ndarray, radii: Radii, p: Settings, fields: FieldInputs
) -> np.ndarray:
    """Return the growth by field inputs: that of all cells, then that of the bore's knots [m]."""
    bore = surface_at(surfaces, 0).bore
    cells = len(fields.skirt)
    out = np.zeros(cells + (bore.temperature.size if len(fields.bore) else 0))
    first = 0
    for s in range(count_of(surfaces) if cells else 0):
        skirt = surface_at(surfaces, s).skirt
        c, a = skirt.temperature.shape
        for i in range(c):
            for j in range(a):
                warmth = skirt.temperature[i, j]
                out[first] = wall_growth(p.piston_expansion, radii.skirt, warmth)
                first += 1
    if len(fields.bore):
        around = bore.temperature.shape[1]
        for k in range(len(bore.temperature)):
            for i in range(around):
                warmth = bore.temperature[k, i]
                out[cells + k * around + i] = wall_growth(p.bore_expansion, radii.bore, warmth)
    return out


@compiled
def growth_work(pressure_force: np.ndarray, change: float) -> float:
    """Return the work of the films on walls that grow [J].

    Eq. (D55):  W = sum F_i (w_1 - w_0)     as Eq. (D11), with the forces at the end of the step

    The source of this energy is heat, because no coordinate of the bodies moves.

    Parameters
    ----------
    pressure_force : ndarray, shape (cells,)
        F of all films of the skirt [N].
    change : float
        w_1 - w_0 of Eq. (I12) [m].
    """
    total = 0.0
    for k in range(len(pressure_force)):
        total += pressure_force[k]
    return total * change  # Eq. (D55)


@compiled
def field_work(
    surfaces: np.ndarray,
    cold: ColdWalls,
    pressure_force: np.ndarray,
    guide_height: float,
    before: np.ndarray,
    growth: np.ndarray,
) -> float:
    """Return the work of the films on walls that grow by field inputs [J], Eq. (D55) by cells.

    The bore is read where the cells are at the end of the step, so that its shape under a moving
    skirt does no work here.

    Parameters
    ----------
    surfaces : ndarray
    cold : ColdWalls
    pressure_force : ndarray, shape (cells,)
        Pressure forces of complete films [N].
    guide_height : float
        Height at which the bore is read [m].
    before, growth : ndarray
        `field_growth` at both ends of the step [m].
    """
    cells = len(cold.gap)
    total = 0.0
    for k in range(cells):
        total -= pressure_force[k] * (growth[k] - before[k])
    if len(growth) == cells:
        return total
    first = 0
    for s in range(count_of(surfaces)):
        surface = surface_at(surfaces, s)
        around = surface.bore.shape.shape[1]
        window = window_of(surface, guide_height)
        below = np.empty((window.knots, around))
        for k in range(window.knots):
            for i in range(around):
                own = cells + (window.first + k) * around + i
                below[k, i] = growth[own] - before[own]
        opened = by_rows(on_rows(window, window.value, below))
        for i in range(opened.shape[0]):
            for j in range(opened.shape[1]):
                total += pressure_force[first + i * opened.shape[1] + j] * opened[i, j]
        first += cells_of(surface)
    return total


@compiled
def oil_temperatures(
    surfaces: np.ndarray, guide_height: float, skirt: float, bore: float
) -> np.ndarray:
    """Return the oil temperature in all films of the skirt, stacked [K]; empty if none is given.

    Eq. (I22):  T_o(theta, y') = (T_s(theta, y') + T_b(theta, Y_0(phi) + y'))/2

    The bore is read where the cell is now. `skirt` and `bore` are the levels [K].

    Parameters
    ----------
    surfaces : ndarray
        Block of all film surfaces.
    guide_height : float
        Y_0, height at which the bore is read [m].
    skirt, bore : float
        Levels of both walls [K].
    """
    count = count_of(surfaces)
    if len(surface_at(surfaces, 0).bore.temperature) == 0:
        return np.zeros(0)
    cells = 0
    for s in range(count):
        cells += cells_of(surface_at(surfaces, s))
    out = np.empty(cells)
    first = 0
    for s in range(count):
        surface = surface_at(surfaces, s)
        window = window_of(surface, guide_height)
        knots = surface.bore.temperature[window.first : window.first + window.knots]
        outer = on_rows(window, window.value, knots)
        c, a = surface.skirt.temperature.shape
        field = np.empty((c, a))
        for i in range(c):
            for j in range(a):
                inner = skirt + surface.skirt.temperature[i, j]
                field[i, j] = (inner + (bore + outer[j, i])) / 2  # Eq. (I22)
        stack_film(out, first, surface, field)
        first += cells_of(surface)
    return out


def wall_faults(options: Any, piston: Any, block: Any) -> list[str]:
    """Return the faults of tables of temperature that do not cover their wall.

    Parameters
    ----------
    options : BuildOptions
    piston : ReducedPiston
    block : ReducedBlock
    """
    walls = options.temperatures
    ends = {
        "skirt": (piston.skirt_lower, piston.skirt_upper),
        "bore": (float(block.heights[0]), float(block.heights[-1])),
    }
    out = []
    for name, (lower, upper) in ends.items() if walls else ():
        table = getattr(walls, name).table
        if table is None:
            continue
        first, last = float(table.height[0]), float(table.height[-1])
        slack = 1e-6 * (upper - lower)
        if first > lower + slack or last < upper - slack:
            out.append(
                f"temperatures.{name}.file: expected heights from {1e3 * lower:.4g} to "
                f"{1e3 * upper:.4g} mm, the ends of the {name}, got {1e3 * first:.4g} to "
                f"{1e3 * last:.4g} mm; check height_unit"
            )
    if walls and walls.bore.varies and walls.stations != len(block.heights):
        out.append(
            f"temperatures.bore: expected a field at {len(block.heights)} heights of the bore, got "
            f"{walls.stations}"
        )
    return out
