"""`run` of native participants iterates as machine code, with the results of Newton in Python."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.system import open_system
from piston_cosim.master.coupling.compiled_newton import (
    CompiledNewton,
    Coordinates,
    compiled_if_native,
)
from piston_cosim.master.coupling.freezing import freeze, thaw
from piston_cosim.master.coupling.methods.newton import Newton
from piston_cosim.master.coupling.methods.solution import MacroStep
from piston_cosim.master.coupling.starting import start
from piston_cosim.master.coupling.stepping import Observer, StepFailed, Stepper

from .runs import EXAMPLE, needs_compiler, small_tree

STEPS = 12
PACKAGES = {"ehd": "fmu_ehd", "bodies": "fmu_mfbd"}
SUMS = 1e-9
"""Of the largest value: sums in another order, which a linear solve multiplies. 2e-11 was seen."""


@dataclass
class Journal(Observer):
    """Attempts of a stepper: measures of the wires and the reason of a failure."""

    trails: list[Any]

    def attempted(self, time, step, trail, failure):
        self.trails.append((np.array(trail), str(failure)))


def stepper(newton, is_compiled, predicted=0):
    """Return a started stepper of the small case with native half films, and its journal.

    predicted : more than 0 iterates in coordinates.
    """
    own = ("native", True), ("symmetric", True), ("time.stop", "30 deg")
    case = check_case(small_tree(*own), EXAMPLE)
    system = open_system(case, EXAMPLE.parent, print)
    start(system)
    method = newton
    if is_compiled:
        method = compiled_if_native(newton, system, PACKAGES, True, predicted)
    journal = Journal([])
    return Stepper(system, method, 2, journal), journal


def taken(one, first, last):
    """Take the steps from one number to another, and return the final vector."""
    step = EXAMPLE_STEP
    for k in range(first, last):
        one.advance(k * step, step)
    return one.predictor.past[-1][1]


EXAMPLE_STEP = float(np.radians(1.0)) / (2 * np.pi * 100.0)  # 1 deg at 6000 rpm [s]


@pytest.fixture(autouse=True)
def compiler():
    needs_compiler()


def test_steps_are_those_of_newton_in_python_and_only_machine_code_takes_them(monkeypatch):
    other, theirs = stepper(Newton(), False)
    expected = taken(other, 0, STEPS)
    one, ours = stepper(Newton(), True)
    assert isinstance(one.method, CompiledNewton)
    monkeypatch.setattr(Newton, "solve", lambda *_: pytest.fail("solved in Python"))
    x = taken(one, 0, STEPS)
    scale = one.interface.nominal
    assert np.abs((x - expected) / scale).max() <= SUMS * np.abs(expected / scale).max()
    assert one.counters == other.counters
    for (own, _), (their, _) in zip(ours.trails, theirs.trails, strict=True):
        # measures of converged wires are round-off of values far above the tolerance
        np.testing.assert_allclose(own, their, rtol=1e-3, atol=1e-2)
    for name, participant in one.interface.participants.items():
        for end in one.interface.inputs[name]:
            assert np.array_equal(participant.get(end.variable).ravel(), x[end.part])
        assert one.interface.spent[name] > 0.0


def test_coordinates_give_the_fixed_point_of_the_wires(monkeypatch):
    wires, (one, ours) = stepper(Newton(), True)[0], stepper(Newton(), True, 3)
    monkeypatch.setattr(Newton, "solve", lambda *_: pytest.fail("solved in Python"))
    expected, x = taken(wires, 0, STEPS), taken(one, 0, STEPS)
    tolerance = one.interface.tolerance
    unknown = np.isfinite(tolerance)
    # each step leaves up to its tolerance, and the steps before it a part of theirs
    assert (np.abs(x - expected) <= 2.0 * tolerance)[unknown].all()
    assert [len(trail) for trail, _ in ours.trails] == one.counters.iterations
    assert one.counters.derivative_products < wires.counters.derivative_products


def test_coordinates_are_those_of_the_bodies_and_not_of_the_guess():
    """An accepted guess would be extrapolated again, and drift."""
    one, _ = stepper(Newton(), True, 3)
    one.interface.tolerance[:] = np.inf
    taken(one, 0, 1)
    bodies: Any = one.interface.participants["bodies"]
    now = Coordinates(bodies).read({"bodies": bodies.save()})
    (_, begun), (_, ended) = one.memory.past
    assert one.counters.iterations == [1]
    assert np.array_equal(ended, now) and not np.array_equal(ended, begun)


def test_coordinates_of_a_rejected_step_are_forgotten():
    """They replace none of those from which the next step is extrapolated."""
    one, _ = stepper(Newton(), True, 3)
    x = taken(one, 0, 2)
    begin = 2 * EXAMPLE_STEP
    saved = {name: participant.save() for name, participant in one.interface.participants.items()}
    for length in (EXAMPLE_STEP, EXAMPLE_STEP / 2):
        one.method.solve(MacroStep(one.interface, begin, length, saved), x, one.memory)
    times = [time / EXAMPLE_STEP for time, _ in one.memory.past]
    assert times == pytest.approx([0.0, 1.0, 2.0, 2.5])


@pytest.mark.parametrize("predicted", [0, 3], ids=["wires", "coordinates"])
def test_a_resumed_run_has_the_same_bits(predicted):
    whole = taken(stepper(Newton(), True, predicted)[0], 0, STEPS)
    begun, _ = stepper(Newton(), True, predicted)
    taken(begun, 0, STEPS // 2)
    resumed, _ = stepper(Newton(), True, predicted)
    thaw(resumed, freeze(begun))
    assert np.array_equal(taken(resumed, STEPS // 2, STEPS), whole)


@pytest.mark.parametrize(
    "newton, force",
    [(Newton(max_iterations=1), 0.0), (Newton(), 1e9)],
    ids=["no convergence", "a discarded step"],
)
def test_a_failure_has_the_message_of_newton_in_python(newton, force):
    stops = []
    for is_compiled in (True, False):
        one, journal = stepper(newton, is_compiled)
        one.interface.participants["bodies"].set("ring_side_force", force)
        with pytest.raises(StepFailed) as stop:
            taken(one, 0, STEPS)
        stops.append((str(stop.value), [failure for _, failure in journal.trails]))
    assert stops[0] == stops[1]
