"""Impacts of a piston on the bore: kinetic energy lost, and motion of the edge that strikes."""

from typing import NamedTuple

import numpy as np

from ..results.file import Results

LEAST_PROMINENCE = 0.1
"""Minimum prominence of an energy peak that counts, relative to the largest energy [-]."""


class Impact(NamedTuple):
    """Loss of the piston's own kinetic energy to the next minimum.

    Parameters
    ----------
    row : int
        Macro step of the maximum before the impact.
    loss : float
        Energy lost [J].
    edge : str
        "lower" or "upper": the edge of the skirt that is faster at `row`.
    velocity : float
        Velocity of that edge, positive towards the thrust side [m/s].
    """

    row: int
    loss: float
    edge: str
    velocity: float

    @property
    def side(self) -> str:
        """Side that the edge strikes."""
        return "thrust" if self.velocity >= 0.0 else "anti-thrust"


def impacts(results: Results, body: str) -> list[Impact] | None:
    """Return the impacts of the piston of participant `body`, None if the run lacks its outputs.

    Eq. (X23):  loss = max E - min E,   E of Eq. (K27), between a peak and the following one
    """
    ports = [
        f"{body}.{name}"
        for name in ("piston_kinetic_energy", "lower_edge_velocity", "upper_edge_velocity")
    ]
    if not {*ports} <= {*results.ports}:
        return None
    energy, *edges = (results.series(port).values for port in ports)
    events = []
    for row, loss in losses(energy):
        speeds = [float(edge[row]) for edge in edges]
        faster = int(abs(speeds[1]) > abs(speeds[0]))
        events.append(Impact(row, loss, ("lower", "upper")[faster], speeds[faster]))
    return events


def prominent_peaks(values: np.ndarray, prominence: float) -> list[int]:
    """Return the positions of maxima by their prominence; a plateau has its middle.

    The prominence is the height above the higher one of the minima on both sides. A side ends at
    the next larger value. `scipy.signal.find_peaks` does the same, but takes a second to import.

    >>> prominent_peaks(np.array([0.0, 2.0, 1.5, 1.8, 0.0, 1.0, 1.0, 0.0]), 0.5)
    [1, 5]
    """
    first = np.flatnonzero(np.diff(values, prepend=np.nan))
    last = np.append(first[1:], len(values)) - 1
    level = values[first]  # of each run of equal values
    rises = np.diff(level) > 0.0
    peaks = []
    for k in np.flatnonzero(rises[:-1] & ~rises[1:]) + 1:
        larger = np.flatnonzero(level > level[k])
        middle = np.searchsorted(larger, k)
        begin = larger[middle - 1] + 1 if middle > 0 else 0
        end = larger[middle] if middle < len(larger) else len(level)
        base = max(level[begin : k + 1].min(), level[k:end].min())
        if level[k] - base >= prominence:
            peaks.append(int(first[k] + last[k]) // 2)
    return peaks


def losses(energy: np.ndarray) -> list[tuple[int, float]]:
    """Return the row of each peak of the kinetic energy, and the loss after it, Eq. (X23)."""
    peaks = prominent_peaks(energy, LEAST_PROMINENCE * energy.max(initial=0.0))
    ends = [*peaks[1:], len(energy)]
    # Eq. (X23)
    return [(row, float(energy[row] - energy[row:end].min())) for row, end in zip(peaks, ends)]
