"""Cost of a macro step, by cells and by modes, with participants in Python and native.

It times `run` with Python participants, the time inside these, which no master could save, and both
participants in one native FMU. It also prints the film's share of the time inside, `run` with
native participants, the time inside these, and the number of derivatives per macro step.

The run is the numerical example from rest, without fields in the results. The time of the start is
left out, and the best of several passes counts.

Run: python tests/bench/slow/cost.py [STEPS [FOLDER]], on a quiet machine. FOLDER is a checkout of
an earlier version, whose native FMU is measured too. 60 steps of 1 deg, the default, and a FOLDER
draw docs/cost.svg.
"""

import sys
from math import nan
from pathlib import Path
from time import perf_counter
from typing import NamedTuple

HERE = Path(__file__).resolve()
sys.path.insert(0, str(HERE.parents[1]))

import matplotlib.pyplot as plt
from native import DEGREE_AT_6000, started
from speed import measured

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.export import export_fmu
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.tests.verification.cases.coupling import modes_a_body, summary_of

STEPS = int(sys.argv[1]) if sys.argv[1:] else 60
EARLIER = sys.argv[2] if sys.argv[2:] else None
PASSES = 2
CELLS = (20, 40, 80)  # around and along
MODES = (0, 20, 60, 150)  # a body
USUAL = 60, 40
PICTURE = HERE.parents[3] / "docs" / "cost.svg"
CURVES = {
    "run": ("o-", "run, participants in Python"),
    "inside": ("o:", "of that inside film and bodies"),
    "before": ("s--", "one native FMU, commit 286c6dce"),
    "native": ("^-", "run, native participants"),
    "single": ("s-", "one native FMU"),
    "native_inside": ("s:", "inside native film and bodies"),
}
"""Member of `Costs` -> style and label."""


class Costs(NamedTuple):
    """Times of a macro step [ms] and number of derivatives (`products`).

    `film` is the time inside the film in Python, `before` that of the native FMU of `EARLIER`.
    """

    run: float
    inside: float
    single: float
    before: float
    film: float
    native: float
    native_inside: float
    products: float


def costs(modes, *grid):
    """Return `Costs`, the best of several passes."""
    grids = [(f"participants.{name}.build.grid", list(grid)) for name in ("bodies", "ehd")]
    rest = ("time.stop", f"{STEPS} deg"), ("record.fields", [])
    changes = [*modes_a_body(modes), *grids, *rest]
    python, native = (
        min(
            (summary_of("numerical_example", *changes, ("native", kind)) for _ in range(PASSES)),
            key=lambda summary: summary["wall_time_s"],
        )
        for kind in (False, True)
    )
    path = find_case("numerical_example")
    case = check_case(read_tree(path, changes), path)
    fmu = export_fmu(case, path.parent, print, "2.0", ["linux64"])
    one, at_start, _ = started(fmu, {}, "lateral_displacement")
    single = []
    for _ in range(PASSES):
        one.restore(at_start)
        begin = perf_counter()
        for k in range(STEPS):
            one.step(k * DEGREE_AT_6000, DEGREE_AT_6000)
        single.append(perf_counter() - begin)
    one.close()

    def inside(summary, *names):
        return 1e3 / summary["steps"] * sum(summary[f"wall_time_{name}_s"] for name in names)

    return Costs(
        1e3 / python["steps"] * python["wall_time_s"],
        inside(python, "bodies", "ehd"),
        1e3 / STEPS * min(single),
        1e3 * min(_before(changes) for _ in range(PASSES)) if EARLIER else nan,
        inside(python, "ehd"),
        1e3 / native["steps"] * native["wall_time_s"],
        inside(native, "bodies", "ehd"),
        python["derivative_products"] / python["steps"],
    )


def _before(changes):
    """Return the time of a macro step of the native FMU of `EARLIER` [s]."""
    return measured("single", STEPS, dict(changes), EARLIER)["step"]


def table(name, values, rows):
    """Print times [ms] and their ratios."""
    heads = (*Costs._fields, "run/inside", "native/inside", "run/single")
    print(f"{name:>8}", *(f"{head:>14}" for head in heads))
    for value, one in zip(values, rows):
        ratios = one.run / one.inside, one.native / one.native_inside, one.run / one.single
        print(f"{value:8d}", *(f"{figure:14.2f}" for figure in (*one, *ratios)))


def draw(by_cells, by_modes):
    """Both pictures side by side."""
    figure, axes = plt.subplots(1, 2, figsize=(9.0, 4.3), sharey=True, layout="constrained")
    for ax, values, rows, label in (
        (axes[0], CELLS, by_cells, f"cells around and along, {USUAL[0]} modes a body"),
        (axes[1], MODES, by_modes, f"modes a body, {USUAL[1]} x {USUAL[1]} cells"),
    ):
        for curve, (style, name) in CURVES.items():
            ax.plot(values, [getattr(one, curve) for one in rows], style, label=name)
        ax.set(xlabel=label, yscale="log")
        ax.grid(which="both", alpha=0.3)
    axes[0].set(xscale="log", xticks=CELLS, xticklabels=CELLS, ylabel="time a macro step [ms]")
    axes[0].minorticks_off()
    axes[1].set_xticks(MODES)
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    figure.savefig(PICTURE)


if __name__ == "__main__":
    by_modes = [costs(modes, USUAL[1], USUAL[1]) for modes in MODES]
    table("modes", MODES, by_modes)
    by_cells = [by_modes[2] if n == USUAL[1] else costs(USUAL[0], n, n) for n in CELLS]
    table("cells", CELLS, by_cells)
    table("rigid", [12], [costs(0, 12, 10)])
    if STEPS == 60 and EARLIER:
        draw(by_cells, by_modes)
