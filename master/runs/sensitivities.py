"""Sensitivities: changes of the figures of a run with variables of its case, by differences.

Eq. (V3):  change = (f(+1) - f(-1)) / 2,   spread = |f(+1) - 2 f(0) + f(-1)| / 2

f is a figure of the last period, +1 and -1 stand for a step of one variable in both directions.
The change is that of a step. The spread is half of the difference of both one-sided changes: what
curvature over the step, and scatter of runs, leave open. A change below its spread is not resolved.
"""

from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..case.changes import changed
from ..case.checked import check_case
from ..fmi.cache import passing_fmus
from ..fmi.errors import BadInput, for_all
from . import sweep as sweeps
from .design_space import Changes, DesignSpace, Shapes
from .lock import sole_writer
from .recorder import writing

Row = dict[str, Any]


@dataclass(frozen=True)
class Sensitivity:
    """Change of a figure with a step of a variable, Eq. (V3), in the SI unit of the figure."""

    figure: str
    variable: str
    value: float
    change: float
    spread: float

    @property
    def is_resolved(self) -> bool:
        """Whether the change is larger than its spread."""
        return abs(self.change) > self.spread


@dataclass(frozen=True)
class Runs:
    """Settings for the runs of designs.

    tree : resolved TOML tree of the case; path : of its file; space : variables; folder : of the
    rows; executor : as for `sweep.sweep`; watch : called with number done, number of all, and the
    row; keeps : whether results files remain.
    """

    tree: dict[str, Any]
    path: Path
    space: DesignSpace
    folder: Path
    executor: Any
    watch: Callable[[int, int, Row], object] = lambda done, total, row: None
    keeps: bool = True

    def rows(
        self,
        designs: Sequence[np.ndarray],
        more: Sequence[Changes] = ([],),
        uncertainty: bool = False,
    ) -> list[Row]:
        """Return the rows of designs, for each design those of all further changes `more`.

        Finished designs are read from the folder. The entry `results` is the results file.

        Raises
        ------
        BadInput
            With every fault of every design.
        """

        def point(pair):
            design, added = pair
            changes = [*added, *self.space.changes(design)]
            tree = changed(self.tree, changes, self.path.parent)
            check_case(tree, self.path)
            return sweeps.Point(dict(zip(self.space.names, design)), tree)

        points = for_all(point, [(x, added) for x in designs for added in more])
        folder = self.folder / "runs"
        for one in points if self.keeps else ():
            if not (folder / f"{one.name}.h5").exists():  # deleted, or not kept by a search
                (folder / f"{one.name}.json").unlink(missing_ok=True)
        waiting = sweeps.unfinished(points, self.folder, uncertainty)
        sweeps.build_all(waiting, self.path.parent, lambda text: None)

        def after_run(rows, ended):
            self.watch(len(rows), len(points), rows[ended[0]])
            for k in ended if not self.keeps else ():
                (folder / f"{points[k].name}.h5").unlink(missing_ok=True)

        case_folder = self.path.parent
        with writing(folder):
            rows = sweeps.rows_of_points(
                points, case_folder, folder, self.executor, after_run, uncertainty
            )
        return [row | {"results": folder / f"{p.name}.h5"} for row, p in zip(rows, points)]


@contextmanager
def use_of(folder: Path) -> Generator[None]:
    """Be the only user of the folder of designs, with a cache of FMUs that is deleted at the end.

    Raises
    ------
    BadInput
        If another process uses the folder.
    """
    with sole_writer(folder / "runs"), passing_fmus(folder / "passing_fmus"):
        yield


def sensitivities(runs: Runs, figures: Sequence[str]) -> tuple[list[Sensitivity], list[Row]]:
    """Return the sensitivities of figures that the runs have, and the rows of designs that failed.

    Raises
    ------
    BadInput
        With the faults of the case, and if the case itself fails.
    """
    count = len(runs.space.names)
    steps = np.eye(count)
    base, *others = runs.rows(
        [np.zeros(count), *(sign * step for step in steps for sign in (1.0, -1.0))]
    )
    if base["status"] != "done":
        raise BadInput(f"the case itself: {base['message']}")
    failed = [row for row in others if row["status"] != "done"]
    known = []
    for k, name in enumerate(runs.space.names):
        upper, lower = others[2 * k], others[2 * k + 1]
        for figure in figures:
            values = [row.get(figure) for row in (base, upper, lower)]
            if all(isinstance(value, float) for value in values):
                known.append(_sensitivity(figure, name, *values))
    return known, failed


def _sensitivity(figure, variable, value, upper, lower):
    change = 0.5 * (upper - lower)  # Eq. (V3)
    return Sensitivity(figure, variable, value, change, 0.5 * abs(upper - 2.0 * value + lower))


def map_of(shapes: Shapes, slopes: Sequence[float]) -> np.ndarray:
    """Return the map whose mean product with each shape is the slope of a figure with it.

    Eq. (V5):  g(theta, y) = sum of c_k s_k,   mean(g s_k) = df/dx_k / a

    Among all maps with these products it has the smallest rms. A profile p changes the figure by
    mean(g p), so a part of the skirt of share A with the height p by A g p.

    Parameters
    ----------
    shapes : Shapes
    slopes : sequence of float
        df/dx_k / a, the unit of the figure per m.

    Returns
    -------
    ndarray, shape (heights, angles)
        The unit of the figure per m.
    """
    values = shapes.values.reshape(len(shapes.names), -1)
    products = values @ values.T / values.shape[1]
    weights = np.linalg.solve(products, np.asarray(slopes))
    return np.tensordot(weights, shapes.values, 1)  # Eq. (V5)
