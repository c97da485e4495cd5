"""Cost of given wall temperatures: times of an evaluation of film and bodies, and of iterations.

    python tests/bench/wall_temperatures.py [--degrees N]

The case is the variant `hot` of fired_motorcycle, flooded, with native FMUs on one thread. It is
compared with the same walls and an oil temperature of the film itself, which needs no wire. Both
take turns, and the shortest of `PASSES` times counts.
"""

import argparse
import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is loaded

import tempfile
from pathlib import Path

import piston_cosim as pc

PASSES = 5
ALIKE = {"native": True, "record.every": 100000, "participants.ehd.parameters.oil_supply": "edges"}
COUNTS = {"ehd": "residual_evaluations", "bodies": "residual_evaluations", "acceleration": "steps"}
"""Part of a run -> number of its calls in a summary."""


def times(variant, folder, degrees):
    """Return the time of a call of each part of a run [ms], and the mean number of iterations."""
    changes = ALIKE | {"time.stop": f"{degrees} deg"}
    case = pc.open_case("fired_motorcycle").variant(variant).changed(changes)
    summary = case.run(folder / f"{variant}.h5").summary
    out = {one: 1e3 * summary[f"wall_time_{one}_s"] / summary[n] for one, n in COUNTS.items()}
    return out | {"iterations": summary["mean_iterations"]}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--degrees", type=int, default=60)
    degrees = parser.parse_args().degrees
    found = {"hot": [], "hot_shape": []}
    with tempfile.TemporaryDirectory() as folder:
        for variant in found:
            times(variant, Path(folder), 2)  # builds
        for _ in range(PASSES):
            for variant, rows in found.items():
                rows.append(times(variant, Path(folder), degrees))
    least = {
        name: {key: min(r[key] for r in rows) for key in rows[0]} for name, rows in found.items()
    }
    print(f"{'':14s}{'tables':>10s}{'without':>10s}{'ratio':>8s}")
    for key, value in least["hot"].items():
        other = least["hot_shape"][key]
        print(f"{key:14s}{value:10.3f}{other:10.3f}{value / other:8.3f}")


if __name__ == "__main__":
    main()
