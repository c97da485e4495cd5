"""What a process of its own costs an FMU a step: set both fields, step, read both forces, from a
restored state.

The 40 x 40 lubrication FMU in this process and isolated, steps interleaved, of each step the best
of several passes; same bits. Run: python tests/bench/isolation.py
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is loaded

from pathlib import Path
from time import perf_counter

import numpy as np

from piston_cosim.master.fmi.builder import build_fmu
from piston_cosim.master.participants.fmi2 import FmuParticipant
from piston_cosim.master.participants.isolated import IsolatedParticipant
from piston_cosim.tests.verification.cases.motored import DEGREE, motored_film

SHAPE, STEPS, PASSES = (40, 40), 120, 12


def iteration(participant, film, velocity, k):
    """Time of one iteration [s], its pressure force."""
    begin = perf_counter()
    saved = participant.save()
    participant.restore(saved)
    participant.set("film_thickness", film)
    participant.set("sliding_velocity", velocity)
    participant.step(k * DEGREE, DEGREE)
    force = participant.get("nodal_pressure_force")
    participant.get("nodal_friction_force")
    participant.free(saved)
    return perf_counter() - begin, force


def main():
    path, inputs = (
        build_fmu("fmu_ehd", {"grid": list(SHAPE)}, Path(".")),
        [motored_film(SHAPE, k * DEGREE) for k in range(STEPS + 1)],
    )
    pair = [FmuParticipant("here", path), IsolatedParticipant(FmuParticipant("there", path), 60.0)]
    for participant in pair:
        participant.start(
            {
                "roughness_rms": 5e-7,
                "film_thickness": inputs[0][0],
                "sliding_velocity": inputs[0][1],
            },
            0.0,
            1.0,
        )
    starts, times = [participant.save() for participant in pair], np.empty((PASSES, STEPS, 2))
    for p in range(PASSES):
        for participant, start in zip(pair, starts):
            participant.restore(start)
        for k, (film, velocity) in enumerate(inputs[1:]):
            (times[p, k, 0], one), (times[p, k, 1], other) = (
                iteration(participant, film, velocity, k) for participant in pair
            )
            assert np.array_equal(one, other)
    here, there = times.min(axis=0).mean(axis=0)
    print(
        f"step in this process {1e6 * here:.0f} us, isolated {1e6 * there:.0f} us: "
        f"{there / here:.2f} times, same bits"
    )
    for participant in pair:
        participant.close()


if __name__ == "__main__":
    main()
