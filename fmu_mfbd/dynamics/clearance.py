"""Geometry of the films of the skirt, from reduced bodies, parameters and measured shapes."""

from collections.abc import Sequence

import numpy as np

from ...master.fmi.compiled import compilable
from ..geometry.film import NO_TEMPERATURE, FilmSurface, Skirt, bore_splines
from ..geometry.grid import cell_centres
from ..geometry.modal_field import modal_field
from ..geometry.profile import (
    HotShape,
    MeasuredShape,
    barrel,
    fourier_bore,
    linear_growth,
    ovality,
    table_shape,
    tilt_about_x,
)
from ..geometry.surfaces import count_of, surface_at
from ..reduction.reduced_body import ReducedBlock, ReducedPiston, mode_classes
from .build_options import BlockOptions, BuildOptions, PistonOptions, WallTemperature
from .contradictions import Fit
from .parameters import Parameters, Settings
from .thermal_growth import Radii, warm, widen


def surfaces(
    piston: ReducedPiston, block: ReducedBlock, options: BuildOptions
) -> tuple[FilmSurface, ...]:
    """Return all film surfaces from below: bands of one skirt in one bore, before `machined`."""
    angle, height = cell_centres(*options.grid, piston.skirt_lower, piston.skirt_upper)
    gap = _measured_gap(options.piston, angle, height) + np.zeros(options.grid)
    walls = options.temperatures
    warm = warmth(walls and walls.skirt, angle, height)
    classes = mode_classes(piston)
    grid = (len(angle), len(height), len(piston.omega))
    radial = piston.radial.reshape(grid)
    axial = piston.axial.reshape(grid)
    one_bore = bore_splines(
        block.heights,
        block.radial,
        block.axial,
        mode_classes(block),
        measured_bore(block.heights, angle, options.block) + np.zeros(len(block.heights)),
        warmth(walls and walls.bore, angle, block.heights),
    )
    bands = [slice(one.first, one.last) for one in options.film_surfaces()]
    return tuple(
        FilmSurface(
            Skirt(
                angle=angle,
                height=height[rows],
                gap=np.ascontiguousarray(gap[:, rows]),
                radius=block.radius,
                pin_offset=options.piston.pin_offset,
                radial=modal_field(radial[:, rows], classes),
                axial=modal_field(axial[:, rows], classes),
                rows=np.arange(len(angle), dtype=float),
                temperature=np.ascontiguousarray(warm[:, rows]),
            ),
            one_bore,
        )
        for rows in bands
    )


def warmth(wall: WallTemperature | None, angle: np.ndarray, height: np.ndarray) -> np.ndarray:
    """Return the difference of a wall's temperature from its level, (c, a) [K], without its rise.

    It has no rows and columns if no temperature is given.
    """
    if wall is None:
        return NO_TEMPERATURE
    even = np.zeros((len(angle), len(height)))
    return table_shape(wall.table, angle, height) if wall.table else even


@compilable
def machined(surfaces: np.ndarray, fit: Fit, p: Settings, radii: Radii) -> np.ndarray:
    """Return all film surfaces with profile, tilt and growth of skirt and bore.

    A bore without a table for its widening remains a cylinder. `radii` are those of `free_radii`.
    """
    out = surfaces.copy()
    warm(out, fit, p)
    widen(out, p, radii)
    for k in range(count_of(out)):
        skirt = surface_at(out, k).skirt
        c, a = skirt.gap.shape
        for i in range(c):
            for j in range(a):
                skirt.gap[i, j] += machined_gap(
                    skirt.angle[i], skirt.height[j], fit.skirt_lower, fit.skirt_upper, p
                )
    bore = surface_at(out, 0).bore  # all surfaces share one
    knots, c = bore.shape.shape
    for k in range(knots):
        height = bore.lowest + k * bore.spacing
        wider = linear_growth(
            height, fit.bore_lower, fit.bore_upper, p.bore_growth_lower, p.bore_growth_upper
        )
        for i in range(c):
            bore.shape[k, i] += wider  # splines have the values of a line as coefficients
    return out


def skirt_gap(
    piston: ReducedPiston,
    angle: np.ndarray,
    height: np.ndarray,
    options: PistonOptions,
    parameters: Parameters,
) -> np.ndarray:
    """Return the film thickness around the concentric, undeformed piston, (c, a) [m].

    It is the sum of clearance, machined profile, heat, tilt and measured shapes.
    """
    gap = machined_gap(angle[:, None], height, piston.skirt_lower, piston.skirt_upper, parameters)
    return gap + _measured_gap(options, angle, height)


def _measured_gap(
    options: PistonOptions, angle: np.ndarray, height: np.ndarray
) -> np.ndarray | int:
    """Return the part of `skirt_gap` by measured shapes and the hot shape, (c, a) [m].

    Eq. (I17):  gap(theta, Y) = profile(theta, Y - u_y) - u_r      u by Eq. (I16)
    """
    gap = measured(options.profiles, angle, height, options.hot)
    return gap - options.hot.radial if options.hot else gap  # Eq. (I17)


@compilable
def machined_gap(angle, height, lower, upper, parameters):
    """Return the part of `skirt_gap` that is not measured.

    Angles are (c, 1) [rad], and heights between the skirt's edges (a,) [m].
    """
    gap = parameters.radial_clearance + barrel(height, lower, upper, parameters.barrel)
    gap = gap + ovality(angle, parameters.ovality)
    gap = gap - linear_growth(
        height, lower, upper, parameters.skirt_growth_lower, parameters.skirt_growth_upper
    )
    return gap + tilt_about_x(angle, height, parameters.pin_tilt)


def measured(
    profiles: Sequence[MeasuredShape],
    angle: np.ndarray,
    height: np.ndarray,
    hot: HotShape | None = None,
) -> np.ndarray | int:
    """Return the sum of measured shapes, (c, a) [m], 0 if there are none.

    They move along y with the hot shape.
    """
    if hot is None:
        return sum(table_shape(table, angle, height) for table in profiles)
    cold = height - hot.axial
    lines = [
        sum(table_shape(table, angle[i : i + 1], row)[0] for table in profiles)
        for i, row in enumerate(cold)
    ]
    return np.stack(lines) if profiles else 0


def bore_shape(
    heights: np.ndarray, angle: np.ndarray, options: BlockOptions, parameters: Parameters
) -> np.ndarray:
    """Return the widening of the undeformed bore on the table of its modes, (c, s) [m].

    It is the sum of Fourier orders, heat and measured shapes.
    """
    heat = linear_growth(
        heights, heights[0], heights[-1], parameters.bore_growth_lower, parameters.bore_growth_upper
    )
    return measured_bore(heights, angle, options) + heat


def measured_bore(heights: np.ndarray, angle: np.ndarray, options: BlockOptions) -> np.ndarray:
    """Return the part of `bore_shape` without linear growth, (c, s) or (c, 1) [m]."""
    shape = fourier_bore(options.orders, angle)[:, None]
    shape = shape + measured(options.profiles, angle, heights, options.hot)
    return shape + options.hot.radial if options.hot else shape
