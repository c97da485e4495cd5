"""Scores of curves: run against run, cycle against cycle, run against a measured file."""

import re
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..case.contract import players
from ..fmi.errors import BadInput, collecting, file_fault, unknown
from ..fmi.quantities import to_si
from ..fmi.separated import read_rows
from .charts import NO_RUN, Chart, Corridor, Curve, Section
from .instants import CRANK_ANGLE
from .words import labelled, name_of, unit_shown

HEADER = re.compile(r"^\s*(?P<port>\w+\.\w+)(?:\s+(?P<bound>low|high))?\s*\[(?P<unit>.+)\]\s*$")

MOST_FAULTS = 5
"""Maximum number of faulty columns in a message."""
BOUNDS = ("low", "high")
"""Suffixes of the port in the headers of a measured band."""


class Score(NamedTuple):
    """Deviation of a curve from a reference: amplitude [-], rms [-], phase [unit of x]."""

    amplitude: float
    rms: float
    phase: float


class Row(NamedTuple):
    """Score of one run's curve.

    share : share of the measured points whose band it meets, or None.
    """

    run: str
    port: str
    score: Score
    share: float | None = None

    @property
    def name(self) -> str:
        """Name of the curve in words."""
        return name_of(self.port)


class Measured(NamedTuple):
    """Column of a measured file, in its own unit; low, high : measured band."""

    values: np.ndarray
    unit: str
    low: np.ndarray | None = None
    high: np.ndarray | None = None


def score(x: np.ndarray, y: np.ndarray, x_reference: np.ndarray, y_reference: np.ndarray) -> Score:
    """Return the deviation of a curve from a reference over their common range.

    Eq. (X1):  amplitude = range(y) / range(y_ref)
    Eq. (X2):  rms = sqrt(mean((y - y_ref)^2)) / range(y_ref)
    Eq. (X3):  phase = the shift d that minimises the mean of (y(x + d) - y_ref(x))^2, without the
               means, |d| <= a tenth of the length (positive: the curve lags behind its reference)

    Parameters
    ----------
    x, y, x_reference, y_reference : ndarray, shapes (n,), (n,), (m,), (m,)
        Both abscissae in the same unit and rising.

    Returns
    -------
    Score

    Raises
    ------
    BadInput
        If the curves overlap in fewer than three reference points, or the reference is constant.
    """
    inside = (x_reference >= x[0]) & (x_reference <= x[-1])
    grid = x_reference[inside]
    reference = y_reference[inside]
    if inside.sum() < 3 or not np.ptp(reference) > 0:
        raise BadInput(
            f"reference: expected three points that differ from {x[0]:g} to {x[-1]:g}, "
            f"got {inside.sum()} that vary by {np.ptp(reference) if inside.any() else 0:g}"
        )
    values = np.interp(grid, x, y)
    size = np.ptp(reference)
    return Score(
        amplitude=float(np.ptp(values) / size),  # Eq. (X1)
        rms=float(np.sqrt(np.mean((values - reference) ** 2)) / size),  # Eq. (X2)
        phase=_shift(x, y, grid, reference),
    )


def _shift(x, y, grid, reference):
    """Return the phase: the best of 401 shifts, refined by a parabola through its neighbours."""
    shifts = np.linspace(-0.1, 0.1, 401) * (grid[-1] - grid[0])

    def misfit(shift):
        known = (grid + shift >= x[0]) & (grid + shift <= x[-1])
        a = np.interp(grid[known] + shift, x, y)
        b = reference[known]
        return float(np.mean((a - a.mean() - b + b.mean()) ** 2))

    # Eq. (X3)
    misfits = np.array([misfit(shift) for shift in shifts])
    k = int(np.clip(misfits.argmin(), 1, len(shifts) - 2))
    left, middle, right = misfits[k - 1 : k + 2]
    bend = left - 2 * middle + right
    if not bend > 0:
        return float(shifts[k])
    return float(shifts[k] + 0.5 * (left - right) / bend * (shifts[1] - shifts[0]))


def read_measured(path: str | Path) -> dict[str, Measured]:
    """Return the columns of a measured CSV file whose header names ports with units.

    For example: bodies.crank_angle [deg],bodies.rocking_angle [mrad]
    Two more columns give a band: bodies.rocking_angle low [mrad],bodies.rocking_angle high [mrad]

    Returns
    -------
    dict of str to Measured
        By port. The first column is the abscissa.

    Raises
    ------
    BadInput
        With every faulty header and the first faulty row.
    """
    try:
        rows = read_rows(path)
    except (OSError, UnicodeDecodeError) as error:
        raise BadInput(file_fault(path, error)) from None
    head = rows[0][1] if rows else []
    heads = [HEADER.match(cell) for cell in head]
    if heads and not any(heads):
        got = f"got {head[0]!r} in the first of {len(heads)} columns"
        raise BadInput(f"{path}: expected a header 'participant.variable [unit]', {got}")
    faults = [
        f"{path}, column {k + 1}: expected 'participant.variable [unit]', got {head[k]!r}"
        for k, match in enumerate(heads)
        if not match
    ]
    if (more := len(faults) - MOST_FAULTS) > 0:
        got = f"got {more} further ones without a port"
        faults[MOST_FAULTS:] = [f"{path}: expected ports in all columns, {got}"]
    if faults or len(heads) < 2:
        got = len(heads) or "an empty file"
        raise BadInput(faults or f"{path}: expected a header of at least two columns, got {got}")
    values = np.array([_numbers(path, len(heads), *row) for row in rows[1:]])
    if not values.size:
        raise BadInput(f"{path}: expected rows of numbers, got none")
    if np.any(np.diff(values[:, 0]) <= 0):
        raise BadInput(f"{path}: expected rising numbers in the first column, got others")
    return _columns(path, [match for match in heads if match], values.T)


def _numbers(path, count, number, row):
    """Return the finite numbers of a row."""
    with suppress(ValueError):
        values = [float(cell) for cell in row]
        if len(values) == count and np.isfinite(values).all():
            return values
    raise BadInput(f"{path}, line {number}: expected {count} numbers, got {', '.join(row)!r}")


def _columns(path, heads, columns):
    """Return the columns by port, each with its band."""
    known = {(head["port"], head["bound"]): k for k, head in enumerate(heads)}
    by_port = {}
    faults = []
    for (port, bound), k in known.items():
        if bound:
            missing = [other for other in (None, *BOUNDS) if (port, other) not in known]
            faults += [
                f"{path}: expected a column '{f'{port} {other or str()}'.strip()}' "
                f"with '{port} {bound}', got none"
                for other in missing
            ]
            continue
        bounds = {other: known[port, other] for other in BOUNDS if (port, other) in known}
        faults += [
            f"{path}, {port} {other}: expected unit {heads[k]['unit']}, got {heads[n]['unit']}"
            for other, n in bounds.items()
            if heads[n]["unit"] != heads[k]["unit"]
        ]
        band = {other: columns[n] for other, n in bounds.items()}
        if len(band) == 2 and np.any(band["low"] > band["high"]):
            faults.append(f"{path}, {port} low: expected values up to {port} high, got higher ones")
        by_port[port] = Measured(columns[k], heads[k]["unit"], **band)
    if faults:
        raise BadInput(faults)
    return by_port


def share_within(x, y, x_measured, measured) -> float | None:
    """Return the share of the measured points at which a curve is inside the band.

    Points outside the range of the curve are ignored. Returns None without band or points. All
    values are in the measured units.
    """
    inside = (x_measured >= x[0]) & (x_measured <= x[-1])
    if measured.low is None or measured.high is None or not inside.any():
        return None
    values = np.interp(x_measured[inside], x, y)
    return float(np.mean((values >= measured.low[inside]) & (values <= measured.high[inside])))


def check_measured(runs, measured):
    """Raise `BadInput` with every measured column that a run lacks or that has another unit."""
    faults = []
    for port, column in measured.items():
        for label, results in runs.items():
            if port not in results.ports:
                faults.append(f"measured {label}: {unknown('variable', port, results.ports)}")
                continue
            with collecting(faults):
                _factor(column.unit, results.series(port).unit)
    if faults:
        raise BadInput(faults)


def outside_text(results, measured) -> str:
    """Return a warning of measured values beyond the ends of a run by 1e-3 of its range, or ""."""
    x_port, (x, x_unit, *_) = next(iter(measured.items()))
    curve_x, si_x, _ = results.series(x_port)
    ends = np.array([curve_x.min(), curve_x.max()]) / _factor(x_unit, si_x)
    count = int((np.abs(x - ends.mean()) > (0.5 + 1e-3) * np.ptp(ends)).sum())
    text = f"outside the run, {ends[0]:.6g} to {ends[1]:.6g} {x_unit}, and are ignored"
    return f"warning: {count} of {len(x)} measured values are {text}" if count else ""


def have_bands(measured) -> bool:
    """Return whether the measured curves have bands; raise `BadInput` if only some have one."""
    ports = [*measured][1:]
    bare = [port for port in ports if measured[port].low is None]
    if bare and len(bare) < len(ports):
        raise BadInput(
            f"measured {', '.join(bare)}: expected a band, as other curves of the file have one"
        )
    return not bare


def deviations(results, measured) -> np.ndarray:
    """Return the deviations of a run from all measured values, in standard deviations.

    The half-width of a band counts as two of them. Without a band, the range of the measured curve
    counts as one. Values outside the range of the run are omitted.

    Raises
    ------
    BadInput
        With every measured column that a run lacks or that has another unit.
    """
    check_measured({"run": results}, measured)
    (x_port, (x, x_unit, *_)), *columns = measured.items()
    curve_x, si_x, _ = results.series(x_port)
    curve_x = curve_x / _factor(x_unit, si_x)
    if np.any(np.diff(curve_x) < 0.0):
        raise BadInput(f"measured {x_port}: expected a first column that rises in the run")
    inside = (x >= curve_x[0]) & (x <= curve_x[-1])
    shares = []
    for port, column in columns:
        curve_y, si_y, _ = results.series(port)
        values = np.interp(x[inside], curve_x, curve_y / _factor(column.unit, si_y))
        spread = np.full(x.size, np.ptp(column.values) or 1.0)
        if column.low is not None and column.high is not None:
            spread = 0.25 * (column.high - column.low)
            if not np.all(spread > 0.0):
                raise BadInput(f"measured {port}: expected a band wider than 0, got one of 0")
        shares.append((values - column.values[inside]) / spread[inside])  # Eq. (V6)
    return np.concatenate(shares)


class Agreement(NamedTuple):
    """Charts of runs and measured values, and the scores of the curves; x_unit : of the phase."""

    section: Section
    rows: list[Row]
    x_unit: str

    @property
    def has_bands(self) -> bool:
        """True if the file has a band."""
        return any(row.share is not None for row in self.rows)


def agreement(runs, measured) -> Agreement:
    """Compare runs with a measured file; the charts have the measured units, one for each column.

    Raises
    ------
    BadInput
        With every measured column that a run lacks or that has another unit.
    """
    check_measured(runs, measured)
    (x_port, (x, x_unit, *_)), *columns = measured.items()
    turns = x_unit == "deg" and all(_turns(results, x_port) for results in runs.values())
    x_label = labelled(name_of(x_port), unit_shown(x_unit, None))
    charts, rows = [], []
    for port, column in columns:
        curves = []
        for k, (label, results) in enumerate(runs.items()):
            curve_x, si_x, _ = results.series(x_port)
            curve_y, si_y, _ = results.series(port)
            curve = curve_x / _factor(x_unit, si_x), curve_y / _factor(column.unit, si_y)
            scored = score(*curve, x, column.values)
            rows.append(Row(label, port, scored, share_within(*curve, x, column)))
            curves.append(Curve(label, k, *curve))
        curves.append(Curve("measured", NO_RUN, x, column.values, points=True))
        y_label = labelled("", unit_shown(column.unit, None)).strip()
        band = None
        if column.low is not None and column.high is not None:
            band = Corridor(x, column.low, column.high, "measured band")
        title = name_of(port).capitalize()
        charts.append(Chart(title, x_label, y_label, curves, cursor=turns, corridor=band))
    return Agreement(Section("Against measured values", charts), rows, x_unit)


def _turns(results, port):
    """Return whether an output is the crank angle of the page's cursor."""
    bodies = players(results.case, "bodies")
    return bool(bodies) and port == f"{bodies[0]}.{CRANK_ANGLE}"


def _factor(unit, si):
    try:
        return to_si(f"1 {unit}", si)
    except ValueError as error:
        raise BadInput(f"measured: {error}") from None
