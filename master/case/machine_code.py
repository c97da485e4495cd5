"""Choice of the participants that run as native FMUs, which take a third of the time."""

from pathlib import Path
from typing import Any

from ..fmi.errors import BadInput, unknown
from .keys import declared_variables


def native_choice(
    case: Any, folder: Path, parameters: dict[str, dict[str, Any]]
) -> tuple[set[str], list[str]]:
    """Return the participants to build as machine code, and the faults of those that cannot be.

    Default: all participants with a prebuilt library that covers them.

    Parameters
    ----------
    case : schema.Case
    folder : Path
        Folder of the case.
    parameters : dict
        Known parameters of participants in SI, by name.
    """
    packages = {name: table.package for name, table in case.participants.items() if table.package}
    if case.native is None and not packages:
        return set(), []
    from ..fmi.builder_native import is_made_ahead  # slow to import, and other FMUs do not need it

    if case.native is None:
        chosen = {
            name
            for name, package in packages.items()
            if is_made_ahead(package)
            and not _uncovered(case.participants[name], folder, parameters.get(name, {}))
        }
        return chosen, []
    chosen = set(packages if case.native is True else case.native or ())
    faults = [
        f"native: {unknown('participant', name, packages)}"
        for name in sorted(chosen - packages.keys())
    ]
    for name in sorted(chosen & packages.keys()):
        uncovered = _uncovered(case.participants[name], folder, parameters.get(name, {}))
        faults += [f"participants.{name}{fault}" for fault in uncovered]
    return chosen, faults


def _uncovered(table, folder, parameters):
    """Return why a participant cannot be machine code, as ends of "participants.NAME"."""
    from ..fmi.builder_native import cannot_build, part_of
    from ..fmi.compiler import this_platform

    platform = this_platform()
    if platform is None:
        return [", native: expected x86-64 or AArch64, got another machine; set native = false"]
    try:
        part = part_of(table.package)
    except BadInput as refusal:
        return [f", {fault}" for fault in refusal.faults]
    faults = [f", {fault}" for fault in cannot_build((platform,), (table.package,))]
    faults += [f".build.{fault}" for fault in part.uncovered(table.build)]
    if not faults and (variables := declared_variables(table, folder)):
        values = {v.name: v.number(v.start) for v in variables} | dict(parameters)
        faults += [f".parameters.{fault}" for fault in part.uncovered_values(values)]
    return faults
