"""Offline work of the FMU builder: reduce both bodies (or find them in the cache) and hand over what the FMU carries."""

from math import pi
from pathlib import Path

import numpy as np

from master.fmi.builder import cache_folder
from master.fmi.errors import BadInput

from .mesh import MeshFault
from .options import read_options
from .reduction import cached, reduce_block, reduce_piston, shapes_file
from .tables import TableFault, gas_table, profile_table


def prepare(options, folder, progress):
    """Validate the build table and reduce both bodies.

    Parameters
    ----------
    options : dict
        The case file's `[participants.X.build]` table.
    folder : Path
        Folder of the case.
    progress : callable
        Takes a sentence now and then.

    Returns
    -------
    options : dict
        In SI, with `files` naming the reduced bodies; becomes build.json.
    files : list of Path
        To be copied into the FMU's resources.

    Raises
    ------
    BadInput
        Every fault of the table; then every fault of the meshes.
    """
    resolved = read_options(options, folder)
    shapes, gas = _tables(resolved)
    faults, files = [], {}
    for name, reduce in (("piston", reduce_piston), ("block", reduce_block)):
        try:
            files[name] = cached(reduce, {k: v for k, v in resolved[name].items() if k not in ("profiles", "orders")},
                                 resolved["grid"], cache_folder("bodies"), lambda text, of=name: progress(f"{of}: {text}"))
        except MeshFault as error:
            faults += error.faults
        except ValueError as error:
            faults.append(f"{name}: {error}")
    if faults:
        raise BadInput(faults)
    for part in ("piston", "block"):
        resolved[part]["mesh"] = Path(resolved[part]["mesh"]).name      # where it lay is no property of the FMU
        resolved[part]["profiles"] = shapes[part]
        resolved[part]["modes"] -= len(set(resolved[part]["modes_off"]))
    resolved["gas"] = gas
    return resolved | {"files": {name: path.name for name, path in files.items()}}, list(files.values())


def _tables(resolved):
    """Measured shapes of both bodies and the gas table, read before any long computation."""
    faults, shapes, gas = [], {"piston": [], "block": []}, None
    for part, found in shapes.items():
        for table in resolved[part]["profiles"]:
            try:
                found.append(profile_table(table["file"], table["angle_unit"], table["height_unit"], table["value_unit"]))
            except TableFault as error:
                faults.append(str(error))
    if resolved["gas"]:
        try:
            gas = gas_table(resolved["gas"]["file"], pi * resolved["gas"]["strokes"], resolved["gas"]["angle_unit"],
                            resolved["gas"]["pressure_unit"])
        except TableFault as error:
            faults.append(str(error))
    if faults:
        raise BadInput(faults)
    return shapes, gas


def reduced_bodies(options, folder, progress):
    """Both reduced bodies of a build table, for reports: {name: (reduced body, mesh and shapes)}, mappings of ndarray."""
    files = dict(zip(("piston", "block"), prepare(options, folder, progress)[1]))
    return {name: (np.load(path), np.load(shapes_file(path))) for name, path in files.items()}
