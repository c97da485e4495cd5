"""What a macro step of `run` costs with participants in Python, and with those of machine code: the
whole, inside the participants, and the ratio of both. Run: python tests/bench/slow/iteration.py

The numerical example, 40 x 40 cells, 180 deg from rest, fields left out of the results; a run of
one kind after a run of the other in one process, the best of several.
"""

import os
import sys
import tempfile
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is loaded

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.case.system import open_system
from piston_cosim.master.runs import run as running

STOP, CELLS, MODES, PASSES = "180 deg", 40, (0, 60), 3
COUNTS = ("residual_evaluations", "derivative_products")


def case_of(modes, native):
    """Case, its tree and its path."""
    path = find_case("numerical_example")
    own = {f"participants.bodies.build.{body}.modes": modes for body in ("piston", "block")}
    own |= {f"participants.{name}.build.grid": [CELLS, CELLS] for name in ("bodies", "ehd")}
    tree = read_tree(
        path, [*own.items(), ("time.stop", STOP), ("record.fields", []), ("native", native)]
    )
    return check_case(tree, path), tree, path


def summary_of(modes, native):
    """Of a run whose participants are of a kind, with the time inside [s]."""
    case, tree, path = case_of(modes, native)
    with tempfile.TemporaryDirectory() as folder:
        system = open_system(case, path.parent, lambda text: None)
        summary = running.run(system, case, tree, Path(folder) / "run.h5")
    return summary | {"inside": sum(summary[f"wall_time_{n}_s"] for n in case.participants)}


def line(name, summaries):
    """What the fastest of several runs took, in words."""
    best = min(summaries, key=lambda one: one["wall_time_s"])
    whole, inside = (1e3 * best[key] / best["steps"] for key in ("wall_time_s", "inside"))
    counts = ", ".join(f"{best[key]} {key}" for key in COUNTS)
    return (
        f"{name:>30}: {whole:6.2f} ms a step, {inside:6.2f} ms inside, ratio {whole / inside:.2f}, "
        f"the rest {whole - inside:5.2f} ms; {counts}"
    )


def main():
    kinds = {"participants in Python": False, "participants of machine code": True}
    for modes in MODES:
        found = {name: [] for name in kinds}
        for _ in range(PASSES):
            for name, native in kinds.items():
                found[name].append(summary_of(modes, native))
        print(f"{modes} modes a body")
        for name, summaries in found.items():
            print(line(name, summaries))


if __name__ == "__main__":
    sys.exit(main())
