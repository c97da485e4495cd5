"""Geometry of the films of the skirt, from reduced bodies, parameters and measured shapes."""

from collections.abc import Sequence

import numpy as np

from ...master.fmi.compiled import compilable
from ..geometry.film import BoreSplines, FilmSurface, Skirt, bore_splines
from ..geometry.grid import cell_centres
from ..geometry.modal_field import modal_field
from ..geometry.profile import (
    MeasuredShape,
    barrel,
    fourier_bore,
    linear_growth,
    ovality,
    table_shape,
    tilt_about_x,
)
from ..reduction.reduced_body import ReducedBlock, ReducedPiston, mode_classes
from .build_options import BlockOptions, BuildOptions, PistonOptions
from .parameters import Parameters


def surfaces(
    piston: ReducedPiston, block: ReducedBlock, options: BuildOptions, parameters: Parameters
) -> tuple[FilmSurface, ...]:
    """Return all film surfaces from below: bands of one skirt in one bore."""
    angle, height = cell_centres(*options.grid, piston.skirt_lower, piston.skirt_upper)
    gap = skirt_gap(piston, angle, height, options.piston, parameters)
    classes = mode_classes(piston)
    grid = (len(angle), len(height), len(piston.omega))
    radial = piston.radial.reshape(grid)
    axial = piston.axial.reshape(grid)
    one_bore = bore(block, angle, options.block, parameters)
    bands = [slice(one.first, one.last) for one in options.film_surfaces()]
    return tuple(
        FilmSurface(
            Skirt(
                angle,
                height[rows],
                np.ascontiguousarray(gap[:, rows]),
                block.radius,
                options.piston.pin_offset,
                modal_field(radial[:, rows], classes),
                modal_field(axial[:, rows], classes),
            ),
            one_bore,
        )
        for rows in bands
    )


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
    return gap + measured(options.profiles, angle, height)


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
    profiles: Sequence[MeasuredShape], angle: np.ndarray, height: np.ndarray
) -> np.ndarray | int:
    """Return the sum of measured shapes, (c, a) [m], 0 if there are none."""
    return sum(table_shape(table, angle, height) for table in profiles)


def bore(
    block: ReducedBlock, angle: np.ndarray, options: BlockOptions, parameters: Parameters
) -> BoreSplines:
    """Return the bore side of the film at the grid's angles (c,) [rad]."""
    return bore_splines(
        block.heights,
        block.radial,
        block.axial,
        mode_classes(block),
        bore_shape(block.heights, angle, options, parameters),
    )


def bore_shape(
    heights: np.ndarray, angle: np.ndarray, options: BlockOptions, parameters: Parameters
) -> np.ndarray:
    """Return the widening of the undeformed bore on the table of its modes, (c, s) [m].

    It is the sum of Fourier orders, heat and measured shapes.
    """
    orders = fourier_bore(options.orders, angle)[:, None]
    heat = linear_growth(
        heights, heights[0], heights[-1], parameters.bore_growth_lower, parameters.bore_growth_upper
    )
    return orders + heat + measured(options.profiles, angle, heights)
