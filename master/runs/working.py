"""Progress of phases that take long: no phase is silent for more than 5 s."""

import sys
import threading
import time as clock
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cached_property
from typing import Any

from rich.console import Console

from ..fmi.cache import cache_folder, write_whole

QUIET = 4.0
"""Time between two lines outside a terminal [s]."""
REFRESH = 0.5
"""Time between two updates in a terminal [s]."""
TYPICAL = 200
"""Kernels of a first start, if no complete compilation is known."""
COMPLETE = 50
"""Smallest number of kernels of a complete compilation."""


class Compilation:
    """Kernels that numba compiles in this process, of those expected.

    Parameters
    ----------
    name : str
        Of the record of the last complete compilation.
    """

    def __init__(self, name: str = "count"):
        self.record = cache_folder("compiled") / name

    @property
    def count(self) -> int:
        """Number of kernels compiled since the first reading."""
        numba: Any = sys.modules.get("numba.core.event")
        if not hasattr(numba, "register"):  # not or only partly imported
            return 0
        return sum(event.is_end for _, event in self._events(numba).buffer)

    def _events(self, numba: Any):
        if "_listener" not in vars(self):
            self._listener = numba.RecordingListener()
            numba.register("numba:compile", self._listener)
        return self._listener

    @cached_property
    def expected(self) -> int:
        """Number of kernels of the last complete compilation."""
        with suppress(OSError, ValueError):
            return max(COMPLETE, int(self.record.read_text()))
        return TYPICAL

    def text(self) -> str:
        """Return the share of compiled kernels; empty if none was compiled."""
        count = self.count
        if not count:
            return ""
        share = min(99, 100 * count // self.expected)
        return f"compiling: {share} % ({count} of about {self.expected} kernels)"

    def finish(self) -> None:
        """Save the number of kernels of a complete compilation."""
        if (count := self.count) >= COMPLETE:
            with suppress(OSError):
                write_whole(self.record, f"{count}\n".encode())


@contextmanager
def every(seconds: float, action: Callable[[], object]) -> Iterator:
    """Call `action` in another thread every few seconds."""
    ended = threading.Event()

    def repeat() -> None:
        while not ended.wait(seconds):
            action()

    thread = threading.Thread(target=repeat, daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()


@contextmanager
def ticking(console: Console, text: Callable[[], str], show: Callable[[str], object]) -> Iterator:
    """Show `text()` by `show` in a terminal, and on the error stream every `QUIET` s elsewhere."""

    def tick() -> None:
        if console.is_terminal:
            show(text())
        elif line := text():
            print(line, file=sys.stderr, flush=True)

    with every(REFRESH if console.is_terminal else QUIET, tick):
        yield


class Phase:
    """Name of the phase under way."""

    def __init__(self, name: str):
        self.name = name
        self.begin = clock.monotonic()
        self.compilation = Compilation()

    def update(self, name: str) -> None:
        """Change the name."""
        self.name = name

    def text(self) -> str:
        """Return name, elapsed time and progress of the compilation."""
        parts = [self.name, f"{clock.monotonic() - self.begin:.0f} s", self.compilation.text()]
        return "  ".join(filter(None, parts))


@contextmanager
def working(console: Console, name: str) -> Iterator[Phase]:
    """Show a phase: with a spinner in a terminal, by lines on the error stream elsewhere."""
    phase = Phase(name)
    with console.status(name) as status, ticking(console, phase.text, status.update):
        yield phase
