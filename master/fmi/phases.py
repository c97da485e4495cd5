"""Phases that take long, and the time that each is expected to take."""

import time
from collections.abc import Generator
from contextlib import contextmanager, suppress

from .cache import cache_folder, write_whole

LONGEST_SHARE = 0.99
"""Share of a phase that takes longer than expected."""


class Phase:
    """A phase under way.

    Parameters
    ----------
    name : str
    work : float
        Amount of work, in any unit.
    typical : float
        Time per unit of work if no earlier phase of this name is known [s].
    """

    def __init__(self, name: str, work: float = 1.0, typical: float = 5.0):
        self.name = name
        self.work = work
        self.begin = time.monotonic()
        self.record = cache_folder("durations") / name.replace(" ", "_")
        with suppress(OSError, ValueError):
            typical = float(self.record.read_text())
        self.expected = work * typical

    @property
    def elapsed(self) -> float:
        """Time since the begin [s]."""
        return time.monotonic() - self.begin

    @property
    def share(self) -> float:
        """Elapsed share of the expected time."""
        return min(LONGEST_SHARE, self.elapsed / max(self.expected, 1e-3))

    def finish(self) -> None:
        """Save the time per unit of work, if there was any, for the next phase of this name."""
        if not self.work:
            return
        with suppress(OSError):
            write_whole(self.record, f"{self.elapsed / self.work:.3g}\n".encode())


UNDER_WAY: list[Phase] = []
"""Phases of this process that have begun and not ended."""


@contextmanager
def phase(name: str, work: float = 1.0, typical: float = 5.0) -> Generator[Phase, None, None]:
    """Add a phase to those under way, with the parameters of `Phase`."""
    this = Phase(name, work, typical)
    UNDER_WAY.append(this)
    try:
        yield this
        this.finish()
    finally:
        UNDER_WAY.remove(this)
