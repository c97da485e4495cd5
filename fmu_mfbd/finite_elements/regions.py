"""Where a surface of a body lies that its mesh file does not name."""

from typing import NamedTuple

import numpy as np

LOOSE = 1e-3
"""How far, relative to its size, a corner may lie off a surface that is found by geometry."""


class Cylinder(NamedTuple):
    """A surface that is a cylinder about y, from a lower to an upper height [m]."""

    radius: float
    lower: float
    upper: float

    def holds(self, corner: np.ndarray) -> np.ndarray:
        """Which faces, given by their corners (t, corners, 3), belong to it."""
        slack = LOOSE * self.radius
        x, y, z = np.moveaxis(corner, -1, 0)
        near = np.abs(np.hypot(x, z) - self.radius) <= slack
        return (near & (y >= self.lower - slack) & (y <= self.upper + slack)).all(axis=1)


class Bore(NamedTuple):
    """A surface that is a cylinder about z of any length [m]."""

    radius: float

    def holds(self, corner: np.ndarray) -> np.ndarray:
        """Which faces, given by their corners (t, corners, 3), belong to it."""
        x, y, _ = np.moveaxis(corner, -1, 0)
        return (np.abs(np.hypot(x, y) - self.radius) <= LOOSE * self.radius).all(axis=1)


class Plane(NamedTuple):
    """A surface that is a plane across y at a height [m]."""

    height: float

    def holds(self, corner: np.ndarray) -> np.ndarray:
        """Which faces, given by their corners (t, corners, 3), belong to it."""
        y = corner[..., 1]
        return (np.abs(y - self.height) <= LOOSE * np.ptp(y)).all(axis=1)


Region = Cylinder | Bore | Plane
"""Where a surface lies that the file does not name, in this project's axes."""
