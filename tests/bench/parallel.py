"""What isolated participants that step at the same time gain: wall time of steps one after the
other beside that of the same steps at once, same bits.

Jacobi order: all read what the others said before. Participants that wait, which needs no core, say
what the schedule is worth on a machine with a core for each; participants that compute say it for
this machine, and mean something only where as many cores are idle. Branches: two chains of two that
meet nowhere, in sequential order, where each pair of the same depth steps at once.

Run: python tests/bench/parallel.py
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is loaded

import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path
from time import perf_counter

sys.path.insert(0, str(Path(__file__).parents[2]))
from piston_cosim.master.case.schema import check_case
from piston_cosim.master.case.system import open_system
from piston_cosim.master.coupling.methods import method_of
from piston_cosim.master.coupling.starting import closing, start
from piston_cosim.master.coupling.stepping import Stepper
from piston_cosim.master.fmi.compiler import compiler
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


def gain(what, flag, count, shape=RING):
    """Print how much faster steps at once are; flag: what a step does, for the compiler."""
    folder = Path(tempfile.mkdtemp())
    library = folder / "counter.so"
    command = [compiler(), "-O1", "-shared", "-fPIC", f"-D{flag}={STEP_TAKES}", SOURCE]
    subprocess.run([*command, "-o", library], check=True)
    make(folder / "model.fmu", library)
    names = [f"p{k}" for k in range(count)]
    wires = [(names[k], names[(k + 1) % count]) for k in range(count)]
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


def main():
    gain("waiting", "WAIT", 2)
    gain("waiting", "WAIT", 4, BRANCHES)
    gain("waiting", "WAIT", 8)
    gain("computing", "BURN", 2)


if __name__ == "__main__":
    main()
