"""A body's mesh: reading it, its named surfaces, and everything that can be wrong with it."""

import gzip
import shutil
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from .element import EDGES, NODES, jacobian_determinants, quadrature

FACES = np.array([[0, 2, 1, 6, 5, 4], [0, 1, 3, 4, 8, 7], [1, 2, 3, 5, 9, 8], [0, 3, 2, 7, 9, 6]])


class MeshFault(ValueError):
    """A mesh that cannot be used; `faults` holds one sentence each."""

    def __init__(self, faults):
        self.faults = list(faults)
        super().__init__("\n".join(self.faults))


@dataclass(frozen=True)
class Mesh:
    """Ten-node tetrahedra with named surfaces; or nodes alone, with surfaces of three-node
    triangles (`point_cloud`).

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Node positions [m].
    tets : ndarray of int, shape (e, 10)
        Corners, then the middles of edges 01, 12, 02, 03, 13, 23.
    faces : dict of str to ndarray of int, shape (t, 6)
        Outer faces of each named surface, ordered so that their normal points out of the body.
    members : dict of str to ndarray of int
        Nodes of a surface that its faces do not all hold.
    row : ndarray of int, shape (n,), optional
        Row of each node in the mesh file.
    """

    points: np.ndarray
    tets: np.ndarray
    faces: dict
    members: dict = field(default_factory=dict)
    row: np.ndarray | None = None

    def nodes(self, name):
        """Sorted node numbers of the named surface."""
        return self.members.get(name, np.unique(self.faces[name]))

    def skin(self):
        """All outer faces, for pictures: (t, 6), or those of the named surfaces, (t, 3)."""
        return outer_faces(self.tets) if len(self.tets) else np.vstack(list(self.faces.values()))


def read_mesh(path, surfaces, scale=1.0, axes=("x", "y", "z"), origin=(0.0, 0.0, 0.0), say=print):
    """Read a mesh file, turn it into this project's axes, find its surfaces and check it.

    Parameters
    ----------
    path : Path
        Any format meshio knows: gmsh .msh (physical groups), Abaqus .inp (element or node sets),
        Nastran .bdf (surfaces by geometry); `.gz` is unpacked on the way. Linear tetrahedra get
        edge nodes, with a warning: curved walls stay polygons.
    surfaces : dict of str to None or (str, ...)
        Surfaces that must be there: None where the file names them, else ("cylinder", radius, low,
        high), a cylinder about y [m], ("bore", radius) one about z, or ("plane", height) across y,
        all in this project's axes.
    scale : float
        Length of the file's unit [m].
    axes : sequence of str
        The file's directions that become x (thrust), y (towards the head), z (pin): "x", "-z", ...
    origin : sequence of float
        The file's coordinates of this project's origin [m].
    say : callable
        Takes a warning.

    Raises
    ------
    MeshFault
        Names every missing surface, wrong element types, the first inverted element, loose pieces,
        an absurd size.
    """
    raw = _read(Path(path))
    kinds = {cells.type for cells in raw.cells}
    if not kinds & {"tetra10", "tetra"}:
        raise MeshFault(
            [
                f"{path}: no tetrahedra (found {', '.join(sorted(kinds))}); write the mesh as 10-node tetrahedra"
            ]
        )
    kind = "tetra10" if "tetra10" in kinds else "tetra"
    tets = np.concatenate([cells.data for cells in raw.cells if cells.type == kind]).astype(
        np.int64
    )
    points, place, tets = _drop_unused(
        to_body_axes(np.asarray(raw.points, dtype=float) * scale, axes, origin), tets
    )
    if kind == "tetra":
        say(
            f"{path}: linear tetrahedra; edge nodes added at straight edges, curved walls stay polygons"
        )
        points, tets = second_order(points, tets)
    outer = outer_faces(tets)
    found = {
        name: outer[_marked(raw, place, points, outer, name, rule)]
        for name, rule in surfaces.items()
    }
    known = sorted(set(raw.field_data) | set(raw.cell_sets) | set(raw.point_sets))
    faults = [
        f"{path}: surface '{name}' is missing or empty (the file names {', '.join(known) or 'none'})"
        for name, faces in found.items()
        if not len(faces)
    ]
    mesh = Mesh(points, tets, found, row=np.flatnonzero(place >= 0) if kind == "tetra10" else None)
    faults += mesh_faults(mesh, path)
    if faults:
        raise MeshFault(faults)
    return mesh


def to_body_axes(points, axes, origin):
    """Points (n, 3) of a file in this project's axes [m]."""
    return (points - np.asarray(origin)) @ turn_of(axes).T


def turn_of(axes):
    """Matrix that turns vectors of a file into this project's axes; `axes` must be right-handed, or
    elements would invert.
    """
    turn = np.array(
        [
            [(-1.0 if axis.startswith("-") else 1.0) * (axis[-1] == name) for name in "xyz"]
            for axis in axes
        ]
    )
    if not np.isclose(np.linalg.det(turn), 1.0):
        raise MeshFault([f"axes = {list(axes)}: not a right-handed set of three directions"])
    return turn


def second_order(points, tets):
    """Add the middles of all edges to linear tetrahedra (e, 4)."""
    edges, place = np.unique(
        np.sort(tets[:, EDGES], axis=2).reshape(-1, 2), axis=0, return_inverse=True
    )
    return np.vstack([points, points[edges].mean(axis=1)]), np.hstack(
        [tets, place.reshape(-1, 6) + len(points)]
    )


def _read(path):
    """Mesh of a file as meshio has it; what meshio cannot read becomes a fault."""
    import meshio

    with tempfile.TemporaryDirectory() as folder:
        plain = path
        if path.suffix == ".gz":
            plain = Path(folder) / path.stem
            with gzip.open(path) as packed, open(plain, "wb") as file:
                shutil.copyfileobj(packed, file)
        try:
            return meshio.read(plain)
        except (
            Exception,
            SystemExit,
        ) as error:  # its readers raise whatever comes, and it ends the process itself
            raise MeshFault(
                [f"{path}: no mesh that can be read ({type(error).__name__}: {error})"]
            ) from None


def _drop_unused(points, tets):
    """Nodes that no tetrahedron uses would make the stiffness singular; returns points, old -> new,
    tets.
    """
    used = np.unique(tets)
    place = np.full(len(points), -1)
    place[used] = np.arange(len(used))
    return points[used], place, place[tets]


def _marked(raw, place, points, outer, name, rule):
    """Which outer faces belong to a surface, by its rule or by the file's names; judged by their
    corners.
    """
    corner = points[outer[:, :3]]
    if rule is not None:
        return GEOMETRY[rule[0]](corner, *rule[1:])
    if name in raw.point_sets:
        return np.isin(outer[:, :3], place[np.asarray(raw.point_sets[name], dtype=int)]).all(axis=1)
    tag = raw.field_data.get(name, (None,))[0]
    chosen = raw.cell_sets.get(name) or [
        np.flatnonzero(tags == tag) for tags in raw.cell_data.get("gmsh:physical", [])
    ]
    faces = [
        cells.data[rows][:, :3]
        for cells, rows in zip(raw.cells, chosen)
        if rows is not None and cells.type in ("triangle", "triangle6")
    ]
    wanted = (
        {tuple(key) for key in np.sort(place[np.concatenate(faces)], axis=1)} if faces else set()
    )
    return np.array([tuple(key) in wanted for key in np.sort(outer[:, :3], axis=1)], dtype=bool)


def _cylinder(corner, radius, low, high):
    near = np.abs(np.hypot(corner[..., 0], corner[..., 2]) - radius) <= LOOSE * radius
    return (
        near & (corner[..., 1] >= low - LOOSE * radius) & (corner[..., 1] <= high + LOOSE * radius)
    ).all(axis=1)


def _bore(corner, radius):
    return (np.abs(np.hypot(corner[..., 0], corner[..., 1]) - radius) <= LOOSE * radius).all(axis=1)


def _plane(corner, height):
    return (np.abs(corner[..., 1] - height) <= LOOSE * np.ptp(corner[..., 1])).all(axis=1)


LOOSE = 1e-3
"""How far, relative to its size, a corner may lie off a surface that is found by geometry."""

GEOMETRY = {"cylinder": _cylinder, "bore": _bore, "plane": _plane}


def outer_faces(tets):
    """6-node faces that belong to one tetrahedron only, normals outwards, shape (t, 6)."""
    faces = tets[:, FACES].reshape(-1, 6)
    _, first, count = np.unique(
        np.sort(faces[:, :3], axis=1), axis=0, return_index=True, return_counts=True
    )
    return faces[np.sort(first[count == 1])]


def mesh_faults(mesh, where):
    """Sentences about an absurd size, inverted elements and loose pieces."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    faults = []
    size = float(np.ptp(mesh.points, axis=0).max())
    if not 5e-3 < size < 5.0:
        faults.append(
            f"{where}: the body is {size:.3g} m long; mesh_unit should say "
            f"what a length of 1 in the file means (e.g. '1 mm')"
        )
    least = jacobian_determinants(
        mesh.points, mesh.tets, np.vstack([quadrature(3)[0], NODES[:4]])
    ).min(axis=1)
    bad = np.flatnonzero(least <= 0.0)
    if len(bad):
        centre = mesh.points[mesh.tets[bad[0], :4]].mean(axis=0)
        faults.append(
            f"{where}: {len(bad)} inverted elements, the first is number {bad[0] + 1} at "
            f"({centre[0]:.4g}, {centre[1]:.4g}, {centre[2]:.4g}) m with Jacobian {least[bad[0]]:.3g} m3"
        )
    rows = np.repeat(mesh.tets[:, 0], 9)
    graph = coo_matrix(
        (np.ones(len(rows)), (rows, mesh.tets[:, 1:].ravel())), shape=(len(mesh.points),) * 2
    )
    pieces, label = connected_components(graph, directed=False)
    if pieces > 1:
        largest = ", ".join(str(n) for n in sorted(np.bincount(label), reverse=True)[:6])
        faults.append(
            f"{where}: {pieces} unconnected pieces, of {largest} nodes: merge coincident nodes"
        )
    return faults
