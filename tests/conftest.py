"""One BLAS thread, as the command line has it: rounding does not depend on the machine's cores, and
small algebra is faster. Every test has the marker of its tier, by the folder it is in.
"""

import os
from pathlib import Path

import pytest

for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(threads, "1")

TIERS = {
    "ehd": "fast",
    "mfbd": "fast",
    "master": "fast",
    "fmu": "fmu",
    "properties": "verification",
    "verification": "verification",
    "pinned": "pinned",
    "docs": "docs",
}


def pytest_collection_modifyitems(items):
    here = Path(__file__).parent
    for item in items:
        folder = item.path.relative_to(here).parts[0]
        item.add_marker(getattr(pytest.mark, TIERS[folder]))
