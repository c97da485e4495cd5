"""Quantities of flow and shear that depend on the film thickness, and their derivatives by it.

Smooth surfaces:

Eq. (E7):  s = h_U = max(h, h_min),   kappa = s^3 / (12 mu),   c_v = mu / s,   b_p = s / 2

Rough surfaces; s and the h of kappa not below h_min, c_v also in overlap, h < 0:

Eq. (E8):  s = h_T,   h_U = h_T - sigma Phi_s,   kappa = phi h^3 / (12 mu)
Eq. (E9):  c_v = (phi_f + Phi_fs) mu / h,   b_p = phi_fp h / 2

s stored and h_U transported film [m], kappa conductivity [m3/(Pa s)] of `reynolds`; c_v and b_p
give the axial stress of `friction`. The factors phi are those of `roughness`, of both surfaces; Y
is the skirt's share of the roughness variance. In the frame of the grid the skirt rests and the
bore moves with twice the entrainment velocity, so a rough skirt retains oil (h_U < h_T).

c_v and b_p contain the total axial action on the bore: shear, and the pressure on the slopes of its
roughness. On a smooth bore under a rough skirt (Y = 1) only shear acts, with the published factors
phi_f + Phi_fs and phi_fp. For a rough bore under a smooth skirt (Y = 0) these factors describe the
shear on the skirt. The action on the bore then follows from the equilibrium of the film, which has
no mass. It is the same for sliding, and h - phi_fp h/2 for a pressure gradient. Between both cases
c_v and b_p are linear in the variances, as the flow factors are.

One array contains all quantities of a film, see `common.quantities`.
"""

import numpy as np

from ...master.fmi.compiled import compiled
from ..common.grid import Array
from ..common.quantities import (
    CONDUCTIVITY_A,
    CONDUCTIVITY_C,
    COUETTE,
    POISEUILLE,
    QUANTITIES,
    STORED,
    TRANSPORT,
)
from ..laws.hermite import interpolate
from ..laws.roughness import (
    FACTOR,
    FACTORS,
    TABLE_END,
    TABLE_START,
)


@compiled
def smooth_film(film_thickness: Array, viscosity: Array, minimum_flow_film: float):
    """Return the film between smooth surfaces, Eq. (E7).

    Parameters
    ----------
    film_thickness : ndarray, shape (n_c, n_a)
        h [m], any sign. Where surfaces overlap, h_min replaces it.
    viscosity : ndarray, shape (n_c, n_a)
        mu [Pa s], > 0.
    minimum_flow_film : float
        h_min [m], > 0.

    Returns
    -------
    quantities, by_film : ndarray, shape (6, n_c, n_a)
        The quantities of the film and their derivatives to h.
    """
    n_c, n_a = film_thickness.shape
    quantities = np.empty((QUANTITIES, n_c, n_a))
    by_film = np.empty((QUANTITIES, n_c, n_a))
    for i in range(n_c):
        for j in range(n_a):
            mu = viscosity[i, j]
            h = max(film_thickness[i, j], minimum_flow_film)
            dh = 1.0 if film_thickness[i, j] > minimum_flow_film else 0.0
            dg = h * h / (4.0 * mu)
            shear = mu / h
            quantities[STORED, i, j] = quantities[TRANSPORT, i, j] = h  # Eq. (E7)
            quantities[CONDUCTIVITY_C, i, j] = quantities[CONDUCTIVITY_A, i, j] = h * dg / 3.0
            quantities[COUETTE, i, j] = shear
            quantities[POISEUILLE, i, j] = 0.5 * h
            by_film[STORED, i, j] = by_film[TRANSPORT, i, j] = dh
            by_film[CONDUCTIVITY_C, i, j] = by_film[CONDUCTIVITY_A, i, j] = dh * dg
            by_film[COUETTE, i, j] = -dh * shear / h
            by_film[POISEUILLE, i, j] = 0.5 * dh
    return quantities, by_film


@compiled(forceinline=True)
def _factors(table, separation, roughness_rms, f, df):
    """Write the functions of `roughness` at h/sigma into `f`, their derivatives by h into `df`."""
    last = table.shape[0] - 1
    for k in range(FACTORS):
        column = 2 * k
        if TABLE_START <= separation < TABLE_END:
            x = separation - TABLE_START
            f[k], df[k] = interpolate(table, column, TABLE_END - TABLE_START, x)
            df[k] /= roughness_rms
        else:
            f[k] = table[0 if separation < TABLE_START else last, column]
            df[k] = 0.0
    if separation >= TABLE_END:  # drag is a factor over h/sigma, and only the factor is constant
        f[FACTOR.drag] *= TABLE_END / separation
        df[FACTOR.drag] = -f[FACTOR.drag] / (separation * roughness_rms)


@compiled
def rough_film(
    film_thickness: Array,
    viscosity: Array,
    minimum_flow_film: float,
    roughness_rms: float,
    table: Array,
):
    """Return the film between rough surfaces, Eqs. (E8), (E9).

    Parameters
    ----------
    film_thickness, viscosity, minimum_flow_film
        As in `smooth_film`.
    roughness_rms : float
        Composite sigma [m], > 0.
    table : ndarray
        From `roughness.factor_table`.

    Returns
    -------
    quantities, by_film : ndarray, shape (6, n_c, n_a)
        The quantities of the film and their derivatives to h.
    """
    n_c, n_a = film_thickness.shape
    quantities = np.empty((QUANTITIES, n_c, n_a))
    by_film = np.empty((QUANTITIES, n_c, n_a))
    f = np.empty(FACTORS)
    df = np.empty(FACTORS)
    for i in range(n_c):
        for j in range(n_a):
            mu = viscosity[i, j]
            _factors(table, film_thickness[i, j] / roughness_rms, roughness_rms, f, df)

            gap = film_thickness[i, j] + roughness_rms * f[FACTOR.gap_excess]  # h_T
            dgap = 1.0 + roughness_rms * df[FACTOR.gap_excess]
            if gap < minimum_flow_film:
                gap = minimum_flow_film
                dgap = 0.0
            h = film_thickness[i, j]
            dh = 1.0
            if h < minimum_flow_film:
                h = minimum_flow_film
                dh = 0.0

            quantities[STORED, i, j] = gap  # Eq. (E8)
            by_film[STORED, i, j] = dgap
            quantities[TRANSPORT, i, j] = gap - roughness_rms * f[FACTOR.shear_flow]
            by_film[TRANSPORT, i, j] = dgap - roughness_rms * df[FACTOR.shear_flow]

            cube = h * h * h / (12.0 * mu)
            dcube = dh * h * h / (4.0 * mu)
            phi = 1.0 + f[FACTOR.flow_c]
            quantities[CONDUCTIVITY_C, i, j] = phi * cube
            by_film[CONDUCTIVITY_C, i, j] = phi * dcube + df[FACTOR.flow_c] * cube
            phi = 1.0 + f[FACTOR.flow_a]
            quantities[CONDUCTIVITY_A, i, j] = phi * cube
            by_film[CONDUCTIVITY_A, i, j] = phi * dcube + df[FACTOR.flow_a] * cube

            quantities[COUETTE, i, j] = f[FACTOR.drag] * mu / roughness_rms  # Eq. (E9)
            by_film[COUETTE, i, j] = df[FACTOR.drag] * mu / roughness_rms
            phi = 1.0 + f[FACTOR.poiseuille]
            dphi = df[FACTOR.poiseuille]
            quantities[POISEUILLE, i, j] = 0.5 * phi * h
            by_film[POISEUILLE, i, j] = 0.5 * (phi * dh + dphi * h)
    return quantities, by_film
