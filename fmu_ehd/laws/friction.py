"""Axial force between skirt and bore, viscous and asperity part, and friction power.

A film has no mass, so its axial force on the skirt is the opposite of that on the bore. The bore is
straight, so its axial force is the shear stress on it. The skirt slides at V relative to the bore,
and the stresses on the skirt, positive towards the head, are

Eq. (F1):  tau_v = -(f c_v V - b_p dp/dy)
Eq. (F2):  tau_a = -tau_b V / sqrt(V^2 + v0^2)

The friction power is a sum over cells of area A:

Eq. (F3):  P = -sum A V (tau_v + tau_a)

tau_b is the boundary shear stress of `asperity`; c_v, b_p are those of `films` (smooth surfaces:
mu/h, h/2). f is the film fraction: in the cavitated part only the oil is sheared [Elrod1981]. With
`cavity_shear = full_film`, f = 1 there. dp/dy is the central difference of face pressures. The
pressure of a face is the mean of both cells, at an edge that of the edge, and at an opening that of
the opening. v0 smooths the step of Coulomb friction at rest, so that friction has a derivative.

The shear stress on the skirt is not used. It differs from Eq. (F1) by h dp/dy, and the pressure on
the slope of the skirt adds p dh/dy. The sum of both differences is d(p h)/dy. The total axial force
of the film on the skirt is therefore Eq. (F1) plus the force p h at both ends. p h is the force of
the pressure beyond an edge on the end of the film, whose area is that of the gap. A model that
applies this pressure to the total section of the bore, pi R^2, includes it already. If it were
included here, it would count twice, and it would have no reaction on the bore.

The equations are valid for a bore that is straight along y. Slopes of its profile and distortion,
about 1e-4, are omitted. Asperities press at right angles to the bore.

References
----------
[Elrod1981] H. G. Elrod, A cavitation algorithm, J. Lubr. Technol. 103 (1981) 350-354.
"""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compiled
from ..common.grid import Array, Field
from ..common.quantities import COUETTE, POISEUILLE, FilmSlopes, Quantities

# what shears of a cavitated film: its oil alone, or f = 1
CAVITY_SHEAR = ("film_fraction", "full_film")


class ShearConstants(NamedTuple):
    """Constants of the whole film.

    lower, upper : pressure at the axial edges [Pa]; dy : axial cell size [m];
    rounding_velocity : v0 [m/s], > 0.
    """

    lower: float
    upper: float
    dy: float
    rounding_velocity: float


class ShearInputs(NamedTuple):
    """Inputs of friction; arrays have the shape (n_c, n_a) if nothing else is stated.

    pressure : p [Pa]; shearing : share of the film that shears f [-]; velocity : V [m/s];
    film : ndarray, shape (6, n_c, n_a), quantities of `films`, of which c and b count;
    boundary_stress : tau_b [Pa]; area : lubricated area of each cell [m2];
    constants : ShearConstants.
    """

    pressure: Field
    shearing: Field
    velocity: Field
    film: Quantities
    boundary_stress: Field
    area: Field
    constants: ShearConstants


class FrictionPowers(NamedTuple):
    """Friction power, and the part of the asperities in it [W]."""

    friction: float
    boundary: float


class ShearForces(NamedTuple):
    """Axial forces on the skirt along +y [N], each ndarray of shape (n_c, n_a).

    The opposite forces act on the bore.

    viscous : of the film; boundary : of the asperities.
    """

    viscous: Array
    boundary: Array


class ShearSlopes(NamedTuple):
    """Derivatives of the axial force of each cell, each ndarray of shape (n_c, n_a).

    film : to film thickness [N/m]; velocity : to sliding velocity [N s/m]; shearing : to the
    shearing share [N]; gradient : to the pressure gradient [N m/Pa]; pressure : to the cell's own
    pressure, beyond the gradient [N/Pa].
    """

    film: Field
    velocity: Field
    shearing: Field
    gradient: Field
    pressure: Field


class ForceSlopes(NamedTuple):
    """Derivatives of both nodal forces without contact, the same in every direction.

    Arrays have the shape (n_c, n_a).

    shear : ShearSlopes;
    area : lubricated area [m2];
    pressure_share, fraction_share : derivatives of pressure and film fraction to the signed
    unknown;
    dy : axial cell size [m].
    """

    shear: ShearSlopes
    area: Field
    pressure_share: Field
    fraction_share: Field
    dy: float


@compiled(forceinline=True)
def _gradients(pressure, area, lower, upper, dy, out):
    """Return the axial pressure gradients of a row of cells from the pressures on both faces."""
    last = pressure.size - 1
    half = 0.5 / dy
    for j in range(1, last):
        out[j] = half * (pressure[j + 1] - pressure[j - 1])
    if last == 0:
        out[0] = (upper - lower) / dy
    else:
        out[0] = (0.5 * (pressure[0] + pressure[1]) - lower) / dy
        out[last] = (upper - 0.5 * (pressure[last - 1] + pressure[last])) / dy
    for j in range(last):
        # an opening's pressure reaches to the face
        if area[j] == 0.0:
            out[j + 1] += half * (pressure[j + 1] - pressure[j])
        elif area[j + 1] == 0.0:
            out[j] += half * (pressure[j + 1] - pressure[j])


@compiled
def gradients(pressure: Array, area: Array, lower: float, upper: float, dy: float):
    """Return the axial pressure gradient of each cell from the pressures on its two faces.

    Parameters
    ----------
    pressure, area : ndarray, shape (n_c, n_a)
        [Pa]; lubricated area, 0 in an opening, whose pressure reaches to its face [m2].
    lower, upper, dy : float
        As in `ShearConstants`.

    Returns
    -------
    ndarray, shape (n_c, n_a)
        [Pa/m].
    """
    gradient = np.empty(pressure.shape)
    for i in range(len(pressure)):
        _gradients(pressure[i], area[i], lower, upper, dy, gradient[i])
    return gradient


@compiled
def boundary_force(inputs: ShearInputs, turning: Array):
    """Return the axial asperity force of each cell, Eq. (F2), or Eq. (F7) of `circumferential`.

    Parameters
    ----------
    inputs : ShearInputs
    turning : ndarray, shape (n_c, n_a)
        W [m/s], 0 on a skirt.
    """
    n_c, n_a = turning.shape
    rounding = inputs.constants.rounding_velocity
    force = np.empty((n_c, n_a))
    for i in range(n_c):
        for j in range(n_a):
            v = inputs.velocity[i, j]
            w = turning[i, j]
            speed = np.sqrt(v * v + w * w + rounding * rounding)
            # Eq. (F2), Eq. (F7)
            force[i, j] = -inputs.area[i, j] * inputs.boundary_stress[i, j] * v / speed
    return force


@compiled
def viscous_force(inputs: ShearInputs):
    """Return the viscous force of each cell, Eq. (F1)."""
    pressure, shearing, velocity, film, _, area, constants = inputs
    lower, upper, dy, _ = constants
    n_c, n_a = pressure.shape
    viscous = np.empty((n_c, n_a))
    gradient = np.empty(n_a)
    for i in range(n_c):
        _gradients(pressure[i], area[i], lower, upper, dy, gradient)
        for j in range(n_a):
            v = velocity[i, j]
            f = shearing[i, j]
            a = area[i, j]
            c = film[COUETTE, i, j]
            flow = film[POISEUILLE, i, j] * gradient[j]
            viscous[i, j] = -a * (f * c * v - flow)  # Eq. (F1)
    return viscous


@compiled
def shear_slopes(inputs: ShearInputs, turning: Array, film_slopes: FilmSlopes, by_pressure: Array):
    """Return the derivatives of the total axial force of each cell, Eqs. (F1), (F2).

    The boundary stress is constant.

    Parameters
    ----------
    inputs : ShearInputs
        As in `viscous_force`.
    turning : ndarray, shape (n_c, n_a)
        W [m/s], 0 on a skirt.
    film_slopes : quantities.FilmSlopes
        Derivatives of `inputs.film`.
    by_pressure : ndarray, shape (n_c, n_a)
        Part of `ShearSlopes.pressure` that exists next to openings too.

    Returns
    -------
    ShearSlopes
    """
    pressure, shearing, velocity, film, boundary_stress, area, constants = inputs
    lower, upper, dy, rounding = constants
    by_film, by_velocity = film_slopes
    n_c, n_a = pressure.shape
    to_film = np.empty((n_c, n_a))
    to_velocity = np.empty((n_c, n_a))
    to_shearing = np.empty((n_c, n_a))
    to_gradient = np.empty((n_c, n_a))
    to_pressure = by_pressure.copy()
    half = 0.5 / dy
    gradient = np.empty(n_a)
    for i in range(n_c):
        _gradients(pressure[i], area[i], lower, upper, dy, gradient)
        for j in range(n_a):
            v = velocity[i, j]
            f = shearing[i, j]
            c = film[COUETTE, i, j]
            a = -area[i, j]
            w = turning[i, j]
            square = v * v + w * w + rounding * rounding
            direction = v / np.sqrt(square)
            to_film[i, j] = a * (
                f * v * by_film[COUETTE, i, j] - by_film[POISEUILLE, i, j] * gradient[j]
            )
            to_velocity[i, j] = a * (
                f * c + boundary_stress[i, j] * (1.0 - direction * direction) / np.sqrt(square)
            )
            if by_velocity.shape[0] > 0:
                to_velocity[i, j] += a * (
                    f * v * by_velocity[COUETTE, i, j] - by_velocity[POISEUILLE, i, j] * gradient[j]
                )
            to_shearing[i, j] = a * c * v
            to_gradient[i, j] = -a * film[POISEUILLE, i, j]
        for j in range(n_a - 1):
            # next to openings, whose pressure is constant
            if area[i, j] == 0.0:
                to_pressure[i, j + 1] += to_gradient[i, j + 1] * half
            elif area[i, j + 1] == 0.0:
                to_pressure[i, j] -= to_gradient[i, j] * half
    return ShearSlopes(to_film, to_velocity, to_shearing, to_gradient, to_pressure)


@compiled
def force_changes(
    slopes: ForceSlopes,
    dfilm: Array,
    dvelocity: Array,
    dunknown: Array,
    normal: Array,
    shear: Array,
):
    """Compute the changes of both nodal forces without contact.

    Parameters
    ----------
    slopes : ForceSlopes
    dfilm, dvelocity, dunknown : ndarray, shape (m, n_c, n_a)
        [m], [m/s], [Pa] or [-].
    normal, shear : ndarray, shape (m, n_c, n_a)
        Overwritten: changes of pressure and friction force [N].
    """
    by, area, pressure_share, fraction_share, dy = slopes
    by_film, by_velocity, by_shearing, by_gradient, by_pressure = by
    m, n_c, n_a = dfilm.shape
    p = np.empty(n_a)
    half = 0.5 / dy
    last = n_a - 1
    for i in range(n_c):
        # the factors of a row remain in the processor's cache for all directions
        for q in range(m):
            for j in range(n_a):
                p[j] = pressure_share[i, j] * dunknown[q, i, j]
            for j in range(n_a):
                normal[q, i, j] = area[i, j] * p[j]
            for j in range(n_a):
                shear[q, i, j] = (
                    by_film[i, j] * dfilm[q, i, j]
                    + by_velocity[i, j] * dvelocity[q, i, j]
                    + by_shearing[i, j] * fraction_share[i, j] * dunknown[q, i, j]
                    + by_pressure[i, j] * p[j]
                )
            for j in range(1, last):
                shear[q, i, j] += by_gradient[i, j] * half * (p[j + 1] - p[j - 1])
            if n_a > 1:
                shear[q, i, 0] += by_gradient[i, 0] * half * (p[0] + p[1])
                shear[q, i, last] -= by_gradient[i, last] * half * (p[last] + p[last - 1])
