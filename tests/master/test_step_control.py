"""Step control: its error estimate, its decisions and its resume.

The reference of the estimate is a step of BDF2 on known functions.
"""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from piston_cosim.master.coupling.freezing import freeze, thaw
from piston_cosim.master.coupling.methods import Newton
from piston_cosim.master.coupling.step_control import (
    HARD_ITERATIONS,
    SMALLEST_FACTOR,
    StepControl,
    step_control,
)
from piston_cosim.master.coupling.stepping import Stepper

ALLOWED = 1e-3


def control(smallest=1e-6):
    """Of the first two of three elements."""
    return StepControl([(slice(0, 2), ALLOWED)], smallest)


def vector(value):
    """Both watched elements alike, and one that is not watched and jumps about."""
    return np.array([value, value, 1e9 * np.sin(1e9 * value)])


def offer(chosen, function, last, step, iterations=2):
    """Whether a step that follows the function exactly is accepted."""
    return chosen.accepts(
        (last, vector(function(last))),
        last,
        step,
        SimpleNamespace(x=vector(function(last + step)), iterations=iterations),
    )


def estimate(function, times):
    """Estimated local error of the last of four times."""
    chosen = control()
    for last, time in zip(times[:-1], times[1:]):
        offer(chosen, function, last, time - last)
    return chosen.error * ALLOWED


def bdf2_error(function, slope, times):
    """Return the error of a BDF2 step from exact values.

    The parabola passes through both values and has the given slope at the end.
    """
    (t2, t1, t), (x2, x1) = times, (function(times[0]), function(times[1]))
    line = x1 + (t - t1) * (x1 - x2) / (t1 - t2)
    bend = (slope(t) - (x1 - x2) / (t1 - t2)) / (
        2 * t - t1 - t2
    )  # x'(t) = secant + bend (2 t - t_1 - t_2)
    return abs(line + bend * (t - t1) * (t - t2) - function(t))


@pytest.mark.parametrize("steps", [(1.0, 1.0, 1.0), (0.3, 0.2, 0.4), (0.2, 0.4, 0.1)])
def test_estimate_is_the_local_error_of_bdf2(steps):
    times = 0.7 + np.concatenate([[0.0], np.cumsum(steps)])
    exact = bdf2_error(lambda t: t**3, lambda t: 3 * t**2, times[1:])
    assert estimate(lambda t: t**3, times) == pytest.approx(
        exact, rel=1e-10
    )  # a cubic: exact but for round-off
    if len(set(steps)) == 1:
        assert exact == pytest.approx(2 / 9 * 6, rel=1e-10)


def test_after_a_hard_step_none_is_longer():
    chosen = control()
    offer(chosen, np.exp, 0.0, 0.01, iterations=HARD_ITERATIONS)
    assert chosen.step == 0.01


def test_a_jump_is_rejected_until_the_step_is_the_smallest():
    chosen, jump, step = control(1e-4), lambda t: 10.0 * (t > 0.3 + 1e-9), 0.1
    for last in (0.0, 0.1, 0.2):
        assert offer(chosen, jump, last, step)
    tried = []
    while not offer(chosen, jump, 0.3, step):
        tried.append(step)
        step = max(chosen.step, chosen.smallest)
    # the same three vectors before it, however often it was tried
    assert [time for time, _ in chosen.past] == [0.1, 0.2, 0.3]
    assert tried[1] == pytest.approx(SMALLEST_FACTOR * tried[0]) and np.all(np.diff(tried) < 0)
    assert step == 1e-4 and chosen.at_smallest == 1


def test_a_failure_halves_the_step_down_to_the_smallest():
    smallest = 1.0
    assert control(smallest).halve(2.0 * smallest * (1 - 1e-13))  # a difference of times
    assert not control(smallest).halve(1.9 * smallest)


def test_each_wire_has_its_own_allowed_error(affine):
    wires = affine(np.zeros((8, 8)), np.zeros, shapes=((7,), ())).wires[:2]
    assert step_control(wires, 1e-6) is None
    both = [replace(wire, local_error=allowed) for wire, allowed in zip(wires, (1e-8, 0.1))]
    assert step_control(both, 1e-6).watched == [(slice(0, 7), 1e-8), (slice(7, 8), 0.1)]


@pytest.mark.parametrize("order", [0, 2])
def test_stepping_keeps_the_error_whatever_the_predictor_and_resumes_with_the_same_bits(
    affine, order
):
    """The first wire is watched, the other one is 1e9 times as fast."""

    def stepper():
        system = affine(np.diag([-0.5, 0.5]), lambda t: np.sin([t, 1e9 * t]), 1e-6)
        control = StepControl([(slice(0, 1), 1e-6)], 1e-3)
        return Stepper(system, Newton(), 3, control=control, order=order)

    whole, again = stepper(), stepper()
    whole.advance(0.0, 1.0)
    middle = freeze(whole)
    whole.advance(1.0, 1.0)
    assert 10 < whole.counters.steps < 200  # neither two long steps nor all of the smallest
    thaw(again, middle)
    again.advance(1.0, 1.0)
    assert freeze(again) == freeze(whole)
