"""What machine code is worth for the lubrication FMU. Run: python tests/bench/native.py

The same films through the native FMU and the FMU in Python, both by pointers in one process, a step
of the one after a step of the other; also one directional derivative of each. One thread, the best
of several passes for every step, so that what else the machine does counts little; the time from
opening the file to the first outputs, most of it the reading of the model description.
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is loaded

from pathlib import Path
from time import perf_counter

import numpy as np
from timing import shortest

from piston_cosim.fmu_ehd.motored import DEGREE, motored_film
from piston_cosim.fmu_ehd.variables import DERIVATIVE_INPUTS, DERIVATIVE_OUTPUTS
from piston_cosim.master.fmi.builder import build_fmu
from piston_cosim.master.fmi.builder_native import build_native_fmu
from piston_cosim.master.participants.fmi2 import FmuParticipant

GRIDS = ((12, 10), (20, 20), (40, 40), (80, 80))
STEPS = 180
PASSES = 4


def step(participant, time, film, velocity):
    """Time of one step with its inputs set and its forces read [s], and a force."""
    begin = perf_counter()
    participant.set("film_thickness", film)
    participant.set("sliding_velocity", velocity)
    participant.step(time, DEGREE)
    force = participant.get("nodal_pressure_force")
    participant.get("nodal_friction_force")
    return perf_counter() - begin, force


def started(path, inputs):
    """An instance of an FMU after its start, its state there, and how long that took [s]."""
    begin = perf_counter()
    one = FmuParticipant("film", path)
    film, velocity = inputs[0]
    values = {"roughness_rms": 5e-7, "film_thickness": film, "sliding_velocity": velocity}
    one.start(values, 0.0, 1.0)
    one.get("nodal_pressure_force")
    return one, one.save(), perf_counter() - begin


def compare(grid):
    """Print the ratios of one grid."""
    inputs = [motored_film(grid, k * DEGREE) for k in range(STEPS + 1)]
    options = {"grid": list(grid)}
    native, native_start, ready = started(
        build_native_fmu("fmu_ehd", options, Path("."), print), inputs
    )
    python, python_start, _ = started(build_fmu("fmu_ehd", options, Path("."), print), inputs)
    times = np.empty((2, PASSES, STEPS))
    for n in range(PASSES):
        native.restore(native_start)
        python.restore(python_start)
        for k, (film, velocity) in enumerate(inputs[1:]):
            times[0, n, k], force = step(native, k * DEGREE, film, velocity)
            times[1, n, k], expected = step(python, k * DEGREE, film, velocity)
            assert np.array_equal(force, expected)
    of_native, of_python = times.min(axis=1).mean(axis=1)
    change = np.random.default_rng(0).standard_normal((2, *grid)) * [[[1e-6]], [[1.0]]]
    seeds = dict(zip(DERIVATIVE_INPUTS, change))
    direct = shortest(lambda: native.derivative(seeds, DERIVATIVE_OUTPUTS), 30)
    through = shortest(lambda: python.derivative(seeds, DERIVATIVE_OUTPUTS), 30)
    print(
        f"{grid[0]} x {grid[1]}: step {1e6 * of_native:.0f} us native, {1e6 * of_python:.0f} us "
        f"Python, ratio {of_native / of_python:.2f}; derivative {1e6 * direct:.0f} us, "
        f"{1e6 * through:.0f} us, ratio {direct / through:.2f}; first outputs after "
        f"{1e3 * ready:.0f} ms; same bits"
    )
    native.close()
    python.close()


if __name__ == "__main__":
    for grid in GRIDS:
        compare(grid)
