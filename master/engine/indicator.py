"""Estimate of the uncertainty of every figure from the results of one run.

It takes no other run. `runs.uncertainty` computes other grids and steps instead, and the factors
below are fitted to its results for five rigid pistons on 20 x 20 and 26 x 10 cells.

Eq. (X49):  u_grid = 0.3 e_h h of the minimum film thickness h
            u_grid = 0.12 min(e_p, 8) p of the maximum pressure p
            e = sum over both directions of (q_1 + q_2 - 2 q) / 2 |q|,   q the extreme cell, q_1 and
            q_2 its neighbours; e_p has the neighbours' values as divisors

Figures of other kinds follow from these two: a displacement is as uncertain as the film, and a
rocking angle as the film over the length of the skirt.

Eq. (X50):  u_step = max(|f - f_2|, max |e_n|)      e_n of Eq. (X26) near the instant of an extreme,
            f_2 the figure of every second macro step
Eq. (X51):  u_period = |f - f_1|,   f_1 the figure of the previous period
Eq. (X52):  u_modes = c s f,   s the truncation error over the film thickness; c is 3 for pressure,
            because the film's conductance is the cube of its thickness, otherwise 1
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from ..results.file import Results
from .impacts import losses
from .peaks import peak_width
from .places import film_body, gap_port, parameter

ROW_TOLERANCE = 1e-6
"""Share of a period by which a row may miss its beginning due to round-off."""
STEPS_NEAR_EXTREME = 4
"""Macro steps on both sides of an extreme whose local errors count."""
FILM_FACTOR, PRESSURE_FACTOR, MOST_STEEPNESS = 0.3, 0.12, 8.0
"""Factors of Eq. (X49)."""
NARROW_PEAK = 2
"""Cells of a pressure peak at half its height up to which it does not converge: its height is that
of the cell, not of the peak."""
FRICTION_FACTOR = 1.0
"""Relative uncertainty of friction over the change of its sum if every second cell is left out."""
OIL_FACTOR = 4.0
"""Relative uncertainty of the oil throughput times the number of cells of the film."""
SIDE_FACTOR = 0.8
"""Uncertainty of the side force over its difference from the demand of gas and inertia."""
SLAP_FACTOR = 5.0
"""Relative uncertainty of the slap energy over sum of (1/n^2), n the cells that carry the load."""


Reduction = Callable[[np.ndarray, np.ndarray], float]
"""Function of times and values of one period that returns a figure."""


@dataclass(frozen=True)
class Course:
    """Values over the macro steps of the whole run, and the function that makes a figure of them.

    values : shape (rows, ...); reduce : callable(time, values) of one period.
    """

    values: np.ndarray
    reduce: Reduction

    def figure(self, time: np.ndarray, rows: slice) -> float:
        """Return the figure of some rows."""
        return float(self.reduce(time[rows], self.values[rows]))


def of_extreme(function: Callable[[np.ndarray], float]) -> Reduction:
    """Return the reduction by a function of the values alone."""
    return lambda time, values: function(values)


def largest(values: np.ndarray) -> float:
    """Return the largest magnitude."""
    return float(np.abs(values).max())


def hardest(time: np.ndarray, energy: np.ndarray) -> float:
    """Return the energy that a piston loses in its hardest impact."""
    return max((loss for _, loss in losses(energy)), default=0.0)


def of_work(figure: float, time: np.ndarray, power: np.ndarray) -> Reduction:
    """Return the reduction of a power to its work, in the unit of a figure of this period."""
    work = trapezoid(time, power)
    return lambda time, values: figure * trapezoid(time, values) / work if work else 0.0


def trapezoid(time: np.ndarray, values: np.ndarray) -> float:
    """Return the integral over time by the trapezoidal rule."""
    return float(np.diff(time) @ (values[1:] + values[:-1]) / 2.0)


def bdf2_error(time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the local error of variable-step BDF2 from the fourth value on.

    Eq. (X26):  e_n = H_n^2 (H_n + H_{n-1})^2 x'''/(6 (2 H_n + H_{n-1})),   x'''/6 by differences

    Parameters
    ----------
    time, values : ndarray, shape (n,)
        [s], and x.
    """
    slope = np.diff(values) / np.diff(time)
    curvature = np.diff(slope) / (time[2:] - time[:-2])
    third = np.diff(curvature) / (time[3:] - time[:-3])
    step, both = time[3:] - time[2:-1], time[3:] - time[1:-2]
    return (step * both) ** 2 * third / (step + both)  # Eq. (X26)


class Resolution(NamedTuple):
    """Resolution of a film by its grid.

    Parameters
    ----------
    thickness, film : float
        Minimum film thickness of the recorded instants, and its uncertainty [m].
    pressure : float
        Relative uncertainty of the maximum pressure [-].
    load : float
        Sum of 1/n^2 over both directions, n the cells that carry the load [-].
    shear : float
        Relative change of the sum of film fraction over thickness if every second cell is left out,
        around and along, of the recorded instants [-].
    cells : int
        Number of cells.
    length : float
        Length of the skirt [m].
    narrow : bool
        Whether the pressure peak has at most `NARROW_PEAK` cells.
    """

    thickness: float
    film: float
    pressure: float
    load: float
    shear: float
    cells: int
    length: float
    narrow: bool


def resolution(
    results: Results, film: str, cell_of_film: tuple[int, int] | None = None
) -> Resolution | None:
    """Return the resolution of a film in the last period, None if its fields are not recorded.

    `cell_of_film` is the cell with the thinnest film. Default: that of the recorded gap.
    """
    ports = f"{film}.pressure", gap_port(results, film)
    length = parameter(results, film, "skirt_length", "m")
    if not length or not {*ports} <= {*results.recorded}:
        return None
    pressure, gap = (results.dataset(port)[:] for port in ports)
    if pressure.shape != gap.shape or not pressure.max() > 0.0:
        return None
    exists = results.existing_cells(ports[1])
    gap = gap if exists is None else np.where(exists, gap, np.inf)
    low = np.unravel_index(gap.argmin(), gap.shape)
    if cell_of_film is not None:
        low = (gap[(slice(None), *cell_of_film)].argmin(), *cell_of_film)
    high = np.unravel_index(pressure.argmax(), pressure.shape)
    instant, *cell = high
    thickness, top = float(gap[low]), float(pressure[high])
    if not thickness > 0.0:
        return None
    bend = sum(max(np.mean(near) / thickness - 1.0, 0.0) for near in neighbours(gap, low))
    steep = sum(
        np.mean([min(top / max(value, 1e-9 * top) - 1.0, MOST_STEEPNESS) for value in near])
        for near in neighbours(pressure, high)
    )
    return Resolution(
        thickness=thickness,
        film=FILM_FACTOR * float(bend) * thickness,
        pressure=PRESSURE_FACTOR * float(min(steep, MOST_STEEPNESS)),  # Eq. (X49)
        load=carrying(pressure),
        shear=thinned(sheared(results, film, gap)),
        cells=pressure[0].size,
        length=length,
        narrow=min(peak_width(pressure[instant], cell)) <= NARROW_PEAK,
    )


def neighbours(field: np.ndarray, index: tuple[Any, ...]) -> Iterator[list[float]]:
    """Yield the values next to a cell around (a ring), and along; finite ones only."""
    k, i, j = index
    around, along = field.shape[1:]
    cells = (
        [(k, (i - 1) % around, j), (k, (i + 1) % around, j)],
        [(k, i, n) for n in (j - 1, j + 1) if 0 <= n < along],
    )
    for pair in cells:
        if values := [float(field[cell]) for cell in pair if np.isfinite(field[cell])]:
            yield values


def sheared(results: Results, film: str, gap: np.ndarray) -> np.ndarray:
    """Return film fraction over thickness, 0 without film; the fraction is 1 if not recorded."""
    port = f"{film}.film_fraction"
    fraction = results.dataset(port)[:] if port in results.recorded else np.ones_like(gap)
    return np.clip(fraction, 0.0, 1.0) / gap


def thinned(field: np.ndarray) -> float:
    """Return the relative change of the sum of a field if every second cell is left out.

    It is the sum over both directions of the mean change over the instants.
    """
    whole = field.mean(axis=(1, 2))
    change = sum(
        np.abs(half.mean(axis=(1, 2)) - whole).sum() for half in (field[:, ::2], field[:, :, ::2])
    )
    return float(change / whole.sum()) if whole.sum() > 0.0 else 0.0


def carrying(pressure: np.ndarray) -> float:
    """Return the mean of the sum of 1/n^2 over instants, weighted by the load.

    n is the number of cells in a direction that carry the load: (sum p)^2 / sum p^2.
    """
    above = np.maximum(pressure - pressure.min(axis=(1, 2), keepdims=True), 0.0)
    load = above.sum(axis=(1, 2))
    if not load.max() > 0.0:
        return 0.0
    lines = above.sum(axis=2), above.sum(axis=1)
    sums = sum((line**2).sum(axis=1) ** 2 for line in lines)
    return float((sums / np.maximum(load, 1e-12 * load.max()) ** 4 * load).sum() / load.sum())


Rule = Callable[[float, Resolution], float]
"""Function of the value of a figure and of the resolution of its film that returns u_grid."""
GRID: dict[str, Rule] = {
    "minimum_film_thickness_m": lambda value, film: film.film,
    "maximum_pressure_pa": lambda value, film: value * film.pressure,
    "mean_friction_power_w": lambda value, film: value * FRICTION_FACTOR * film.shear,
    "friction_mean_effective_pressure_pa": lambda value, film: value * FRICTION_FACTOR * film.shear,
    "contact_share": lambda value, film: value * 3.0 * film.film / film.thickness,
    "contact_area": lambda value, film: value * 3.0 * film.film / film.thickness,
    "oil_throughput_m3": lambda value, film: value * OIL_FACTOR / film.cells,
    "side_force_n": lambda value, film: value * SIDE_FACTOR,
    "slap_energy_j": lambda value, film: value * SLAP_FACTOR * film.load,
    "range_lateral_displacement_m": lambda value, film: film.film,
    "minimum_lateral_displacement_m": lambda value, film: film.film / 2.0,
    "maximum_lateral_displacement_m": lambda value, film: film.film / 2.0,
    "largest_lateral_displacement_m": lambda value, film: film.film / 2.0,
    "range_rocking_angle_rad": lambda value, film: 4.0 * film.film / film.length,
    "minimum_rocking_angle_rad": lambda value, film: 2.0 * film.film / film.length,
    "maximum_rocking_angle_rad": lambda value, film: 2.0 * film.film / film.length,
    "largest_rocking_angle_rad": lambda value, film: 2.0 * film.film / film.length,
}
"""Key of a measure -> rule of its uncertainty from the grid."""


class Indicator:
    """Estimates of the parts of uncertainties of one run, from its last period.

    Parameters
    ----------
    results : Results
        Results of the last period.
    films : list of str
    cells : dict of str to (int, int), optional
        Cell with the thinnest film, by film.
    """

    def __init__(
        self,
        results: Results,
        films: list[str],
        cells: Mapping[str, tuple[int, int]] = MappingProxyType({}),
    ):
        self.results = results
        known = {film: resolution(results, film, cells.get(film)) for film in films}
        self.films = {film: one for film, one in known.items() if one}
        self.body = {film: film_body(results, film) for film in films}
        self.time = results.whole.time
        self.share = (results.summary or {}).get("truncation_error_film")

    def film_of(self, owner: str) -> Resolution | None:
        """Return the film of a participant with the largest uncertainty, of all films for ""."""
        own = [
            one
            for film, one in self.films.items()
            if owner in ("", film) or owner == self.body[film]
        ]
        return max(own, key=lambda one: one.film / one.thickness, default=None)

    def parts(self, measure: Any) -> dict[str, float]:
        """Return the known parts of the uncertainty of a measure by cause."""
        parts: dict[str, float] = {}
        film = self.film_of(measure.owner)
        if film and (rule := GRID.get(measure.key)):
            scale = measure.value if measure.scale is None else measure.scale
            parts["grid"] = rule(abs(scale), film)  # Eq. (X49)
        if measure.course:
            parts |= self._of_course(measure)
        if isinstance(self.share, float) and film:
            factor = 3.0 if measure.key == "maximum_pressure_pa" else 1.0
            size = film.thickness if measure.key.endswith("displacement_m") else measure.value
            parts["modes"] = factor * self.share * abs(size)  # Eq. (X52)
        return parts

    def _of_course(self, measure) -> dict[str, float]:
        """Return the parts of step and period."""
        course, time = measure.course, self.time
        count = len(self.results.time)
        if count < 4:
            return {}
        own, rows = slice(len(time) - count, None), time[-count:]
        values = course.values[own]
        every = slice((count - 1) % 2, None, 2)
        figure = course.reduce(rows, values)
        local = np.abs(bdf2_error(rows, values))
        if measure.row is not None:
            at = (
                max(0, measure.row - 3 - STEPS_NEAR_EXTREME),
                max(1, measure.row - 2 + STEPS_NEAR_EXTREME),
            )
            spread = float(local[slice(*at)].max(initial=0.0))
        else:
            spread = 0.0
        # Eq. (X50)
        parts = {"step": max(abs(figure - course.reduce(rows[every], values[every])), spread)}
        first = self._previous(rows)
        if first is not None:
            before = slice(first, len(time) - count + 1)
            # Eq. (X51)
            parts["period"] = abs(figure - course.reduce(time[before], course.values[before]))
        return parts

    def _previous(self, rows) -> int | None:
        """Return the first row of the previous period, None if it is not whole."""
        length = self.results.period
        begin = rows[0] - length
        if not length or begin < self.time[0] - ROW_TOLERANCE * length:
            return None
        return int(np.searchsorted(self.time, begin - ROW_TOLERANCE * length))


def reason(results: Results, films: list[str]) -> str:
    """Return why the grid's part of an uncertainty is unknown."""
    ports = [port for film in films for port in (f"{film}.pressure", gap_port(results, film))]
    lacking = [port for port in ports if port not in results.recorded]
    return f"record.fields lacks {' and '.join(lacking)}" if lacking else "no estimate of the grid"
