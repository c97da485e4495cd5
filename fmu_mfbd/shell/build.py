"""Offline work of the shell's FMU: reduce it, or find it in the cache."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from ...master.fmi.cache import cache_folder
from ...master.fmi.errors import BadInput
from ...master.fmi.phases import phase
from ...master.fmi.variables import Variable
from ..dynamics.bearing_shell import YieldingShell
from ..finite_elements.mesh import MeshFault
from ..reduction.reduced_body import ReducedShell, ShellFilm, ShellKind, load
from ..reduction.store import kept_shell
from .options import BuildShell, read_shell
from .variables import variables

Say = Callable[[str], None]
SHELL = ShellKind("shell")


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
    return variables(read_shell(options, Path(folder)).grid if options is not None else (4, 4))


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
    build = read_shell(options, Path(folder))
    film = ShellFilm(build.grid, build.length, build.modes)
    try:
        with phase("reducing shell"):
            path = kept_shell(build, film, SHELL, cache_folder("bodies"), progress)
    except MeshFault as error:
        raise BadInput(error.faults) from None
    except (ValueError, MemoryError) as error:
        raise BadInput(str(error)) from None
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
