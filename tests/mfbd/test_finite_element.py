"""Ten-node tetrahedron: rigid-body motions, mass properties, patch test and quadrature.

The comparison with FElupe is in tests/verification/test_mfbd.py.
"""

import math

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.finite_elements.connections import (
    aspect_ratios,
    mesh_faults,
    outer_faces,
)
from piston_cosim.fmu_mfbd.finite_elements.element import (
    consistent_mass,
    mass_properties,
    quadrature,
    rigid_mass,
    rigid_motions,
    stiffness,
)
from piston_cosim.fmu_mfbd.finite_elements.faces import face_load
from piston_cosim.fmu_mfbd.reduction.frame_integrals import floating_frame_integrals
from piston_cosim.tests.verification.cases.bodies import box_mesh


@pytest.fixture(scope="module")
def warped():
    """Return a block of elements with curved edges."""
    points, tets = box_mesh((2, 2, 3), (0.1, 0.2, 0.3))
    return points + 4e-3 * np.sin(25 * points[:, [1, 2, 0]]), tets


@pytest.mark.parametrize("n", [1, 2, 3, 4])
def test_quadrature_is_exact_up_to_its_degree(n):
    position, weight = quadrature(n)
    for i in range(2 * n):
        for j in range(2 * n - i):
            k = 2 * n - 1 - i - j
            exact = (
                math.factorial(i)
                * math.factorial(j)
                * math.factorial(k)
                / math.factorial(i + j + k + 3)
            )
            assert weight @ np.prod(position ** [i, j, k], axis=1) == pytest.approx(
                exact, rel=1e-12
            )


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
    integrals = floating_frame_integrals(M, points, np.zeros((len(points), 3, 0)))
    mass = 2700.0 * size.prod()
    assert integrals.mass == pytest.approx(mass, rel=1e-12)
    assert integrals.S == pytest.approx(mass * size[:2] / 2, rel=1e-12)
    assert integrals.I0 == pytest.approx(mass * (size[0] ** 2 + size[1] ** 2) / 3, rel=1e-12)


def test_rigid_mass_needs_no_assembly(warped):
    """Curved elements by the assembled matrix, Eq. (M3); turned inertia of a box by hand."""
    R = rigid_motions(warped[0])
    whole = R.T @ (consistent_mass(*warped, 2700.0) @ R)
    np.testing.assert_allclose(rigid_mass(*warped, 2700.0), whole, atol=1e-13 * whole.max())
    size = np.array([0.1, 0.2, 0.3])
    points, tets = box_mesh((2, 3, 2), size)
    mass, centre, inertia = mass_properties(rigid_mass(points + 1.0, tets, 2700.0))
    assert mass == pytest.approx(2700.0 * size.prod(), rel=1e-12)
    assert centre == pytest.approx(1.0 + size / 2, rel=1e-12)
    own = np.diag(mass * ((size**2).sum() - size**2) / 12)
    np.testing.assert_allclose(inertia, own, atol=1e-12 * mass)  # after a shift of m by 1 m


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


def test_inverted_elements_are_named(warped):
    points, tets = warped
    bad = tets.copy()
    bad[3] = bad[3][[1, 0, 2, 3, 4, 6, 5, 8, 7, 9]]
    [text] = mesh_faults(points, bad, "body")
    assert (
        "body: expected positive Jacobians, got 1 inverted elements; the first is number 4" in text
    )


def two_boxes():
    """Return two boxes of 12 tetrahedra each with a common side of 4 triangles at x = 0.1 m.

    Each box has its own nodes there.
    """
    points, tets = box_mesh((1, 2, 1), np.full(3, 0.1))
    return np.vstack([points, points + [0.1, 0.0, 0.0]]), np.vstack([tets, tets + len(points)])


def merged(points, tets, chosen):
    """Return the boxes with common nodes where `chosen(points)` holds."""
    half = len(points) // 2
    apart = np.linalg.norm(points[half:, None] - points[:half], axis=2)
    number = np.arange(len(points))
    same = (apart.min(axis=1) < 1e-9) & chosen(points[half:])
    number[half:][same] = apart.argmin(axis=1)[same]
    used, tets = np.unique(number[tets], return_inverse=True)
    return points[used], tets.reshape(-1, 10)


def test_pieces_that_faces_do_not_connect_are_named():
    points, tets = two_boxes()
    assert mesh_faults(*merged(points, tets, lambda at: at[:, 0] > 0), "body") == []
    pieces, crack = mesh_faults(points, tets, "body")
    assert "body: expected one body, got 2 unconnected pieces of 12, 12 elements" in pieces
    assert "body: expected no crack, got 4 pairs of coincident outer faces at" in crack
    hinge, _ = mesh_faults(*merged(points, tets, lambda at: at[:, 1] + at[:, 2] < 1e-9), "body")
    assert "body: expected elements connected through faces, got 2 pieces of 12, 12" in hinge
    assert "with 1 common nodes at (0.1, 0, 0) m" in hinge


def test_a_crack_is_named():
    """Nodes of their own over half the common side; faces connect the boxes over the other half."""
    (told,) = mesh_faults(*merged(*two_boxes(), lambda at: at[:, 1] > 0.049), "body")
    assert "expected no crack, got 2 pairs of coincident outer faces at (0.1, 0.0" in told


def test_a_duplicate_element_is_named():
    points, tets = box_mesh((1, 1, 1), np.full(3, 0.1))
    turned = tets[4, [1, 2, 0, 3, 5, 6, 4, 8, 9, 7]]  # another order of the same nodes
    (told,) = mesh_faults(points, np.vstack([tets, turned]), "body")
    x, y, z = points[tets[4, :4]].mean(axis=0)
    assert "body: expected different elements, got 1 duplicates; remove them" in told
    assert f"the first is number 7 at ({x:.4g}, {y:.4g}, {z:.4g}) m" in told


def test_aspect_ratio_by_hand():
    """1 of a regular tetrahedron; of the corner of a cube sqrt(2/3) sqrt(2) sqrt(3) = 2."""
    regular = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]], dtype=float)
    corner = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)
    for points, expected in ((regular, 1.0), (corner, 2.0)):
        assert aspect_ratios(points, np.array([[0, 1, 2, 3]])) == pytest.approx(expected, rel=1e-14)
