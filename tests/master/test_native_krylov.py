"""The linear algebra of the coupled FMU without Python beside that of `methods.krylov`, its loops
run as written.
"""

import numpy as np
import pytest

from piston_cosim.master.coupling import native_krylov
from piston_cosim.master.coupling.methods import krylov
from piston_cosim.master.coupling.methods.krylov import NOISE, RecycledGmres, orthogonal
from piston_cosim.master.fmi.compiled import Kernel


@pytest.fixture(autouse=True)
def interpreted(monkeypatch):
    """Kernels as written, not compiled."""
    for kernel in vars(native_krylov).values():
        if isinstance(kernel, Kernel):
            monkeypatch.setitem(kernel.__dict__, "dispatcher", kernel.py_func)


def remembered(rng, kept, n, filled):
    """A memory that has learned so many pairs, more than it keeps if need be."""
    memory = RecycledGmres(7)
    memory.images, memory.differences = np.zeros((2, kept, n))
    memory.gram = np.zeros((kept, kept))
    for _ in range(filled):
        one, image = rng.standard_normal((2, 1, n))
        memory._learn(one, image, krylov.Arnoldi(*of_products(rng, image, memory.images)))
    return memory


def as_native(memory):
    """Pairs in use, and their factor, of a memory that does not notice."""
    return native_krylov.in_use(memory.gram.copy(), NOISE, memory.oldest)


@pytest.mark.parametrize("filled", [4, 9, 13])
def test_preconditioner(filled):
    """Eq. (Q7), with fewer pairs than fit, with more than there are directions, of which only the
    noise makes a regular matrix, and with pairs that go round the end.
    """
    rng = np.random.default_rng(1)
    memory = remembered(rng, 9, 6, filled)
    r = rng.standard_normal(6)
    rows, factor = as_native(memory)
    used = min(filled, 9)  # 6 directions would allow 11
    assert list(rows) == [(filled - 1 - k) % 9 for k in range(used)]
    whole = memory.gram[np.ix_(rows, rows)] + NOISE * np.eye(used)
    np.testing.assert_allclose(factor @ factor.T, whole, atol=1e-14)
    found, projected = np.empty(6), np.zeros(9)
    pairs = memory.images, memory.differences
    native_krylov.precondition(r, *pairs, rows, factor, projected, found)
    np.testing.assert_allclose(projected, memory.images @ r, rtol=1e-13)
    inverse = np.linalg.inv(whole)
    expected = r + inverse @ projected[rows] @ memory.differences[rows]  # Eq. (Q7)
    assert np.abs(found - r).max() > 0.1  # it does something
    # a matrix of condition 1e6 factorised in one, inverted in the other
    np.testing.assert_allclose(found, expected, rtol=1e-8)


@pytest.mark.parametrize("known", [3, 10, 17])
def test_no_more_pairs_than_their_directions_need(known):
    """Eq. (Q11) in a plane: 1.3 x 2 + 4 = 6.6 pairs, the seven newest, what is older forgotten by
    both; P is that of these alone.
    """
    rng = np.random.default_rng(5)
    pairs, n = 12, 40
    plane = np.linalg.qr(rng.standard_normal((n, 2)))[0].T
    memory = RecycledGmres(7)
    memory.images, memory.differences = np.zeros((2, pairs, n))
    memory.gram = np.zeros((pairs, pairs))
    for k in range(known):
        place = k % pairs
        memory.images[place] = np.array([np.cos(k), np.sin(k)]) @ plane
        memory.differences[place] = rng.standard_normal(n)
    memory.gram = memory.images @ memory.images.T
    memory.oldest = known % pairs
    own = memory.gram.copy()
    rows, factor = native_krylov.in_use(own, NOISE, memory.oldest)
    theirs, other = memory._in_use()
    used = min(known, 7)
    assert list(rows) == list(theirs) == [(known - 1 - k) % pairs for k in range(used)]
    np.testing.assert_array_equal(own, memory.gram)
    in_use = np.isin(np.arange(pairs), rows)
    assert (np.diag(own)[~in_use] == 0.0).all() and not own[in_use][:, ~in_use].any()
    np.testing.assert_allclose(np.diag(own)[in_use], 1.0, rtol=1e-14)
    np.testing.assert_allclose(np.tril(factor)[:used, :used], np.tril(other), rtol=1e-9)
    # nothing of a pair out of use is looked at
    for which in (memory.images, memory.differences):
        which[~in_use] = np.nan
    r, found, projected = rng.standard_normal(n), np.empty(n), np.zeros(pairs)
    kept = memory.images, memory.differences
    native_krylov.precondition(r, *kept, rows, factor, projected, found)
    z, d = memory.images[rows], memory.differences[rows]
    expected = r + np.linalg.solve(z @ z.T + NOISE * np.eye(used), z @ r) @ d  # Eq. (Q7)
    np.testing.assert_allclose(found, expected, rtol=1e-8, atol=1e-8)
    assert not projected[~in_use].any()
    # and as few are known in the next solve
    assert list(native_krylov.in_use(own, NOISE, memory.oldest)[0]) == list(rows)


def test_every_element_is_looked_at():
    limits = np.array([1.0, 0.5, np.inf])
    assert native_krylov.is_within(np.array([-1.0, 0.5, 1e9]), limits)
    for beyond in ([-1.1, 0.0, 0.0], [0.0, 0.51, 0.0], [0.0, np.nan, 0.0]):
        assert not native_krylov.is_within(np.array(beyond), limits)


def test_orthogonal_part():
    rng = np.random.default_rng(2)
    basis = np.linalg.qr(rng.standard_normal((8, 3)))[0].T
    vector = 10.0 * basis[1] + 1e-6 * rng.standard_normal(8)
    ours, theirs = vector.copy(), np.zeros(5)
    column = np.zeros(5)
    native_krylov.orthogonalise(ours, basis, column)
    expected = orthogonal(vector, basis, theirs)
    assert np.abs(basis @ ours).max() < 1e-20  # of 1e-6: the second pass
    np.testing.assert_allclose(ours, expected, atol=1e-15 * 10)
    np.testing.assert_allclose(column[:4], theirs[:4], rtol=1e-9)


def test_least_squares():
    """By hand: |1 - 3 w|^2 + |4 w|^2 is least at w = 3/25; then beside numpy's."""
    assert native_krylov.least_squares(np.array([[3.0, 4.0]]), 1.0, 1) == pytest.approx(3 / 25)
    rng = np.random.default_rng(3)
    whole = np.triu(rng.standard_normal((6, 5)), -1)
    target = np.zeros(6)
    target[0] = 2.5
    expected = np.linalg.lstsq(whole, target, rcond=None)[0]
    found = native_krylov.least_squares(np.ascontiguousarray(whole.T), 2.5, 5)
    np.testing.assert_allclose(found, expected, rtol=1e-12)


def of_products(rng, products, images):
    """Eq. (Q10) of any products: a basis begun with any vector, the k-th within k + 2 of it."""
    count, n = products.shape
    basis, triangle = np.linalg.qr(np.vstack([rng.standard_normal(n), products]).T)
    hessenberg = np.zeros((count + 1, count))
    hessenberg[: len(triangle)] = triangle[:, 1:]
    projected = np.zeros((count + 1, len(images)))
    projected[: basis.shape[1]] = (images @ basis).T
    return hessenberg, projected


@pytest.mark.parametrize("filled, count", [(0, 3), (4, 4), (6, 9)])
def test_what_is_kept(filled, count):
    """Fewer pairs than fit, as many as make it begin again, more than fit at once; one of them is
    nothing and is left out.
    """
    rng = np.random.default_rng(4)
    kept, n = 7, 5
    memory = remembered(rng, kept, n, filled)
    ours = memory.images.copy(), memory.differences.copy(), memory.gram.copy()
    oldest = np.array([float(memory.oldest)])
    directions, products = rng.standard_normal((2, count, n))
    products[1] = 0.0
    hessenberg, projected = of_products(rng, products, ours[0])
    by_columns = native_krylov.Arnoldi(np.ascontiguousarray(hessenberg.T), projected)
    native_krylov.learn(directions, products, by_columns, *ours, oldest)
    memory._learn(directions, products, krylov.Arnoldi(hessenberg, projected))
    for found, expected in zip(ours, (memory.images, memory.differences, memory.gram)):
        np.testing.assert_allclose(found, expected, rtol=1e-13, atol=1e-15)
    np.testing.assert_allclose(memory.gram, memory.images @ memory.images.T, atol=1e-14)
    assert oldest[0] == memory.oldest
