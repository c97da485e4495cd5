"""Variables of the body FMU, with the names of the interface contract."""

from collections.abc import Mapping
from dataclasses import fields, replace
from math import pi
from typing import Any, get_type_hints

from ..master.fmi.variables import Variable, constant, input_variable, output_variable
from .dynamics.block_force import BlockForce
from .dynamics.build_options import BoreGrid, BuildOptions, FilmGrid, WallTemperatures
from .dynamics.drive import Scalars
from .dynamics.model import OIL
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
from .dynamics.pin_outputs import PinScalars
from .dynamics.space_model import SpaceScalars

Rows = tuple[tuple[Any, ...], ...]
"""Name, unit, description and numbers of variables, as `input_variable` and `output_variable` take
them.
"""

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
"""Motion of a mounted block, as `Carrier`."""
SKIRT_INPUTS: Rows = (
    (
        "nodal_pressure_force",
        "N",
        "Pressure force on a grid cell; positive separates skirt and bore",
        0.0,
        1.0,
    ),
    (
        "nodal_friction_force",
        "N",
        "Axial force of the film on the skirt in a grid cell; the opposite force acts on the bore",
        0.0,
        0.1,
    ),
)
PIN_INPUTS: Rows = (
    (
        "nodal_pressure_force",
        "N",
        "Pressure force on a grid cell; positive separates pin and shell",
        0.0,
        1.0,
    ),
    (
        "nodal_friction_force",
        "N",
        "Axial force of the film on the pin; it has no effect, because the pin does not move "
        "axially",
        0.0,
        0.1,
    ),
    (
        "nodal_circumferential_force",
        "N",
        "Circumferential force of the film on the pin, positive with ascending i; the opposite "
        "force acts on the shell",
        0.0,
        0.1,
    ),
)
GAUGE = (-2e5, 1e8)
FORCE = (-1e9, 1e9)
FAST = (-1e6, 1e6)
"""Ranges of gauge pressures [Pa], forces of the rings [N] and accelerations of a block."""
GROWING = {"piston": "skirt", "bore": "bore"}
WALL_LEVELS = {"skirt": "piston_temperature", "bore": "bore_temperature"}
"""Wall -> input with the level of its temperature."""
WALL_FIELDS = {"skirt": "skirt_temperature_field", "bore": "bore_temperature_field"}
"""Wall -> field input of its temperature, which replaces the level."""
WARMEST = (233.15, 573.15)
"""Range of the temperature of a wall with a film, as of the oil [K]."""
OTHER_INPUTS = (
    input_variable(
        "gas_pressure",
        "Pa",
        "Gauge pressure on the piston crown and on the bore above the top ring; gas_source "
        "combines it with the built-in table",
        0.0,
        1e6,
        limits=GAUGE,
    ),
    input_variable(
        "crankcase_pressure",
        "Pa",
        "Gauge pressure below the piston, over the area of the bore",
        0.0,
        1e5,
        limits=GAUGE,
    ),
    input_variable(
        "land_pressure",
        "Pa",
        "Gauge pressure on the bore between the rings",
        0.0,
        1e5,
        limits=GAUGE,
    ),
    input_variable(
        "ring_side_force",
        "N",
        "Force of the rings on the piston towards the thrust side",
        0.0,
        1e2,
        limits=FORCE,
    ),
    input_variable(
        "ring_axial_force",
        "N",
        "Force of the rings on the piston towards the head, along the bore axis",
        0.0,
        1e2,
        limits=FORCE,
    ),
    input_variable(
        "ring_moment",
        "N.m",
        "Moment of the rings on the piston about +z at pin point A, in addition to that of their "
        "axial force",
        0.0,
        1.0,
        limits=(-1e5, 1e5),
    ),
    input_variable(
        "load_torque",
        "N.m",
        "Load torque on a free crank against its direction of rotation, at the end of the step; "
        "without effect on a crank of prescribed speed",
        0.0,
        10.0,
        limits=(-1e7, 1e7),
    ),
    *(
        input_variable(
            f"{body}_temperature",
            "K",
            f"Level of the temperature of the {body}, with which the {grows} grows from "
            "reference_temperature on; it is even unless build options give a distribution",
            293.15,
            300.0,
            limits=(200.0, 1000.0),
        )
        for body, grows in GROWING.items()
    ),
    input_variable(
        "crank_speed",
        "rad/s",
        "Speed of the crank at the end of the step; for a free crank, at the start",
        100 * pi,
        300.0,
        limits=(0.0, 3000.0),
    ),
)
SKIRT_OUTPUTS: Rows = (
    (
        "film_thickness",
        "m",
        "Radial distance from skirt to bore; negative where they overlap",
        1e-5,
    ),
    ("sliding_velocity", "m/s", "Axial velocity of the skirt relative to the bore", 1.0),
)
PIN_OUTPUTS: Rows = (
    ("film_thickness", "m", "Radial distance from pin to shell; negative where they overlap", 1e-5),
    ("sliding_velocity", "m/s", "Axial velocity of the pin relative to the shell; always 0", 1.0),
    (
        "circumferential_velocity",
        "m/s",
        "Circumferential velocity of the pin relative to the shell, positive with ascending i",
        1.0,
    ),
)
OTHER_OUTPUTS: Rows = (
    (
        "side_force_demand",
        "N",
        "Side-force demand of gas, rings and inertia, for a rigid piston in the middle of the bore",
        1e3,
    ),
    ("cylinder_pressure", "Pa", "Current gauge pressure on the crown", 1e6),
)
MODES: Rows = (
    (
        "modal_coordinate",
        "1",
        "Mass-normalised modal coordinates [kg^(1/2) m], those of the piston first, then of the "
        "block",
        1e-6,
    ),
    ("modal_velocity", "1/s", "Time derivatives of the modal coordinates [kg^(1/2) m/s]", 1e-2),
)


BEARINGS: Rows = (
    (
        "bearing_coordinate",
        "1",
        "Coordinates of pin, crank and shells for a start: plays [m], angle of the pin [rad], "
        "shapes and modes [kg^(1/2) m]",
        1e-6,
    ),
    ("bearing_velocity", "1/s", "Time derivatives of the coordinates of pin and crank", 1e-2),
)


EYE_MODES: Rows = (
    (
        "small_end_modal_coordinate",
        "1",
        "Mass-normalised modal coordinates of the small end [kg^(1/2) m]",
        1e-6,
    ),
    (
        "small_end_modal_velocity",
        "1/s",
        "Time derivatives of the modal coordinates [kg^(1/2) m/s]",
        1e-2,
    ),
)


def variables(options: BuildOptions) -> list[Variable]:
    """Return the variables of an FMU with these build options."""
    return signals(options) + properties(options)


def signals(options: BuildOptions) -> list[Variable]:
    """Return inputs, outputs and parameters of an FMU with these build options."""
    modes = options.piston.modes + options.block.modes
    films = options.film_grids()
    pins = options.pin_grids()
    acting, answers = inputs(films, pins), outputs(films, modes, pins)
    pin = options.floating_pin
    if pins:
        answers = answers + declared(PinScalars, options.absent_parts())
    answers = answers + of_modes(BEARINGS, options.bearing_coordinates())
    if pin and pin.small_end_modes:
        answers = answers + of_modes(EYE_MODES, pin.small_end_modes)
    film = "main_bearing" in options.crank_surfaces()  # which has outputs of these names
    answers = answers + declared(BlockForce, ("main_bearing",) * film)
    if walls := options.temperatures:
        acting = warmed(acting, walls, options)
        answers = answers + [oil_output(film) for film in films]
    if options.mounted:
        acting = acting + block_inputs()
    if outside := options.block.bore_from_outside:
        acting, answers = acting + [bore_input(outside)], answers + bore_outputs(outside)
    if options.in_space:
        answers = answers + declared(SpaceScalars)
    kinds: list[type] = [PinParameters] * bool(pin)
    kinds += [AxisParameters] * bool(pin and pin.pin_shapes)
    kinds += [CRANK_PARAMETERS[name] for name in options.crank_surfaces()]
    kinds += [SpaceParameters] * (options.in_space is not None)
    kinds += [WALL_PARAMETERS[name] for name in fixed_walls(walls)]
    starts = {f"{name}_temperature_rise": getattr(walls, name).rise for name in fixed_walls(walls)}
    return acting + answers + parameters(*kinds, starts=starts)


def fixed_walls(walls: WallTemperatures | None) -> list[str]:
    """Return the walls whose temperature the build options give, without those of field inputs."""
    return [name for name in WALL_PARAMETERS if walls and not getattr(walls, name).varies]


def warmed(
    acting: list[Variable], walls: WallTemperatures, options: BuildOptions
) -> list[Variable]:
    """Return the inputs with the temperatures of walls: start values of levels, or fields."""
    fixed = {WALL_LEVELS[name]: getattr(walls, name).level for name in fixed_walls(walls)}
    others = [one for one in acting if one.name not in WALL_LEVELS.values()]
    levels = [
        replace(one, start=fixed[one.name], minimum=WARMEST[0], maximum=WARMEST[1])
        for one in acting
        if one.name in fixed
    ]
    shapes = {}
    if walls.skirt.varies:
        shapes = {f"{one.prefix}{WALL_FIELDS['skirt']}": one.shape for one in options.film_grids()}
    if walls.bore.varies:
        shapes[WALL_FIELDS["bore"]] = options.grid[0], walls.stations
    text = "Temperature of the wall, with which it grows from reference_temperature on"
    fields = [
        input_variable(name, "K", text, REFERENCE, 300.0, shape, limits=WARMEST)
        for name, shape in shapes.items()
    ]
    return others + levels + fields


def oil_output(film: FilmGrid) -> Variable:
    """Return the oil temperature of a film between walls whose temperatures are given."""
    text = "Oil temperature, mean of both walls; the bore is read where the cell is now"
    return output_variable(f"{film.prefix}{OIL}", "K", text, 300.0, film.shape)


def inputs(films: tuple[FilmGrid, ...], pins: tuple[FilmGrid, ...] = ()) -> list[Variable]:
    """Return the inputs of the bodies. `pins` are the films of a floating pin."""
    return [
        *(one for film in films for one in on_grid(input_variable, film, SKIRT_INPUTS)),
        *(one for pin in pins for one in on_grid(input_variable, pin, PIN_INPUTS)),
        *OTHER_INPUTS,
    ]


def on_grid(make: Any, film: FilmGrid, rows: Rows) -> list[Variable]:
    """Return the variables of a film, one of each row."""
    return [make(f"{film.prefix}{name}", *rest, film.shape) for name, *rest in rows]


def outputs(
    films: tuple[FilmGrid, ...], modes: int, pins: tuple[FilmGrid, ...] = ()
) -> list[Variable]:
    """Return the outputs of the bodies. `pins` are the films of a floating pin."""
    return [
        *(one for film in films for one in on_grid(output_variable, film, SKIRT_OUTPUTS)),
        *(one for pin in pins for one in on_grid(output_variable, pin, PIN_OUTPUTS)),
        *declared(Scalars),
        *(output_variable(*row) for row in OTHER_OUTPUTS),
        *(
            output_variable(
                f"{film.prefix}interface_work_error",
                "1",
                "Relative difference between the power of the interface forces on the grid "
                "and in the coordinates",
            )
            for film in (*films, *pins)
        ),
        output_variable(
            "residual_evaluations",
            "1",
            "Number of residual evaluations of the equations of motion so far (NRES)",
            start=0,
        ),
        output_variable(
            "jacobian_evaluations",
            "1",
            "Number of Jacobian evaluations of the equations of motion so far (NJAC)",
            start=0,
        ),
        *of_modes(MODES, modes),
    ]


def of_modes(rows: Rows, modes: int) -> list[Variable]:
    """Return the modal outputs of a body; one without modes has none."""
    return [output_variable(*row, shape=(modes,)) for row in rows if modes]


def declared(kind: type, absent: tuple[str, ...] = ()) -> list[Variable]:
    """Return the outputs of a named tuple, except those whose names begin like absent parts."""
    return [
        output_variable(name, *hint.__metadata__)
        for name, hint in get_type_hints(kind, include_extras=True).items()
        if not name.startswith(absent)
    ]


def block_inputs() -> list[Variable]:
    """Return the motion of a mounted block in the plane of the cylinder."""
    text = "Acceleration of the block at the crank axis along the cylinder's"
    return [
        *(
            input_variable(
                f"block_acceleration_{axis}", "m/s2", f"{text} {axis}", 0.0, 1.0, limits=FAST
            )
            for axis in "xy"
        ),
        input_variable(
            "block_angular_acceleration",
            "rad/s2",
            "Angular acceleration of the block about the crank axis",
            0.0,
            10.0,
            limits=FAST,
        ),
        input_variable(
            "block_angular_velocity",
            "rad/s",
            "Angular velocity of the block about the crank axis",
            0.0,
            0.1,
            limits=(-1e4, 1e4),
        ),
    ]


def bore_input(grid: BoreGrid) -> Variable:
    """Return the deflection of a bore that another participant computes."""
    return input_variable(
        "bore_deflection",
        "m",
        "Outward deflection of the bore, on its grid of angles and heights",
        0.0,
        1e-5,
        tuple(grid),
    )


def bore_outputs(grid: BoreGrid) -> list[Variable]:
    """Return the forces of the cylinder on a deflecting block."""
    return [
        output_variable(
            "force_on_bore",
            "N",
            "Outward force of film and gas on the bore, on its grid of angles and heights",
            10.0,
            tuple(grid),
        ),
        output_variable("force_on_deck", "N", "Force of the gas on the deck along y", 1e3),
    ]


def parameters(*own: type, starts: Mapping[str, float] | None = None) -> list[Variable]:
    """Return the parameters of `Parameters`, of force elements, and of own classes.

    `own` are e.g. `PinParameters`. `starts` are start values that replace defaults.
    """
    kinds = [Parameters, *ELEMENT_PARAMETERS, *own]
    defaults = {name: value for kind in kinds for name, value in vars(kind()).items()}
    defaults |= starts or {}
    return [
        Variable(
            one.name,
            causality="parameter",
            start=defaults[one.name],
            tunable=one.name in TUNABLE,
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
