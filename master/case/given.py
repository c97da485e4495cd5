"""Build options that one participant gives another, by the contract.

Example: a film has no cells at positions where the mesh has no skirt.
"""

import json
import zipfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from ..fmi.errors import BadInput
from ..fmi.separated import read_rows
from ..fmi.tree import import_part
from .contract import contract, given_by_others


def build_options(
    case: Any, folder: Path, progress: Callable[[str], object]
) -> dict[str, dict[str, Any]]:
    """Return the build options of each participant.

    They are its own, and those that the contract takes from others if it has none itself.

    Parameters
    ----------
    case : schema.Case
    folder : Path
        Folder of the case.
    progress : callable
        Called with messages.
    """
    builds = {name: dict(table.build) for name, table in case.participants.items()}
    for name, key, (owner, surface), option in given_by_others(case, "build"):
        table = case.participants[name]
        if not table.package or key in table.build:
            continue
        with suppress(BadInput):  # reported when the giver is built
            options = _built(case.participants[owner], Path(folder), progress)
            if (value := options.get(f"{surface}{option}")) is not None:
                builds[name][key] = value
    return builds


def _built(giver, folder: Path, progress) -> dict[str, Any]:
    """Return the checked build options of a participant, empty if they are not known.

    For an FMU they are read from resources/build.json.
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
    """Return the masks of participants that the contract builds with one: rows of 1 and 0.

    A cell of a field exists if its entry is 1. If the option names a file, the file is read.

    Parameters
    ----------
    case : schema.Case
    builds : dict of str to dict
        Checked build options of each participant.
    folder : Path
        Folder of the case.
    """
    roles = contract()
    by_film = {}
    for name, build in builds.items():
        role = case.participants[name].role
        mask = build.get("mask") if role in roles and "mask" in roles[role].build else None
        if isinstance(mask, str) and mask != "none":
            cells = [row for _, row in read_rows(Path(folder) / mask)]
            mask = np.array(cells, dtype=float, ndmin=2).astype(int).tolist()
        if isinstance(mask, list):
            by_film[name] = mask
    return by_film
