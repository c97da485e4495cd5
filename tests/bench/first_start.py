"""First and second start of the run line of the README in this checkout, each in an empty home.

For each run: wall and processor time with those of all child processes, and compilations of kernels
in all processes, counted by their files. The times of the phases are those of the progress lines.

1. The first start, with an empty cache, and the same with `--jobs 1`.
2. The second start, with the variants side by side, one after the other, and each alone.

The order alternates over the rounds, so that the load of the machine is the same for all.

Run: python tests/bench/first_start.py [ROUNDS]      0: the first starts only. Default: 3
"""

import os
import re
import resource
import subprocess
import sys
import tempfile
import time
from itertools import groupby
from pathlib import Path
from statistics import median
from typing import NamedTuple

CASE = "numerical_example"
PHASES = {
    "preparing|reducing": "start and reductions",
    "compiling": "compilation",
    "starting": "first step",
    "evaluating|drawing": "answers and pictures",
    "%": "steps",
}
"""Words of a progress line -> phase, in the order of the search."""


class Cost(NamedTuple):
    """Wall and processor time [s], compilations, and the wall time of each phase [s]."""

    wall: float
    processor: float
    compilations: int
    phases: list[tuple[str, float]]


def run(home: Path, *words: str) -> Cost:
    """Run the case in a home; its cache is that of earlier runs there."""
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("PISTON", "XDG"))}
    environment |= {"HOME": str(home), "NUMBA_CACHE_DIR": str(home / "numba")}
    before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    kernels = count(home)
    command = [sys.executable, "-m", "piston_cosim", "run", CASE, *words]
    with subprocess.Popen(
        command,
        cwd=home,
        env=environment,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stderr is not None
        seen = [(time.perf_counter() - begin, phase(line)) for line in process.stderr]
    if process.returncode:
        raise SystemExit(f"exit code {process.returncode}")
    wall = time.perf_counter() - begin
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    processor = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return Cost(wall, processor, count(home) - kernels, lengths(seen, wall))


def phase(line: str) -> str:
    """Return the phase of a progress line; "" of another line."""
    return next((name for words, name in PHASES.items() if re.search(words, line)), "")


def lengths(seen: list[tuple[float, str]], wall: float) -> list[tuple[str, float]]:
    """Return phases in their order, each from the end of the one before to its last line."""
    ends = [
        (name, max(time for time, _ in lines))
        for name, lines in groupby((one for one in seen if one[1]), key=lambda one: one[1])
    ]
    begins = [0.0, *(end for _, end in ends[:-1])]
    found = [(name, end - begin) for (name, end), begin in zip(ends, begins)]
    return [*found, ("answers and pictures", wall - ends[-1][1])] if ends else []


def count(home: Path) -> int:
    """Number of compiled kernels in the cache of a home."""
    return sum(1 for _ in (home / "numba").rglob("*.nbc"))


def show(name: str, cost: Cost) -> None:
    print(
        f"{name:32s} wall {cost.wall:6.1f} s   processor {cost.processor:6.1f} s   "
        f"{cost.compilations} compilations   load {os.getloadavg()[0]:.1f}",
        flush=True,
    )
    for part, seconds in cost.phases:
        print(f"    {part:28s} {seconds:6.1f} s")


def first_starts() -> Path:
    """Show the first starts; return the home of one."""
    homes = {words: Path(tempfile.mkdtemp()) for words in ((), ("--jobs", "1"))}
    costs = {words: run(home, *words) for words, home in homes.items()}
    for words, cost in costs.items():
        show(" ".join(["first start", *words]), cost)
    both, alone = costs.values()
    print(f"first start / --jobs 1: wall {both.wall / alone.wall:.2f}")
    return homes[()]


def second_starts(home: Path, rounds: int) -> None:
    """Show the median times of second starts, and their ratios."""
    kinds = {
        "side by side": (),
        "one after the other": ("--jobs", "1"),
        "flexible alone": ("--only", "flexible", "--no-plots"),
        "rigid alone": ("--only", "rigid", "--no-plots"),
    }
    costs = {name: [] for name in kinds}
    for k in range(rounds):
        for name in list(kinds)[:: 1 if k % 2 else -1]:
            costs[name].append(run(home, *kinds[name]))
    wall = {name: median(cost.wall for cost in found) for name, found in costs.items()}
    for name, found in costs.items():
        processor = median(cost.processor for cost in found)
        compilations = sum(cost.compilations for cost in found)
        show(f"second start, {name}", Cost(wall[name], processor, compilations, []))
    together = wall["side by side"]
    print(f"side by side / one after the other: wall {together / wall['one after the other']:.2f}")
    alone = wall["flexible alone"] + wall["rigid alone"]
    print(f"side by side / sum of both alone:   wall {together / alone:.2f}")


def main() -> None:
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 3
    home = first_starts()
    if rounds:
        second_starts(home, rounds)


if __name__ == "__main__":
    main()
