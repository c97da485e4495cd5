"""Shapes of a pin's axis: a hollow cylinder that tilts and bends as a free beam.

The beam is Timoshenko's: a piston pin is two to three diameters long, and its shear deflection is
as large as that by bending. The shapes are orthogonal to each other and to the pin's shift, and are
the same in both directions across the axis. The model neglects oval sections and the gyroscopic
moments of the pin.

References
----------
[Cowper1966], [Timoshenko1921]
"""

from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre

from .arrays import Vector

DEGREE = 30
"""Degree of the polynomials for deflection and rotation of the sections."""

MOST = 11
"""Maximum number of shapes: tilt and ten bending shapes."""


class HollowPin(NamedTuple):
    """Cylinder with a bore.

    Parameters
    ----------
    mass : float
        [kg]
    length, radius, bore_radius : float
        [m]; the radius of the bore is smaller than that of the pin, 0 for a solid pin.
    young, poisson : float
        [Pa], [-]
    """

    mass: float
    length: float
    radius: float
    bore_radius: float
    young: float
    poisson: float

    def spin_inertia(self) -> float:
        """Return the moment of inertia about the pin's axis [kg m2].

        Eq. (J26):  J = m (R^2 + r^2)/2
        """
        return self.mass * (self.radius**2 + self.bore_radius**2) / 2  # Eq. (J26)


class Section(NamedTuple):
    """Section of a beam.

    Parameters
    ----------
    shear : float
        kappa G A [N].
    bending : float
        E I [N m2].
    mass : float
        Mass per length [kg/m].
    turning : float
        Moment of inertia about a diameter per length [kg m].
    """

    shear: float
    bending: float
    mass: float
    turning: float


class AxisShapes(NamedTuple):
    """Shapes of a pin's axis, the same along x and y; without shapes it is parallel to its shells.

    The n shapes are mass-orthonormal, as all modes: coordinates s have the unit kg^1/2 m.

    Parameters
    ----------
    slope : ndarray, shape (n,)
        Tilt of the pin per s [kg^-1/2 m^-1].
    sag : ndarray, shape (n,)
        Displacement of the middle from the mean of both ends per s [kg^-1/2].
    """

    slope: Vector
    sag: Vector


class Beam(NamedTuple):
    """Undamped shapes of a pin.

    Parameters
    ----------
    pin : HollowPin
    omega : ndarray, shape (n,)
        Angular eigenfrequencies, 0 for tilt [rad/s].
    polynomials : ndarray, shape (degree + 1, n)
        Coefficients of Legendre polynomials of 2 z/L.
    """

    pin: HollowPin
    omega: np.ndarray
    polynomials: np.ndarray

    def at(self, z: np.ndarray) -> np.ndarray:
        """Return each shape at positions from the pin's middle [m], (len(z), n) [kg^-1/2]."""
        return legendre.legval(2 * z / self.pin.length, self.polynomials).T

    def shapes(self) -> AxisShapes:
        """Return tilt and sag of the shapes."""
        ends = self.pin.length / 2 * np.array([-1.0, 0.0, 1.0])
        low, middle, high = self.at(ends)
        slope = np.zeros(len(self.omega))
        slope[:1] = high[:1] * 2 / self.pin.length
        return AxisShapes(slope, middle - (low + high) / 2)


def section(pin: HollowPin) -> Section:
    """Return the section of a pin.

    Eq. (J27):  A = pi (R^2 - r^2),   I = pi (R^4 - r^4)/4,   G = E/(2 (1 + nu))
    Eq. (J28):  kappa = 6 (1 + nu) (1 + m^2)^2/((7 + 6 nu) (1 + m^2)^2 + (20 + 12 nu) m^2)
                m = r/R       share of a hollow circle that shears [Cowper1966]
    """
    # Eq. (J27)
    area = np.pi * (pin.radius**2 - pin.bore_radius**2)
    second = np.pi * (pin.radius**4 - pin.bore_radius**4) / 4
    rigidity = pin.young / (2 * (1 + pin.poisson))
    # Eq. (J28)
    m2 = (pin.bore_radius / pin.radius) ** 2
    whole = (1 + m2) ** 2
    nu = pin.poisson
    kappa = 6 * (1 + nu) * whole / ((7 + 6 * nu) * whole + (20 + 12 * nu) * m2)
    by_length = pin.mass / pin.length
    return Section(
        shear=float(kappa * rigidity * area),
        bending=float(pin.young * second),
        mass=by_length,
        turning=float(by_length * second / area),
    )


def free_beam(pin: HollowPin, n: int) -> Beam:
    """Return the first n shapes: tilt, then bending shapes by ascending frequency.

    Eq. (J29):  2 T = int (rho A w'^2 + rho I b'^2) dz
                2 V = int (kappa G A (dw/dz - b)^2 + E I (db/dz)^2) dz
                w, b: displacement of the axis and rotation of the section, Legendre polynomials
    Eq. (J30):  2 T = s'^2 of each;   tilt: w = s z (12/(m (L^2 + 12 I/A)))^1/2

    The ends are free, because no condition restricts w or b there. Shapes are orthogonal in T, also
    to the pin's shift.

    Parameters
    ----------
    pin : HollowPin
    n : int
        0 to `MOST`.

    References
    ----------
    [Timoshenko1921]. Checked against the frequencies of Euler's slender beam and against the
    frequency equation of Timoshenko's in tests/mfbd/test_pin_shapes.py.
    """
    of = section(pin)
    length = pin.length
    size = DEGREE + 1
    points, weights = legendre.leggauss(size)
    weights = weights * length / 2
    norm = np.sqrt((2 * np.arange(size) + 1) / length)
    value = legendre.legvander(points, DEGREE) * norm
    rate = legendre.legval(points, legendre.legder(np.diag(norm))).T * 2 / length
    # Eqs. (J29), (J30), each unknown by the root of its mass: int of the values' squares is 1
    sheared = np.hstack([rate / np.sqrt(of.mass), -value / np.sqrt(of.turning)])
    turned = np.hstack([np.zeros_like(rate), rate / np.sqrt(of.turning)])
    stiffness = of.shear * (sheared.T * weights) @ sheared
    stiffness += of.bending * (turned.T * weights) @ turned
    square, vectors = np.linalg.eigh(stiffness)
    # the first two are shift and tilt, at rest
    bending = slice(2, 2 + max(n - 1, 0))
    polynomials = norm[:, None] * vectors[:size, bending] / np.sqrt(of.mass)
    tilt = np.zeros((size, min(n, 1)))
    tilt[1:2] = 1 / np.sqrt(pin.mass / 3 + 4 * of.turning / length)
    both = np.hstack([tilt, polynomials])
    return Beam(
        pin,
        omega=np.concatenate([np.zeros(min(n, 1)), np.sqrt(square[bending])]),
        polynomials=both * np.where(both.sum(axis=0) < 0.0, -1.0, 1.0),
    )
