"""What FMI 2.0 adds to a lubrication step at 40 x 40. Run: python tests/bench/ehd_fmi.py

Set both input fields, doStep, get both force fields of the built FMU by pointers, against the bare
model on the same films; also the directional derivative through the FMU against the bare one. One
thread, one run, the best of several passes.
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is loaded

from pathlib import Path
from time import perf_counter

import numpy as np
from timing import shortest

from piston_cosim.fmu_ehd.model import LubricationModel
from piston_cosim.fmu_ehd.parameters import Parameters
from piston_cosim.fmu_ehd.variables import DERIVATIVE_INPUTS, DERIVATIVE_OUTPUTS
from piston_cosim.master.fmi.builder import build_fmu
from piston_cosim.master.participants.fmi2 import FmuParticipant
from piston_cosim.tests.verification.cases.motored import DEGREE, motored_film

SHAPE = (40, 40)
STEPS = 360


def model_pass(inputs):
    """Time of each bare step [s], the last pressure force, and the model."""
    model = LubricationModel(Parameters(SHAPE, roughness_rms=5e-7))
    state, _ = model.start(*inputs[0])
    times = []
    for film, velocity in inputs[1:]:
        begin = perf_counter()
        state, outputs = model.advance(state, film, velocity, DEGREE)
        times.append(perf_counter() - begin)
    return np.array(times), outputs["nodal_pressure_force"], model


def fmu_pass(participant, start, inputs):
    """The same through FMI, from a saved state."""
    participant.restore(start)
    times = []
    for k, (film, velocity) in enumerate(inputs[1:]):
        begin = perf_counter()
        participant.set("film_thickness", film)
        participant.set("sliding_velocity", velocity)
        participant.step(k * DEGREE, DEGREE)
        force = participant.get("nodal_pressure_force")
        participant.get("nodal_friction_force")
        times.append(perf_counter() - begin)
    return np.array(times), force


def main():
    inputs = [motored_film(SHAPE, k * DEGREE) for k in range(STEPS + 1)]
    participant = FmuParticipant("ehd", build_fmu("fmu_ehd", {"grid": list(SHAPE)}, Path(".")))
    participant.start(
        {"roughness_rms": 5e-7, "film_thickness": inputs[0][0], "sliding_velocity": inputs[0][1]},
        0.0,
        1.0,
    )
    start = participant.save()
    model_pass(inputs[:20])
    fmu_pass(participant, start, inputs[:20])
    bare, through = [], []
    for _ in range(4):
        times, expected, model = model_pass(inputs)
        bare.append(times)
        times, force = fmu_pass(participant, start, inputs)
        through.append(times)
    assert np.array_equal(force, expected)
    bare, through = np.min(bare, axis=0).mean(), np.min(through, axis=0).mean()
    change = (
        np.random.default_rng(0).standard_normal((2, *SHAPE)) * np.array([1e-6, 1.0])[:, None, None]
    )
    seeds = dict(zip(DERIVATIVE_INPUTS, change))
    direct = shortest(lambda: model.tangent(*seeds.values()), 50)
    derivative = shortest(lambda: participant.derivative(seeds, DERIVATIVE_OUTPUTS), 50)
    print(
        f"bare step {1e6 * bare:.0f} us, through FMI {1e6 * through:.0f} us: "
        f"{through / bare:.2f} times (target 2), same bits"
    )
    print(
        f"bare derivative {1e6 * direct:.0f} us, through FMI {1e6 * derivative:.0f} us: "
        f"{derivative / direct:.1f} times"
    )
    participant.close()


if __name__ == "__main__":
    main()
