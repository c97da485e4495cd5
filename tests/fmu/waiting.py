"""Wait for what another process does."""

import time


def wait_for(condition, seconds=60):
    """Return once `condition()` holds; fail if it does not hold by then."""
    end = time.monotonic() + seconds
    while not condition() and time.monotonic() < end:
        time.sleep(0.005)
    assert condition()
