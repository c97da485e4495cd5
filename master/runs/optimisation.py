"""Optimisation of a design: the best value of one figure, within limits on others.

Eq. (V4):  minimise  J(x) = sum over points of s f(x) / |f(0)| / number of points
           with  g(x) = s (limit - f(x)) / |limit| >= 0  for each limit and point, and bounds of x

A limit of zero is divided by |f(0)| instead.

f is a figure of a run, s is 1 if less is better and -1 if more is better; points are the operating
points of the engine. A limit without a value is the figure of the case itself at this point.

Gradients are differences of runs over `GRADIENT_STEP` of a variable's share. These runs are
simultaneous. Sequential quadratic programming [Kraft1988] uses the gradients. Runs scatter, so the
result is not the last design. It is the best of all that keep the limits to `LIMIT_TOLERANCE`. A
design that fails has the objective `FAILED_OBJECTIVE`.

References
----------
[Kraft1988] D. Kraft, A software package for sequential quadratic programming, DFVLR-FB 88-28, 1988.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize, nnls

from ..fmi.errors import BadInput, unknown
from ..fmi.quantities import to_si
from ..results.words import words_and_unit
from .design_space import Changes
from .sensitivities import Row, Runs

GRADIENT_STEP = 0.05
"""Difference of a share for a gradient: a compromise of curvature and scatter of runs."""
LIMIT_TOLERANCE = 2e-3
"""Relative excess over a limit that counts as none; runs that settle to 1e-3 scatter by less."""
ACTIVE_DISTANCE = 1e-2
"""Relative distance up to which a limit counts as active."""
END_TOLERANCE = 1e-4
"""Change of J in an iteration at which the search ends."""
FAILED_OBJECTIVE = 10.0
"""J of a design whose run fails; that of the case itself is 1 or -1."""

Values = Callable[[Sequence[np.ndarray]], Sequence[np.ndarray | None]]
"""Values of designs; None for one of which a run fails."""


@dataclass(frozen=True)
class Limit:
    """Limit on a figure.

    sign : 1 for at most, -1 for at least; value : in the SI unit of the figure, None for the
    figure of the case itself.
    """

    figure: str
    sign: float
    value: float | None = None


LIMIT_FORMS = "FIGURE, FIGURE<=VALUE or FIGURE>=VALUE"


def known_figure(name: str, directions: Mapping[str, str], option: str) -> str:
    """Return the name of a figure, a key of `directions`; raise `BadInput` for another one."""
    if name not in directions:
        raise BadInput(f"{option}: {unknown('figure', name, directions)}")
    return name


def limit_of(text: str, directions: Mapping[str, str]) -> Limit:
    """Return the limit of one of `LIMIT_FORMS`; `directions` : "raise", "lower", "none" by figure.

    Raises
    ------
    BadInput
        For an unknown figure, a value of another unit, and a figure without direction and value.
    """
    for sign, symbol in ((1.0, "<="), (-1.0, ">=")):
        name, sign_is_there, value = text.partition(symbol)
        if sign_is_there:
            figure = known_figure(name.strip(), directions, "--limit")
            try:
                return Limit(figure, sign, to_si(value.strip(), words_and_unit(figure)[1] or "1"))
            except ValueError as error:
                raise BadInput(f"--limit {figure}: {error}") from None
    if any(one in text for one in "<>="):
        raise BadInput(f"--limit: expected {LIMIT_FORMS}, got {text!r}")
    figure = known_figure(text.strip(), directions, "--limit")
    if directions[figure] == "none":
        raise BadInput(f"--limit {figure}: expected FIGURE<=VALUE or FIGURE>=VALUE, got no value")
    return Limit(figure, -1.0 if directions[figure] == "raise" else 1.0)


@dataclass(frozen=True)
class Task:
    """Task of an optimisation.

    goal : figure; sign : 1 if less is better, -1 if more; limits; points : changes of the case at
    each operating point; bounds : lower and upper share of each variable; gradients : at most;
    start : shares at which the search begins, default: those of the case.
    """

    goal: str
    sign: float
    limits: tuple[Limit, ...]
    points: tuple[Changes, ...]
    bounds: tuple[tuple[float, float], ...]
    gradients: int = 15
    start: tuple[float, ...] = ()


@dataclass(frozen=True)
class Active:
    """Limit that the result reaches.

    multiplier : relative change of the goal per relative change of the limit [-].
    """

    limit: Limit
    point: int
    multiplier: float


class Trial(NamedTuple):
    """Design that was run: its shares, J, and the smallest g, at most 0."""

    shares: np.ndarray
    value: float
    slack: float


@dataclass(frozen=True)
class Optimum:
    """Result of an optimisation.

    shares : of the variables; before, after : J of the case itself and of the result; active;
    history : all designs in their order; gradient : of J to the shares;
    message : why the search ended; slack : the smallest g of the result, at most 0.
    """

    shares: np.ndarray
    before: float
    after: float
    active: list[Active]
    history: list[Trial]
    gradient: np.ndarray
    message: str
    slack: float


@dataclass
class Search:
    """Designs that were run, and their objective and limits, Eq. (V4)."""

    task: Task
    runs: Runs
    watch: Callable[[float, float], object] = lambda value, slack: None
    base: list[Row] = field(default_factory=list[Row])
    known: dict[bytes, np.ndarray] = field(default_factory=dict)
    slopes: dict[bytes, np.ndarray] = field(default_factory=dict)
    history: list[Trial] = field(default_factory=list[Trial])

    def start(self) -> None:
        """Run the case itself at all points.

        Raises
        ------
        BadInput
            If one of these runs fails, or has no such figure.
        """
        self.base = self.runs.rows([np.zeros(len(self.task.bounds))], self.task.points)
        for row in self.base:
            if row["status"] != "done":
                raise BadInput(f"the case itself: {row['message']}")
            for figure in (self.task.goal, *(one.figure for one in self.task.limits)):
                if not isinstance(row.get(figure), (int, float)) or not np.isfinite(row[figure]):
                    raise BadInput(f"{figure}: expected a figure of this case, got none from it")
            if not row[self.task.goal]:
                raise BadInput(f"{self.task.goal}: expected a goal that is not 0 in the case")

    def values(self, designs: Sequence[np.ndarray]) -> list[np.ndarray | None]:
        """Return J and all g of designs, shape (1 + m,), None for one of which a run failed."""
        rows, count = self.runs.rows(designs, self.task.points), len(self.task.points)
        return [self._value(rows[k * count : (k + 1) * count]) for k in range(len(designs))]

    def _value(self, rows):
        task = self.task
        if any(row["status"] != "done" for row in rows):
            return None
        shares = [row[task.goal] / abs(base[task.goal]) for row, base in zip(rows, self.base)]
        slack = []
        for one in task.limits:
            for row, base in zip(rows, self.base):
                limit = base[one.figure] if one.value is None else one.value
                # Eq. (V4)
                size = abs(limit) or abs(base[one.figure]) or 1.0
                slack.append(one.sign * (limit - row[one.figure]) / size)
        return np.array([task.sign * float(np.mean(shares)), *slack])

    def at(self, x: np.ndarray) -> np.ndarray:
        """Return J and all g of a design, shape (1 + m,)."""
        key = x.tobytes()
        if key not in self.known:
            (value,) = self.values([x])
            if value is None:
                count = len(self.task.limits) * len(self.task.points)
                value = np.array([FAILED_OBJECTIVE] + [-1.0] * count)
            self.known[key] = value
            self.history.append(Trial(x.copy(), float(value[0]), float(value[1:].min(initial=0.0))))
            self.watch(*self.history[-1][1:])
        return self.known[key]

    def slope(self, x: np.ndarray) -> np.ndarray:
        """Return the gradients of J and all g at a design, shape (1 + m, n)."""
        key = x.tobytes()
        if key not in self.slopes:
            self.slopes[key] = differences(self.values, x, self.at(x), self.task.bounds)
        return self.slopes[key]


def differences(
    values: Values, x: np.ndarray, here: np.ndarray, bounds: Sequence[tuple[float, float]]
) -> np.ndarray:
    """Return the derivatives of the values of a design with its shares.

    Parameters
    ----------
    values : callable
    x : ndarray, shape (n,)
    here : ndarray, shape (m,)
        Values of x.
    bounds : sequence of (float, float)
        Lower and upper share of each variable.

    Returns
    -------
    ndarray, shape (m, n)
        0 for a variable whose run fails.
    """
    steps = np.where(x + GRADIENT_STEP <= np.array(bounds)[:, 1], GRADIENT_STEP, -GRADIENT_STEP)
    moved = values([*(x + np.diag(steps))])
    changes = [(here if one is None else one) - here for one in moved]
    return np.stack(changes, axis=1) / steps  # rows without strides, which SLSQP misreads


def optimise(search: Search) -> Optimum:
    """Return the best design that the search finds.

    Raises
    ------
    BadInput
        If the case itself fails.
    """
    task = search.task
    search.start()
    zero = np.zeros(len(task.bounds))
    before = search.at(zero)[0]
    within = {
        "type": "ineq",
        "fun": lambda x: search.at(x)[1:],
        "jac": lambda x: search.slope(x)[1:],
    }
    done = minimize(
        lambda x: search.at(x)[0],
        np.array(task.start) if task.start else zero,
        jac=lambda x: search.slope(x)[0],
        method="SLSQP",
        bounds=task.bounds,
        constraints=[within] if task.limits else [],
        options={"maxiter": task.gradients, "ftol": END_TOLERANCE},
    )
    feasible = [one for one in search.history if one.slack >= -LIMIT_TOLERANCE]
    best, after, slack = (
        min(feasible, key=lambda one: one.value)
        if feasible
        else max(search.history, key=lambda one: (one.slack, -one.value))
    )
    return Optimum(
        shares=best,
        before=before,
        after=after,
        active=_active(search, best),
        history=search.history,
        gradient=search.slope(best)[0],
        message=done.message,
        slack=slack,
    )


def _active(search, x):
    """Return the active limits with their multipliers: grad J = sum of multiplier grad g."""
    task, slack, slopes = search.task, search.at(x)[1:], search.slope(x)
    free = np.array(
        [
            low + GRADIENT_STEP < one < high - GRADIENT_STEP
            for one, (low, high) in zip(x, task.bounds)
        ]
    )
    active = [k for k, one in enumerate(slack) if one <= ACTIVE_DISTANCE]
    if not active or not free.any():
        return []
    multipliers, _ = nnls(slopes[1:][active][:, free].T, slopes[0, free])
    count = len(task.points)
    pairs = zip(active, multipliers)
    return [Active(task.limits[k // count], k % count, float(one)) for k, one in pairs]
