"""Elastic shell of a bearing under the forces of its film, without inertia.

Eq. (D52):  q_k = Q_k/omega_k^2,   u_e = sum_k Phi_ek q_k      Q of Eq. (G6)

A body that does not move holds the shell. The lowest mode of a bearing shell is far above the
frequencies of its load, so that each mode follows its force. The work of the film is then the
change of the elastic energy.
"""

from typing import Annotated, NamedTuple

import numpy as np

from ..geometry.pin import (
    PinForces,
    diameters,
    pin_surface,
    resultants_on,
    shell_modes,
    shell_pushes,
    yielded,
)
from ..reduction.reduced_body import ReducedShell


class SupportLoad(NamedTuple):
    """Load of a film on the support of its shell: unit and nominal value."""

    force_x: Annotated[float, "N", 1e3]
    """Force of the film on the support of the shell along x."""
    force_y: Annotated[float, "N", 1e3]
    """Force of the film on the support of the shell along y."""
    moment: Annotated[float, "N.m", 1.0]
    """Moment of the film on the support of the shell about +z."""


class LoadedShell:
    """Elastic shell under a film: its deflection and the load on its support.

    Parameters
    ----------
    reduced : ReducedShell
    """

    def __init__(self, reduced: ReducedShell):
        self.omega, self.outward, self.onward = reduced.omega, reduced.outward, reduced.onward
        around, along, _ = reduced.outward.shape
        modes = shell_modes(reduced.outward, reduced.onward)
        self.surface = pin_surface(reduced.radius, 0.0, (around, along), modes)
        self.stiffness = reduced.omega**2

    def coordinates(self, forces: PinForces) -> np.ndarray:
        """Return the modal coordinates under nodal forces, (k,) [kg^1/2 m]."""
        return shell_pushes(self.surface, forces)[0] / self.stiffness  # Eq. (D52)

    def deflection(self, coordinates: np.ndarray) -> np.ndarray:
        """Return the outward deflection of the bore, (c, a) [m]."""
        return yielded(self.surface, coordinates)

    def energy(self, coordinates: np.ndarray) -> float:
        """Return the elastic energy [J]."""
        return float(self.stiffness @ coordinates**2 / 2)

    def widening(self, coordinates: np.ndarray) -> tuple[float, float]:
        """Return the change of the diameter at mid-length along x and y [m], Eq. (H13)."""
        return diameters(self.deflection(coordinates))

    def on_support(self, forces: PinForces, coordinates: np.ndarray) -> SupportLoad:
        """Return the load on the support, opposite to that on the journal (Eqs. (G3), (G5))."""
        resultants = resultants_on(self.surface, forces, np.zeros(2), np.eye(2))
        moment = resultants.on_shell - shell_pushes(self.surface, forces)[1] @ coordinates
        x, y = resultants.force
        return SupportLoad(-x, -y, float(moment))
