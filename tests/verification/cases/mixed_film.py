"""What `monolithic` adds for a mixed film on scarce oil: asperity contact, and oil on the bore.

It shares no line with `fmu_ehd`. The gap of rigid bodies is a formula, so contact is evaluated at
points of each cell, not interpolated between cells. The oil on the bore is a balance by backward
Euler in the position that the crank prescribes.
"""

from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

REACH = 7.0
"""Separation over roughness beyond which asperities do not touch: F_5/2 is 1e-13 of that at 0."""
POINTS = 4
"""Gauss points of a cell in each direction."""


class Roughness(NamedTuple):
    """Rough surface of Greenwood and Tripp, and the boundary friction of its asperities.

    Fields: rms [m], eta beta_a sigma [-], sigma/beta_a [-], E* [Pa], coefficient of boundary
    friction [-], and the velocity that rounds the friction at rest [m/s].
    """

    roughness_rms: float
    asperity_product: float
    asperity_slope: float
    contact_modulus: float
    boundary_friction_coefficient: float
    friction_rounding_velocity: float


class Contact(NamedTuple):
    """Contact pressure of the cells (n,) [Pa] and its slopes.

    The slopes are against x_A and the rocking angle (n, 2), and against the deflection (n,).
    """

    pressure: np.ndarray
    by_motion: np.ndarray
    by_deflection: np.ndarray


def height_integral(order: float, separation: np.ndarray) -> np.ndarray:
    """Return F_n by Gauss-Legendre points of t = sqrt(s - Lambda).

    Eq. (Z8):  F_n(Lambda) = (2/pi)^(1/2) int_0^inf t^(2n+1) exp(-(Lambda + t^2)^2/2) dt
    """
    t, weight = np.polynomial.legendre.leggauss(80)
    t = 2.0 * (t + 1.0)  # to t = 4: exp(-128) at Lambda = 0
    values = t ** (2 * order + 1) * np.exp(-((separation[:, None] + t**2) ** 2) / 2)
    return np.sqrt(2 / np.pi) * (values @ (2.0 * weight))  # Eq. (Z8)


class Asperities:
    """Contact of a cell as the mean over its points.

    Parameters
    ----------
    roughness : Roughness
    gap : ndarray, shape (n, points)
        Of the undeformed bodies at rest [m].
    by_motion : ndarray, shape (n, points, 2)
        How x_A and the rocking angle change it.
    weight : ndarray, shape (points,)
    """

    def __init__(self, roughness, gap, by_motion, weight):
        self.roughness = roughness
        self.gap = gap
        self.by_motion = by_motion
        self.weight = weight
        separation = np.linspace(-2.0, REACH, 1801)
        r = roughness
        scale = 16 * np.sqrt(2) * np.pi / 15 * r.asperity_product**2
        scale *= np.sqrt(r.asperity_slope) * r.contact_modulus
        self.law = CubicSpline(separation, scale * height_integral(2.5, separation))

    def contact(self, position, deflection) -> Contact:
        """Contact at a position; deflection: ndarray, shape (n, points), or 0 [m]."""
        gap = self.gap + self.by_motion @ position + deflection
        reach = REACH * self.roughness.roughness_rms
        cells = np.flatnonzero(gap.min(axis=1) < reach)
        separation = np.minimum(gap[cells], reach) / self.roughness.roughness_rms
        by_gap = self.law(separation, 1) / self.roughness.roughness_rms * self.weight
        values = np.zeros((len(gap), 4))
        values[cells, 0] = self.law(separation) @ self.weight
        values[cells, 1:3] = np.einsum("np,npk->nk", by_gap, self.by_motion[cells])
        values[cells, 3] = by_gap.sum(axis=1)
        return Contact(values[:, 0], values[:, 1:3], values[:, 3])


class Supply(NamedTuple):
    """Oil outside the film.

    The layers [m] are the one that the ring leaves above the skirt, and the initial and the largest
    one below it. `oil_splash` is in [m/s]. An edge can push `chamfer_capacity` [m2] along.
    """

    oil_ring_layer: float
    initial_oil_layer: float
    largest_oil_layer: float
    oil_splash: float
    chamfer_capacity: float


LOWER, UPPER = 0, 1


class BoreOil:
    """Layer below the skirt, and what the two edges push along; the skirt starts at its highest.

    Eq. (Z9):  R' = lambda |V| - q   covering,   R' = q - min(R/dt + q, |V| h)   uncovering

    R oil at an edge per width [m2], q [m2/s] into the film or out of it, lambda layer on the bore,
    h gap at the edge [m]. What the second one takes stays on the bore. Above the skirt lambda is
    the ring's.

    Parameters
    ----------
    supply : Supply
    around : int
    size, depth : float
        Length of a cell; lowest position of the edge below its start [m].
    """

    def __init__(self, supply: Supply, around: int, size: float, depth: float):
        self.supply = supply
        self.size = size
        self.ends = size * np.arange(1, int(np.ceil(depth / size)) + 2)
        self.layer = np.full((around, len(self.ends)), supply.initial_oil_layer)
        self.pushed = np.zeros((2, around))

    def bare(self, depth: float) -> np.ndarray:
        """Share of the cells below an edge at a depth [-]."""
        return np.clip((self.ends - depth) / self.size, 0.0, 1.0)

    def available(self, depth: float, new_depth: float, step: float) -> np.ndarray:
        """Splash, then take up what the edges cover; return what can go into the film [m2]."""
        bare = self.bare(depth)
        growth = self.supply.oil_splash * step * (bare > 0)
        self.layer = np.maximum(
            self.layer, np.minimum(self.layer + growth, self.supply.largest_oil_layer)
        )
        down = new_depth - depth
        covered = np.maximum(bare - self.bare(new_depth), 0.0) * self.size
        self.pushed[LOWER] += self.layer @ covered
        self.pushed[UPPER] += self.supply.oil_ring_layer * max(-down, 0.0)
        return self.pushed

    def left(self, depth: float, new_depth: float, inflow: np.ndarray, gap: np.ndarray) -> None:
        """Finish the step, Eq. (Z9); inflow over both edges [m2] and gap there [m], (2, around)."""
        self.pushed = np.maximum(self.pushed - inflow, 0.0)
        edge = LOWER if new_depth < depth else UPPER
        distance = abs(new_depth - depth)
        stays = np.minimum(self.pushed[edge], distance * gap[edge])  # Eq. (Z9)
        self.pushed[edge] -= stays
        if edge == LOWER and distance > 0:
            bare = self.bare(depth)
            uncovered = self.bare(new_depth) - bare
            more = (stays / distance)[:, None] * uncovered
            whole = np.maximum(bare + uncovered, 1e-12)
            self.layer = (self.layer * bare + more) / whole
        self.pushed = np.minimum(self.pushed, self.supply.chamfer_capacity)
