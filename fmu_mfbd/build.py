"""Offline work of the FMU builder: reduce both bodies (or find them in the cache) and hand over
what the FMU carries.
"""

import hashlib
import zipfile
from math import pi
from pathlib import Path

import numpy as np

from ..master.fmi.cache import cache_folder
from ..master.fmi.errors import BadInput
from .dynamics.speed_table import speed_table
from .dynamics.start_state import check_modes, read_start
from .dynamics.tables import TableFault, gas_table, inline_numbers, profile_table, read_numbers
from .finite_elements.mesh import MeshFault
from .options import SOURCES, Bodies, read_options
from .reduction.reduce import cached, reduce_block, reduce_piston, save


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
    shapes, tables = _tables(resolved)
    files = {name: _carried(name, path) for name, path in _reduced(resolved, progress).items()}
    for part in ("piston", "block"):
        for source in SOURCES:  # where it lay is no property of the FMU
            resolved[part][source] = resolved[part][source] and Path(resolved[part][source]).name
        resolved[part]["profiles"] = shapes[part]
        with np.load(files[part]) as body:
            resolved[part]["modes"] = len(body["omega"])
    if tables["start"]:
        try:
            check_modes(
                tables["start"], sum(resolved[part]["modes"] for part in ("piston", "block"))
            )
        except ValueError as error:
            raise BadInput([str(error)]) from None
    return resolved | tables | {"files": {name: path.name for name, path in files.items()}}, list(
        files.values()
    )


def reduced_bodies(options, folder, progress):
    """The reduced bodies of a build table, or of one that has a single body.

    Parameters
    ----------
    options, folder, progress
        As for `prepare`.

    Returns
    -------
    dict of str to Path
        An .npz for each of piston and block: what `reduction` gives, mesh and mode shapes included.

    Raises
    ------
    BadInput
    """
    return _reduced(read_options(options, folder, Bodies), progress)


def _reduced(resolved, progress):
    """Paths of the bodies' .npz, by name; every fault of all of them in one message."""
    faults, files = [], {}
    for name, reduce in (("piston", reduce_piston), ("block", reduce_block)):
        try:
            if resolved[name] is not None:
                files[name] = _body(name, reduce, resolved, progress)
        except MeshFault as error:
            faults += error.faults
        except (ValueError, MemoryError) as error:
            faults.append(f"{name}: {error}")
    if faults:
        raise BadInput(faults)
    return files


NEEDED = {
    "piston": (
        "mass",
        "S",
        "I0",
        "T",
        "b",
        "B",
        "g",
        "G",
        "omega",
        "kind",
        "gas_force",
        "radial",
        "axial",
        "radius",
        "skirt_lower",
        "skirt_upper",
    ),
    "block": ("omega", "kind", "radial", "axial", "heights", "radius"),
}


def _body(name, reduce, resolved, progress):
    """Path of a reduced body: made from its mesh, found in the cache, or the user's own,
    checked.
    """
    part, grid = resolved[name], tuple(resolved["grid"])
    if part["reduced"] is None:
        options = {
            key: value
            for key, value in part.items()
            if key not in ("profiles", "orders", "reduced")
        }
        return cached(
            reduce, options, grid, cache_folder("bodies"), lambda text: progress(f"{name}: {text}")
        )
    path = Path(part["reduced"])
    if not zipfile.is_zipfile(path):
        raise ValueError(f"{path.name} is no .npz file")
    with np.load(path) as body:
        missing = [key for key in NEEDED[name] if key not in body]
        if missing:
            raise ValueError(f"{path.name} lacks {', '.join(missing)}")
        rows = grid[0] * grid[1] if name == "piston" else grid[0]
        if len(body["radial"]) != rows:
            raise ValueError(
                f"{path.name} was reduced for another film grid "
                f"({len(body['radial'])} rows of modes, {rows} needed)"
            )
        if not np.all(np.diff(body["omega"]) >= 0) or np.any(body["omega"] <= 0):
            raise ValueError(f"{path.name}: frequencies must be positive and rise")
    return path


def _carried(name, path):
    """What of a reduced body goes into the FMU: all but its mesh and mode shapes, in a file named
    by its content.
    """
    with np.load(path) as body:
        arrays = {key: body[key] for key in NEEDED[name]}
    digest = hashlib.sha256()
    for array in arrays.values():
        digest.update(str(array.shape).encode() + array.tobytes())
    carried = cache_folder("carried") / f"{name}-{digest.hexdigest()[:24]}.npz"
    if not carried.exists():
        save(carried, arrays)
    return carried


def _tables(resolved):
    """Measured shapes of both bodies; tables of gas and speed and the start, by name: read before
    any long computation.
    """
    faults, shapes, tables = [], {"piston": [], "block": []}, {}
    for part, found in shapes.items():
        for table in resolved[part]["profiles"]:
            try:
                found.append(
                    profile_table(
                        table["file"],
                        table["angle_unit"],
                        table["height_unit"],
                        table["value_unit"],
                    )
                )
            except TableFault as error:
                faults.append(str(error))
    for name, read in (("gas", _gas), ("speed", _speed), ("start", read_start)):
        try:
            tables[name] = resolved[name] and read(resolved[name])
        except ValueError as error:
            faults.append(str(error))
    if faults:
        raise BadInput(faults)
    return shapes, tables


def _rows(name, part):
    """Numbers of a table in a file or in the case."""
    return (
        read_numbers(part["file"])
        if part["file"]
        else inline_numbers(f"{name}.points", part["points"])
    )


def _gas(part):
    return gas_table(
        _rows("gas", part), pi * part["strokes"], part["angle_unit"], part["pressure_unit"]
    )


def _speed(part):
    over = "time" if part["time_unit"] else "angle"
    return speed_table(
        _rows("speed", part), over, pi * part["strokes"], part[f"{over}_unit"], part["speed_unit"]
    )
