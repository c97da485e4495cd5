"""Pressure peak: position around the skirt relative to the thrust line, and width in cells."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

LOADED_SHARE = 0.5
"""Fraction of a side's maximum pressure below which instants are ignored, an assumption."""
LEAST_DISTANCE = 15.0
"""Minimum distance [deg] of a peak that is not on the thrust line, an assumption. It exceeds one
cell of the coarsest usual grid (24 cells around)."""
LEAST_EXCESS = 0.15
"""Minimum excess of a peak over the pressure on the thrust line [-], an assumption."""


class SidePeak(NamedTuple):
    """Position of the pressure peak on one side of the skirt.

    Parameters
    ----------
    side : str
        Mark of the angular axis, e.g. "thrust".
    distance : float
        Angle between the mark's line and the highest pressure of all instants [deg].
    excess : float
        Relative excess of that pressure over the highest one on the line at that instant [-].
    share : float
        Fraction of the loaded instants whose peak is off the line and exceeds the pressure there by
        `LEAST_EXCESS` [-].
    instants : int
        Number of loaded instants.
    """

    side: str
    distance: float
    excess: float
    share: float
    instants: int


def side_peaks(axis, pressure: np.ndarray) -> list[SidePeak]:
    """Return the position of the pressure peak on each side that the angular axis marks.

    Eq. (X18):  excess = max_theta P(theta) / P(theta_line) - 1,   P(theta) = max over heights of p

    Parameters
    ----------
    axis : Axis
        Angular axis of a case, in degrees, with `marks`. A side reaches half-way to the next mark.
    pressure : ndarray, shape (instants, around, along)
        Recorded film pressure [Pa].

    Returns
    -------
    list of SidePeak
        One for each mark whose side carries pressure.
    """
    angle = np.asarray(axis.positions(pressure.shape[1]), dtype=float)
    low, high = axis.range
    turn = high - low
    lines = np.array([*axis.marks.values()])
    distance = np.abs((angle[:, None] - lines + turn / 2) % turn - turn / 2)
    around = pressure.max(axis=2)
    peaks = []
    for k, side in enumerate(axis.marks):
        mine = np.flatnonzero(distance.argmin(axis=1) == k)
        if peak := _side_peak(side, distance[mine, k], around[:, mine]):
            peaks.append(peak)
    return peaks


def _side_peak(side, distance, around):
    """Return the peak of one side.

    distance : from the line (n,) [deg]; around : pressures (instants, n) [Pa].
    """
    highest = around.max(axis=1)
    if not highest.max(initial=0.0) > 0.0:
        return None
    on_line = around[:, distance <= distance.min() + 1e-6].max(axis=1)
    excess = highest / np.maximum(on_line, 1e-12 * highest.max()) - 1.0  # Eq. (X18)
    off = distance[around.argmax(axis=1)]
    loaded = highest >= LOADED_SHARE * highest.max()
    counted = (off >= LEAST_DISTANCE) & (excess >= LEAST_EXCESS)
    top = int(highest.argmax())
    return SidePeak(
        side,
        float(off[top]),
        float(excess[top]),
        float(counted[loaded].mean()),
        int(loaded.sum()),
    )


class Widths(NamedTuple):
    """Width of a peak in cells."""

    around: int
    along: int


def peak_width(field: np.ndarray, index: Sequence[int]) -> Widths:
    """Return the width of a peak in cells, around (a ring) and along.

    The cells have at least half of the value at `index`.
    """
    i, j = index
    high = field >= field[i, j] / 2
    ring = np.roll(high[:, j], -i)
    line = high[i]
    around = len(ring) if ring.all() else run_length(ring) + run_length(ring[::-1])
    return Widths(around, run_length(line[j:]) + run_length(line[: j + 1][::-1]) - 1)


def run_length(flags: np.ndarray) -> int:
    """Return the number of true values before the first false one."""
    return len(flags) if flags.all() else int(np.argmin(flags))
