"""Parallel efficiency of a sweep: the same points by one and by two processes, in one go on one machine.

    python tests/bench/sweep_efficiency.py [points]

Efficiency = time with one process / (2 x time with two). Built FMUs and compiled code are in the cache for both.
"""

import os
import sys
import tempfile
import time
from pathlib import Path

from master.case import find_case, read_tree
from master.sweep import build_all, local_executor, parse_axis, points, sweep


def wall_time(found, folder, workers):
    """Seconds for all points with `workers` processes, their start included."""
    begin = time.perf_counter()
    with tempfile.TemporaryDirectory() as output, local_executor(workers) as executor:
        rows = sweep(found, folder, Path(output), executor)
    assert {row["status"] for row in rows} == {"done"}
    return time.perf_counter() - begin


def main():
    """The table."""
    path = find_case("fired_motorcycle")
    tree = read_tree(path)
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 8
    changes = [("time.stop", "180 deg"), ("record.fields", []), *tree["variants"]["rigid"].items()]
    found = points(path, changes, [parse_axis(f"radial_clearance=15um..60um:{count}", tree)])
    build_all(found, path.parent, print)
    wall_time(found[:1], path.parent, 1)
    load = os.getloadavg()[0]
    one, two = (wall_time(found, path.parent, workers) for workers in (1, 2))
    print(f"{count} points, load of the machine before: {load:.1f}")
    print(f"1 process {one:.1f} s   2 processes {two:.1f} s   efficiency {one / two / 2:.2f}")


if __name__ == "__main__":
    main()
