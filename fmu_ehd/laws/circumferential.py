"""Circumferential shear, and friction power on a grid that is fixed to the bore.

A bearing slides in both directions, and its grid is fixed to the shell, which is its bore. Around
the circumference, as Eqs. (F1), (F2) along the axis:

Eq. (F6):  tau_v = -(f c W - b dp/dx)
Eq. (F7):  tau_a = -tau_b W / s,   s^2 = V^2 + W^2 + v0^2

Both act on the journal, their opposites on the shell. V and W are the axial and circumferential
velocity of the journal relative to the shell. The moment about the axis of the shell is R sum A
(tau_v + tau_a). That about the eccentric axis of the journal also contains the moment of the
pressure. The pressure is normal to the journal and does only the work of dh/dt. The shear on the
journal itself is Eq. (F6) less h grad p. The power of sliding is therefore

Eq. (F8):  P = -sum A (V tau_y + W tau_x) + sum A h (V dp/dy + W dp/dx)

which is the angular speed of the journal times the moment about its own axis. Tables of bearings
call it friction.

dp/dx is the central difference of face pressures, as dp/dy in `friction`. Arrays have the shape
(n_c, n_a).
"""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable, compiled
from ..common.grid import Array, Field, put, sum_of_products
from ..common.quantities import COUETTE, POISEUILLE, FilmSlopes
from .friction import ForceSlopes, FrictionPowers, ShearForces, ShearInputs, gradients


class CircumferentialInputs(NamedTuple):
    """Inputs of shear around the circumference, in addition to `friction.ShearInputs`.

    velocity : ndarray, W [m/s]; end : pressure beyond the two ends of a sector [Pa]; dx : cell size
    around [m]; ring : whether i is periodic.
    """

    velocity: Field
    end: float
    dx: float
    ring: bool


class CircumferentialSlopes(NamedTuple):
    """Derivatives of the forces of a bearing, arrays of shape (n_c, n_a).

    They are those of the circumferential force of each cell, and that of the axial force to W.

    film : to film thickness [N/m]; own, axial : to W and V [N s/m]; shearing, gradient, pressure :
    as in `friction.ShearSlopes`;
    axial_across : of the axial force to W [N s/m].
    """

    film: Field
    own: Field
    axial: Field
    shearing: Field
    gradient: Field
    pressure: Field
    axial_across: Field


class Changes(NamedTuple):
    """Changes of the inputs and of the unknown, each ndarray of shape (m, n_c, n_a).

    They are those of film thickness [m], of V and W [m/s] and of the signed unknown.
    """

    film: Array
    axial: Array
    around: Array
    unknown: Array


@compiled
def gradients_around(pressure: Array, area: Array, end: float, dx: float, ring: bool):
    """Return the circumferential pressure gradient from the pressures on both faces of each cell.

    Parameters
    ----------
    pressure, area : ndarray, shape (n_c, n_a)
        [Pa]; lubricated area, 0 in an opening, whose pressure reaches to its face [m2].
    end, dx, ring
        As in `CircumferentialInputs`.

    Returns
    -------
    ndarray, shape (n_c, n_a)
        [Pa/m].
    """
    n_c, n_a = pressure.shape
    gradient = np.empty((n_c, n_a))
    for i in range(n_c):
        for j in range(n_a):
            here = pressure[i, j]
            west = pressure[(i - 1) % n_c, j]
            east = pressure[(i + 1) % n_c, j]
            before = west if area[(i - 1) % n_c, j] == 0.0 else 0.5 * (west + here)
            behind = east if area[(i + 1) % n_c, j] == 0.0 else 0.5 * (here + east)
            if not ring and i == 0:
                before = end
            if not ring and i == n_c - 1:
                behind = end
            gradient[i, j] = (behind - before) / dx
    return gradient


@compilable
def speed(inputs: ShearInputs, turning: CircumferentialInputs) -> Array:
    """Return s of Eq. (F7) [m/s]."""
    square = inputs.velocity * inputs.velocity + turning.velocity * turning.velocity
    rounding = inputs.constants.rounding_velocity
    return np.sqrt(square + rounding * rounding)


@compilable
def _gradients(inputs, turning, pressure):
    """Return `gradients_around` with the pressure of a step."""
    return gradients_around(pressure, inputs.area, turning.end, turning.dx, turning.ring)


@compilable
def shear_forces(inputs: ShearInputs, turning: CircumferentialInputs) -> ShearForces:
    """Return the circumferential force on the journal in each cell, Eqs. (F6), (F7).

    It has a part of the film and one of the asperities, positive with ascending i.
    """
    couette = inputs.shearing * inputs.film[COUETTE] * turning.velocity
    driven = inputs.film[POISEUILLE] * _gradients(inputs, turning, inputs.pressure)
    across = -inputs.area / speed(inputs, turning) * turning.velocity  # Eq. (F7)
    # Eq. (F6)
    return ShearForces(-inputs.area * (couette - driven), across * inputs.boundary_stress)


@compilable
def powers(
    along: FrictionPowers,
    inputs: ShearInputs,
    around: ShearForces,
    turning: CircumferentialInputs,
    thickness: Array,
) -> FrictionPowers:
    """Return the friction power of a bearing.

    Parameters
    ----------
    along : friction.FrictionPowers
        Powers of the forces along the axis.
    inputs : friction.ShearInputs
    around : friction.ShearForces
        From `shear_forces`.
    turning : CircumferentialInputs
    thickness : ndarray, shape (n_c, n_a)
        h, not below the floor [m].
    """
    w = turning.velocity
    turned = around.viscous + around.boundary
    carried = carried_power(inputs, turning, thickness)
    friction = along.friction - sum_of_products(turned, w) + carried  # Eq. (F8)
    boundary = along.boundary - sum_of_products(around.boundary, w)
    return FrictionPowers(friction, boundary)


@compilable
def carried_power(inputs: ShearInputs, turning: CircumferentialInputs, thickness: Array) -> float:
    """Return the second sum of Eq. (F8) [W], for a film thickness h [m] of shape (n_c, n_a)."""
    constants = inputs.constants
    along = gradients(inputs.pressure, inputs.area, constants.lower, constants.upper, constants.dy)
    across = _gradients(inputs, turning, inputs.pressure)
    # Eq. (F8)
    driven = inputs.velocity * along + turning.velocity * across
    return sum_of_products(inputs.area * thickness, driven)


@compilable
def _by(inputs, quantities, velocity, gradient):
    """Return the derivative of a viscous force through the quantities of the film."""
    if quantities.shape[0] == 0:
        return 0.0 * inputs.area
    sheared = inputs.shearing * velocity * quantities[COUETTE]
    return -inputs.area * (sheared - quantities[POISEUILLE] * gradient)


@compilable
def force_slopes(
    inputs: ShearInputs,
    turning: CircumferentialInputs,
    to_v: FilmSlopes,
    to_w: FilmSlopes,
    by_pressure: Array,
) -> CircumferentialSlopes:
    """Return the derivatives of the forces of a bearing, but for contact.

    They are those of the circumferential force of each cell, and that of the axial force to W.

    Parameters
    ----------
    inputs : friction.ShearInputs
    turning : CircumferentialInputs
    to_v, to_w : quantities.FilmSlopes
        `by_velocity` to V, and to W.
    by_pressure : ndarray, shape (n_c, n_a)
        By piezoviscosity, beyond the gradient [N/Pa].

    Returns
    -------
    CircumferentialSlopes
    """
    pressure, shearing, v, film, stress, area, constants = inputs
    w = turning.velocity
    across = _gradients(inputs, turning, pressure)
    along = gradients(pressure, area, constants.lower, constants.upper, constants.dy)
    s = speed(inputs, turning)
    dry = -area * stress / s
    crosswise = -dry * v * w / (s * s)
    return CircumferentialSlopes(
        film=_by(inputs, to_w.by_film, w, across),
        own=-area * shearing * film[COUETTE]
        + _by(inputs, to_w.by_velocity, w, across)
        + dry * (1.0 - (w / s) * (w / s)),
        axial=_by(inputs, to_v.by_velocity, w, across) + crosswise,
        shearing=-area * film[COUETTE] * w,
        gradient=area * film[POISEUILLE],
        pressure=by_pressure,
        axial_across=_by(inputs, to_w.by_velocity, v, along) + crosswise,
    )


@compilable
def force_changes(
    slopes: CircumferentialSlopes,
    shared: ForceSlopes,
    turning: CircumferentialInputs,
    changes: Changes,
    shear: Array,
    around: Array,
) -> None:
    """Compute the changes of the forces of a bearing, but for contact.

    Parameters
    ----------
    slopes : CircumferentialSlopes
    shared : friction.ForceSlopes
    turning : CircumferentialInputs
    changes : Changes
    shear : ndarray, shape (m, n_c, n_a)
        Changes of the axial force by `friction.force_changes`, with no boundary stress; what W and
        the asperities add is added in place [N].
    around : ndarray, shape (m, n_c, n_a)
        Overwritten: changes of the circumferential force [N].
    """
    dfilm, dv, dw, dunknown = changes
    dpressure = shared.pressure_share * dunknown
    dgradient = np.empty(dfilm.shape)
    for q in range(dfilm.shape[0]):
        put(
            dgradient[q],
            gradients_around(dpressure[q], shared.area, 0.0, turning.dx, turning.ring),
        )
    put(shear, shear + slopes.axial_across * dw)
    put(
        around,
        slopes.film * dfilm
        + slopes.own * dw
        + slopes.axial * dv
        + slopes.shearing * shared.fraction_share * dunknown
        + slopes.pressure * dpressure
        + slopes.gradient * dgradient,
    )
