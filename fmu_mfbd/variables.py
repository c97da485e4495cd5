"""Every variable of the body FMU, declared once (the interface contract's names)."""

from ..master.fmi.variables import Variable, constant


def variables(options):
    """The table of variables.

    Parameters
    ----------
    options : dict
        Of the FMU's build.json: grid, piston.modes, block.modes.

    Returns
    -------
    list of Variable
    """
    grid = tuple(options["grid"])
    modes = options["piston"]["modes"] + options["block"]["modes"]
    return inputs(grid) + outputs(grid, modes) + parameters() + properties(options)


def inputs(grid):
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
            start=314.1592653589793,
            nominal=300.0,
            minimum=0.0,
            maximum=3000.0,
        ),
    ]


def outputs(grid, modes):
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
            "Displacement of A from its concentric place towards the thrust side",
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
        out.append(
            Variable(
                "modal_coordinate",
                "1",
                "output",
                "Mass-normalised modal coordinates [kg^(1/2) m], piston then block",
                nominal=1e-6,
                shape=(modes,),
            )
        )
        out.append(
            Variable(
                "modal_velocity",
                "1/s",
                "output",
                "Their rates [kg^(1/2) m/s]",
                nominal=1e-2,
                shape=(modes,),
            )
        )
    return out


def parameters():
    """What a user may set: the shipped case's values are the start values."""

    def parameter(name, unit, description, start, minimum=None, maximum=None):
        return Variable(
            name, unit, "parameter", description, start=start, minimum=minimum, maximum=maximum
        )

    return [
        parameter(
            "radial_clearance",
            "m",
            "Bore radius minus skirt radius at the thrust faces, mid skirt",
            25e-6,
            1e-6,
            1e-3,
        ),
        parameter(
            "barrel",
            "m",
            "Radial drop of the skirt profile at its upper and lower edge",
            30e-6,
            0.0,
            1e-3,
        ),
        parameter(
            "ovality",
            "m",
            "Skirt diameter across the thrust faces minus that along the pin",
            150e-6,
            0.0,
            2e-3,
        ),
        parameter(
            "skirt_growth_lower",
            "m",
            "Radial thermal growth of the skirt at its lower edge, linear to the upper one",
            0.0,
            -1e-3,
            1e-3,
        ),
        parameter(
            "skirt_growth_upper",
            "m",
            "Radial thermal growth of the skirt at its upper edge",
            0.0,
            -1e-3,
            1e-3,
        ),
        parameter(
            "bore_growth_lower",
            "m",
            "Radial thermal growth of the bore at its lower end, linear to the upper one",
            0.0,
            -1e-3,
            1e-3,
        ),
        parameter(
            "bore_growth_upper",
            "m",
            "Radial thermal growth of the bore at its upper end",
            0.0,
            -1e-3,
            1e-3,
        ),
        parameter("crank_radius", "m", "Half the stroke", 24.75e-3, 1e-3, 0.5),
        parameter("rod_length", "m", "Between the eyes", 0.1, 5e-3, 2.0),
        parameter("crank_offset", "m", "x of the crank axis from the bore axis", 0.0, -0.1, 0.1),
        parameter("rod_mass", "kg", "Connecting rod", 0.14, 0.0, 100.0),
        parameter("rod_inertia", "kg.m2", "Of the rod about its centre of mass", 2.2e-4, 0.0, 10.0),
        parameter(
            "rod_centre",
            "m",
            "Distance of the rod's centre of mass from the big end",
            0.03,
            0.0,
            2.0,
        ),
        parameter(
            "pin_mass",
            "kg",
            "Piston pin (and what else moves with A without turning)",
            0.03,
            0.0,
            20.0,
        ),
        parameter(
            "pin_friction_coefficient",
            "1",
            "Coulomb friction between pin and piston; 0: none",
            0.0,
            0.0,
            1.0,
        ),
        parameter("pin_radius", "m", "Arm of the friction at the pin", 7e-3, 1e-4, 0.1),
        parameter(
            "pin_friction_speed",
            "rad/s",
            "Relative angular velocity at which Coulomb friction has 76 % of its size",
            5.0,
            1e-3,
            1e3,
        ),
        parameter(
            "pin_friction_damping",
            "N.m.s/rad",
            "Viscous friction at the pin: moment by relative angular velocity",
            0.0,
            0.0,
            1e3,
        ),
        parameter(
            "crank_free",
            "1",
            "0: crank at given speed, 1: free, driven by gas and load torque",
            0,
            0,
            1,
        ),
        parameter("crank_inertia", "kg.m2", "Crank, flywheel and what they drive", 0.01, 1e-6, 1e4),
        parameter("load_torque", "N.m", "Torque that a free crank works against", 0.0, -1e5, 1e5),
        parameter(
            "pin_tilt",
            "rad",
            "Held rotation of pin and piston about +x: a pin that is not square to the bore's axis",
            0.0,
            -0.01,
            0.01,
        ),
        parameter("start_crank_angle", "rad", "Crank angle at the start", 0.0),
        parameter("start_lateral_displacement", "m", "Of A at the start", 0.0, -1e-3, 1e-3),
        parameter("start_rocking_angle", "rad", "At the start", 0.0, -0.05, 0.05),
        parameter(
            "damping_ratio",
            "1",
            "Modal damping ratio below the transition frequency",
            0.02,
            0.0,
            2.0,
        ),
        parameter(
            "high_frequency_damping_ratio", "1", "Modal damping ratio above it", 0.5, 0.0, 2.0
        ),
        parameter(
            "damping_transition_frequency", "Hz", "Where the strong damping begins", 20e3, 0.0, 1e9
        ),
        parameter(
            "quasi_static_frequency",
            "Hz",
            "Modes above it follow their load without inertia",
            1e9,
            0.0,
            1e9,
        ),
        parameter(
            "rayleigh_mass_factor", "1/s", "Further damping proportional to mass", 0.0, 0.0, 1e6
        ),
        parameter(
            "rayleigh_stiffness_factor",
            "s",
            "Further damping proportional to stiffness",
            0.0,
            0.0,
            1.0,
        ),
        parameter(
            "spectral_radius", "1", "Of the time integrator at infinite frequency", 0.6, 0.0, 1.0
        ),
    ]


def properties(options):
    """Properties of the built FMU, readable and never settable."""
    return [
        constant("n_circumferential", options["grid"][0], "Film grid cells around the skirt"),
        constant("n_axial", options["grid"][1], "Film grid cells along the skirt"),
        constant("piston_modes", options["piston"]["modes"], "Modes of the piston"),
        constant("block_modes", options["block"]["modes"], "Modes of the cylinder block"),
        constant("contract_version", 1, "Version of the interface contract"),
    ]
