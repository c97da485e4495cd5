"""What a case file may say about the elastic shell of a bearing."""

from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, ValidationError

from ...master.fmi.errors import BadInput
from ...master.fmi.option_classes import sentences
from ..body_options import MOST_MODES, Count, Density, Length
from ..options import BearingShell, resolve, shell_faults


class BuildShell(BearingShell):
    """Build options of the FMU of a shell.

    The mesh origin is on its axis z at mid-length. Surfaces: bore, and held, which is fixed.
    """

    grid: tuple[Count, Count] = (72, 8)
    """Number of cells around and along the shell, equal to the grid of its film."""
    length: Annotated[Length, Field(gt=0)]
    """Length of the film along the shell."""
    density: Annotated[Density, Field(ge=500, le=25000)] = 7850.0
    """Density of the material. It has no effect on the deflection."""
    modes: Annotated[int, Field(ge=1, le=MOST_MODES)] = 60
    """Number of modes."""


def read_shell(options: dict[str, Any], folder: Path) -> BuildShell:
    """Validate a build table; its path becomes absolute.

    Raises
    ------
    BadInput
        With every fault: path, value, what is allowed.
    """
    try:
        build = BuildShell.model_validate(options)
    except ValidationError as error:
        raise BadInput(sentences(error, BuildShell)) from None
    faults = shell_faults("", build.modes, build.grid)
    if build.mesh:
        faults += resolve(build, "mesh", "mesh", folder)
    if faults:
        raise BadInput(faults)
    return build
