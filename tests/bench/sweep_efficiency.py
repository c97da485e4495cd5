"""Parallel efficiency of a sweep: the same points by one and by two processes, in one go on one
machine.

    python tests/bench/sweep_efficiency.py [points]

Efficiency = time with one process / (2 x time with two); it means something on an otherwise idle
machine only. On a busy one the other two figures still hold: the share of the two processes' time
spent in points (the rest is start and waiting for the last one), and how processor time a point
grows when two run side by side.
"""

import os
import sys
import tempfile
import time
from pathlib import Path

from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.runs.sweep import (
    all_points,
    build_all,
    local_executor,
    parse_axis,
    run_point,
)


def timed_point(tree, case_folder, output):
    """Wall and processor time [s] of a point, in the process that runs it."""
    wall, processor = time.perf_counter(), time.process_time()
    assert run_point(tree, case_folder, output)["status"] == "done"
    return time.perf_counter() - wall, time.process_time() - processor


def timed_sweep(points, folder, workers):
    """Wall time of all points, their start included; sums of the points' wall and processor times
    [s].
    """
    begin = time.perf_counter()
    with tempfile.TemporaryDirectory() as output, local_executor(workers) as executor:
        futures = [
            executor.submit(timed_point, p.tree, str(folder), str(Path(output) / f"{p.name}.h5"))
            for p in points
        ]
        inside, processor = (
            sum(column) for column in zip(*(future.result() for future in futures))
        )
    return time.perf_counter() - begin, inside, processor


def main():
    """The table."""
    path = find_case("fired_motorcycle")
    tree = read_tree(path)
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 12
    changes = [("time.stop", "360 deg"), ("record.fields", []), *tree["variants"]["rigid"].items()]
    points = all_points(path, changes, [parse_axis(f"radial_clearance=15um..60um:{count}", tree)])
    build_all(points, path.parent, print)
    timed_sweep(points[:1], path.parent, 1)
    load = os.getloadavg()[0]
    (one, _, processor_one), (two, inside, processor_two) = (
        timed_sweep(points, path.parent, workers) for workers in (1, 2)
    )
    print(f"{count} points; load of the machine before: {load:.1f}")
    print(f"1 process {one:.1f} s, 2 processes {two:.1f} s: efficiency {one / two / 2:.2f}")
    print(
        f"two processes spent {inside / two / 2:.2f} of their time in points; "
        f"processor time a point grew by {processor_two / processor_one:.2f}"
    )


if __name__ == "__main__":
    main()
