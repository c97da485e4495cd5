"""Mesh of a body: reader, named surfaces, and faults."""

import gzip
import lzma
import shutil
import tempfile
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ...master.fmi.errors import file_fault
from .abaqus import read_abaqus
from .ansys import read_ansys
from .connections import mesh_faults, outer_faces
from .deck import Deck, MeshFault
from .element import EDGES
from .nastran import read_nastran
from .regions import Region


@dataclass(frozen=True)
class Mesh:
    """Ten-node tetrahedra with named surfaces, or nodes and three-node triangles (`point_cloud`).

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Node positions [m].
    tets : ndarray of int, shape (e, 10)
        Corners, then the middles of edges 01, 12, 02, 03, 13, 23.
    faces : dict of str to ndarray of int, shape (t, 6)
        Outer faces of each named surface. Their normals point out of the body.
    members : dict of str to ndarray of int
        All nodes of a surface, if some of them do not belong to its faces.
    labels : ndarray of int, shape (n,), optional
        Numbers of the nodes in the mesh file. None if edge nodes were added, or if nodes of several
        instances have the same number.
    """

    points: np.ndarray
    tets: np.ndarray
    faces: dict[str, np.ndarray]
    members: dict[str, np.ndarray] = field(default_factory=dict)
    labels: np.ndarray | None = None

    def nodes(self, name: str) -> np.ndarray:
        """Return the sorted node numbers of the named surface."""
        return self.members.get(name, np.unique(self.faces[name]))

    def skin(self) -> np.ndarray:
        """Return all outer faces, (t, 6), or those of the named surfaces, (t, 3)."""
        return outer_faces(self.tets) if len(self.tets) else np.vstack(list(self.faces.values()))


def read_mesh(
    path: Path | str,
    surfaces: Mapping[str, Region | None],
    scale: float = 1.0,
    axes: Sequence[str] = ("x", "y", "z"),
    origin: Sequence[float] = (0.0, 0.0, 0.0),
    say: Callable[[str], None] = print,
) -> Mesh:
    """Read a mesh file in this project's axes, select its surfaces and check it.

    Parameters
    ----------
    path : Path
        Abaqus .inp, Nastran .bdf, .nas, .fem, ANSYS .cdb, gmsh .msh with physical groups, and other
        formats of meshio, also as `.gz` or `.xz`. Linear tetrahedra get edge nodes at straight
        edges, with a warning.
    surfaces : dict of str to Region or None
        Surfaces that the mesh must have; None if the file names them.
    scale : float
        Length of the file's unit [m].
    axes : sequence of str
        Directions of the file that become x (thrust), y (towards the head) and z (pin), for example
        "x" or "-z".
    origin : sequence of float
        Coordinates of this project's origin in the file [m].
    say : callable
        Prints a warning.

    Raises
    ------
    MeshFault
        If the file has unknown element types, lacks surfaces, or has faults of `mesh_faults`.
    """
    raw = read_raw(Path(path))
    if not len(raw.tets):
        present = ", ".join(f"{count} {kind}" for kind, count in raw.other.items()) or "nothing"
        raise MeshFault(f"{path}: expected 10-node tetrahedra, got {present}")
    if solids := {kind: n for kind, n in raw.other.items() if kind not in FLAT}:
        present = ", ".join(f"{count} {kind}" for kind, count in solids.items())
        raise MeshFault(f"{path}: expected 10-node tetrahedra only, got also {present}")
    tets = raw.tets
    points = to_body_axes(raw.points * scale, axes, origin)
    used = np.unique(tets)  # nodes that no tetrahedron uses would make the stiffness singular
    number = np.full(len(points), -1)
    number[used] = np.arange(len(used))
    points = points[used]
    tets = number[tets]
    linear = tets.shape[1] == 4
    if linear:
        say(
            f"{path}: linear tetrahedra; edge nodes added at straight edges, curved walls stay "
            "polygons"
        )
        points, tets = second_order(points, tets)
    outer = outer_faces(tets)
    faces = {
        name: outer[_marked(raw, number, points, outer, name, region)]
        for name, region in surfaces.items()
    }
    names = ", ".join(raw.known()) or "none"
    faults = [
        f"{path}: surface '{name}' is missing or empty (the file names {names})"
        for name, members in faces.items()
        if not len(members)
    ]
    labels = None if linear or raw.labels is None else raw.labels[used]
    mesh = Mesh(points, tets, faces, labels=labels)
    faults += mesh_faults(points, tets, path)
    if faults:
        raise MeshFault(faults)
    return mesh


def to_body_axes(points: np.ndarray, axes: Sequence[str], origin: Sequence[float]) -> np.ndarray:
    """Return points of a file, (n, 3), in this project's axes [m]."""
    return (points - np.asarray(origin)) @ axes_matrix(axes).T


def axes_matrix(axes: Sequence[str]) -> np.ndarray:
    """Return the matrix (3, 3) that transforms vectors of a file into this project's axes.

    Raises
    ------
    MeshFault
        If `axes` are not right-handed, so that elements would be inverted.
    """
    matrix = np.zeros((3, 3))
    for row, axis in enumerate(axes):
        matrix[row, "xyz".index(axis[-1])] = -1.0 if axis.startswith("-") else 1.0
    if not np.isclose(np.linalg.det(matrix), 1.0):
        raise MeshFault(f"axes: expected three right-handed directions, got {list(axes)}")
    return matrix


def second_order(points: np.ndarray, tets: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Add the middles of all edges to linear tetrahedra (e, 4); return points and (e, 10)."""
    ends = np.sort(tets[:, EDGES], axis=2).reshape(-1, 2)
    edges, number = np.unique(ends, axis=0, return_inverse=True)
    middles = points[edges].mean(axis=1)
    return np.vstack([points, middles]), np.hstack([tets, number.reshape(-1, 6) + len(points)])


PACKED = {".gz": gzip.open, ".xz": lzma.open}


def read_raw(path: Path) -> Deck:
    """Read a file, which may be compressed, in its own axes and units.

    Raises
    ------
    MeshFault
        If the file cannot be read.
    """
    if path.suffix not in PACKED:
        return _read(path, path)
    with tempfile.TemporaryDirectory() as folder:
        plain = Path(folder) / path.stem
        with PACKED[path.suffix](path) as packed, open(plain, "wb") as file:
            shutil.copyfileobj(packed, file)
        return _read(plain, path)


def _read(plain, path):
    """Read an uncompressed file; messages contain `path`."""
    try:
        return READERS.get(plain.suffix.lower(), _by_meshio)(plain)
    except MeshFault as fault:
        raise fault.of_file(path) from None
    except OSError as error:
        raise MeshFault(file_fault(path, error)) from None
    except (Exception, SystemExit):  # readers raise whatever comes, meshio ends the process
        raise MeshFault(f"{path}: expected a mesh file, got other or incomplete content") from None


READERS = {
    ".inp": read_abaqus,
    ".bdf": read_nastran,
    ".nas": read_nastran,
    ".fem": read_nastran,
    ".cdb": read_ansys,
}
"""Readers by the suffix of the file; meshio reads all others."""

FLAT = ("vertex", "line", "line3", "triangle", "triangle6", "quad", "quad8", "quad9")
"""Elements without volume, as meshio names them."""


def _by_meshio(path: Path) -> Deck:
    """Read a file with meshio, with names of gmsh's physical groups."""
    import meshio

    raw = meshio.read(path)
    kinds = Counter()
    for cells in raw.cells:
        kinds[cells.type] += len(cells.data)
    kind = "tetra10" if "tetra10" in kinds else "tetra"
    blocks = [cells.data for cells in raw.cells if cells.type == kind]
    tets = np.concatenate(blocks).astype(np.int64) if blocks else np.empty((0, 10), dtype=int)
    del kinds[kind]
    names = set(raw.field_data) | set(raw.cell_sets)
    return Deck(
        np.asarray(raw.points, dtype=float),
        tets,
        {name: np.asarray(rows, dtype=int) for name, rows in raw.point_sets.items()},
        {name: _faces_by_meshio(raw, name) for name in sorted(names)},
        np.arange(1, len(raw.points) + 1),
        kinds,
    )


def _faces_by_meshio(raw, name):
    """Return the corners of the triangles of a named group, (t, 3)."""
    tag = raw.field_data.get(name, (None,))[0]
    chosen = raw.cell_sets.get(name) or [
        np.flatnonzero(tags == tag) for tags in raw.cell_data.get("gmsh:physical", [])
    ]
    faces = [
        cells.data[rows][:, :3]
        for cells, rows in zip(raw.cells, chosen)
        if rows is not None and cells.type in ("triangle", "triangle6")
    ]
    return np.concatenate(faces) if faces else np.empty((0, 3), dtype=int)


def _marked(raw, number, points, outer, name, region):
    """Return which outer faces belong to a surface, by its region or by the names in the file.

    number : of each node of the file among the used ones.
    """
    corners = outer[:, :3]
    if region is not None:
        return region.holds(points[corners])
    faces = _entry(raw.faces, name)
    if faces is not None and len(faces):
        wanted = {tuple(key) for key in np.sort(number[faces], axis=1)}
        return np.array([tuple(key) in wanted for key in np.sort(corners, axis=1)], dtype=bool)
    nodes = _entry(raw.node_sets, name)
    if nodes is not None:
        return np.isin(corners, number[nodes]).all(axis=1)
    return np.zeros(len(outer), dtype=bool)


def _entry(table, name):
    """Return the entry of a name, or of the only name that differs in case alone, else None.

    ANSYS writes all names in capitals, and Abaqus ignores case.
    """
    if name in table:
        return table[name]
    same = [known for known in table if known.casefold() == name.casefold()]
    return table[same[0]] if len(same) == 1 else None
