"""Axial shear force on the skirt: viscous and asperity part.

Eq. (F1):  tau_v = -mu f V / s - (s/2) dp/dy                 on the skirt, which slides at V relative to the bore
Eq. (F2):  tau_a = -mu_b p_a V / sqrt(V^2 + v0^2)

f is the film fraction: in the cavitated part only the oil shears [Elrod1981]. dp/dy is the central difference of face
pressures (mean of both cells, edge pressure at an edge). v0 rounds Coulomb's step at rest, so that friction has a derivative.
"""

import numpy as np
from numba import njit


@njit(cache=True, inline="always")
def _face_pressure(pressure, i, face, lower, upper):
    """Pressure on an axial face: the edge's, or the mean of both cells."""
    if face == 0:
        return lower
    if face == pressure.shape[1]:
        return upper
    return 0.5 * (pressure[i, face - 1] + pressure[i, face])


@njit(cache=True)
def shear_forces(pressure, fraction, stored, velocity, viscosity, lower, upper, dy,
                 asperity_pressure, boundary_coefficient, rounding_velocity, area):
    """Viscous and asperity shear force of each cell, Eqs. (F1), (F2).

    Parameters
    ----------
    pressure, fraction, stored, velocity : ndarray, shape (n_c, n_a)
        p [Pa], f [-], s [m], V [m/s].
    viscosity : float
        mu [Pa s].
    lower, upper : float
        Pressure at the axial edges [Pa].
    dy : float
        Axial cell size [m].
    asperity_pressure : ndarray, shape (n_c, n_a)
        p_a [Pa].
    boundary_coefficient : float
        mu_b [-].
    rounding_velocity : float
        v0 [m/s], > 0.
    area : float
        Cell area [m2].

    Returns
    -------
    viscous, boundary : ndarray, shape (n_c, n_a)
        Force on the skirt along +y [N].
    """
    n_c, n_a = pressure.shape
    viscous, boundary = np.empty((n_c, n_a)), np.empty((n_c, n_a))
    for i in range(n_c):
        for j in range(n_a):
            v, s = velocity[i, j], stored[i, j]
            gradient = (_face_pressure(pressure, i, j + 1, lower, upper) - _face_pressure(pressure, i, j, lower, upper)) / dy
            viscous[i, j] = -area * (viscosity * fraction[i, j] * v / s + 0.5 * s * gradient)  # Eq. (F1)
            speed = np.sqrt(v * v + rounding_velocity * rounding_velocity)
            boundary[i, j] = -area * boundary_coefficient * asperity_pressure[i, j] * v / speed  # Eq. (F2)
    return viscous, boundary


@njit(cache=True)
def shear_force_changes(pressure, fraction, stored, velocity, viscosity, lower, upper, dy,
                        asperity_pressure, boundary_coefficient, rounding_velocity, area,
                        dpressure, dfraction, dstored, dvelocity, dasperity_pressure):
    """Change of the total shear force of each cell, the derivative of Eqs. (F1), (F2).

    Parameters
    ----------
    pressure ... area
        As in `shear_forces`.
    dpressure, dfraction, dstored, dvelocity, dasperity_pressure : ndarray, shape (n_c, n_a)
        Changes of p, f, s, V, p_a.

    Returns
    -------
    ndarray, shape (n_c, n_a)
        [N].
    """
    n_c, n_a = pressure.shape
    force = np.empty((n_c, n_a))
    for i in range(n_c):
        for j in range(n_a):
            v, s, f = velocity[i, j], stored[i, j], fraction[i, j]
            gradient = (_face_pressure(pressure, i, j + 1, lower, upper) - _face_pressure(pressure, i, j, lower, upper)) / dy
            dgradient = (_face_pressure(dpressure, i, j + 1, 0.0, 0.0) - _face_pressure(dpressure, i, j, 0.0, 0.0)) / dy
            couette = viscosity * (dfraction[i, j] * v + f * dvelocity[i, j] - f * v * dstored[i, j] / s) / s
            square = v * v + rounding_velocity * rounding_velocity
            direction = v / np.sqrt(square)
            ddirection = dvelocity[i, j] * (1.0 - direction * direction) / np.sqrt(square)
            force[i, j] = -area * (couette + 0.5 * (s * dgradient + dstored[i, j] * gradient) + boundary_coefficient
                                   * (dasperity_pressure[i, j] * direction + asperity_pressure[i, j] * ddirection))
    return force
