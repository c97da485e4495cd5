"""GMRES that is preconditioned by the products of earlier solves.

Python runs it as written, native FMUs compile it.
"""

from typing import Annotated, Any, NamedTuple

import numpy as np

from ...fmi.block import keep
from ...fmi.compiled import compilable, standing_for
from ..vector import put

STORED_PAIRS = 80
"""Pairs kept from one solve to the next. The numerical example with 60 modes a body, 200 steps from
rest: 5600 products with 40 pairs, 3800 with 60 to 80, 4000 with 100, 4800 with 160; after the first
90 steps 12.7 an update with 40, 6.8 with 80, 6.4 with 160.
"""

NOISE = 1e-5
"""Noise, relative to the squared length of a product: differences of nearly parallel products of
different times.
"""

KEPT_OF_COORDINATES, NOISE_OF_COORDINATES = 60, 3e-7
"""The same for the coordinates of bodies, whose products change faster: the shapes of a block stay
with its bore, while the film moves. Products of the numerical example, 360 steps from rest: 2711;
2819 with noise 3e-8, 2834 with 80 pairs, 3801 with noise 1e-5.
"""

PAIRS_PER_DIRECTION = 1.3
EXTRA_PAIRS = 4.0
"""Pairs in use: `PAIRS_PER_DIRECTION` for each direction that they span, and `EXTRA_PAIRS` more.

Products of the numerical example with rigid bodies (4 directions; 180 steps from rest),
`floating_pin` (10; 60 deg) and `fired_motorcycle` (40; 120 deg) with all of `STORED_PAIRS`: 504,
331 and 3076. With 2 for each and 2 more: 416, 277 and 3001. With these: 416, 272 and 2824. With 60
modes a body (70 directions), all are in use.
"""

Array = np.ndarray
Square = Annotated[Array, "pairs, pairs"]
Rows = Annotated[Array, "pairs, unknowns"]


class Goal(NamedTuple):
    """Bound on a residual: its length is at most `size`, or at most `limit` and `excess` is 1."""

    size: float
    limit: float


class Pairs(NamedTuple):
    """Directions and their products from earlier solves.

    products, differences : Z and V - Z by rows, as many as are kept at most, 0 where nothing is
    known yet; in single precision round-off would grow to what two solves differ by. gram : Z' Z
    of those in use, 0 elsewhere. oldest : the row that is overwritten next; those in use end before
    it. is_whole : 1 once a field of a mirrored wire has lost its symmetry, so that all are
    unknowns. noise : share of a product's squared length, as `NOISE`.
    """

    products: Rows
    differences: Rows
    gram: Square
    oldest: Annotated[Array, "1"]
    is_whole: Annotated[Array, "1"]
    noise: Annotated[Array, "1"]


class Space(NamedTuple):
    """Directions of a solve by rows, their products, and an orthonormal basis of the products.

    Eq. (Q10):  product_k = sum over i <= k + 1 of  H_ki basis_i

    hessenberg : ndarray, shape (>= count, >= count + 1), H;
    projected : ndarray, shape (>= count + 1, pairs), Z' basis_i.
    """

    directions: Array
    products: Array
    basis: Array
    hessenberg: Array
    projected: Array


class KrylovSolution(NamedTuple):
    """Solution x = sum of weights times the directions, in order of their products.

    Without a product it is the right-hand side, which is within the goal.

    is_answered : whether every product was there.
    """

    x: Array
    weights: Array
    space: Space
    is_answered: bool


@compilable
def minimise(
    product: Any, excess: Any, system: Any, right: Array, goal: Goal, pairs: Pairs, most: int
):
    """Return the solution of A x = right within `goal`, or the best of `most` products.

    The least residual r_k in the space of k products needs no solve: the Hessenberg matrix has
    one vector g with g' H = 0, of which every product gives another element.

    Eq. (Q9):  r_k = |right| / |g|^2 sum_i g_i basis_i,   |r_k| = |right| / |g|,
               g_0 = 1,   g_k+1 = -sum_i H_ki g_i / H_k,k+1

    Parameters
    ----------
    product : callable(system, k, v, out)
        Writes the k-th product A v; whether there is one.
    excess : callable(system, residual)
        Returns the largest ratio of an element of a residual to its limit. Above 1, it is called
        again when the norm of the residual has decreased by half of this ratio.
    system : object
        First argument of both.
    right : ndarray, shape (n,)
    goal : Goal
    pairs : Pairs
    most : int

    Returns
    -------
    KrylovSolution
    """
    n = len(right)
    size = length(right)
    if size <= goal.size or (size <= goal.limit and excess(system, right) <= 1.0):
        return KrylovSolution(right.copy(), np.zeros(0), space_of(0, n, len(pairs.gram)), True)
    limit = goal.limit
    inverse = pairs_in_use(pairs)
    space = space_of(most, n, len(pairs.gram))
    basis = space.basis
    null = np.zeros(most + 1)
    keep(basis[0], right / size)
    null[0] = 1.0
    count = min(most, 0)  # numba compiles `product` anew for a literal
    while count < most:
        direction = space.directions[count]
        precondition(pairs, inverse, basis[count], space.projected[count], direction)
        if not product(system, count, direction, space.products[count]):
            return KrylovSolution(right, np.zeros(0), space, False)
        column = space.hessenberg[count]
        rest = orthogonal(space.products[count], basis[: count + 1], column)
        count += 1
        if column[count] == 0.0:
            break
        keep(basis[count], rest / column[count])
        null[count] = -(column[:count] @ null[:count]) / column[count]  # Eq. (Q9)
        known = null[: count + 1]
        if size <= goal.size * length(known):
            break
        left = size / length(known)
        if left <= limit:
            residual = (known @ basis[: count + 1]) * (size / (known @ known))  # Eq. (Q9)
            above = excess(system, residual)
            if above <= 1.0:
                break
            limit = min(limit, 2.0 * left / above)
    weights = least_squares(space.hessenberg, size, count)
    if space.hessenberg[count - 1, count] != 0.0:
        project(pairs, len(inverse), basis[count], space.projected[count])
    return KrylovSolution(weights @ space.directions[:count], weights, space, True)


@compilable
def space_of(most: int, n: int, pairs: int):
    """Return an empty space for `most` products of vectors of n elements."""
    whole = np.empty((3, most + 1, n))  # in one piece, which malloc reuses
    return Space(
        whole[0],
        whole[1],
        whole[-1],
        np.zeros((most, most + 1)),
        np.zeros((most + 1, pairs)),
    )


@compilable
def length(vector: Array) -> Any:
    """Return the 2-norm."""
    return np.sqrt(vector @ vector)


@compilable
def _inverse_factor(matrix: Array):
    inverse = np.zeros(matrix.shape)
    for i in range(len(matrix)):
        # Cholesky's factor row by row, and its inverse with it
        share = inverse[:i] @ matrix[i]
        pivot = np.sqrt(matrix[i, i] - share @ share)
        keep(inverse[i], (share @ inverse[:i]) / -pivot)
        inverse[i, i] = 1.0 / pivot
    return inverse


@standing_for(_inverse_factor)
def inverse_factor(matrix: Array):
    """Return F, a lower triangle, of the inverse F' F of a positive definite matrix."""
    return np.linalg.inv(np.linalg.cholesky(matrix))


@compilable
def pairs_in_use(pairs: Pairs):
    """Return F of (Z' Z + n I)^-1 = F' F, a row for each pair in use, the newest first.

    Its columns are the rows of `pairs`. Pairs older than Eq. (Q11) allows are removed: with zeros
    in their place, a saved state is small.
    """
    gram = pairs.gram
    capacity = len(gram)
    rows: Array = (int(pairs.oldest[0]) - 1 - np.arange(capacity)) % capacity
    known = 0
    while known < capacity and gram[rows[known], rows[known]] > 0.0:  # not if NaN
        known += 1
    rows = rows[:known]
    noise = pairs.noise[0]
    factor = inverse_factor(gram[rows][:, rows] + noise * np.eye(known))
    flat = factor.reshape(factor.size)
    directions = known - noise * (flat @ flat)
    used = min(known, int(np.ceil(PAIRS_PER_DIRECTION * directions + EXTRA_PAIRS)))  # Eq. (Q11)
    inverse = np.zeros((used, capacity))
    for i in range(used):
        put(inverse[i], rows, factor[i])
    for row in rows[used:]:
        keep(gram[:, row], np.zeros(capacity))
        for table in (gram, pairs.products, pairs.differences):
            keep(table[row], np.zeros(len(table[row])))
    return inverse


@compilable
def project(pairs: Pairs, used: int, r: Array, projected: Array):
    """Write Z' r of the pairs in use into `projected`, shape (pairs,)."""
    oldest = int(pairs.oldest[0])
    first = oldest - used  # they go round the end where it is below 0
    before, end = max(first, 0), len(projected)
    if oldest > before:
        keep(projected[before:oldest], pairs.products[before:oldest] @ r)
    if first < 0:
        keep(projected[first + end :], pairs.products[first + end :] @ r)


@compilable
def precondition(pairs: Pairs, inverse: Array, r: Array, projected: Array, out: Array):
    """Write P r into `out`, Eq. (Q7), and Z' r into `projected`, shape (pairs,)."""
    used = len(inverse)
    keep(out, r)
    if used == 0:
        return
    project(pairs, used, r, projected)
    shares = (inverse @ projected) @ inverse
    rest = projected - (pairs.gram @ shares + pairs.noise[0] * shares)  # what round-off has left
    shares = shares + (inverse @ rest) @ inverse
    oldest = int(pairs.oldest[0])
    first = oldest - used
    before, end = max(first, 0), len(shares)
    if oldest > before:
        keep(out, out + shares[before:oldest] @ pairs.differences[before:oldest])  # Eq. (Q7)
    if first < 0:
        keep(out, out + shares[first + end :] @ pairs.differences[first + end :])


@compilable
def orthogonal(vector: Array, basis: Array, column: Array):
    """Return a vector without its shares in an orthonormal basis, shape (m, n).

    The shares are added to `column`, shape (>= m + 1,), followed by the remaining length.
    """
    m = len(basis)
    for _ in range(2):  # a second pass keeps the basis orthogonal to round-off
        shares = basis @ vector
        keep(column[:m], column[:m] + shares)
        vector = vector - shares @ basis
    column[m] = length(vector)
    return vector


@compilable
def least_squares(hessenberg: Array, size: float, count: int):
    """Return the weights of `count` directions that minimise |size e_0 - H' w|.

    H has the shape (>= count, >= count + 1). A direction that adds nothing has the weight 0.
    """
    triangle = hessenberg[:count, : count + 1].copy()
    right = np.zeros(count + 1)
    right[0] = size
    for k in range(count):
        hypotenuse = np.hypot(triangle[k, k], triangle[k, k + 1])
        if hypotenuse == 0.0:
            continue
        cosine, sine = triangle[k, k] / hypotenuse, triangle[k, k + 1] / hypotenuse
        upper, lower = triangle[k:, k].copy(), triangle[k:, k + 1].copy()
        keep(triangle[k:, k], cosine * upper + sine * lower)
        keep(triangle[k:, k + 1], cosine * lower - sine * upper)
        right[k + 1] = -sine * right[k]
        right[k] *= cosine
    weights = np.zeros(count)
    for k in range(count - 1, -1, -1):
        if triangle[k, k] != 0.0:
            weights[k] = right[k] / triangle[k, k]
            keep(right[:k], right[:k] - weights[k] * triangle[k, :k])
    return weights


@compilable
def learn(pairs: Pairs, space: Space, count: int):
    """Replace the oldest pairs by those of a solve.

    Their inner products follow from those with the basis, because products are sums of the basis by
    Eq. (Q10).
    """
    capacity = len(pairs.gram)
    sizes = np.empty(count)
    full = 0
    for k in range(count):
        sizes[k] = length(space.products[k])
        full += sizes[k] != 0.0
    rows = np.full(count, -1)
    row = int(pairs.oldest[0])
    for k in range(count):
        if sizes[k] == 0.0:
            continue
        full -= 1
        if full >= capacity:
            continue  # more than fit
        keep(pairs.products[row], space.products[k] / sizes[k])
        keep(pairs.differences[row], space.directions[k] / sizes[k] - pairs.products[row])
        keep(space.projected[: count + 1, row], space.hessenberg[k, : count + 1] / sizes[k])
        rows[k] = row
        row = (row + 1) % capacity
    for k in range(count):
        if rows[k] >= 0:
            share = space.hessenberg[k, : count + 1] / sizes[k]
            keep(pairs.gram[rows[k]], share @ space.projected[: count + 1])  # Eq. (Q10)
            keep(pairs.gram[:, rows[k]], pairs.gram[rows[k]])
    pairs.oldest[0] = row


@compilable
def no_pairs(unknowns: int, most: int = STORED_PAIRS, noise: float = NOISE):
    """Return a memory for at most `most` pairs, without pairs in use."""
    capacity = min(most, unknowns)
    rows = np.zeros((2, capacity, unknowns))
    return Pairs(
        products=rows[0],
        differences=rows[1],
        gram=np.zeros((capacity, capacity)),
        oldest=np.zeros(1),
        is_whole=np.zeros(1),
        noise=np.full(1, noise),
    )


@compilable
def forget(pairs: Pairs):
    """Remove all pairs."""
    for table in (pairs.gram, pairs.products, pairs.differences):
        keep(table.reshape(table.size), np.zeros(table.size))
    pairs.oldest[0] = 0.0
    pairs.is_whole[0] = 0.0


@compilable
def first_columns(table: Array, count: int):
    """Return an array of `count` columns in the memory of one that may have more."""
    rows = len(table)
    return table.reshape(table.size)[: rows * count].reshape((rows, count))


class RecycledGmres:
    """Memory of GMRES for a sequence of systems A x = b whose matrices change little.

    Eq. (Q7):  P r = r + (V - Z) (Z' Z + n I)^-1 Z' r,   Z = A V,   |z_i| = 1

    V and Z are directions and their products from earlier solves: for small n P is the inverse of
    the A of that time on the space spanned by Z, and the identity elsewhere. GMRES works with A P,
    so a stale P costs products, never accuracy.

    Few directions need few pairs. Older pairs do not improve P, so they are removed permanently:

    Eq. (Q11):  pairs <= 1.3 d + 4,   d = tr Z' Z (Z' Z + n I)^-1

    d counts the directions in which the pairs differ by more than the noise.

    Machine code that solves in coordinates (`CompiledNewton`) also keeps them at the last accepted
    times, and their scale.
    """

    def __init__(self):
        self.pairs: Pairs | None = None
        self.past: list[tuple[float, Array]] = []
        self.scale: Array | None = None

    def pairs_of(self, unknowns: int) -> Pairs:
        """Return the pairs; before a first solve there are none in use."""
        if self.pairs is None or self.pairs.products.shape[1] != unknowns:
            self.pairs = no_pairs(unknowns)
        return self.pairs
