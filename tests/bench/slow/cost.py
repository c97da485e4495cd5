"""What a macro step costs, by cells and by modes: `run`, the time inside its participants, which no
master could spare, and both in one native FMU. Draws docs/cost.svg; some five minutes, a quiet
machine. Run: python tests/bench/slow/cost.py

The numerical example, 60 deg from rest, rigid steps and fields left out of the results; what either
needs to start is left out too. Beside what is drawn: what of the time inside is the film's, and the
derivatives that a macro step asks for.
"""

import sys
import tempfile
from pathlib import Path
from time import perf_counter
from typing import NamedTuple

HERE = Path(__file__).resolve()
sys.path.insert(0, str(HERE.parents[1]))

import matplotlib.pyplot as plt
from native import DEGREE_AT_6000, coupled_fmu, started

from piston_cosim.master.case.system import open_system
from piston_cosim.master.runs.run import run

STEPS, PASSES = 60, 2
CELLS = (20, 40, 80)  # around and along, 60 modes a body
MODES = (0, 20, 60, 200)  # a body, 40 x 40 cells
USUAL = 60, 40
PICTURE = HERE.parents[3] / "docs" / "cost.svg"
CURVES = ("run", "of that inside film and bodies", "both in one native FMU")


class Costs(NamedTuple):
    """Of a macro step: times as in `CURVES` and inside the film [ms], derivatives asked for."""

    run: float
    inside: float
    native: float
    film: float
    products: float


def costs(modes, cells):
    """`Costs`, the best of several passes."""
    fmu, case, tree, path = coupled_fmu(modes, (cells, cells), f"{STEPS} deg")
    found = []
    for _ in range(PASSES):
        with tempfile.TemporaryDirectory() as folder:
            system = open_system(case, path.parent, lambda text: None)
            found.append(run(system, case, tree, Path(folder) / "run.h5"))
    best = min(found, key=lambda summary: summary["wall_time_s"])
    inside = sum(best[f"wall_time_{name}_s"] for name in case.participants)
    one, at_start, _ = started(fmu, {}, "lateral_displacement")
    native = []
    for _ in range(PASSES):
        one.restore(at_start)
        begin = perf_counter()
        for k in range(STEPS):
            one.step(k * DEGREE_AT_6000, DEGREE_AT_6000)
        native.append(perf_counter() - begin)
    one.close()
    ms_a_step = 1e3 / STEPS
    return Costs(
        ms_a_step * best["wall_time_s"],
        ms_a_step * inside,
        ms_a_step * min(native),
        ms_a_step * best["wall_time_ehd_s"],
        best["derivative_products"] / best["steps"],
    )


def table(name, values, rows):
    """Print what was measured, with what is asked of it."""
    print(
        f"{name:>8} {'run':>9} {'inside':>9} {'film':>9} {'native':>9} {'run/inside':>11} "
        f"{'run/native':>11} {'products':>9}"
    )
    for value, one in zip(values, rows):
        print(
            f"{value:8d} {one.run:6.2f} ms {one.inside:6.2f} ms {one.film:6.2f} ms "
            f"{one.native:6.2f} ms {one.run / one.inside:11.2f} {one.run / one.native:11.1f} "
            f"{one.products:9.1f}"
        )


def draw(by_cells, by_modes):
    """Both pictures side by side."""
    figure, axes = plt.subplots(1, 2, figsize=(9.0, 3.6), sharey=True, layout="constrained")
    for ax, values, rows, label in (
        (axes[0], CELLS, by_cells, f"cells around and along, {USUAL[0]} modes a body"),
        (axes[1], MODES, by_modes, f"modes a body, {USUAL[1]} x {USUAL[1]} cells"),
    ):
        for curve, style, times in zip(CURVES, ("o-", "o--", "s-"), zip(*rows)):
            ax.plot(values, times, style, label=curve)
        ax.set(xlabel=label, yscale="log")
        ax.grid(which="both", alpha=0.3)
    axes[0].set(xscale="log", xticks=CELLS, xticklabels=CELLS, ylabel="time a macro step [ms]")
    axes[0].minorticks_off()
    axes[1].set_xticks(MODES)
    axes[0].legend()
    figure.savefig(PICTURE)


if __name__ == "__main__":
    by_modes = [costs(modes, USUAL[1]) for modes in MODES]
    table("modes", MODES, by_modes)
    by_cells = [by_modes[2] if n == USUAL[1] else costs(USUAL[0], n) for n in CELLS]
    table("cells", CELLS, by_cells)
    draw(by_cells, by_modes)
