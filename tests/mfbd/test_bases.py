"""Ways to tie a body to its frame, and the third basis."""

import numpy as np
import pytest
import scipy.linalg as la

from piston_cosim.fmu_mfbd.finite_elements.element import rigid_motions
from piston_cosim.fmu_mfbd.finite_elements.faces import surface_matrix
from piston_cosim.fmu_mfbd.finite_elements.matrices import assembled
from piston_cosim.fmu_mfbd.reduction.bases import (
    Elastic,
    MeanElastic,
    characteristic_constraint_modes,
    craig_bampton,
    mean_conditions,
    orthonormal_modes,
)

from .conftest import clamped_box


@pytest.fixture(scope="module")
def plate():
    """Points, K, M and the area of each node on the face y = 0."""
    mesh, _ = clamped_box((3, 4, 2), (0.03, 0.05, 0.02))
    points, faces = mesh.points, mesh.skin()
    faces = faces[(points[faces][:, :, 1] == 0.0).all(axis=1)]
    _, K, M = assembled(mesh, 7e10, 0.3, 2700.0)
    return points, K, M, surface_matrix(points, faces)


def test_surface_matrix_holds_area_and_moments(plate):
    points, _, _, area = plate
    share = np.asarray(area.sum(axis=1)).ravel()
    assert share.sum() == pytest.approx(0.03 * 0.02, rel=1e-12)
    assert points[:, 0] @ (area @ points[:, 0]) == pytest.approx(0.03**3 / 3 * 0.02, rel=1e-12)


def test_mean_held_body_is_the_constrained_problem(plate):
    """Against the dense saddle-point system."""
    points, K, M, area = plate
    C = mean_conditions(points, np.asarray(area.sum(axis=1)).ravel())
    body = MeanElastic(K, M, C, rigid_motions(points))
    load = np.random.default_rng(0).standard_normal((len(points) * 3, 2))
    scale = 1e8
    saddle = np.block([[K.toarray(), scale * C.T], [scale * C, np.zeros((len(C), len(C)))]])
    reference = np.linalg.solve(saddle, np.vstack([load, np.zeros((len(C), 2))]))[: len(load)]
    deflection = body.solve(load)
    np.testing.assert_allclose(deflection, reference, atol=1e-8 * np.abs(reference).max())
    assert np.abs(C @ deflection).max() <= 1e-10 * np.abs(deflection).max()
    # lowest modes of the constrained body
    _, omega = orthonormal_modes(body, craig_bampton(body, 4))
    null = la.null_space(C)
    exact = la.eigh(
        null.T @ (K @ null), null.T @ (M @ null), eigvals_only=True, subset_by_index=(0, 3)
    )
    np.testing.assert_allclose(omega**2, exact, rtol=1e-7)


def test_characteristic_constraint_modes_are_guyan_modes(plate):
    """Against dense static condensation."""
    points, K, M, _ = plate
    body = Elastic(K, M, np.flatnonzero(points[:, 1] == 0.0))
    surface = np.flatnonzero(points[:, 0] == 0.03)
    shapes = characteristic_constraint_modes(body, surface, 5)
    chosen = np.isin(body.free, (3 * surface[:, None] + np.arange(3)).ravel())
    dense, mass = body.K.toarray(), body.M.toarray()
    psi = np.zeros((len(dense), chosen.sum()))
    psi[chosen] = np.eye(chosen.sum())
    psi[~chosen] = -np.linalg.solve(dense[np.ix_(~chosen, ~chosen)], dense[np.ix_(~chosen, chosen)])
    exact = la.eigh(
        psi.T @ dense @ psi, psi.T @ mass @ psi, eigvals_only=True, subset_by_index=(0, 4)
    )
    np.testing.assert_allclose(orthonormal_modes(body, shapes)[1] ** 2, exact, rtol=1e-7)
