"""Faces of a body: triangles of 3 or 6 nodes, their shape functions, pressure on them, their area
at the nodes.
"""

import numpy as np
import scipy.sparse as sp
from skfem import ElementTriP1, ElementTriP2


def face_load(points, triangles, pressure_sign=-1.0):
    """Consistent nodal forces of a unit pressure on faces, following the outward normal.

    Eq. (F3):  f_i = -int N_i n dA        faces ordered so that (X1-X0) x (X2-X0) points out of the body

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    triangles : ndarray of int, shape (t, 3 or 6)
        Corners, then perhaps the middles of edges 01, 12, 20.
    pressure_sign : float
        -1 for a pressure that pushes into the body, +1 along the outward normal.

    Returns
    -------
    ndarray, shape (n, 3)
        [N/Pa] = [m2]
    """
    value, weight, normal = _face_rule(points, triangles)
    load = np.zeros_like(points)
    np.add.at(
        load,
        triangles,
        pressure_sign * np.einsum("q,qi,tqa->tia", weight, value, normal, optimize=True),
    )  # Eq. (F3)
    return load


def _face_rule(points, triangles):
    """Shape functions (q, nodes) and weights (q,) of a rule on the reference triangle, and normals
    times area (t, q, 3) [m2].
    """
    nodes, weights = np.polynomial.legendre.leggauss(4)
    a, b = np.meshgrid((nodes + 1) / 2, (nodes + 1) / 2, indexing="ij")
    s, t, weight = (
        a.ravel(),
        ((1 - a) * b).ravel(),
        (np.outer(weights, weights) / 4 * (1 - a)).ravel(),
    )
    value, ds, dt = triangle_functions(s, t, triangles.shape[1])
    corners = points[triangles]
    return (
        value,
        weight,
        np.cross(np.einsum("qi,tia->tqa", ds, corners), np.einsum("qi,tia->tqa", dt, corners)),
    )


def triangle_functions(s, t, nodes=6):
    """Shape functions of the triangle of 3 or 6 nodes and their derivatives along s and t, each of
    shape (q, nodes).
    """
    element = {3: ElementTriP1(), 6: ElementTriP2()}[nodes]
    values, slopes = zip(*(element.lbasis(np.stack([s, t]), k) for k in range(nodes)))
    value = np.stack(np.broadcast_arrays(*values), axis=-1)
    ds, dt = (
        np.stack([np.broadcast_to(slope[axis], s.shape) for slope in slopes], axis=-1)
        for axis in (0, 1)
    )
    return value, ds, dt


def surface_matrix(points, triangles):
    """Area-weighted products of shape functions over faces.

    Eq. (F4):  A_ij = int N_i N_j dA      its rows add up to the area that belongs to a node

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    triangles : ndarray of int, shape (t, 3 or 6)

    Returns
    -------
    scipy.sparse.csc_matrix, shape (n, n)
        [m2]
    """
    value, weight, normal = _face_rule(points, triangles)
    area = np.linalg.norm(normal, axis=2) * weight
    blocks, width = (
        np.einsum("tq,qi,qj->tij", area, value, value, optimize=True),
        triangles.shape[1],
    )  # Eq. (F4)
    rows, columns = (
        np.repeat(triangles, width, axis=1).ravel(),
        np.tile(triangles, (1, width)).ravel(),
    )
    return sp.csc_matrix((blocks.ravel(), (rows, columns)), shape=(len(points),) * 2)
