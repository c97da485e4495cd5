"""Cost of forward sensitivities against the run itself, of a rigid piston in Python.

    python tests/bench/forward.py [CELLS [STEPS]]

The run takes STEPS macro steps (default: 120) of 1 deg, with CELLS (default: 40) around and along.
Variables are viscosities with different steps. Processor time of all steps after the start, one
thread. The run without variables evaluates its participants alone.
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is loaded

import sys
import time

import piston_cosim as pc
from piston_cosim.master.case.checked import check_case
from piston_cosim.master.coupling.forward import ForwardSensitivities, Pair
from piston_cosim.master.coupling.methods import method_of
from piston_cosim.master.coupling.starting import start
from piston_cosim.master.coupling.stepping import Observer, Stepper
from piston_cosim.master.runs.forward import SHARE, local_system

VARIABLES = (0, 1, 20)
WARM = 5  # steps before the measured ones, which load kernels


def system_at(cells, share=0.0):
    """Return the system with a share of 2 % more viscosity."""
    changes = {f"participants.{name}.build.grid": [cells, cells] for name in ("bodies", "ehd")}
    changes["participants.ehd.parameters.viscosity"] = f"{6.0 * (1.0 + 0.02 * share)!r} mPa s"
    case = pc.open_case("numerical_example", variant="rigid").changed(changes)
    return local_system(case.tree, case.path), check_case(case.tree, case.path).coupling


def seconds(cells, steps, count):
    """Return the processor time of the steps with derivatives by some variables [s]."""
    system, coupling = system_at(cells)
    start(system)
    observer = Observer()
    if count:
        shares = [SHARE * (1.0 + k / count) for k in range(count)]
        pairs = [Pair(system_at(cells, e)[0], system_at(cells, -e)[0], e) for e in shares]
        observer = ForwardSensitivities(system_at(cells)[0], pairs)
    halvings = coupling.advanced.halvings
    stepper = Stepper(system, method_of(coupling), halvings, observer, coupling.predictor)
    for k in range(WARM + steps):
        if k == WARM:
            begin = time.process_time()
        stepper.advance(k * system.step, system.step)
    return time.process_time() - begin


def main(cells=40, steps=120):
    """Print the times."""
    plain = seconds(cells, steps, 0)
    print(f"{cells} x {cells}, {steps} steps: run {plain:.2f} s")
    for count in VARIABLES[1:]:
        own = seconds(cells, steps, count)
        print(f"{count:3d} variables: {own:.2f} s, {(own - plain) / plain:.1f} runs more")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
