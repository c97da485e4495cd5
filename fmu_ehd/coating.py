"""A soft layer on the skirt that yields where it is pressed.

Eq. (L1):  w = c (p + p_a),   c = d (1 + nu) (1 - 2 nu) / [E (1 - nu)]          thin bonded layer, no lateral strain
Eq. (L2):  film = h + w,   p_a = p_a(h + w)

Each point yields by itself: valid where the layer is thin against the width of the pressure, d << 1
mm here, and nu is not near 1/2. Newton's method on Eqs. (E1), (L1), (L2) together: with k = 1 / (1
- c dp_a/dh), the change of the deflection from its last value w_0 is

Eq. (L3):  w - w_0 = k [c p + c p_a(h + w_0) - w_0]

which enters the film balance through its derivative to the film, on the same five points.

References
----------
[Johnson1985] K. L. Johnson, Contact Mechanics, Cambridge 1985, section 5.8.
"""

import numpy as np

from ..master.fmi.compiled import compiled

LIMIT = 40  # Newton iterations
TOLERANCE = (
    1e-11  # last change of the deflection over the deflection: what is left is second order in it
)
NEGLIGIBLE = 1e-19  # [m]


def compliance(thickness, modulus, poisson):
    """Compliance c of the layer [m/Pa], Eq. (L1).

    Parameters
    ----------
    thickness : float
        d [m]; 0 = no layer.
    modulus : float
        E [Pa].
    poisson : float
        nu [-], 0 to 0.45.
    """
    return (
        thickness * (1.0 + poisson) * (1.0 - 2.0 * poisson) / (modulus * (1.0 - poisson))
    )  # Eq. (L1)


def linear_deflection(c, deflection, asperity_pressure, asperity_slope, pressure, ratio, reduced):
    """Change of the deflection as a linear function of the (reduced) pressure of the step, Eq.
    (L3).

    Parameters
    ----------
    c : float
        [m/Pa].
    deflection, asperity_pressure, asperity_slope : ndarray, shape (n_c, n_a)
        w_0 [m], p_a [Pa] and dp_a/dh [Pa/m] there.
    pressure, ratio, reduced : ndarray, shape (n_c, n_a)
        Last p [Pa], dp/dq [-] and q [Pa]: p = pressure + ratio (q - reduced).

    Returns
    -------
    weight, offset : ndarray, shape (n_c, n_a)
        w - w_0 = weight q + offset [m/Pa], [m].
    """
    k = 1.0 / (1.0 - c * asperity_slope)
    return k * c * ratio, k * (
        c * (pressure - ratio * reduced + asperity_pressure) - deflection
    )  # Eq. (L3)


@compiled
def soften(full, slopes, weight, offset, centre, south, north, west, east, right):
    """Add a deflection that follows the pressure, Eq. (L3), to the film balance; in place.

    Parameters
    ----------
    full : ndarray of bool, shape (n_c, n_a)
        Cells whose unknown is a pressure.
    slopes : ndarray, shape (5, n_c, n_a)
        Derivative of the balance to the film, from `reynolds.linearise`.
    weight, offset : ndarray, shape (n_c, n_a)
        From `linear_deflection`.
    centre, south, north, west, east, right : ndarray, shape (n_c, n_a)
        From `reynolds.assemble`.
    """
    n_c, n_a = full.shape
    parts = (centre, south, north, west, east)
    for i in range(n_c):
        for j in range(n_a):
            for k in range(5):
                a = (i - 1) % n_c if k == 3 else (i + 1) % n_c if k == 4 else i
                b = max(j - 1, 0) if k == 1 else min(j + 1, n_a - 1) if k == 2 else j
                if full[a, b]:
                    parts[k][i, j] += slopes[k, i, j] * weight[a, b]
                right[i, j] -= slopes[k, i, j] * offset[a, b]


def settled(change, deflection):
    """Whether the last change of the deflection is round-off."""
    return np.abs(change).max() <= TOLERANCE * np.abs(deflection).max() + NEGLIGIBLE
