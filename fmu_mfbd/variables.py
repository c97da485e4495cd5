"""Every variable of the body FMU, declared once (the interface contract's names)."""

from dataclasses import fields
from math import pi

from ..master.fmi.variables import Variable, constant, input_variable, output_variable
from .dynamics.build_options import BoreGrid, BuildOptions, FilmGrid
from .dynamics.parameters import (
    CRANK_PARAMETERS,
    AxisParameters,
    Parameters,
    PinParameters,
    SpaceParameters,
)


def variables(options: BuildOptions) -> list[Variable]:
    """The table of variables of an FMU built so."""
    return signals(options) + properties(options)


def signals(options: BuildOptions) -> list[Variable]:
    """Inputs, outputs and parameters of an FMU built so."""
    modes = options.piston.modes + options.block.modes
    films = options.film_grids()
    pins = options.pin_grids()
    bending = options.floating_pin is not None and options.floating_pin.pin_shapes > 0
    acting, answers = inputs(films, pins), outputs(films, modes, pins)
    if bending:
        answers = answers + axis_outputs()
    if pins and options.floating_pin and options.floating_pin.small_end_modes:
        answers = answers + eye_outputs(options.floating_pin.small_end_modes)
    answers = answers + [
        one for name in options.crank_surfaces() for one in crank_outputs(name, *OF_CRANK[name])
    ]
    if options.mounted:
        acting, answers = acting + block_inputs(), answers + block_outputs()
    if outside := options.block.bore_from_outside:
        acting, answers = acting + [bore_input(outside)], answers + bore_outputs(outside)
    if options.in_space:
        answers = answers + space_outputs()
    kinds: list[type] = [PinParameters] * bool(pins) + [AxisParameters] * bending
    kinds += [CRANK_PARAMETERS[name] for name in options.crank_surfaces()]
    kinds += [SpaceParameters] * (options.in_space is not None)
    return acting + answers + parameters(*kinds)


def inputs(films: tuple[FilmGrid, ...], pins: tuple[FilmGrid, ...] = ()) -> list[Variable]:
    """What acts on the bodies; `pins`: films of a floating pin."""
    of_films = [
        (
            input_variable(
                f"{film.prefix}nodal_pressure_force",
                "N",
                "Pressure force on a grid cell; positive pushes skirt and bore apart",
                0.0,
                1.0,
                film.shape,
            ),
            input_variable(
                f"{film.prefix}nodal_friction_force",
                "N",
                "Axial force of the film on the skirt in a grid cell; its opposite acts on the "
                "bore",
                0.0,
                0.1,
                film.shape,
            ),
        )
        for film in films
    ]
    return [
        *(one for pair in of_films for one in pair),
        *(one for pin in pins for one in _on_pin(pin)),
        input_variable(
            "gas_pressure",
            "Pa",
            "Gauge pressure on the piston crown and on the bore above the top ring; gas_source "
            "says whether it adds to the built-in table or replaces it",
            0.0,
            1e6,
        ),
        input_variable(
            "land_pressure", "Pa", "Gauge pressure on the bore between the rings", 0.0, 1e5
        ),
        input_variable(
            "ring_side_force",
            "N",
            "Force of the rings on the piston towards the thrust side",
            0.0,
            1e2,
        ),
        input_variable(
            "ring_axial_force",
            "N",
            "Force of the rings on the piston towards the head, on the axis of the bore",
            0.0,
            1e2,
        ),
        input_variable(
            "ring_moment",
            "N.m",
            "Moment of the rings on the piston about A, about +z, beside that of their axial force",
            0.0,
            1.0,
        ),
        Variable(
            "crank_speed",
            "rad/s",
            "input",
            "Speed of the crank at the end of the step; of a free crank at the start",
            start=100 * pi,
            nominal=300.0,
            minimum=0.0,
            maximum=3000.0,
        ),
    ]


def _on_pin(film: FilmGrid) -> list[Variable]:
    """What a film of the floating pin does."""
    return [
        input_variable(
            f"{film.prefix}nodal_pressure_force",
            "N",
            "Pressure force on a grid cell; positive pushes pin and shell apart",
            0.0,
            1.0,
            film.shape,
        ),
        input_variable(
            f"{film.prefix}nodal_friction_force",
            "N",
            "Axial force of the film on the pin: without effect, nothing moves along it",
            0.0,
            0.1,
            film.shape,
        ),
        input_variable(
            f"{film.prefix}nodal_circumferential_force",
            "N",
            "Circumferential force of the film on the pin, positive with ascending i; its opposite "
            "acts on the shell",
            0.0,
            0.1,
            film.shape,
        ),
    ]


def _of_pin(film: FilmGrid) -> list[Variable]:
    """What a film of the floating pin is told."""
    return [
        output_variable(
            f"{film.prefix}film_thickness",
            "m",
            "Radial distance shell minus pin; negative where they overlap",
            1e-5,
            film.shape,
        ),
        output_variable(
            f"{film.prefix}sliding_velocity",
            "m/s",
            "Axial velocity of pin minus shell: 0",
            1.0,
            film.shape,
        ),
        output_variable(
            f"{film.prefix}circumferential_velocity",
            "m/s",
            "Circumferential velocity of pin minus shell, positive with ascending i",
            1.0,
            film.shape,
        ),
    ]


PIN_MOTION = (
    output_variable(
        "pin_displacement_x", "m", "Of the pin's axis from that of the bosses, along x", 1e-5
    ),
    output_variable(
        "pin_displacement_y", "m", "Of the pin's axis from that of the bosses, along y", 1e-5
    ),
    output_variable(
        "small_end_displacement_x", "m", "Of the pin's axis from that of the rod's eye, x", 1e-5
    ),
    output_variable(
        "small_end_displacement_y", "m", "Of the pin's axis from that of the rod's eye, y", 1e-5
    ),
    output_variable("pin_angle", "rad", "Angle that the pin has turned about +z", 1.0),
    output_variable("pin_rotation_speed", "rad/s", "Of the pin about +z", 10.0),
    output_variable("small_end_force_x", "N", "Force of the pin on the rod along x", 1e3),
    output_variable("small_end_force_y", "N", "Force of the pin on the rod along y", 1e3),
    output_variable(
        "small_end_friction_moment", "N.m", "Friction of the pin on the rod about +z", 0.1
    ),
)
"""Motion of a floating pin, and what it does to the rod."""


def outputs(
    films: tuple[FilmGrid, ...], modes: int, pins: tuple[FilmGrid, ...] = ()
) -> list[Variable]:
    """What the bodies answer; `pins`: films of a floating pin."""
    of_films = [
        (
            output_variable(
                f"{film.prefix}film_thickness",
                "m",
                "Radial distance bore minus skirt; negative where they overlap",
                1e-5,
                film.shape,
            ),
            output_variable(
                f"{film.prefix}sliding_velocity",
                "m/s",
                "Axial velocity of the skirt minus that of the bore",
                1.0,
                film.shape,
            ),
        )
        for film in films
    ]
    out = [
        *(one for pair in of_films for one in pair),
        *(one for pin in pins for one in _of_pin(pin)),
        output_variable("crank_angle", "rad", "Crank angle, 0 at firing top dead centre", 1.0),
        output_variable("rotation_speed", "rad/s", "Speed of the crank now", 300.0),
        output_variable("piston_position", "m", "Height of pin point A above the crank axis", 0.1),
        output_variable("piston_velocity", "m/s", "Velocity of pin point A towards the head", 10.0),
        output_variable(
            "lateral_displacement",
            "m",
            "Displacement of A from its concentric position towards the thrust side",
            1e-5,
        ),
        output_variable(
            "rocking_angle", "rad", "Rotation of the piston about the pin axis +z", 1e-3
        ),
        output_variable("lateral_velocity", "m/s", "Velocity of A towards the thrust side", 1e-2),
        output_variable(
            "rocking_velocity", "rad/s", "Angular velocity of the piston about the pin axis +z", 1.0
        ),
        output_variable(
            "side_force",
            "N",
            "Force of the piston on the bore through the film, positive on the thrust side",
            1e3,
        ),
        output_variable(
            "side_force_demand",
            "N",
            "Side force that gas, rings and inertia ask of a rigid piston amid the bore",
            1e3,
        ),
        output_variable(
            "crank_torque",
            "N.m",
            "Torque of the drive on the crank in its direction of turning",
            10.0,
        ),
        output_variable("cylinder_pressure", "Pa", "Gauge pressure on the crown now", 1e6),
        output_variable("pin_force_x", "N", "Force of the pin on the piston along x", 1e3),
        output_variable("pin_force_y", "N", "Force of the pin on the piston along y", 1e3),
        output_variable(
            "pin_friction_moment", "N.m", "Friction of the pin on the piston about +z", 0.1
        ),
        output_variable(
            "pin_friction_power", "W", "What friction at the pin turns into heat", 10.0
        ),
        *(
            output_variable(
                f"{film.prefix}interface_work_error",
                "1",
                "Power of the interface forces on the grid minus that in the coordinates, relative",
            )
            for film in (*films, *pins)
        ),
        *(PIN_MOTION if pins else ()),
        output_variable(
            "kinetic_energy",
            "J",
            "Kinetic energy of the motion across the bore, rocking and modes included",
            1e-3,
        ),
        output_variable("elastic_energy", "J", "Elastic energy of all modes", 1e-3),
        output_variable("film_work", "J", "Work of the film on the bodies over the step", 1e-3),
        output_variable(
            "energy_error",
            "J",
            "Energy across the bore that time integration made (+) or lost (-) over the step",
            1e-3,
        ),
        output_variable(
            "energy_gain",
            "J",
            "Energy that the bodies took from the film over the step, by what their motion shows",
            1e-3,
        ),
        output_variable(
            "energy_size",
            "J",
            "Kinetic energy across the bore, the rod's with it, and what other forces than the "
            "film's passed to and fro over the step",
            1e-3,
        ),
        output_variable(
            "residual_evaluations",
            "1",
            "Residuals of the equations of motion evaluated so far (NRES)",
            start=0,
        ),
        output_variable(
            "jacobian_evaluations",
            "1",
            "Jacobians of the equations of motion evaluated so far (NJAC)",
            start=0,
        ),
    ]
    if modes:
        out += [
            output_variable(
                "modal_coordinate",
                "1",
                "Mass-normalised modal coordinates [kg^(1/2) m], piston then block",
                1e-6,
                (modes,),
            ),
            output_variable(
                "modal_velocity", "1/s", "Their derivatives in time [kg^(1/2) m/s]", 1e-2, (modes,)
            ),
        ]
    return out


def block_inputs() -> list[Variable]:
    """How a mounted block moves, in the plane of the cylinder."""
    along = "in the cylinder's axes, at the crank axis"
    return [
        input_variable("block_acceleration_x", "m/s2", f"Of the block, {along}", 0.0, 1.0),
        input_variable("block_acceleration_y", "m/s2", f"Of the block, {along}", 0.0, 1.0),
        input_variable(
            "block_angular_acceleration", "rad/s2", "Of the block about the crank axis", 0.0, 10.0
        ),
        input_variable(
            "block_angular_velocity", "rad/s", "Of the block about the crank axis", 0.0, 0.1
        ),
    ]


def block_outputs() -> list[Variable]:
    """What the cylinder does to a mounted block."""
    return [
        output_variable(
            "force_on_block_x",
            "N",
            "Force of bore, deck and main bearings on the block along x",
            1e3,
        ),
        output_variable(
            "force_on_block_y",
            "N",
            "Force of bore, deck and main bearings on the block along y",
            1e3,
        ),
        output_variable(
            "moment_on_block", "N.m", "Moment of bore and deck about the crank axis", 1e2
        ),
        output_variable(
            "main_bearing_force_x", "N", "Force of the crank on its main bearings along x", 1e3
        ),
        output_variable(
            "main_bearing_force_y", "N", "Force of the crank on its main bearings along y", 1e3
        ),
    ]


OF_CRANK = {
    "big_end": ("crank pin", "rod's big end", "rod"),
    "main_bearing": ("crank's journal", "main bearing", "block"),
}
"""What turns, in what, and whose that is."""


def crank_outputs(name: str, journal: str, shell: str, body: str) -> list[Variable]:
    """Where the crank stands in one of its films, and what it does there."""
    of = f"Of the {journal} from the middle of the {shell}, along"
    force = f"Force of the {journal} on the {body} along"
    return [
        output_variable(f"{name}_displacement_x", "m", f"{of} x", 1e-5),
        output_variable(f"{name}_displacement_y", "m", f"{of} y", 1e-5),
        output_variable(f"{name}_force_x", "N", f"{force} x", 1e3),
        output_variable(f"{name}_force_y", "N", f"{force} y", 1e3),
        output_variable(
            f"{name}_friction_moment",
            "N.m",
            f"Friction of the {journal} on the {body} about +z",
            0.1,
        ),
    ]


def axis_outputs() -> list[Variable]:
    """How a floating pin tilts and bends."""
    middle = "Middle of the floating pin's axis from the mean of both ends, along"
    return [
        output_variable("pin_tilt_x", "rad", "Tilt of the floating pin in its bosses, dx/dz", 1e-4),
        output_variable("pin_tilt_y", "rad", "Tilt of the floating pin in its bosses, dy/dz", 1e-4),
        output_variable("pin_bending_x", "m", f"{middle} x", 1e-5),
        output_variable("pin_bending_y", "m", f"{middle} y", 1e-5),
    ]


def eye_outputs(modes: int) -> list[Variable]:
    """How a rod's eye yields."""
    wider = "Change of the diameter of the rod's eye amid its length, "
    return [
        output_variable("small_end_widening_across", "m", f"{wider}across the rod", 1e-5),
        output_variable("small_end_widening_along", "m", f"{wider}along the rod", 1e-5),
        output_variable(
            "small_end_modal_coordinate",
            "1",
            "Mass-normalised modal coordinates of the rod's eye [kg^(1/2) m]",
            1e-6,
            (modes,),
        ),
        output_variable(
            "small_end_modal_velocity",
            "1/s",
            "Their derivatives in time [kg^(1/2) m/s]",
            1e-2,
            (modes,),
        ),
    ]


def bore_input(grid: BoreGrid) -> Variable:
    """How a bore deflects from outside."""
    return input_variable(
        "bore_deflection",
        "m",
        "Of the bore, outwards, at its own angles and heights",
        0.0,
        1e-5,
        tuple(grid),
    )


def bore_outputs(grid: BoreGrid) -> list[Variable]:
    """What the cylinder does to a block that deflects."""
    return [
        output_variable(
            "force_on_bore",
            "N",
            "Of film and gas on the bore, outwards, at its own angles and heights",
            10.0,
            tuple(grid),
        ),
        output_variable("force_on_deck", "N", "Of gas on the deck along y", 1e3),
    ]


def space_outputs() -> list[Variable]:
    """Motion of a piston out of the plane of the crank, and what holds it."""
    return [
        output_variable("pin_axis_displacement", "m", "Displacement of A along the pin, +z", 1e-5),
        output_variable(
            "roll_angle", "rad", "Rotation of the piston about +x, held pin_tilt included", 1e-3
        ),
        output_variable("yaw_angle", "rad", "Rotation of the piston about +y", 1e-3),
        output_variable("pin_axis_velocity", "m/s", "Velocity of A along the pin", 1e-2),
        output_variable("roll_velocity", "rad/s", "Angular velocity about +x", 1.0),
        output_variable("yaw_velocity", "rad/s", "Angular velocity about +y", 1.0),
        output_variable(
            "pin_axis_side_force", "N", "Force of the piston on the bore through the film, +z", 1e2
        ),
        output_variable("rod_force_z", "N", "Stop and damper of the rod on the pin, along z", 10.0),
        output_variable("rod_moment_x", "N.m", "Of the rod's eye on the pin about +x", 1.0),
        output_variable("rod_moment_y", "N.m", "Of the rod's eye on the pin about +y", 1.0),
    ]


def parameters(*own: type) -> list[Variable]:
    """What a user may set, as `Parameters` declares it, and `own` classes: `PinParameters` of a
    floating pin and others.
    """
    kinds = [Parameters, *own]
    defaults = {name: value for kind in kinds for name, value in vars(kind()).items()}
    return [
        Variable(one.name, causality="parameter", start=defaults[one.name], **one.metadata)
        for kind in kinds
        for one in fields(kind)
    ]


def properties(options: BuildOptions) -> list[Variable]:
    """Properties of the built FMU, readable and never settable."""
    sizes = []
    surfaces = [
        *((film, "skirt") for film in options.film_grids()),
        *((film, "pin") for film in options.pin_grids()),
    ]
    for film, what in surfaces:
        around, along = film.shape
        sizes += [
            constant(
                f"{film.prefix}n_circumferential", around, f"Film grid cells around the {what}"
            ),
            constant(f"{film.prefix}n_axial", along, f"Film grid cells along the {what}"),
        ]
    return [
        *sizes,
        constant("piston_modes", options.piston.modes, "Modes of the piston"),
        constant("block_modes", options.block.modes, "Modes of the cylinder block"),
        constant("contract_version", 2, "Version of the interface contract"),
    ]
