"""Cost of a lubrication step and of its derivative, in units of one block factorisation. Run:
python tests/bench/ehd_step.py

One thread, one run, ratios: the moving skirt of `motored` at 40 x 40 with contact, the best
 of several passes for each step, so that other load on the machine matters less.
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is loaded

from time import perf_counter

import numpy as np
from timing import shortest

from piston_cosim.fmu_ehd.model import LubricationModel
from piston_cosim.fmu_ehd.parameters import Parameters
from piston_cosim.fmu_ehd.solvers.blocks import BlockTridiagonal
from piston_cosim.fmu_ehd.solvers.sparse import SuperLU
from piston_cosim.tests.verification.cases.motored import DEGREE, motored_film

SHAPE = (40, 40)
STEPS = 720


class Recorder(BlockTridiagonal):
    """Keeps every matrix it factorises."""

    def __init__(self, shape):
        super().__init__(shape)
        self.matrices = []

    def factorise(self, stencil, stations=None):
        self.matrices.append(stencil)
        super().factorise(stencil, stations)


def cycle(inputs, solver=None):
    """Time of each step [s], factorisations of each, and the model at the end."""
    model = LubricationModel(Parameters(SHAPE, roughness_rms=5e-7))
    if solver is not None:
        model.film_step.solver = solver
    state, _ = model.start(*inputs[0])
    times, iterations = np.empty(len(inputs) - 1), []
    for k, (film, velocity) in enumerate(inputs[1:]):
        begin = perf_counter()
        state, outputs = model.advance(state, film, velocity, DEGREE)
        times[k] = perf_counter() - begin
        iterations.append(outputs["solver_iterations"])
    return times, iterations, model


def main():
    inputs = [motored_film(SHAPE, k * DEGREE) for k in range(STEPS + 1)]
    cycle(inputs[:20])
    passes = [
        (cycle(inputs), cycle(inputs, SuperLU(SHAPE))) for _ in range(3)
    ]  # in turn, so that both see the same machine
    step, superlu = (np.min([times for times, _, _ in kind], axis=0) for kind in zip(*passes))
    _, iterations, model = passes[-1][0]
    recorder = Recorder(SHAPE)
    cycle(inputs, recorder)
    solver = BlockTridiagonal(SHAPE)
    factorisation = np.mean(
        [shortest(lambda m=matrix: solver.factorise(m), 3) for matrix in recorder.matrices[::10]]
    )
    rng = np.random.default_rng(0)
    one = rng.standard_normal((2, 1, *SHAPE)) * np.array([1e-6, 1.0])[:, None, None, None]
    first = shortest(lambda: (setattr(model, "_linear", None), model.tangent(*one)), 20)
    rows = [
        ("block factorisation (mean over the cycle)", factorisation, None),
        ("step (mean over the cycle)", step.mean(), 2.5),
        ("step, median", np.median(step), None),
        ("first directional derivative of a step", first, None),
        ("directional derivative", shortest(lambda: model.tangent(*one), 20), 0.4),
    ]
    print(
        f"{' x '.join(map(str, SHAPE))}, {STEPS} steps, "
        f"{np.mean(iterations):.2f} factorisations a step, most {max(iterations)}"
    )
    print(f"{'':44s}{'us':>8s}{'factorisations':>16s}{'target':>8s}")
    for name, time, target in rows:
        print(
            f"{name:44s}{1e6 * time:8.0f}{time / factorisation:16.2f}"
            f"{'' if target is None else target:>8}"
        )
    print(
        f"{'the same step on SuperLU':44s}{1e6 * superlu.mean():8.0f}   "
        f"{superlu.mean() / step.mean():.1f} times the block step (target 10)"
    )


if __name__ == "__main__":
    main()
