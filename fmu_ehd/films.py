"""What a film thickness means for flow and shear, with the derivative to the film thickness.

Eq. (E7):  s = t = max(h, h_min),  g = s^3 / (12 mu),  c = mu / s,  b = s / 2              smooth surfaces
Eq. (E8):  s = h_T,  t = h_T - (2 Y - 1) sigma Phi_s,  g = phi h^3 / (12 mu),  c = phi_f mu / h,
           d = (2 Y - 1) Phi_fs mu / h,  b = phi_fp h / 2                                   rough surfaces, h >= h_min

s stored and t transported film [m], g conductivity [m3/(Pa s)] of `reynolds`; c, d and b give the
shear stress of `friction`. The factors phi are those of `roughness`; Y is the skirt's share of the
roughness variance. In the frame of the grid the skirt rests and the bore moves with twice the
entrainment velocity, so a rough skirt holds oil back (t < h_T).
"""

from typing import NamedTuple

import numpy as np

from ..master.fmi.compiled import compiled
from .hermite import interpolate
from .roughness import TABLE_END


class FlowFilm(NamedTuple):
    """Film seen by flow and shear, each an ndarray of shape (n_c, n_a).

    stored, transport [m]; conductivity_c, conductivity_a across i and j [m3/(Pa s)]; couette c,
    drag d [Pa s/m]; poiseuille b [m].
    """

    stored: np.ndarray
    transport: np.ndarray
    conductivity_c: np.ndarray
    conductivity_a: np.ndarray
    couette: np.ndarray
    drag: np.ndarray
    poiseuille: np.ndarray


@compiled
def smooth_film(film_thickness, viscosity, minimum_flow_film):
    """Flow film of smooth surfaces, Eq. (E7).

    Parameters
    ----------
    film_thickness : ndarray, shape (n_c, n_a)
        h [m], any sign: where surfaces overlap the floor holds.
    viscosity : ndarray, shape (n_c, n_a)
        mu [Pa s], > 0.
    minimum_flow_film : float
        h_min [m], > 0.

    Returns
    -------
    values, slopes : ndarray, shape (7, n_c, n_a)
        The quantities of `FlowFilm` and their derivatives to h.
    """
    n_c, n_a = film_thickness.shape
    values, slopes = np.empty((7, n_c, n_a)), np.empty((7, n_c, n_a))
    for i in range(n_c):
        for j in range(n_a):
            mu, h = viscosity[i, j], max(film_thickness[i, j], minimum_flow_film)
            slope = 1.0 if film_thickness[i, j] > minimum_flow_film else 0.0
            area, shear = h * h / (4.0 * mu), mu / h
            values[0, i, j] = values[1, i, j] = h  # Eq. (E7)
            values[2, i, j] = values[3, i, j] = h * area / 3.0
            values[4, i, j], values[5, i, j], values[6, i, j] = shear, 0.0, 0.5 * h
            slopes[0, i, j] = slopes[1, i, j] = slope
            slopes[2, i, j] = slopes[3, i, j] = slope * area
            slopes[4, i, j], slopes[5, i, j], slopes[6, i, j] = -slope * shear / h, 0.0, 0.5 * slope
    return values, slopes


def thin(values, slopes, factor, slope, thickness, above_floor, sliding_velocity):
    """Shear thinning: conductivities grow by mu_0/mu, Couette stress and drag fall by mu/mu_0;
    `values` and `slopes` in place.

    Parameters
    ----------
    values, slopes : ndarray, shape (7, n_c, n_a)
        From `smooth_film` or `rough_film` with the low-shear viscosity.
    factor, slope : ndarray, shape (n_c, n_a)
        mu/mu_0 [-] and its derivative [s] at the shear rate |V|/h, `oil.Oil.thinning`.
    thickness : ndarray, shape (n_c, n_a)
        h [m], not below the floor.
    above_floor : ndarray of bool, shape (n_c, n_a)
    sliding_velocity : ndarray, shape (n_c, n_a)
        V [m/s].

    Returns
    -------
    values, slopes, velocity_slopes : ndarray, shape (7, n_c, n_a)
        The last: derivatives to V.
    """
    by_film = np.where(above_floor, -slope * np.abs(sliding_velocity) / thickness**2, 0.0)
    by_velocity = slope * np.sign(sliding_velocity) / thickness
    velocity_slopes = np.zeros_like(slopes)
    for rows, power in ((slice(2, 4), -1.0), (slice(4, 6), 1.0)):
        scale, dscale = factor**power, power * factor ** (power - 1.0)
        velocity_slopes[rows] = values[rows] * dscale * by_velocity
        slopes[rows] = slopes[rows] * scale + values[rows] * dscale * by_film
        values[rows] *= scale
    return values, slopes, velocity_slopes


@compiled
def rough_film(film_thickness, viscosity, minimum_flow_film, roughness_rms, asymmetry, table):
    """Flow film of rough surfaces, Eq. (E8).

    Parameters
    ----------
    film_thickness, viscosity, minimum_flow_film
        As in `smooth_film`.
    roughness_rms : float
        Composite sigma [m], > 0.
    asymmetry : float
        2 Y - 1 [-]: 1 where only the skirt is rough, -1 where only the bore is.
    table : ndarray
        From `roughness.factor_table`.

    Returns
    -------
    values, slopes : ndarray, shape (7, n_c, n_a)
        The quantities of `FlowFilm` and their derivatives to h.
    """
    n_c, n_a = film_thickness.shape
    values, slopes = np.empty((7, n_c, n_a)), np.empty((7, n_c, n_a))
    last = table.shape[0] - 1
    f, df = (
        np.empty(7),
        np.empty(7),
    )  # deviation of each factor from its smooth limit, and its slope to h
    for i in range(n_c):
        for j in range(n_a):
            mu, separation = viscosity[i, j], film_thickness[i, j] / roughness_rms
            for k in range(7):
                if 0.0 <= separation < TABLE_END:
                    f[k], df[k] = interpolate(table, 2 * k, TABLE_END, separation)
                    df[k] /= roughness_rms
                elif (
                    k == 0 and separation < 0.0
                ):  # the average gap goes on along its tangent, until the floor holds
                    f[k], df[k] = (
                        table[0, 0] + table[0, 1] * separation,
                        table[0, 1] / roughness_rms,
                    )
                else:
                    f[k], df[k] = table[0 if separation < 0.0 else last, 2 * k], 0.0
            gap = film_thickness[i, j] + roughness_rms * f[0]  # h_T
            dgap = 1.0 + roughness_rms * df[0]
            if gap < minimum_flow_film:
                gap, dgap = minimum_flow_film, 0.0
            values[0, i, j], slopes[0, i, j] = gap, dgap  # Eq. (E8)
            values[1, i, j] = gap - asymmetry * roughness_rms * f[3]
            slopes[1, i, j] = dgap - asymmetry * roughness_rms * df[3]
            h, dh = film_thickness[i, j], 1.0
            if h < minimum_flow_film:
                h, dh = minimum_flow_film, 0.0
            cube, dcube = h * h * h / (12.0 * mu), dh * h * h / (4.0 * mu)
            values[2, i, j], slopes[2, i, j] = (
                (1.0 + f[1]) * cube,
                (1.0 + f[1]) * dcube + df[1] * cube,
            )
            values[3, i, j], slopes[3, i, j] = (
                (1.0 + f[2]) * cube,
                (1.0 + f[2]) * dcube + df[2] * cube,
            )
            shear, dshear = mu / h, -mu * dh / (h * h)
            values[4, i, j], slopes[4, i, j] = (
                (1.0 + f[4]) * shear,
                (1.0 + f[4]) * dshear + df[4] * shear,
            )
            values[5, i, j], slopes[5, i, j] = (
                asymmetry * f[5] * shear,
                asymmetry * (f[5] * dshear + df[5] * shear),
            )
            values[6, i, j], slopes[6, i, j] = (
                0.5 * (1.0 + f[6]) * h,
                0.5 * ((1.0 + f[6]) * dh + df[6] * h),
            )
    return values, slopes
