"""Elimination with exchange of rows, against numpy and by hand."""

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.mechanism.elimination import factorise, substitute


def test_two_equations_by_hand():
    """0 x + 2 y = 4, 3 x + y = 5: rows change places."""
    factors = factorise(np.array([[0.0, 2.0], [3.0, 1.0]]))
    assert np.array_equal(factors.order, [1.0, 1.0])
    assert np.array_equal(factors.both, [[3.0, 1.0], [0.0, 2.0]])
    assert np.array_equal(substitute(factors, np.array([4.0, 5.0])), [1.0, 2.0])


@pytest.mark.parametrize("n", [1, 7, 40])
def test_solutions_are_those_of_numpy(n):
    """The residual of A x is round-off (backward stable), even if row sizes differ by 1e12.

    Rows of newtons and of modal forces differ as much.
    """
    rng = np.random.default_rng(n)
    matrix = rng.standard_normal((n, n)) * 10.0 ** rng.integers(-6, 6, n)[:, None]
    wanted = rng.standard_normal(n)
    right = matrix @ wanted
    found = substitute(factorise(matrix), right)
    assert (np.abs(matrix @ found - right) <= 1e-14 * n * np.abs(matrix) @ np.abs(found)).all()
    np.testing.assert_allclose(found, np.linalg.solve(matrix, right), rtol=1e-9)


def test_a_singular_system_has_no_finite_solution():
    with np.errstate(all="ignore"):
        found = substitute(factorise(np.ones((2, 2))), np.array([1.0, 2.0]))
    assert not np.isfinite(found).all()
