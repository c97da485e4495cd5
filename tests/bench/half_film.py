"""Cost of half a film against the whole one, of film and bodies, in Python and as machine code.

    python tests/bench/half_film.py [CELLS] [--curves DEGREES [--tolerance METRES]]

Film: the same symmetric film on both grids. Bodies: those of the numerical example under forces of
a film. A step of the one follows a step of the other. The best of several passes counts for every
step, so that other processes count little. A step is followed by a directional derivative. One
thread; CELLS (default: 40) around and along.

With --curves the numerical example also runs over DEGREES of the crank with half and with whole
films. Both have the same tolerance of the film thickness (default: 10 nm). The largest difference
of each curve is over its range.
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is loaded

import argparse
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from native import FORCES, GAP, started, step
from timing import shortest

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.fmi.builder import build_fmu
from piston_cosim.master.fmi.builder_native import build_native_fmu
from piston_cosim.tests.fmu.runs import EXAMPLE, datasets, run_tree
from piston_cosim.tests.verification.cases.motored import DEGREE, motored_film

STEPS, PASSES = 60, 4
ROUND_OFF = 1e-9  # of the largest value
TOLERANCE = 1e-8  # m, of the film thickness by default
NO_CURVES = (
    "bodies/interface_work_error",
    "bodies/jacobian_evaluations",
    "bodies/residual_evaluations",
    "ehd/mass_imbalance",
)
"""Outputs that are counts, or consist of round-off and of what the iteration leaves."""
CHOICES = (1, 3)  # none, automatic


def compare(name, fmu, course, outputs):
    """Print the times of a step and of a derivative with whole and half films."""
    both = [started(fmu, {"film_symmetry": k, **course[0]}, outputs[0])[:2] for k in CHOICES]
    times = np.empty((2, PASSES, STEPS))
    for n in range(PASSES):
        for one, begin in both:
            one.restore(begin)
        for k, inputs in enumerate(course[1:]):
            found = [step(one, k * DEGREE, inputs, outputs) for one, _ in both]
            times[:, n, k] = [seconds for seconds, _ in found]
            whole, half = (values for _, values in found)
            assert np.abs(half - whole).max() <= ROUND_OFF * np.abs(whole).max()
    seeds = {key: np.ones_like(value) for key, value in course[0].items()}
    of_step = 1e3 * times.min(axis=1).mean(axis=1)
    of_seed = [1e3 * shortest(partial(one.derivative, seeds, outputs), 30) for one, _ in both]
    print(
        f"{name}: step {of_step[0]:.3f} -> {of_step[1]:.3f} ms, ratio "
        f"{of_step[1] / of_step[0]:.2f}; derivative {of_seed[0]:.3f} -> {of_seed[1]:.3f} ms, "
        f"ratio {of_seed[1] / of_seed[0]:.2f}",
        flush=True,
    )
    for one, _ in both:
        one.close()


def curves(degrees, tolerance):
    """Print the largest differences of curves of the numerical example, over their ranges."""
    runs = []
    equal = [
        ("time.stop", f"{degrees} deg"),
        ("wires.0.tolerance", f"{tolerance} m"),
        ("wires.1.tolerance", tolerance / TOLERANCE * 1e-5),  # nominal velocities, as by default
    ]
    with TemporaryDirectory() as folder:
        for whole in ([], [("symmetric", False)]):
            tree = read_tree(EXAMPLE, [*equal, *whole])
            path = Path(folder) / "o.h5"
            run_tree(EXAMPLE, tree, path).close()
            runs.append(datasets(path))
            path.unlink()
    half, whole = runs
    differences = {
        name: np.abs(half[name] - values).max() / np.ptp(values)
        for name, values in whole.items()
        if ("ehd/" in name or "bodies/" in name) and np.ptp(values) > 0.0
        if name not in NO_CURVES
    }
    for name, difference in sorted(differences.items(), key=lambda pair: -pair[1])[:12]:
        print(f"{name}: {difference:.1e} of its range")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("cells", nargs="?", type=int, default=40)
    parser.add_argument("--curves", type=int)
    parser.add_argument("--tolerance", type=float, default=TOLERANCE)
    options = parser.parse_args()
    shape = [options.cells, options.cells]
    path = find_case("numerical_example")
    tree = read_tree(path, [("participants.bodies.build.grid", shape)])
    own = check_case(tree, path).participants["bodies"].build, path.parent
    course = [dict(zip(GAP, motored_film(tuple(shape), k * DEGREE))) for k in range(STEPS + 1)]
    pressed = [
        dict(zip(FORCES, (0.1 * (2.5e-5 / one[GAP[0]]) ** 2, -2e-3 * one[GAP[1]])))
        for one in course
    ]
    for kind, build in (("machine code", build_native_fmu), ("Python", build_fmu)):
        film = build("piston_cosim.fmu_ehd", {"grid": shape}, Path(), print)
        compare(f"film, {kind}", film, course, FORCES)
        compare(f"bodies, {kind}", build("piston_cosim.fmu_mfbd", *own, print), pressed, GAP)
    if options.curves:
        curves(options.curves, options.tolerance)


if __name__ == "__main__":
    main()
