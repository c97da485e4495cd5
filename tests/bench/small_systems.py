"""Cost of the master for FMUs that cost nothing: two scalar FMUs, processor time of a macro step,
side by side with a bare loop of FMPy calls that exchanges the same values.

Each method is measured twice: the stepper alone, and a user's run through `pc.couple` with all
outputs recorded. Of the latter the time of a step is the difference of a long and a short run, and
the start is the rest. An evaluation is a step of every participant; a derivative by differences
takes one.

Run: python tests/bench/small_systems.py [--check]
     --check exits with 1 if a user's step takes more than 4 times the bare loop for an evaluation
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is loaded

import sys
import tempfile
import tomllib
from pathlib import Path
from time import process_time
from typing import NamedTuple

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave

sys.path.insert(0, str(Path(__file__).parents[2]))
import piston_cosim as pc
from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.system import open_system
from piston_cosim.master.coupling.methods import method_of
from piston_cosim.master.coupling.starting import closing, start
from piston_cosim.master.coupling.stepping import Stepper
from tests.fmu import counter
from tests.fmu.c_fmus import compile_model
from tests.fmu.counter import SOURCE, case_text

STEPS, STEP, ROUNDS = 1000, 1e-3, 10
LONG = 3
"""Length of the long run, in short ones."""
ALLOWED = 4.0
"""Largest cost of an evaluation through `pc.couple`, in bare loops."""
SCALARS = 3
"""Variables of the FMUs: a parameter, an input and an output."""
K, U, X = 0, 1, 2
"""Value references of the lag: its constant, input and output."""


def bare(folder):
    """CPU a step [us] of FMPy's calls in a loop, and where x is at the end."""
    slaves = []
    for name in "ab":
        path = str(folder / f"{name}.fmu")
        description = fmpy.read_model_description(path, validate=False)
        slave = FMU2Slave(
            guid=description.guid,
            unzipDirectory=fmpy.extract(path),
            instanceName=name,
            modelIdentifier="counter",
        )
        slave.instantiate()
        slave.setupExperiment(startTime=0.0)
        slave.setReal([K], [2.0])
        slave.enterInitializationMode()
        slave.exitInitializationMode()
        slaves.append(slave)
    a, b = slaves
    begin = process_time()
    for k in range(STEPS):
        a.setReal([U], b.getReal([X]))
        a.doStep(k * STEP, STEP)
        b.setReal([U], a.getReal([X]))
        b.doStep(k * STEP, STEP)
    spent = process_time() - begin
    return 1e6 * spent / STEPS, a.getReal([X])[0]


def stepping(folder, method):
    """The same of macro steps under the master, and iterations a step."""
    wires = [("a.x", "b.u", ""), ("b.x", "a.u", "")]
    text = case_text(wires, method, f"{STEPS * STEP} s", f"{STEP} s", *2 * ["k = 2.0"])
    case = check_case(tomllib.loads(text.replace("[coupling]", "[coupling]\npredictor = 0")), "")
    system = open_system(case, folder, print)
    with closing(system.participants.values()):
        start(system)
        stepper = Stepper(system, method_of(case.coupling), 6, order=0)
        begin = process_time()
        for k in range(STEPS):
            stepper.advance(k * STEP, STEP)
        spent = process_time() - begin
        x = system.participants["a"].get("x")
    return 1e6 * spent / STEPS, x, float(np.mean(stepper.counters.iterations))


class Cost(NamedTuple):
    """Processor time of a short and of a long run [s]; evaluations of a step."""

    short: float
    long: float
    evaluations: float


def through_couple(folder, method):
    """Return the `Cost` of a user's run."""
    spent = []
    for steps in (STEPS, LONG * STEPS):
        case = pc.couple(
            {name: folder / f"{name}.fmu" for name in "ab"},
            ["a.x -> b.u", "b.x -> a.u"],
            stop=f"{steps * STEP} s",
            step=f"{STEP} s",
            method=method,
            parameters={name: {"k": 2.0} for name in "ab"},
        )
        begin = process_time()
        results = case.run(folder / "results.h5")
        spent.append(process_time() - begin)
    counted = results.summary
    evaluations = counted["residual_evaluations"] + counted["derivative_products"]
    return Cost(spent[0], spent[1], evaluations / counted["steps"])


def main():
    folder = Path(tempfile.mkdtemp())
    library = folder / "counter.so"
    compile_model(SOURCE, library)
    del counter.VARIABLES[SCALARS:]
    for name in "ab":
        counter.make(folder / f"{name}.fmu", library)
    methods = ("explicit", "aitken", "iqn_ils", "newton")
    costs = {method: [] for method in ("bare", *methods)}
    users = {method: [] for method in methods}
    for _ in range(ROUNDS):  # turn by turn: the machine's mood is the same for all
        cost, expected = bare(folder)
        costs["bare"].append(cost)
        for method in methods:
            cost, x, iterations = stepping(folder, method)
            costs[method].append((cost, iterations))
            users[method].append(through_couple(folder, method))
            if method == "explicit":
                same = x == expected
    least = min(costs["bare"])
    print(f"bare loop of FMPy calls {least:6.1f} us a step")
    print("method      stepper alone   through pc.couple   evaluations   times a bare loop   start")
    slow = []
    for method in methods:
        alone, _ = min(costs[method])
        short, long = (min(times) for times in list(zip(*users[method]))[:2])
        step = 1e6 * (long - short) / ((LONG - 1) * STEPS)
        start = 1e3 * (short - (long - short) / (LONG - 1))
        evaluations = users[method][0].evaluations
        ratio = step / evaluations / least
        print(
            f"{method:<10} {alone:11.1f} us {step:16.1f} us {evaluations:13.2f} {ratio:21.1f} "
            f"{start:8.0f} ms"
        )
        if method in ("explicit", "newton") and ratio > ALLOWED:
            slow.append(method)
    print(f"explicit gives the bits of the bare loop: {same}")
    return 1 if "--check" in sys.argv and (slow or not same) else 0


if __name__ == "__main__":
    sys.exit(main())
