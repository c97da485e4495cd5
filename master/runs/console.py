"""What a run says on the screen: a progress line while it goes, a one-screen summary at its end."""

import time as clock
from contextlib import contextmanager

from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Column, Table

from ..fmi.quantities import short
from .working import Phase, ticking

STARTING = "starting"
REFRESH = 0.2
"""Seconds from one progress line to the next: units of handy size take a millisecond to find."""


class Watch:
    """A run's progress on the screen: the `watch` of `run`; `first` is when the first step was done
    [s].
    """

    def __init__(self, progress, task):
        self.progress = progress
        self.task = task
        self.first: float | None = None
        self.next = 0.0
        self.phase = Phase(STARTING)

    def text(self):
        """Return the progress outside a terminal."""
        if self.first is None:
            return self.phase.text()
        fields = self.progress.tasks[self.task]
        return f"{100 * fields.completed:.0f} %  {fields.fields['state']}"

    def show(self, text):
        """Show the progress of the start in a terminal."""
        if self.first is None:
            self.progress.update(self.task, state=text)

    def __call__(self, time, stop, solution, monitored):
        now = clock.perf_counter()
        if self.first is None:
            self.first = now
            self.phase.compilation.finish()
        if now < self.next and time < stop:
            return
        self.next = now + REFRESH
        parts = [f"{name} {short(*pair)}" for name, pair in monitored.items()]
        parts.append(f"iterations {solution.iterations}  residual {solution.history[-1]:.0e}")
        self.progress.update(self.task, completed=time / stop, state="  ".join(parts))


@contextmanager
def watching(console, label):
    """A `Watch` under a progress bar."""
    name = TextColumn("{task.description}", table_column=Column(min_width=len(label)))
    columns = (name, BarColumn(8), TimeElapsedColumn(), TextColumn("{task.fields[state]}"))
    with Progress(*columns, console=console, refresh_per_second=1 / REFRESH) as progress:
        watch = Watch(progress, progress.add_task(label, total=1.0, state=STARTING))
        with ticking(console, lambda: f"{label}: {watch.text()}", watch.show):
            yield watch


def print_summary(console, summaries):
    """Table of the runs' summaries, a column each."""
    table = Table("", *summaries, box=None)
    for key in dict.fromkeys(key for summary in summaries.values() for key in summary):
        values = [summary.get(key, "") for summary in summaries.values()]
        table.add_row(key, *(f"{v:.6g}" if isinstance(v, float) else str(v) for v in values))
    console.print(table)
