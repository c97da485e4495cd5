"""Reduce bodies and put everything about them into a folder; recover displacement and stress on
their meshes: the commands `reduce` and `recover`, and as a library.
"""

import csv
import shutil
from pathlib import Path

import numpy as np

from ..master.fmi.errors import BadInput
from .build import reduced_bodies
from .finite_elements.element import von_mises
from .reduction.mode_pictures import draw_modes
from .reduction.mode_tables import CLASSES, mass_properties, mode_table, write_modes
from .reduction.mode_tables import recover as recovered

ANATOMY = (
    "points",
    "tets",
    "skin",
    "shapes",
    "young",
    "poisson",
    "rigid_mass",
    "seconds",
    "peak_memory",
)
"""What a reduced body must hold besides what its FMU carries."""


def reduce(options, folder, output, progress=print):
    """Reduce the bodies of a build table, or find them in the cache, and write what they are made
    of.

    Into `output`, for each body: `NAME.npz`, which a case file may name as `reduced`;
    `NAME-modes.csv`, the table of modes; `NAME-modes.vtu`, all mode shapes; `NAME-modes.png`, the
    twelve with the largest share in film thickness.

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
        One a body: name, files, nodes, elements, degrees_of_freedom, mass [kg], centre [m], inertia
        [kg m2], seconds, peak_memory [bytes, of the whole process], modes (rows of
        `report.mode_table`, `class` in words).

    Raises
    ------
    BadInput
        Every fault of the table, then of meshes and matrices.
    """
    return [
        _written(name, path, Path(output))
        for name, path in reduced_bodies(options, folder, progress).items()
    ]


def recover(options, folder, modal_coordinate, path, progress=print):
    """Displacement and stress of the bodies of a build table at an instant, as VTU files on their
    meshes.

    Parameters
    ----------
    options, folder, progress
        As for `reduce`.
    modal_coordinate : ndarray, shape (k,)
        Of piston, then block [kg^1/2 m], as the FMU's output of that name.
    path : Path
        The files' names begin with it.

    Returns
    -------
    list of dict
        One a body: name, file, largest_displacement [m], largest_stress (von Mises) [Pa], None for
        a body of matrices.

    Raises
    ------
    BadInput
        As `reduce`, and if the bodies have other numbers of modes.
    """
    files, out, first = reduced_bodies(options, folder, progress), [], 0
    bodies = {name: _whole(file) for name, file in files.items()}
    modes = [len(body["omega"]) for body in bodies.values()]
    if sum(modes) != len(modal_coordinate):
        raise BadInput(
            f"{len(modal_coordinate)} modal coordinates; the bodies have {' + '.join(map(str, modes))} modes"
        )
    path.parent.mkdir(parents=True, exist_ok=True)
    for (name, body), count in zip(bodies.items(), modes):
        file = path.with_name(f"{path.name}-{name}.vtu")
        displacement, stress = recovered(body, modal_coordinate[first : first + count], file)
        first += count
        out.append(
            {
                "name": name,
                "file": file,
                "largest_displacement": float(np.linalg.norm(displacement, axis=1).max()),
                "largest_stress": None if stress is None else float(von_mises(stress).max()),
            }
        )
    return out


def _written(name, path, output):
    """Files of one body, and what is to be said about it."""
    files = [
        output / f"{name}{ending}" for ending in (".npz", "-modes.csv", "-modes.vtu", "-modes.png")
    ]
    body = _whole(path)
    output.mkdir(parents=True, exist_ok=True)
    if path != files[0].resolve():
        shutil.copyfile(path, files[0])
    table = [row | {"class": CLASSES[row["kind"]]} for row in mode_table(body)]
    with open(files[1], "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["mode", "frequency [Hz]", "modal_mass [kg]", "film_share [-]", "class"])
        writer.writerows(
            [row["mode"], row["frequency"], row["modal_mass"], row["film_share"], row["class"]]
            for row in table
        )
    if table:
        write_modes(body, files[2])
        draw_modes(body, table, files[3])
    mass, centre, inertia = mass_properties(body)
    return {
        "name": name,
        "files": [file for file in files if file.exists()],
        "nodes": len(body["points"]),
        "elements": len(body["tets"]),
        "degrees_of_freedom": 3 * len(body["points"]),
        "mass": mass,
        "centre": centre.tolist(),
        "inertia": inertia.tolist(),
        "seconds": float(body["seconds"]),
        "peak_memory": int(body["peak_memory"]),
        "modes": table,
    }


def _whole(path):
    """A reduced body with its mesh and mode shapes."""
    with np.load(path) as stored:
        if lacking := [key for key in ANATOMY if key not in stored]:
            raise BadInput(
                f"{path.name} lacks {', '.join(lacking)}: an FMU can be built of it, pictures and recovery cannot"
            )
        return dict(stored)
