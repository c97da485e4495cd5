import numpy as np
import pytest

from piston_cosim.fmu_ehd.common.grid import CENTRE, EAST, NORTH, SOUTH, WEST
from piston_cosim.fmu_ehd.solvers.blocks import BlockTridiagonal, invert_in_place


def stencil(rng, shape):
    """Return a column-dominant M-matrix of five-point shape on a ring."""
    south, north, west, east = (-rng.random(shape) for _ in range(4))
    south[:, 0] = north[:, -1] = 0.0
    rows = (
        np.roll(south, -1, 1),
        np.roll(north, 1, 1),
        np.roll(west, -1, 0),
        np.roll(east, 1, 0),
    )  # what stands in column (i,j)
    centre = -sum(rows) + 0.01 * rng.random(shape)
    return np.stack([centre, south, north, west, east])


def product(coefficients, x):
    """Five-point matrix times x, Eq. (B1), by shifts."""
    return (
        coefficients[CENTRE] * x
        + coefficients[SOUTH] * np.roll(x, 1, 1)
        + coefficients[NORTH] * np.roll(x, -1, 1)
        + coefficients[WEST] * np.roll(x, 1, 0)
        + coefficients[EAST] * np.roll(x, -1, 0)
    )


@pytest.mark.parametrize("n", [1, 5, 8, 40])
def test_inverse_of_scattered_columns_multiplies_the_others(n):
    rng = np.random.default_rng(n)
    a = -rng.random((n, n + 3))
    pivots = np.arange(n + 3)[1:-2]
    others = np.array([0, n + 1, n + 2])
    a[np.arange(n), pivots] = 0.1 - a.sum(axis=1)
    both = a.copy()
    invert_in_place(both, pivots)
    assert np.allclose(both[:, pivots] @ a[:, pivots], np.eye(n), atol=1e-12)
    assert np.allclose(a[:, pivots] @ both[:, others], a[:, others], atol=1e-12)


@pytest.mark.parametrize("shape", [(1, 5), (2, 4), (3, 1), (7, 9), (8, 8)])
@pytest.mark.parametrize("ahead, shift", [(None, 0), (NORTH, 1), (SOUTH, -1)])
def test_solution_satisfies_the_system(shape, ahead, shift):
    """Also with cells whose column reaches one neighbour downstream, like cavitated ones."""
    rng = np.random.default_rng(1)
    coefficients = stencil(rng, shape)
    if ahead is not None:
        empty = rng.random(shape) < 0.5
        coefficients[ahead][np.roll(empty, -shift, 1)] = 0.0
        coefficients[WEST][np.roll(empty, 1, 0)] = 0.0
        coefficients[EAST][np.roll(empty, -1, 0)] = 0.0
    solver = BlockTridiagonal(shape)
    solver.factorise(coefficients)
    for many in (3, 9):  # one after the other, and by matrix products
        right = rng.standard_normal((many, *shape))
        for b, x in zip(right, solver.solve(right.copy())):
            residual = np.abs(product(coefficients, x) - b).max()
            assert residual <= 1e-11 * np.abs(x).max()  # round-off times condition


def with_columns(old, new, chosen):
    """Return a stencil whose columns of axial stations `chosen` are `new`, the others `old`."""
    j = np.arange(old.shape[-1])
    column = np.tile(j, (5, 1))  # in which each coefficient of station j stands
    column[SOUTH] = j - 1
    column[NORTH] = j + 1
    return np.where(np.isin(column, chosen)[:, None], new, old)


@pytest.mark.parametrize("emptied", [SOUTH, NORTH], ids=["descending", "ascending"])
@pytest.mark.parametrize("chosen", [[4, 5], [0], [8]])
def test_refactorising_the_changed_stations_is_the_full_factorisation(emptied, chosen):
    rng = np.random.default_rng(2)
    shape = (6, 9)
    before, after = (stencil(rng, shape) for _ in range(2))
    for coefficients in (before, after):
        coefficients[emptied, 2, 4] = 0.0  # tells the solver which way is downstream
    mixed = with_columns(before, after, chosen)
    partly, wholly = BlockTridiagonal(shape), BlockTridiagonal(shape)
    partly.factorise(before)
    partly.factorise(mixed, (chosen[0], chosen[-1]))
    wholly.factorise(mixed)
    right = rng.standard_normal((1, *shape))
    assert np.array_equal(partly.solve(right.copy()), wholly.solve(right.copy()))


def test_nothing_of_an_earlier_factorisation_is_left():
    rng = np.random.default_rng(4)
    coefficients, right = stencil(rng, (5, 6)), rng.standard_normal((1, 5, 6))
    fresh, used = BlockTridiagonal((5, 6)), BlockTridiagonal((5, 6))
    used.factorise(np.full((5, 5, 6), np.nan))
    for solver in (fresh, used):
        solver.factorise(coefficients)
    assert np.array_equal(fresh.solve(right.copy()), used.solve(right.copy()))
