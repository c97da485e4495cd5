"""A soft layer on the skirt that yields where it is pressed.

Thin bonded layer without lateral strain:

Eq. (L1):  w = c (p + p_a),   c = d (1 + nu) (1 - 2 nu) / [E (1 - nu)]
Eq. (L2):  film = h + w,   p_a = p_a(h, w)

Each point yields by itself: valid where the layer is thin against the width of the pressure, d << 1
mm here, and nu is not near 1/2. Newton's method on Eqs. (E1), (L1), (L2) together: with k = 1 / (1
- c dp_a/dw), the change of the deflection from its last value w_0 is

Eq. (L3):  w - w_0 = k [c p + c p_a(h, w_0) - w_0]

which enters the film balance through its derivative to the film, on the same five points.

References
----------
[Johnson1985] K. L. Johnson, Contact Mechanics, Cambridge 1985, section 5.8.
"""

from typing import NamedTuple

import numpy as np

from ..master.fmi.compiled import compiled
from .contact import Contact
from .grid import CENTRE, EAST, NORTH, SOUTH, WEST, Array, Flags

LIMIT = 40  # Newton iterations
TOLERANCE = 1e-11  # last change over the deflection: what is left is second order in it
NEGLIGIBLE = 1e-19  # [m]
LARGEST_CHANGE = 0.3  # of a film in one iteration


class PressureTangent(NamedTuple):
    """Pressure as a linear function of the reduced pressure q of a step, arrays of shape (n_c,
    n_a): p = pressure + ratio (q - reduced).

    pressure : last p [Pa]; ratio : dp/dq [-]; reduced : last q [Pa].
    """

    pressure: Array
    ratio: Array | float
    reduced: Array


class Softness(NamedTuple):
    """A deflection that follows the pressure, w - w_0 = weight q + offset.

    stencil : ndarray, shape (5, n_c, n_a), derivative of the film balance to the film, from
    `reynolds.linearise`;
    weight, offset : ndarray, shape (n_c, n_a) [m/Pa], [m].
    """

    stencil: Array
    weight: Array
    offset: Array


def compliance(thickness: float, modulus: float, poisson: float) -> float:
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
    constrained = thickness * (1.0 + poisson) * (1.0 - 2.0 * poisson)
    return constrained / (modulus * (1.0 - poisson))  # Eq. (L1)


def yielding(c: float, contact: Contact) -> Array:
    """k of Eq. (L3) [-], by which the asperities relieve the layer."""
    stiffness = -contact.pressure_slope.sum(axis=0)  # all of a cell moves with its layer
    return 1.0 / (1.0 + c * stiffness)


def linear_deflection(
    c: float, deflection: Array, contact: Contact, tangent: PressureTangent
) -> tuple[Array, Array]:
    """Change of the deflection as a linear function of the (reduced) pressure of the step, Eq.
    (L3).

    Parameters
    ----------
    c : float
        [m/Pa].
    deflection : ndarray, shape (n_c, n_a)
        w_0 [m].
    contact : contact.Contact
        At h and w_0.
    tangent : PressureTangent

    Returns
    -------
    weight, offset : ndarray, shape (n_c, n_a)
        w - w_0 = weight q + offset [m/Pa], [m].
    """
    k = yielding(c, contact)
    at_zero = tangent.pressure - tangent.ratio * tangent.reduced
    weight = k * c * tangent.ratio  # Eq. (L3)
    offset = k * (c * (at_zero + contact.pressure) - deflection)
    return weight, offset


@compiled
def soften(full: Flags, softness: Softness, stencil: Array, right: Array):
    """Add a deflection that follows the pressure, Eq. (L3), to the film balance; in place.

    Parameters
    ----------
    full : ndarray of bool, shape (n_c, n_a)
        Cells whose unknown is a pressure.
    softness : Softness
    stencil, right : ndarray, shape (5, n_c, n_a), (n_c, n_a)
        From `reynolds.assemble`.
    """
    slopes, weight, offset = softness
    n_c, n_a = full.shape
    for i in range(n_c):
        for j in range(n_a):
            for k in (CENTRE, SOUTH, NORTH, WEST, EAST):
                a = i
                b = j
                if k == WEST:
                    a = (i - 1) % n_c
                elif k == EAST:
                    a = (i + 1) % n_c
                elif k == SOUTH:
                    b = max(j - 1, 0)
                elif k == NORTH:
                    b = min(j + 1, n_a - 1)
                if full[a, b]:
                    stencil[k, i, j] += slopes[k, i, j] * weight[a, b]
                right[i, j] -= slopes[k, i, j] * offset[a, b]


def limited(change: Array, film_thickness: Array) -> Array:
    """A change of the deflection that leaves each film its size, but for a share of it [m].

    Far from the solution Newton's method closes films, which then carry pressures that no later
    iteration finds back from; near it nothing is cut.
    """
    most = LARGEST_CHANGE * film_thickness
    return np.clip(change, -most, most)


def has_converged(change: Array, deflection: Array) -> bool:
    """Whether the last change of the deflection is round-off."""
    return bool(np.abs(change).max() <= TOLERANCE * np.abs(deflection).max() + NEGLIGIBLE)
