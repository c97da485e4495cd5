"""Ten-node tetrahedron: stiffness, consistent mass and stress of linear isotropic elasticity,
assembled by scikit-fem.
"""

import numpy as np
import scipy.sparse as sp
from scipy.special import roots_jacobi
from skfem import Basis, BilinearForm, ElementTetP2, MeshTet2

EDGES = np.array([[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]])
NODES = ElementTetP2.doflocs
"""Reference coordinates of the ten nodes, shape (10, 3): corners, then the middles of `EDGES`."""
PART = 50_000  # elements assembled at a time: bounds the memory of large bodies


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

    References ---------- [Stroud1971], conical products of Gauss-Jacobi rules. Checked in
    tests/mfbd/test_finite_element.py.
    """
    rules = [roots_jacobi(points_a_side, power, 0.0) for power in (2.0, 1.0, 0.0)]
    (a, wa), (b, wb), (c, wc) = [
        ((x + 1) / 2, w / 2 ** (power + 1)) for (x, w), power in zip(rules, (2, 1, 0))
    ]
    a, b, c = np.meshgrid(a, b, c, indexing="ij")
    weight = wa[:, None, None] * wb[None, :, None] * wc[None, None, :]
    return np.stack([a, (1 - a) * b, (1 - a) * (1 - b) * c], axis=-1).reshape(-1, 3), weight.ravel()


def element_basis(points, tets, position, weight):
    """Basis of scikit-fem on isoparametric ten-node tetrahedra.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Node positions [m].
    tets : ndarray of int, shape (e, 10)
        Corners, then edge nodes in the order of `EDGES`; every node belongs to an element.
    position, weight : ndarray, shapes (q, 3), (q,)
        Quadrature rule. The tabulated rules of scikit-fem 12 above degree 4 miss the last degree
        they claim.

    Returns
    -------
    Basis
        Of one displacement component.
    place : ndarray of int, shape (n,)
        Number in the basis of each node.
    """
    mesh = MeshTet2(np.ascontiguousarray(points.T), np.ascontiguousarray(tets.T))
    basis = Basis(mesh, ElementTetP2(), quadrature=(position.T, weight))
    place = np.empty(len(points), dtype=np.int64)
    place[tets.T] = basis.element_dofs
    return basis, place


def stiffness(points, tets, young, poisson):
    """Stiffness matrix of isotropic linear elasticity.

    Eq. (F1):  K_(ia)(jb) = lambda D^ab_ij + mu D^ba_ij + mu delta_ab D^cc_ij,   D^ab_ij = int N_i,a N_j,b dV
               lambda = E nu / ((1+nu)(1-2nu)),  mu = E / (2 (1+nu))

    Degrees of freedom are ordered x, y, z of node 0, then of node 1, and so on. Quadrature of
    degree 5: exact on straight-edged elements (degree 2), on curved ones far inside the error of
    the elements. Six scalar forms instead of one of vectors: it takes a twelfth of the time.

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
    [Bathe2014] ch. 5. Checked against FElupe in tests/verification/test_mfbd.py.
    """
    lame, shear = lame_constants(young, poisson)
    pairs = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)]
    forms = [lambda u, v, w, a=a, b=b: v.grad[a] * u.grad[b] for a, b in pairs]
    D = dict(zip(pairs, _assemble(points, tets, 3, forms)))
    D |= {(b, a): D[a, b].T for a, b in pairs if a != b}
    laplace = D[0, 0] + D[1, 1] + D[2, 2]
    blocks = [
        [
            lame * D[a, b] + shear * (D[b, a] + laplace if a == b else D[b, a]) for b in range(3)
        ]  # Eq. (F1)
        for a in range(3)
    ]
    by_node = (np.arange(len(points))[:, None] + len(points) * np.arange(3)).ravel()
    return sp.block_array(blocks, format="csr")[by_node].tocsc()[:, by_node]


def lame_constants(young, poisson):
    """lambda and mu [Pa] from Young's modulus [Pa] and Poisson's ratio [-]."""
    return young * poisson / ((1 + poisson) * (1 - 2 * poisson)), young / (2 * (1 + poisson))


def consistent_mass(points, tets, density):
    """Consistent mass matrix.

    Eq. (F2):  M_(ia)(jb) = delta_ab int rho N_i N_j dV

    Quadrature of degree 7: exact for N_i N_j (degree 4) times the Jacobian determinant of a curved
    element (degree 3).

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Node positions [m].
    tets : ndarray of int, shape (e, 10)
    density : float
        [kg/m3]

    Returns
    -------
    scipy.sparse.csc_matrix, shape (3 n, 3 n)
        [kg]; ordered as the stiffness.
    """
    return each_direction(
        _assemble(points, tets, 4, [lambda u, v, w: density * u * v])[0]
    )  # Eq. (F2)


def each_direction(scalar):
    """Matrix of one displacement component (n, n) -> the same for all three (3 n, 3 n)."""
    return sp.kron(scalar, sp.identity(3), format="csc")


def _assemble(points, tets, points_a_side, forms):
    """Matrices of scalar bilinear forms, each (n, n) in the order of the nodes."""
    totals = [sp.csr_matrix((len(points),) * 2)] * len(forms)
    for part in np.array_split(tets, -(-len(tets) // PART)):
        used, inside = np.unique(part, return_inverse=True)
        basis, place = element_basis(
            points[used], inside.reshape(part.shape), *quadrature(points_a_side)
        )
        for k, form in enumerate(forms):
            found = BilinearForm(form).assemble(basis)[place][:, place].tocoo()
            totals[k] = totals[k] + sp.csr_matrix(
                (found.data, (used[found.row], used[found.col])), shape=totals[k].shape
            )
    return totals


def jacobian_determinants(points, tets, position):
    """Determinant of the isoparametric map of each element at reference positions (q, 3), shape (e,
    q) [m3]; positive in a sound element.
    """
    basis, _ = element_basis(points, tets, NODES[:1], np.ones(1))
    return basis.mesh.mapping().detDF(position.T)


def nodal_stress(points, tets, displacement, young, poisson):
    """Stress at the nodes, the mean of the values in the elements that meet there.

    Eq. (F5):  sigma = lambda tr(eps) 1 + 2 mu eps,   eps = (grad u + grad u^T)/2

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
    lame, shear = lame_constants(young, poisson)
    basis, place = element_basis(points, tets, NODES, np.ones(len(NODES)))
    nodal = np.empty_like(displacement)
    nodal[place] = displacement
    slope = np.stack([basis.interpolate(component).grad for component in nodal.T])  # (a, b, e, 10)
    strain = (slope + slope.swapaxes(0, 1)) / 2
    stress = 2 * shear * strain + lame * np.trace(strain) * np.eye(3)[:, :, None, None]  # Eq. (F5)
    count = np.bincount(tets.ravel(), minlength=len(points))
    return np.stack(
        [
            np.bincount(tets.ravel(), stress[a, b].ravel(), len(points)) / count
            for a, b in zip((0, 1, 2, 0, 1, 2), (0, 1, 2, 1, 2, 0))
        ],
        axis=1,
    )


def von_mises(stress):
    """Equivalent stress of (n, 6) stresses xx, yy, zz, xy, yz, zx [Pa]."""
    xx, yy, zz, xy, yz, zx = stress.T
    return np.sqrt(
        ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * (xy**2 + yz**2 + zx**2)
    )


def rigid_motions(points):
    """Six rigid-body motions about the origin: translations along x, y, z, rotations about them, (3
    n, 6).
    """
    out = np.zeros((len(points), 3, 6))
    out[:, :, :3] = np.eye(3)
    for axis in range(3):
        out[:, :, 3 + axis] = np.cross(np.eye(3)[axis], points)
    return out.reshape(-1, 6)
