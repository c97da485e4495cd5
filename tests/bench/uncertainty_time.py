"""Processor time of a run with `--uncertainty` over that of the plain run.

    python tests/bench/uncertainty_time.py [CASE...]    data_sheet and numerical_example: minutes

Each run is a command of its own with one thread. A first pass fills the caches of kernels, FMUs and
reduced bodies. The passes take turns, and the shortest time of each counts.
"""

import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

PASSES = 2
THREADS = {f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "NUMBA")}


def seconds(case: str, variant: str, *options: str) -> float:
    """Return the processor time of a command with its children [s]."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "piston_cosim", "run", case, "--only", variant]
        command += ["--no-plots", "--output", str(Path(folder) / "runs"), *options]
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, env=os.environ | THREADS)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def main():
    """Print the table."""
    variants = {"data_sheet": "rigid", "numerical_example": "flexible"}
    print(f"{'case':24s} {'plain [s]':>10s} {'with [s]':>10s} {'ratio':>7s}")
    for case in sys.argv[1:] or variants:
        of_case = variants.get(case, "base")
        times = [
            (seconds(case, of_case), seconds(case, of_case, "--uncertainty"))
            for _ in range(1 + PASSES)
        ]
        plain, both = (min(column) for column in zip(*times[1:]))
        print(f"{case:24s} {plain:10.1f} {both:10.1f} {both / plain:7.2f}", flush=True)


if __name__ == "__main__":
    main()
