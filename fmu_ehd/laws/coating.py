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

from ...master.fmi.compiled import compilable, compiled
from ..common.grid import Array, Flags
from .contact import Contact, neighbour
from .piezoviscosity import TruePressure

LIMIT = 40  # Newton iterations
TOLERANCE = 1e-11  # last change over the deflection; the error is of second order in it
NEGLIGIBLE = 1e-19  # [m]
LARGEST_CHANGE = 0.3  # of a film in one iteration


class Softness(NamedTuple):
    """A deflection that follows the pressure, w - w_0 = weight q + offset.

    stencil : ndarray, shape (5, n_c, n_a), derivative of the film balance to the film, from
    `tangent.linearise`;
    weight, offset : ndarray, shape (n_c, n_a) [m/Pa], [m].
    """

    stencil: Array
    weight: Array
    offset: Array


@compilable
def compliance(thickness: float, modulus: float, poisson: float) -> float:
    """Return the compliance c of the layer [m/Pa], Eq. (L1).

    Parameters
    ----------
    thickness : float
        d [m]; 0 = no layer.
    modulus : float
        E [Pa].
    poisson : float
        nu [-], 0 to 0.45.

    >>> print(f"{1e6 * 10e6 * compliance(20e-6, 4e9, 0.4):.4f} um at 10 MPa")
    0.0233 um at 10 MPa
    """
    constrained = thickness * (1.0 + poisson) * (1.0 - 2.0 * poisson)
    return constrained / (modulus * (1.0 - poisson))  # Eq. (L1)


@compiled
def yielding(c: float, contact_slope: Array):
    """Return k of Eq. (L3) [-], by which the asperities relieve the layer, shape (n_c, n_a).

    Parameters
    ----------
    c : float
        [m/Pa].
    contact_slope : ndarray, shape (5, n_c, n_a)
        `pressure_slope` of `contact.Contact` [Pa/m].
    """
    _, n_c, n_a = contact_slope.shape
    k = np.empty((n_c, n_a))
    for i in range(n_c):
        for j in range(n_a):
            stiffness = 0.0  # all of a cell moves with its layer
            for m in range(5):
                stiffness -= contact_slope[m, i, j]
            k[i, j] = 1.0 / (1.0 + c * stiffness)
    return k


@compiled
def linear_deflection(
    c: float,
    deflection: Array,
    contact: Contact,
    under: TruePressure,
    reduced: Array,
    open_cells: Flags,
):
    """Return the change of the deflection as a linear function of the pressure, Eq. (L3).

    The pressure is the reduced one of the step.

    Parameters
    ----------
    c : float
        [m/Pa].
    deflection : ndarray, shape (n_c, n_a)
        w_0 [m].
    contact : contact.Contact
        At h and w_0.
    under : piezoviscosity.TruePressure
        Last p, and dp/dq there.
    reduced : ndarray, shape (n_c, n_a)
        Last q [Pa].
    open_cells : ndarray of bool, shape (n_c, n_a)
        Cells without a film, whose coating does not yield.

    Returns
    -------
    weight, offset : ndarray, shape (n_c, n_a)
        w - w_0 = weight q + offset [m/Pa], [m].
    """
    n_c, n_a = deflection.shape
    k = yielding(c, contact.pressure_slope)
    weight = np.zeros((n_c, n_a))
    offset = np.zeros((n_c, n_a))
    for i in range(n_c):
        for j in range(n_a):
            if open_cells[i, j]:
                continue
            ratio = under.ratio[i, j] if under.ratio.size > 0 else 1.0
            at_zero = under.pressure[i, j] - ratio * reduced[i, j]
            weight[i, j] = k[i, j] * c * ratio  # Eq. (L3)
            pressed = c * (at_zero + contact.pressure[i, j])
            offset[i, j] = k[i, j] * (pressed - deflection[i, j])
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
            for k in range(5):
                a, b = neighbour(k, i, j, n_c, n_a)
                if full[a, b]:
                    stencil[k, i, j] += slopes[k, i, j] * weight[a, b]
                right[i, j] -= slopes[k, i, j] * offset[a, b]


# ---- an iteration


class DeflectionResult(NamedTuple):
    """Result of an iteration of the deflection.

    deflection : ndarray, shape (n_c, n_a), to go on with [m];
    change : the largest, of either sign [m]; i, j : its cell;
    converged : whether that is round-off.
    """

    deflection: Array
    change: float
    i: int
    j: int
    converged: bool


@compiled
def yielded(deflection: Array, softness: Softness, reduced: Array, film_thickness: Array):
    """Return the coating that yields to the pressure found.

    Far from the solution Newton's method closes films, which then carry pressures that no later
    iteration finds back from: each film is left its size but for a share of it. Near the solution
    nothing is cut.

    Parameters
    ----------
    deflection : ndarray, shape (n_c, n_a)
        [m].
    softness : Softness
    reduced : ndarray, shape (n_c, n_a)
        q [Pa].
    film_thickness : ndarray, shape (n_c, n_a)
        Not below the floor [m].
    """
    n_c, n_a = deflection.shape
    moved = np.empty((n_c, n_a))
    largest = 0.0
    most_i = 0
    most_j = 0
    deepest = 0.0
    for i in range(n_c):
        for j in range(n_a):
            change = softness.weight[i, j] * reduced[i, j] + softness.offset[i, j]  # Eq. (L3)
            if not abs(change) <= abs(largest):
                largest = change
                most_i = i
                most_j = j
            deepest = max(deepest, abs(deflection[i, j]))
            most = LARGEST_CHANGE * film_thickness[i, j]
            moved[i, j] = deflection[i, j] + min(max(change, -most), most)
    converged = abs(largest) <= TOLERANCE * deepest + NEGLIGIBLE
    return DeflectionResult(moved, largest, most_i, most_j, converged)
