"""Every variable of the body FMU, declared once (the interface contract's names)."""

from dataclasses import fields
from math import pi

from ..master.fmi.variables import Variable, constant
from .dynamics.build_options import BuildOptions
from .dynamics.parameters import Parameters


def variables(options: BuildOptions) -> list[Variable]:
    """The table of variables of an FMU built so."""
    modes = options.piston.modes + options.block.modes
    return inputs(options.grid) + outputs(options.grid, modes) + parameters() + properties(options)


def inputs(grid: tuple[int, int]) -> list[Variable]:
    """What acts on the bodies."""
    return [
        Variable(
            "nodal_pressure_force",
            "N",
            "input",
            "Pressure force on a grid cell; positive pushes skirt and bore apart",
            nominal=1.0,
            shape=grid,
        ),
        Variable(
            "nodal_friction_force",
            "N",
            "input",
            "Axial shear force on the skirt in a grid cell; its opposite acts on the bore",
            nominal=0.1,
            shape=grid,
        ),
        Variable("gas_pressure", "Pa", "input", "Gauge pressure on the piston crown", nominal=1e6),
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


def outputs(grid: tuple[int, int], modes: int) -> list[Variable]:
    """What the bodies answer."""
    out = [
        Variable(
            "film_thickness",
            "m",
            "output",
            "Radial distance bore minus skirt; negative where they overlap",
            nominal=1e-5,
            shape=grid,
        ),
        Variable(
            "sliding_velocity",
            "m/s",
            "output",
            "Axial velocity of the skirt minus that of the bore",
            nominal=1.0,
            shape=grid,
        ),
        Variable(
            "crank_angle", "rad", "output", "Crank angle, 0 at firing top dead centre", nominal=1.0
        ),
        Variable("rotation_speed", "rad/s", "output", "Speed of the crank now", nominal=300.0),
        Variable(
            "piston_position",
            "m",
            "output",
            "Height of pin point A above the crank axis",
            nominal=0.1,
        ),
        Variable(
            "piston_velocity",
            "m/s",
            "output",
            "Velocity of pin point A towards the head",
            nominal=10.0,
        ),
        Variable(
            "lateral_displacement",
            "m",
            "output",
            "Displacement of A from its concentric position towards the thrust side",
            nominal=1e-5,
        ),
        Variable(
            "rocking_angle",
            "rad",
            "output",
            "Rotation of the piston about the pin axis +z",
            nominal=1e-3,
        ),
        Variable(
            "lateral_velocity",
            "m/s",
            "output",
            "Velocity of A towards the thrust side",
            nominal=1e-2,
        ),
        Variable(
            "rocking_velocity",
            "rad/s",
            "output",
            "Angular velocity of the piston about the pin axis +z",
            nominal=1.0,
        ),
        Variable(
            "side_force",
            "N",
            "output",
            "Force of the piston on the bore through the film, positive on the thrust side",
            nominal=1e3,
        ),
        Variable(
            "crank_torque",
            "N.m",
            "output",
            "Torque of the drive on the crank in its direction of turning",
            nominal=10.0,
        ),
        Variable(
            "pin_force_x", "N", "output", "Force of the pin on the piston along x", nominal=1e3
        ),
        Variable(
            "pin_force_y", "N", "output", "Force of the pin on the piston along y", nominal=1e3
        ),
        Variable(
            "pin_friction_moment",
            "N.m",
            "output",
            "Friction of the pin on the piston about +z",
            nominal=0.1,
        ),
        Variable(
            "interface_work_error",
            "1",
            "output",
            "Power of the interface forces on the grid minus that in the coordinates, relative",
        ),
        Variable(
            "kinetic_energy",
            "J",
            "output",
            "Kinetic energy of the motion across the bore, rocking and modes included",
            nominal=1e-3,
        ),
        Variable("elastic_energy", "J", "output", "Elastic energy of all modes", nominal=1e-3),
        Variable(
            "film_work", "J", "output", "Work of the film on the bodies over the step", nominal=1e-3
        ),
        Variable(
            "energy_error",
            "J",
            "output",
            "Energy across the bore that time integration made (+) or lost (-) over the step",
            nominal=1e-3,
        ),
        Variable(
            "residual_evaluations",
            "1",
            "output",
            "Residuals of the equations of motion evaluated so far (NRES)",
            start=0,
        ),
        Variable(
            "jacobian_evaluations",
            "1",
            "output",
            "Jacobians of the equations of motion evaluated so far (NJAC)",
            start=0,
        ),
    ]
    if modes:
        out += [
            Variable(
                "modal_coordinate",
                "1",
                "output",
                "Mass-normalised modal coordinates [kg^(1/2) m], piston then block",
                nominal=1e-6,
                shape=(modes,),
            ),
            Variable(
                "modal_velocity",
                "1/s",
                "output",
                "Their derivatives in time [kg^(1/2) m/s]",
                nominal=1e-2,
                shape=(modes,),
            ),
        ]
    return out


def parameters() -> list[Variable]:
    """What a user may set, as `Parameters` declares it."""
    defaults = vars(Parameters())
    return [
        Variable(one.name, causality="parameter", start=defaults[one.name], **one.metadata)
        for one in fields(Parameters)
    ]


def properties(options: BuildOptions) -> list[Variable]:
    """Properties of the built FMU, readable and never settable."""
    around, along = options.grid
    return [
        constant("n_circumferential", around, "Film grid cells around the skirt"),
        constant("n_axial", along, "Film grid cells along the skirt"),
        constant("piston_modes", options.piston.modes, "Modes of the piston"),
        constant("block_modes", options.block.modes, "Modes of the cylinder block"),
        constant("contract_version", 1, "Version of the interface contract"),
    ]
