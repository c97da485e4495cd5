"""One BLAS thread, as the command line has it: rounding does not depend on the machine's cores, and
small algebra is faster. Every test has the marker of its tier, by the folder it is in. Folders of
long tests come first: a file is one process's, and a long one at the end keeps the others idle.
"""

import os
from pathlib import Path

import pytest

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(threads, "1")

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


def pytest_collection_modifyitems(items):
    here = Path(__file__).parent
    order = list(TIERS)
    folders = {item: item.path.relative_to(here).parts[0] for item in items}
    for item, folder in folders.items():
        item.add_marker(getattr(pytest.mark, TIERS[folder]))
    items.sort(key=lambda item: order.index(folders[item]))
