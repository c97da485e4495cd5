"""Growth of the cost of a factorisation, a step and derivatives with the grid.

One thread, one run. Each solver takes the same first degrees of the motored skirt, where the film
ruptures.

Run: python tests/bench/ehd_grids.py [cells ...]
"""

import os
import sys

for name in ("OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")  # before numpy is loaded

from time import perf_counter

import numpy as np
from timing import shortest

from piston_cosim.fmu_ehd.model import LubricationModel
from piston_cosim.fmu_ehd.parameters import Parameters
from piston_cosim.fmu_ehd.solvers.sparse import BlockTridiagonal, Pardiso, SuperLU
from piston_cosim.tests.verification.cases.motored import DEGREE, motored_film

STEPS = 8
MANY = 130  # directions of a bearing with shells, `journal.by_shapes`


class Recorder:
    """A solver that keeps every matrix it factorises."""

    def __init__(self, solver):
        self.solver = solver
        self.matrices = []

    def factorise(self, stencil, stations=None):
        self.matrices.append(stencil)
        self.solver.factorise(stencil, stations)

    def solve(self, right):
        return self.solver.solve(right)


def measure(cells, solver):
    """Return times [s], factorisations per step and the highest pressure [Pa].

    The times are those of a step, a factorisation, a derivative, derivatives in `MANY` directions
    at once, and their right-hand sides alone. Means are over the steps after the first.
    """
    shape = cells, cells
    model = LubricationModel(Parameters(shape, roughness_rms=5e-7))
    model.solver = solver
    inputs = [motored_film(shape, k * DEGREE) for k in range(STEPS + 1)]
    start, _ = model.start(*inputs[0])
    start, _ = model.advance(start, *inputs[1], DEGREE)
    passes = []
    for _ in range(
        1 + 200 // cells
    ):  # small grids more often, so that other load on the machine matters less
        state, counts, times = start, [], []
        for film, velocity in inputs[2:]:
            begin = perf_counter()
            state, outputs = model.advance(state, film, velocity, DEGREE)
            times.append(perf_counter() - begin)
            counts.append(outputs["solver_iterations"])
        passes.append(times)
    recorder = model.solver = Recorder(solver)
    for film, velocity in inputs[2:]:
        start, _ = model.advance(start, film, velocity, DEGREE)
    ones = [
        shortest(lambda m=matrix: solver.factorise(m), 1 + 200 // cells)
        for matrix in recorder.matrices
    ]  # all stations
    changes = np.random.default_rng(0).standard_normal((2, MANY, *shape))
    changes[0] *= 1e-6
    return (
        np.min(passes, axis=0).mean(),
        np.mean(counts),
        np.mean(ones),
        shortest(lambda: model.tangent(*changes[:, 0]), 20),
        shortest(lambda: model.tangent(*changes), 20),
        shortest(lambda: solver.solve(changes[1].copy()), 20),
        outputs["maximum_pressure"],
    )


def main():
    measure(12, BlockTridiagonal((12, 12)))  # compile
    sizes = [int(argument) for argument in sys.argv[1:]] or [20, 40, 80, 160]
    print(
        f"{'grid':>9s}  {'solver':16s}{'factorisation ms':>17s}{'step ms':>10s}"
        f"{'a step':>8s}{'step/(n x fact.)':>18s}{'us a cell':>11s}{'derivative us':>15s}"
        f"{f'{MANY} of them':>13s}{'their solution':>16s}{'peak MPa':>10s}"
    )
    for cells in sizes:
        for kind in (BlockTridiagonal, Pardiso, SuperLU):
            if kind is SuperLU and cells > 160:
                continue
            try:
                figures = measure(cells, kind((cells, cells)))
            except ImportError:
                print(f"{cells:4d}x{cells:<4d}  {kind.__name__:16s}   not installed")
                continue
            step, count, one, derivative, many, solution, peak = figures
            print(
                f"{cells:4d}x{cells:<4d}  {kind.__name__:16s}{1e3 * one:17.2f}"
                f"{1e3 * step:10.2f}{count:8.2f}{step / count / one:18.2f}"
                f"{1e6 * step / cells**2:11.2f}{1e6 * derivative:15.1f}"
                f"{1e6 * many:13.1f}{1e6 * solution:16.1f}{1e-6 * peak:10.4f}"
            )


if __name__ == "__main__":
    main()
