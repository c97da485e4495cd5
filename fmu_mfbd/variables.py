"""Variables of the body FMU, with the names of the interface contract."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import fields, replace
from functools import partial
from math import pi
from typing import Annotated, Any, NamedTuple, get_type_hints

import numpy as np

from ..master.fmi.texts import description
from ..master.fmi.variables import Variable, constant, input_variable, output_variable
from .dynamics.block_force import BlockForce
from .dynamics.build_options import BuildOptions, FilmGrid, WallTemperatures
from .dynamics.drive import Scalars
from .dynamics.parameters import (
    CRANK_PARAMETERS,
    ELEMENT_PARAMETERS,
    REFERENCE,
    TUNABLE,
    WALL_PARAMETERS,
    AxisParameters,
    Parameters,
    PinParameters,
    SpaceParameters,
)
from .dynamics.pin_outputs import PIN_OUTPUTS
from .dynamics.space_model import SpaceScalars
from .force_elements import SLIDES

FORCES = ("nodal_pressure_force", "nodal_friction_force")
FILM = ("film_thickness", "sliding_velocity")
"""Forces and motion of a film of the skirt whose derivatives are known."""
PIN_FORCES = ("nodal_pressure_force", "nodal_circumferential_force")
PIN_FILM = ("film_thickness", "circumferential_velocity")
"""The same of a film of pin or crank."""
RINGS = ("ring_side_force", "ring_axial_force", "ring_moment")
"""Forces of the rings, as `RingForce`."""
BLOCK = (
    "block_acceleration_x",
    "block_acceleration_y",
    "block_angular_acceleration",
    "block_angular_velocity",
)
"""Motion of a mounted block, as `BlockMotion`."""
GAUGE_PRESSURES = (-2e5, 1e8)
RING_FORCES = (-1e9, 1e9)
BLOCK_ACCELERATIONS = (-1e6, 1e6)
TEMPERATURES = (200.0, 1000.0)
"""Ranges of gauge pressures [Pa], forces of the rings [N], accelerations of a block, and
temperatures [K].
"""
WALL_LEVELS = {"skirt": "piston_temperature", "bore": "bore_temperature"}
"""Input with the level of the temperature of each wall."""
WALL_FIELDS = {"skirt": "skirt_temperature_field", "bore": "bore_temperature_field"}
"""Field input of the temperature of each wall, which replaces the level."""
WALL_TEMPERATURES = (233.15, 573.15)
"""Range of the temperature of a wall with a film, as of the oil [K]."""


class SkirtInputs(NamedTuple):
    """Forces of a film on the skirt: unit, start and nominal value."""

    nodal_pressure_force: Annotated[np.ndarray, "N", 0.0, 1.0]
    """Pressure force on a grid cell; positive separates skirt and bore."""
    nodal_friction_force: Annotated[np.ndarray, "N", 0.0, 0.1]
    """Axial force of the film on the skirt in a grid cell; the opposite force acts on the bore."""


class PinInputs(NamedTuple):
    """Forces of a film of pin or crank: unit, start and nominal value."""

    nodal_pressure_force: Annotated[np.ndarray, "N", 0.0, 1.0]
    """Pressure force on a grid cell; positive separates pin and shell."""
    nodal_friction_force: Annotated[np.ndarray, "N", 0.0, 0.1]
    """Axial force of the film on the pin; it has no effect, because the pin does not move axially.
    """
    nodal_circumferential_force: Annotated[np.ndarray, "N", 0.0, 0.1]
    """Circumferential force of the film on the pin, positive with ascending i; the opposite force
    acts on the shell.
    """


class OtherInputs(NamedTuple):
    """Inputs of all body FMUs: unit, start, nominal value and range."""

    gas_pressure: Annotated[float, "Pa", 0.0, 1e6, GAUGE_PRESSURES]
    """Gauge pressure on the piston crown and on the bore above the top ring; gas_source combines it
    with the built-in table.
    """
    crankcase_pressure: Annotated[float, "Pa", 0.0, 1e5, GAUGE_PRESSURES]
    """Gauge pressure below the piston, over the area of the bore."""
    land_pressure: Annotated[float, "Pa", 0.0, 1e5, GAUGE_PRESSURES]
    """Gauge pressure on the bore between the rings."""
    ring_side_force: Annotated[float, "N", 0.0, 1e2, RING_FORCES]
    """Force of the rings on the piston towards the thrust side."""
    ring_axial_force: Annotated[float, "N", 0.0, 1e2, RING_FORCES]
    """Force of the rings on the piston towards the head, along the bore axis."""
    ring_moment: Annotated[float, "N.m", 0.0, 1.0, (-1e5, 1e5)]
    """Moment of the rings on the piston about +z at pin point A, in addition to that of their axial
    force.
    """
    load_torque: Annotated[float, "N.m", 0.0, 10.0, (-1e7, 1e7)]
    """Load torque on a free crank against its direction of rotation, at the end of the step;
    without effect on a crank of prescribed speed.
    """
    piston_temperature: Annotated[float, "K", 293.15, 300.0, TEMPERATURES]
    """Level of the temperature of the piston. The skirt grows above reference_temperature. The
    temperature is uniform unless build options give a distribution.
    """
    bore_temperature: Annotated[float, "K", 293.15, 300.0, TEMPERATURES]
    """Level of the temperature of the bore. The bore grows above reference_temperature. The
    temperature is uniform unless build options give a distribution.
    """
    crank_speed: Annotated[float, "rad/s", 100 * pi, 300.0, (0.0, 3000.0)]
    """Speed of the crank at the end of the step; for a free crank, at the start."""


class BlockInputs(NamedTuple):
    """Motion of a mounted block in the plane of the cylinder: unit, start, nominal value, range."""

    block_acceleration_x: Annotated[float, "m/s2", 0.0, 1.0, BLOCK_ACCELERATIONS]
    """Acceleration of the block at the crank axis along the cylinder's x."""
    block_acceleration_y: Annotated[float, "m/s2", 0.0, 1.0, BLOCK_ACCELERATIONS]
    """Acceleration of the block at the crank axis along the cylinder's y."""
    block_angular_acceleration: Annotated[float, "rad/s2", 0.0, 10.0, BLOCK_ACCELERATIONS]
    """Angular acceleration of the block about the crank axis."""
    block_angular_velocity: Annotated[float, "rad/s", 0.0, 0.1, (-1e4, 1e4)]
    """Angular velocity of the block about the crank axis."""


class BoreInputs(NamedTuple):
    """Deflection of a bore that another participant computes: unit, start and nominal value."""

    bore_deflection: Annotated[np.ndarray, "m", 0.0, 1e-5]
    """Outward deflection of the bore, on its grid of angles and heights."""


class BoreOutputs(NamedTuple):
    """Forces of the cylinder on a block with such a bore: unit and nominal value."""

    force_on_bore: Annotated[np.ndarray, "N", 10.0]
    """Outward force of film and gas on the bore, on its grid of angles and heights."""
    force_on_deck: Annotated[float, "N", 1e3]
    """Force of the gas on the deck along y."""


class SkirtOutputs(NamedTuple):
    """Motion of a film of the skirt: unit and nominal value."""

    film_thickness: Annotated[np.ndarray, "m", 1e-5]
    """Radial distance from skirt to bore; negative where they overlap."""
    sliding_velocity: Annotated[np.ndarray, "m/s", 1.0]
    """Axial velocity of the skirt relative to the bore."""


class PinOutputs(NamedTuple):
    """Motion of a film of pin or crank: unit and nominal value."""

    film_thickness: Annotated[np.ndarray, "m", 1e-5]
    """Radial distance from pin to shell; negative where they overlap."""
    sliding_velocity: Annotated[np.ndarray, "m/s", 1.0]
    """Axial velocity of the pin relative to the shell; always 0."""
    circumferential_velocity: Annotated[np.ndarray, "m/s", 1.0]
    """Circumferential velocity of the pin relative to the shell, positive with ascending i."""


class WorkOutputs(NamedTuple):
    """Check of each film: unit."""

    interface_work_error: Annotated[float, "1"]
    """Relative difference between the power of the interface forces on the grid and in the
    coordinates.
    """


class Evaluations(NamedTuple):
    """Numbers of evaluations: unit."""

    residual_evaluations: Annotated[int, "1"]
    """Number of residual evaluations of the equations of motion so far (NRES)."""
    jacobian_evaluations: Annotated[int, "1"]
    """Number of Jacobian evaluations of the equations of motion so far (NJAC)."""


class OilOutputs(NamedTuple):
    """Oil temperature of a film between walls with given temperatures: unit and nominal value."""

    oil_temperature: Annotated[np.ndarray, "K", 300.0]
    """Oil temperature, mean of both walls; the bore is read where the cell is now."""


class ModalOutputs(NamedTuple):
    """Coordinates of piston and block: unit and nominal value."""

    modal_coordinate: Annotated[np.ndarray, "1", 1e-6]
    """Mass-normalised modal coordinates [kg^(1/2) m], those of the piston first, then of the block.
    """
    modal_velocity: Annotated[np.ndarray, "1/s", 1e-2]
    """Time derivatives of the modal coordinates [kg^(1/2) m/s]."""


class BearingOutputs(NamedTuple):
    """Coordinates of pin, crank and shells: unit and nominal value."""

    bearing_coordinate: Annotated[np.ndarray, "1", 1e-6]
    """Coordinates of pin, crank and shells for a start: plays [m], angle of the pin [rad], shapes
    and modes [kg^(1/2) m].
    """
    bearing_velocity: Annotated[np.ndarray, "1/s", 1e-2]
    """Time derivatives of the coordinates of pin and crank."""


def variables(options: BuildOptions) -> list[Variable]:
    """Return the variables of an FMU with these build options."""
    return signals(options) + properties(options)


def signals(options: BuildOptions) -> list[Variable]:
    """Return inputs, outputs and parameters of an FMU with these build options."""
    modes = options.piston.modes + options.block.modes
    films = options.film_grids()
    pins = options.pin_grids()
    acting, answers = inputs(films, pins), outputs(films, modes, pins)
    if pins:
        absent = options.absent_parts()
        answers += [output_variable(*row) for row in PIN_OUTPUTS if not row[0].startswith(absent)]
    answers += of_modes(BearingOutputs, options.bearing_coordinates())
    for name in options.slides:
        joint = f"the {SLIDES[name].acts} in its joint on the {SLIDES[name].reacts}"
        answers.append(output_variable(name, "m", f"Displacement of {joint}", 1e-3))
    has_film = "main_bearing" in options.crank_surfaces()  # its outputs have the same names
    answers += declared(BlockForce, absent=("main_bearing",) * has_film)
    if walls := options.temperatures:
        acting = with_wall_temperatures(acting, walls, options)
        answers += [one for film in films for one in declared(OilOutputs, output_variable, *film)]
    if options.mounted:
        acting += declared(BlockInputs, _input)
    if outside := options.block.bore_from_outside:
        acting += declared(BoreInputs, _input, shape=tuple(outside))
        answers += declared(BoreOutputs, shape=tuple(outside))
    if options.in_space:
        answers += declared(SpaceScalars)
    starts = {f"{name}_temperature_rise": getattr(walls, name).rise for name in fixed_walls(walls)}
    return acting + answers + parameters(*own_parameters(options), starts=starts)


def own_parameters(options: BuildOptions) -> list[type]:
    """Return the classes of the parameters of single parts, in addition to `Parameters`."""
    pin = options.floating_pin
    return [
        *[PinParameters] * bool(pin),
        *[AxisParameters] * bool(pin and pin.pin_shapes),
        *(CRANK_PARAMETERS[name] for name in options.crank_surfaces()),
        *[SpaceParameters] * (options.in_space is not None),
        *(WALL_PARAMETERS[name] for name in fixed_walls(options.temperatures)),
    ]


def fixed_walls(walls: WallTemperatures | None) -> list[str]:
    """Return the walls whose temperature the build options give, without those of field inputs."""
    return [name for name in WALL_PARAMETERS if walls and not getattr(walls, name).varies]


def with_wall_temperatures(
    acting: list[Variable], walls: WallTemperatures, options: BuildOptions
) -> list[Variable]:
    """Return the inputs with those for walls: start values of levels, or field inputs."""
    fixed = {WALL_LEVELS[name]: getattr(walls, name).level for name in fixed_walls(walls)}
    others = [one for one in acting if one.name not in WALL_LEVELS.values()]
    levels = [
        replace(
            one, start=fixed[one.name], minimum=WALL_TEMPERATURES[0], maximum=WALL_TEMPERATURES[1]
        )
        for one in acting
        if one.name in fixed
    ]
    shapes = {}
    if walls.skirt.varies:
        shapes = {f"{one.prefix}{WALL_FIELDS['skirt']}": one.shape for one in options.film_grids()}
    if walls.bore.varies:
        shapes[WALL_FIELDS["bore"]] = options.grid[0], walls.stations
    text = "Temperature of the wall, which grows above reference_temperature"
    fields = [
        input_variable(name, "K", text, REFERENCE, 300.0, shape, limits=WALL_TEMPERATURES)
        for name, shape in shapes.items()
    ]
    return others + levels + fields


def inputs(films: tuple[FilmGrid, ...], pins: tuple[FilmGrid, ...] = ()) -> list[Variable]:
    """Return the inputs of the bodies. `pins` are the films of a floating pin."""
    return [
        *(one for film in films for one in declared(SkirtInputs, _input, *film)),
        *(one for pin in pins for one in declared(PinInputs, _input, *pin)),
        *declared(OtherInputs, _input),
    ]


def outputs(
    films: tuple[FilmGrid, ...], modes: int, pins: tuple[FilmGrid, ...] = ()
) -> list[Variable]:
    """Return the outputs of the bodies. `pins` are the films of a floating pin."""
    return [
        *(one for film in films for one in declared(SkirtOutputs, output_variable, *film)),
        *(one for pin in pins for one in declared(PinOutputs, output_variable, *pin)),
        *declared(Scalars),
        *(
            one
            for film in (*films, *pins)
            for one in declared(WorkOutputs, output_variable, film.prefix)
        ),
        *declared(Evaluations, partial(output_variable, start=0)),
        *of_modes(ModalOutputs, modes),
    ]


def of_modes(kind: type, modes: int) -> list[Variable]:
    """Return the modal outputs of a body; one without modes has none."""
    return declared(kind, shape=(modes,)) if modes else []


def declared(
    kind: type,
    make: Callable[..., Variable] = output_variable,
    prefix: str = "",
    shape: tuple[int, ...] = (),
    absent: tuple[str, ...] = (),
) -> list[Variable]:
    """Return the variables of a named tuple.

    Parameters
    ----------
    kind : type
        Each member has its unit and numbers in the annotation, and its description below.
    make : callable
        Takes name, unit, text, numbers of the annotation, and `shape`. Default: outputs.
    prefix : str
        Beginning of all names.
    shape : tuple of int
        Shape of the arrays.
    absent : tuple of str
        Prefixes of the names to omit.
    """
    return [
        make(
            f"{prefix}{name}",
            hint.__metadata__[0],
            description(kind, name),
            *hint.__metadata__[1:],
            shape=shape if hint.__origin__ is np.ndarray else (),
        )
        for name, hint in get_type_hints(kind, include_extras=True).items()
        if not name.startswith(absent)
    ]


def _input(
    name: str,
    unit: str,
    text: str,
    start: float,
    nominal: float,
    limits: tuple[float | None, float | None] = (None, None),
    shape: tuple[int, ...] = (),
) -> Variable:
    """Return an input of a row of `declared`."""
    return input_variable(name, unit, text, start, nominal, shape, limits=limits)


def parameters(*own: type, starts: Mapping[str, float] | None = None) -> list[Variable]:
    """Return the parameters of `Parameters`, of force elements, and of the classes `own`.

    An example of `own` is `PinParameters`. `starts` are start values that replace defaults.
    """
    return declared_parameters([Parameters, *ELEMENT_PARAMETERS, *own], starts)


def declared_parameters(
    kinds: Iterable[type], starts: Mapping[str, Any] | None = None
) -> list[Variable]:
    """Return the parameters of dataclasses, each described by the text below it.

    `starts` are start values that replace defaults.
    """
    return [
        Variable(
            one.name,
            causality="parameter",
            description=description(kind, one.name),
            start=(starts or {}).get(one.name, getattr(kind, one.name)),
            tunable=kind is Parameters and one.name in TUNABLE,
            **one.metadata,
        )
        for kind in kinds
        for one in fields(kind)
    ]


def properties(options: BuildOptions) -> list[Variable]:
    """Return the constants of the built FMU."""
    sizes = []
    surfaces = [
        *((film, "skirt") for film in options.film_grids()),
        *((film, "pin") for film in options.pin_grids()),
    ]
    for film, what in surfaces:
        around, along = film.shape
        sizes += [
            constant(
                f"{film.prefix}n_circumferential",
                around,
                f"Number of film grid cells around the {what}",
            ),
            constant(f"{film.prefix}n_axial", along, f"Number of film grid cells along the {what}"),
        ]
    return [
        *sizes,
        constant("piston_modes", options.piston.modes, "Number of modes of the piston"),
        constant("block_modes", options.block.modes, "Number of modes of the cylinder block"),
        constant("contract_version", 2, "Version of the interface contract"),
    ]
