"""Bodies and films of a run over time for ParaView: one .pvd file to open, and a VTU file for each
instant and part in a folder beside it.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from .fields_export import Block, cylinder_cells, write_collection
from .solids import Solid


@dataclass(frozen=True)
class Film:
    """Fields on the cylinder of a radius [m], between two heights of the piston [m]; without them
    as long as the skirt, or 1 m.
    """

    name: str
    radius: float
    blocks: list[Block]
    heights: tuple[float, float] | None = None


def write_series(
    solids: list[Solid], films: list[Film], instants: np.ndarray, chosen: np.ndarray, path: Path
) -> Path:
    """Write the chosen instants.

    Points are where they are, at their true scale; `displacement` is the deflection, for ParaView's
    "Warp By Vector". A film lies between the edges of the skirt, upright and as high as the piston.

    Parameters
    ----------
    solids : list of Solid
    films : list of Film
    instants : ndarray, shape (instants,)
        Recorded ones [s].
    chosen : ndarray of int
        Those written.
    path : Path
        Ends with .pvd.

    Returns
    -------
    Path
        The .pvd file.
    """
    import meshio

    folder = path.with_suffix("")
    folder.mkdir(parents=True, exist_ok=True)
    skirt = next((solid for solid in solids if solid.film), None)
    entries = []
    for k in chosen:
        parts: dict[str, Any] = {solid.name: _body(solid, k) for solid in solids}
        for film in films:
            ends = film.heights or (skirt and skirt.film) or (0.0, 1.0)
            height = 0.0 if skirt is None or skirt.motion is None else skirt.motion[k, 1]
            parts[film.name] = _film(film, (ends[0] + height, ends[1] + height), k)
        for number, (name, mesh) in enumerate(parts.items()):
            file = folder / f"{name}_{k:05d}.vtu"
            meshio.write(file, mesh)
            entries.append((float(instants[k]), number, file))
    return write_collection(entries, path)


def _body(solid, k):
    """A body's surface at instant `k`."""
    import meshio

    deflection = solid.modes @ solid.coordinates[k] if solid.modes.shape[2] else 0 * solid.points
    points = solid.points
    data = {"displacement [m]": deflection}
    if solid.motion is not None:
        across, along, turn = solid.motion[k]
        c, s = np.cos(turn), np.sin(turn)
        turned = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        points = points @ turned.T + [across, along, 0]
        data = {"displacement [m]": deflection @ turned.T}
    if solid.stress is not None:
        data["von Mises stress [Pa]"] = solid.stress[k]
    return meshio.Mesh(points, [("triangle", solid.triangles)], point_data=data)


def _film(film, ends, k):
    """The fields of a film at instant `k`, between two heights [m]."""
    import meshio

    points, cells = cylinder_cells(film.blocks[0].values.shape[1:], film.radius, ends)
    data = {f"{one.name} [{one.unit}]": [one.values[k].ravel()] for one in film.blocks}
    return meshio.Mesh(points, [("quad", cells)], cell_data=data)
