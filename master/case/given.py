"""Build options that one participant gives another, by the contract: a film has no cells where the
mesh has no skirt.
"""

import json
import zipfile
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from ..fmi.errors import BadInput
from ..fmi.tree import import_part
from .contract import contract, interface


def build_options(case, folder, progress) -> dict[str, dict[str, Any]]:
    """Build options of each participant: its own, and what the contract lets it have of others
    where it says nothing itself.

    Parameters
    ----------
    case : schema.Case
    folder : Path
        Of the case.
    progress : callable
        Takes a sentence now and then.
    """
    roles = contract()
    builds = {name: dict(table.build) for name, table in case.participants.items()}
    for name, table in case.participants.items():
        if not table.package or table.role not in roles:
            continue
        for key, source in roles[table.role].build.items():
            role, _, option = source.partition(".")
            other = interface(case.wires, name, table.role)
            if key in table.build or other is None:
                continue
            giver = case.participants[other.owner]
            if giver.role != role:
                continue
            try:
                given = _built(giver, Path(folder), progress)
            except BadInput:
                continue  # told where the giver is built
            value = given.get(f"{other.surface}{option}")
            if value is not None:
                builds[name][key] = value
    return builds


def _built(giver, folder: Path, progress) -> dict[str, Any]:
    """Checked build options of a participant: of one that is built here, or of an FMU that was and
    holds them in resources/build.json; none of another.
    """
    if giver.package:
        return import_part(f"{giver.package}.build").prepare(giver.build, folder, progress)[0]
    if not giver.fmu:
        return {}
    with suppress(KeyError, ValueError, OSError, zipfile.BadZipFile):
        with zipfile.ZipFile(folder / giver.fmu) as archive:
            built = json.loads(archive.read("resources/build.json"))
            return built if isinstance(built, dict) else {}
    return {}


def masks(case, builds, folder) -> dict[str, list[list[int]]]:
    """Rows of the cells that fields have (1) and have not (0), of participants that are built with
    such a `mask` by the contract; a file of them is read.

    Parameters
    ----------
    case : schema.Case
    builds : dict of str to dict
        Checked build options of each participant.
    folder : Path
        Of the case.
    """
    roles = contract()
    found = {}
    for name, build in builds.items():
        role = case.participants[name].role
        mask = build.get("mask") if role in roles and "mask" in roles[role].build else None
        if isinstance(mask, str) and mask != "none":
            mask = np.loadtxt(Path(folder) / mask, delimiter=",", ndmin=2).astype(int).tolist()
        if isinstance(mask, list):
            found[name] = mask
    return found
