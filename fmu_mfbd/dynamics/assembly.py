"""From reduced bodies and parameters to the model that runs."""

from collections.abc import Mapping, Sequence
from itertools import zip_longest
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable
from ...master.fmi.noted import none_yet, sentences_of
from ..geometry.film import FilmSurface
from ..geometry.grid import film_rows
from ..geometry.pin import PinSurface, ShellModes, pin_surface, relieved, shell_modes
from ..geometry.pin_shapes import STRAIGHT, Beam, HollowPin, free_beam
from ..geometry.surfaces import in_block, with_room
from ..reduction.reduced_body import (
    ReducedBlock,
    ReducedBosses,
    ReducedPiston,
    ReducedSmallEnd,
    load,
)
from .bore_from_outside import outside_bore
from .build_options import BuildOptions, CrankBearing, FloatingPin
from .clearance import surfaces
from .contradictions import FAULTS, ROD_TOO_SHORT, Fit, check, pin_radius
from .floating_frame import FlexibleBody
from .gas_on_bore import bore_wall
from .modal_damping import ModalSprings, modal_springs
from .model import Crank, PistonInBore
from .motion_in_space import SpaceBodies, SpaceBody, Stop
from .parameters import (
    AxisParameters,
    BigEndParameters,
    MainBearingParameters,
    Parameters,
    PinParameters,
    SpaceParameters,
)
from .pin_coordinates import RIGID_CRANK, Crankshaft
from .pin_friction import PinFriction
from .pin_model import PistonOnFloatingPin
from .quasi_static import StaticModes, standing
from .slider_crank import Mechanism
from .space_model import PistonInSpace
from .system import BodySystem

PIN_LENGTH = 1.5
"""Length of a pin by the skirt's radius, for its inertia about a diameter: our own choice, pins end
short of the skirt's two radii.
"""

CrankParameters = Mapping[str, BigEndParameters | MainBearingParameters]
"""Film surface of the crank -> its own parameters."""


class PistonParts(NamedTuple):
    """The piston with the modes that move, and those that follow statically."""

    moving: FlexibleBody
    static: StaticModes


class ReducedBodies(NamedTuple):
    """All reduced bodies of an FMU: bosses and small end only if they yield."""

    piston: ReducedPiston
    block: ReducedBlock
    bosses: ReducedBosses | None
    small_end: ReducedSmallEnd | None


def load_bodies(folder: Path, options: BuildOptions) -> ReducedBodies:
    """Read the reduced bodies of an FMU from its folder."""
    pin = options.floating_pin
    return ReducedBodies(
        load(ReducedPiston, folder / options.piston.file),
        load(ReducedBlock, folder / options.block.file),
        load(ReducedBosses, folder / pin.bosses) if pin and pin.bosses else None,
        load(ReducedSmallEnd, folder / pin.small_end) if pin and pin.small_end else None,
    )


def assemble(
    piston: ReducedPiston, block: ReducedBlock, options: BuildOptions, parameters: Parameters
) -> PistonInBore:
    """Return the model of a piston on a tied pin.

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
    films = surfaces(piston, block, options, parameters)
    if options.block.bore_from_outside:
        films = with_room(films, len(block.heights))
    system = assemble_system(piston, block, options, parameters, films)
    crank = Crank(
        free=bool(parameters.crank_free),
        inertia=parameters.crank_inertia,
        load_torque=parameters.load_torque,
        table=options.speed,
    )
    gas_area = np.pi * block.radius**2
    grid = options.block.bore_from_outside
    around, _ = options.grid
    return PistonInBore(
        system,
        crank,
        gas_area,
        parameters.spectral_radius,
        options.gas,
        options.film_grids(),
        parameters.crank_unbalance if options.mounted else None,
        outside=outside_bore(grid, around, block.heights, block.radius, system.wall)
        if grid
        else None,
    )


def assemble_system(
    piston: ReducedPiston,
    block: ReducedBlock,
    options: BuildOptions,
    parameters: Parameters,
    films: Sequence[FilmSurface],
) -> BodySystem:
    """Return both bodies, the mechanism and the films of a skirt."""
    parts = parted_piston(piston, options, parameters)
    springs = modal_springs(block.omega, parameters)
    k = _moving(block, parameters)
    return BodySystem(
        piston=parts.moving,
        piston_static=parts.static,
        block=ModalSprings(springs.stiffness[:k], springs.damping[:k]),
        block_static=standing(springs.stiffness[k:]),
        mechanism=mechanism(piston.radius, options.piston.pin_offset, parameters),
        surfaces=in_block(films),
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


def assemble_floating(
    piston: ReducedPiston,
    block: ReducedBlock,
    options: BuildOptions,
    parameters: Parameters,
    pin: PinParameters,
    bosses: ReducedBosses | None = None,
    axis: AxisParameters | None = None,
    crank: CrankParameters | None = None,
    *,
    small_end: ReducedSmallEnd | None = None,
) -> PistonOnFloatingPin:
    """Return the model of a piston whose pin floats.

    `pin` holds its own parameters, `bosses` those of a flexible piston, `axis` those of a pin with
    shapes. `crank` holds those of each film of the crank, and `small_end` is a flexible eye. The
    others are as in `assemble`.
    """
    assert options.floating_pin
    radius = pin_radius(piston.radius, parameters)
    crank = crank or {}
    eye_omega = small_end.eye_omega if small_end else np.zeros(0)
    eye = modal_springs(eye_omega, parameters)
    spin = pin_spin_inertia(parameters.pin_mass, radius, pin.pin_inertia)
    shapes = STRAIGHT
    films = pin_surfaces(options, radius, pin, crank, bosses, small_end)
    if axis:
        beam = pin_beam(piston, options.floating_pin, parameters, bosses, axis)
        spin = pin.pin_inertia or beam.pin.spin_inertia()
        shapes = beam.shapes(modal_springs(beam.omega, parameters).damping)
        films = with_shapes(films, options.floating_pin, bosses, beam, axis)
    return PistonOnFloatingPin(
        assemble(piston, block, options, parameters),
        films,
        options.pin_grids(),
        spin,
        shapes,
        eye,
        crankshaft(options, parameters, crank),
        absent=options.absent_parts(),
    )


def pin_surfaces(
    options: BuildOptions,
    radius: float,
    pin: PinParameters,
    crank: CrankParameters,
    bosses: ReducedBosses | None,
    small_end: ReducedSmallEnd | None,
) -> tuple[PinSurface, ...]:
    """Return the films of a pin that stays parallel to its shells, and those of the crank."""
    clearances = (pin.boss_clearance, pin.boss_clearance, pin.small_end_clearance)
    shells: list[ShellModes | None] = [None, None]
    if bosses:
        shells = [shell_modes(*pair) for pair in zip(bosses.boss_outward, bosses.boss_onward)]
    if small_end:
        shells.append(shell_modes(small_end.eye_outward, small_end.eye_onward))
    grids = options.pin_grids()
    films = zip_longest(clearances, grids[: len(clearances)], shells)
    of_pin = (pin_surface(radius, one, grid.shape, shell) for one, grid, shell in films)
    return (*of_pin, *(journal_surface(one, crank) for one in options.crank_bearings))


def with_shapes(
    films: tuple[PinSurface, ...],
    pin: FloatingPin,
    bosses: ReducedBosses | None,
    beam: Beam,
    axis: AxisParameters,
) -> tuple[PinSurface, ...]:
    """Return the films of a pin that tilts and bends, with relieved shells."""
    reliefs = axis.boss_relief, axis.boss_relief, axis.small_end_relief
    each = zip(films, pin_rows(pin, bosses), reliefs, pin.lengths().values())
    of_pin = [
        one._replace(clearance=relieved(one.clearance, relief, z, long), axis=beam.at(z))
        for one, z, relief, long in each
    ]
    return (*of_pin, *films[len(of_pin) :])


@compilable
def pin_spin_inertia(mass: float, radius: float, given: float) -> float:
    """Return the inertia of a pin about its axis [kg m2]; default: solid cylinder."""
    return given if given > 0.0 else mass * radius**2 / 2


def crankshaft(options: BuildOptions, parameters: Parameters, crank: CrankParameters) -> Crankshaft:
    """Return the crank with the films of the build table."""
    big_end = "big_end" in options.crank_surfaces()
    main = crank.get("main_bearing")
    if not isinstance(main, MainBearingParameters):
        return RIGID_CRANK._replace(big_end=big_end)
    return Crankshaft(big_end, True, main.crank_mass, parameters.crank_unbalance)


def journal_surface(bearing: CrankBearing, crank: CrankParameters) -> PinSurface:
    """Return the film surface of the crank."""
    own = crank[bearing.name]
    radius, clearance = (getattr(own, f"{bearing.name}_{size}") for size in ("radius", "clearance"))
    return pin_surface(radius, clearance, bearing.grid)


def pin_rows(pin: FloatingPin, bosses: ReducedBosses | None) -> tuple[np.ndarray, ...]:
    """Return z of the rows of all films of the pin [m].

    Rows of bosses are those of the mesh. For a piston without a mesh of bosses they begin at the
    end of the rod's eye.
    """
    half = pin.small_end_length / 2
    outer = half + pin.boss_length
    ends = (-outer, -half), (half, outer), (-half, half)
    left, right, eye = (film_rows(*pair, pin.grid) for pair in ends)
    if bosses:
        left, right = bosses.boss_stations
    return left, right, eye


def pin_span(pin: FloatingPin, bosses: ReducedBosses | None) -> float:
    """Return the least length of a pin that reaches through all its films [m]."""
    _, along = pin.grid
    lengths = pin.lengths().values()
    rows = pin_rows(pin, bosses)
    return max(2 * np.abs(z).max() + long / along for z, long in zip(rows, lengths))


def pin_beam(
    piston: ReducedPiston,
    pin: FloatingPin,
    parameters: Parameters,
    bosses: ReducedBosses | None,
    axis: AxisParameters,
) -> Beam:
    """Return a floating pin as a free beam with the shapes of the build table."""
    hollow = HollowPin(
        mass=parameters.pin_mass,
        length=axis.pin_length or pin_span(pin, bosses),
        radius=pin_radius(piston.radius, parameters),
        bore_radius=axis.pin_bore_radius,
        young=axis.pin_young,
        poisson=axis.pin_poisson,
    )
    return free_beam(hollow, pin.pin_shapes)


def assemble_in_space(
    piston: ReducedPiston,
    block: ReducedBlock,
    options: BuildOptions,
    parameters: Parameters,
    space: SpaceParameters,
) -> PistonInSpace:
    """Return the model of a rigid piston that moves in space.

    `space` holds its own parameters. The others are as in `assemble`.

    Eq. (J21):  m_pin (R^2/4 + L^2/12)      of a solid pin about a diameter
    """
    assert options.in_space
    planar = assemble(piston, block, options, parameters)
    S_x, S_y = piston.S
    body = SpaceBody(
        piston.mass, np.array([S_x, S_y, options.in_space.first_moment_z]), options.in_space.inertia
    )
    radius = pin_radius(piston.radius, parameters)
    length = PIN_LENGTH * piston.radius
    solid = parameters.pin_mass * (radius**2 / 4 + length**2 / 12)  # Eq. (J21)
    bodies = SpaceBodies(
        piston=body,
        mechanism=planar.system.mechanism,
        pin_inertia=space.pin_cross_inertia or solid,
        tilt=parameters.pin_tilt,
        pin_offset=options.piston.pin_offset,
        along=Stop(space.pin_axial_play, space.pin_axial_stiffness, space.pin_axial_damping),
        askew=Stop(space.pin_tilt_play, space.pin_tilt_stiffness, space.pin_tilt_damping),
    )
    return PistonInSpace(planar, bodies)


def faults(
    piston: ReducedPiston,
    block: ReducedBlock,
    options: BuildOptions,
    parameters: Parameters,
    bosses: ReducedBosses | None = None,
    axis: AxisParameters | None = None,
    eye_radius: float = 0.0,
) -> list[str]:
    """Return sentences about parameters that do not fit each other.

    `eye_radius` is the radius of a flexible eye [m].
    """
    noted = none_yet()
    lacks_gas = parameters.gas_source == "table" and not options.gas
    check(fit_of(piston, block, options, bosses, eye_radius), parameters, lacks_gas, noted)
    out = sentences_of(noted, FAULTS)
    if noted[1] == ROD_TOO_SHORT and out:
        return out
    pin = options.floating_pin
    limits = [
        (options.speed, "a table build.speed"),
        (pin, "a floating pin"),
        (options.in_space, "motion in space"),
    ]
    for given, what in limits:
        if given and parameters.crank_free:
            out.append(f"crank_free: expected 0 with {what}, got 1")
    if pin:
        fastest = piston.omega.max(initial=0.0) / (2 * np.pi)
        if fastest > parameters.quasi_static_frequency:
            out.append(
                f"quasi_static_frequency: expected more than all modes with a floating pin, "
                f"{fastest:.4g} Hz, got {parameters.quasi_static_frequency:g} Hz"
            )
        if axis:
            out += axis_faults(piston, pin, parameters, bosses, axis)
    modes = len(block.omega) + len(piston.omega)
    if options.in_space and modes:
        out.append(f"motion_in_space: expected rigid bodies, got {modes} modes")
    return out + body_faults(piston, block, options, bosses)


def fit_of(
    piston: ReducedPiston,
    block: ReducedBlock,
    options: BuildOptions,
    bosses: ReducedBosses | None,
    eye_radius: float,
) -> Fit:
    """Return what parameters have to fit."""
    films = options.crank_surfaces()
    return Fit(
        piston.radius,
        piston.skirt_lower,
        piston.skirt_upper,
        options.piston.pin_offset,
        float(block.heights[0]),
        float(block.heights[-1]),
        bosses.boss_radius if bosses else 0.0,
        eye_radius,
        options.floating_pin is not None,
        "big_end" in films,
        "main_bearing" in films,
    )


def body_faults(
    piston: ReducedPiston, block: ReducedBlock, options: BuildOptions, bosses: ReducedBosses | None
) -> list[str]:
    """Return sentences about reduced bodies that do not fit each other or the pin."""
    out = []
    modes = len(block.omega) + (0 if bosses else len(piston.omega))
    if options.floating_pin and modes:
        out.append(
            "floating_pin: expected rigid bodies or a piston with modes for its bosses, "
            f"got {modes} modes"
        )
    if piston.radius >= block.radius:
        out.append(
            f"piston: expected a skirt radius below the bore radius, {block.radius:g} m, got "
            f"{piston.radius:g} m"
        )
    return out


def axis_faults(
    piston: ReducedPiston,
    pin: FloatingPin,
    parameters: Parameters,
    bosses: ReducedBosses | None,
    axis: AxisParameters,
) -> list[str]:
    """Return sentences about a pin whose parameters contradict each other."""
    out = []
    radius = pin_radius(piston.radius, parameters)
    if axis.pin_bore_radius >= radius:
        out.append(
            f"pin_bore_radius: expected less than the radius of the pin, {1e3 * radius:.4g} mm, "
            f"got {1e3 * axis.pin_bore_radius:.4g} mm"
        )
    span = pin_span(pin, bosses)
    if axis.pin_length and axis.pin_length < (1 - 1e-9) * span:
        out.append(
            f"pin_length: expected 0 or at least the length of all films, {1e3 * span:.4g} mm, "
            f"got {1e3 * axis.pin_length:.4g} mm"
        )
    return out


def parted_piston(
    piston: ReducedPiston, options: BuildOptions, parameters: Parameters
) -> PistonParts:
    """Return the piston with the modes up to the quasi-static frequency, and the faster ones."""
    k = _moving(piston, parameters)
    springs = modal_springs(piston.omega, parameters)
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
        stiffness=springs.stiffness[:k],
        damping=springs.damping[:k],
    )
    static = StaticModes(
        stiffness=springs.stiffness[k:],
        T=contiguous(piston.T[:, k:]),
        b=contiguous(piston.b[k:]),
        g=contiguous(piston.g[k:]),
    )
    return PistonParts(moving, static)


def _moving(body: ReducedPiston | ReducedBlock, parameters: Parameters) -> int:
    """Return the number of modes that have inertia."""
    return int(np.count_nonzero(body.omega <= 2 * np.pi * parameters.quasi_static_frequency))


@compilable
def mechanism(skirt_radius: float, pin_offset: float, parameters: Parameters) -> Mechanism:
    """Return crank, rod and pin."""
    friction = PinFriction(
        lever=parameters.pin_friction_coefficient * pin_radius(skirt_radius, parameters),
        speed=parameters.pin_friction_speed,
        viscous=parameters.pin_friction_damping,
    )
    return Mechanism(
        crank_radius=parameters.crank_radius,
        rod_length=parameters.rod_length,
        offset=pin_offset - parameters.crank_offset,
        rod_mass=parameters.rod_mass,
        rod_inertia=parameters.rod_inertia,
        rod_centre=parameters.rod_centre / parameters.rod_length,
        pin_mass=parameters.pin_mass,
        friction=friction,
    )
