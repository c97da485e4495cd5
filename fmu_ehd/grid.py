"""The film grid and what holds at its edges."""

from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class Grid:
    """Cells on the developed surface, i circumferential and j axial.

    Parameters
    ----------
    shape : tuple of int
        (n_circumferential, n_axial).
    width, length : float
        Circumferential and axial extent of the whole grid [m].
    ring : bool
        True: i closes on itself. False: i ends at a first and a last edge.
    """

    shape: tuple
    width: float
    length: float
    ring: bool = True

    @property
    def spacing(self):
        """Cell size (circumferential, axial) [m]."""
        return self.width / self.shape[0], self.length / self.shape[1]

    @property
    def cell_area(self):
        """Area of a cell [m2]."""
        dx, dy = self.spacing
        return dx * dy


@dataclass(frozen=True)
class Edges:
    """Oil supply at the edges, in the order lower, upper, first, last (the last two unused on a
    ring).

    Parameters
    ----------
    pressure : ndarray, shape (4,)
        Pressure above cavitation pressure [Pa], >= 0.
    film_fraction : ndarray, shape (4,)
        Film fraction of the oil that sliding drags in [-], 0 to 1. An edge with less than 1 should
        have the cavitation pressure: the model knows no gas at another pressure inside the film.
    """

    pressure: np.ndarray = field(default_factory=lambda: np.zeros(4))
    film_fraction: np.ndarray = field(default_factory=lambda: np.ones(4))
