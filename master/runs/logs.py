"""Two text tables next to the results, similar to preCICE's: macro steps and iterations.

<label>-iterations.log    a line for each attempt at a macro step, failed ones with
                          Converged = 0 and the reason
<label>-convergence.log   a line for each evaluation: residual / tolerance of every wire,
                          converged if all are 1 or less
"""

from contextlib import suppress
from pathlib import Path

ATTEMPT = "{:>6} {:>22} {:>22} {:>10} {:>15} {:>9}"
ROW = "%6d %22r %22r %10d %15d %9d"
HEADER = ("Window", "Time[s]", "Step[s]", "Iterations", "TotalIterations", "Converged")


class CouplingLog:
    """Writer of both tables; a window is an accepted step, including halved ones.

    Parameters
    ----------
    output : Path
        Results file.
    wires : sequence of Wire
    counters : Counters
        Counters of the run so far. Lines beyond them come from an interrupted run after its
        checkpoint, and are removed.
    """

    def __init__(self, output, wires, counters):
        self.windows = windows = counters.steps
        self.total = counters.residual_evaluations
        targets = [" ".join(".".join(wire.target).split()) for wire in wires]
        self.widths = [max(12, len(target)) for target in targets]
        self.row = "%6d %9d " + " ".join(f"%{width}.4e" for width in self.widths) + "\n"
        self.iterations = _table(log_path(output, "iterations"), ATTEMPT.format(*HEADER), windows)
        self.convergence = _table(log_path(output, "convergence"), self._header(targets), windows)

    def _header(self, targets):
        named = (f"{target:>{width}}" for target, width in zip(targets, self.widths))
        return f"{'Window':>6} {'Iteration':>9} " + " ".join(named)

    def attempt(self, time, step, trail, failure):
        """Log an attempt at the macro step from `time` over `step` [s].

        trail : residual / tolerance of every wire, by evaluation; failure : its reason, None if
        it converged.
        """
        count = len(trail)
        self.total += count
        window = self.windows + 1
        for k, shares in enumerate(trail):
            self.convergence.write(self.row % (window, k + 1, *shares))
        line = ROW % (window, time, step, count, self.total, failure is None)
        self.iterations.write(f"{line}  {failure}\n" if failure else f"{line}\n")
        self.windows += failure is None

    def flush(self):
        """Write all lines to the disk."""
        self.iterations.flush()
        self.convergence.flush()

    def close(self):
        """Close both files; ignore a full disk, which the run has reported."""
        for file in (self.iterations, self.convergence):
            with suppress(OSError):
                file.close()


def log_path(output, kind):
    """Return the path of a table next to a results file."""
    return Path(output).with_name(f"{Path(output).stem}-{kind}.log")


def _table(path, header, windows):
    """Open a table for appending, with its first `windows` windows or a new header."""
    lines = [header + "\n"]
    if windows and path.exists():
        written = path.read_text().splitlines(keepends=True)
        head, *rows = [line for line in written if line.endswith("\n")]  # complete lines
        lines = [head, *(row for row in rows if int(row.split()[0]) <= windows)]
    path.write_text("".join(lines))
    return open(path, "a")
