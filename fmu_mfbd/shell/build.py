"""Offline work of the shell's FMU: reduce it, or find it in the cache."""

from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from ...master.fmi.variables import Variable
from ..body_options import MOST_MODES, Count, Length
from ..dynamics.bearing_shell import LoadedShell
from ..options import BuildTable, RoundShell, read_options, shell_faults
from ..reducing import Say, reduced_shell
from ..reduction.reduced_body import ReducedShell, ShellFilm, ShellKind, load
from .slave import Shell

SHELL = ShellKind("shell")
DENSITY = 7850.0
"""Density for the scale of the modes [kg/m3]. It has no effect on the deflection."""


class BuildShell(RoundShell, BuildTable):
    """Build options of the FMU of a shell.

    The mesh origin is on its axis z at mid-length. Surfaces: bore, and held, which is fixed.
    """

    grid: tuple[Count, Count] = (72, 8)
    """Number of cells around and along the shell, equal to the grid of its film."""
    length: Annotated[Length, Field(gt=0)]
    """Length of the film along the shell."""
    modes: Annotated[int, Field(ge=1, le=MOST_MODES)] = 60
    """Number of modes."""

    def faults(self, folder: Path) -> list[str]:
        """Return the faults of modes and mesh; the path becomes absolute."""
        return shell_faults("", self.modes, self.grid) + super().faults(folder)


def options_schema() -> dict[str, Any]:
    """Return the JSON schema of the build table."""
    return BuildShell.model_json_schema()


def declared_variables(options: dict[str, Any] | None, folder: Path) -> list[Variable]:
    """Return the variables of the FMU of a build table, or of none, without a reduction.

    Raises
    ------
    BadInput
        Every fault of the table.
    """
    grid = (4, 4) if options is None else read_options(options, folder, BuildShell).grid
    return Shell.variables({"grid": grid})


def prepare(
    options: dict[str, Any], folder: Path, progress: Say
) -> tuple[dict[str, Any], list[Path]]:
    """Validate the build table and reduce the shell.

    Returns the content of build.json, and the reduced shell for the FMU's resources.

    Raises
    ------
    BadInput
        Every fault of the table; then every fault of the mesh.
    """
    build = read_options(options, folder, BuildShell)
    film = ShellFilm(build.grid, build.length, build.modes)
    path = reduced_shell(build, DENSITY, film, SHELL, progress)
    return {"file": path.name, "grid": list(build.grid)}, [path]


def elastic_shell(
    options: dict[str, Any], folder: Path | str = ".", progress: Say = print
) -> LoadedShell:
    """Return the shell of a build table, to use without an FMU.

    Parameters
    ----------
    options : dict
        As in the case file, with units as text.
    folder : Path
        Folder of the mesh file.
    progress : callable
        Prints a sentence.

    Raises
    ------
    BadInput
        Every fault of the table; then every fault of the mesh.
    """
    _, (path,) = prepare(options, Path(folder), progress)
    return LoadedShell(load(ReducedShell, path))
