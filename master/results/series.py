"""Bodies and films of a run over time for ParaView: a .pvd file and a folder of VTU files.

Each VTU file contains one instant of one part.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .fields_export import ExportedField, write_collection
from .solids import Solid, Stand, about_z, moved


@dataclass(frozen=True)
class Film:
    """Fields on a surface that moves like a body.

    Parameters
    ----------
    name : str
    blocks : list of Block
    points : ndarray, shape (n, 3)
        Relative to the body's origin [m].
    cells : ndarray of int, shape (c, 4)
        In the order of a field's values.
    motion : ndarray, shape (instants, 3), or None
        across, along [m] and the rotation about z [rad] at the recorded instants. None: it is
        fixed.
    stand : Stand
        Position of its cylinder.
    """

    name: str
    blocks: list[ExportedField]
    points: np.ndarray
    cells: np.ndarray
    motion: np.ndarray | None = None
    stand: Stand = Stand()


def write_series(
    solids: list[Solid], films: list[Film], instants: np.ndarray, chosen: np.ndarray, path: Path
) -> Path:
    """Write the chosen instants.

    Points have their true position and scale, with every cylinder at its position. `displacement`
    is the deflection, for ParaView's "Warp By Vector".

    Parameters
    ----------
    solids : list of Solid
    films : list of Film
    instants : ndarray, shape (instants,)
        Recorded instants [s].
    chosen : ndarray of int
        Indices of the instants to write.
    path : Path
        With suffix .pvd.

    Returns
    -------
    Path
        The .pvd file.
    """
    import meshio

    folder = path.with_suffix("")
    folder.mkdir(parents=True, exist_ok=True)
    entries = []
    for k in chosen:
        parts: dict[str, Any] = {solid.title("_"): _body(solid, k) for solid in solids}
        parts |= {film.name: _film(film, k) for film in films}
        for number, (name, mesh) in enumerate(parts.items()):
            file = folder / f"{name}_{k:05d}.vtu"
            meshio.write(file, mesh)
            entries.append((float(instants[k]), number, file))
    return write_collection(entries, path)


def _body(solid, k):
    """Return a body's surface at instant `k`."""
    import meshio

    deflection = solid.modes @ solid.coordinates[k] if solid.modes.shape[2] else 0 * solid.points
    motion = None if solid.motion is None else solid.motion[k]
    if motion is not None:
        _, _, turn = motion
        deflection = deflection @ about_z(turn).T
    points = solid.stand.placed(moved(solid.points, motion))
    data = {"displacement [m]": solid.stand.turned(deflection)}
    if solid.stress is not None:
        data["von Mises stress [Pa]"] = solid.stress[k]
    return meshio.Mesh(points, [("triangle", solid.triangles)], point_data=data)


def _film(film, k):
    """Return the fields of a film at instant `k`."""
    import meshio

    points = moved(film.points, None if film.motion is None else film.motion[k])
    data = {f"{one.name} [{one.unit}]": [one.values[k].ravel()] for one in film.blocks}
    return meshio.Mesh(film.stand.placed(points), [("quad", film.cells)], cell_data=data)
