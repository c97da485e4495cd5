"""What the master costs where FMUs cost nothing: two scalar FMUs, CPU a macro step, beside a bare
loop of FMPy calls that exchanges the same values.

Run: python tests/bench/small_systems.py
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is loaded

import sys
import tempfile
import tomllib
from pathlib import Path
from time import process_time

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave

sys.path.insert(0, str(Path(__file__).parents[2]))
from piston_cosim.master.case.schema import check_case
from piston_cosim.master.case.system import open_system
from piston_cosim.master.coupling.methods import method_of
from piston_cosim.master.coupling.starting import closing, start
from piston_cosim.master.coupling.stepping import Stepper
from tests.fmu.c_fmus import compile_model
from tests.fmu.counter import SOURCE, case_text, make

STEPS, STEP, ROUNDS = 1000, 1e-3, 20
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


def main():
    folder = Path(tempfile.mkdtemp())
    library = folder / "counter.so"
    compile_model(SOURCE, library)
    for name in "ab":
        make(folder / f"{name}.fmu", library)
    methods = ("explicit", "aitken", "iqn_ils", "newton")
    costs = {method: [] for method in ("bare", *methods)}
    for _ in range(ROUNDS):  # turn by turn: the machine's mood is the same for all
        cost, expected = bare(folder)
        costs["bare"].append(cost)
        for method in methods:
            cost, x, iterations = stepping(folder, method)
            costs[method].append((cost, iterations))
            if method == "explicit":
                same = x == expected
    least = min(costs["bare"])
    print(f"bare loop of FMPy calls  {least:6.1f} us of CPU a step")
    for method in methods:
        cost, iterations = min(costs[method])
        print(
            f"{method:<23} {cost:7.1f} us of CPU a step, {cost / least:5.1f} times, "
            f"{iterations:.1f} iterations"
        )
    print(f"explicit gives the bits of the bare loop: {same}")


if __name__ == "__main__":
    main()
