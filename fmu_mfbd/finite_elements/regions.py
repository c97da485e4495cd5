"""Regions of a body's surface that its mesh file does not name."""

from typing import NamedTuple

import numpy as np

SURFACE_TOLERANCE = 1e-3
"""Largest distance of a corner from a surface that is given by geometry, relative to its size."""


class Cylinder(NamedTuple):
    """Cylinder about y, from a lower to an upper height [m]."""

    radius: float
    lower: float
    upper: float

    def holds(self, corner: np.ndarray) -> np.ndarray:
        """Return which faces, given by corners (t, corners, 3), belong to the surface."""
        slack = SURFACE_TOLERANCE * self.radius
        x, y, z = np.moveaxis(corner, -1, 0)
        near = np.abs(np.hypot(x, z) - self.radius) <= slack
        return (near & (y >= self.lower - slack) & (y <= self.upper + slack)).all(axis=1)


class Bore(NamedTuple):
    """Cylinder about z of any length [m]."""

    radius: float

    def holds(self, corner: np.ndarray) -> np.ndarray:
        """Return which faces, given by corners (t, corners, 3), belong to the surface."""
        x, y, _ = np.moveaxis(corner, -1, 0)
        return (np.abs(np.hypot(x, y) - self.radius) <= SURFACE_TOLERANCE * self.radius).all(axis=1)


class Plane(NamedTuple):
    """Plane perpendicular to y at a height [m]."""

    height: float

    def holds(self, corner: np.ndarray) -> np.ndarray:
        """Return which faces, given by corners (t, corners, 3), belong to the surface."""
        y = corner[..., 1]
        return (np.abs(y - self.height) <= SURFACE_TOLERANCE * np.ptp(y)).all(axis=1)


Region = Cylinder | Bore | Plane
"""Region of a surface in this project's axes."""
