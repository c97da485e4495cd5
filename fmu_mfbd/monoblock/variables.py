"""Variables of the block FMU."""

from typing import Annotated, NamedTuple

from ...master.fmi.variables import Variable, constant, input_variable, output_variable, parameter
from ..dynamics.build_options import FilmGrid
from ..dynamics.monoblock import BlockParameters, Cylinder, CylinderMotion
from ..variables import declared, declared_parameters

AXES = ("x", "y", "z")


class BlockScalars(NamedTuple):
    """Scalar outputs of the block: unit and nominal value."""

    kinetic_energy: Annotated[float, "J", 1e-3]
    """Kinetic energy of the block, including its modes."""
    elastic_energy: Annotated[float, "J", 1e-3]
    """Elastic energy of modes and mounts."""
    mount_power: Annotated[float, "W", 1.0]
    """Power dissipated by the mounts."""
    modal_power: Annotated[float, "W", 1.0]
    """Power dissipated by the modes."""
    largest_bore_deflection: Annotated[float, "m", 1e-5]
    """Largest deflection on the grids of all bores."""
    power_error: Annotated[float, "W", 1.0]
    """Power of all forces minus that stored and lost, mean over the step."""


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


def ports(cylinders: int, kind: type) -> tuple[str, ...]:
    """Return the full names of the variables of a named tuple for all cylinders."""
    return tuple(
        f"{cylinder.prefix}{name}" for cylinder in each(cylinders) for name in kind._fields
    )


def each(cylinders: int, grid: tuple[int, int] = (0, 0)) -> list[FilmGrid]:
    """Return the prefix of each cylinder's variables and the shape of its fields."""
    return [FilmGrid(f"cylinder_{k}.", grid) for k in range(1, cylinders + 1)]


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
    films = each(cylinders, grid)
    springs = [
        (f"mount_{k}_stiffness_{axis}", "N/m", f"Stiffness of mount {k} along {axis}")
        for k in range(1, mounts + 1)
        for axis in AXES
    ]
    return [
        *(one for film in films for one in declared(Cylinder, input_variable, *film)),
        *(parameter(*spring, 0.0, 0.0, 1e20) for spring in springs),
        *declared_parameters([BlockParameters]),
        *(one for film in films for one in declared(CylinderMotion, output_variable, *film)),
        *vectors(),
        *declared(BlockScalars),
        constant("cylinders", cylinders, "Number of cylinders"),
        constant("mounts", mounts, "Number of mounts"),
    ]
