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

from ...master.fmi.compiled import compilable
from .arrays import Matrix, Vector
from .eigen import symmetric_eigen

DEGREE = 30
"""Degree of the polynomials for deflection and rotation of the sections."""

SIZE = DEGREE + 1
POINTS, WEIGHTS = legendre.leggauss(SIZE)
VALUE = np.ascontiguousarray(legendre.legvander(POINTS, DEGREE))
RATE = np.ascontiguousarray(legendre.legval(POINTS, legendre.legder(np.eye(SIZE))).T)
"""Rule of Gauss, and the polynomials and their derivatives at its points, (points, size)."""

MOST_SHAPES = 11
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
    omega: Vector
    polynomials: Matrix


@compilable
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
        shear=kappa * rigidity * area,
        bending=pin.young * second,
        mass=by_length,
        turning=by_length * second / area,
    )


@compilable
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
        0 to `MOST_SHAPES`.

    References
    ----------
    [Timoshenko1921]. Checked against the frequencies of Euler's slender beam and against the
    frequency equation of Timoshenko's in tests/mfbd/test_pin_shapes.py.
    """
    of, length = section(pin), pin.length
    norm = np.empty(SIZE)
    for k in range(SIZE):
        norm[k] = np.sqrt((2 * k + 1) / length)
    square, vectors = symmetric_eigen(_stiffness(of, length, norm))
    # the first two are shift and tilt, at rest
    out = Beam(pin, np.zeros(n), np.zeros((SIZE, n)))
    if n > 0:
        # Eq. (J30)
        out.polynomials[1, 0] = 1 / np.sqrt(pin.mass / 3 + 4 * of.turning / length)
    for j in range(1, n):
        out.omega[j] = np.sqrt(square[j + 1])
        total = 0.0
        for k in range(SIZE):
            out.polynomials[k, j] = norm[k] * vectors[k, j + 1] / np.sqrt(of.mass)
            total += out.polynomials[k, j]
        for k in range(SIZE if total < 0.0 else 0):
            out.polynomials[k, j] = -out.polynomials[k, j]
    return out


@compilable
def _stiffness(of, length, norm):
    """Return the stiffness for unknowns by the root of their mass, Eqs. (J29), (J30)."""
    shears, turns = np.zeros((SIZE, 2 * SIZE)), np.zeros((SIZE, 2 * SIZE))
    for q in range(SIZE):
        weight = np.sqrt(WEIGHTS[q] * length / 2)
        shear, bending = np.sqrt(of.shear) * weight, np.sqrt(of.bending) * weight
        for k in range(SIZE):
            value, rate = VALUE[q, k] * norm[k], RATE[q, k] * norm[k] * 2 / length
            # Eq. (J29)
            shears[q, k] = shear * rate / np.sqrt(of.mass)
            shears[q, SIZE + k] = -shear * value / np.sqrt(of.turning)
            turns[q, SIZE + k] = bending * rate / np.sqrt(of.turning)
    out = np.empty((2 * SIZE, 2 * SIZE))
    for i in range(2 * SIZE):
        for j in range(i + 1):
            total = 0.0
            for q in range(SIZE):
                total += shears[q, i] * shears[q, j] + turns[q, i] * turns[q, j]
            out[i, j], out[j, i] = total, total
    return out


@compilable
def beam_at(beam: Beam, z: np.ndarray) -> np.ndarray:
    """Return each shape at positions from the pin's middle [m], (len(z), n) [kg^-1/2]."""
    size, n = beam.polynomials.shape
    out = np.zeros((len(z), n))
    for i in range(len(z)):
        x = 2 * z[i] / beam.pin.length
        before, value = 0.0, 1.0
        for k in range(size):
            for j in range(n):
                out[i, j] += beam.polynomials[k, j] * value
            before, value = value, ((2 * k + 1) * x * value - k * before) / (k + 1)
    return out


@compilable
def beam_shapes(beam: Beam) -> AxisShapes:
    """Return tilt and sag of the shapes."""
    half, n = beam.pin.length / 2, len(beam.omega)
    ends = beam_at(beam, np.array((-half, 0.0, half)))
    out = AxisShapes(np.zeros(n), np.empty(n))
    for j in range(n):
        out.sag[j] = ends[1, j] - (ends[0, j] + ends[2, j]) / 2
    if n > 0:
        out.slope[0] = ends[2, 0] / half
    return out


@compilable
def spin_inertia(pin: HollowPin) -> float:
    """Return the moment of inertia about the pin's axis [kg m2].

    Eq. (J26):  J = m (R^2 + r^2)/2
    """
    return pin.mass * (pin.radius**2 + pin.bore_radius**2) / 2  # Eq. (J26)
