"""Stiffness and mass matrices of a body: from elements, or from files of other programs."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from .element import Sparse, Value, consistent_mass, rigid_motions, stiffness
from .mesh import Mesh, MeshFault
from .nastran import cards

NASTRAN = (".bdf", ".dat", ".nas", ".pch", ".dmig")


class FullModel(NamedTuple):
    """Mesh of a body [m], its stiffness [N/m] and its mass [kg], matrices of shape (3 n, 3 n)."""

    mesh: Mesh
    K: Sparse
    M: Sparse


def assembled(mesh: Mesh, young: Value, poisson: Value, density: Value) -> FullModel:
    """Return a body from its elements: [Pa], [-], [kg/m3], of the body or of each element."""
    K = stiffness(mesh.points, mesh.tets, young, poisson)
    return FullModel(mesh, K, consistent_mass(mesh.points, mesh.tets, density))


class Entries(NamedTuple):
    """Entries of a matrix by nodes and directions 1 to 6, as arrays of floats, shape (n,)."""

    node: np.ndarray
    direction: np.ndarray
    other_node: np.ndarray
    other_direction: np.ndarray
    value: np.ndarray


def read_matrix(path: Path | str, labels: np.ndarray) -> Sparse:
    """Read a symmetric matrix for the displacements of a body's nodes.

    - Matrix Market (first line `%%MatrixMarket`) and Abaqus' coordinate format (three columns: row,
      column, value). Degrees of freedom are x, y, z of each node, in the order of the nodes' file.
    - Abaqus' matrix input and label formats (five columns: node, degree of freedom, node, degree of
      freedom, value).
    - Nastran DMIG in a punch or bulk data file with one matrix, in small, large or free fields.

    One triangle is sufficient. Entries of nodes that are not in `labels`, and of rotations, must be
    zero.

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
        The message contains the file and the first faulty row or node.
    """
    path = Path(path)
    n = len(labels)
    if path.suffix.lower() in NASTRAN:
        try:
            return _by_labels(_dmig(path), labels, path)
        except MeshFault as fault:
            raise fault.of_file(path.name) from None
    with open(path, encoding="ascii", errors="replace") as file:
        if file.readline().startswith("%%MatrixMarket"):
            from scipy.io import mmread

            return _whole(sp.coo_array(mmread(path)), n, path)
    table = _columns(path)
    if table.shape[1] == 5:
        return _by_labels(Entries(*table.T), labels, path)
    if table.shape[1] != 3:
        raise MeshFault(
            f"{path.name}: expected 3 or 5 columns, got {table.shape[1]}; write row, column, "
            "value or node, direction, node, direction, value"
        )
    row, column, value = table.T
    row = row.astype(np.int64) - 1
    column = column.astype(np.int64) - 1
    size = max(3 * n, row.max() + 1, column.max() + 1)
    return _whole(sp.coo_array((value, (row, column)), shape=(size, size)), n, path)


def _columns(path):
    """Return the numbers of a text file, (rows, columns), without lines that begin with `*`."""
    with open(path) as file:
        first = next((line for line in file if line.strip() and not line.startswith("*")), "")
    try:
        return np.loadtxt(path, comments="*", delimiter="," if "," in first else None, ndmin=2)
    except ValueError:
        raise MeshFault(f"{path.name}: expected rows of numbers, got other text") from None


def _whole(matrix, n, path):
    """Check the size, and complete a triangle."""
    if matrix.shape != (3 * n, 3 * n):
        raise MeshFault(
            f"{path.name}: expected {3 * n} rows for {n} nodes, got {matrix.shape[0]} x "
            f"{matrix.shape[1]}"
        )
    return _symmetric(matrix.tocsc(), path)


def _symmetric(matrix, path):
    """Return the matrix with both triangles; entries given in both must agree."""
    other = matrix.T.tocsc()
    here = sp.csc_matrix((np.ones(matrix.nnz), matrix.indices, matrix.indptr), shape=matrix.shape)
    both = other.multiply(here)
    difference = abs(matrix.multiply(here.T) - both).tocoo()
    if difference.nnz and difference.data.max() > 1e-8 * abs(matrix).max():
        at = difference.data.argmax()
        raise MeshFault(
            f"{path.name}: expected a symmetric matrix, got a difference of "
            f"{difference.data[at]:.3g} between rows {difference.row[at] + 1} and "
            f"{difference.col[at] + 1}"
        )
    return sp.csc_matrix(matrix + (other - both))


def _by_labels(entries: Entries, labels: np.ndarray, path: Path) -> Sparse:
    """Return the matrix of the entries that are not zero."""
    node, direction, other_node, other_direction, value = (
        column[entries.value != 0.0] for column in entries
    )
    row = _freedom(node, direction, labels, path)
    column = _freedom(other_node, other_direction, labels, path)
    shape = (3 * len(labels),) * 2
    return _symmetric(sp.coo_array((value, (row, column)), shape=shape).tocsc(), path)


def _freedom(node, direction, labels, path):
    """Return the row in the body's matrices of each node's direction."""
    order = np.argsort(labels)
    index = order[np.searchsorted(labels, node, sorter=order).clip(max=len(labels) - 1)]
    faults = []
    unknown = np.flatnonzero(labels[index] != node)
    rotations = np.flatnonzero((direction < 1) | (direction > 3))
    if len(unknown):
        at = unknown[0]
        faults.append(
            f"{path.name}, entry {at + 1}: expected a node of the body, got {int(node[at])}"
        )
    if len(rotations):
        at = rotations[0]
        faults.append(
            f"{path.name}, entry {at + 1}: expected direction 1, 2 or 3, got {int(direction[at])} "
            f"of node {int(node[at])}"
        )
    if faults:
        raise MeshFault(faults)
    return 3 * index + direction.astype(np.int64) - 1


def _dmig(path: Path) -> Entries:
    """Return the entries of the one DMIG matrix in a file.

    A header card reads DMIG, name, 0, form, type; a column card DMIG, name, node, direction, blank,
    then entries of four fields each: node, direction, value, blank.
    """
    rows = []
    names = set()
    for card in cards(path):
        if card.name == "DMIG":
            names.add(card.get(0))
            column = card.integer(1), card.integer(2) or 1
            for k in range(4, len(card.fields) if column[0] else 0, 4):
                if node := card.integer(k):
                    rows.append((node, card.integer(k + 1) or 1, *column, card.real(k + 2)))
    if len(names) != 1 or not rows:
        present = ", ".join(sorted(names)) or "none"
        raise MeshFault(f"{path.name}: expected one DMIG matrix, got {present}")
    return Entries(*np.array(rows, dtype=float).T)


def matrix_faults(mesh: Mesh, K: Sparse, M: Sparse, where: str) -> list[str]:
    """Return sentences about wrong units, order or supports in the matrices of a body.

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
