"""Stiffness and mass matrices from other programs: Matrix Market, Abaqus text, Nastran DMIG."""

import gzip
import re
from pathlib import Path

import numpy as np
import scipy.sparse as sp

from .element import rigid_motions
from .mesh import MeshFault

NASTRAN = (".bdf", ".dat", ".nas", ".pch", ".dmig")


def read_matrix(path, labels):
    """A symmetric matrix on the displacements of a body's nodes.

    - Matrix Market (first line `%%MatrixMarket`) and Abaqus' coordinate format (three columns: row,
    column, value): degrees of
      freedom are x, y, z of the first node, then of the second, and so on, in the order of the file
      that gives the nodes.
    - Abaqus' matrix input and label formats (five columns: node, degree of freedom, node, degree of
      freedom, value).
    - Nastran DMIG in a punch or bulk data file with one matrix; small, large and comma-separated
      fields.

    One triangle stands for both. Entries of nodes that are not in `labels`, and of rotations, must
    be zero.

    Parameters
    ----------
    path : Path
    labels : ndarray of int, shape (n,)
        Numbers of the nodes in these files, in the body's order.

    Returns
    -------
    scipy.sparse.csc_matrix, shape (3 n, 3 n)
        In the file's units.

    Raises
    ------
    MeshFault
        Names the file and the first row or node at fault.
    """
    path, n = Path(path), len(labels)
    if path.suffix.lower() in NASTRAN:
        return _by_labels(_dmig(path), labels, path)
    with open(path, encoding="ascii", errors="replace") as file:
        if file.readline().startswith("%%MatrixMarket"):
            from scipy.io import mmread

            return _whole(sp.coo_array(mmread(path)), n, path)
    table = _columns(path)
    if table.shape[1] == 5:
        return _by_labels(table, labels, path)
    if table.shape[1] != 3:
        raise MeshFault(
            [
                f"{path.name}: {table.shape[1]} columns; wanted are node, direction, node, direction, value, or row, "
                "column, value"
            ]
        )
    row, column = table[:, :2].T.astype(np.int64) - 1
    size = max(3 * n, row.max() + 1, column.max() + 1)
    return _whole(sp.coo_array((table[:, 2], (row, column)), shape=(size, size)), n, path)


def _columns(path):
    """Numbers of a text file without its keyword and comment lines (`*`), shape (rows, columns)."""
    with open(path) as file:
        first = next((line for line in file if line.strip() and not line.startswith("*")), "")
    try:
        return np.loadtxt(path, comments="*", delimiter="," if "," in first else None, ndmin=2)
    except ValueError as error:
        raise MeshFault([f"{path.name}: {error}"]) from None


def _whole(matrix, n, path):
    """Check the size; complete a triangle."""
    if matrix.shape != (3 * n, 3 * n):
        raise MeshFault(
            [
                f"{path.name}: {matrix.shape[0]} x {matrix.shape[1]}; {n} nodes need {3 * n} rows, x, y, z of each "
                "node in the order of the nodes' file"
            ]
        )
    return _symmetric(matrix.tocsc(), path)


def _symmetric(matrix, path):
    """Entries that are given on one side of the diagonal only, on both; those given twice must
    agree.
    """
    other = matrix.T.tocsc()
    here = sp.csc_matrix((np.ones(matrix.nnz), matrix.indices, matrix.indptr), shape=matrix.shape)
    both = other.multiply(here)
    difference = abs(matrix.multiply(here.T) - both).tocoo()
    if difference.nnz and difference.data.max() > 1e-8 * abs(matrix).max():
        at = difference.data.argmax()
        raise MeshFault(
            [
                f"{path.name}: not symmetric, rows {difference.row[at] + 1} and {difference.col[at] + 1} of the body "
                f"differ by {difference.data[at]:.3g}"
            ]
        )
    return sp.csc_matrix(matrix + (other - both))


def _by_labels(table, labels, path):
    """Matrix of rows (node, direction 1..6, node, direction, value)."""
    order = np.argsort(labels)
    places, faults = [], []
    table = table[table[:, 4] != 0.0]
    for node, direction in (table[:, 0:2].T, table[:, 2:4].T):
        at = order[np.searchsorted(labels, node, sorter=order).clip(max=len(labels) - 1)]
        strange, turned = (
            np.flatnonzero(labels[at] != node),
            np.flatnonzero((direction < 1) | (direction > 3)),
        )
        if len(strange):
            faults.append(
                f"{path.name}, entry {strange[0] + 1}: node {int(node[strange[0]])} is not among the body's nodes"
            )
        if len(turned):
            faults.append(
                f"{path.name}, entry {turned[0] + 1}: node {int(node[turned[0]])} has direction "
                f"{int(direction[turned[0]])}; solid bodies have 1, 2, 3"
            )
        places.append(3 * at + direction.astype(np.int64) - 1)
    if faults:
        raise MeshFault(list(dict.fromkeys(faults)))
    return _symmetric(
        sp.coo_array((table[:, 4], tuple(places)), shape=(3 * len(labels),) * 2).tocsc(), path
    )


def _dmig(path):
    """Rows (node, direction, node, direction, value) of the one DMIG matrix in a file."""
    rows, names, column = [], set(), (0, 0)
    for number, fields in _cards(path):
        try:
            if fields[0] == "DMIG" and fields[2] in ("0", ""):  # the header: name, 0, form, type
                names.add(fields[1])
                continue
            if fields[0] == "DMIG":
                names.add(fields[1])
                column, fields = (int(fields[2]), int(fields[3] or 1)), fields[5:]
            else:
                fields = fields[1:]
            for k in range(0, len(fields) - 2, 4):
                if fields[k]:
                    rows.append(
                        (int(fields[k]), int(fields[k + 1] or 1), *column, _real(fields[k + 2]))
                    )
        except (ValueError, IndexError):
            raise MeshFault(
                [f"{path.name}, line {number}: not a DMIG entry: {','.join(fields)!r}"]
            ) from None
    if len(names) != 1 or not rows:
        raise MeshFault(
            [f"{path.name}: one DMIG matrix is wanted, found {', '.join(sorted(names)) or 'none'}"]
        )
    return np.array(rows, dtype=float)


def _cards(path):
    """(line number, fields) of the DMIG entries and their continuations; the first field is DMIG or
    empty.
    """
    inside = False
    with open(path) as file:
        for number, line in enumerate(file, 1):
            line = line.split("$")[0].rstrip()
            head = line[:8].split(",")[0].strip().rstrip("*").upper()
            inside = head == "DMIG" or (inside and (head == "" or head[0] in "+*") and line != "")
            if not inside:
                continue
            if "," in line:
                fields = [part.strip() for part in line.split(",")]
            else:
                width = 16 if "*" in line[:8] else 8
                fields = [""] + [
                    line[k : k + width].strip() for k in range(8, min(len(line), 72), width)
                ]
            yield number, ["DMIG" if head == "DMIG" else "", *fields[1:]]


def _real(text):
    """A Nastran real: 1.5+3 and 1.5D+3 are 1.5e3."""
    return float(re.sub(r"(?<=[\d.])([+-]\d+)$", r"e\1", text.upper().replace("D", "E")))


def node_labels(path, count):
    """Numbers of a mesh file's nodes: those of an Abaqus or Nastran file, else 1, 2, ..., in the
    order of the file.
    """
    path = Path(path)
    kind = Path(path.stem).suffix if path.suffix == ".gz" else path.suffix
    with (gzip.open if path.suffix == ".gz" else open)(path, "rt", errors="replace") as file:
        if kind == ".inp":
            return np.array(list(_abaqus_nodes(file)))
        if kind in (".bdf", ".nas", ".dat"):
            return np.array(
                [
                    int(
                        line.split(",")[1]
                        if "," in line
                        else line[8 : 24 if line[:5] == "GRID*" else 16]
                    )
                    for line in file
                    if line[:4].upper() == "GRID"
                ]
            )
    return np.arange(1, count + 1)


def _abaqus_nodes(lines):
    inside = False
    for line in lines:
        if line.startswith("*"):
            inside = (
                inside and line.startswith("**") or line.split(",")[0].strip().upper() == "*NODE"
            )
        elif inside and line.strip():
            yield int(line.split(",")[0])


def matrix_faults(mesh, K, M, where):
    """Sentences about matrices in SI that cannot be those of a loose solid body of metal: wrong
    units, order or supports.

    Eq. (X1):  K R = 0    R the six rigid motions
    Eq. (X2):  c ~ d sqrt(median K_ii/M_ii)      d the distance of neighbouring nodes, c the speed of sound, some 5 km/s

    Parameters
    ----------
    mesh : Mesh
    K, M : scipy.sparse matrix, shape (3 n, 3 n)
        [N/m], [kg]
    where : str
        Begins each sentence.
    """
    from scipy.spatial import cKDTree

    faults = []
    for name, matrix in (("stiffness", K), ("mass", M)):
        bad = np.flatnonzero(matrix.diagonal() <= 0.0)
        if len(bad):
            faults.append(
                f"{where}: {len(bad)} diagonal entries of the {name} are not positive, the first at node "
                f"{bad[0] // 3 + 1} of the body along {'xyz'[bad[0] % 3]}"
            )
    if faults:
        return faults
    rigid = rigid_motions(mesh.points - mesh.points.mean(axis=0))
    resisted = np.abs(K @ rigid).max(axis=0) / (abs(K) @ np.abs(rigid)).max(axis=0)  # Eq. (X1)
    if resisted.max() > 1e-5:
        faults.append(
            f"{where}: the stiffness resists rigid motions ({resisted.max():.2g} of its size): the body must be loose, "
            "and the rows in the order of the nodes"
        )
    near = np.median(cKDTree(mesh.points).query(mesh.points, 2)[0][:, 1])
    speed = near * np.sqrt(np.median(K.diagonal() / M.diagonal()))  # Eq. (X2)
    if not 8e2 < speed < 8e4:
        faults.append(
            f"{where}: stiffness, mass and size would make the speed of sound some {speed:.2g} m/s; "
            "check stiffness_unit, mass_unit, mesh_unit"
        )
    density = M.sum() / 3 / np.prod(np.ptp(mesh.points, axis=0))
    if not 20.0 < density < 25e3:
        faults.append(
            f"{where}: a mass of {M.sum() / 3:.3g} kg in a box of {np.prod(np.ptp(mesh.points, axis=0)):.3g} m3 "
            f"({density:.2g} kg/m3); check mass_unit, mesh_unit"
        )
    return faults
