"""Faces of a body: triangles of 3 or 6 nodes, and integrals of pressure and motion over them."""

from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from skfem import ElementTriP1, ElementTriP2

from .element import Sparse


class ShapeFunctions(NamedTuple):
    """Shape functions of a triangle and their derivatives along s and t, each (q, nodes)."""

    value: np.ndarray
    ds: np.ndarray
    dt: np.ndarray


class FaceRule(NamedTuple):
    """Quadrature on faces.

    Parameters
    ----------
    value : ndarray, shape (q, nodes)
        Shape functions.
    weight : ndarray, shape (q,)
        Weights on the reference triangle.
    normal : ndarray, shape (t, q, 3)
        Normals times area [m2].
    """

    value: np.ndarray
    weight: np.ndarray
    normal: np.ndarray


def face_load(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return consistent nodal forces of a unit pressure on faces.

    Eq. (M6):  f_i = -int N_i n dA        faces ordered so that (X1-X0) x (X2-X0) points outwards

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        [m]
    triangles : ndarray of int, shape (t, 3 or 6)
        Corners, then perhaps the middles of edges 01, 12, 20.

    Returns
    -------
    ndarray, shape (n, 3)
        [N/Pa] = [m2]
    """
    rule = _face_rule(points, triangles)
    # Eq. (M6)
    parts = np.einsum("q,qi,tqa->tia", rule.weight, rule.value, rule.normal, optimize=True)
    load = np.zeros_like(points)
    np.subtract.at(load, triangles, parts)
    return load


def _face_rule(points: np.ndarray, triangles: np.ndarray) -> FaceRule:
    """Return a rule of 16 points on each face."""
    nodes, weights = np.polynomial.legendre.leggauss(4)
    a, b = np.meshgrid((nodes + 1) / 2, (nodes + 1) / 2, indexing="ij")
    s = a.ravel()
    t = ((1 - a) * b).ravel()
    weight = (np.outer(weights, weights) / 4 * (1 - a)).ravel()
    shape = triangle_functions(s, t, triangles.shape[1])
    corners = points[triangles]
    along_s = np.einsum("qi,tia->tqa", shape.ds, corners)
    along_t = np.einsum("qi,tia->tqa", shape.dt, corners)
    return FaceRule(shape.value, weight, np.cross(along_s, along_t))


def triangle_functions(s: np.ndarray, t: np.ndarray, nodes: int = 6) -> ShapeFunctions:
    """Return the shape functions of the triangle of 3 or 6 nodes at (s, t), each (q,)."""
    element = {3: ElementTriP1(), 6: ElementTriP2()}[nodes]
    values, slopes = zip(*(element.lbasis(np.stack([s, t]), k) for k in range(nodes)))
    value = np.stack(np.broadcast_arrays(*values), axis=-1)
    ds = np.stack([np.broadcast_to(slope[0], s.shape) for slope in slopes], axis=-1)
    dt = np.stack([np.broadcast_to(slope[1], s.shape) for slope in slopes], axis=-1)
    return ShapeFunctions(value, ds, dt)


def surface_matrix(points: np.ndarray, triangles: np.ndarray) -> Sparse:
    """Return area-weighted products of shape functions over faces.

    Eq. (M7):  A_ij = int N_i N_j dA      the sum of a row is the area of a node

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        [m]
    triangles : ndarray of int, shape (t, 3 or 6)

    Returns
    -------
    scipy.sparse.csc_matrix, shape (n, n)
        [m2]
    """
    rule = _face_rule(points, triangles)
    area = np.linalg.norm(rule.normal, axis=2) * rule.weight
    blocks = np.einsum("tq,qi,qj->tij", area, rule.value, rule.value, optimize=True)  # Eq. (M7)
    width = triangles.shape[1]
    rows = np.repeat(triangles, width, axis=1).ravel()
    columns = np.tile(triangles, (1, width)).ravel()
    return sp.csc_matrix((blocks.ravel(), (rows, columns)), shape=(len(points),) * 2)


def normal_products(points: np.ndarray, triangles: np.ndarray, shapes: np.ndarray) -> np.ndarray:
    """Return integrals over faces of products of the shapes' normal displacements.

    Eq. (M19):  R_kl = int (n phi_k) (n phi_l) dA

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        [m]
    triangles : ndarray of int, shape (t, 3 or 6)
    shapes : ndarray, shape (n, 3, k)

    Returns
    -------
    ndarray, shape (k, k)
        [m2] times the unit of the shapes squared.
    """
    rule = _face_rule(points, triangles)
    area = np.linalg.norm(rule.normal, axis=2)
    unit = rule.normal / area[..., None]
    # faces in pieces: all quadrature points of a large mesh at once are gigabytes
    out = np.zeros((shapes.shape[2],) * 2)
    for part in np.array_split(np.arange(len(triangles)), len(triangles) // 1000 + 1):
        normal = np.einsum(
            "qi,tqa,tiak->tqk", rule.value, unit[part], shapes[triangles[part]], optimize=True
        )
        flat = (normal * np.sqrt(area[part] * rule.weight)[..., None]).reshape(-1, len(out))
        out += flat.T @ flat  # Eq. (M19)
    return out
