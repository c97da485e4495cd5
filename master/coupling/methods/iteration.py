"""Newton iteration of a macro step. Python runs it as written, native FMUs compile it."""

from typing import Any, NamedTuple

import numpy as np

from ...fmi.block import keep
from ...fmi.compiled import compilable
from ..vector import Array, Evaluation, Layout, Positions, moved, put
from .krylov import Goal, Pairs, first_columns, forget, learn, length, minimise

NO_FAILURE = -1.0
"""Failure of an iteration that converged, or in which a participant rejected a call."""
SENTENCES = {
    "not_finite": "a participant's output is not finite",
    "grows": "the residual grows: {a} of what is allowed after {i} iterations, {b} at best",
    "too_many": "no convergence in {i} iterations: {a} of what is allowed is left, {b} at best",
}

MIRROR_TOLERANCE = 0.1
"""Largest difference between the residuals of mirror images, as a share of the allowed residual, up
to which half of a field is iterated."""

GUESS_TOLERANCE = 0.1
"""Measure up to which a first guess is accepted. Guesses that are extrapolated from accepted ones
drift by the tolerance, and a film answers its correction in a short step by a high pressure.
"""


class Failures(NamedTuple):
    """Numbers of the failures, as ordered in `SENTENCES`."""

    not_finite: float = 0.0
    grows: float = 1.0
    too_many: float = 2.0


FAILURES = Failures()


class Answer(NamedTuple):
    """Evaluation of an iterate.

    measure : largest residual as a share of its tolerance, NaN if one is not finite; negative if a
    participant rejected the step. allowed : residual that counts as converged, by element.
    """

    at: Evaluation
    measure: float
    allowed: Array


class NewtonSystem(NamedTuple):
    """Linear system of a Newton update.

    derivative : callable(step, change, out)
        Writes the change of all outputs; returns whether all participants answered.
    step : object
        Argument of `derivative`.
    unknowns, images : ndarray of int, shape (unknowns,)
        Positions of the unknowns and of their mirror images, which have the same values.
    scale, limits : ndarray, shape (unknowns,)
        Scale of the unknowns, and bounds on the scaled residual.
    seed : ndarray, shape (size,)
        Argument of `derivative`; 0 except for the unknowns.
    products : ndarray, shape (most, size)
        Changes of all outputs, by direction.
    """

    derivative: Any
    step: Any
    unknowns: Positions
    images: Positions
    scale: Array
    limits: Array
    seed: Array
    products: Array


class Update(NamedTuple):
    """Newton update of the vector, its number of products, and whether all were answered."""

    change: Array
    products: int
    is_answered: bool


class Iterated(NamedTuple):
    """Result of an iteration.

    history : ndarray
        Measures of the evaluations; the last one is negative if a participant rejected the step.
    products : int
        Number of directional derivatives of the whole evaluation.
    first : ndarray
        First update, empty without one.
    failure : float
        Number as in `FAILURES`, or `NO_FAILURE`.
    is_converged : bool
    """

    at: Evaluation
    history: Array
    products: int
    first: Array
    failure: float
    is_converged: bool


@compilable
def product(linear: NewtonSystem, k: int, direction: Array, out: Array):
    """Write the k-th product with I - J; return whether all participants answered."""
    unknowns = linear.unknowns
    seed = direction * linear.scale
    put(linear.seed, unknowns, seed)
    put(linear.seed, linear.images, seed)
    if not linear.derivative(linear.step, linear.seed, linear.products[k]):
        return False
    keep(out, direction - linear.products[k][unknowns] / linear.scale)
    return True


@compilable
def excess(linear: NewtonSystem, residual: Array):
    """Return 1 if no element of a scaled residual exceeds its limit, else 2.

    If no element exceeds its limit, the norm of the residual is at most that of the limits.
    Therefore `minimise` compares the norms first.
    """
    return 1.0 if (np.abs(residual) <= linear.limits).all() else 2.0


@compilable
def unknowns_of(answer: Answer, layout: Layout, pairs: Pairs):
    """Return the unknowns of an update and their mirror images, see `Layout`.

    All are unknowns once the residuals of mirror images differ by more than `MIRROR_TOLERANCE`.
    """
    if pairs.is_whole[0] == 0.0:
        r = answer.at.residual
        difference = np.abs(r[layout.half] - r[layout.images])
        if (difference <= MIRROR_TOLERANCE * answer.allowed[layout.half]).all():
            return layout.half, layout.images
        forget(pairs)
        pairs.is_whole[0] = 1.0
    return layout.unknowns, layout.unknowns


@compilable
def field_update(
    derivative: Any, step: Any, answer: Answer, rules: Any, layout: Layout, pairs: Pairs
):
    """Return the Newton update at an evaluation, see `converge`."""
    at = answer.at
    if len(layout.unknowns) == 1:
        return scalar_update(derivative, step, at, layout)
    size = len(at.used)
    unknowns, images = unknowns_of(answer, layout, pairs)
    known = Pairs(
        products=first_columns(pairs.products, len(unknowns)),
        differences=first_columns(pairs.differences, len(unknowns)),
        gram=pairs.gram,
        oldest=pairs.oldest,
        is_whole=pairs.is_whole,
        noise=pairs.noise,
    )
    # an element and its image count twice, so that norms are those of the whole field
    scale = layout.nominal[unknowns] / np.sqrt(1.0 + (images != unknowns))
    right = (at.outputs - at.used)[unknowns] / scale
    products = np.empty((max(rules.largest_krylov_space, 1), size))
    linear = NewtonSystem(
        derivative=derivative,
        step=step,
        unknowns=unknowns,
        images=images,
        scale=scale,
        limits=rules.accuracy * answer.allowed[unknowns] / scale,
        seed=np.zeros(size),
        products=products,
    )
    # see `excess`: if the norm exceeds that of the limits, so does an element
    goal = Goal(rules.forcing * length(right), length(linear.limits))
    most = rules.largest_krylov_space
    solved = minimise(product, excess, linear, right, goal, known, most)  # Eq. (Q1)
    x, count, is_answered = solved.x, len(solved.weights), solved.is_answered
    if is_answered and count > 0:
        learn(known, solved.space, count)
        change = solved.weights @ products[:count]
    else:
        is_answered = is_answered and product(linear, count, x, np.empty(len(x)))
        change = products[0]
    put(change, unknowns, x * scale)
    put(change, images, x * scale)
    return Update(change, max(count, 1), is_answered)


@compilable
def scalar_update(derivative: Any, step: Any, at: Evaluation, layout: Layout):
    """Return the Newton update of a single unknown, see `converge`."""
    unknown = layout.unknowns[0]
    scale = layout.nominal[unknown]
    seed = np.zeros(len(at.used))
    seed[unknown] = scale
    products = np.empty(len(seed))
    is_answered = derivative(step, seed, products)
    pivot = 1.0 - products[unknown] / scale
    x = 0.0
    if is_answered and pivot != 0.0:
        x = (at.outputs[unknown] - at.used[unknown]) / scale / pivot  # Eq. (Q1)
    change = x * products
    change[unknown] = x * scale
    return Update(change, 1, is_answered)


@compilable
def accepted_of(evaluations: int, most: int):
    """Return the measure up to which an evaluation is accepted.

    The first evaluation is that of the guess. If it is also the last one, `most` = 1, it is
    accepted as every other iterate.

    Parameters
    ----------
    evaluations : int
        Number of the evaluation, from 1.
    most : int
        Maximum number of evaluations.
    """
    return GUESS_TOLERANCE if evaluations == 1 and most > 1 else 1.0


@compilable
def failure_of(outputs: Array, history: Array, most: int):
    """Return the number of the reason to end an iteration without a solution, or `NO_FAILURE`."""
    last = history[-1]
    if not last < np.inf and not np.isfinite(outputs).all():
        return FAILURES.not_finite
    if len(history) > 3 and last > 1e3 * np.min(history):
        return FAILURES.grows
    return FAILURES.too_many if len(history) == most else NO_FAILURE


@compilable
def converge(
    evaluate: Any,
    update: Any,
    step: Any,
    guess: Array,
    rules: Any,
    layout: Layout,
    pairs: Pairs,
):
    """Return the fixed point of a macro step by Newton's iteration.

    Eq. (Q1):  (I - J) dx = G(x) - x,   J = dG/dx,   G(x): the feedback wires evaluated at x

    Parameters
    ----------
    evaluate : callable(step, x)
        Returns an `Answer`.
    update : callable(step, answer, rules, layout, pairs)
        Returns an `Update`, as `field_update` does.
    step : object
        First argument of both.
    guess : ndarray, shape (size,)
    rules : Newton, or native_block.Rules
    layout : Layout
    pairs : Pairs
        Updated.

    Returns
    -------
    Iterated
    """
    history = np.empty(rules.max_iterations)
    first = np.zeros(0)
    answer: Answer = evaluate(step, guess)
    history[0] = answer.measure
    count = 1
    products = 0
    failure = NO_FAILURE
    accepted = accepted_of(count, rules.max_iterations)
    while not answer.measure <= accepted:
        accepted = 1.0
        failure = failure_of(answer.at.outputs, history[:count], rules.max_iterations)
        if failure != NO_FAILURE:
            break
        change, more, is_answered = update(step, answer, rules, layout, pairs)
        products += more
        if not is_answered:
            break
        if count == 1:
            first = change
        answer = evaluate(step, moved(layout, answer.at.used, change))
        history[count] = answer.measure
        count += 1
    is_converged = 0.0 <= answer.measure <= accepted
    return Iterated(
        at=answer.at,
        history=history[:count],
        products=products,
        first=first,
        failure=failure,
        is_converged=is_converged,
    )
