"""Cost of a step and of a directional derivative against the two dense products no step can avoid, measured side by side.

    python tests/bench/mfbd_step.py            the shipped case's bodies, and 0 to 200 modes
"""

import time
from pathlib import Path

import numpy as np

from fmu_mfbd.assembly import assemble
from fmu_mfbd.build import prepare
from fmu_mfbd.model import Inputs
from fmu_mfbd.variables import parameters

CASE = Path(__file__).parents[2] / "models" / "numerical_example"
MATERIAL = {"density": "2700 kg/m^3", "young": "78 GPa", "poisson": 0.33}


def fastest(call, repeats=40, number=40):
    """Smallest mean time of `number` calls [s]: what the machine does when nothing else wants it."""
    call()
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        for _ in range(number):
            call()
        times.append((time.perf_counter() - begin) / number)
    return min(times)


def model(modes, symmetric=True):
    """The shipped bodies with the given number of modes each, as a running model."""
    table = {"grid": [40, 40]} | {name: {"mesh": f"{name}.msh.gz", "modes": modes, **MATERIAL} for name in ("piston", "block")}
    options, files = prepare(table, CASE, print)
    piston, block = (dict(np.load(path)) for path in files)
    if not symmetric:
        piston["kind"], block["kind"] = -np.ones_like(piston["kind"]), -np.ones_like(block["kind"])
    return assemble(piston, block, options, {v.name: v.start for v in parameters()})


def row(modes, symmetric=True):
    """Times of the two products, a step and a derivative [us]."""
    body = model(modes, symmetric)
    rng = np.random.default_rng(0)
    push, drag = rng.random((40, 40)), -0.1 * rng.random((40, 40))
    inputs = Inputs(314.0, 1e6, push, drag)
    state, _ = body.start(0.5, 0.0, 0.0, Inputs(314.0, 1e6, 0 * push, 0 * drag))
    dense, q = rng.standard_normal((2, 1600, max(modes, 60))), rng.standard_normal(max(modes, 60))
    two = fastest(lambda: (dense[0] @ q, dense[1] @ q))
    step = fastest(lambda: body.advance(state, inputs, 5e-5))
    derivative = fastest(lambda: body.directional_derivative(push, drag))
    return two * 1e6, step * 1e6, derivative * 1e6


def main():
    """The table."""
    print(f"{'modes':>12} {'2 products':>11} {'step':>8} {'ratio':>6} {'derivative':>11} {'ratio':>6}")
    for modes, symmetric in ((60, True), (60, False), (0, True), (20, True), (120, True), (200, True)):
        two, step, derivative = row(modes, symmetric)
        label = f"{modes}+{modes}" + ("" if symmetric else " *")
        print(f"{label:>12} {two:9.1f}us {step:6.1f}us {step / two:6.2f} {derivative:9.1f}us {derivative / two:6.2f}", flush=True)
    print("* as if the bodies had no planes of symmetry. Products: two dense 1600 x modes (60 at least) matrices times a vector.")


if __name__ == "__main__":
    main()
