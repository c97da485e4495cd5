"""Sparse direct solvers give the same results and reject the same matrices.

They are SuperLU of scipy and, if the extra `large` is installed, PARDISO.
"""

import os
import sys
from importlib.util import find_spec

import numpy as np
import pytest
import scipy.sparse as sp

from piston_cosim.fmu_mfbd.finite_elements import solver as solvers
from piston_cosim.fmu_mfbd.finite_elements.element import stiffness
from piston_cosim.fmu_mfbd.finite_elements.solver import Pardiso, SuperLU, factorise, threads
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
        match="mesh: expected a .* got .*; hold at least three nodes, not all on one line",
    ):
        solver(without(loose[1], np.array(held, dtype=int)))


def test_the_solver_at_hand(loose):
    points, K = loose
    kind = type(factorise(without(K, np.flatnonzero(points[:, 1] == 0.0))))
    assert kind is (Pardiso if find_spec("pypardiso") else SuperLU)


def test_the_expected_cost_is_that_of_both_shapes(monkeypatch):
    """A plate and a cube of SuperLU with twice the degrees of freedom that were measured."""
    monkeypatch.setattr(solvers, "find_spec", lambda name: None)
    plate, cube = (solvers.expected_cost(2 * size) for size in (47_880, 34_914))
    # 3 s x 2^1.5 and 1.2 GB x 2^1.2; 18 s x 2^2.7 and 2.1 GB x 2^1.6
    assert plate.startswith("about 8.5 s of processor time and 2.8 GB by SuperLU if thin-walled")
    assert cube.endswith("117 s and 6.4 GB if solid")


def test_a_large_body_needs_the_extra(monkeypatch):
    """Without pypardiso, 60 001 degrees of freedom are rejected before anything is factorised."""
    monkeypatch.setitem(sys.modules, "pypardiso", None)
    monkeypatch.setattr(solvers, "SuperLU", lambda K: K.shape[0])
    assert factorise(sp.identity(60_000, format="csc")) == 60_000
    with pytest.raises(ValueError, match=r"at most 60000 .* extra `large`, got 60001; .*\[large\]"):
        factorise(sp.identity(60_001, format="csc"))


@pytest.mark.parametrize(
    "own, openmp, count",
    [
        (None, "3", 3),
        ("3", "1", 3),
        (None, "2,4", 2),
        ("all", "1", os.cpu_count()),
        (None, None, os.cpu_count()),
    ],
)
def test_threads_are_those_of_the_user(own, openmp, count, monkeypatch):
    """`own` is what the command line found before it set OMP_NUM_THREADS to 1."""
    for name, value in zip(solvers.THREADS, (own, openmp)):
        monkeypatch.delenv(name, raising=False)
        if value:
            monkeypatch.setenv(name, value)
    assert threads() == count
