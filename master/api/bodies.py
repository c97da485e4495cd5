"""Reduction of bodies."""

import logging
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from ..case.ahead import reject_asymmetry
from ..case.checked import check_case
from ..case.reading import find_case, read_tree
from ..fmi.errors import BadInput
from ..fmi.tree import import_part
from .cases import Case, Changes

log = logging.getLogger("piston_cosim")

OFFLINE = "fmu_mfbd.offline"
"""Module with `reduce(options, folder, output, progress)`, called by name because this package
does not import bodies."""
PACKAGE = OFFLINE.split(".")[0]


def reduce_bodies(
    source: Case | str | Path, output: str | Path, changes: Changes | None = None
) -> list[Any]:
    """Reduce the bodies of a case, or load them from the cache, and write their data.

    Parameters
    ----------
    source : Case, str or Path
        A case that builds bodies (its name, folder or file), or a TOML file with `grid` and the
        tables `[piston]`, `[block]` or both.
    output : path
        Folder for the reduced bodies (`NAME.npz`, which a case can use as `reduced`), their tables
        and pictures of modes.
    changes : mapping, optional
        Dotted key -> value, as for `Case.changed`.

    Returns
    -------
    list of fmu_mfbd.offline.BodyReport
        For each body: `name`, `mass` [kg], `centre` of mass [m], `inertia` about it [kg m2],
        `modes` (number, frequency [Hz], modal mass [kg], share in the film), `files`, `seconds`.

    Raises
    ------
    BadInput
        With every fault of the tables, then of meshes and matrices.

    Examples
    --------
    The first call reduces the bodies, further calls load them from the cache:

    >>> piston, block = pc.reduce_bodies("numerical_example", "bodies")    # doctest: +SKIP
    >>> f"{piston.mass:.4f} kg, {len(piston.modes)} modes"                 # doctest: +SKIP
    '0.1102 kg, 60 modes'
    """
    if isinstance(source, Case):
        case = source.changed(changes) if changes else source
        tree, folder = case.tree, case.path.parent
    else:
        path = find_case(str(source))
        tree, folder = read_tree(path, (changes or {}).items()), path.parent
    return reduced(tree, folder, Path(output), log.info)


def reduced(
    tree: dict[str, Any], folder: Path, output: Path, progress: Callable[[str], object]
) -> list[Any]:
    """Reduce the bodies of a tree whose paths are relative to `folder`."""
    if "participants" in tree:
        reject_asymmetry(check_case(tree, folder / "case.toml"), folder)
    offline: Any = import_part(OFFLINE)
    return offline.reduce(build_table(tree), folder, output, progress)


def build_tables(tree: dict[str, Any], names: Iterable[str]) -> dict[str, dict[str, Any]]:
    """Return the build tables of those participants that consist of bodies, by name."""
    tables = {name: tree["participants"][name] for name in names}
    return {
        name: table.get("build", {})
        for name, table in tables.items()
        if table.get("package") == PACKAGE
    }


def build_table(tree: dict[str, Any]) -> dict[str, Any]:
    """Return the table that describes the bodies: of the case's participant, or the file itself."""
    if "participants" not in tree:
        return tree
    for table in build_tables(tree, tree["participants"]).values():
        return table
    raise BadInput(
        f"participants: expected one with package = {PACKAGE!r}, got none; "
        "`piston-cosim list` lists the cases"
    )
