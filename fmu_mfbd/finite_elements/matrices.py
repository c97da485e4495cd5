"""Stiffness and mass matrices from other programs: Matrix Market, Abaqus text, Nastran DMIG."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from .element import Sparse, rigid_motions
from .mesh import Mesh, MeshFault

NASTRAN = (".bdf", ".dat", ".nas", ".pch", ".dmig")


class Entries(NamedTuple):
    """Entries of a matrix by nodes and directions 1 to 6; arrays of shape (n,), all numbers as
    floats.
    """

    node: np.ndarray
    direction: np.ndarray
    other_node: np.ndarray
    other_direction: np.ndarray
    value: np.ndarray


def read_matrix(path: Path | str, labels: np.ndarray) -> Sparse:
    """A symmetric matrix on the displacements of a body's nodes.

    - Matrix Market (first line `%%MatrixMarket`) and Abaqus' coordinate format (three columns: row,
      column, value): degrees of freedom are x, y, z of the first node, then of the second, and so
      on, in the order of the file that gives the nodes.
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
    path = Path(path)
    n = len(labels)
    if path.suffix.lower() in NASTRAN:
        return _by_labels(_dmig(path), labels, path)
    with open(path, encoding="ascii", errors="replace") as file:
        if file.readline().startswith("%%MatrixMarket"):
            from scipy.io import mmread

            return _whole(sp.coo_array(mmread(path)), n, path)
    table = _columns(path)
    if table.shape[1] == 5:
        return _by_labels(Entries(*table.T), labels, path)
    if table.shape[1] != 3:
        raise MeshFault(
            [
                f"{path.name}: expected 3 or 5 columns, got {table.shape[1]}; write row, column, "
                "value or node, direction, node, direction, value"
            ]
        )
    row, column, value = table.T
    row = row.astype(np.int64) - 1
    column = column.astype(np.int64) - 1
    size = max(3 * n, row.max() + 1, column.max() + 1)
    return _whole(sp.coo_array((value, (row, column)), shape=(size, size)), n, path)


def _columns(path):
    """Numbers of a text file without its keyword and comment lines (`*`), shape (rows, columns)."""
    with open(path) as file:
        first = next((line for line in file if line.strip() and not line.startswith("*")), "")
    try:
        return np.loadtxt(path, comments="*", delimiter="," if "," in first else None, ndmin=2)
    except ValueError:
        raise MeshFault([f"{path.name}: expected rows of numbers, got other text"]) from None


def _whole(matrix, n, path):
    """Check the size; complete a triangle."""
    if matrix.shape != (3 * n, 3 * n):
        raise MeshFault(
            [
                f"{path.name}: expected {3 * n} rows for {n} nodes, got {matrix.shape[0]} x "
                f"{matrix.shape[1]}"
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
                f"{path.name}: expected a symmetric matrix, got a difference of "
                f"{difference.data[at]:.3g} between rows {difference.row[at] + 1} and "
                f"{difference.col[at] + 1}"
            ]
        )
    return sp.csc_matrix(matrix + (other - both))


def _by_labels(entries: Entries, labels: np.ndarray, path: Path) -> Sparse:
    """Matrix of the entries that are not zero."""
    entries = Entries(*(column[entries.value != 0.0] for column in entries))
    faults = _faults_of_freedoms(entries.node, entries.direction, labels, path)
    faults += _faults_of_freedoms(entries.other_node, entries.other_direction, labels, path)
    if faults:
        raise MeshFault(list(dict.fromkeys(faults)))
    row = _freedom(entries.node, entries.direction, labels)
    column = _freedom(entries.other_node, entries.other_direction, labels)
    shape = (3 * len(labels),) * 2
    return _symmetric(sp.coo_array((entries.value, (row, column)), shape=shape).tocsc(), path)


def _body_nodes(node, labels):
    """Number in the body of the node that has each label, of another node where none has."""
    order = np.argsort(labels)
    return order[np.searchsorted(labels, node, sorter=order).clip(max=len(labels) - 1)]


def _freedom(node, direction, labels):
    """Row in the body's matrices of a node's direction."""
    return 3 * _body_nodes(node, labels) + direction.astype(np.int64) - 1


def _faults_of_freedoms(node, direction, labels, path):
    """Sentences about the first node that is not the body's, the first that turns."""
    faults = []
    strange = np.flatnonzero(labels[_body_nodes(node, labels)] != node)
    turned = np.flatnonzero((direction < 1) | (direction > 3))
    if len(strange):
        at = strange[0]
        faults.append(
            f"{path.name}, entry {at + 1}: expected a node of the body, got {int(node[at])}"
        )
    if len(turned):
        at = turned[0]
        faults.append(
            f"{path.name}, entry {at + 1}: expected direction 1, 2 or 3, got {int(direction[at])} "
            f"of node {int(node[at])}"
        )
    return faults


def _dmig(path: Path) -> Entries:
    """Entries of the one DMIG matrix in a file.

    A header card reads DMIG, name, 0, form, type; a column card DMIG, name, node, direction, blank,
    then entries of four fields each: node, direction, value, blank. Continuations hold entries.
    """
    rows = []
    names = set()
    column = (0, 0)
    for number, (keyword, *fields) in _cards(path):
        try:
            if keyword == "DMIG":
                name, node, direction, *entries = fields
                names.add(name)
                if node in ("0", ""):  # the header
                    continue
                column = int(node), int(direction or 1)
                fields = entries[1:]
            for k in range(0, len(fields) - 2, 4):
                node, direction, value = fields[k : k + 3]
                if node:
                    rows.append((int(node), int(direction or 1), *column, _real(value)))
        except ValueError:
            what = f"expected a DMIG entry, got {','.join(fields)!r}"
            raise MeshFault([f"{path.name}, line {number}: {what}"]) from None
    if len(names) != 1 or not rows:
        present = ", ".join(sorted(names)) or "none"
        raise MeshFault([f"{path.name}: expected one DMIG matrix, got {present}"])
    return Entries(*np.array(rows, dtype=float).T)


def _cards(path: Path) -> Iterator[tuple[int, list[str]]]:
    """(line number, fields) of the DMIG entries and their continuations; the first field is DMIG or
    empty.
    """
    inside = False
    with open(path) as file:
        for number, line in enumerate(file, 1):
            line = line.split("$")[0].rstrip()
            head = line[:8].split(",")[0].strip().rstrip("*").upper()
            goes_on = inside and line != "" and (head == "" or head[0] in "+*")
            inside = head == "DMIG" or goes_on
            if not inside:
                continue
            if "," in line:
                fields = [part.strip() for part in line.split(",")]
            else:
                width = 16 if "*" in line[:8] else 8
                starts = range(8, min(len(line), 72), width)
                fields = ["", *(line[k : k + width].strip() for k in starts)]
            yield number, ["DMIG" if head == "DMIG" else "", *fields[1:]]


def _real(text):
    """A Nastran real: 1.5+3 and 1.5D+3 are 1.5e3."""
    return float(re.sub(r"(?<=[\d.])([+-]\d+)$", r"e\1", text.upper().replace("D", "E")))


def matrix_faults(mesh: Mesh, K: Sparse, M: Sparse, where: str) -> list[str]:
    """Sentences about matrices in SI that cannot be those of a loose solid body of metal: wrong
    units, order or supports.

    Eq. (M8):  K R = 0    R the six rigid motions
    Eq. (M9):  c ~ d sqrt(median K_ii/M_ii)      d the distance of neighbouring nodes,
                                                 c the speed of sound, some 5 km/s

    Parameters
    ----------
    mesh : Mesh
    K, M : scipy.sparse matrix, shape (3 n, 3 n)
        [N/m], [kg]
    where : str
        Begins each sentence.
    """
    from scipy.spatial import KDTree

    faults = []
    for name, matrix in (("stiffness", K), ("mass", M)):
        bad = np.flatnonzero(matrix.diagonal() <= 0.0)
        if len(bad):
            node, axis = divmod(int(bad[0]), 3)
            faults.append(
                f"{where}: expected a positive diagonal of the {name}, got {len(bad)} other "
                f"entries; the first is at node {node + 1} along {'xyz'[axis]}"
            )
    if faults:
        return faults
    rigid = rigid_motions(mesh.points - mesh.points.mean(axis=0))
    resisted = np.abs(K @ rigid).max(axis=0) / (abs(K) @ np.abs(rigid)).max(axis=0)  # Eq. (M8)
    if resisted.max() > 1e-5:
        faults.append(
            f"{where}: expected no resistance to rigid motions, got {resisted.max():.2g} of the "
            "stiffness; check the order of the rows"
        )
    distance, _ = KDTree(mesh.points).query(mesh.points, 2)
    near = np.median(distance[:, 1])
    speed = near * np.sqrt(np.median(K.diagonal() / M.diagonal()))  # Eq. (M9)
    if not 8e2 < speed < 8e4:
        faults.append(
            f"{where}: expected a speed of sound of 800 to 80000 m/s, got {speed:.2g} m/s; check "
            "stiffness_unit, mass_unit, mesh_unit"
        )
    mass = M.sum() / 3
    volume = np.prod(np.ptp(mesh.points, axis=0))
    if not 20.0 < mass / volume < 25e3:
        faults.append(
            f"{where}: expected 20 to 25000 kg/m3, got {mass / volume:.2g} kg/m3; check "
            "mass_unit, mesh_unit"
        )
    return faults
