"""Cost of the equations of motion of chains of bodies.

It prints processor time of residual, tangent and solution in compiled code, in microseconds, each
the shortest of several alternate runs. Then it prints those of a step with its films, 16 x 12 cells
on the skirt, and of a derivative at its end.

    python tests/bench/chain_cost.py
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is loaded

from time import process_time

import numpy as np
from numba import njit

from piston_cosim.fmu_mfbd.dynamics.instant import end_of_step
from piston_cosim.fmu_mfbd.dynamics.response import response
from piston_cosim.fmu_mfbd.mechanism.carrier import FIXED
from piston_cosim.fmu_mfbd.mechanism.derivative import chain_tangent
from piston_cosim.fmu_mfbd.mechanism.equations import chain_forces
from piston_cosim.fmu_mfbd.mechanism.solution import solve_chain
from piston_cosim.tests.mfbd.chains import CRANK, engine, flexible, tied
from piston_cosim.tests.mfbd.pin_models import (
    crank_model,
    floating_model,
    rough_way,
    tied_model,
    yielding_model,
)
from piston_cosim.tests.mfbd.test_mechanism import loads, motion, reach

REPEATS, CALLS = 15, 200


def loop_of(kernel):
    """Return a compiled loop that calls a kernel."""
    inner = kernel.dispatcher

    @njit(error_model="numpy")
    def loop(calls, arguments):
        for _ in range(calls):
            inner(*arguments)

    return loop


KERNELS = (chain_forces, chain_tangent, solve_chain, end_of_step, response)
LOOPS = {kernel: loop_of(kernel) for kernel in KERNELS}


def microseconds(*pairs):
    """Return the shortest times of calls (kernel, arguments), run in turn."""
    best = [np.inf] * len(pairs)
    for repeat in range(REPEATS + 1):  # the first one compiles
        for k, (kernel, arguments) in enumerate(pairs):
            begin = process_time()
            LOOPS[kernel](CALLS, arguments)
            if repeat:
                best[k] = min(best[k], (process_time() - begin) / CALLS)
    return [1e6 * one for one in best]


def chain_calls(built, given, now):
    """Return residual, tangent and solution of a chain with their arguments."""
    by = reach(len(now.position))
    forces = chain_forces(built.chain, given, now, CRANK, FIXED)
    arrow = chain_tangent(built.chain, given, now, forces, by)
    return (
        (chain_forces, (built.chain, given, now, CRANK, FIXED)),
        (chain_tangent, (built.chain, given, now, forces, by)),
        (solve_chain, (arrow, forces.residual)),
    )


def step_calls(model):
    """Return a step and a derivative at its end with their arguments."""
    calls, own = [], model._instant

    def noted(*arguments):
        calls.append(arguments)
        return own(*arguments)

    model._instant = noted
    rough_way(model, 6)
    step, given, _ = calls[-1]
    films, last = (given.skirt, given.pins), model._last
    change = model.system, last, given.skirt, given.rings, given.pins, FIXED, 0.0
    return (end_of_step, (model.system, step, *films)), (response, change)


def main():
    print("us: residual, tangent, solution")
    for modes in (0, 60, 200):
        report(f"tied pin, {modes} modes", tied(flexible(modes)))
    for name, pistons, mounted, modes in (
        ("six films, rigid", 1, False, 0),
        ("six films, 60 modes", 1, False, 60),
        ("six films on mounts, 8 modes", 1, True, 8),
        ("two cylinders, 8 modes", 2, True, 8),
    ):
        report(name, engine([flexible(modes)] * pistons, True, True, mounted))
    print("us: step, derivative")
    for name, model in (
        ("tied pin", tied_model()),
        ("floating pin", floating_model()),
        ("floating pin, 3 modes", yielding_model()),
        ("six films", crank_model()),
        ("six films, all flexible", crank_model(yielding=True, shapes=3)),
    ):
        print(f"{name}:", "".join(f"{one:7.1f}" for one in microseconds(*step_calls(model))))


def report(name, built):
    """Print the times of a chain."""
    now = motion(built)
    times = microseconds(*chain_calls(built, loads(built, now), now))
    print(f"{name}:", "".join(f"{one:7.2f}" for one in times))


if __name__ == "__main__":
    main()
