"""Axial shear force on the skirt: viscous and asperity part, and what sliding costs.

Eq. (F1):  tau_v = -f (c - d) V - b dp/dy                    on the skirt, which slides at V relative to the bore
Eq. (F2):  tau_a = -tau_b V / sqrt(V^2 + v0^2)
Eq. (F3):  P = sum A V [f (c + d) V - b dp/dy - tau_a]       shear of the film on the bore x sliding velocity

tau_b is the boundary shear stress of `asperity`; c, d, b are those of `films.FlowFilm` (smooth surfaces: mu/h, 0, h/2).
f is the film fraction: in the cavitated part only the oil shears [Elrod1981]; with `cavity_shear = full_film` f = 1 there.
dp/dy is the central difference of face pressures (mean of both cells, edge pressure at an edge). v0 rounds Coulomb's step at
rest, so that friction has a derivative.

The shear stresses on skirt and bore differ by 2 b dp/dy: the axial part of the pressure on the sloping skirt. The bore is
the straight surface, so its shear is the whole axial force between the bodies and gives the power that sliding costs.

References
----------
[Elrod1981] H. G. Elrod, A cavitation algorithm, J. Lubr. Technol. 103 (1981) 350-354.
"""

import numpy as np
from numba import njit


@njit(cache=True, inline="always")
def _gradient(pressure, i, j, lower, upper, dy):
    """Axial pressure gradient of a cell from the pressures on its two faces."""
    last = pressure.shape[1] - 1
    south = lower if j == 0 else 0.5 * (pressure[i, j - 1] + pressure[i, j])
    north = upper if j == last else 0.5 * (pressure[i, j] + pressure[i, j + 1])
    return (north - south) / dy


@njit(cache=True)
def shear_forces(pressure, shearing, velocity, couette, drag, poiseuille, lower, upper, dy,
                 boundary_stress, rounding_velocity, area):
    """Viscous and asperity shear force of each cell, and the power of sliding, Eqs. (F1) to (F3).

    Parameters
    ----------
    pressure, shearing, velocity : ndarray, shape (n_c, n_a)
        p [Pa], share of the film that shears f [-], V [m/s].
    couette, drag, poiseuille : ndarray, shape (n_c, n_a)
        c, d [Pa s/m], b [m].
    lower, upper : float
        Pressure at the axial edges [Pa].
    dy : float
        Axial cell size [m].
    boundary_stress : ndarray, shape (n_c, n_a)
        tau_b [Pa].
    rounding_velocity : float
        v0 [m/s], > 0.
    area : ndarray, shape (n_c, n_a)
        Lubricated area of each cell [m2].

    Returns
    -------
    viscous, boundary : ndarray, shape (n_c, n_a)
        Force on the skirt along +y [N].
    power : ndarray, shape (n_c, n_a)
        [W].
    """
    n_c, n_a = pressure.shape
    viscous, boundary, power = np.empty((n_c, n_a)), np.empty((n_c, n_a)), np.empty((n_c, n_a))
    for i in range(n_c):
        for j in range(n_a):
            v, f, a = velocity[i, j], shearing[i, j], area[i, j]
            flow = poiseuille[i, j] * _gradient(pressure, i, j, lower, upper, dy)
            viscous[i, j] = -a * (f * (couette[i, j] - drag[i, j]) * v + flow)  # Eq. (F1)
            speed = np.sqrt(v * v + rounding_velocity * rounding_velocity)
            boundary[i, j] = -a * boundary_stress[i, j] * v / speed  # Eq. (F2)
            power[i, j] = v * (a * (f * (couette[i, j] + drag[i, j]) * v - flow) - boundary[i, j])  # Eq. (F3)
    return viscous, boundary, power


@njit(cache=True)
def shear_force_changes(pressure, shearing, velocity, couette, drag, poiseuille, lower, upper, dy,
                        boundary_stress, rounding_velocity, area,
                        dpressure, dshearing, dvelocity, dcouette, ddrag, dpoiseuille, dboundary_stress):
    """Change of the total shear force of each cell, the derivative of Eqs. (F1), (F2).

    Parameters
    ----------
    pressure ... area
        As in `shear_forces`.
    dpressure ... dboundary_stress : ndarray, shape (n_c, n_a)
        Changes of p, f, V, c, d, b, tau_b.

    Returns
    -------
    ndarray, shape (n_c, n_a)
        [N].
    """
    n_c, n_a = pressure.shape
    force = np.empty((n_c, n_a))
    for i in range(n_c):
        for j in range(n_a):
            v, f, dv, df = velocity[i, j], shearing[i, j], dvelocity[i, j], dshearing[i, j]
            c, dc = couette[i, j] - drag[i, j], dcouette[i, j] - ddrag[i, j]
            sliding = df * c * v + f * (dc * v + c * dv)
            flow = (dpoiseuille[i, j] * _gradient(pressure, i, j, lower, upper, dy)
                    + poiseuille[i, j] * _gradient(dpressure, i, j, 0.0, 0.0, dy))
            square = v * v + rounding_velocity * rounding_velocity
            direction = v / np.sqrt(square)
            ddirection = dv * (1.0 - direction * direction) / np.sqrt(square)
            boundary = dboundary_stress[i, j] * direction + boundary_stress[i, j] * ddirection
            force[i, j] = -area[i, j] * (sliding + flow + boundary)
    return force
