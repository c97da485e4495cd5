"""Body without elements: nodes, their sets, and the surfaces between them."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from ...master.fmi.separated import read_rows
from .mesh import Mesh, MeshFault, to_body_axes
from .regions import Region

AROUND_Y, AROUND_Z, FROM_ABOVE = "around y", "around z", "from above"
VIEWS = {
    "skirt": AROUND_Y,
    "bore": AROUND_Y,
    "pin_bore": AROUND_Z,
    "crown": FROM_ABOVE,
    "bolts": FROM_ABOVE,
}
"""Direction from which each surface is projected or unrolled for its triangulation."""


def read_nodes(
    path: Path | str,
    surfaces: Mapping[str, Region | None],
    scale: float = 1.0,
    axes: Sequence[str] = ("x", "y", "z"),
    origin: Sequence[float] = (0.0, 0.0, 0.0),
) -> Mesh:
    """Read nodes of a CSV file, and triangulate their surfaces with three-node triangles.

    The header is `node,x,y,z` or `node,x,y,z,sets`. `sets` contains names of surfaces, separated by
    blanks. Other surfaces need a region.

    Parameters
    ----------
    path, surfaces, scale, axes, origin
        As for `mesh.read_mesh`.

    Returns
    -------
    Mesh
        Without tetrahedra, with the nodes' numbers in the file.

    Raises
    ------
    MeshFault
        If a row is invalid, or surfaces are missing.
    """
    path = Path(path)
    labels, rows, sets = _table(path)
    points = to_body_axes(rows * scale, axes, origin)
    faults = []
    faces = {}
    members = {}
    for name, region in surfaces.items():
        if region:
            mask = region.holds(points[:, None, :])
        else:
            mask = np.array([name in names for names in sets])
        members[name] = np.flatnonzero(mask)
        if len(members[name]) < 3:
            known = ", ".join(sorted(set().union(*sets))) or "none"
            faults.append(
                f"{path}: surface '{name}': expected at least 3 nodes, got {len(members[name])}; "
                f"the file has {known}"
            )
        else:
            faces[name] = members[name][triangulate(points[mask], VIEWS[name])]
    if faults:
        raise MeshFault(faults)
    return Mesh(points, np.empty((0, 10), dtype=np.int64), faces, members, labels)


def _table(path):
    """Return the numbers of the nodes, their coordinates, (n, 3), and the names of their sets."""
    (_, head), *rows = read_rows(path) or [(0, [])]
    header = [name.strip().lower() for name in head]
    if header not in (["node", "x", "y", "z"], ["node", "x", "y", "z", "sets"]):
        raise MeshFault(
            f"{path}: expected a first row node,x,y,z or node,x,y,z,sets, got {','.join(header)!r}"
        )
    labels = []
    points = []
    sets = []
    for number, row in rows:
        try:
            label, x, y, z, *names = row
            labels.append(int(label))
            points.append([float(x), float(y), float(z)])
        except ValueError:
            what = f"expected a node number and three coordinates, got {','.join(row)!r}"
            raise MeshFault(f"{path}, row {number}: {what}") from None
        sets.append(frozenset(names[0].split() if names else ()))
    if len(set(labels)) < len(labels):
        raise MeshFault(f"{path}: expected different node numbers, got equal ones")
    return np.array(labels), np.array(points), sets


def triangulate(points: np.ndarray, view: str) -> np.ndarray:
    """Return Delaunay triangles of a surface's nodes, (t, 3), without those that bridge gaps.

    A triangle bridges a gap if a side is four times as long as the median. Nodes on one line have
    no triangles.
    """
    from scipy.spatial import Delaunay, QhullError  # slow to import, and used without a mesh alone

    if view == FROM_ABOVE:
        flat = points[:, [2, 0]]  # z, x: triangles turn about +y
        node = np.arange(len(points))
    else:
        flat, node = _unrolled(points, view)
    try:
        triangles = Delaunay(flat).simplices
    except QhullError:
        return np.empty((0, 3), dtype=np.int64)
    corner = flat[triangles]
    sides = np.linalg.norm(corner - np.roll(corner, 1, axis=1), axis=2)
    chosen = sides.max(axis=1) <= 4.0 * np.median(sides)
    if view != FROM_ABOVE:
        turn = corner[:, :, 0].mean(axis=1)
        half = np.pi * _radius(points, view)
        chosen &= (turn >= -half) & (turn < half)
    first, second, third = corner.swapaxes(0, 1)
    u = second - first
    v = third - first
    clockwise = u[:, 0] * v[:, 1] < u[:, 1] * v[:, 0]
    triangles[clockwise] = triangles[clockwise][:, [0, 2, 1]]
    return node[triangles[chosen]]


def _radius(points, view):
    """Return the mean radius of a cylinder's nodes."""
    x, y, z = points.T
    return np.hypot(x, z if view == AROUND_Y else y).mean()


def _unrolled(points, view):
    """Return arc length and height of the nodes, (3 n, 2), and the node of each.

    The nodes are repeated to the left and to the right.
    """
    x, y, z = points.T
    side, along = (z, y) if view == AROUND_Y else (y, z)
    radius = _radius(points, view)
    arc = radius * np.arctan2(x, side)
    turn = 2 * np.pi * radius
    flat = np.concatenate([np.stack([arc + k * turn, along], axis=1) for k in (-1, 0, 1)])
    return flat, np.tile(np.arange(len(points)), 3)
