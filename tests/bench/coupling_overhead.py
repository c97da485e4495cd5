"""Cost of FMI in the first revolution of the numerical example: FMUs against direct calls.

The direct calls use the same model classes in this process. Both use the same master, the same
steps, 60 modes per body and 40 x 40 cells, and alternate every 10 steps.

Run: python tests/bench/coupling_overhead.py
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is loaded

from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from time import perf_counter

import numpy as np

from piston_cosim.fmu_ehd.slave import Ehd
from piston_cosim.fmu_mfbd.slave import Mfbd
from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.case.system import open_system
from piston_cosim.master.coupling.methods import method_of
from piston_cosim.master.coupling.starting import start
from piston_cosim.master.coupling.stepping import Stepper
from piston_cosim.master.fmi.archive import unpack
from piston_cosim.master.participants.local import LocalParticipant

STEPS, TURN, UNTIMED = 360, 10, 20
SLAVES = {"ehd": Ehd, "bodies": Mfbd}
own = {}
"""What a worker process keeps between turns."""


def prepare(direct):
    """Start the case in this process, through FMUs or with the slaves called directly."""
    path = find_case("numerical_example")
    case = check_case(read_tree(path), path)
    system = open_system(case, path.parent, lambda text: None)
    if direct:
        system = replace(
            system,
            participants={
                name: LocalParticipant(
                    name,
                    SLAVES[name](instance_name=name, resources=str(unpack(p.path) / "resources")),
                )
                for name, p in system.participants.items()
            },
        )
    start(system)
    own.update(
        step=system.step,
        stepper=Stepper(system, method_of(case.coupling), 6, order=case.coupling.predictor),
    )


def turn(number):
    """Time of some macro steps [s], and where the wires stand then."""
    step, stepper, begin = own["step"], own["stepper"], perf_counter()
    for k in range(number * TURN, (number + 1) * TURN):
        stepper.advance(k * step, step)
    return perf_counter() - begin, stepper.predictor.past[-1][1]


def main():
    # a process each: numba looks types up slowly once equally named classes of two packages have
    # been seen
    workers = [
        ProcessPoolExecutor(
            1, mp_context=get_context("spawn"), initializer=prepare, initargs=(direct,)
        )
        for direct in (False, True)
    ]
    times, same = np.zeros((STEPS // TURN, 2)), True
    for number in range(len(times)):
        (times[number, 0], one), (times[number, 1], other) = (
            worker.submit(turn, number).result() for worker in workers
        )
        same &= np.array_equal(one, other)
    for worker in workers:
        worker.shutdown()
    timed = times[
        UNTIMED // TURN :
    ]  # what is compiled or first touched in the first steps is left out
    through, direct = timed.sum(axis=0) / (STEPS - UNTIMED)
    print(
        f"a macro step through FMUs {1e3 * through:.2f} ms, called directly {1e3 * direct:.2f} ms: "
        f"{through / direct:.2f} times (at most 1.5); "
        f"median of turns {np.median(timed[:, 0] / timed[:, 1]):.2f}; same bits: {same}"
    )


if __name__ == "__main__":
    main()
