import numpy as np
import pytest
from piston_cosim.fmu_ehd.blocks import BlockTridiagonal, invert_in_place


def stencil(rng, shape):
    """A column-dominant M-matrix of five-point shape on a ring."""
    south, north, west, east = (-rng.random(shape) for _ in range(4))
    south[:, 0] = north[:, -1] = 0.0
    rows = (
        np.roll(south, -1, 1),
        np.roll(north, 1, 1),
        np.roll(west, -1, 0),
        np.roll(east, 1, 0),
    )  # what stands in column (i,j)
    return -sum(rows) + 0.01 * rng.random(shape), south, north, west, east


def product(coefficients, x):
    """Five-point matrix times x, Eq. (B1), by shifts."""
    centre, south, north, west, east = coefficients
    return (
        centre * x
        + south * np.roll(x, 1, 1)
        + north * np.roll(x, -1, 1)
        + west * np.roll(x, 1, 0)
        + east * np.roll(x, -1, 0)
    )


@pytest.mark.parametrize("n", [1, 2, 3, 7, 40])
def test_inverse(n):
    a = -np.random.default_rng(n).random((n, n))
    a += np.diag(0.1 - a.sum(axis=0))
    inverse = a.copy()
    invert_in_place(inverse, np.arange(n))
    assert np.allclose(inverse @ a, np.eye(n), atol=1e-12)


@pytest.mark.parametrize("n", [1, 5, 8])
def test_inverse_of_scattered_columns_multiplies_the_others(n):
    rng = np.random.default_rng(n)
    a = -rng.random((n, n + 3))
    places, others = np.arange(n + 3)[1:-2], np.array([0, n + 1, n + 2])
    a[np.arange(n), places] = 0.1 - a.sum(axis=1)
    both = a.copy()
    invert_in_place(both, places)
    assert np.allclose(both[:, places] @ a[:, places], np.eye(n), atol=1e-12)
    assert np.allclose(a[:, places] @ both[:, others], a[:, others], atol=1e-12)


@pytest.mark.parametrize("shape", [(1, 5), (2, 4), (3, 1), (7, 9), (8, 8)])
def test_solution_satisfies_the_system(shape):
    rng = np.random.default_rng(1)
    coefficients = stencil(rng, shape)
    solver = BlockTridiagonal(shape)
    solver.factorise(coefficients)
    right = rng.standard_normal((3, *shape))
    for b, x in zip(right, solver.solve(right.copy())):
        assert (
            np.abs(product(coefficients, x) - b).max() <= 1e-11 * np.abs(x).max()
        )  # round-off times condition


def with_columns(old, new, chosen):
    """Stencil with the columns of axial stations `chosen` taken from `new`, the others from
    `old`.
    """
    j = np.arange(old[0].shape[1])
    offset = (0, 1, -1, 0, 0)  # south of station j stands in column j - 1, north in j + 1
    return tuple(np.where(np.isin(j - o, chosen), b, a) for a, b, o in zip(old, new, offset))


@pytest.mark.parametrize("emptied", [1, 2], ids=["descending", "ascending"])
@pytest.mark.parametrize("chosen", [[4, 5], [0], [8]])
def test_refactorising_the_changed_stations_is_the_full_factorisation(emptied, chosen):
    rng = np.random.default_rng(2)
    shape = (6, 9)
    before, after = (list(stencil(rng, shape)) for _ in range(2))
    for coefficients in (before, after):
        coefficients[emptied][2, 4] = 0.0  # tells the solver which way is downstream
    mixed = with_columns(before, after, chosen)
    partly, wholly = BlockTridiagonal(shape), BlockTridiagonal(shape)
    partly.factorise(tuple(before))
    partly.factorise(mixed, (chosen[0], chosen[-1]))
    wholly.factorise(mixed)
    right = rng.standard_normal((1, *shape))
    assert np.array_equal(partly.solve(right.copy()), wholly.solve(right.copy()))


@pytest.mark.parametrize("downstream", ["up", "down"])
def test_columns_with_a_diagonal_alone_are_solved_too(downstream):
    rng = np.random.default_rng(3)
    shape = (8, 7)
    centre, south, north, west, east = stencil(rng, shape)
    empty = (
        rng.random(shape) < 0.5
    )  # cells whose column reaches one neighbour downstream, like cavitated ones
    ahead = north if downstream == "up" else south
    shift = 1 if downstream == "up" else -1
    ahead[np.roll(empty, -shift, 1)] = 0.0
    west[np.roll(empty, 1, 0)] = 0.0
    east[np.roll(empty, -1, 0)] = 0.0
    solver = BlockTridiagonal(shape)
    solver.factorise((centre, south, north, west, east))
    right = rng.standard_normal((1, *shape))
    x = solver.solve(right.copy())[0]
    assert (
        np.abs(product((centre, south, north, west, east), x) - right[0]).max()
        <= 1e-11 * np.abs(x).max()
    )


def test_nothing_of_an_earlier_factorisation_is_left():
    rng = np.random.default_rng(4)
    coefficients, right = stencil(rng, (5, 6)), rng.standard_normal((1, 5, 6))
    fresh, used = BlockTridiagonal((5, 6)), BlockTridiagonal((5, 6))
    used.factorise(tuple(np.full((5, 6), np.nan) for _ in range(5)))
    for solver in (fresh, used):
        solver.factorise(coefficients)
    assert np.array_equal(fresh.solve(right.copy()), used.solve(right.copy()))
