"""Ten-node tetrahedron: shape functions, stiffness and consistent mass of linear isotropic elasticity."""

import numpy as np
import scipy.sparse as sp
from scipy.special import roots_jacobi

EDGES = np.array([[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]])


def quadrature(points_a_side):
    """Conical product rule on the reference tetrahedron (0,0,0), (1,0,0), (0,1,0), (0,0,1).

    Exact for polynomials of degree 2 n - 1 with n points a side.

    Parameters
    ----------
    points_a_side : int
        n >= 1.

    Returns
    -------
    position : ndarray, shape (n^3, 3)
        Reference coordinates [-].
    weight : ndarray, shape (n^3,)
        Their sum is 1/6, the reference volume.

    References
    ----------
    [Stroud1971], conical products of Gauss-Jacobi rules. Checked in tests/mfbd/test_finite_element.py.
    """
    rules = [roots_jacobi(points_a_side, power, 0.0) for power in (2.0, 1.0, 0.0)]
    (a, wa), (b, wb), (c, wc) = [((x + 1) / 2, w / 2 ** (power + 1)) for (x, w), power in zip(rules, (2, 1, 0))]
    a, b, c = np.meshgrid(a, b, c, indexing="ij")
    weight = wa[:, None, None] * wb[None, :, None] * wc[None, None, :]
    return np.stack([a, (1 - a) * b, (1 - a) * (1 - b) * c], axis=-1).reshape(-1, 3), weight.ravel()


def shape_functions(position):
    """Shape functions and reference gradients of the 10-node tetrahedron.

    Eq. (F1):  N_k = L_k (2 L_k - 1) at the corners,  N_m = 4 L_i L_j at the middle of edge ij     edges 01 12 02 03 13 23

    Parameters
    ----------
    position : ndarray, shape (q, 3)
        Reference coordinates [-].

    Returns
    -------
    value : ndarray, shape (q, 10)
    gradient : ndarray, shape (q, 10, 3)
    """
    corner = np.column_stack([1.0 - position.sum(axis=1), position])
    slope = np.vstack([-np.ones(3), np.eye(3)])
    i, j = EDGES.T
    value = np.hstack([corner * (2 * corner - 1), 4 * corner[:, i] * corner[:, j]])                       # Eq. (F1)
    gradient = np.concatenate([(4 * corner - 1)[:, :, None] * slope,
                               4 * (corner[:, i, None] * slope[j] + corner[:, j, None] * slope[i])], axis=1)
    return value, gradient


def jacobians(points, tets, gradient):
    """Isoparametric map dX/dxi and its determinant, shapes (e, q, 3, 3) and (e, q); the determinant is positive in a sound
    element."""
    map_ = np.einsum("eia,qib->eqab", points[tets], gradient, optimize=True)
    return map_, np.linalg.det(map_)


def stiffness(points, tets, young, poisson):
    """Stiffness matrix of isotropic linear elasticity.

    Eq. (F2):  K_(ia)(jb) = int lambda N_i,a N_j,b + mu N_i,b N_j,a + mu delta_ab N_i,c N_j,c dV
               lambda = E nu / ((1+nu)(1-2nu)),  mu = E / (2 (1+nu))

    Degrees of freedom are ordered x, y, z of node 0, then of node 1, and so on. Quadrature of degree 5: exact on straight-edged
    elements (degree 2), on curved ones far inside the error of the elements.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Node positions [m].
    tets : ndarray of int, shape (e, 10)
        Corners, then edge nodes in the order of `EDGES`.
    young, poisson : float
        Young's modulus [Pa] and Poisson's ratio [-], 0 <= nu < 0.5.

    Returns
    -------
    scipy.sparse.csc_matrix, shape (3 n, 3 n)
        [N/m], symmetric, six rigid-body motions in its null space.

    References
    ----------
    [Bathe2014] ch. 5. Checked against scikit-fem in tests/verification/test_mfbd.py.
    """
    lame, shear = young * poisson / ((1 + poisson) * (1 - 2 * poisson)), young / (2 * (1 + poisson))
    position, weight = quadrature(3)
    _, reference = shape_functions(position)
    blocks = []
    for part in np.array_split(tets, max(1, len(tets) // 2000)):
        map_, volume = jacobians(points, part, reference)
        slope = np.einsum("qib,eqba->eqia", reference, np.linalg.inv(map_), optimize=True)
        scaled = slope * (volume * weight)[:, :, None, None]
        # D[e, i, a, j, b] = int N_i,a N_j,b dV, one matrix product an element
        product = np.matmul(scaled.reshape(len(part), len(weight), 30).transpose(0, 2, 1),
                            slope.reshape(len(part), len(weight), 30)).reshape(-1, 10, 3, 10, 3)
        block = lame * product + shear * product.transpose(0, 1, 4, 3, 2)                                 # Eq. (F2)
        block[:, :, range(3), :, range(3)] += shear * np.einsum("eicjc->eij", product)
        blocks.append(block.reshape(-1, 30, 30))
    dofs = (3 * tets[:, :, None] + np.arange(3)).reshape(-1, 30)
    return scatter(np.concatenate(blocks), dofs, 3 * len(points))


def consistent_mass(points, tets, density):
    """Consistent mass matrix of one displacement component; the full one is its Kronecker product with the 3 x 3 identity.

    Eq. (F3):  M_ij = int rho N_i N_j dV

    Quadrature of degree 7: exact for N_i N_j (degree 4) times the Jacobian determinant of a curved element (degree 3).

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Node positions [m].
    tets : ndarray of int, shape (e, 10)
    density : float
        [kg/m3]

    Returns
    -------
    scipy.sparse.csc_matrix, shape (n, n)
        [kg]; all entries add up to the mass of the body.
    """
    position, weight = quadrature(4)
    value, reference = shape_functions(position)
    pairs = (value[:, :, None] * value[:, None, :]).reshape(len(weight), 100)
    blocks = [((jacobians(points, part, reference)[1] * (density * weight)) @ pairs).reshape(-1, 10, 10)  # Eq. (F3)
              for part in np.array_split(tets, max(1, len(tets) // 2000))]
    return scatter(np.concatenate(blocks), tets, len(points))


def scatter(blocks, dofs, size):
    """Sum element matrices (e, k, k) into a sparse matrix by their degrees of freedom (e, k)."""
    width = dofs.shape[1]
    rows, columns = np.repeat(dofs, width, axis=1).ravel(), np.tile(dofs, (1, width)).ravel()
    return sp.coo_matrix((blocks.ravel(), (rows, columns)), shape=(size, size)).tocsc()


def face_load(points, triangles, pressure_sign=-1.0):
    """Consistent nodal forces of a unit pressure on 6-node faces, following the outward normal.

    Eq. (F4):  f_i = -int N_i n dA        faces ordered so that (X1-X0) x (X2-X0) points out of the body

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    triangles : ndarray of int, shape (t, 6)
        Corners, then the middles of edges 01, 12, 20.
    pressure_sign : float
        -1 for a pressure that pushes into the body, +1 along the outward normal.

    Returns
    -------
    ndarray, shape (n, 3)
        [N/Pa] = [m2]
    """
    value, weight, normal = _face_rule(points, triangles)
    load = np.zeros_like(points)
    np.add.at(load, triangles, pressure_sign * np.einsum("q,qi,tqa->tia", weight, value, normal, optimize=True))  # Eq. (F4)
    return load


def _face_rule(points, triangles):
    """Shape functions (q, 6) and weights (q,) of a rule on the reference triangle, and normals times area (t, q, 3) [m2]."""
    nodes, weights = np.polynomial.legendre.leggauss(4)
    a, b = np.meshgrid((nodes + 1) / 2, (nodes + 1) / 2, indexing="ij")
    s, t, weight = a.ravel(), ((1 - a) * b).ravel(), (np.outer(weights, weights) / 4 * (1 - a)).ravel()
    value, ds, dt = triangle_functions(s, t)
    corners = points[triangles]
    return value, weight, np.cross(np.einsum("qi,tia->tqa", ds, corners), np.einsum("qi,tia->tqa", dt, corners))


def triangle_functions(s, t):
    """Shape functions of the 6-node triangle and their derivatives along s and t, each of shape (q, 6)."""
    r = 1.0 - s - t
    zero = np.zeros_like(s)
    value = np.stack([r * (2 * r - 1), s * (2 * s - 1), t * (2 * t - 1), 4 * r * s, 4 * s * t, 4 * t * r], axis=-1)
    ds = np.stack([1 - 4 * r, 4 * s - 1, zero, 4 * (r - s), 4 * t, -4 * t], axis=-1)
    dt = np.stack([1 - 4 * r, zero, 4 * t - 1, -4 * s, 4 * s, 4 * (r - t)], axis=-1)
    return value, ds, dt


def surface_matrix(points, triangles):
    """Area-weighted products of shape functions over 6-node faces.

    Eq. (F5):  A_ij = int N_i N_j dA      its rows add up to the area that belongs to a node

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    triangles : ndarray of int, shape (t, 6)

    Returns
    -------
    scipy.sparse.csc_matrix, shape (n, n)
        [m2]
    """
    value, weight, normal = _face_rule(points, triangles)
    area = np.linalg.norm(normal, axis=2) * weight
    return scatter(np.einsum("tq,qi,qj->tij", area, value, value, optimize=True), triangles, len(points))       # Eq. (F5)


CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
NODES = np.vstack([CORNERS, CORNERS[EDGES].mean(axis=1)])
"""Reference coordinates of the ten nodes."""


def nodal_stress(points, tets, displacement, young, poisson):
    """Stress at the nodes, the mean of the values in the elements that meet there.

    Eq. (F6):  sigma = lambda tr(eps) 1 + 2 mu eps,   eps = (grad u + grad u^T)/2

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        [m]
    tets : ndarray of int, shape (e, 10)
    displacement : ndarray, shape (n, 3)
        [m]
    young, poisson : float
        [Pa], [-]

    Returns
    -------
    ndarray, shape (n, 6)
        xx, yy, zz, xy, yz, zx [Pa]. The jump between elements, not shown, is the error of the mesh.
    """
    lame, shear = young * poisson / ((1 + poisson) * (1 - 2 * poisson)), young / (2 * (1 + poisson))
    _, reference = shape_functions(NODES)
    map_, _ = jacobians(points, tets, reference)
    slope = np.einsum("eqib,eia->eqab", np.einsum("qib,eqba->eqia", reference, np.linalg.inv(map_), optimize=True),
                      displacement[tets],
                      optimize=True)
    strain = (slope + slope.swapaxes(2, 3)) / 2
    stress = 2 * shear * strain + lame * np.trace(strain, axis1=2, axis2=3)[:, :, None, None] * np.eye(3)         # Eq. (F6)
    total, count = np.zeros((len(points), 6)), np.bincount(tets.ravel(), minlength=len(points))
    np.add.at(total, tets, stress[:, :, [0, 1, 2, 0, 1, 2], [0, 1, 2, 1, 2, 0]])
    return total / count[:, None]


def von_mises(stress):
    """Equivalent stress of (n, 6) stresses xx, yy, zz, xy, yz, zx [Pa]."""
    xx, yy, zz, xy, yz, zx = stress.T
    return np.sqrt(((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * (xy**2 + yz**2 + zx**2))
