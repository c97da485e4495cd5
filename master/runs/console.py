"""Output of a run on the screen: progress bar and summary."""

import time as clock
from contextlib import contextmanager

from rich.markup import escape
from rich.table import Table

from ..fmi.phases import Phase
from ..fmi.quantities import short
from .working import Compilation, bars

REFRESH_INTERVAL = 0.2
"""Time between two progress lines [s]; choosing a unit prefix takes a millisecond."""


class Watch:
    """Progress of a run: the `watch` of `run`; `first` is the time of the first step [s].

    Parameters
    ----------
    show : callable
        Called with the completed share of the run, and its state as text.
    """

    def __init__(self, show):
        self.show = show
        self.first: float | None = None
        self.next = 0.0
        self.compilation = Compilation()
        self.start = Phase("starting")

    def tick(self):
        """Show the progress of the start."""
        if self.first is None:
            left = self.start.expected - self.start.elapsed
            words = f"starting, {left:.0f} s left" if left > 0.0 else "starting"
            self.show(0.0, f"{words}  {self.compilation.text()}".rstrip())

    def __call__(self, time, stop, solution, monitored):
        now = clock.perf_counter()
        if self.first is None:
            self.first = now
            self.compilation.finish()
            self.start.finish()
        if now < self.next and time < stop:
            return
        self.next = now + REFRESH_INTERVAL
        parts = [f"{name} {short(*pair)}" for name, pair in monitored.items()]
        parts.append(f"iterations {solution.iterations}  residual {solution.history[-1]:.0e}")
        self.show(time / stop, "  ".join(parts))


@contextmanager
def watching(console, label):
    """Yield a `Watch` under a progress bar."""
    watch = Watch(lambda share, state: show(label, share, state))
    with bars(console, watch.tick) as show:
        yield watch


def print_summary(console, summaries):
    """Print a table of the runs' summaries, with a column for each."""
    table = Table("", *summaries, box=None)
    for key in dict.fromkeys(key for summary in summaries.values() for key in summary):
        values = [summary.get(key, "") for summary in summaries.values()]
        table.add_row(
            key, *(f"{v:.6g}" if isinstance(v, float) else escape(str(v)) for v in values)
        )
    console.print(table)
