"""Every coupling method on affine systems x = A x + b whose iterates are known in closed form.

Unless a test says otherwise A = diag(-1, 0) and b = (2, 1): the residuals of x are 2 - 2 x_1 and
1 - x_2, from x = 0 the first ones are (2, 1). Measures are residual / tolerance. Expected numbers
are exact fractions: rel = 1e-9 is round-off of some ten operations with room for a solve of 2 x 2.
"""

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from piston_cosim.master.coupling.methods import (
    Explicit,
    LeastSquares,
    Newton,
    QuasiNewton,
    Relaxation,
    krylov,
)
from piston_cosim.master.coupling.methods.filtering import filtered
from piston_cosim.master.coupling.methods.iteration import FAILURES, NONE, failure_of
from piston_cosim.master.coupling.methods.krylov import Goal, RecycledGmres
from piston_cosim.master.coupling.stepping import StepFailed, Stepper
from piston_cosim.master.coupling.vector import macro_step_end, step_length
from piston_cosim.master.coupling.wiring import is_unknown
from piston_cosim.models.elastic_tube.secants import Ageing

A = ((-1.0, 0.0), (0.0, 0.0))
B = np.array([2.0, 1.0])
FINE = 1e-2
"""Tolerance of the wires: measures are then a hundred times the residuals."""
ROUND_OFF = 1e-10
"""A measure that is zero but for rounding: some 1e-15 of numbers of order 1, over FINE."""


class Trails:
    """An observer that keeps the measures of every attempt."""

    def __init__(self):
        self.attempts = []

    def attempted(self, time, step, trail, failure):
        self.attempts.append(trail)

    def accepted(self, time, solution):
        pass


def trail_of(system, method, steps=1, order=0):
    """Measures of the unknown wires, evaluation by evaluation, of every attempt; the stepper."""
    trails, unknown = Trails(), len(system.participants["plant"].inputs)
    stepper = Stepper(system, method, 0, trails, order)
    try:
        for k in range(steps):
            stepper.advance(float(k), 1.0)
    except StepFailed:
        pass
    return [np.array(trail)[:, :unknown] for trail in trails.attempts], stepper


def residuals(system, method):
    """Residuals of the first macro step, evaluation by evaluation."""
    return trail_of(system, method)[0][0] * FINE


def test_constant_relaxation_shrinks_each_error_by_its_factor(affine):
    # Eq. (C2): the error of x_k goes with 1 - w (1 - a_k) = 1/2 and 3/4
    history = residuals(affine(A, lambda t: B, FINE), Relaxation(0.25, False, 4))
    assert history == pytest.approx(
        np.array([[2, 1], [1, 3 / 4], [1 / 2, 9 / 16], [1 / 4, 27 / 64]]), rel=1e-9
    )


def test_aitken_s_factors_by_hand(affine):
    # nominals 1 and 1/2, so scaled residuals r_0 = (2, 2), r_1 = (1, 1.5) after w_0 = 1/4:
    # w_1 = 1/4 x 3 / 1.25 = 0.6, x_2 = (1.1, 0.7), r_2 = (-0.2, 0.6) scaled
    # w_2 = 0.6 x 2.55 / 2.25 = 0.68, x_3 = (0.964, 0.904)
    history = residuals(affine(A, lambda t: B, FINE, nominal=(1.0, 0.5)), Relaxation(0.25, True, 4))
    assert history == pytest.approx(
        np.array([[2, 1], [1, 0.75], [0.2, 0.3], [0.072, 0.096]]), rel=1e-9
    )


def test_aitken_begins_every_macro_step_with_the_case_s_factor(affine):
    attempts, _ = trail_of(affine([[-1.0]], lambda t: 2 * t, FINE), Relaxation(0.25, True, 9), 2)
    # one unknown: the second factor is exact; each step begins 2 off and is 1 off after w_0 = 1/4
    for measures in attempts:
        assert measures[:, 0] * FINE == pytest.approx([2.0, 1.0, 0.0], abs=1e-12)


@pytest.mark.parametrize(
    "secants, third",
    [
        # one pair dr = (-1, -1/4), dx = (1/2, 1/4) at r_1 = (1, 3/4), Eq. (C4). Shares of the wires
        # in r_0 and r_1, added: 0.8 + 0.64 and 0.2 + 0.36; c = (1/1.44 + 3/16/0.56) / (1/1.44 +
        # 1/16/0.56) = 83/65; x_2 = (3/2 - c/2, 1)
        (LeastSquares(), (18 / 65, 0.0)),
        # Eq. (C6) knows no scaling of wires: (1 + 3/16) / (1 + 1/16) = 19/17, divided by 1 + n
        (Ageing(), (1 - 19 / 17 / (1 + 1e-6), 0.0)),
        (Ageing(noise=0.25), (1 - 19 / 17 / 1.25, 0.0)),
    ],
)
def test_secant_updates_by_hand(affine, secants, third):
    history = residuals(affine(A, lambda t: B, FINE), QuasiNewton(secants, 0.25))
    assert history[:2] == pytest.approx(np.array([[2, 1], [1, 0.75]]), rel=1e-9)
    assert history[2] == pytest.approx(np.abs(third), rel=1e-9, abs=FINE * ROUND_OFF)


def test_secants_are_scaled_by_nominals_before_the_wires_shares(affine):
    # nominals 1 and 1/2: r_1 = (1, 3/2), dr = (-1, -1/2); c = 1.75 / 1.25 = 1.4,
    # x_2 = (3/2 - c/2, 1) in SI, for both residuals of the second wire scale alike
    system = affine(A, lambda t: B, FINE, nominal=(1.0, 0.5))
    history = residuals(system, QuasiNewton(Ageing(noise=0.0), 0.25))
    assert history[2] == pytest.approx([0.4, 0.0], rel=1e-9, abs=FINE * ROUND_OFF)


def loads(t):
    """From step to step the residual is (2, 1), (2, 1), and then (2, 1/2)."""
    return {1.0: B, 2.0: 2 * B, 3.0: np.array([6.0, 2.5])}[t]


@pytest.mark.parametrize(
    "secants, iterations",
    [
        # the first step: no pair, one, two (everything of a map of two unknowns), converged. The
        # second step begins with both. It teaches one pair, which alone does not answer the third
        # step's residual: one window leaves that step an evaluation more than two.
        (LeastSquares(windows=0), [4, 4, 4]),
        (LeastSquares(windows=1), [4, 2, 3]),
        (LeastSquares(windows=2), [4, 2, 2]),
        (Ageing(noise=1e-12, drift=0.0), [4, 2, 2]),
    ],
)
def test_pairs_of_so_many_macro_steps_are_used_again(affine, secants, iterations):
    _, stepper = trail_of(affine(A, loads, 1e-6), QuasiNewton(secants, 0.25), 3)
    assert stepper.counters.iterations == iterations


def test_ageing_trusts_a_pair_of_the_last_step_by_its_drift(affine):
    # one unknown, x = -x + 2 t: the first step learns two pairs v = -1, X = 1/2 and ends at
    # x = 3/2 - 1 / (2 + 2 n); the second begins 2 t - 2 x = r off, a_i = -e r / (2 + n), Eq. (C6),
    # so dx = r (1 - e / (2 + n)) leaves r (2 e / (2 + n) - 1)
    drift, noise = 0.1, 0.01
    attempts, _ = trail_of(
        affine([[-1.0]], lambda t: 2 * t, 0.1), QuasiNewton(Ageing(9, drift, noise), 0.25), 2
    )
    r = 1 + 1 / (1 + noise)
    left = r * (1 - 2 * np.exp(-drift) / (2 + noise))
    assert attempts[0][:, 0] == pytest.approx([20, 10, 10 * noise / (1 + noise)], rel=1e-9)
    assert attempts[1][:2, 0] == pytest.approx([10 * r, 10 * left], rel=1e-9)


def test_oldest_pairs_make_room():
    """As many pairs as are kept, of a linear map, after as many of the opposite one."""
    random, n = np.random.default_rng(0), 8
    matrix, memory = np.eye(n) + 0.5 * random.standard_normal((n, n)), Ageing(8, noise=1e-12)
    memory.begin()
    for sign in (1, -1):
        for change in random.standard_normal((n, n)):
            memory.learn(change, sign * matrix @ change)
    change, _ = memory.update(np.ones(n), [slice(0, n)])
    assert np.allclose(change, np.linalg.solve(matrix, np.ones(n)), rtol=1e-6, atol=1e-5)


def test_filter_compares_what_is_new_with_the_column():
    # of (1, 1/2) behind (10, 0) only 1/2 is new: 0.447 of the column itself
    chosen, q, triangle = filtered([np.array([10.0, 0.0]), np.array([1.0, 0.5])], 0.4)
    assert chosen == [0, 1]
    assert triangle == pytest.approx(np.array([[10.0, 1.0], [0.0, 0.5]]), rel=1e-15)
    assert np.abs(q) == pytest.approx(np.eye(2), abs=1e-15)
    assert filtered([np.array([10.0, 0.0]), np.array([1.0, 0.5])], 0.5)[0] == [0]


def test_newton_on_an_affine_map_needs_one_update(affine):
    # two evaluations; I - J = diag(2, 1) has two eigenvalues: two products, and the change of the
    # outputs is a sum of theirs
    attempts, stepper = trail_of(affine(A, lambda t: B, FINE), Newton())
    assert attempts[0] == pytest.approx(np.array([[200, 100], [0, 0]]), abs=ROUND_OFF)
    counters = stepper.counters
    assert counters.iterations == [2]
    assert counters.residual_evaluations == 2
    assert counters.jacobian_evaluations == 1
    assert counters.derivative_products == 2


@pytest.mark.parametrize("unknown, products", [(FINE, 2), (np.inf, 1)])
def test_what_goes_along_the_order_is_updated_with_the_unknowns(affine, unknown, products):
    # plant.y, measured here, changes by the sum of what it does along the directions: nothing is
    # left of its residual. Where the unknowns are not measured their residual is within the goal
    # and is the update itself, one product tells what y does along it
    system = affine(A, lambda t: B, FINE)
    tolerances = (unknown, unknown, FINE, FINE)
    wires = tuple(replace(wire, tolerance=t) for wire, t in zip(system.wires, tolerances))
    attempts, stepper = trail_of(replace(system, wires=wires), Newton())
    assert stepper.counters.iterations == [2]
    assert stepper.counters.derivative_products == products


def test_products_by_differences_are_counted_as_evaluations(affine):
    _, stepper = trail_of(affine(A, lambda t: B, FINE), Newton(differences=True))
    counters = stepper.counters
    assert counters.iterations == [2]
    assert counters.residual_evaluations == 2 + 2
    assert counters.jacobian_evaluations == 1
    assert counters.derivative_products == 0


@pytest.mark.parametrize(
    "nominal, second",
    [
        # Krylov space of one direction r = (2, 1): (I - J) r = (4, 1), weight 9/17
        ((1.0, 1.0), (2 / 17, 8 / 17)),
        # scaled by nominals r = (2, 2), (I - J) r = (4, 2), weight 3/5
        ((1.0, 0.5), (0.4, 0.4)),
    ],
)
def test_newton_in_a_krylov_space_of_one_direction(affine, nominal, second):
    system = affine(A, lambda t: B, FINE, nominal=nominal)
    history = residuals(system, Newton(max_iterations=2, largest_krylov_space=1))
    assert history == pytest.approx(np.array([[2, 1], second]), rel=1e-9)


class Gmres(RecycledGmres):
    """Solves A x = right with at most `most` products, and learns."""

    def __init__(self, most):
        super().__init__()
        self.most = most

    def solve(self, multiply, right, goal):
        def product(system, k, v, out):
            out[:] = multiply(v)
            return True

        def excess(system, residual):
            return 1.0 if (np.abs(residual) <= elements).all() else 2.0

        elements, size = goal
        own = Goal(size, np.linalg.norm(elements))
        pairs = self.pairs_of(right.size)
        solved = krylov.minimise(product, excess, None, right, own, pairs, self.most)
        count = len(solved.weights)
        krylov.learn(pairs, solved.space, count)
        return SimpleNamespace(x=solved.x, weights=solved.weights, products=count)


def doubled(v):
    """Return A v of A = diag(2, 1)."""
    return np.array([2.0, 1.0]) * v


def within(*elements, size=0.0):
    return np.array(elements), size


def test_gmres_minimises_the_residual_and_counts_its_products():
    # along (1, 1): weight (b . A b) / (A b . A b) = 3/5
    found = Gmres(1).solve(doubled, np.ones(2), within(0.0, 0.0))
    assert (found.x, found.products) == (pytest.approx([0.6, 0.6], rel=1e-12), 1)
    # |(1, 1)| = sqrt(2): the weight of that direction as a unit vector
    assert found.weights == pytest.approx([0.6 * np.sqrt(2)], rel=1e-12)
    gmres = Gmres(5)
    found = gmres.solve(doubled, np.ones(2), within(0.0, 0.0, size=1e-9))
    assert (found.x, found.products) == (pytest.approx([0.5, 1.0], rel=1e-9), 2)
    # what it learned answers the next system at once, but for the noise 1e-5 of Eq. (Q7)
    found = gmres.solve(doubled, np.array([3.0, -2.0]), within(0.0, 0.0, size=1e-3))
    assert (found.x, found.products) == (pytest.approx([1.5, -2.0], rel=1e-4), 1)
    # nothing to do: the right-hand side is within the goal
    assert gmres.solve(doubled, np.array([1e-4, 0.0]), within(0.0, 0.0, size=1e-3)).products == 0
    assert gmres.solve(doubled, np.array([1e-4, 0.1]), within(1e-4, 0.1)).products == 0


def test_gmres_looks_at_every_element_of_the_residual():
    # one product along (1, 1) leaves (1, 1) - 3/5 (2, 1) = (-1/5, 2/5), of length 0.447
    for elements, size, products in (
        ((0.21, 0.41), 0.0, 1),
        ((0.19, 0.9), 0.0, 2),
        ((0.9, 0.39), 0.0, 2),
        ((0.0, 0.0), 0.45, 1),
        ((0.0, 0.0), 0.44, 2),
        ((np.inf, 0.41), 0.0, 1),
        ((np.inf, 0.39), 0.0, 2),
    ):
        found = Gmres(5).solve(doubled, np.ones(2), within(*elements, size=size))
        assert found.products == products, elements


@pytest.mark.parametrize(
    "history, expected",
    [
        ([1.0, 0.5, 0.4, 401.0], FAILURES.grows),  # a thousand times the smallest
        ([1.0, 0.5, 0.4, 399.0], NONE),
        ([0.4, 1.0, 401.0], NONE),  # too early to tell
        ([1.0, 0.5, 0.4, 0.4, 0.4], FAILURES.too_many),
    ],
)
def test_an_iteration_ends_where_its_residual_grows(history, expected):
    assert failure_of(np.zeros(1), np.array(history), 5) == expected


def test_explicit_coupling_hands_on_what_the_last_step_gave(affine):
    # loose coupling of x = -x/2 + 3 is the plain iteration, an evaluation a step: 0, 3, 3/2, 9/4
    system = affine([[-0.5]], lambda t: 3.0, 1e-6)
    values, stepper = [], Stepper(system, Explicit(), 0, order=0)
    for k in range(4):
        stepper.advance(float(k), 1.0)
        values.append(float(system.participants["plant"].values["u0"]))
    assert values == [0.0, 3.0, 1.5, 2.25]
    assert stepper.counters.iterations == [1, 1, 1, 1]
    assert stepper.counters.unconverged_steps == 4


def test_explicit_coupling_that_diverges_stops_and_names_the_wire(affine):
    """x = -50 x + 3: the residual grows 50-fold a step; the tenth is enough to stop."""
    system = affine([[-50.0]], lambda t: 3.0, 1e-6)
    stepper = Stepper(system, Explicit(), 6, order=0)
    with pytest.raises(StepFailed, match=r"wire echo.w0 -> plant.u0: .* residual that grew"):
        for k in range(30):
            stepper.advance(float(k), 1.0)
    # the first change, from 0, counts as a doubling, and no shorter step is tried
    assert (stepper.counters.steps, len(stepper.failures)) == (9, 1)


@pytest.mark.parametrize(
    "gain, drive, words",
    [
        # it may be meant, so that the run goes on
        (1.05, lambda t: 3.0, "the residual grew 1.05-fold in each of 10 macro steps"),
        (-1.05, lambda t: 3.0, "the residual grew 1.6-fold in 10 macro steps"),  # 1.05^10
        (-1.0, lambda t: 3.0, "an undamped oscillation changes the output by 3 m"),
        # each fourth macro step changes nothing
        (0.0, lambda t: 10.0 ** (t - t // 4), r"the residual grew 1e\+10-fold since the start"),
        # honest: powers of time, a damped loop, an oscillation of 12 steps
        (0.0, lambda t: t**4, ""),
        (-0.9, lambda t: 3.0, ""),
        (0.5, lambda t: np.sin(np.pi * t / 6), ""),
    ],
)
def test_explicit_coupling_warns_once_unless_it_settles(affine, gain, drive, words):
    """x = gain x + drive(t)."""
    stepper = Stepper(affine([[gain]], drive, 1e-6), Explicit(), 0, order=0)
    for k in range(40):
        stepper.advance(float(k), 1.0)
    assert [one.count for _, one in stepper.warned()] == [1] * bool(words)
    assert not words or re.match(words, stepper.warned()[0][1].text)


def test_in_jacobi_s_order_a_value_takes_an_evaluation_to_each_side(affine):
    # x = 2 plainly iterated: plant says 2 at once, echo in the second, both agree in the third
    trails = Trails()
    system = affine([[0.0]], lambda t: 2.0, 0.1, parallel=True)
    Stepper(system, Relaxation(1.0, False, 9), 0, trails, 0).advance(0.0, 1.0)
    assert trails.attempts == [[[0.0, 20.0], [20.0, 0.0], [0.0, 0.0]]]


@pytest.mark.parametrize(
    "smallest, change, share",
    [
        # floor 0.4 - 1/2 x 0.4: the element may fall by 0.2
        (0.4, (-1.0, 0.0), 0.2),
        # the other element is held by the same floor 0.2
        (0.4, (0.0, -3.0), 0.6),
        # below a tenth of the nominal the floor is 0.05 - 1/2 x 0.1 = 0
        (0.05, (-1.0, 0.0), 0.05),
        # rising is free
        (0.4, (5.0, 5.0), 1.0),
    ],
)
def test_largest_decrease_by_hand(affine, smallest, change, share):
    system = affine(np.zeros((2, 2)), lambda t: np.zeros(2), shapes=((2,),))
    wires = (replace(system.wires[0], largest_decrease=0.5), *system.wires[1:])
    stepper = Stepper(replace(system, wires=wires), Newton(), 0)
    x, whole = np.array([smallest, 2.0, 0.0, 0.0]), np.array([*change, -9.0, -9.0])
    assert step_length(stepper.interface.layout, x, whole) == pytest.approx(share, rel=1e-12)


def test_a_failure_names_the_worst_element_and_every_measure(affine):
    system = affine(np.zeros((3, 3)), lambda t: np.array([1.0, 3.0, 2.0]), shapes=((2,), ()))
    with pytest.raises(StepFailed) as failure:
        Stepper(system, Relaxation(0.5, False, 3), 0, order=0).advance(0.0, 1.0)
    text = str(failure.value)
    assert "t = 0 s, step 1 s: no convergence in 3 iterations" in text
    assert "plant.u0[2]: expected a residual of at most 0.1 m, got 0.75 m" in text
    assert "residual/tolerance per iteration: 30 15 7.5" in text


@pytest.mark.parametrize(
    "given, evaluations",
    [
        # x = -x + (3, 4) relaxed by 1/4: after k evaluations the residual is (3, 4) / 2^k, and the
        # outputs say (3, 4) (1 + 2^-k) / 2: their ratio is 1, 2/3, 2/5, 2/9, 2/17, 2/33
        ({"tolerance": 0.6}, 4),  # max 4, 2, 1, 0.5
        ({"tolerance": 0.45}, 5),
        ({"tolerance": 0.0, "relative_tolerance": 0.12}, 5),
        ({"tolerance": 0.0, "relative_tolerance": 0.11}, 6),
        # one criterion that is met is enough
        ({"tolerance": 0.6, "relative_tolerance": 0.11}, 4),
        ({"tolerance": 0.45, "relative_tolerance": 0.11}, 5),
        ({"tolerance": 0.45, "relative_tolerance": 0.25}, 4),
    ],
)
def test_each_criterion_ends_the_iteration_where_it_is_met(affine, given, evaluations):
    system = affine(-np.eye(2), lambda t: np.array([3.0, 4.0]), shapes=((2,),), **given)
    stepper = Stepper(system, Relaxation(0.25, False, 20), 0, order=0)
    stepper.advance(0.0, 1.0)
    assert stepper.counters.iterations == [evaluations]


@pytest.mark.parametrize(
    "source, target, parallel, unknown",
    [
        ("plant", "echo", False, False),
        ("echo", "plant", False, True),
        ("plant", "plant", False, True),  # what it says at the end it cannot read before
        ("plant", "echo", True, True),
    ],
)
def test_wires_against_the_order_are_unknowns(affine, source, target, parallel, unknown):
    wire = replace(affine([[0.0]], lambda t: t).wires[0], source=(source, ""), target=(target, ""))
    assert is_unknown(wire, ["plant", "echo"], parallel) is unknown


@pytest.mark.parametrize(
    "step, share, off, expected",
    [
        (0.25, 1.0, 0.0, 1.0),
        (0.25, 1.0, 2e-7, 1.0),
        (0.25, 1.0, -2e-7, 1.0),
        (0.25, 1.0, 3e-7, 1.0 + 3e-7),  # 1.2e-6 of a macro step
        (0.5, 0.5, 2e-7, 1.0),  # the first of two
        (0.125, 1.0, 2e-7, 1.0 + 2e-7),  # half a macro step
        (0.4, 1.0, 0.1, 1.1),
    ],
)
def test_ends_near_a_multiple_of_the_macro_step_are_on_it(step, share, off, expected):
    """Macro steps of 0.25 s, of which 1e-6 are 2.5e-7 s."""
    end = macro_step_end(1.0 + off - step * share, step, share, 0.25)
    assert end == (expected if expected == 1.0 else pytest.approx(expected, rel=1e-15))
