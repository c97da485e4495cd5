"""Cost of the master for FMUs that cost nothing: processor time against a bare FMPy loop.

The FMUs have one input and one output (`tests/fmu/c_models/odd.c`). The bare loop sets the input,
takes the step and reads the output of each FMU by FMPy. The time of a run is the difference between
a long and a short one, so that start and end do not count. Bare loops and runs alternate, and the
median of their ratios counts, because other processes change the speed of the processor.

    python tests/bench/step_cost.py
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is loaded

import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from statistics import median
from time import process_time

import fmpy
from fmpy.fmi2 import FMU2Slave

import piston_cosim as pc
from piston_cosim.tests.fmu.c_fmus import MODELS, Variable, compile_model, describe, pack

H = 1e-3
STEP = "-DSTEP=x = (x + H * (u + 10 * (double)((int)(t * 1000 + 0.5) % 7))) / (1 + H)"
"""A forcing that jumps, so that an iteration has something to do."""
VARIABLES = [Variable("y", 1, "output"), Variable("u", 2, "input", "Real", 'start="0"')]
REPEATS = 7


def make(folder):
    """Return an FMU with x' = u + f(t) - x."""
    compile_model(MODELS / "odd.c", folder / "odd.so", STEP)
    return pack(folder / "odd.fmu", describe("2.0", "odd", VARIABLES), folder / "odd.so")


class Bare:
    """Ring of FMUs that FMPy steps."""

    def __init__(self, fmu, count):
        place = fmpy.extract(fmu)
        self.instances = [
            FMU2Slave(guid="1", unzipDirectory=place, modelIdentifier="odd", instanceName=f"f{k}")
            for k in range(count)
        ]
        for one in self.instances:
            one.instantiate()
            one.setupExperiment(startTime=0.0)
            one.enterInitializationMode()
            one.exitInitializationMode()

    def run(self, steps):
        y = 1.0
        for k in range(steps):
            for one in self.instances:
                one.setReal([2], [y])
                one.doStep(k * H, H)
                y = one.getReal([1])[0]


def run(fmu, count, folder, method, steps):
    """Run a ring and return its summary."""
    names = [f"f{k}" for k in range(count)]
    wires = [f"{a}.y -> {b}.u" for a, b in zip(names, [*names[1:], names[0]])]
    times = {"stop": f"{steps * H:.17g} s", "step": f"{H:g} s"}
    case = pc.couple(dict.fromkeys(names, fmu), wires, method=method, **times)
    return case.run(folder / "o.h5").summary


def per_step(cost: Callable[[Callable[[], object]], float], action, steps):
    """Return the cost of a step: the difference of a long and a short run."""
    short, long = (cost(partial(action, n)) for n in (steps, 3 * steps))
    return (long - short) / (2 * steps)


def seconds(action):
    """Return the processor time of an action [s]."""
    begin = process_time()
    action()
    return process_time() - begin


def main():
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        fmu = make(folder)
        for count, method, most in (
            (2, "explicit", 4.0),
            (2, "newton", 4.0),
            (50, "explicit", 2.5),
        ):
            steps, bare = 20000 // count, Bare(fmu, count)
            ours = partial(run, fmu, count, folder, method)
            evaluations = ours(steps)["residual_evaluations"] / steps
            rows = []
            for _ in range(REPEATS):
                taken = per_step(seconds, ours, steps) / evaluations
                rows.append((taken, per_step(seconds, bare.run, steps)))
            own, other = (1e6 * median(column) for column in zip(*rows))
            ratio = median(a / b for a, b in rows)
            print(
                f"{count:2d} FMUs, {method:8s}: {own:6.1f} us an evaluation ({evaluations:.2f} a "
                f"step), bare {other:6.1f} us: {ratio:.2f} times (at most {most:g})"
            )


if __name__ == "__main__":
    main()
