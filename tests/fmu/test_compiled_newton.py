"""`run` of native participants iterates as machine code, with the results of Newton in Python."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.system import open_system
from piston_cosim.master.coupling.compiled_newton import CompiledNewton, compiled_if_native
from piston_cosim.master.coupling.freezing import freeze, thaw
from piston_cosim.master.coupling.methods.newton import Newton
from piston_cosim.master.coupling.starting import start
from piston_cosim.master.coupling.stepping import Observer, StepFailed, Stepper

from .runs import EXAMPLE, needs_compiler, small_tree

STEPS = 12
PACKAGES = ("fmu_ehd", "fmu_mfbd")
SUMS = 1e-9
"""Of the largest value: sums in another order, which a linear solve multiplies. 2e-11 was seen."""


@dataclass
class Journal(Observer):
    """Attempts of a stepper: measures of the wires and the reason of a failure."""

    trails: list[Any]

    def attempted(self, time, step, trail, failure):
        self.trails.append((np.array(trail), str(failure)))


def stepper(newton, is_compiled):
    """Return a started stepper of the small case with native half films, and its journal."""
    own = ("native", True), ("symmetric", True), ("time.stop", "30 deg")
    case = check_case(small_tree(*own), EXAMPLE)
    system = open_system(case, EXAMPLE.parent, print)
    start(system)
    method = compiled_if_native(newton, system, PACKAGES, True) if is_compiled else newton
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


def test_a_resumed_run_has_the_same_bits():
    whole = taken(stepper(Newton(), True)[0], 0, STEPS)
    begun, _ = stepper(Newton(), True)
    taken(begun, 0, STEPS // 2)
    resumed, _ = stepper(Newton(), True)
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
