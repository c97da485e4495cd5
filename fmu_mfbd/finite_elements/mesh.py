"""Mesh of a body: reader, named surfaces, and faults."""

import gzip
import lzma
import re
import shutil
import tempfile
import zlib
from collections import Counter, defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ...master.fmi.errors import file_fault
from .abaqus import read_abaqus
from .ansys import read_ansys
from .connections import corner_remarks, mesh_faults, outer_faces
from .deck import Deck, MeshFault, Selection, entry, tetrahedra, text_of
from .gmsh import read_gmsh
from .materials import ElementSets, Material
from .med import read_med
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
    sets : ElementSets
        Sets of elements and materials of the mesh file.
    material : Material, optional
        Material of the elements, if it is known.
    """

    points: np.ndarray
    tets: np.ndarray
    faces: dict[str, np.ndarray]
    members: dict[str, np.ndarray] = field(default_factory=dict)
    labels: np.ndarray | None = None
    sets: ElementSets = ElementSets()
    material: Material | None = None

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
    part: str | None = None,
    say: Callable[[str], None] = print,
) -> Mesh:
    """Read a mesh file in this project's axes, select its surfaces and check it.

    Parameters
    ----------
    path : Path
        A file in one of the `FORMATS`, also as `.gz` or `.xz`. Linear tetrahedra get edge nodes at
        straight edges, with a warning.
    surfaces : dict of str to Region or None
        Surfaces that the mesh must have; None if the file names them.
    scale : float
        Length of the file's unit [m].
    axes : sequence of str
        Directions of the file that become x (thrust), y (towards the head) and z (pin), for example
        "x" or "-z".
    origin : sequence of float
        Coordinates of this project's origin in the file [m].
    part : str, optional
        Name of the only part, instance or set of elements that is read. Default: the whole file.
    say : callable
        Prints a warning.

    Raises
    ------
    MeshFault
        If the file has unknown element types, lacks surfaces, or has faults of `mesh_faults`.
    """
    raw = read_raw(Path(path), part)
    for remark in raw.remarks:
        say(f"{path}: {remark}")
    points = to_body_axes(raw.points * scale, axes, origin)
    used = np.unique(raw.tets)  # nodes that no element uses would make the stiffness singular
    number = np.full(len(points), -1)
    number[used] = np.arange(len(used))
    points = points[used]
    tets = number[raw.tets]
    outer = outer_faces(tets)
    faces = {
        name: outer[_marked(raw, number, points, outer, name, region)]
        for name, region in surfaces.items()
    }
    faults = [
        f"{path}: surface '{name}': expected outer faces, got {_instead(raw, name, region)}"
        for name, region in surfaces.items()
        if not len(faces[name])
    ]
    faults += mesh_faults(points, tets, path)
    if faults:
        hints = raw.choice() if any("pieces" in fault for fault in faults) else []
        raise MeshFault([*faults, *(f"{path}: {hint}" for hint in hints)])
    for remark in corner_remarks(points, tets):
        say(f"{path}: {remark}")
    members = {name: np.unique(one.tets) for name, one in raw.parts.items() if len(one.tets)}
    sets = ElementSets(members, raw.materials, raw.properties, scale)
    labels = None if raw.labels is None else raw.labels[used]
    return Mesh(points, tets, faces, labels=labels, sets=sets)


def _instead(raw: Deck, name: str, region: Region | None) -> str:
    """Return what a file has instead of the faces of a surface."""
    if region is not None:
        return "none in its region; check origin, axes and mesh_unit"
    if fault := entry(raw.faults, name):
        return fault
    if (nodes := entry(raw.node_sets, name)) is not None:
        return f"a set of {len(nodes)} nodes that holds the corners of no outer face"
    if entry(raw.faces, name) is not None:
        return "faces inside the body"
    if entry(raw.parts, name) is not None:
        return "a set of solid elements; define a set of nodes or a surface"
    return f"no such name; the file names {', '.join(raw.known()) or 'none'}"


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


PACKED = {".gz": gzip.open, ".xz": lzma.open}


def read_raw(path: Path, part: str | None = None) -> Deck:
    """Read a file, which may be compressed, or a part of it, in its own axes and units.

    Raises
    ------
    MeshFault
        If the file cannot be read.
    """
    if path.suffix not in PACKED:
        return _read(path, path, part)
    with tempfile.TemporaryDirectory() as folder:
        plain = Path(folder) / path.stem
        try:
            with PACKED[path.suffix](path) as packed, open(plain, "wb") as file:
                shutil.copyfileobj(packed, file)
        except (EOFError, gzip.BadGzipFile, lzma.LZMAError, zlib.error) as error:
            raise MeshFault(f"{path}: expected a compressed mesh, got {error}") from None
        return _read(plain, path, part)


def _read(plain, path, part):
    """Read an uncompressed file; messages contain `path`."""
    try:
        if plain.suffix.lower() in GEOMETRY:
            raise MeshFault(
                "expected a mesh of tetrahedra, got geometry; mesh it first, e.g. by new --step"
            )
        deck = _reader(plain)(plain)
        return (deck.only(part) if part else deck).completed()
    except MeshFault as fault:
        raise fault.of_file(path) from None
    except OSError as error:
        raise MeshFault(file_fault(path, error)) from None
    except (StopIteration, RuntimeError):  # of a reader's loop
        raise MeshFault(f"{path}: {UNREADABLE} (it ends too early)") from None
    except (ValueError, KeyError, IndexError) as reason:
        if text := re.search("(?:to float|base 10): (.*)", str(reason)):
            raise MeshFault(f"{path}: expected a number, got {text[1]}") from None
        raise MeshFault(f"{path}: {UNREADABLE} ({reason}); {FORMATS}") from None


GEOMETRY = (".step", ".stp", ".iges", ".igs", ".brep", ".x_t", ".x_b", ".sat", ".stl", ".sldprt")
"""Suffixes of files of geometry."""
FORMATS = (
    "readable suffixes: .msh (gmsh), .inp (Abaqus), .bdf/.nas/.fem/.dat (Nastran), .cdb/.dat "
    "(Ansys), .med/.vtu/.vtk"
)
"""Hint about the files that are read."""
UNREADABLE = "expected a mesh file, got other or incomplete content"
READERS = {
    r"\s*\$MeshFormat": read_gmsh,
    r"(?im)^\*keyword\b": "a deck of LS-DYNA; export Abaqus or Nastran",  # with words of Abaqus
    r"\A\s*-1\s*\n\s*\d+\s*\n": "a universal file (UNV); export MED, or Nastran",
    r"(?im)^[ \t]*((n|e|cm|et)block|/prep7)\b": read_ansys,
    r"(?im)^[ \t]*\*\s*(node|part|heading|include|element)\b": read_abaqus,
    r"(?im)^[ \t]*(begin\s+bulk|include\s+['\"]|(grid|ctetra)\*?[\s,])": read_nastran,
}
"""Readers by a pattern of the file, or the name of a format that is not read. The first match
counts."""
BY_MESHIO = (".vtu", ".vtk", ".mesh", ".meshb", ".xdmf", ".vol", ".su2", ".e", ".exo")
"""Suffixes of formats that meshio reads, with named surfaces if the format has them."""


def _reader(path):
    """Return the reader of a file by its content, for formats without text by its suffix.

    Abaqus, Ansys and Nastran all write .inp and .dat.
    """
    if path.suffix.lower() == ".med":
        return read_med
    if path.suffix.lower() in BY_MESHIO:
        return _by_meshio
    text = text_of(path)
    readers = (reader for pattern, reader in READERS.items() if re.search(pattern, text))
    reader = next(readers, None)
    if isinstance(reader, str):
        raise MeshFault(f"expected a mesh file that is read, got {reader}; {FORMATS}")
    if reader:
        return reader
    raise MeshFault(f"{UNREADABLE}; {FORMATS}")


def _by_meshio(path: Path) -> Deck:
    """Read a file with meshio."""
    import meshio

    try:
        raw = meshio.read(path)
    except (Exception, SystemExit) as error:  # its readers raise any error, or exit
        reason = "" if isinstance(error, SystemExit) else f" (meshio: {error})"
        raise MeshFault(f"{UNREADABLE}{reason}; {FORMATS}") from None
    tets: list[list[int]] = []
    faces: dict[str, list[np.ndarray]] = defaultdict(list)
    parts: dict[str, list[np.ndarray]] = defaultdict(list)
    other: Counter[str] = Counter()
    for k, cells in enumerate(raw.cells):
        sets = {name: rows[k] for name, rows in raw.cell_sets.items()}
        members = {name: rows for name, rows in sets.items() if rows is not None and len(rows)}
        if cells.type in TETRAHEDRA:
            for name, rows in members.items():
                parts[name].append(len(tets) + np.asarray(rows, dtype=int))
            tets += cells.data.tolist()
            continue
        other[cells.type] += len(cells.data)
        for name, rows in members.items() if cells.type in TRIANGLES else ():
            faces[name].append(cells.data[rows][:, :3])
    return Deck(
        points=np.asarray(raw.points, dtype=float),
        tets=tetrahedra(tets),
        node_sets={name: np.asarray(rows, dtype=int) for name, rows in raw.point_sets.items()},
        faces={name: np.concatenate(rows) for name, rows in faces.items()},
        labels=np.arange(1, len(raw.points) + 1),
        other=other,
        parts={name: Selection(np.concatenate(rows)) for name, rows in parts.items()},
    )


TETRAHEDRA, TRIANGLES = ("tetra", "tetra10"), ("triangle", "triangle6")


def _marked(raw, number, points, outer, name, region):
    """Return which outer faces belong to a surface, by its region or by the names in the file.

    number : new number of each node of the file, -1 if no element uses it.
    """
    corners = outer[:, :3]
    if region is not None:
        return region.holds(points[corners])
    faces = entry(raw.faces, name)
    if faces is not None and len(faces):
        keys = {tuple(key) for key in np.sort(number[faces], axis=1)}
        return np.array([tuple(key) in keys for key in np.sort(corners, axis=1)], dtype=bool)
    nodes = entry(raw.node_sets, name)
    if nodes is not None:
        return np.isin(corners, number[nodes]).all(axis=1)
    return np.zeros(len(outer), dtype=bool)
