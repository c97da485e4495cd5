"""Contact of the top land of the piston with the bore.

References
----------
[Hunt1975] K. H. Hunt, F. R. E. Crossley, Coefficient of restitution interpreted as damping in
vibroimpact, J. Applied Mechanics 42 (1975) 440.
"""

from dataclasses import dataclass

import numpy as np

from ...master.fmi.compiled import compilable
from .element import ForceElement, PointForce, PointMotion, declared


@dataclass(frozen=True)
class LandParameters:
    """Parameters of a top land that may touch the bore, in SI."""

    land_stiffness: float = declared("N/m", 0.0, 0.0, 1e12, advanced=True)
    """Contact stiffness of the top land on the bore; 0: no contact."""
    land_damping: float = declared("s/m", 0.0, 0.0, 1e3, advanced=True)
    """Increase of the contact force of the top land per approach velocity."""
    land_clearance: float = declared("m", 0.25e-3, 0.0, 0.01, advanced=True)
    """Bore radius minus radius of the top land at the thrust line."""
    land_height: float = declared("m", 0.03, 0.0, 1.0, advanced=True)
    """Height of the top land above pin point A."""


@compilable
def land_force(p: LandParameters, at: PointMotion) -> PointForce:
    """Return the force of the bore on the land.

    Eq. (D66):  F = -k d (1 + c d') sign(x),   d = |x| - clearance > 0, 1 + c d' > 0 [Hunt1975]
    """
    side = np.sign(at.x)
    depth = abs(at.x) - p.land_clearance
    growth = 1 + p.land_damping * side * at.vx
    if depth <= 0.0 or growth <= 0.0:
        return PointForce(0.0, 0.0, 0.0)
    return PointForce(-p.land_stiffness * depth * growth * side, 0.0, 0.0)  # Eq. (D66)


@compilable
def land_change(p: LandParameters, at: PointMotion, by: PointMotion) -> PointForce:
    """Return the change of `land_force` with a small change of the motion."""
    side = np.sign(at.x)
    depth = abs(at.x) - p.land_clearance
    growth = 1 + p.land_damping * side * at.vx
    if depth <= 0.0 or growth <= 0.0:
        return PointForce(0.0, 0.0, 0.0)
    change = growth * by.x + depth * p.land_damping * by.vx
    return PointForce(-p.land_stiffness * change, 0.0, 0.0)


LAND_CONTACT = ForceElement(LandParameters, land_force, land_change, height="land_height")
