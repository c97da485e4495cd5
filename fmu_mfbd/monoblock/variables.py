"""Every variable of the block's FMU, declared once."""

from typing import Any

from ...master.fmi.variables import Variable, constant, input_variable, output_variable, parameter

AXES = ("x", "y", "z")
FORCES = {
    "force_x": ("N", "Of bore, deck and main bearings along x", 1e3),
    "force_y": ("N", "Of bore, deck and main bearings along y", 1e3),
    "moment": ("N.m", "Of bore and deck about the crank axis", 1e2),
    "bearing_force_x": ("N", "Of the crank on its main bearings along x", 1e3),
    "bearing_force_y": ("N", "Of the crank on its main bearings along y", 1e3),
    "force_on_deck": ("N", "Of gas on the deck along y", 1e3),
}
"""Unit, description and nominal of the numbers that a cylinder says."""
MOTIONS = {
    "acceleration_x": ("m/s2", "Of the block at the cylinder, along x", 1.0),
    "acceleration_y": ("m/s2", "Of the block at the cylinder, along y", 1.0),
    "angular_acceleration": ("rad/s2", "Of the block about z", 10.0),
    "angular_velocity": ("rad/s", "Of the block about z", 0.1),
}
"""Likewise of those that it is told."""
ON_BORE, DEFLECTION = "force_on_bore", "bore_deflection"
WHOLE = (
    ("displacement", "m", "rotation", "rad", "Of the block, at O", 1e-5),
    ("velocity", "m/s", "rotation_velocity", "rad/s", "Of the block, at O", 1e-3),
    ("shaking_force", "N", "shaking_moment", "N.m", "Of all cylinders, about O", 1e3),
    ("mount_force", "N", "mount_moment", "N.m", "Of the block on its mounts, about O", 1e2),
)
"""Vectors of the whole block, each with its rotational one."""


def ports(cylinders: int, names: Any) -> tuple[str, ...]:
    """Variables of all cylinders by these names."""
    return tuple(f"cylinder_{k}.{name}" for k in range(1, cylinders + 1) for name in names)


def variables(cylinders: int, mounts: int, grid: tuple[int, int]) -> list[Variable]:
    """The table of a block of so many cylinders and mounts, bores of so many angles and heights."""
    acting, told = [], []
    for k in range(1, cylinders + 1):
        prefix = f"cylinder_{k}."
        acting += [
            input_variable(prefix + name, unit, what, 0.0, nominal)
            for name, (unit, what, nominal) in FORCES.items()
        ]
        what = "Of film and gas on the bore, outwards, at its own angles and heights"
        acting.append(input_variable(prefix + ON_BORE, "N", what, 0.0, 10.0, grid))
        told += [
            output_variable(prefix + name, unit, what, nominal)
            for name, (unit, what, nominal) in MOTIONS.items()
        ]
        what = "Of the bore, outwards, at its own angles and heights"
        told.append(output_variable(prefix + DEFLECTION, "m", what, 1e-5, grid))
    of_mounts = [
        parameter(
            f"mount_{k}_stiffness_{axis}", "N/m", f"Of mount {k} along {axis}", 0.0, 0.0, 1e20
        )
        for k in range(1, mounts + 1)
        for axis in AXES
    ]
    vectors = [
        output_variable(f"{name}_{axis}", unit, what, nominal)
        for first, unit_1, second, unit_2, what, nominal in WHOLE
        for name, unit in ((first, unit_1), (second, unit_2))
        for axis in AXES
    ]
    return [
        *acting,
        *of_mounts,
        parameter("damping_time", "s", "tau: damping of the mounts by stiffness", 0.0, 0.0, 1.0),
        parameter("damping_ratio", "1", "Of all modes", 0.02, 0.0, 2.0),
        parameter(
            "quasi_static_frequency",
            "Hz",
            "Modes above it follow their load without inertia",
            1e9,
            0.0,
            1e9,
        ),
        parameter(
            "spectral_radius", "1", "Of the modes' time integrator at infinite frequency", 0.6, 0, 1
        ),
        *told,
        *vectors,
        output_variable("kinetic_energy", "J", "Of the block, modes included", 1e-3),
        output_variable("elastic_energy", "J", "Of modes and mounts", 1e-3),
        output_variable("mount_power", "W", "What the mounts turn into heat", 1.0),
        output_variable("modal_power", "W", "What the modes turn into heat", 1.0),
        output_variable("largest_bore_deflection", "m", "On the grids of all bores", 1e-5),
        output_variable(
            "energy_error", "J", "Work of all forces over the step minus what became of it", 1e-3
        ),
        constant("cylinders", cylinders, "Cylinders"),
        constant("mounts", mounts, "Mounts"),
    ]
