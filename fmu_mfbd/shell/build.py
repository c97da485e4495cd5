"""Offline work of the shell's FMU: reduce it, or find it in the cache."""

from pathlib import Path
from typing import Any

from ...master.fmi.variables import Variable
from ..dynamics.bearing_shell import YieldingShell
from ..options import read_options
from ..reducing import Say, reduced_shell
from ..reduction.reduced_body import ReducedShell, ShellFilm, ShellKind, load
from .options import BuildShell
from .variables import variables

SHELL = ShellKind("shell")
DENSITY = 7850.0
"""Density for the scale of the modes [kg/m3]. It has no effect on the deflection."""


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
    has_options = options is not None
    return variables(read_options(options, folder, BuildShell).grid if has_options else (4, 4))


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
) -> YieldingShell:
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
    return YieldingShell(load(ReducedShell, path))
