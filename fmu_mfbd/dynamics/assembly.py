"""From reduced bodies and parameters to the model that runs."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..geometry.film import Bore, FilmSurface, Skirt, bore_splines
from ..geometry.grid import cell_centres
from ..geometry.modal_field import modal_field
from ..geometry.profile import (
    barrel,
    fourier_bore,
    linear_growth,
    ovality,
    table_shape,
    tilt_about_x,
)
from ..reduction.reduced_body import ReducedBlock, ReducedBody, ReducedPiston, mode_classes
from .build_options import BlockOptions, BuildOptions, DampingBand, PistonOptions
from .floating_frame import FlexibleBody
from .gas_on_bore import bore_wall
from .instant import Block, System
from .model import Crank, PistonInBore
from .parameters import Parameters
from .pin_friction import PinFriction
from .quasi_static import StaticModes, standing
from .slider_crank import Mechanism

PIN_SHARE = 0.25
"""Radius of a pin that is not given, by that of the skirt: our own choice, as for `new`."""


class PistonParts(NamedTuple):
    """The piston with the modes that move, and those that follow statically."""

    moving: FlexibleBody
    static: StaticModes


class BlockParts(NamedTuple):
    """Likewise the block."""

    moving: Block
    static: StaticModes


def assemble(
    piston: ReducedPiston, block: ReducedBlock, options: BuildOptions, parameters: Parameters
) -> PistonInBore:
    """The model.

    Parameters
    ----------
    piston, block
        Reduced bodies.
    options : BuildOptions
    parameters : Parameters

    Returns
    -------
    PistonInBore
    """
    piston_parts = parted_piston(piston, modal_damping(piston, options, parameters), parameters)
    block_parts = parted_block(block, modal_damping(block, options, parameters), parameters)
    system = System(
        piston=piston_parts.moving,
        piston_static=piston_parts.static,
        block=block_parts.moving,
        block_static=block_parts.static,
        mechanism=mechanism(piston.radius, options.piston, parameters),
        surfaces=surfaces(piston, block, options, parameters),
        pin_offset=options.piston.pin_offset,
        gas_force=np.ascontiguousarray(piston.gas_force),
        wall=bore_wall(
            block.heights,
            block.radial,
            block.radius,
            parameters.top_ring_height,
            parameters.second_ring_height,
            parameters.land_pressure_share,
        ),
    )
    crank = Crank(
        free=bool(parameters.crank_free),
        inertia=parameters.crank_inertia,
        load_torque=parameters.load_torque,
        table=options.speed,
    )
    gas_area = np.pi * block.radius**2
    return PistonInBore(
        system,
        crank,
        gas_area,
        parameters.spectral_radius,
        options.gas,
        options.film_grids(),
        parameters.crank_unbalance if options.mounted else None,
    )


def damping(
    omega: np.ndarray,
    bands: Sequence[DampingBand],
    mass_factor: float,
    stiffness_factor: float,
) -> np.ndarray:
    """Modal damping by frequency bands, and Rayleigh's two terms besides.

    Eq. (I5):  D = 2 zeta omega + a + b omega^2      zeta the ratio of the band that omega/(2 pi)
                                                     lies in

    Parameters
    ----------
    omega : ndarray, shape (k,)
        [rad/s]
    bands : sequence of DampingBand
        By rising frequency, the first from 0 Hz.
    mass_factor, stiffness_factor : float
        a [1/s], b [s].

    Returns
    -------
    ndarray, shape (k,)
        [rad/s]
    """
    above = np.array([band.above for band in bands])
    ratio = np.array([band.ratio for band in bands])
    zeta = ratio[np.searchsorted(2 * np.pi * above, omega, side="right") - 1]
    return 2 * zeta * omega + mass_factor + stiffness_factor * omega**2  # Eq. (I5)


def damping_bands(options: BuildOptions, parameters: Parameters) -> tuple[DampingBand, ...]:
    """The bands of the build table, else the two of the parameters."""
    return options.damping_bands or (
        DampingBand(0.0, parameters.damping_ratio),
        DampingBand(
            parameters.damping_transition_frequency, parameters.high_frequency_damping_ratio
        ),
    )


def modal_damping(body: ReducedBody, options: BuildOptions, parameters: Parameters) -> np.ndarray:
    """Damping of all modes of a body [rad/s]."""
    return damping(
        body.omega,
        damping_bands(options, parameters),
        parameters.rayleigh_mass_factor,
        parameters.rayleigh_stiffness_factor,
    )


def faults(
    piston: ReducedPiston, block: ReducedBlock, options: BuildOptions, parameters: Parameters
) -> list[str]:
    """Sentences about parameters that do not fit each other: rod too short, skirt leaving the
    bore.
    """
    crank_radius = parameters.crank_radius
    rod_length = parameters.rod_length
    offset = options.piston.pin_offset - parameters.crank_offset
    reach = crank_radius + abs(offset)
    if rod_length**2 - reach**2 <= 0.0:
        return [
            f"rod_length = {rod_length:g} m: must exceed crank_radius plus the offsets, {reach:g} m"
        ]
    out = []
    if parameters.crank_free and options.speed:
        out.append(
            "crank_free = 1: must be 0 with a table of crank speed ([speed] in the build table)"
        )
    if parameters.rod_centre > rod_length:
        out.append(
            f"rod_centre = {parameters.rod_centre:g} m: must lie within "
            f"rod_length = {rod_length:g} m"
        )
    if parameters.top_ring_height and not (
        piston.skirt_upper <= parameters.second_ring_height <= parameters.top_ring_height
    ):
        out.append(
            f"second_ring_height = {parameters.second_ring_height:g} m: must lie between the "
            f"skirt's upper edge, {piston.skirt_upper:g} m above the pin, and "
            f"top_ring_height = {parameters.top_ring_height:g} m"
        )
    turn = np.linspace(0.0, 2 * np.pi, 721)
    xi = offset + crank_radius * np.sin(turn)
    height_of_A = crank_radius * np.cos(turn) + np.sqrt(rod_length**2 - xi**2)  # Eq. (K1)
    lowest = height_of_A.min() + piston.skirt_lower
    highest = height_of_A.max() + piston.skirt_upper
    bore_lower = block.heights[0]
    bore_upper = block.heights[-1]
    if lowest < bore_lower or highest > bore_upper:
        out.append(
            f"crank_radius, rod_length: the skirt travels from {lowest:g} to {highest:g} m above "
            f"the crank axis, the bore reaches from {bore_lower:g} to {bore_upper:g} m"
        )
    if piston.radius >= block.radius:
        out.append(
            f"piston mesh: skirt radius {piston.radius:g} m is not smaller than the bore radius "
            f"{block.radius:g} m"
        )
    return out


def parted_piston(
    piston: ReducedPiston, damping: np.ndarray, parameters: Parameters
) -> PistonParts:
    """The piston with the modes up to the quasi-static frequency, and the faster ones.

    Parameters
    ----------
    piston : ReducedPiston
    damping : ndarray, shape (k,)
        Of all its modes [rad/s].
    parameters : Parameters
    """
    k = _moving(piston, parameters)
    contiguous = np.ascontiguousarray
    moving = FlexibleBody(
        mass=piston.mass,
        S=piston.S,
        I0=piston.I0,
        T=contiguous(piston.T[:, :k]),
        b=contiguous(piston.b[:k]),
        B=contiguous(piston.B[:k, :k]),
        g=contiguous(piston.g[:k]),
        G=contiguous(piston.G[:k, :k]),
        stiffness=piston.omega[:k] ** 2,
        damping=damping[:k],
    )
    static = StaticModes(
        stiffness=piston.omega[k:] ** 2,
        T=contiguous(piston.T[:, k:]),
        b=contiguous(piston.b[k:]),
        g=contiguous(piston.g[k:]),
    )
    return PistonParts(moving, static)


def parted_block(block: ReducedBlock, damping: np.ndarray, parameters: Parameters) -> BlockParts:
    """The block's modes up to the quasi-static frequency, and the faster ones; as
    `parted_piston`.
    """
    k = _moving(block, parameters)
    moving = Block(stiffness=block.omega[:k] ** 2, damping=damping[:k])
    return BlockParts(moving, standing(block.omega[k:] ** 2))


def _moving(body: ReducedBody, parameters: Parameters) -> int:
    """How many modes have inertia of their own."""
    return int(np.count_nonzero(body.omega <= 2 * np.pi * parameters.quasi_static_frequency))


def mechanism(skirt_radius: float, options: PistonOptions, parameters: Parameters) -> Mechanism:
    """Crank, rod and pin."""
    pin_radius = parameters.pin_radius or PIN_SHARE * skirt_radius
    friction = PinFriction(
        lever=parameters.pin_friction_coefficient * pin_radius,
        speed=parameters.pin_friction_speed,
        viscous=parameters.pin_friction_damping,
    )
    return Mechanism(
        crank_radius=parameters.crank_radius,
        rod_length=parameters.rod_length,
        offset=options.pin_offset - parameters.crank_offset,
        rod_mass=parameters.rod_mass,
        rod_inertia=parameters.rod_inertia,
        rod_centre=parameters.rod_centre / parameters.rod_length,
        pin_mass=parameters.pin_mass,
        friction=friction,
    )


def surfaces(
    piston: ReducedPiston, block: ReducedBlock, options: BuildOptions, parameters: Parameters
) -> tuple[FilmSurface, ...]:
    """All film surfaces, from below: bands of one skirt in one bore."""
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
    """Film thickness around the concentric, undeformed piston in a cylinder, (c, a) [m]: clearance,
    machined profile, heat, tilt, measured shapes.
    """
    lower = piston.skirt_lower
    upper = piston.skirt_upper
    gap = parameters.radial_clearance + barrel(height, lower, upper, parameters.barrel)
    gap = gap + ovality(angle, parameters.ovality)[:, None]
    gap = gap - linear_growth(
        height, lower, upper, parameters.skirt_growth_lower, parameters.skirt_growth_upper
    )
    gap = gap + tilt_about_x(angle, height, parameters.pin_tilt)
    return gap + sum(table_shape(table, angle, height) for table in options.profiles)


def bore(
    block: ReducedBlock, angle: np.ndarray, options: BlockOptions, parameters: Parameters
) -> Bore:
    """Bore side of the film at the grid's angles (c,) [rad]."""
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
    """Widening of the undeformed bore on the table of its modes, (c, s) [m]: measured, by Fourier
    orders, by heat.
    """
    orders = fourier_bore(options.orders, angle)[:, None]
    heat = linear_growth(
        heights,
        heights[0],
        heights[-1],
        parameters.bore_growth_lower,
        parameters.bore_growth_upper,
    )
    return orders + heat + sum(table_shape(table, angle, heights) for table in options.profiles)
