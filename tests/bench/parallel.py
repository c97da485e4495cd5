"""What isolated participants that step at the same time gain: wall time of steps one after the
other beside that of the same steps at once, same bits.

Jacobi order: all read what the others said before. Participants that wait, which needs no core, say
what the schedule is worth on a machine with a core for each; participants that compute say it for
this machine, and mean something only where as many cores are idle. Branches: two chains of two that
meet nowhere, in sequential order, where each pair of the same depth steps at once.

A schedule for more cores than there are is played through: what the master does for each
participant of a macro step, one after the other, is measured on participants whose step takes no
time, half of it counted before a step is sent away and half after its end; the steps between run on
the cores that the master leaves. The same play for the participants that wait stands beside what
was measured.

Run: python tests/bench/parallel.py
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is loaded

import heapq
import sys
import tempfile
import tomllib
from pathlib import Path
from time import perf_counter

sys.path.insert(0, str(Path(__file__).parents[2]))
from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.system import open_system
from piston_cosim.master.coupling.methods import method_of
from piston_cosim.master.coupling.starting import closing, start
from piston_cosim.master.coupling.stepping import Stepper
from tests.fmu.c_fmus import compile_model
from tests.fmu.counter import SOURCE, make

STEP_TAKES = 150_000
"""Of a participant [us]."""
STEPS, STEP, ROUNDS = 8, 1e-3, 3
RING, BRANCHES = "ring", "branches"


def case_text(names, wires, isolated, parallel):
    """A case of counters, each in a process of its own or not."""
    own = f"isolated = {str(isolated).lower()}"
    tables = "".join(f'[participants.{n}]\nfmu = "model.fmu"\n{own}\n' for n in names)
    lines = "".join(f'[[wires]]\nfrom = "{a}.x"\nto = "{b}.u"\n' for a, b in wires)
    order = f"order = {list(names)}\nparallel = {str(parallel).lower()}\n".replace("'", '"')
    return (
        f'title = "counters"\n[time]\nstop = "{STEPS * STEP} s"\nstep = "{STEP} s"\n'
        f'{tables}{lines}[coupling]\nmethod = "explicit"\npredictor = 0\n{order}'
    )


def run(folder, names, wires, isolated, parallel):
    """Wall time a macro step [s], and what all participants say at the end."""
    case = check_case(tomllib.loads(case_text(names, wires, isolated, parallel)), "")
    system = open_system(case, folder, lambda _: None)
    with closing(system.participants.values()):
        start(system)
        stepper = Stepper(system, method_of(case.coupling), 6, order=0)
        begin = perf_counter()
        for k in range(STEPS):
            stepper.advance(k * STEP, STEP)
        spent = perf_counter() - begin
        return spent / STEPS, [one.get("x") for one in system.participants.values()]


def counters(folder, flag, takes, count):
    """An FMU whose step takes so long [us]; names of participants and the wires of a ring."""
    library = folder / "counter.so"
    compile_model(SOURCE, library, f"-D{flag}={takes}")
    make(folder / "model.fmu", library)
    names = [f"p{k}" for k in range(count)]
    return names, [(names[k], names[(k + 1) % count]) for k in range(count)]


def gain(what, flag, count, shape=RING):
    """Print how much faster steps at once are; flag: what a step does, for the compiler."""
    folder = Path(tempfile.mkdtemp())
    names, wires = counters(folder, flag, STEP_TAKES, count)
    if shape == BRANCHES:
        wires = [(names[0], names[2]), (names[1], names[3])]
    serial, parallel = [], []
    for _ in range(ROUNDS):  # turn by turn: the machine's mood is the same for both
        one = run(folder, names, wires, isolated=False, parallel=shape == RING)
        all_at_once = run(folder, names, wires, isolated=True, parallel=shape == RING)
        assert one[-1] == all_at_once[-1], "not the same bits"
        serial.append(one[0])
        parallel.append(all_at_once[0])
    print(
        f"{count} {what} participants, {shape:<8}  {1e3 * min(serial):7.1f} ms a step one by one, "
        f"{1e3 * min(parallel):6.1f} ms at once: {min(serial) / min(parallel):.2f} times faster",
        flush=True,
    )


def overhead(count):
    """What the master does for a participant of a macro step [s], of so many."""
    folder = Path(tempfile.mkdtemp())
    names, wires = counters(folder, "WAIT", 0, count)
    return min(run(folder, names, wires, True, True)[0] for _ in range(ROUNDS)) / count


def played(durations, each, cores):
    """Length of a macro step [s] of participants that take so long, by the schedule of
    `Interface._step`: sent away one after the other, waited for in the same order.
    """
    free = [0.0] * (cores - 1)  # one core is the master's
    ends, now = [], 0.0
    for duration in durations:
        now += each / 2
        heapq.heappush(free, end := max(now, heapq.heappop(free)) + duration)
        ends.append(end)
    for end in ends:
        now = max(now, end) + each / 2
    return now


def schedule(count, cores):
    """Print what the schedule is worth with so many participants and cores."""
    each = overhead(count)
    print(f"the master's own work: {1e3 * each:.3f} ms a participant and macro step")
    for takes in (STEP_TAKES / 1e6, 1e-2, 1e-3):
        even = [takes] * count
        uneven = [takes * (1 + 0.1 * k / (count - 1)) for k in range(count)]
        gains = [sum(steps) / played(steps, each, cores) for steps in (even, uneven)]
        print(
            f"{count} participants on {cores} cores, played: steps of {1e3 * takes:5.1f} ms "
            f"{gains[0]:.2f} times faster, of up to a tenth more {gains[1]:.2f}",
            flush=True,
        )


def main():
    gain("waiting", "WAIT", 2)
    gain("waiting", "WAIT", 4, BRANCHES)
    gain("waiting", "WAIT", 8)
    schedule(8, 16)
    gain("computing", "BURN", 2)


if __name__ == "__main__":
    main()
