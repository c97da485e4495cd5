"""Cost of half a film against the whole one, in Python and as machine code.

    python tests/bench/half_film.py [CELLS]

The same symmetric film runs on both grids, a step of the one after a step of the other. The best of
several passes counts for every step, so that other processes count little. A step is followed by a
directional derivative. One thread; CELLS (default: 40) around and along.
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is loaded

import sys
from functools import partial
from pathlib import Path

import numpy as np
from native import FORCES, GAP, started, step
from timing import shortest

from piston_cosim.master.fmi.builder import build_fmu
from piston_cosim.master.fmi.builder_native import build_native_fmu
from piston_cosim.tests.verification.cases.motored import DEGREE, motored_film

STEPS, PASSES = 60, 4
ROUND_OFF = 1e-9  # of the largest force


def main():
    cells = int(sys.argv[1]) if len(sys.argv) > 1 else 40
    shape = (cells, cells)
    course = [dict(zip(GAP, motored_film(shape, k * DEGREE))) for k in range(STEPS + 1)]
    seeds = {name: np.ones(shape) for name in GAP}
    for kind, build in (("machine code", build_native_fmu), ("Python", build_fmu)):
        fmu = build("piston_cosim.fmu_ehd", {"grid": list(shape)}, Path(), print)
        films = [
            started(fmu, {"film_symmetry": 1 + k, **course[0]}, FORCES[0])[:2] for k in range(2)
        ]
        times = np.empty((2, PASSES, STEPS))
        for n in range(PASSES):
            for film, begin in films:
                film.restore(begin)
            for k, inputs in enumerate(course[1:]):
                found = [step(film, k * DEGREE, inputs, FORCES) for film, _ in films]
                times[:, n, k] = [seconds for seconds, _ in found]
                whole, half = (force for _, force in found)
                assert np.abs(half - whole).max() <= ROUND_OFF * np.abs(whole).max()
        of_step = times.min(axis=1).mean(axis=1)
        of_seed = [shortest(partial(film.derivative, seeds, FORCES), 30) for film, _ in films]
        print(
            f"{kind}, {cells} x {cells} cells: step {1e3 * of_step[0]:.2f} -> "
            f"{1e3 * of_step[1]:.2f} ms, ratio {of_step[1] / of_step[0]:.2f}; derivative "
            f"{1e3 * of_seed[0]:.2f} -> {1e3 * of_seed[1]:.2f} ms, ratio "
            f"{of_seed[1] / of_seed[0]:.2f}"
        )
        for film, _ in films:
            film.close()


if __name__ == "__main__":
    main()
