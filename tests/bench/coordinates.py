"""Native FMU of the numerical example, iterated in coordinates of the bodies and on wires.

    python tests/bench/coordinates.py [--modes PISTON BLOCK] [--degrees N] [--other FILE ...]

Steps of 1 deg from rest, one thread. All FMUs step in turns in one process, and the shortest of
`PASSES` processor times of each step counts, so that other processes count little. The differences
of curves are over the range on wires. FILE is such an FMU of another version.
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is loaded

import argparse
from pathlib import Path
from time import thread_time

import numpy as np
from speed import CURVES, STEP

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.export import export_fmu
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.participants.fmi2 import FmuParticipant

PASSES = 5
BUILD = "participants.bodies.build"


def exported(coordinates, modes):
    """Return the native FMU, iterated in coordinates or on wires."""
    path = find_case("numerical_example")
    changes = [("coupling.advanced.coordinates", coordinates)] if coordinates is False else []
    for body, count in zip(("piston", "block"), modes):
        changes += [(f"{BUILD}.{body}.modes", count), (f"{BUILD}.{body}.symmetric_film", False)]
    case = check_case(read_tree(path, changes), path)
    return export_fmu(case, path.parent, lambda text: None, "2.0", ["linux64"])


def main(modes, degrees, others):
    fmus = {"on wires": exported(False, modes), "in coordinates": exported(True, modes)}
    fmus |= {str(one): one for one in others}
    times = np.full((len(fmus), degrees), np.inf)
    curves = np.empty((len(fmus), degrees, len(CURVES)))
    for _ in range(PASSES):
        running = [FmuParticipant("one", path) for path in fmus.values()]
        for one in running:
            one.start({}, 0.0, 1.0)
        for k in range(degrees):
            for i, one in enumerate(running):
                begin = thread_time()
                one.step(k * STEP, STEP)
                times[i, k] = min(times[i, k], thread_time() - begin)
                curves[i, k] = [one.get(name) for name in CURVES]
        for one in running:
            one.close()
    ranges = np.ptp(curves[0], axis=0)
    for name, own, curve in zip(fmus, times, curves):
        print(f"{name}: {1e3 * own.mean():.2f} ms a step, {own.mean() / times[0].mean():.3f}")
        for of, far in zip(CURVES, np.abs(curve - curves[0]).max(axis=0) / ranges):
            print(f"    {of:24} {far:.1e}")
    print("load average", *(f"{one:.2f}" for one in os.getloadavg()))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--modes", type=int, nargs=2, default=())
    parser.add_argument("--degrees", type=int, default=180)
    parser.add_argument("--other", type=Path, nargs="*", default=())
    chosen = parser.parse_args()
    main(chosen.modes, chosen.degrees, chosen.other)
