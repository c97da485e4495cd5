"""The parts of GMRES compared with numpy's linear algebra."""

from types import SimpleNamespace

import numpy as np
import pytest

from piston_cosim.master.coupling.methods import krylov
from piston_cosim.master.coupling.methods.iteration import excess
from piston_cosim.master.coupling.methods.krylov import NOISE, Goal, Space, no_pairs


def of_products(rng, products, images):
    """Eq. (Q10) of any products: a basis begun with any vector, the k-th within k + 2 of it."""
    count, n = products.shape
    basis, triangle = np.linalg.qr(np.vstack([rng.standard_normal(n), products]).T)
    hessenberg = np.zeros((count, count + 1))
    hessenberg[:, : len(triangle)] = triangle[:, 1:].T
    projected = np.zeros((count + 1, len(images)))
    projected[: basis.shape[1]] = (images @ basis).T
    return hessenberg, projected


def remembered(rng, kept, n, filled):
    """Pairs that have been learned one by one, more than are kept if need be."""
    pairs = no_pairs(n, kept)._replace(
        products=np.zeros((kept, n)), differences=np.zeros((kept, n)), gram=np.zeros((kept, kept))
    )
    for _ in range(filled):
        direction, product = rng.standard_normal((2, 1, n))
        known = of_products(rng, product, pairs.products)
        krylov.learn(pairs, Space(direction, product, product, *known), 1)
    return pairs


def preconditioned(pairs, used):
    """Rows of the pairs in use, P r and r."""
    rows = (int(pairs.oldest[0]) - 1 - np.arange(used)) % len(pairs.gram)
    r = np.random.default_rng(6).standard_normal(pairs.products.shape[1])
    inverse = krylov.pairs_in_use(pairs)
    assert len(inverse) == used
    found, projected = np.empty(len(r)), np.zeros(len(pairs.gram))
    krylov.precondition(pairs, inverse, r, projected, found)
    np.testing.assert_allclose(projected[rows], pairs.products[rows] @ r, rtol=1e-12)
    assert not np.delete(projected, rows).any()
    z, d = pairs.products[rows], pairs.differences[rows]
    whole = z @ z.T + NOISE * np.eye(used)
    np.testing.assert_allclose(
        (inverse.T @ inverse)[np.ix_(rows, rows)], np.linalg.inv(whole), rtol=1e-8
    )
    expected = r + np.linalg.solve(whole, z @ r) @ d  # Eq. (Q7)
    assert np.abs(found - r).max() > 0.1  # it does something
    # a matrix of condition 1e6 factorised in one, solved with in the other
    np.testing.assert_allclose(found, expected, rtol=1e-8, atol=1e-8)
    return rows


@pytest.mark.parametrize("filled", [4, 9, 13])
def test_preconditioner(filled):
    """The preconditioner follows Eq. (Q7).

    The cases: fewer pairs than fit, pairs that wrap around the end, and more pairs than directions.
    In the last one only the noise makes the matrix regular.
    """
    pairs = remembered(np.random.default_rng(1), 9, 6, filled)
    preconditioned(pairs, min(filled, 9))  # 6 directions would allow 11


@pytest.mark.parametrize("known", [3, 10, 17])
def test_no_more_pairs_than_their_directions_need(known):
    """Eq. (Q11) in a plane: 1.3 x 2 + 4 = 6.6 pairs, so that the seven newest are used.

    Older pairs are not read, and no more than seven are known in the next solve.
    """
    rng = np.random.default_rng(5)
    kept, n, used = 12, 40, min(known, 7)
    plane = np.linalg.qr(rng.standard_normal((n, 2)))[0].T
    pairs = no_pairs(n, kept)
    pairs.oldest[0] = known % kept
    for k in range(known):
        pairs.products[k % kept] = np.array([np.cos(k), np.sin(k)]) @ plane
        pairs.differences[k % kept] = rng.standard_normal(n)
    pairs.gram[:] = pairs.products @ pairs.products.T
    assert len(krylov.pairs_in_use(pairs)) == used
    for which in pairs[:2]:
        assert which.any(axis=1).sum() == used
        which[np.diag(pairs.gram) == 0.0] = np.nan
    rows = preconditioned(pairs, used)
    np.testing.assert_allclose(np.diag(pairs.gram)[rows], 1.0, rtol=1e-14)
    assert not np.delete(pairs.gram, rows, axis=0).any()
    assert not np.delete(pairs.gram, rows, axis=1).any()


def test_every_element_is_looked_at():
    linear = SimpleNamespace(limits=np.array([1.0, 0.5, np.inf]))
    assert excess(linear, np.array([-1.0, 0.5, 1e9])) <= 1.0
    for beyond in ([-1.1, 0.0, 0.0], [0.0, 0.51, 0.0], [0.0, np.nan, 0.0]):
        assert excess(linear, np.array(beyond)) > 1.0


def test_orthogonal_part():
    rng = np.random.default_rng(2)
    basis = np.linalg.qr(rng.standard_normal((8, 3)))[0].T
    rest = 1e-6 * rng.standard_normal(8)
    column = np.zeros(5)
    found = krylov.orthogonal(10.0 * basis[1] + rest, basis, column)
    assert np.abs(basis @ found).max() < 1e-20  # of 1e-6: the second pass
    expected = rest - basis.T @ (basis @ rest)
    np.testing.assert_allclose(found, expected, atol=1e-14)
    np.testing.assert_allclose(column[:3], [0.0, 10.0, 0.0] + basis @ rest, atol=1e-14)
    assert column[3] == pytest.approx(np.linalg.norm(expected), rel=1e-8) and column[4] == 0.0


def test_least_squares():
    """By hand: |1 - 3 w|^2 + |4 w|^2 is least at w = 3/25; then beside numpy's."""
    assert krylov.least_squares(np.array([[3.0, 4.0]]), 1.0, 1) == pytest.approx(3 / 25)
    rng = np.random.default_rng(3)
    whole = np.triu(rng.standard_normal((6, 5)), -1)
    target = np.array([2.5, 0.0, 0.0, 0.0, 0.0, 0.0])
    expected = np.linalg.lstsq(whole, target, rcond=None)[0]
    found = krylov.least_squares(np.ascontiguousarray(whole.T), 2.5, 5)
    np.testing.assert_allclose(found, expected, rtol=1e-12)
    whole[:, 3] = 0.0  # a direction that adds nothing
    found = krylov.least_squares(np.ascontiguousarray(whole[:5, :4].T), 2.5, 4)
    expected = np.linalg.lstsq(whole[:4, :3], target[:4], rcond=None)[0]
    np.testing.assert_allclose(found, [*expected, 0.0], rtol=1e-12)


def test_the_factor_in_kernels_is_that_of_python():
    matrix = np.cov(np.random.default_rng(8).standard_normal((6, 20)))
    factor = krylov.inverse_factor(matrix)
    np.testing.assert_allclose(factor.T @ factor, np.linalg.inv(matrix), rtol=1e-12)
    np.testing.assert_allclose(krylov.inverse_factor.kernel.py_func(matrix), factor, rtol=1e-12)


def test_products_that_are_not_finite_are_not_used():
    """Nor are older ones, because the newest come first."""
    pairs = remembered(np.random.default_rng(9), 5, 8, 3)
    nan = np.full((1, 8), np.nan)
    known = np.full((1, 2), np.nan), np.full((2, 5), np.nan)
    krylov.learn(pairs, Space(nan, nan, nan, *known), 1)
    assert krylov.pairs_in_use(pairs).shape == (0, 5)


@pytest.mark.parametrize("filled, count", [(0, 3), (4, 4), (6, 9)])
def test_what_is_kept(filled, count):
    """The newest pairs that fit are kept.

    The cases: fewer than fit, enough to wrap around, and more than fit at once.
    One pair is zero and is left out.
    """
    rng = np.random.default_rng(4)
    kept, n = 7, 5
    pairs = remembered(rng, kept, n, filled)
    directions, products = rng.standard_normal((2, count, n))
    products[1] = 0.0
    expected = [[row.copy() for row in which] for which in pairs[:2]]
    place = filled
    newest = [k for k in range(count) if k != 1][-kept:]
    for k in newest:
        size = np.linalg.norm(products[k])
        expected[0][place % kept] = products[k] / size
        expected[1][place % kept] = (directions[k] - products[k]) / size
        place += 1
    known = of_products(rng, products, pairs.products)
    krylov.learn(pairs, Space(directions, products, products, *known), count)
    for found, rows in zip(pairs[:2], expected):
        np.testing.assert_allclose(found, rows, rtol=1e-13, atol=1e-15)
    np.testing.assert_allclose(pairs.gram, pairs.products @ pairs.products.T, atol=1e-14)
    assert pairs.oldest[0] == place % kept


def test_a_product_that_is_refused_ends_the_solve():
    rng = np.random.default_rng(7)
    matrix = np.eye(12) + 0.2 * rng.standard_normal((12, 12))

    def stretched(system, k, v, out):
        out[:] = system @ v
        return k < 4

    def never(system, residual):
        return 2.0

    pairs = remembered(rng, 9, 12, 0)
    for most, is_answered in ((4, True), (5, False)):
        goal, right = Goal(1e-9, 0.0), rng.standard_normal(12)
        solved = krylov.minimise(stretched, never, matrix, right, goal, pairs, most)
        assert (solved.is_answered, len(solved.weights)) == (is_answered, 4 * is_answered)
