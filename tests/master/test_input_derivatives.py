"""Input derivatives of FMI 2.0, for models that read inputs at the end of a step."""

from pathlib import Path

import numpy as np
import pytest

from piston_cosim.master.fmi.builder import build_fmu_of_file
from piston_cosim.master.fmi.compiler import compiler
from piston_cosim.master.fmi.errors import Discard
from piston_cosim.master.participants.fmi2 import FmuParticipant

from . import test_front
from .front_toy import SHAPE

TOY = Path(__file__).parent / "front_toy.py"
U = np.linspace(-2.0, 3.0, 6).reshape(SHAPE)


version, library, fmu = test_front.version, test_front.library, test_front.fmu


@pytest.mark.skipif(not compiler(), reason="no C compiler, or not Linux on x86-64")
@pytest.mark.parametrize("version, fmu", [("2.0", "native")], indirect=True)
@pytest.mark.parametrize("native", [False, True])
def test_inputs_are_extrapolated_to_the_end_of_the_step(fmu, native):
    """Eq. (Y1) at the end of a step of 0.5 s: (1 + 1 + 3/4 - 1/2) U/8, with x' = u at the end.

    A discarded step takes the input back, and the next step has no derivatives.
    """
    toy = FmuParticipant("toy", fmu if native else build_fmu_of_file(f"{TOY}:Toy", {}))
    assert toy.description.coSimulation.canInterpolateInputs and not toy.can_interpolate
    assert toy.fields["u"].description == "Input.; its value at the end of the step"
    toy.start({"gain": 1.0}, 0.0, 9.0)
    end = 2.25 * U / 8
    toy.set_course("u", np.array([U, 2 * U, 6 * U, -24 * U]) / 8)
    toy.step(0.0, 0.5)
    np.testing.assert_allclose(toy.get("x"), 0.5 * end, rtol=1e-15)  # all in powers of 2
    toy.step(0.5, 0.5)
    np.testing.assert_allclose(toy.get("x"), end, rtol=1e-15)
    toy.set_course("u", np.array([U, 80 * U]) / 8)
    with pytest.raises(Discard):  # faster than the model allows
        toy.step(1.0, 0.5)
    toy.step(1.0, 0.5)
    np.testing.assert_allclose(toy.get("x"), end + 0.5 * U / 8, rtol=1e-15)
    toy.close()
