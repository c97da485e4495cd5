"""What a macro step of `run` costs with its iteration as machine code, beside that in Python: the
whole, inside the participants, and the ratio of both. Run: python tests/bench/slow/iteration.py

The numerical example, 40 x 40 cells, 180 deg from rest, fields left out of the results; a run of
the one after a run of the other in one process, the best of several.
"""

import os
import sys
import tempfile
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is loaded

from piston_cosim.master.case.schema import check_case, find_case, read_tree
from piston_cosim.master.case.system import open_system
from piston_cosim.master.fmi.builder_native import ITERATING, iteration_library, object_files
from piston_cosim.master.runs import run as running

STOP, CELLS, MODES, PASSES = "180 deg", 40, (0, 60), 3
COUNTS = ("residual_evaluations", "derivative_products")


def case_of(modes):
    """Case, its tree and its path."""
    path = find_case("numerical_example")
    own = {f"participants.bodies.build.{body}.modes": modes for body in ("piston", "block")}
    own |= {f"participants.{name}.build.grid": [CELLS, CELLS] for name in ("bodies", "ehd")}
    tree = read_tree(path, [*own.items(), ("time.stop", STOP), ("record.fields", [])])
    return check_case(tree, path), tree, path


def summary_of(case, tree, path, choose):
    """Of a run whose method is chosen so."""
    running.compiled_where_it_can = choose
    with tempfile.TemporaryDirectory() as folder:
        system = open_system(case, path.parent, lambda text: None)
        return running.run(system, case, tree, Path(folder) / "run.h5")


def line(name, case, summaries):
    """What the fastest of several runs took, in words."""
    best = min(summaries, key=lambda one: one["wall_time_s"])
    whole = 1e3 * best["wall_time_s"] / best["steps"]
    inside = sum(1e3 * best[f"wall_time_{n}_s"] / best["steps"] for n in case.participants)
    counts = ", ".join(f"{best[key]} {key}" for key in COUNTS)
    return (
        f"{name:>12}: {whole:6.2f} ms a step, {inside:6.2f} ms inside, ratio {whole / inside:.2f}, "
        f"the rest {whole - inside:5.2f} ms; {counts}"
    )


def main():
    if not iteration_library():
        object_files(ITERATING, ["linux64"], print)
    compiled = running.compiled_where_it_can
    ways = {"Python": lambda method, system: method, "machine code": compiled}
    for modes in MODES:
        case, tree, path = case_of(modes)
        found = {name: [] for name in ways}
        for _ in range(PASSES):
            for name, choose in ways.items():
                found[name].append(summary_of(case, tree, path, choose))
        print(f"{modes} modes a body")
        for name, summaries in found.items():
            print(line(name, case, summaries))


if __name__ == "__main__":
    sys.exit(main())
