"""Processor time of a run with `--uncertainty` over that of the plain run.

    python tests/bench/uncertainty_time.py [CASE...] [--passes N]    default: data_sheet and
                                                         numerical_example, two passes: minutes

Each run is a command of its own with one thread. A first one fills the caches of kernels, FMUs and
reduced bodies. The passes take turns, and the shortest time of each counts.
"""

import argparse
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

import piston_cosim as pc

CASES = ("data_sheet", "numerical_example")
THREADS = {f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "NUMBA")}


def seconds(case: str, *options: str) -> float:
    """Return the processor time of a command that runs a case without its variants [s]."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "piston_cosim", "run", case]
        command += ["--only", pc.open_case(case).label]
        command += ["--no-plots", "--output", str(Path(folder) / "runs"), *options]
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, env=os.environ | THREADS)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("cases", nargs="*")
    parser.add_argument("--passes", type=int, default=2)
    options = parser.parse_args()
    print(f"{'case':24s} {'plain [s]':>10s} {'with [s]':>10s} {'ratio':>7s}")
    for case in options.cases or CASES:
        seconds(case, "--uncertainty")
        times = [(seconds(case), seconds(case, "--uncertainty")) for _ in range(options.passes)]
        plain, both = (min(column) for column in zip(*times))
        print(f"{case:24s} {plain:10.1f} {both:10.1f} {both / plain:7.2f}", flush=True)


if __name__ == "__main__":
    main()
