"""Cost of a step and of a directional derivative against the two dense products no step can avoid,
measured side by side.

python tests/bench/mfbd_step.py            the shipped case's bodies, and 0 to 200 modes
"""

import itertools
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from piston_cosim.fmu_mfbd.build import prepare
from piston_cosim.fmu_mfbd.dynamics.assembly import assemble
from piston_cosim.fmu_mfbd.dynamics.build_options import BuildOptions
from piston_cosim.fmu_mfbd.dynamics.model import Inputs
from piston_cosim.fmu_mfbd.dynamics.parameters import Parameters
from piston_cosim.fmu_mfbd.reduction.reduced_body import ReducedBlock, ReducedPiston, load

CASE = Path(__file__).parents[2] / "models" / "numerical_example"
MATERIAL = {"density": "2700 kg/m^3", "young": "78 GPa", "poisson": 0.33}


def fastest(calls, repeats=500, number=4):
    """Smallest mean time of `number` calls of each [s], taken in turns, each turn shorter than a
    time slice: what the machine does when nothing else wants it.
    """
    for call in calls:
        call()
    times = np.empty((repeats, len(calls)))
    for line in times:
        for k, call in enumerate(calls):
            begin = time.perf_counter()
            for _ in range(number):
                call()
            line[k] = (time.perf_counter() - begin) / number
    return times.min(axis=0)


def model(modes, symmetric=True):
    """The shipped bodies with the given number of modes each, as a running model."""
    table = {"grid": [40, 40]} | {
        name: {"mesh": f"{name}.msh.xz", "modes": modes, **MATERIAL} for name in ("piston", "block")
    }
    options, files = prepare(table, CASE, lambda text: None)
    piston, block = load(ReducedPiston, files[0]), load(ReducedBlock, files[1])
    if not symmetric:
        piston = replace(piston, kind=-np.ones_like(piston.kind))
        block = replace(block, kind=-np.ones_like(block.kind))
    return assemble(piston, block, BuildOptions.from_json(options), Parameters())


def row(modes, symmetric=True):
    """Times of the two products, a step, a derivative, and the first derivative after a step, which
    linearises [us].
    """
    body = model(modes, symmetric)
    rng = np.random.default_rng(0)
    push, drag = rng.random((40, 40)), -0.1 * rng.random((40, 40))
    inputs = Inputs(314.0, 1e6, push, drag)
    state, _ = body.start(0.5, 0.0, 0.0, Inputs(314.0, 1e6, 0 * push, 0 * drag))
    dense, q = rng.standard_normal((2, 1600, max(modes, 60))), rng.standard_normal(max(modes, 60))

    def first():
        body._linear = None
        return body.directional_derivative(push, drag)

    return 1e6 * fastest(
        [
            lambda: (dense[0] @ q, dense[1] @ q),
            lambda: body.advance(state, inputs, 5e-5),
            lambda: body.directional_derivative(push, drag),
            first,
        ]
    )


def main():
    """The table."""
    print(
        f"{'modes':>10} {'2 products':>11} {'step':>10} {'ratio':>6} {'derivative':>11} "
        f"{'ratio':>6} {'first':>10} {'ratio':>6}"
    )
    for modes, symmetric in itertools.product((0, 20, 40, 60, 120, 200), (True, False)):
        if modes or symmetric:
            two, *others = row(modes, symmetric)
            cells = "".join(
                f" {t:{width}.1f}us {t / two:6.2f}" for t, width in zip(others, (8, 9, 8))
            )
            print(
                f"{modes:>3} + {modes:<3}{' ' if symmetric else '*'} {two:9.1f}us{cells}",
                flush=True,
            )
    print(
        "* as if the bodies had no planes of symmetry. Products: two dense 1600 x modes (60 at "
        "least) matrices times a vector, timed in turns with\nthe rest. first: the first "
        "derivative after a step, which linearises; a step asks for several."
    )


if __name__ == "__main__":
    main()
