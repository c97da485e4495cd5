"""Ten-node tetrahedron against scikit-fem, rigid-body motions, mass properties, quadrature."""

import math

import numpy as np
import pytest

from fmu_mfbd.finite_element import consistent_mass, face_load, quadrature, stiffness
from fmu_mfbd.mesh import MeshFault, mesh_faults, Mesh, outer_faces, read_mesh
from fmu_mfbd.reduction import floating_frame_integrals
from fmu_mfbd.bases import rigid_motions
from fmu_mfbd.verification import box_mesh


@pytest.fixture(scope="module")
def warped():
    """A block of elements with edges that are not straight."""
    points, tets = box_mesh((2, 2, 3), (0.1, 0.2, 0.3))
    return points + 4e-3 * np.sin(25 * points[:, [1, 2, 0]]), tets


@pytest.mark.parametrize("n", [1, 2, 3, 4])
def test_quadrature_is_exact_up_to_its_degree(n):
    position, weight = quadrature(n)
    for i in range(2 * n):
        for j in range(2 * n - i):
            k = 2 * n - 1 - i - j
            exact = math.factorial(i) * math.factorial(j) * math.factorial(k) / math.factorial(i + j + k + 3)
            assert weight @ np.prod(position ** [i, j, k], axis=1) == pytest.approx(exact, rel=1e-12)


def test_matrices_agree_with_scikit_fem(warped):
    """Same elements, same quadrature degree; both sum in another order, hence 1e-12 of the largest entry."""
    from skfem import BilinearForm, ElementTetP2, ElementVector, Basis, MeshTet2
    from skfem.helpers import ddot, dot, eye, sym_grad, trace

    points, tets = warped
    young, poisson = 7e10, 0.3
    lame, shear = young * poisson / ((1 + poisson) * (1 - 2 * poisson)), young / (2 * (1 + poisson))

    @BilinearForm
    def elastic(u, v, w):
        e = sym_grad(u)
        return ddot(2 * shear * e + lame * eye(trace(e), 3), sym_grad(v))

    @BilinearForm
    def inertia(u, v, w):
        return 2700.0 * dot(u, v)

    import meshio
    mesh = MeshTet2.from_meshio if hasattr(MeshTet2, "from_meshio") else None
    assert mesh is None or meshio
    from skfem.io.meshio import from_meshio
    other = from_meshio(meshio.Mesh(points, [("tetra10", tets)]))
    position, weight = quadrature(3)
    basis = Basis(other, ElementVector(ElementTetP2()), quadrature=(position.T, weight))
    finer = basis.with_elements(np.arange(len(tets)))
    position, weight = quadrature(4)
    finer = Basis(other, ElementVector(ElementTetP2()), quadrature=(position.T, weight))
    where = basis.doflocs.T
    node = np.array([np.linalg.norm(points - at, axis=1).argmin() for at in where])
    axis = np.empty(len(where), int)
    axis[basis.nodal_dofs], axis[basis.edge_dofs] = np.arange(3)[:, None], np.arange(3)[:, None]
    dofs = 3 * node + axis
    K, M = stiffness(points, tets, young, poisson), consistent_mass(points, tets, 2700.0)
    M = np.kron(M.toarray(), np.eye(3))
    for ours, form, space in ((K.toarray(), elastic, basis), (M, inertia, finer)):
        theirs = form.assemble(space).toarray()
        assert np.abs(ours[np.ix_(dofs, dofs)] - theirs).max() <= 1e-12 * np.abs(theirs).max()


def test_six_rigid_body_motions_and_no_more(warped):
    points, tets = warped
    K = stiffness(points, tets, 7e10, 0.3).toarray()
    scale = np.linalg.norm(K, 2)
    assert np.abs(K @ rigid_motions(points)).max() <= 1e-12 * scale
    assert np.linalg.eigvalsh(K)[6] > 1e-6 * scale


def test_mass_centre_and_inertia_of_a_box():
    """Polynomials of degree 2: the consistent mass integrates them to round-off."""
    size = np.array([0.1, 0.2, 0.3])
    points, tets = box_mesh((2, 3, 2), size)
    M = consistent_mass(points, tets, 2700.0)
    found = floating_frame_integrals(M, points, np.zeros((len(points), 3, 0)))
    mass = 2700.0 * size.prod()
    assert found["mass"] == pytest.approx(mass, rel=1e-12)
    assert found["S"] == pytest.approx(mass * size[:2] / 2, rel=1e-12)
    assert found["I0"] == pytest.approx(mass * (size[0] ** 2 + size[1] ** 2) / 3, rel=1e-12)


def test_uniform_stress_is_exact_on_curved_elements(warped):
    """Patch test: a linear displacement has no force on inner nodes."""
    points, tets = warped
    gradient = np.array([[1e-3, 2e-4, 0.0], [0.0, -5e-4, 3e-4], [1e-4, 0.0, 2e-4]])
    force = (stiffness(points, tets, 7e10, 0.3) @ (points @ gradient.T).ravel()).reshape(-1, 3)
    inner = np.setdiff1d(np.arange(len(points)), outer_faces(tets))
    assert len(inner) > 10
    # quadrature of degree 5 on curved elements leaves far less than the elements' own error
    assert np.abs(force[inner]).max() <= 2e-5 * np.abs(force).max()


def test_pressure_on_all_faces_balances(warped):
    points, tets = warped
    load = face_load(points, outer_faces(tets))
    size = np.abs(load).sum()
    assert np.abs(load.sum(axis=0)).max() <= 1e-13 * size
    assert np.abs(np.cross(points, load).sum(axis=0)).max() <= 1e-13 * size


def test_inverted_and_loose_elements_are_named(warped):
    points, tets = warped
    bad = tets.copy()
    bad[3] = bad[3][[1, 0, 2, 3, 4, 6, 5, 8, 7, 9]]
    [text] = mesh_faults(Mesh(points, bad, {}), "body")
    assert "1 inverted elements, the first is number 4" in text
    twice = Mesh(np.vstack([points, points + 1.0]), np.vstack([tets, tets + len(points)]), {})
    assert "2 unconnected pieces" in mesh_faults(twice, "body")[0]


def test_missing_surface_and_linear_elements(bodies, tmp_path):
    import meshio

    with pytest.raises(MeshFault, match="surface 'belt' is missing or empty .the file names crown, pin_bore, skirt"):
        read_mesh(bodies[0] / "piston.msh", {"skirt": None, "belt": None})
    meshio.write(tmp_path / "shell.msh", meshio.Mesh(np.eye(3), [("triangle", [[0, 1, 2]])]), file_format="gmsh22")
    with pytest.raises(MeshFault, match="no tetrahedra .found triangle"):
        read_mesh(tmp_path / "shell.msh", {})
    with pytest.raises(MeshFault, match="the body is 36 m long; mesh_unit"):
        read_mesh(bodies[0] / "piston.msh", {}, scale=1000.0 * 36 / 56)
