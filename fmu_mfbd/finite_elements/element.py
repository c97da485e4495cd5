"""Ten-node tetrahedron of linear isotropic elasticity: stiffness, consistent mass and stress.

scikit-fem assembles the matrices and supplies the shape functions.
"""

from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import scipy.sparse as sp
from scipy.special import roots_jacobi
from skfem import Basis, BilinearForm, ElementTetP2, MeshTet2

EDGES = np.array([[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]])
Sparse: TypeAlias = Any
"""Sparse matrix; scipy has no types for it."""
Value: TypeAlias = float | np.ndarray
"""Property of a material: of the whole body, or of each element, (e,)."""
NODES = ElementTetP2.doflocs
"""Reference coordinates of the ten nodes, shape (10, 3): corners, then the middles of `EDGES`."""
CORNERS = 4
COMPONENTS = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)]
"""Components of a stress tensor in the order xx, yy, zz, xy, yz, zx."""
ELEMENTS_AT_ONCE = 50_000  # elements assembled at a time: bounds the memory of large bodies


class Quadrature(NamedTuple):
    """Rule on the reference tetrahedron.

    Parameters
    ----------
    position : ndarray, shape (q, 3)
        Reference coordinates [-].
    weight : ndarray, shape (q,)
        Their sum is 1/6, the reference volume.
    """

    position: np.ndarray
    weight: np.ndarray


class NodalBasis(NamedTuple):
    """Basis of scikit-fem for one displacement component, and its degree of freedom of each node.

    Parameters
    ----------
    basis : Basis
    number : ndarray of int, shape (n,)
    """

    basis: Basis
    number: np.ndarray


class MassProperties(NamedTuple):
    """Mass properties of a body.

    Parameters
    ----------
    mass : float
        [kg]
    centre : ndarray, shape (3,)
        Centre of mass from the body's origin [m].
    inertia : ndarray, shape (3, 3)
        Inertia about the centre of mass [kg m2].
    """

    mass: float
    centre: np.ndarray
    inertia: np.ndarray


class Lame(NamedTuple):
    """Lame's constants lambda and mu [Pa]."""

    first: float
    shear: float


def quadrature(points_a_side: int) -> Quadrature:
    """Return the conical product rule on the tetrahedron (0,0,0), (1,0,0), (0,1,0), (0,0,1).

    With n points on each side, it is exact for polynomials of degree 2 n - 1.

    Parameters
    ----------
    points_a_side : int
        n >= 1.

    Returns
    -------
    Quadrature
        n^3 points.

    References
    ----------
    [Stroud1971], conical products of Gauss-Jacobi rules. Checked in
    tests/mfbd/test_finite_element.py.
    """
    a, weight_a = _jacobi_rule(points_a_side, 2)
    b, weight_b = _jacobi_rule(points_a_side, 1)
    c, weight_c = _jacobi_rule(points_a_side, 0)
    a, b, c = np.meshgrid(a, b, c, indexing="ij")
    position = np.stack([a, (1 - a) * b, (1 - a) * (1 - b) * c], axis=-1)
    weight = weight_a[:, None, None] * weight_b[None, :, None] * weight_c[None, None, :]
    return Quadrature(position.reshape(-1, 3), weight.ravel())


def _jacobi_rule(points, power):
    """Return points and weights of a Gauss rule on 0 to 1 for the weight (1 - x)^power."""
    x, weight = roots_jacobi(points, float(power), 0.0)
    return (x + 1) / 2, weight / 2 ** (power + 1)


def element_basis(points: np.ndarray, tets: np.ndarray, rule: Quadrature) -> NodalBasis:
    """Return a basis of scikit-fem on isoparametric ten-node tetrahedra.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Node positions [m].
    tets : ndarray of int, shape (e, 10)
        Corners, then edge nodes in the order of `EDGES`; every node belongs to an element.
    rule : Quadrature
        The tables of scikit-fem 12 above degree 4 are not exact for the degree that they state.
    """
    mesh = MeshTet2(np.ascontiguousarray(points.T), np.ascontiguousarray(tets.T))
    basis = Basis(mesh, ElementTetP2(), quadrature=(rule.position.T, rule.weight))
    number = np.empty(len(points), dtype=np.int64)
    number[tets.T] = basis.element_dofs
    return NodalBasis(basis, number)


def stiffness(points: np.ndarray, tets: np.ndarray, young: Value, poisson: Value) -> Sparse:
    """Return the stiffness matrix of isotropic linear elasticity.

    Elements of different materials are assembled separately and added.

    Eq. (M1):  K_(ia)(jb) = lambda D^ab_ij + mu D^ba_ij + mu delta_ab D^cc_ij,
               D^ab_ij = int N_i,a N_j,b dV,  lambda and mu by Eq. (M2)

    Degrees of freedom are ordered x, y, z of node 0, then of node 1, and so on. The quadrature has
    degree 5 and is exact on straight-edged elements (degree 2). On curved elements its error is
    far smaller than that of the elements. Scalar forms are faster than one form of vectors.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Node positions [m].
    tets : ndarray of int, shape (e, 10)
        Corners, then edge nodes in the order of `EDGES`.
    young, poisson : float or ndarray, shape (e,)
        Young's modulus [Pa] and Poisson's ratio [-], 0 <= nu < 0.5, of the body or of each element.

    Returns
    -------
    scipy.sparse.csc_matrix, shape (3 n, 3 n)
        [N/m], symmetric, six rigid-body motions in its null space.

    References
    ----------
    [Bathe2014] ch. 5. Checked against FElupe in tests/verification/test_mfbd.py.
    """
    parts = by_material(len(tets), young, poisson)
    return _sum(_stiffness(points, tets[rows], lame_constants(*values)) for rows, values in parts)


def _stiffness(points: np.ndarray, tets: np.ndarray, lame: Lame) -> Sparse:
    """Return the stiffness matrix of elements of one material."""
    pairs = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)]
    forms = [lambda u, v, w, a=a, b=b: v.grad[a] * u.grad[b] for a, b in pairs]
    D = dict(zip(pairs, _assemble(points, tets, 3, forms)))
    D |= {(b, a): D[a, b].T for a, b in pairs if a != b}
    laplace = D[0, 0] + D[1, 1] + D[2, 2]

    def block(a, b):
        transverse = D[b, a] + laplace if a == b else D[b, a]
        return lame.first * D[a, b] + lame.shear * transverse  # Eq. (M1)

    blocks = [[block(a, b) for b in range(3)] for a in range(3)]
    by_node = (np.arange(len(points))[:, None] + len(points) * np.arange(3)).ravel()
    whole = sp.csr_matrix(sp.block_array(blocks, format="csr"))
    return whole[by_node].tocsc()[:, by_node]


def lame_constants(young: Any, poisson: Any) -> Lame:
    """Return Lame's constants for Young's modulus [Pa] and Poisson's ratio [-].

    Eq. (M2):  lambda = E nu / ((1 + nu)(1 - 2 nu)),  mu = E / (2 (1 + nu))
    """
    first = young * poisson / ((1 + poisson) * (1 - 2 * poisson))  # Eq. (M2)
    return Lame(first, young / (2 * (1 + poisson)))


def thermal_load(
    points: np.ndarray,
    tets: np.ndarray,
    young: Value,
    poisson: Value,
    expansion: Value,
    rise: np.ndarray,
) -> np.ndarray:
    """Return the nodal forces that replace thermal expansion.

    Eq. (M25):  f_ia = int (3 lambda + 2 mu) alpha dT N_i,a dV,   dT = sum_j N_j dT_j

    The quadrature is that of the stiffness, so that a free body grows evenly to round-off.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Node positions [m].
    tets : ndarray of int, shape (e, 10)
    young, poisson, expansion : float or ndarray, shape (e,)
        [Pa], [-], [1/K], of the body or of each element.
    rise : ndarray, shape (n,)
        Temperature above that of the mesh without stress [K].

    Returns
    -------
    ndarray, shape (n, 3)
        [N]; they are in equilibrium.

    References
    ----------
    [Bathe2014] ch. 4. Checked in tests/mfbd/test_hot_shapes.py.
    """
    forms = [lambda u, v, w, a=a: v.grad[a] * u for a in range(3)]
    load = np.zeros(points.shape)
    for rows, (E, nu, alpha) in by_material(len(tets), young, poisson, expansion):
        lame = lame_constants(E, nu)
        slopes = _assemble(points, tets[rows], 3, forms)
        # Eq. (M25)
        force = np.stack([slope @ rise for slope in slopes], axis=1)
        load += (3 * lame.first + 2 * lame.shear) * alpha * force
    return load


def by_material(elements: int, *values: Value) -> list[tuple[Any, tuple[float, ...]]]:
    """Return the rows of the elements of each material, and its values.

    Parameters
    ----------
    elements : int
        Number of elements.
    *values : float or ndarray, shape (e,)
        Properties of the body or of each element.
    """
    if all(np.ndim(one) == 0 for one in values):
        return [(slice(None), tuple(map(float, values)))]
    table = np.stack([np.broadcast_to(one, elements) for one in values], axis=1)
    materials, number = np.unique(table, axis=0, return_inverse=True)
    number = number.reshape(-1)
    return [(np.flatnonzero(number == k), tuple(one)) for k, one in enumerate(materials.tolist())]


def _sum(matrices: Iterable[Sparse]) -> Sparse:
    """Return the sum of at least one matrix."""
    first, *rest = matrices
    return sum(rest, first)


def consistent_mass(points: np.ndarray, tets: np.ndarray, density: Value) -> Sparse:
    """Return the consistent mass matrix.

    Eq. (M3):  M_(ia)(jb) = delta_ab int rho N_i N_j dV

    The quadrature of degree 7 is exact: N_i N_j has degree 4, and the Jacobian determinant of a
    curved element has degree 3.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Node positions [m].
    tets : ndarray of int, shape (e, 10)
    density : float or ndarray, shape (e,)
        [kg/m3], of the body or of each element.

    Returns
    -------
    scipy.sparse.csc_matrix, shape (3 n, 3 n)
        [kg]; ordered as the stiffness.
    """
    scalar = _sum(
        # Eq. (M3)
        _assemble(points, tets[rows], 4, [lambda u, v, w, rho=rho: rho * u * v])[0]
        for rows, (rho,) in by_material(len(tets), density)
    )
    return each_direction(scalar)


def rigid_mass(points: np.ndarray, tets: np.ndarray, density: Value) -> np.ndarray:
    """Return the mass matrix of a body's rigid motions about the origin, without assembly.

    Eq. (M13):  R^T M R = int rho R^T R dV      R: `rigid_motions`, here at each point of the volume

    The quadrature of degree 7 is exact, as for the consistent mass matrix M of Eq. (M3).

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Node positions [m].
    tets : ndarray of int, shape (e, 10)
    density : float or ndarray, shape (e,)
        [kg/m3], of the body or of each element.

    Returns
    -------
    ndarray, shape (6, 6)
        [kg], [kg m], [kg m2]
    """
    rule = quadrature(4)
    share, _ = shape_functions(rule.position)
    volume = rule.weight * jacobian_determinants(points, tets, rule.position)
    nodes = points[tets]
    total = np.zeros((6, 6))
    for k, share_of_point in enumerate(share):
        R = rigid_motions(share_of_point @ nodes)
        total += R.T @ (np.repeat(density * volume[:, k], 3)[:, None] * R)  # Eq. (M13)
    return total


def mass_properties(rigid_mass: np.ndarray) -> MassProperties:
    """Return the mass properties of a body from its mass matrix of rigid motions, (6, 6).

    Eq. (J13):  R^T M R = [m 1, -m [c]x; m [c]x, I_0],   I = I_0 + m [c]x [c]x
    """
    mass = rigid_mass[0, 0]
    moment = rigid_mass[3:, :3]
    x, y, z = np.array([moment[2, 1], moment[0, 2], moment[1, 0]]) / mass
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    inertia = rigid_mass[3:, 3:] + mass * cross @ cross  # Eq. (J13)
    return MassProperties(float(mass), np.array([x, y, z]), inertia)


def each_direction(scalar: Sparse) -> Sparse:
    """Return the matrix of all three displacement components, (3 n, 3 n), from that of one."""
    return sp.csc_matrix(sp.kron(scalar, sp.identity(3), format="csc"))


def _assemble(
    points: np.ndarray, tets: np.ndarray, points_a_side: int, forms: Sequence[Callable]
) -> list[Sparse]:
    """Return the matrices of scalar bilinear forms, each (n, n) in the order of the nodes."""
    totals = [sp.csr_matrix((len(points),) * 2)] * len(forms)
    rule = quadrature(points_a_side)
    for part in np.array_split(tets, -(-len(tets) // ELEMENTS_AT_ONCE)):
        used, inside = np.unique(part, return_inverse=True)
        basis, number = element_basis(points[used], inside.reshape(part.shape), rule)
        for k, form in enumerate(forms):
            matrix = BilinearForm(form).assemble(basis)[number][:, number].tocoo()
            ij = used[matrix.row], used[matrix.col]
            totals[k] = totals[k] + sp.csr_matrix((matrix.data, ij), shape=totals[k].shape)
    return totals


def jacobian_determinants(points: np.ndarray, tets: np.ndarray, position: np.ndarray) -> np.ndarray:
    """Return the Jacobian determinant of each element, (e, q) [m3], at reference positions (q, 3).

    Eq. (M16):  J = det sum_k r_k (dN_k/dxi)^T      positive if the element is not inverted
    """
    _, slopes = shape_functions(position)
    along = np.einsum("qka,eki->aeqi", slopes, points[tets], optimize=True)
    first, second, third = along
    return (np.cross(first, second) * third).sum(axis=-1)  # Eq. (M16)


def shape_functions(position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return N, (q, 10), and dN/dxi, (q, 10, 3), at reference positions, (q, 3)."""
    element = ElementTetP2()
    values, slopes = zip(*(element.lbasis(position.T, k) for k in range(len(NODES))))
    return np.stack(values, axis=-1), np.stack([slope.T for slope in slopes], axis=1)


def corner_stress(
    points: np.ndarray, tets: np.ndarray, displacement: np.ndarray, young: Value, poisson: Value
) -> np.ndarray:
    """Return the stress in each element at its corners.

    Eq. (M4):  sigma = lambda tr(eps) 1 + 2 mu eps,   eps = (grad u + grad u^T)/2

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        [m]; every node belongs to an element.
    tets : ndarray of int, shape (e, 10)
    displacement : ndarray, shape (n, 3) or (n, 3, k)
        One displacement or k of them, for example mode shapes [m].
    young, poisson : float or ndarray, shape (e,)
        [Pa], [-], of the body or of each element.

    Returns
    -------
    ndarray, shape (e, 4, 6) or (e, 4, 6, k)
        xx, yy, zz, xy, yz, zx [Pa].
    """
    first, shear = (np.asarray(one)[..., None] for one in lame_constants(young, poisson))
    basis, number = element_basis(points, tets, Quadrature(NODES[:CORNERS], np.ones(CORNERS)))
    nodal = np.empty_like(displacement)
    nodal[number] = displacement

    def of(displaced):
        fields: list[Any] = [basis.interpolate(component) for component in displaced.T]
        slope = np.stack([one.grad for one in fields])  # (a, b, e, 4)
        # Eq. (M4)
        strain = (slope + slope.swapaxes(0, 1)) / 2
        pressure_part = first * np.trace(strain) * np.eye(3)[:, :, None, None]
        stress = 2 * shear * strain + pressure_part
        return np.stack([stress[a, b] for a, b in COMPONENTS], axis=2)

    if nodal.ndim == 2:
        return of(nodal)
    return np.stack([of(one) for one in np.moveaxis(nodal, 2, 0)], axis=3)


def nodal_stress(tets: np.ndarray, stress: np.ndarray, young: Value = 0.0) -> np.ndarray:
    """Return the stress at the nodes: the mean of the elements, on edges the mean of the ends.

    A corner has five times as many elements as an edge, so its mean is smoother. Stress of ten-node
    elements is linear within them. Stress jumps between materials. A node between them has that of
    the stiffest one.

    Parameters
    ----------
    tets : ndarray of int, shape (e, 10)
    stress : ndarray, shape (e, 4, ...)
        From `corner_stress` [Pa].
    young : float or ndarray, shape (e,)
        [Pa], of the body or of each element.

    Returns
    -------
    ndarray, shape (n, ...)
    """
    nodes = int(tets.max()) + 1
    first, *stiffer = by_material(len(tets), young)
    total = _nodal_mean(tets[first[0]], stress[first[0]], nodes)
    for rows, _ in stiffer:  # in ascending order
        own = np.unique(tets[rows])
        total[own] = _nodal_mean(tets[rows], stress[rows], nodes)[own]
    return total


def _nodal_mean(tets, stress, nodes):
    """Return the mean stress of elements of one material at their nodes, (nodes, ...)."""
    corners, edges = tets[:, :CORNERS], tets[:, CORNERS:]
    count = np.bincount(corners.ravel(), minlength=nodes)
    columns = stress.reshape(corners.size, -1).T
    sums = np.stack([np.bincount(corners.ravel(), one, nodes) for one in columns], axis=1)
    mean = sums / np.maximum(count, 1)[:, None]
    mean[edges] = mean[tets[:, EDGES]].mean(axis=2)
    return mean.reshape(nodes, *stress.shape[2:])


def von_mises(stress: np.ndarray) -> np.ndarray:
    """Return the equivalent stress of stresses xx, yy, zz, xy, yz, zx, (n, 6) [Pa].

    Eq. (M5):  sqrt(((xx - yy)^2 + (yy - zz)^2 + (zz - xx)^2)/2 + 3 (xy^2 + yz^2 + zx^2))
    """
    xx, yy, zz, xy, yz, zx = stress.T
    normal = ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2
    return np.sqrt(normal + 3 * (xy**2 + yz**2 + zx**2))  # Eq. (M5)


def rigid_motions(points: np.ndarray) -> np.ndarray:
    """Return translations along x, y, z and rotations about these axes, (3 n, 6)."""
    out = np.zeros((len(points), 3, 6))
    out[:, :, :3] = np.eye(3)
    for axis in range(3):
        out[:, :, 3 + axis] = np.cross(np.eye(3)[axis], points)
    return out.reshape(-1, 6)
