"""Variables of the block FMU."""

from typing import Any

from ...master.fmi.variables import Variable, constant, input_variable, output_variable, parameter

AXES = ("x", "y", "z")
FORCES = {
    "force_x": ("N", "Force of bore, deck and main bearings on the block along x", 0.0, 1e3),
    "force_y": ("N", "Force of bore, deck and main bearings on the block along y", 0.0, 1e3),
    "moment": ("N.m", "Moment of bore and deck on the block about the crank axis", 0.0, 1e2),
    "bearing_force_x": ("N", "Force of the crank on its main bearings along x", 0.0, 1e3),
    "bearing_force_y": ("N", "Force of the crank on its main bearings along y", 0.0, 1e3),
    "force_on_deck": ("N", "Force of the gas on the deck along y", 0.0, 1e3),
}
"""Unit, description, start and nominal of the forces that a cylinder provides."""
MOTIONS = {
    "acceleration_x": ("m/s2", "Acceleration of the block at the cylinder along x", 1.0),
    "acceleration_y": ("m/s2", "Acceleration of the block at the cylinder along y", 1.0),
    "angular_acceleration": ("rad/s2", "Angular acceleration of the block about z", 10.0),
    "angular_velocity": ("rad/s", "Angular velocity of the block about z", 0.1),
}
"""Unit, description and nominal of the motion that a cylinder receives."""
ON_BORE, DEFLECTION = "force_on_bore", "bore_deflection"
ON_GRID = "on its grid of angles and heights"
SETTINGS = (
    (
        "damping_time",
        "s",
        "Damping time of the mounts: damping divided by stiffness",
        0.0,
        0.0,
        1.0,
    ),
    ("damping_ratio", "1", "Modal damping ratio of all modes", 0.02, 0.0, 2.0),
    (
        "quasi_static_frequency",
        "Hz",
        "Frequency above which modes follow their load without inertia",
        1e9,
        0.0,
        1e9,
    ),
    (
        "spectral_radius",
        "1",
        "Spectral radius of the modes' time integrator at infinite frequency",
        0.6,
        0.0,
        1.0,
    ),
)
"""Parameters, as `parameter` takes them."""
SCALARS = (
    ("kinetic_energy", "J", "Kinetic energy of the block, including its modes", 1e-3),
    ("elastic_energy", "J", "Elastic energy of modes and mounts", 1e-3),
    ("mount_power", "W", "Power dissipated by the mounts", 1.0),
    ("modal_power", "W", "Power dissipated by the modes", 1.0),
    ("largest_bore_deflection", "m", "Largest deflection on the grids of all bores", 1e-5),
    (
        "power_error",
        "W",
        "Power of all forces minus that stored and lost, mean over the step",
        1.0,
    ),
)
"""Outputs, as `output_variable` takes them."""
WHOLE = (
    ("displacement", "m", "rotation", "rad", "of the block at O", 1e-5),
    ("velocity", "m/s", "rotation_velocity", "rad/s", "of the block at O", 1e-3),
    ("shaking_force", "N", "shaking_moment", "N.m", "of all cylinders about O", 1e3),
    ("mount_force", "N", "mount_moment", "N.m", "of the block on its mounts about O", 1e2),
)
"""Vectors of the whole block, each with its rotational counterpart."""


def words(name: str) -> str:
    """Return a variable's name as words."""
    return name.replace("_", " ").capitalize()


def ports(cylinders: int, names: Any) -> tuple[str, ...]:
    """Return the full names of these variables for all cylinders."""
    return tuple(f"cylinder_{k}.{name}" for k in range(1, cylinders + 1) for name in names)


def of_cylinders(make: Any, cylinders: int, rows: Any) -> list[Variable]:
    """Return the variables of these rows, name -> arguments of `make`, for all cylinders."""
    return [
        make(f"cylinder_{k + 1}.{n}", *row) for k in range(cylinders) for n, row in rows.items()
    ]


def vectors() -> list[Variable]:
    """Return the components of the vectors of the whole block."""
    return [
        output_variable(f"{name}_{axis}", unit, f"{words(name)} {what}, {axis} component", nominal)
        for first, unit_1, second, unit_2, what, nominal in WHOLE
        for name, unit in ((first, unit_1), (second, unit_2))
        for axis in AXES
    ]


def variables(cylinders: int, mounts: int, grid: tuple[int, int]) -> list[Variable]:
    """Return the variables of a block, with a grid of angles and heights on each bore."""
    force = ("N", f"Outward force of film and gas on the bore, {ON_GRID}", 0.0, 10.0, grid)
    deflection = ("m", f"Outward deflection of the bore, {ON_GRID}", 1e-5, grid)
    springs = [
        (f"mount_{k}_stiffness_{axis}", "N/m", f"Stiffness of mount {k} along {axis}")
        for k in range(1, mounts + 1)
        for axis in AXES
    ]
    return [
        *of_cylinders(input_variable, cylinders, FORCES | {ON_BORE: force}),
        *(parameter(*spring, 0.0, 0.0, 1e20) for spring in springs),
        *(parameter(*row) for row in SETTINGS),
        *of_cylinders(output_variable, cylinders, MOTIONS | {DEFLECTION: deflection}),
        *vectors(),
        *(output_variable(*row) for row in SCALARS),
        constant("cylinders", cylinders, "Number of cylinders"),
        constant("mounts", mounts, "Number of mounts"),
    ]
