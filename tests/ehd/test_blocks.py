import numpy as np
import pytest

from fmu_ehd.blocks import BlockTridiagonal, invert_in_place


def stencil(rng, shape):
    """A column-dominant M-matrix of five-point shape on a ring."""
    south, north, west, east = (-rng.random(shape) for _ in range(4))
    south[:, 0] = north[:, -1] = 0.0
    rows = np.roll(south, -1, 1), np.roll(north, 1, 1), np.roll(west, -1, 0), np.roll(east, 1, 0)  # what stands in column (i,j)
    return -sum(rows) + 0.01 * rng.random(shape), south, north, west, east


def product(coefficients, x):
    """Five-point matrix times x, Eq. (B1), by shifts."""
    centre, south, north, west, east = coefficients
    return (centre * x + south * np.roll(x, 1, 1) + north * np.roll(x, -1, 1)
            + west * np.roll(x, 1, 0) + east * np.roll(x, -1, 0))


@pytest.mark.parametrize("n", [1, 2, 3, 7, 40])
def test_inverse(n):
    a = -np.random.default_rng(n).random((n, n))
    a += np.diag(0.1 - a.sum(axis=0))
    inverse = a.copy()
    invert_in_place(inverse)
    assert np.allclose(inverse @ a, np.eye(n), atol=1e-12)


@pytest.mark.parametrize("shape", [(1, 5), (2, 4), (3, 1), (7, 9), (8, 8)])
def test_solution_satisfies_the_system(shape):
    rng = np.random.default_rng(1)
    coefficients = stencil(rng, shape)
    solver = BlockTridiagonal(shape)
    solver.factorise(coefficients)
    right = rng.standard_normal((3, *shape))
    for b, x in zip(right, solver.solve(right)):
        assert np.abs(product(coefficients, x) - b).max() <= 1e-11 * np.abs(x).max()  # round-off times condition


def test_refactorising_from_the_first_changed_station_is_the_full_factorisation():
    rng = np.random.default_rng(2)
    shape = (6, 9)
    before, after = stencil(rng, shape), stencil(rng, shape)
    mixed = []
    for k, (old, new) in enumerate(zip(before, after)):
        offset = {1: 1, 2: -1}.get(k, 0)  # south of station j stands in column j - 1, north in j + 1
        mixed.append(np.ascontiguousarray(np.where(np.arange(shape[1]) >= 4 + offset, new, old)))
    partly, wholly = BlockTridiagonal(shape), BlockTridiagonal(shape)
    partly.factorise(before)
    partly.factorise(tuple(mixed), first=4)
    wholly.factorise(tuple(mixed))
    right = rng.standard_normal((1, *shape))
    assert np.array_equal(partly.solve(right), wholly.solve(right))
