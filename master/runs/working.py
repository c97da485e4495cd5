"""Progress of long phases, with a first output within 5 s."""

import re
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cached_property
from typing import Any

from rich.console import Console
from rich.progress import (
    BarColumn,
    Progress,
    Task,
    TaskID,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from ..fmi.cache import cache_folder, write_whole
from ..fmi.phases import LONGEST_SHARE, UNDER_WAY, phase

Tenths = tuple[int, int | None]
"""Tenths of a share, and of the share of compiled kernels."""
QUIET_INTERVAL = 4.0
"""Shortest time between two lines outside a terminal [s]."""
REFRESH_INTERVAL = 0.5
"""Time between two updates in a terminal [s]."""
TYPICAL_KERNELS = 200
"""Kernels of a first start, if no complete compilation is known."""
COMPLETE_KERNELS = 50
"""Smallest number of kernels of a complete compilation."""


class Compilation:
    """Kernels that numba has compiled in this process, compared with the expected number.

    Parameters
    ----------
    name : str
        Name of the record of the last complete compilation.
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
            return max(COMPLETE_KERNELS, int(self.record.read_text()))
        return TYPICAL_KERNELS

    def text(self) -> str:
        """Return the share of compiled kernels; empty if none was compiled."""
        count = self.count
        if not count:
            return ""
        share = min(99, 100 * count // self.expected)
        return f"compiling: {share} % ({count} of about {self.expected} kernels)"

    def finish(self) -> None:
        """Save the number of kernels of a complete compilation."""
        if (count := self.count) >= COMPLETE_KERNELS:
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
def bars(console: Console, tick: Callable[[], object] = lambda: None, **options: Any) -> Iterator:
    """Yield `show(label, share, state)` of parallel progress bars; call `tick` before updates.

    Outside a terminal they are lines on the error stream, one for each 10 %, at most one in
    `QUIET_INTERVAL` s.
    """
    columns = (
        TextColumn("{task.description}"),
        BarColumn(8),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
        TextColumn("{task.fields[state]}"),
    )
    tasks: dict[str, TaskID] = {}
    with Progress(
        *columns, console=console, refresh_per_second=1 / REFRESH_INTERVAL, **options
    ) as progress:

        def show(label: str, share: float, state: str) -> None:
            if label not in tasks:
                tasks[label] = progress.add_task(label, total=1.0, state="")
            progress.update(tasks[label], completed=share, state=state)

        printed: dict[str, Tenths] = {}

        def print_lines() -> None:
            if not console.is_terminal:
                for task in progress.tasks:
                    if not task.finished and printed.get(task.description) != _tenths(task):
                        printed[task.description] = _tenths(task)
                        print(_line(task), file=sys.stderr, flush=True)

        with every(REFRESH_INTERVAL, tick), every(QUIET_INTERVAL, print_lines):
            yield show


def _tenths(task: Task) -> Tenths:
    """Return the tenths of a bar's share, and of its compilation."""
    compiled = re.match(r"compiling: (\d+) %", task.fields["state"])
    return int(10 * task.completed), int(compiled[1]) // 10 if compiled else None


def _line(task: Task) -> str:
    """Return name, share, remaining time and state of a bar."""
    share = task.completed
    parts = [f"{task.description}:", f"{100 * share:.0f} %" if share else ""]
    if share < LONGEST_SHARE and task.time_remaining is not None:
        parts.append(f"{task.time_remaining:.0f} s left")
    return "  ".join(filter(None, [*parts, task.fields["state"]]))


@contextmanager
def working(console: Console, name: str, work: float = 1.0, typical: float = 5.0) -> Iterator:
    """Show a phase with the parameters of `Phase`, and the phases within it, by `bars`."""
    compilation = Compilation()
    shown: set[str] = set()

    def tick() -> None:
        under_way = {one.name: one.share for one in list(UNDER_WAY)}
        for label in shown - under_way.keys():
            show(label, 1.0, "")
        shown.update(under_way)
        for label, share in under_way.items():
            show(label, share, compilation.text() if label == name else "")

    with bars(console, tick, transient=True) as show, phase(name, work, typical):
        yield
