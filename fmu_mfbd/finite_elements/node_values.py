"""Displacements and temperatures at nodes from files of other programs: CSV, VTU, CalculiX frd.

meshio 5.3.5 reads VTU. It does not read frd files.
"""

import re
from collections.abc import Iterator, Sequence
from itertools import takewhile
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...master.fmi.errors import file_fault
from ...master.fmi.separated import read_rows
from .deck import CORNERS, MeshFault
from .element import EDGES, rigid_motions
from .mesh import Mesh, axes_matrix, to_body_axes

NODE_TOLERANCE = 1e-4
"""Largest distance of a node of the file from that of the mesh, by the size of the mesh."""
DEFORMATION_RANGE = 1e-5, 2e-2
"""Range of the deformation of a surface by its size. Heat of 500 K expands aluminium by 1.2e-2, and
bolts distort a bore by some 1e-4: a wrong length unit is a factor of 25 or more."""


class Quantity(NamedTuple):
    """Quantity at nodes: name, names of its columns in a CSV, and pattern of its name elsewhere."""

    name: str
    columns: tuple[str, ...]
    pattern: str


DISPLACEMENT = Quantity("displacement", ("ux", "uy", "uz"), r"(?i)(disp\w*|u)$")
TEMPERATURE = Quantity("temperature", ("temperature",), r"(?i)((nd)?temp\w*|t|nt)$")


class NodeValues(NamedTuple):
    """Values at nodes as the file has them.

    Parameters
    ----------
    values : ndarray, shape (m, k)
    labels : ndarray of int, shape (m,), or None
        Numbers of the nodes.
    points : ndarray, shape (m, 3), or None
        Coordinates of the nodes.
    """

    values: np.ndarray
    labels: np.ndarray | None = None
    points: np.ndarray | None = None


def read_node_values(path: Path | str, quantity: Quantity, field: str | None = None) -> NodeValues:
    """Read a quantity at nodes.

    - CSV: the header names the columns `node`, `x`, `y`, `z` (one or both kinds) and those of the
      quantity: `ux`, `uy`, `uz`, or `temperature`.
    - VTU and other formats of meshio: the point data `field`.
    - frd of CalculiX in text: the last results `field`, default: DISP or NDTEMP.

    Parameters
    ----------
    path : Path
    quantity : Quantity
    field : str, optional
        Name in the file, not for CSV. Default: the only field with such a name.

    Raises
    ------
    MeshFault
        If the file cannot be read, or does not have the quantity.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    try:
        if suffix == ".csv":
            if field:
                raise MeshFault(
                    f"field: expected nothing for a CSV file, whose header names the columns, got "
                    f"{field!r}"
                )
            return _of_table(path, quantity)
        return (
            _of_frd(path, quantity, field)
            if suffix == ".frd"
            else _by_meshio(path, quantity, field)
        )
    except MeshFault as fault:
        raise fault.of_file(path) from None
    except (OSError, UnicodeDecodeError) as error:
        raise MeshFault(file_fault(path, error)) from None
    except (ValueError, LookupError) as error:
        raise MeshFault(f"{path}: expected numbers at nodes, got other content ({error})") from None


def _of_table(path, quantity):
    """Return the values of a CSV file."""
    (_, head), *rows = read_rows(path) or [(0, [])]
    header = [name.strip().lower() for name in head]
    places = ("node",), ("x", "y", "z")
    has = [set(place) <= set(header) for place in places]
    missing = [name for name in quantity.columns if name not in header]
    if missing or not any(has):
        raise MeshFault(
            f"expected a first row with node or x,y,z and {','.join(quantity.columns)}, got "
            f"{','.join(header)!r}"
        )
    table = np.empty((len(rows), len(header)))
    for k, (number, row) in enumerate(rows):
        try:
            table[k] = [float(cell) for cell in row]
        except ValueError:
            what = f"expected {len(header)} numbers, got {','.join(row)!r}"
            raise MeshFault(f"row {number}: {what}") from None
    columns = dict(zip(header, table.T))
    labels, points = (
        np.stack([columns[name] for name in place], axis=1) if there else None
        for place, there in zip(places, has)
    )
    values = np.stack([columns[name] for name in quantity.columns], axis=1)
    return NodeValues(values, None if labels is None else labels[:, 0].astype(int), points)


def _by_meshio(path, quantity, field):
    """Return point data of a file that meshio reads."""
    import meshio

    try:
        raw = meshio.read(path)
    except (Exception, SystemExit) as error:  # its readers raise any error, or exit
        text = str(error) or "meshio cannot read it"
        raise MeshFault(f"expected .csv, .frd, .vtu or .vtk with results, got {text}") from None
    count = len(quantity.columns)
    data = {
        name: np.asarray(one, float).reshape(len(raw.points), -1)
        for name, one in raw.point_data.items()
    }
    name = _chosen([name for name, one in data.items() if one.shape[1] == count], quantity, field)
    return NodeValues(data[name], None, np.asarray(raw.points, dtype=float))


def _chosen(names: Sequence[str], quantity: Quantity, field: str | None) -> str:
    """Return the name of the field of a quantity."""
    matches = [field] if field else [name for name in names if re.match(quantity.pattern, name)]
    if len(matches) != 1 or matches[0] not in names:
        asked = f"field {field!r}" if field else f"one field with the {quantity.name}"
        known = ", ".join(names) or "none"
        raise MeshFault(f"expected {asked}, got {known}; set field to its name")
    return matches[0]


def _of_frd(path, quantity, field):
    """Return the last results of a name in an frd file: records -1 with node and values."""
    lines = path.read_text(encoding="ascii", errors="replace").splitlines()
    blocks: dict[str, tuple[np.ndarray, np.ndarray]] = {}
    points, width = None, 10
    rows = iter(lines)
    for line in rows:
        key = line[:6].strip()
        if key == "2C":
            if line[-1:] in ("2", "3"):
                raise MeshFault("expected an frd file in text, got a binary one")
            width = 5 if line.endswith("0") else 10
            points = _records(rows, width, 3)
        elif line.startswith(" -4"):
            name, count = line[5:13].strip(), int(line[13:18])
            blocks[name] = _records(rows, width, min(count, len(quantity.columns)))
    if points is None:
        raise MeshFault("expected a block of nodes (2C), got none")
    known = [name for name, (_, one) in blocks.items() if one.shape[1] == len(quantity.columns)]
    labels, values = blocks[_chosen(known, quantity, field)]
    number = {label: row for row, label in enumerate(points[0].tolist())}
    place = points[1][[number[label] for label in labels.tolist()]]
    return NodeValues(values, labels, place)


def _records(rows: Iterator[str], width: int, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return numbers of nodes, (m,), and values, (m, count), of the records -1 up to -3.

    width : columns of the number of a node; values have twelve.
    """
    first = 3 + width
    block = takewhile(lambda line: line[:3] != " -3", rows)
    records = [line for line in block if line[:3] == " -1"]
    labels = np.array([int(line[3:first]) for line in records], dtype=int)
    ends = [first + 12 * k for k in range(count + 1)]
    values = [[float(line[a:b]) for a, b in zip(ends, ends[1:])] for line in records]
    return labels, np.array(values).reshape(-1, count)


class Placement(NamedTuple):
    """Length of the unit of a file of results [m], and axes and origin of the mesh file."""

    length: float
    axes: Sequence[str]
    origin: Sequence[float]


def on_mesh(
    nodal: NodeValues, mesh: Mesh, placed: Placement, needed: np.ndarray, where: str
) -> np.ndarray:
    """Return values at the nodes of a mesh, (n, k), nan at nodes that the file does not have.

    Nodes are identified by their coordinates, or by their numbers if the file has no coordinates.
    A node in the middle of an edge without a value has the mean of the ends.

    Parameters
    ----------
    nodal : NodeValues
    mesh : Mesh
    placed : Placement
    needed : ndarray of int
        Nodes that must have a value.
    where : str
        Begins the faults.

    Raises
    ------
    MeshFault
        If a needed node has no value, or a value is not finite.
    """
    out = np.full((len(mesh.points), nodal.values.shape[1]), np.nan)
    size = float(np.ptp(mesh.points, axis=0).max())
    if nodal.points is not None:
        from scipy.spatial import KDTree

        points = to_body_axes(nodal.points * placed.length, placed.axes, placed.origin)
        distance, row = KDTree(points).query(mesh.points)
        near = distance <= NODE_TOLERANCE * size
        out[near] = nodal.values[np.asarray(row)[near]]
        spans = [
            ", ".join(f"{1e3 * one:.4g}" for one in np.ptp(p, axis=0))
            for p in (points, mesh.points)
        ]
        reason = (
            f"nodes within {1e3 * NODE_TOLERANCE * size:.2g} mm, got distances of up to "
            f"{1e3 * distance[needed].max():.3g} mm; the file spans {spans[0]} mm and the mesh "
            f"{spans[1]} mm; check length_unit = {placed.length:g} m, mesh_unit, axes and origin"
        )
    elif mesh.labels is not None and nodal.labels is not None:
        row_of = {label: row for row, label in enumerate(nodal.labels.tolist())}
        row = np.array([row_of.get(label, -1) for label in mesh.labels.tolist()])
        out[row >= 0] = nodal.values[row[row >= 0]]
        reason = "numbers of nodes as in the mesh file, got others; or give x,y,z"
    else:
        raise MeshFault(f"{where}: expected x,y,z of the nodes, got numbers, which the mesh lacks")
    _fill_middles(out, mesh.tets)
    lacking = np.flatnonzero(~np.isfinite(out[needed]).all(axis=1))
    if len(lacking):
        x, y, z = 1e3 * mesh.points[needed[lacking[0]]]
        raise MeshFault(
            f"{where}: expected finite values at {len(needed)} nodes, got none at {len(lacking)}, "
            f"the first at ({x:.4g}, {y:.4g}, {z:.4g}) mm; expected {reason}"
        )
    return out


def _fill_middles(values: np.ndarray, tets: np.ndarray) -> None:
    """Give nodes in the middle of edges without values the mean of the ends, in place."""
    middles = tets[:, CORNERS:]
    empty = np.isnan(values[middles]).all(axis=2)
    ends = tets[:, EDGES][empty]
    values[middles[empty]] = values[ends].mean(axis=1)


def displacement_on(
    nodal: NodeValues, mesh: Mesh, placed: Placement, surface: str, needed: np.ndarray, where: str
) -> np.ndarray:
    """Return displacements at the nodes of a mesh in the body's axes, (n, 3) [m].

    Eq. (M26):  e = max |u - R q|/L      q of least squares: R its rigid motions, L the size

    e is the deformation of the surface, which must be in the range `DEFORMATION_RANGE`.

    Parameters
    ----------
    nodal, mesh, placed, needed, where
        As for `on_mesh`.
    surface : str
        Film surface.

    Raises
    ------
    MeshFault
        As for `on_mesh`, and if the deformation is out of range.
    """
    u = on_mesh(nodal, mesh, placed, needed, where) * placed.length @ axes_matrix(placed.axes).T
    nodes = mesh.nodes(surface)
    size = float(np.ptp(mesh.points[nodes], axis=0).max())
    rest = without_rigid(mesh.points[nodes], u[nodes])
    deformed = float(np.linalg.norm(rest, axis=1).max()) / size  # Eq. (M26)
    least, most = DEFORMATION_RANGE
    if not least <= deformed <= most:
        raise MeshFault(
            f"{where}: expected a deformation of surface '{surface}' of "
            f"{1e6 * least * size:.3g} to {1e6 * most * size:.3g} um, got "
            f"{1e6 * deformed * size:.3g} um; check length_unit = {placed.length:g} m"
        )
    return u


def without_rigid(points: np.ndarray, displacement: np.ndarray) -> np.ndarray:
    """Return a displacement, (n, 3), without its rigid motion of least squares."""
    rigid = rigid_motions(points - points.mean(axis=0))
    q, *_ = np.linalg.lstsq(rigid, displacement.ravel(), rcond=None)
    return displacement - (rigid @ q).reshape(-1, 3)
