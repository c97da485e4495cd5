"""Sparse direct solvers: SuperLU of scipy, and PARDISO where the extra `large` is installed, give
the same and refuse the same.
"""

from importlib.util import find_spec

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.finite_elements.element import stiffness
from piston_cosim.fmu_mfbd.finite_elements.solver import Pardiso, SuperLU, factorise
from piston_cosim.tests.verification.cases.bodies import box_mesh


@pytest.fixture(scope="module")
def loose():
    points, tets = box_mesh((3, 4, 2), (0.03, 0.05, 0.02))
    return points, stiffness(points, tets, 7e10, 0.3).tocsr()


def without(K, nodes):
    """K without the degrees of freedom of some nodes."""
    free = np.setdiff1d(
        np.arange(K.shape[0]), (3 * np.asarray(nodes)[:, None] + np.arange(3)).ravel()
    )
    return K[free][:, free].tocsc()


@pytest.fixture(params=[SuperLU, Pardiso])
def solver(request):
    if request.param is Pardiso:
        pytest.importorskip("pypardiso", reason="the extra `large` is not installed")
    return request.param


def test_solutions_of_one_and_of_many_loads(loose, solver):
    points, K = loose
    A = without(K, np.flatnonzero(points[:, 1] == 0.0))
    load = np.random.default_rng(0).standard_normal((A.shape[0], 40))
    factors = solver(A)
    many, one = factors.solve(load), factors.solve(load[:, 7])
    exact = np.linalg.solve(A.toarray(), load)
    # condition number 1e5
    np.testing.assert_allclose(many, exact, atol=1e-10 * np.abs(exact).max())
    np.testing.assert_allclose(one, exact[:, 7], atol=1e-10 * np.abs(exact).max())
    np.testing.assert_array_equal(solver(A).solve(load), many)


@pytest.mark.parametrize("held", [[], [0], [0, 2]])
def test_what_can_move_is_refused(held, loose, solver):
    """Free, on one node, on two nodes."""
    with pytest.raises(
        ValueError,
        match="mesh: expected a .* got .*; hold three nodes off one line against rigid motions",
    ):
        solver(without(loose[1], np.array(held, dtype=int)))


def test_the_solver_at_hand(loose):
    points, K = loose
    kind = type(factorise(without(K, np.flatnonzero(points[:, 1] == 0.0))))
    assert kind is (Pardiso if find_spec("pypardiso") else SuperLU)
