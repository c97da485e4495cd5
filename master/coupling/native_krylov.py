"""GMRES that remembers, as loops for machine code: `methods.krylov`, where its equations stand."""

from typing import NamedTuple

import numpy as np

from ..fmi.compiled import compiled
from .methods.krylov import MORE, PER_DIRECTION
from .native_block import keep


@compiled
def size_of(vector):
    """2-norm."""
    return np.sqrt(vector @ vector)


@compiled
def is_within(vector: np.ndarray, limits: np.ndarray):
    """Whether no element is larger than it may be."""
    for i in range(len(vector)):
        if not abs(vector[i]) <= limits[i]:
            return False
    return True


@compiled
def factorise(gram: np.ndarray, noise: float):
    """Cholesky factor of Z' Z + n I, shape (pairs, pairs), as lower triangle."""
    n = len(gram)
    factor = np.zeros((n, n))
    for i in range(n):
        keep(factor[i, : i + 1], gram[i])
        factor[i, i] += noise
    column = np.empty(n)
    for j in range(n):
        factor[j, j] = np.sqrt(factor[j, j])
        for i in range(j + 1, n):
            factor[i, j] /= factor[j, j]
            column[i] = factor[i, j]
        for i in range(j + 1, n):
            share = column[i]
            rest = factor[i, j + 1 : i + 1]  # a slice: its indices are known to be no negative ones
            other = column[j + 1 : i + 1]
            for k in range(len(rest)):
                rest[k] -= share * other[k]
    return factor


@compiled
def solve_factored(factor, x):
    """x of F F' x = b, in the place of b; of a larger factor its first rows and columns."""
    n = len(x)
    for i in range(n):
        rest = x[i]
        for k in range(i):
            rest -= factor[i, k] * x[k]
        x[i] = rest / factor[i, i]
    for i in range(n - 1, -1, -1):
        last = x[i] / factor[i, i]
        x[i] = last
        for k in range(i):
            x[k] -= factor[i, k] * last


@compiled
def length_of_inverse(factor):
    """Squared Frobenius norm of the inverse of a lower triangle."""
    n = len(factor)
    total = 0.0
    inverse = np.zeros((n, n))
    for i in range(n):
        row = inverse[i]
        for k in range(i):
            share = factor[i, k]
            above = inverse[k]
            for j in range(k + 1):
                row[j] += share * above[j]
        for j in range(i):
            row[j] /= -factor[i, i]
        row[i] = 1.0 / factor[i, i]
        for j in range(i + 1):
            total += row[j] ** 2
    return total


@compiled
def in_use(gram: np.ndarray, noise: float, oldest: int):
    """Rows of the pairs in use, the newest first, and the factor of Z' Z + n I of them and of older
    ones, in that order; what is older than Eq. (Q11) allows is out of use.

    Parameters
    ----------
    gram : ndarray, shape (pairs, pairs)
        Z' Z of those in use, 0 elsewhere.
    noise : float
    oldest : int
        The row that is overwritten next.
    """
    pairs = len(gram)
    known = 0
    for row in range(pairs):
        if gram[row, row] != 0.0:
            known += 1
    rows = np.empty(known, np.int64)
    for k in range(known):
        rows[k] = (oldest - 1 - k) % pairs
    ordered = np.empty((known, known))
    for k in range(known):
        for q in range(known):
            ordered[k, q] = gram[rows[k], rows[q]]
    factor = factorise(ordered, noise)
    directions = known - noise * length_of_inverse(factor)
    used = min(known, int(np.ceil(PER_DIRECTION * directions + MORE)))  # Eq. (Q11)
    for k in range(used, known):
        for other in range(pairs):
            gram[rows[k], other] = 0.0
            gram[other, rows[k]] = 0.0
    return rows[:used], factor


@compiled
def blocks_of(rows: np.ndarray, pairs: int):
    """First row and end of the one or two blocks in which rows lie that go down by one, or from 0
    to the last, shape (2, 2).
    """
    blocks = np.zeros((2, 2), np.int64)
    used = len(rows)
    if used == pairs:
        blocks[0, 1] = pairs
    elif used > 0:
        blocks[0, 0] = rows[used - 1]
        blocks[0, 1] = rows[0] + 1
        if rows[0] < rows[used - 1]:
            blocks[0, 1] = pairs
            blocks[1, 1] = rows[0] + 1
    return blocks


@compiled
def project(r: np.ndarray, images: np.ndarray, rows: np.ndarray, projected: np.ndarray):
    """Z' r of the pairs in use into `projected`, shape (pairs,)."""
    blocks = blocks_of(rows, len(images))
    for b in range(2):
        first = blocks[b, 0]
        end = blocks[b, 1]
        if end > first:
            keep(projected[first:end], images[first:end] @ r)


@compiled
def precondition(
    r: np.ndarray,
    images: np.ndarray,
    differences: np.ndarray,
    rows: np.ndarray,
    factor: np.ndarray,
    projected: np.ndarray,
    out: np.ndarray,
):
    """P r into `out`, Eq. (Q7), and Z' r into `projected`, shape (pairs,)."""
    project(r, images, rows, projected)
    shares = np.empty(len(rows))
    for k in range(len(rows)):
        shares[k] = projected[rows[k]]
    solve_factored(factor, shares)
    by_row = np.empty(len(images))
    for k in range(len(rows)):
        by_row[rows[k]] = shares[k]
    keep(out, r)
    blocks = blocks_of(rows, len(images))
    for b in range(2):
        first = blocks[b, 0]
        end = blocks[b, 1]
        if end > first:
            change = by_row[first:end] @ differences[first:end]
            for i in range(len(r)):
                out[i] += change[i]


@compiled
def orthogonalise(vector: np.ndarray, basis: np.ndarray, column: np.ndarray):
    """Take from a vector its shares in an orthonormal basis, shape (m, n), in its place.

    The shares are added to `column`, shape (>= m + 1,), what is left of the length behind them.
    """
    m = len(basis)
    for _ in range(2):  # a second pass keeps the basis orthogonal to round-off
        shares = basis @ vector
        along = shares @ basis
        for k in range(m):
            column[k] += shares[k]
        for i in range(len(vector)):
            vector[i] -= along[i]
    column[m] = size_of(vector)


@compiled
def least_squares(hessenberg: np.ndarray, size: float, count: int):
    """Weights of `count` directions by which |size e_0 - H w| is least; H by columns, shape
    (>= count, >= count + 1). A direction that adds nothing has the weight 0.
    """
    triangle = np.empty((count, count + 1))
    for j in range(count):
        keep(triangle[j], hessenberg[j])
    right = np.zeros(count + 1)
    right[0] = size
    for k in range(count):
        a = triangle[k, k]
        b = triangle[k, k + 1]
        length = np.hypot(a, b)
        if length == 0.0:
            continue
        cosine = a / length
        sine = b / length
        for j in range(k, count):
            upper = triangle[j, k]
            lower = triangle[j, k + 1]
            triangle[j, k] = cosine * upper + sine * lower
            triangle[j, k + 1] = cosine * lower - sine * upper
        right[k + 1] = -sine * right[k]
        right[k] = cosine * right[k]
    weights = np.zeros(count)
    for k in range(count - 1, -1, -1):
        if triangle[k, k] != 0.0:
            weights[k] = right[k] / triangle[k, k]
            for i in range(k):
                right[i] -= triangle[k, i] * weights[k]
    return weights


class Arnoldi(NamedTuple):
    """As `krylov.Arnoldi`, H by columns: hessenberg, shape (>= count, >= count + 1)."""

    hessenberg: np.ndarray
    projected: np.ndarray


@compiled
def learn(
    directions: np.ndarray,
    products: np.ndarray,
    arnoldi: Arnoldi,
    images: np.ndarray,
    differences: np.ndarray,
    gram: np.ndarray,
    oldest: np.ndarray,
):
    """Put pairs of direction and product in the place of the oldest; `oldest`, shape (1,), is the
    row that is overwritten next. Their inner products follow from Eq. (Q10).
    """
    pairs = len(images)
    count = len(products)
    sizes = np.empty(count)
    full = 0
    for k in range(count):
        sizes[k] = size_of(products[k])
        if sizes[k] != 0.0:
            full += 1
    passed_over = max(full - pairs, 0)
    first = int(oldest[0])
    newest = 0
    product_of = np.full(pairs, -1)  # of a row that is new
    for k in range(count):
        if sizes[k] == 0.0:
            continue
        if passed_over > 0:
            passed_over -= 1
            continue
        row = (first + newest) % pairs
        product_of[row] = k
        newest += 1
        image = images[row]
        difference = differences[row]
        for i in range(len(image)):
            image[i] = products[k, i] / sizes[k]
            difference[i] = directions[k, i] / sizes[k] - image[i]
    hessenberg, projected = arnoldi
    for row in range(pairs):
        k = product_of[row]
        if k < 0:
            continue
        for other in range(pairs):
            q = product_of[other]
            total = 0.0  # Eq. (Q10)
            if q < 0:
                for i in range(k + 2):
                    total += hessenberg[k, i] * projected[i, other]
            else:
                for i in range(min(k, q) + 2):
                    total += hessenberg[k, i] * hessenberg[q, i] / sizes[q]
            gram[row, other] = total / sizes[k]
            gram[other, row] = gram[row, other]
    oldest[0] = float((first + newest) % pairs)
