"""Cost of the equations of motion of a piston: by hand and as a chain of bodies, side by side.

It prints processor time of residual, tangent and solution in compiled code, in microseconds, each
the shortest of several alternate runs.

    python tests/bench/chain_cost.py
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is loaded

from time import process_time

import numpy as np
from numba import njit

from piston_cosim.fmu_mfbd.dynamics import elimination, floating_pin, pin_tangent
from piston_cosim.fmu_mfbd.dynamics.carrier import FIXED
from piston_cosim.fmu_mfbd.mechanism.equations import chain_forces, chain_tangent, solve_chain
from piston_cosim.master.fmi.compiled import compilable
from piston_cosim.tests.mfbd.chains import CRANK, engine, flexible, tied
from piston_cosim.tests.mfbd.test_mechanism import (
    by_hand_with_films,
    in_order,
    loads,
    motion,
    on_piston,
    reach,
)

REPEATS, CALLS = 15, 200


@compilable
def solve_dense(matrix, right):
    """Return the solution of a system by elimination."""
    return elimination.substitute(elimination.factorise(matrix), right)


def loop_of(kernel):
    """Return a compiled loop that calls a kernel."""
    inner = kernel.dispatcher

    @njit(error_model="numpy")
    def loop(calls, arguments):
        for _ in range(calls):
            inner(*arguments)

    return loop


KERNELS = (
    *(floating_pin.imbalance, pin_tangent.tangent, solve_dense),
    *(chain_forces, chain_tangent, solve_chain),
)
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


def floating_calls(piston, built, given, now):
    """Return the same of a floating pin with films of the crank by hand."""
    bodies, films = by_hand_with_films(piston, built, given)
    load = on_piston(built, given, now)
    order = in_order(now)
    theirs = type(now)(*(one[order] for one in now))
    by = reach(len(order))
    known = floating_pin.imbalance(bodies, load, theirs, CRANK, films)
    state = bodies, load, theirs, films, known, by.velocity, by.position
    return (
        (floating_pin.imbalance, (bodies, load, theirs, CRANK, films)),
        (pin_tangent.tangent, state),
        (solve_dense, (pin_tangent.tangent(*state), known.residual)),
    )


def main():
    print("us: residual, tangent, solution; their sum as a share of that by hand")
    for modes in (0, 60, 200):
        built = tied(flexible(modes))
        now = motion(built)
        times = microseconds(*chain_calls(built, loads(built, now), now))
        print(f"tied pin, {modes:3d} modes:", "".join(f"{one:7.2f}" for one in times))
    for modes in (0, 60):
        piston = flexible(modes)
        built = engine([piston], True, True)
        now = motion(built)
        given = loads(built, now)
        times = microseconds(
            *floating_calls(piston, built, given, now), *chain_calls(built, given, now)
        )
        hand, own = ("".join(f"{one:7.2f}" for one in part) for part in (times[:3], times[3:]))
        share = sum(times[3:]) / sum(times[:3])
        print(f"six films, {modes:3d} modes: by hand {hand}, chain {own}, share {share:.2f}")
    for pistons in (1, 2):
        built = engine([flexible(8)] * pistons, True, True, True)
        now = motion(built)
        times = microseconds(*chain_calls(built, loads(built, now), now))
        print(f"all of it, {pistons} cylinders:", "".join(f"{one:7.2f}" for one in times))


if __name__ == "__main__":
    main()
