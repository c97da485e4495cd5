"""Derivatives of the forces at the end of a step, to film thickness and velocities there.

`linearise` computes the derivatives that all directions share, and `changes` the changes of the
forces for any directions. Python runs both (`model`), and a native FMU compiles them (`native`).
"""

from typing import Annotated, NamedTuple

import numpy as np

from ..master.fmi.compiled import compilable, numbered
from .balance.film_step import film_slopes, solutions
from .balance.tangent import apply_stencils
from .common.grid import Array, Entrainment, Field, Stencil, put
from .common.quantities import COUETTE, FilmSlopes
from .constants import FilmConstants
from .laws import cavitation, circumferential, coating, friction
from .laws.circumferential import Changes, CircumferentialSlopes
from .laws.contact import contact_changes
from .laws.friction import ForceSlopes, ShearInputs
from .laws.piezoviscosity import TruePressure, raised
from .solvers.blocks import Factors
from .solvers.sparse import LinearSolver
from .state import LastStep

FORCE = numbered("normal", "along", "around")  # axis of `forces` in `changes`

StencilPair = Annotated[Array, "2, 5, n_c, n_a"]


class Linearisation(NamedTuple):
    """Derivatives that all directions of a tangent share.

    stencil, stencil_around : ndarray, shape (2, 5, n_c, n_a), of the balance, `film_slopes`, the
    velocity the axial and the circumferential one; that of a skirt of shape (0, 0, 0, 0);
    film : friction.ForceSlopes; around : circumferential.CircumferentialSlopes;
    weight : ndarray, shape (n_c, n_a), c k of Eq. (L3) [m/Pa];
    contact_pressure, contact_shear, contact_around : ndarray, shape (5, n_c, n_a), derivatives of
    the contact's forces to the film thickness of a cell and its neighbours, as of
    `contact.Contact` [N/m].
    Absent members have the shape (0, ..).
    """

    stencil: StencilPair
    stencil_around: StencilPair
    film: ForceSlopes
    around: CircumferentialSlopes
    weight: Field
    contact_pressure: Stencil
    contact_shear: Stencil
    contact_around: Stencil


class Directions(NamedTuple):
    """Changes of film thickness without coating deflection [m], V and W [m/s], (m, n_c, n_a)."""

    film: Array
    velocity: Array
    turning: Array


# ---- parts


@compilable
def _by_pressure(shear: ShearInputs, velocity: Array, couette: Array, under: TruePressure) -> Array:
    """Return the derivative of a viscous force to the pressure by the viscosity [N/Pa]."""
    if under.ratio.size == 0:
        return np.zeros(velocity.shape)
    return -shear.area * shear.shearing * velocity * couette * under.slope


@compilable
def _add_contact_changes(slope: Array, film: Array, deflection: Array, force: Array) -> None:
    """Add the changes of a contact force, shape (m, n_c, n_a), in place."""
    put(force, force + contact_changes(slope, film, deflection))


# ---- both steps of a tangent


@compilable
def balance_slopes(
    fixed: FilmConstants, last: LastStep, slopes: FilmSlopes, around: float, along: float
) -> Array:
    """Return `film_step.film_slopes` of a step.

    around, along : derivatives of the entrainment velocities to the velocity of `slopes`.
    """
    velocity = last.shear.velocity
    return film_slopes(
        last.film,
        slopes,
        Entrainment(fixed.share * last.turning.velocity, fixed.share * velocity),
        Entrainment(np.full(velocity.shape, around), np.full(velocity.shape, along)),
        last.filling,
        last.edges,
        last.length,
        fixed.domain,
    )


@compilable
def _raised_slopes(slopes: FilmSlopes, ratio: Array) -> FilmSlopes:
    """Return the derivatives of `raised` quantities."""
    return FilmSlopes(raised(slopes.by_film, ratio), raised(slopes.by_velocity, ratio))


@compilable
def linearise(fixed: FilmConstants, last: LastStep) -> Linearisation:
    """Return the derivatives of the last step that all directions share."""
    shear = last.shear
    under = last.under
    turning = last.turning
    couette = last.film[COUETTE]
    none = np.zeros((0, 0))
    weight = none
    if fixed.surfaces.compliance > 0.0:
        compliance = fixed.surfaces.compliance
        weight = compliance * coating.yielding(compliance, last.pressure_slope)
    of_pressure, of_fraction = cavitation.shares(fixed.domain.model, last.unknown, last.full)
    if under.ratio.size > 0:
        of_pressure = of_pressure * under.ratio  # dp/dq, Eq. (O6)
    if not fixed.surfaces.by_oil:
        of_fraction = np.zeros(of_fraction.shape)
    to_v = _raised_slopes(last.slopes, under.ratio)
    by_pressure = _by_pressure(shear, shear.velocity, couette, under)
    along_axis = friction.shear_slopes(shear, turning.velocity, to_v, by_pressure)
    film = ForceSlopes(along_axis, shear.area, of_pressure, of_fraction, shear.constants.dy)
    normal = np.zeros((0, 0, 0))
    along = normal
    across = normal
    if last.touching:
        speed = circumferential.speed(shear, turning)
        dry = -shear.area * last.stress_slope
        normal = shear.area * last.pressure_slope
        along = dry * shear.velocity / speed  # Eq. (F2), Eq. (F7)
        if fixed.domain.bearing:
            across = dry * turning.velocity / speed
    to_turning = np.zeros((0, 0, 0, 0))
    around = CircumferentialSlopes(
        film=none,
        own=none,
        axial=none,
        shearing=none,
        gradient=none,
        pressure=none,
        axial_across=none,
    )
    if fixed.domain.bearing:
        to_turning = balance_slopes(fixed, last, last.slopes_around, fixed.share, 0.0)
        to_w = _raised_slopes(last.slopes_around, under.ratio)
        by_pressure = _by_pressure(shear, turning.velocity, couette, under)
        around = circumferential.force_slopes(shear, turning, to_v, to_w, by_pressure)
    stencil = balance_slopes(fixed, last, last.slopes, 0.0, fixed.share)
    return Linearisation(
        stencil=stencil,
        stencil_around=to_turning,
        film=film,
        around=around,
        weight=weight,
        contact_pressure=normal,
        contact_shear=along,
        contact_around=across,
    )


@compilable
def changes(
    fixed: FilmConstants,
    last: LastStep,
    linear: Linearisation,
    directions: Directions,
    solver: LinearSolver | Factors,
    right: Array,
    forces: Array,
) -> None:
    """Compute the changes of the forces at the end of the last step.

    The state at its beginning is constant.

    Parameters
    ----------
    fixed : FilmConstants
    last : LastStep
    linear : Linearisation
    directions : Directions
    solver : sparse.LinearSolver or blocks.Factors
        With the factorisation of the step.
    right : ndarray, shape (m, n_c, n_a)
        Overwritten: work array for the changes of the signed unknown.
    forces : ndarray, shape (2, m, n_c, n_a), of a bearing (3, m, n_c, n_a)
        Overwritten: changes of pressure, friction and circumferential force [N].
    """
    hard, velocity, turning = directions
    still = np.zeros(hard.shape)
    deflection = still
    by_contact = still
    moved = hard
    coated = linear.weight.size > 0
    if coated:
        by_contact = contact_changes(last.pressure_slope, hard, still)
        moved = hard + linear.weight * by_contact
    apply_stencils(linear.stencil, moved, velocity, right)
    if fixed.domain.bearing:
        added = np.empty(hard.shape)
        apply_stencils(linear.stencil_around, still, turning, added)
        right += added
    unknown = solutions(solver, last.stencil, right)  # Eq. (E6)
    film = hard
    if coated:
        pressed = by_contact + linear.film.pressure_share * unknown
        deflection = linear.weight * pressed  # Eq. (L3)
        film = hard + deflection
    friction.force_changes(
        linear.film, film, velocity, unknown, forces[FORCE.normal], forces[FORCE.along]
    )
    if last.touching:
        _add_contact_changes(linear.contact_pressure, hard, deflection, forces[FORCE.normal])
        _add_contact_changes(linear.contact_shear, hard, deflection, forces[FORCE.along])
    if not fixed.domain.bearing:
        return
    of_all = Changes(film, velocity, turning, unknown)
    circumferential.force_changes(
        linear.around, linear.film, last.turning, of_all, forces[FORCE.along], forces[FORCE.around]
    )
    if last.touching:
        _add_contact_changes(linear.contact_around, hard, deflection, forces[FORCE.around])
