"""Connections of the elements of a mesh: outer faces, and faults."""

from pathlib import Path

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from .element import NODES, jacobian_determinants, quadrature

FACES = np.array([[0, 2, 1, 6, 5, 4], [0, 1, 3, 4, 8, 7], [1, 2, 3, 5, 9, 8], [0, 3, 2, 7, 9, 6]])
"""Nodes of a tetrahedron's four faces: corners, then the middles of their edges 01, 12, 20."""
COINCIDENT = 1e-3
"""Faces coincide if their corners differ by less than this share of the shortest edge."""


def outer_faces(tets: np.ndarray) -> np.ndarray:
    """Return the 6-node faces of one tetrahedron only, (t, 6), with outward normals."""
    faces = tets[:, FACES].reshape(-1, 6)
    corners = np.sort(faces[:, :3], axis=1)
    _, first, count = np.unique(corners, axis=0, return_index=True, return_counts=True)
    return faces[np.sort(first[count == 1])]


def aspect_ratios(points: np.ndarray, tets: np.ndarray) -> np.ndarray:
    """Return the aspect ratio of each tetrahedron by its corners, shape (e,).

    Eq. (M20):  q = sqrt(2/3) l_max / h_min,   h_min = 3 V / A_max      1 for a regular one

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        [m]
    tets : ndarray of int, shape (e, 4 or 10)
    """
    corner = points[tets[:, :4]]
    sides = corner[:, FACES[:, :3]]  # (e, 4 faces, 3 corners, 3)
    first, second = sides[:, :, 1] - sides[:, :, 0], sides[:, :, 2] - sides[:, :, 0]
    area = np.linalg.norm(np.cross(first, second), axis=2).max(axis=1) / 2
    volume = np.abs(np.einsum("ea,ea->e", first[:, 0], np.cross(second[:, 0], second[:, 1]))) / 6
    edges = np.linalg.norm(corner[:, :, None] - corner[:, None], axis=3).max(axis=(1, 2))
    with np.errstate(divide="ignore"):
        return np.sqrt(2 / 3) * edges * area / (3 * volume)  # Eq. (M20)


def mesh_faults(points: np.ndarray, tets: np.ndarray, where: Path | str) -> list[str]:
    """Return the faults of a mesh, one sentence each.

    Faults are an absurd size, elements inverted at an integration point of the stiffness, duplicate
    elements, outer faces that coincide, and pieces
    that are not connected through faces.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        [m]
    tets : ndarray of int, shape (e, 10)
    where : Path or str
        Begins each sentence.
    """
    faults = []
    size = float(np.ptp(points, axis=0).max())
    if not 5e-3 < size < 5.0:
        faults.append(
            f"expected a body of 5 mm to 5 m, got {size:.3g} m; set mesh_unit, for example '1 mm'"
        )
    least = jacobian_determinants(points, tets, quadrature(3).position).min(axis=1)
    bad = np.flatnonzero(least <= 0.0)
    if len(bad):
        faults.append(
            f"expected positive Jacobians, got {len(bad)} inverted elements; the first is number "
            f"{bad[0] + 1} at {_place(points[tets[bad[0], :4]])} with a Jacobian of "
            f"{least[bad[0]]:.3g} m3"
        )
    faults += _duplicates(points, tets) or [
        *_loose_pieces(points, tets),
        *_coincident(points, outer_faces(tets)),
    ]
    return [f"{where}: {fault}" for fault in faults]


def corner_remarks(points: np.ndarray, tets: np.ndarray) -> list[str]:
    """Return a warning about elements whose Jacobian is not positive at a corner.

    Their matrices are valid if the Jacobian is positive at the integration points of the stiffness.
    Stresses at such a corner are not.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        [m]
    tets : ndarray of int, shape (e, 10)
    """
    jacobian = jacobian_determinants(points, tets, NODES[:4])
    bad = np.flatnonzero(jacobian.min(axis=1) <= 0.0)
    if not len(bad):
        return []
    corner = tets[bad[0], [jacobian[bad[0]].argmin()]]
    return [
        f"{len(bad)} elements with a negative Jacobian at a corner; stresses there are wrong; "
        f"the first is number {bad[0] + 1}, its corner is at {_place(points[corner])}"
    ]


def _place(corners):
    """Return the centre of points as text."""
    x, y, z = corners.mean(axis=0)
    return f"({x:.4g}, {y:.4g}, {z:.4g}) m"


def _duplicates(points, tets):
    """Return a fault if elements have the same corners."""
    corners = np.sort(tets[:, :4], axis=1)
    _, first = np.unique(corners, axis=0, return_index=True)
    copies = np.setdiff1d(np.arange(len(tets)), first)
    if not len(copies):
        return []
    return [
        f"expected different elements, got {len(copies)} duplicates; remove them, the first is "
        f"number {copies[0] + 1} at {_place(points[tets[copies[0], :4]])}"
    ]


def _coincident(points, outer):
    """Return a fault if outer faces are at the same place: a crack between nodes not merged."""
    corner = points[outer[:, :3]]
    edges = np.linalg.norm(corner - np.roll(corner, 1, axis=1), axis=2)
    near = COINCIDENT * float(edges.min())
    pairs = KDTree(corner.mean(axis=1)).query_pairs(near, output_type="ndarray")
    one, other = corner[pairs[:, 0]], corner[pairs[:, 1]]
    distance = np.linalg.norm(one[:, :, None] - other[:, None], axis=3).min(axis=2).max(axis=1)
    pairs = pairs[distance < 2 * near]
    if not len(pairs):
        return []
    return [
        f"expected no crack, got {len(pairs)} pairs of coincident outer faces at "
        f"{_place(corner[pairs[0, 0]])}; merge coincident nodes"
    ]


def _loose_pieces(points, tets):
    """Return a fault if the elements are not all connected through faces."""
    corners = np.sort(tets[:, FACES[:, :3]].reshape(-1, 3), axis=1)
    order = np.lexsort(corners.T)
    shared = np.flatnonzero((corners[order[1:]] == corners[order[:-1]]).all(axis=1))
    one, other = order[shared] // 4, order[shared + 1] // 4
    graph = coo_matrix((np.ones(len(one)), (one, other)), shape=(len(tets),) * 2)
    pieces, piece = connected_components(graph, directed=False)
    if pieces == 1:
        return []
    sizes = ", ".join(str(n) for n in sorted(np.bincount(piece), reverse=True)[:6])
    low, high = np.full(len(points), pieces), np.full(len(points), -1)
    np.minimum.at(low, tets, piece[:, None])
    np.maximum.at(high, tets, piece[:, None])
    joints = np.flatnonzero(high > low)
    if not len(joints):
        return [
            f"expected one body, got {pieces} unconnected pieces of {sizes} elements; merge "
            "coincident nodes"
        ]
    return [
        f"expected elements connected through faces, got {pieces} pieces of {sizes} elements with "
        f"{len(joints)} common nodes at {_place(points[joints[:1]])}; merge coincident nodes"
    ]
