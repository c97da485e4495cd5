"""One BLAS thread, a marker for each tier, and the order of the folders.

As on the command line, one BLAS thread makes rounding independent of the machine's cores, and small
algebra faster. Every test gets the marker of its tier, according to its folder. Folders of long
tests come first. One process runs a whole file, so a long file at the end leaves the other
processes idle.
"""

import gc
import os
import sys
from pathlib import Path

import pytest

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(threads, "1")
gc.set_threshold(100_000, 20, 20)  # as on the command line: a twentieth of the time of the tests
# hundreds of processes import the project; each without bytecode of it parses for a second or two
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

TIERS = {
    "pinned": "pinned",
    "fmu": "fmu",
    "verification": "verification",
    "docs": "docs",
    "properties": "verification",
    "mfbd": "fast",
    "master": "fast",
    "ehd": "fast",
}
"""Folder -> tier, in the order in which they run."""
FIRST = ("pinned/test_pinned.py", "fmu/test_native_coupled.py")
"""Files that run before all: side by side they compile what most others then find in the cache."""


def pytest_collection_modifyitems(items):
    here = Path(__file__).parent
    order = list(TIERS)
    places = {item: item.path.relative_to(here) for item in items}
    for item, place in places.items():
        item.add_marker(getattr(pytest.mark, TIERS[place.parts[0]]))
    items.sort(
        key=lambda item: (
            places[item].as_posix() not in FIRST,
            order.index(places[item].parts[0]),
        )
    )
