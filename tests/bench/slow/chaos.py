"""An hour of the chaos driver of `tests/fmu/chaos.py`: runs that are killed, frozen, short of disk
or whose files are damaged end with the tables of an undisturbed one.

    python tests/bench/slow/chaos.py
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is loaded

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[3]))
from tests.fmu import chaos

HOUR = 3600

if __name__ == "__main__":
    chaos.main(HOUR)
