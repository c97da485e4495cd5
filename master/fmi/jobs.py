"""Number of processes that compute at the same time."""

import os

VARIABLE = "PISTON_COSIM_JOBS"
"""Environment variable that `--jobs` sets for the command and its processes."""


def jobs() -> int:
    """Return the number of processes; default: the processors that this process may use."""
    setting = os.environ.get(VARIABLE, "")
    if setting.isdecimal() and int(setting) > 0:
        return int(setting)
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
