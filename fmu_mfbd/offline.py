"""Reduce bodies and put everything about them into a folder: `piston-cosim reduce`, and as a library."""

import csv
import shutil
from pathlib import Path

import numpy as np

from master.fmi.errors import BadInput

from .build import reduced_bodies
from .mode_pictures import draw_modes
from .report import CLASSES, mass_properties, mode_table, write_modes


ANATOMY = ("points", "tets", "skin", "shapes", "young", "poisson", "rigid_mass", "seconds", "peak_memory")
"""What a reduced body must hold besides what its FMU carries."""


def reduce(options, folder, output, progress=print):
    """Reduce the bodies of a build table, or find them in the cache, and write what they are made of.

    Into `output`, for each body: `NAME.npz`, which a case file may name as `reduced`; `NAME-modes.csv`, the table of modes;
    `NAME-modes.vtu`, all mode shapes; `NAME-modes.png`, the twelve with the largest share in film thickness.

    Parameters
    ----------
    options : dict
        As in a case's `[participants.X.build]`, units as text; piston or block may be left out.
    folder : Path
        Where its paths start.
    output : Path
    progress : callable
        Takes a sentence now and then.

    Returns
    -------
    list of dict
        One a body: name, files, nodes, elements, degrees_of_freedom, mass [kg], centre [m], inertia [kg m2], seconds,
        peak_memory [bytes, of the whole process], modes (rows of `report.mode_table`, `class` in words).

    Raises
    ------
    BadInput
        Every fault of the table, then of meshes and matrices.
    """
    return [_written(name, path, Path(output)) for name, path in reduced_bodies(options, folder, progress).items()]


def _written(name, path, output):
    """Files of one body, and what is to be said about it."""
    files = [output / f"{name}{ending}" for ending in (".npz", "-modes.csv", "-modes.vtu", "-modes.png")]
    with np.load(path) as stored:
        if lacking := [key for key in ANATOMY if key not in stored]:
            raise BadInput(f"{path.name} lacks {', '.join(lacking)}: an FMU can be built of it, pictures and recovery cannot")
        body = dict(stored)
    output.mkdir(parents=True, exist_ok=True)
    if path != files[0].resolve():
        shutil.copyfile(path, files[0])
    table = [row | {"class": CLASSES[row["kind"]]} for row in mode_table(body)]
    with open(files[1], "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["mode", "frequency [Hz]", "modal_mass [kg]", "film_share [-]", "class"])
        writer.writerows([row["mode"], row["frequency"], row["modal_mass"], row["film_share"], row["class"]] for row in table)
    if table:
        write_modes(body, files[2])
        draw_modes(body, table, files[3])
    mass, centre, inertia = mass_properties(body)
    return {"name": name, "files": [file for file in files if file.exists()], "nodes": len(body["points"]),
            "elements": len(body["tets"]), "degrees_of_freedom": 3 * len(body["points"]), "mass": mass, "centre": centre.tolist(),
            "inertia": inertia.tolist(), "seconds": float(body["seconds"]), "peak_memory": int(body["peak_memory"]),
            "modes": table}
