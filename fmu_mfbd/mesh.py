"""A body's mesh: reading it, its named surfaces, and everything that can be wrong with it."""

import gzip
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .finite_element import jacobians, quadrature, shape_functions

FACES = np.array([[0, 2, 1, 6, 5, 4], [0, 1, 3, 4, 8, 7], [1, 2, 3, 5, 9, 8], [0, 3, 2, 7, 9, 6]])


class MeshFault(ValueError):
    """A mesh that cannot be used; `faults` holds one sentence each."""

    def __init__(self, faults):
        self.faults = list(faults)
        super().__init__("\n".join(self.faults))


@dataclass(frozen=True)
class Mesh:
    """Ten-node tetrahedra with named surfaces.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Node positions [m].
    tets : ndarray of int, shape (e, 10)
        Corners, then the middles of edges 01, 12, 02, 03, 13, 23.
    faces : dict of str to ndarray of int, shape (t, 6)
        Outer faces of each named surface, ordered so that their normal points out of the body.
    """

    points: np.ndarray
    tets: np.ndarray
    faces: dict

    def nodes(self, name):
        """Sorted node numbers of the named surface."""
        return np.unique(self.faces[name])


def read_mesh(path, names, scale=1.0):
    """Read a mesh file and check it.

    Parameters
    ----------
    path : Path
        Any format meshio knows with physical groups (gmsh .msh); `.gz` is unpacked on the way.
    names : list of str
        Surfaces that must be there.
    scale : float
        Length of the file's unit [m].

    Raises
    ------
    MeshFault
        Names every missing surface, a missing or linear element type, the first inverted element, loose pieces.
    """
    raw = _read(Path(path))
    cells = {kind: [c.data for c in raw.cells if c.type == kind] for kind in ("tetra10", "triangle6")}
    if not cells["tetra10"]:
        kinds = sorted({c.type for c in raw.cells})
        raise MeshFault([f"{path}: no 10-node tetrahedra (found {', '.join(kinds)}); write the mesh in second order"])
    tets = np.concatenate(cells["tetra10"]).astype(np.int64)
    points, tets = _drop_unused(np.asarray(raw.points, dtype=float) * scale, tets)
    mesh = Mesh(points[0], tets, {})
    surfaces, missing = _surfaces(raw, points[1], mesh, names)
    faults = [f"{path}: surface '{name}' is missing (found {', '.join(sorted(raw.field_data)) or 'none'})" for name in missing]
    faults += mesh_faults(mesh, path)
    if faults:
        raise MeshFault(faults)
    return Mesh(mesh.points, tets, surfaces)


def _read(path):
    import meshio

    if path.suffix != ".gz":
        return meshio.read(path)
    with tempfile.TemporaryDirectory() as folder:
        plain = Path(folder) / path.stem
        with gzip.open(path) as packed, open(plain, "wb") as file:
            shutil.copyfileobj(packed, file)
        return meshio.read(plain)


def _drop_unused(points, tets):
    """Nodes that no tetrahedron uses would make the stiffness singular; returns ((points, old -> new), tets)."""
    used = np.unique(tets)
    place = np.full(len(points), -1)
    place[used] = np.arange(len(used))
    return (points[used], place), place[tets]


def _surfaces(raw, place, mesh, names):
    """Faces of each named group, taken from the tetrahedra so that their normals point outwards."""
    outer = outer_faces(mesh.tets)
    found, missing = {}, []
    for name in names:
        tag = raw.field_data.get(name, (None, None))[0]
        marked = [c.data[t == tag] for c, t in zip(raw.cells, raw.cell_data.get("gmsh:physical", [])) if c.type == "triangle6"]
        marked = np.concatenate(marked) if marked else np.empty((0, 6), int)
        if tag is None or not len(marked):
            missing.append(name)
            continue
        wanted = {tuple(k) for k in np.sort(place[marked[:, :3]], axis=1)}
        keep = [tuple(k) in wanted for k in np.sort(outer[:, :3], axis=1)]
        found[name] = outer[np.array(keep)]
    return found, missing


def outer_faces(tets):
    """6-node faces that belong to one tetrahedron only, normals outwards, shape (t, 6)."""
    faces = tets[:, FACES].reshape(-1, 6)
    _, first, count = np.unique(np.sort(faces[:, :3], axis=1), axis=0, return_index=True, return_counts=True)
    return faces[np.sort(first[count == 1])]


def mesh_faults(mesh, where):
    """Sentences about inverted elements and loose pieces."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    faults = []
    at = np.vstack([quadrature(3)[0], [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]])
    least = jacobians(mesh.points, mesh.tets, shape_functions(at)[1])[1].min(axis=1)
    bad = np.flatnonzero(least <= 0.0)
    if len(bad):
        centre = mesh.points[mesh.tets[bad[0], :4]].mean(axis=0)
        faults.append(f"{where}: {len(bad)} inverted elements, the first is number {bad[0] + 1} at "
                      f"({centre[0]:.4g}, {centre[1]:.4g}, {centre[2]:.4g}) m with Jacobian {least[bad[0]]:.3g} m3")
    rows = np.repeat(mesh.tets[:, 0], 9)
    graph = coo_matrix((np.ones(len(rows)), (rows, mesh.tets[:, 1:].ravel())), shape=(len(mesh.points),) * 2)
    pieces, label = connected_components(graph, directed=False)
    if pieces > 1:
        sizes = np.bincount(label)
        faults.append(f"{where}: {pieces} unconnected pieces, of {', '.join(str(s) for s in sorted(sizes, reverse=True)[:6])} nodes: merge "
                      "coincident nodes")
    return faults
