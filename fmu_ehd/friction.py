"""Axial shear force on the skirt: viscous and asperity part, and what sliding costs.

Eq. (F1):  tau_v = -f (c - d) V - b dp/dy                    on the skirt, which slides at V relative to the bore
Eq. (F2):  tau_a = -tau_b V / sqrt(V^2 + v0^2)
Eq. (F3):  P = sum A V [f (c + d) V - b dp/dy - tau_a]       shear of the film on the bore x sliding velocity

tau_b is the boundary shear stress of `asperity`; c, d, b are those of `films.FlowFilm` (smooth
surfaces: mu/h, 0, h/2). f is the film fraction: in the cavitated part only the oil shears
[Elrod1981]; with `cavity_shear = full_film` f = 1 there. dp/dy is the central difference of face
pressures (mean of both cells, edge pressure at an edge). v0 rounds Coulomb's step at rest, so that
friction has a derivative.

The shear stresses on skirt and bore differ by 2 b dp/dy: the axial part of the pressure on the
sloping skirt. The bore is the straight surface, so its shear is the whole axial force between the
bodies and gives the power that sliding costs.

References
----------
[Elrod1981] H. G. Elrod, A cavitation algorithm, J. Lubr. Technol. 103 (1981) 350-354.
"""

import numpy as np

from ..master.fmi.compiled import compiled


@compiled(inline="always")
def _gradients(pressure, lower, upper, dy, out):
    """Axial pressure gradient of each cell of a row from the pressures on its two faces."""
    last = pressure.size - 1
    half = 0.5 / dy
    for j in range(1, last):
        out[j] = half * (pressure[j + 1] - pressure[j - 1])
    if last == 0:
        out[0] = (upper - lower) / dy
    else:
        out[0] = (0.5 * (pressure[0] + pressure[1]) - lower) / dy
        out[last] = (upper - 0.5 * (pressure[last - 1] + pressure[last])) / dy


@compiled
def shear_forces(
    pressure,
    shearing,
    velocity,
    couette,
    drag,
    poiseuille,
    lower,
    upper,
    dy,
    boundary_stress,
    rounding_velocity,
    area,
):
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
    gradient = np.empty(n_a)
    for i in range(n_c):
        _gradients(pressure[i], lower, upper, dy, gradient)
        for j in range(n_a):
            v, f, a = velocity[i, j], shearing[i, j], area[i, j]
            flow = poiseuille[i, j] * gradient[j]
            viscous[i, j] = -a * (f * (couette[i, j] - drag[i, j]) * v + flow)  # Eq. (F1)
            speed = np.sqrt(v * v + rounding_velocity * rounding_velocity)
            boundary[i, j] = -a * boundary_stress[i, j] * v / speed  # Eq. (F2)
            power[i, j] = v * (
                a * (f * (couette[i, j] + drag[i, j]) * v - flow) - boundary[i, j]
            )  # Eq. (F3)
    return viscous, boundary, power


@compiled
def shear_slopes(
    pressure,
    shearing,
    velocity,
    couette,
    drag,
    poiseuille,
    lower,
    upper,
    dy,
    boundary_stress,
    rounding_velocity,
    area,
    by_film,
    by_velocity,
    boundary_slope,
):
    """Derivatives of the total shear force of each cell, Eqs. (F1), (F2).

    Parameters
    ----------
    pressure ... area
        As in `shear_forces`.
    by_film, by_velocity : ndarray, shape (3, n_c, n_a)
        Derivatives of c, d, b to film thickness and to sliding velocity; the latter of shape (0,
        n_c, n_a) if all zero.
    boundary_slope : ndarray, shape (n_c, n_a)
        Derivative of tau_b to film thickness [Pa/m].

    Returns
    -------
    ndarray, shape (4, n_c, n_a)
        To film thickness [N/m], sliding velocity [N s/m], shearing share [N], and to the pressure
        gradient [N m/Pa].
    """
    n_c, n_a = pressure.shape
    slopes = np.empty((4, n_c, n_a))
    gradient = np.empty(n_a)
    for i in range(n_c):
        _gradients(pressure[i], lower, upper, dy, gradient)
        for j in range(n_a):
            v, f, c, a = velocity[i, j], shearing[i, j], couette[i, j] - drag[i, j], -area[i, j]
            square = v * v + rounding_velocity * rounding_velocity
            direction = v / np.sqrt(square)
            slopes[0, i, j] = a * (
                f * v * (by_film[0, i, j] - by_film[1, i, j])
                + by_film[2, i, j] * gradient[j]
                + boundary_slope[i, j] * direction
            )
            slopes[1, i, j] = a * (
                f * c + boundary_stress[i, j] * (1.0 - direction * direction) / np.sqrt(square)
            )
            if by_velocity.shape[0] > 0:
                slopes[1, i, j] += a * (
                    f * v * (by_velocity[0, i, j] - by_velocity[1, i, j])
                    + by_velocity[2, i, j] * gradient[j]
                )
            slopes[2, i, j] = a * c * v
            slopes[3, i, j] = a * poiseuille[i, j]
    return slopes


@compiled
def force_changes(
    slopes,
    by_pressure,
    contact_slope,
    area,
    dy,
    pressure_share,
    fraction_share,
    dfilm,
    dvelocity,
    dunknown,
    normal,
    shear,
):
    """Changes of both nodal forces.

    Parameters
    ----------
    slopes : ndarray, shape (4, n_c, n_a)
        From `shear_slopes`.
    by_pressure : ndarray, shape (n_c, n_a)
        Derivative of the shear force to the cell's own pressure, beyond the gradient [N/Pa].
    contact_slope, area : ndarray, shape (n_c, n_a)
        Derivative of the asperity pressure to film thickness [Pa/m], lubricated area [m2].
    dy : float
        Axial cell size [m].
    pressure_share, fraction_share : ndarray, shape (n_c, n_a)
        Derivatives of pressure and film fraction to the signed unknown.
    dfilm, dvelocity, dunknown : ndarray, shape (m, n_c, n_a)
        [m], [m/s], [Pa] or [-].
    normal, shear : ndarray, shape (m, n_c, n_a)
        Overwritten: changes of pressure and friction force [N].
    """
    m, n_c, n_a = dfilm.shape
    p = np.empty(n_a)
    half, last = 0.5 / dy, n_a - 1
    for i in range(
        n_c
    ):  # what stands before the changes of a row stays in the cache for all directions
        for q in range(m):
            for j in range(n_a):
                p[j] = pressure_share[i, j] * dunknown[q, i, j]
            for j in range(n_a):
                normal[q, i, j] = area[i, j] * (p[j] + contact_slope[i, j] * dfilm[q, i, j])
            for j in range(n_a):
                shear[q, i, j] = (
                    slopes[0, i, j] * dfilm[q, i, j]
                    + slopes[1, i, j] * dvelocity[q, i, j]
                    + slopes[2, i, j] * fraction_share[i, j] * dunknown[q, i, j]
                    + by_pressure[i, j] * p[j]
                )
            for j in range(1, last):
                shear[q, i, j] += slopes[3, i, j] * half * (p[j + 1] - p[j - 1])
            if n_a > 1:
                shear[q, i, 0] += slopes[3, i, 0] * half * (p[0] + p[1])
                shear[q, i, last] -= slopes[3, i, last] * half * (p[last] + p[last - 1])
