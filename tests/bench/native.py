"""What machine code is worth for both FMUs. Run: python tests/bench/native.py

The same films through the native FMU and the FMU in Python, both by pointers in one process, a step
of the one after a step of the other; also one directional derivative of each. Then bodies in the
same way: those of the numerical example, pressed by a film that turns round. One thread, the best
of several passes for every step, so that what else the machine does counts little; the time from
opening the file to the first outputs, most of it the reading of the model description.
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is loaded

from pathlib import Path
from time import perf_counter, process_time

import numpy as np
from timing import shortest

from piston_cosim.fmu_ehd.variables import DERIVATIVE_INPUTS, DERIVATIVE_OUTPUTS
from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.fmi.builder import build_fmu
from piston_cosim.master.fmi.builder_native import build_native_fmu
from piston_cosim.master.participants.fmi2 import FmuParticipant
from piston_cosim.tests.verification.cases.motored import DEGREE, motored_film

FILMS = ((12, 10), (20, 20), (40, 40), (80, 80))
BODIES = ((0, (12, 10)), (0, (40, 40)), (60, (40, 40)))  # modes a body, grid
STEPS = 180
PASSES = 4
FORCES = ("nodal_pressure_force", "nodal_friction_force")
GAP = ("film_thickness", "sliding_velocity")
FILM_ROUND_OFF = 0.0  # of the largest value of an output
BODY_ROUND_OFF = 1e-12  # products with a matrix are another library's
DEGREE_AT_6000 = float(np.radians(1.0)) / (2 * np.pi * 100.0)  # [s]


def step(participant, time, inputs, outputs):
    """Processor time of a step with inputs set and outputs read [s], and the first of these."""
    begin = process_time()
    for name, values in inputs.items():
        participant.set(name, values)
    participant.step(time, DEGREE)
    found = [participant.get(name) for name in outputs]
    return process_time() - begin, found[0]


def started(path, inputs, output):
    """Return an FMU's started instance, its state, and the duration of the start [s]."""
    begin = perf_counter()
    one = FmuParticipant("one", path)
    one.start(inputs, 0.0, 1.0)
    one.get(output)
    return one, one.save(), perf_counter() - begin


def compare(package, build, course, outputs, seeds, round_off):
    """Ratios of the FMU of one package, of a build table and its folder, in words."""
    first = dict(course[0])
    native, native_start, ready = started(
        build_native_fmu(package, *build, print), first, outputs[0]
    )
    python, python_start, _ = started(build_fmu(package, *build, print), first, outputs[0])
    times = np.empty((2, PASSES, STEPS))
    for n in range(PASSES):
        native.restore(native_start)
        python.restore(python_start)
        for k, inputs in enumerate(course[1:]):
            times[0, n, k], ours = step(native, k * DEGREE, inputs, outputs)
            times[1, n, k], expected = step(python, k * DEGREE, inputs, outputs)
            assert np.abs(ours - expected).max() <= round_off * np.abs(expected).max()
    of_native, of_python = times.min(axis=1).mean(axis=1)
    direct = shortest(lambda: native.derivative(seeds, outputs), 30)
    through = shortest(lambda: python.derivative(seeds, outputs), 30)
    native.close()
    python.close()
    return (
        f"step {1e6 * of_native:.0f} us native, {1e6 * of_python:.0f} us Python, ratio "
        f"{of_native / of_python:.2f}; derivative {1e6 * direct:.0f} us, {1e6 * through:.0f} us, "
        f"ratio {direct / through:.2f}; first outputs after {1e3 * ready:.0f} ms"
    )


def film(grid):
    """Ratios of the lubrication FMU on a grid."""
    motion = [motored_film(grid, k * DEGREE) for k in range(STEPS + 1)]
    course = [dict(zip(GAP, both)) for both in motion]
    course[0]["roughness_rms"] = 5e-7
    change = np.random.default_rng(0).standard_normal((2, *grid)) * [[[1e-6]], [[1.0]]]
    seeds = dict(zip(DERIVATIVE_INPUTS, change))
    build = {"grid": list(grid)}, Path(".")
    return compare("fmu_ehd", build, course, DERIVATIVE_OUTPUTS, seeds, FILM_ROUND_OFF)


def bodies(modes, grid):
    """Ratios of the body FMU of the numerical example with so many modes a body, on a grid."""
    path = find_case("numerical_example")
    own = {f"participants.bodies.build.{body}.modes": modes for body in ("piston", "block")}
    tree = read_tree(path, [*own.items(), ("participants.bodies.build.grid", list(grid))])
    build = check_case(tree, path).participants["bodies"].build, path.parent
    around = np.arange(grid[0]) * 2 * np.pi / grid[0]
    course = [
        {
            FORCES[0]: np.tile(0.1 * (1 + np.cos(around - np.radians(k)))[:, None], (1, grid[1])),
            FORCES[1]: np.full(grid, 0.01),
        }
        for k in range(STEPS + 1)
    ]
    seeds = dict(zip(FORCES, np.random.default_rng(0).standard_normal((2, *grid))))
    return compare("fmu_mfbd", build, course, GAP, seeds, BODY_ROUND_OFF)


if __name__ == "__main__":
    for grid in FILMS:
        print(f"film, {grid[0]} x {grid[1]}: {film(grid)}", flush=True)
    for modes, grid in BODIES:
        words = f"bodies, {modes} modes each, {grid[0]} x {grid[1]}"
        print(f"{words}: {bodies(modes, grid)}", flush=True)
