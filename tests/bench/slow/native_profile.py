"""Where a macro step of the coupled native FMU spends its time, by the function that it is in: the
numerical example, half a turn from rest. Needs Linux and its `perf`.

    python tests/bench/slow/native_profile.py [MODES [CELLS CELLS]]

Samples of the FMU's library alone; what is inlined counts to the function that it is inlined in.
"""

import re
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from native import DEGREE_AT_6000, STEPS, coupled_fmu, started

SAMPLED = 5  # half turns
PARTS = {"fmu_ehd": "film", "fmu_mfbd": "bodies", "coupling": "master"}
SHOWN = 0.01  # least share of a function that is named
SYMBOL = re.compile(r"^\s*([\d.]+)%\s+\[\.\]\s+(\S+)", re.MULTILINE)


def half_turns(path):
    """What is looked at."""
    one, at_start, _ = started(Path(path), {}, "lateral_displacement")
    for _ in range(SAMPLED):
        one.restore(at_start)
        for k in range(STEPS):
            one.step(k * DEGREE_AT_6000, DEGREE_AT_6000)


def shares(path):
    """Shares of the library's functions, by (part, function), the largest first."""
    with tempfile.TemporaryDirectory() as folder:
        samples = Path(folder) / "perf.data"
        looked_at = [sys.executable, __file__, "--run", str(path)]
        subprocess.run(["perf", "record", "-q", "-o", str(samples), *looked_at], check=True)
        of_library = ["--percentage", "relative", "--dsos", f"{path.name.split('-')[0]}.so"]
        told = subprocess.run(
            ["perf", "report", "-i", str(samples), "--stdio", "--sort", "symbol", *of_library],
            check=True,
            capture_output=True,
            text=True,
        ).stdout
    found = Counter()
    for share, symbol in SYMBOL.findall(told):
        part = next((words for name, words in PARTS.items() if name in symbol), "front")
        # numba's names: a kernel's own stands before its version
        name = re.search(r"(\w+?)(?:\[abi:|B\d+v\d+|$)", symbol.split("::")[-1])
        found[part, re.sub(r".*\d", "", name[1]) if name else symbol] += float(share) / 100
    return found.most_common()


if __name__ == "__main__":
    if sys.argv[1:2] == ["--run"]:
        half_turns(sys.argv[2])
        sys.exit()
    modes, *grid = map(int, sys.argv[1:]) if sys.argv[1:] else [0]
    found = shares(coupled_fmu(modes, tuple(grid) or (40, 40))[0])
    total = Counter()
    for (part, _), share in found:
        total[part] += share
    print(", ".join(f"{part} {share:.0%}" for part, share in total.most_common()))
    for (part, name), share in found:
        if share >= SHOWN:
            print(f"{share:6.1%}  {part:7s} {name}")
