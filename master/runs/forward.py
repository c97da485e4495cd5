"""Sensitivities from the derivative of one run, `coupling.forward`, instead of two runs each.

Eq. (V8):  change = (f(y + e y') - f(y - e y')) / (2 e)
           spread = |f(y + e y') - 2 f(y) + f(y - e y')| / (2 e)

f is a figure of the last period, y the scalar outputs of the run at all instants, and y' their
derivatives by the step of a variable. The run is that of the case itself. Its macro steps and their
parts, the cells that are full, and the instants of extremes do not change with the variable.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..case.changes import changed
from ..case.checked import check_case
from ..case.system import open_system
from ..coupling.forward import ForwardSensitivities, NotCovered, Pair
from ..engine.measures import measures
from ..fmi.builder import slave_of
from ..fmi.tree import slave_class
from ..participants.local import LocalParticipant
from ..participants.participant import Wrapper
from ..results.file import Results
from .completed import complete_run
from .reductions import Reduction
from .sensitivities import Row, Runs, Sensitivity, sensitivities

Answer = tuple[list[Sensitivity], list[Row], list[str]]
"""Sensitivities, rows of failed designs, and sentences."""
SHARE = 1e-4
"""e of Eqs. (Q14) and (V8): difference of a variable over its step."""
LARGEST_GROWTH = 10.0
"""Growth of the derivative per period above which it is no guide."""
DERIVATIVES = "derivatives.npz"
"""File with the derivatives of all scalar outputs at all instants."""


@dataclass(frozen=True)
class Derivatives:
    """Derivatives of a run.

    known : changes of figures; notes : sentences about accuracy and held rules; path : file with
    `time`, `ports`, `variables` and `values`, shape (rows, variables, ports), in SI by the step of
    each variable.
    """

    known: list[Sensitivity]
    notes: list[str]
    path: Path


class MovedResults(Results):
    """Results of a run whose scalar outputs are moved by a factor times their derivatives."""

    def __init__(self, path: Path, changes: dict[str, np.ndarray], factor: float):
        super().__init__(path)
        self.changes, self.factor = changes, factor

    def series(self, port: str):
        """Return a scalar output with its change."""
        series = super().series(port)
        if port not in self.changes:
            return series
        change = self.changes[port][self._first_row :]
        return series._replace(values=series.values + self.factor * change)


def local_system(tree: dict[str, Any], path: Path) -> Any:
    """Return the system of a case with its participants in this process, before their start.

    Raises
    ------
    NotCovered
        If a participant or a wire is of another kind.
    """
    case = check_case(tree, path)
    if case.coupling.method == "explicit":
        raise NotCovered("explicit coupling does not solve the macro step")
    system = open_system(case, path.parent, lambda line: None, fmu_options={"version": "2.0"})
    if system.held or system.clocks:
        raise NotCovered("a wire carries a value that is not real, or a clock")
    local = {}
    for name, participant in system.participants.items():
        package = case.participants[name].package
        if not package or isinstance(participant, Wrapper):
            raise NotCovered(f"{name}: expected a package of this project without own steps")
        slave = slave_class(slave_of(package))
        folder = str(participant.folder / "resources")
        local[name] = LocalParticipant(name, slave(instance_name=name, resources=folder))
    return replace(system, participants=local)


def forward(runs: Runs, figures: Sequence[str]) -> Derivatives:
    """Return the changes of figures with all variables, from the derivative of one run.

    Raises
    ------
    NotCovered
        With the reason.
    BadInput, Stopped
        If the case is wrong, or its run fails.
    """
    tree, path, space = runs.tree, runs.path, runs.space
    names, folder = space.names, runs.folder / "forward"

    def system_at(shares):
        return local_system(changed(tree, space.changes(shares), path.parent), path)

    base = local_system(tree, path)
    units = SHARE * np.eye(len(names))
    pairs = [Pair(system_at(unit), system_at(-unit), SHARE) for unit in units]
    observer = ForwardSensitivities(base, pairs)
    case, system = check_case(tree, path), local_system(tree, path)
    file = folder / "run.h5"
    silent = {"say": lambda line: None, "observers": (observer,)}
    summary = complete_run(system, case, tree, file, **silent)
    with Results(file) as results:
        rows = len(results.whole.time)
    if rows != len(observer.times):
        raise NotCovered("periods of the run were extrapolated")
    values = np.array(observer.rows)
    ports = [".".join(port) for port in observer.ports]
    np.savez_compressed(
        folder / DERIVATIVES, time=observer.times, ports=ports, variables=names, values=values
    )
    known = []
    for k, name in enumerate(names):
        changes = dict(zip(ports, values[:, k].T))
        shown = [_figures(case, MovedResults(file, changes, e)) for e in (0.0, SHARE, -SHARE)]
        for figure in figures:
            if all(figure in one for one in shown):
                here, above, below = (one[figure] for one in shown)
                change = 0.5 * (above - below) / SHARE  # Eq. (V8)
                spread = 0.5 * abs(above - 2.0 * here + below) / SHARE
                known.append(Sensitivity(figure, name, here, change, spread))
    return Derivatives(known, _notes(observer, system.period, summary), folder / DERIVATIVES)


def by_differences(runs: Runs, figures: Sequence[str]) -> Answer:
    """Return the changes of `sensitivities`, its failed rows, and no sentences."""
    known, failed = sensitivities(runs, figures)
    return known, failed, []


def forward_or_differences(runs: Runs, figures: Sequence[str]) -> Answer:
    """Return the changes of `forward`, or of `sensitivities` if it does not cover the case.

    Returns
    -------
    known : list of Sensitivity
    failed : list of dict
        Rows of designs that failed.
    notes : list of str
        Sentences about accuracy, held rules, or the reason for differences of runs.
    """
    try:
        one = forward(runs, figures)
    except NotCovered as reason:
        known, failed, _ = by_differences(runs, figures)
        return known, failed, [f"differences of runs, because {reason}"]
    return one.known, [], [*one.notes, f"derivatives at all instants: {one.path}"]


def _figures(case, results):
    """Return the measures of a design and the summary entries of the last period."""
    with results:
        figures = dict(measures(case, results).design)
        last = results.last
        for name, text in case.summary.items():
            entry = Reduction(name, text, last.time[0])
            values = last.series(".".join(entry.port)).values
            for time, value in zip(last.time[1:], values[1:]):
                entry.add(time, float(value))
            figures[name] = float(entry.result())
    return figures


def _notes(observer, period, summary):
    """Return sentences about accuracy and held rules."""
    notes = [f"largest error of the interface equations: {observer.mismatch:.1g} of the derivative"]
    for name, count in observer.switches.items():
        if count:
            notes.append(f"{name}: a rule switched within {count} differences, one side was used")
    for counter in ("halved_steps", "repeated_steps"):
        if summary.get(counter):
            notes.append(f"{counter}: {summary[counter]}, held")
    growth = observer.growth(period) if period else np.nan
    if growth == growth:
        notes.append(f"growth of the derivative over the last period: {growth:.3g}")
    if growth > LARGEST_GROWTH:
        notes.append(f"the derivative is no guide, because it grows by more than {LARGEST_GROWTH}")
    return notes
