"""Inputs that move inside a macro step.

The tests check exact polynomials, the call of the standard, and messages for unsupported cases.
"""

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.case.system import open_system
from piston_cosim.master.fmi.builder import build_fmu_of_file
from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.master.participants.fmi2 import FmuParticipant
from piston_cosim.master.participants.interpolated import hermite, linear

from .runs import problems_of, run_tree, stopped

PATH = find_case("two_mass_oscillator")


@pytest.fixture(scope="module")
def oscillator():
    return build_fmu_of_file(f"{PATH.parent}/oscillator.py:Oscillator", {})


def test_courses_are_exact_for_their_polynomials():
    cubic, step = Polynomial([1.0, -2.0, 3.0, 5.0]), 0.3
    slope = cubic.deriv()
    coefficients = hermite(cubic(0.0), cubic(step), slope(0.0), slope(step), step)
    np.testing.assert_allclose(
        coefficients, [cubic.deriv(k)(0.0) for k in range(4)], rtol=1e-13
    )  # round-off / step^2
    np.testing.assert_allclose(
        linear(np.float64(2.0), np.float64(5.0), step), [2.0, 10.0], rtol=1e-15
    )


def test_description_declares_what_it_can(oscillator):
    assert problems_of(oscillator) == []
    participant = FmuParticipant("one", oscillator)
    assert participant.can_interpolate
    assert participant.fields["velocity"].derivative_of == "displacement"
    assert participant.fields["displacement"].derivative_of is None


def motion(participant, course, step):
    participant.set_course("other_displacement", np.array(course))
    participant.step(0.0, step)
    return participant.get("displacement")


def test_a_step_follows_the_course_and_forgets_it(oscillator):
    """A step follows the course of its input, which acts in this step alone.

    The input is a cubic whose exact motion is a cubic too: k_m v = m u'' + (k_o + k_m) u for
    u = s^3. Held inputs give another motion.
    """
    participant, step = FmuParticipant("one", oscillator), 0.02
    participant.start({}, 0.0, 1.0)
    saved = participant.save()
    # v = (6 s + 20 pi^2 s^3) / (16 pi^2): v' = 6/(16 pi^2), v''' = 6 * 20/16
    assert motion(participant, [0.0, 6 / (16 * np.pi**2), 0.0, 7.5], step) == pytest.approx(
        step**3, rel=1e-12
    )
    participant.restore(saved)
    participant.step(0.0, step)
    assert participant.get("displacement") == 0.0  # nothing was said of this step's input
    participant.close()


def result_of(folder, *changes):
    tree = read_tree(PATH, [("time.stop", "0.2 s"), *changes])
    return run_tree(PATH, tree, folder / "run.h5").series("left.displacement")[0]


def test_isolated_gives_the_same_bits_and_newton_the_same_motion(tmp_path):
    here = result_of(tmp_path)
    np.testing.assert_array_equal(result_of(tmp_path, ("participants.left.isolated", True)), here)
    # twenty steps, each converged to 1e-12 m
    np.testing.assert_allclose(result_of(tmp_path, ("coupling.method", "newton")), here, atol=1e-10)


def test_resumed_goes_on_along_the_same_course(tmp_path):
    """The values at the beginning of a step are part of the checkpoint."""
    tree = read_tree(PATH, [("time.stop", "0.2 s"), ("record", {"checkpoint_every": 7})])
    restored = stopped(PATH, tree, tmp_path / "run.h5", 0.165)
    assert restored.account.steps_done == 14
    resumed = run_tree(PATH, tree, tmp_path / "run.h5", begin_at=restored)
    whole = result_of(tmp_path, ("record", {"checkpoint_every": 0}))
    np.testing.assert_array_equal(resumed.series("left.displacement").values, whole)


def test_what_cannot_interpolate_is_named_before_the_run():
    path = find_case("elastic_tube")
    changes = [("wires.0.interpolation", "hermite"), ("wires.1.interpolation", "linear")]
    with pytest.raises(BadInput) as refusal:
        open_system(check_case(read_tree(path, changes), path), path.parent, print)
    assert len(refusal.value.faults) == 3
    text = "\n".join(refusal.value.faults)
    assert "expected an output declared as derivative of pressure, got none" in text
    assert text.count("expected an FMU with canInterpolateInputs") == 2
