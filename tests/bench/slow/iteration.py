"""What a macro step of `run` costs with participants in Python, and with those of machine code: the
whole, inside the participants, and the ratio of both. Run: python tests/bench/slow/iteration.py

The numerical example, 40 x 40 cells, 180 deg from rest, fields left out of the results; a run of
one kind after a run of the other in one process, the best of several.
"""

import os
import sys

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is loaded

from piston_cosim.tests.verification.cases import coupling
from piston_cosim.tests.verification.cases.coupling import modes_a_body

STOP, CELLS, MODES, PASSES = "180 deg", 40, (0, 60), 3
PARTICIPANTS = ("bodies", "ehd")
COUNTS = ("residual_evaluations", "derivative_products")


def summary_of(modes, native):
    """Of a run whose participants are of a kind, with the time inside [s]."""
    grids = [(f"participants.{name}.build.grid", [CELLS, CELLS]) for name in PARTICIPANTS]
    rest = ("time.stop", STOP), ("record.fields", []), ("native", native)
    summary = coupling.summary_of("numerical_example", *modes_a_body(modes), *grids, *rest)
    return summary | {"inside": sum(summary[f"wall_time_{name}_s"] for name in PARTICIPANTS)}


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
