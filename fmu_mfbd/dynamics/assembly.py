"""Assembly of the model from reduced bodies and parameters."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable
from ...master.fmi.symmetry import FILM_SYMMETRIES
from ..force_elements import SLIDES
from ..geometry.arrays import Matrix, Numbers
from ..geometry.film import FilmSurface, knot_rule
from ..geometry.pin import PinSurface
from ..geometry.pin_shapes import AxisShapes, beam_shapes, spin_inertia
from ..geometry.surfaces import (
    in_block,
    pin_surface_at,
    pins_in_block,
    pins_of,
    put_pin_surface,
    row_at,
    surface_at,
    with_room,
)
from ..mechanism.cylinder import EYE, CylinderParts, cylinder_chain, integrators, motion_across
from ..mechanism.floating_frame import FlexibleBody
from ..mechanism.modal_damping import ModalSprings, count_modes_with_inertia
from ..mechanism.pin_friction import PinFriction
from ..mechanism.slider_crank import Mechanism
from ..reduction.reduced_body import ReducedBlock, ReducedBosses, ReducedPiston, ReducedShell, load
from .bore_from_outside import outside_bore
from .build_options import BuildOptions
from .clearance import machined, surfaces
from .contradictions import Fit, pin_radius
from .element_laws import cylinder_laws, free_slides
from .gas_on_bore import BoreWall, bore_wall
from .half_films import half_films, is_halved
from .model import PistonInBore
from .motion_in_space import SpaceBodies, SpaceBody, Stop, without_piston
from .parameters import Parameters, Settings, SpaceParameters, settings_of
from .pin_axis import pin_beam, pin_rows, pin_span, pin_surfaces, put_beam
from .pin_films import damp_modes
from .space_model import PistonInSpace
from .speed_table import SpeedTable
from .step import BodyModel
from .system import BodySystem
from .tables import GasTable
from .thermal_growth import Radii, cold_walls, free_radii

PIN_LENGTH = 1.5
"""Length of a pin by the skirt's radius, for its inertia about a diameter: our own choice, pins end
short of the skirt's two radii.
"""

NO_GAS = GasTable(np.zeros(0), np.zeros(0), 0.0)
NO_SPEED = SpeedTable(False, np.zeros(0), np.zeros(0), np.zeros(0))
"""Tables of gas pressure and crank speed without points."""


class ReducedBodies(NamedTuple):
    """All reduced bodies of an FMU: bosses only if they yield, and flexible shells by surface.

    The shells are those of the films in small end and crank, in this order.
    """

    piston: ReducedPiston
    block: ReducedBlock
    bosses: ReducedBosses | None = None
    shells: Mapping[str, ReducedShell] = {}

    def radii(self) -> dict[str, float]:
        """Return the radii of the shells, by surface [m]."""
        return {name: shell.radius for name, shell in self.shells.items()}


def load_bodies(folder: Path, options: BuildOptions) -> ReducedBodies:
    """Read the reduced bodies of an FMU from its folder."""
    pin = options.floating_pin
    files = {"small_end": pin.small_end if pin else ""}
    files |= {one.name: one.shell for one in options.crank_bearings}
    return ReducedBodies(
        load(ReducedPiston, folder / options.piston.file),
        load(ReducedBlock, folder / options.block.file),
        load(ReducedBosses, folder / pin.bosses) if pin and pin.bosses else None,
        {name: load(ReducedShell, folder / file) for name, file in files.items() if file},
    )


class BodySetup(NamedTuple):
    """Bodies and films before any parameter is known.

    Parameters
    ----------
    fit : Fit
    gas, gas_area, speed, mounted
        As of `BodyModel`.
    radii : Radii
        0 for a wall whose profile is that of the running engine.
    skirt_field, bore_field : bool
        Whether the temperatures of skirt and bore are field inputs.
    bore_rule : ndarray, shape (knots, s)
        As of `ColdWalls`; no rows if that of the bore is none.
    piston : FlexibleBody
        With all modes, undamped.
    gas_force, wall
        As of `BodySystem`, the rings unset.
    piston_omega, block_omega, shell_omega : ndarray
        Angular frequencies of all modes [rad/s].
    surfaces, pin_surfaces : ndarray
        Films of the skirt before `clearance.machined`, and of pin and crank before `pin_films`.
    half_surfaces : ndarray
        One half of those of the skirt, without surfaces if there is none.
    pin_shapes, pin_rows, pin_lengths : int, ndarray
        Number of shapes of the pin; z of the rows of its films and their lengths [m].
    slides : ndarray
        Numbers of those of `SLIDES` that joints have.
    """

    fit: Fit
    gas: GasTable
    gas_area: float
    speed: SpeedTable
    mounted: bool
    radii: Radii
    skirt_field: bool
    bore_field: bool
    bore_rule: Matrix
    piston: FlexibleBody
    gas_force: Annotated[np.ndarray, "piston_modes"]
    wall: BoreWall
    piston_omega: Annotated[np.ndarray, "piston_modes"]
    block_omega: Annotated[np.ndarray, "block_modes"]
    shell_omega: Annotated[np.ndarray, "shell_modes"]
    big_end_modes: int
    main_bearing_modes: int
    surfaces: Annotated[np.ndarray, "n"]
    half_surfaces: Annotated[np.ndarray, "n_half"]
    pin_surfaces: Annotated[np.ndarray, "n"]
    pin_shapes: int
    pin_rows: Annotated[np.ndarray, "pins, rows"]
    pin_lengths: Annotated[np.ndarray, "pins"]
    slides: Numbers


def setup_of(bodies: ReducedBodies, options: BuildOptions, needs: Parameters) -> BodySetup:
    """Return what no parameter changes.

    `needs` are parameters that decide what exists: gas on the wall if there is a top ring, a table
    for the widening of the bore if it grows, and half films if they may be chosen.
    """
    piston, block, bosses, shells = bodies
    films = surfaces(piston, block, options)
    if needs.bore_growth_lower or needs.bore_growth_upper or options.block.bore_from_outside:
        films = with_room(films, len(block.heights))
    half: Sequence[FilmSurface] = ()
    walls = options.temperatures
    fields = (walls.skirt.varies, walls.bore.varies) if walls else (False, False)
    in_plane = not (options.in_space or options.block.bore_from_outside or any(fields))
    if needs.film_symmetry != FILM_SYMMETRIES[0] and in_plane:
        half = half_films(films, (piston, block), options.start)
    contiguous, pin = np.ascontiguousarray, options.floating_pin
    return BodySetup(
        fit=fit_of(bodies, options, bodies.radii()),
        gas=options.gas or NO_GAS,
        gas_area=np.pi * block.radius**2,
        speed=options.speed or NO_SPEED,
        mounted=options.mounted,
        radii=Radii(
            0.0 if options.piston.is_hot else piston.radius,
            0.0 if options.block.is_hot else block.radius,
        ),
        skirt_field=fields[0],
        bore_field=fields[1],
        bore_rule=contiguous(knot_rule(len(block.heights))) if fields[1] else np.zeros((0, 0)),
        piston=FlexibleBody(
            **{name: getattr(piston, name) for name in FlexibleBody._fields[:8]},
            stiffness=piston.omega * piston.omega,
            damping=np.zeros(len(piston.omega)),
        ),
        gas_force=contiguous(piston.gas_force),
        wall=bore_wall(block.heights, block.radial, block.radius, needs.top_ring_height, 0.0),
        piston_omega=piston.omega,
        block_omega=block.omega,
        shell_omega=np.concatenate([np.zeros(0), *(one.omega for one in shells.values())]),
        big_end_modes=len(shells["big_end"].omega) if "big_end" in shells else 0,
        main_bearing_modes=len(shells["main_bearing"].omega) if "main_bearing" in shells else 0,
        surfaces=in_block(films),
        half_surfaces=in_block(half),
        pin_surfaces=pins_in_block(pin_surfaces(options, bosses, shells)),
        pin_shapes=pin.pin_shapes if pin else 0,
        pin_rows=np.array(pin_rows(pin, bosses)) if pin else np.zeros((0, 0)),
        pin_lengths=np.array([*pin.lengths().values()]) if pin else np.zeros(0),
        slides=np.array([[*SLIDES].index(name) for name in options.slides], dtype=np.int64),
    )


@compilable
def assembled(setup: BodySetup, p: Settings) -> BodyModel:
    """Return the model for these parameters."""
    fit, wall = setup.fit, setup.wall
    films, omega = pin_films(setup, p), np.zeros(0)
    shapes = AxisShapes(np.zeros(0), np.zeros(0))
    spin = p.pin_mass * pin_radius(fit.piston_radius, p) ** 2 / 2
    if setup.pin_shapes > 0:
        beam = pin_beam(fit.piston_radius, fit.pin_span, setup.pin_shapes, p)
        put_beam(films, beam, setup.pin_rows, setup.pin_lengths, p)
        omega, shapes, spin = beam.omega, beam_shapes(beam), spin_inertia(beam.pin)
    if p.pin_inertia > 0.0:
        spin = p.pin_inertia
    others = np.concatenate((setup.block_omega, omega, omega, setup.shell_omega))
    block = len(setup.block_omega)
    cylinder = CylinderParts(
        piston=setup.piston,
        moving=count_modes_with_inertia(setup.piston_omega, p.quasi_static_frequency),
        mechanism=mechanism(fit.piston_radius, fit.pin_offset, p),
        spin_inertia=spin,
        crank_mass=p.crank_mass,
        unbalance=p.crank_unbalance,
        floats=fit.floats,
        big_end=fit.has_big_end,
        main_bearing=fit.has_main_bearing,
        springs=ModalSprings(others * others, np.zeros(len(others))),
        block_modes=block,
        block_static=block - count_modes_with_inertia(setup.block_omega, p.quasi_static_frequency),
        shapes=len(omega),
        big_end_modes=setup.big_end_modes,
        main_bearing_modes=setup.main_bearing_modes,
        laws=cylinder_laws(p, setup.slides),
        slides=free_slides(setup.slides),
    )
    chain = cylinder_chain(cylinder)
    kinds = integrators(cylinder, chain)
    damp_modes(kinds, chain, p)
    half = is_halved(setup.half_surfaces, p)
    cold_films = setup.half_surfaces if half else setup.surfaces
    radii = free_radii(setup.radii, len(surface_at(cold_films, 0).skirt.temperature) > 0, p)
    hot_films = machined(cold_films, fit, p, radii)
    parts = BodySystem(
        chain=chain,
        kinds=kinds,
        inertia=motion_across(cylinder, 0.0),
        with_rod=motion_across(cylinder, 1.0),
        shapes=shapes,
        mechanism=cylinder.mechanism,
        surfaces=hot_films,
        pin_surfaces=films,
        pin_offset=fit.pin_offset,
        gas_force=setup.gas_force,
        wall=BoreWall(
            lowest=wall.lowest,
            spacing=wall.spacing,
            above=wall.above,
            at=wall.at,
            top_ring=p.top_ring_height,
            second_ring=p.second_ring_height,
            land_share=p.land_pressure_share,
        ),
        resolution=p.impact_resolution,
    )
    cold = cold_walls(hot_films, (setup.skirt_field, setup.bore_field), setup.bore_rule)
    return BodyModel(
        parts=parts,
        settings=p,
        gas=setup.gas,
        gas_area=setup.gas_area,
        speed=setup.speed,
        mounted=setup.mounted,
        radii=radii,
        cold=cold,
    )


@compilable
def pin_films(setup: BodySetup, p: Settings) -> np.ndarray:
    """Return the films of pin and crank with their radii and clearances."""
    out = setup.pin_surfaces.copy()
    of_pin = EYE + 1 if setup.fit.floats else 0
    for k in range(pins_of(out)):
        radius = pin_radius(setup.fit.piston_radius, p)
        clearance = p.boss_clearance if k < EYE else p.small_end_clearance
        if k == of_pin and setup.fit.has_big_end:
            radius = p.big_end_radius
            clearance = p.big_end_clearance
        elif k >= of_pin:
            radius = p.main_bearing_radius
            clearance = p.main_bearing_clearance
        one = pin_surface_at(out, k)
        for j in range(len(one.clearance)):
            one.clearance[j] = clearance
        turned = PinSurface(
            outward=one.outward,
            onward=one.onward,
            radius=radius,
            clearance=one.clearance,
            modes=one.modes,
            axis=one.axis,
        )
        put_pin_surface(row_at(out, k), turned)
    return out


def assemble(
    piston: ReducedPiston,
    block: ReducedBlock,
    options: BuildOptions,
    parameters: Parameters,
    own: Sequence[Any] = (),
) -> PistonInBore:
    """Return the model of a piston on a tied pin."""
    return model_of(ReducedBodies(piston, block), options, parameters, own)


def model_of(
    bodies: ReducedBodies, options: BuildOptions, parameters: Parameters, own: Sequence[Any] = ()
) -> PistonInBore:
    """Return the model of an FMU, with all parts of its options.

    `own` are the parameters of its parts in addition to `Parameters`, one object of each class. A
    piston moves in space if they contain `SpaceParameters`.
    """
    setup = setup_of(bodies, options, parameters)
    model = assembled(setup, settings_of(parameters, *own))
    grid, outside = options.block.bore_from_outside, None
    if grid:
        around, _ = options.grid
        block = bodies.block
        outside = outside_bore(grid, around, block.heights, block.radius, model.parts.wall)
    planar = PistonInBore(model, options, outside)
    space = next((one for one in own if isinstance(one, SpaceParameters)), None)
    return _in_space(planar, bodies.piston, options, parameters, space) if space else planar


def _in_space(
    planar: PistonInBore,
    piston: ReducedPiston,
    options: BuildOptions,
    parameters: Parameters,
    space: SpaceParameters,
) -> PistonInSpace:
    """Return the model of a rigid piston that moves in space, from that in its plane.

    Eq. (J21):  m_pin (R^2/4 + L^2/12)      of a solid pin about a diameter
    """
    assert options.in_space
    S_x, S_y = piston.S
    body = SpaceBody(
        piston.mass, np.array([S_x, S_y, options.in_space.first_moment_z]), options.in_space.inertia
    )
    radius = pin_radius(piston.radius, parameters)
    length = PIN_LENGTH * piston.radius
    solid = parameters.pin_mass * (radius**2 / 4 + length**2 / 12)  # Eq. (J21)
    parts = SpaceBodies(
        piston=body,
        chain=without_piston(planar.system.chain),
        pin_mass=parameters.pin_mass,
        pin_inertia=space.pin_cross_inertia or solid,
        tilt=parameters.pin_tilt,
        pin_offset=options.piston.pin_offset,
        along=Stop(space.pin_axial_play, space.pin_axial_stiffness, space.pin_axial_damping),
        askew=Stop(space.pin_tilt_play, space.pin_tilt_stiffness, space.pin_tilt_damping),
    )
    return PistonInSpace(planar, parts)


def fit_of(bodies: ReducedBodies, options: BuildOptions, radii: Mapping[str, float]) -> Fit:
    """Return what parameters have to fit."""
    piston, block, bosses, _ = bodies
    films, pin = options.crank_surfaces(), options.floating_pin
    return Fit(
        piston_radius=piston.radius,
        skirt_lower=piston.skirt_lower,
        skirt_upper=piston.skirt_upper,
        pin_offset=options.piston.pin_offset,
        bore_lower=float(block.heights[0]),
        bore_upper=float(block.heights[-1]),
        boss_radius=bosses.boss_radius if bosses else 0.0,
        eye_radius=radii.get("small_end", 0.0),
        big_end_shell=radii.get("big_end", 0.0),
        main_bearing_shell=radii.get("main_bearing", 0.0),
        pin_span=pin_span(pin, bosses) if pin and pin.pin_shapes else 0.0,
        has_speed=options.speed is not None,
        floats=options.floating_pin is not None,
        has_big_end="big_end" in films,
        has_main_bearing="main_bearing" in films,
        symmetric_film=options.symmetric_film,
    )


@compilable
def mechanism(skirt_radius: float, pin_offset: float, parameters: Settings) -> Mechanism:
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
