"""Derivatives of the forces at the end of a step, to film thickness and velocities there.

`linearise` computes once what all directions share, and `changes` the forces' changes for any
directions. Python runs both as written (`model`), and a native FMU compiles them (`native`).
"""

from typing import Annotated, NamedTuple

import numpy as np

from ..master.fmi.compiled import compilable, compiled, numbered
from .balance.film_step import film_slopes, solutions
from .balance.films import COUETTE, FilmSlopes
from .balance.grid import Array, Entrainment, Field, Stencil
from .balance.tangent import apply_stencils
from .constants import FilmConstants
from .laws import cavitation, circumferential, coating, friction
from .laws.circumferential import Changes, CircumferentialSlopes
from .laws.contact import contact_changes
from .laws.friction import ForceSlopes, ShearInputs
from .laws.piezoviscosity import TruePressure, raised
from .solvers.blocks import Factors
from .solvers.sparse import LinearSolver
from .step import LastStep

FORCE = numbered("normal", "along", "around")  # forces whose changes are asked for

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
    What there is not is of shape (0, ..).
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
    """Changes of hard film [m], V and W [m/s], each ndarray of shape (m, n_c, n_a)."""

    film: Array
    velocity: Array
    turning: Array


# ---- parts


@compiled
def force_slopes(
    shear: ShearInputs,
    film: Array,
    slopes: FilmSlopes,
    shares: tuple[Array, Array],
    under: TruePressure,
    by_oil: bool,
):
    """Return the derivatives of the forces that all directions share, but for contact.

    Parameters
    ----------
    shear : friction.ShearInputs
    film : ndarray, shape (6, n_c, n_a)
        Quantities of `films`, without the viscosity under pressure.
    slopes : films.FilmSlopes
        Of `film`.
    shares : tuple of ndarray, shape (n_c, n_a)
        Derivatives of reduced pressure and film fraction to the signed unknown.
    under : piezoviscosity.TruePressure
    by_oil : bool
        Whether the oil alone shears in cavities.

    Returns
    -------
    friction.ForceSlopes
    """
    of_pressure, of_fraction = shares
    n_c, n_a = of_pressure.shape
    by_pressure = np.zeros((n_c, n_a))
    if under.ratio.size > 0:
        of_pressure = of_pressure.copy()
        for i in range(n_c):
            for j in range(n_a):
                sheared = -shear.area[i, j] * shear.shearing[i, j] * shear.velocity[i, j]
                by_pressure[i, j] = sheared * film[COUETTE, i, j] * under.slope[i, j]
                of_pressure[i, j] *= under.ratio[i, j]  # dp/dq, Eq. (O6)
    by_film = raised(slopes.by_film, under.ratio)
    by_velocity = raised(slopes.by_velocity, under.ratio)
    if not by_oil:
        of_fraction = np.zeros((n_c, n_a))
    return ForceSlopes(
        friction.shear_slopes(shear, FilmSlopes(by_film, by_velocity), by_pressure),
        shear.area,
        of_pressure,
        of_fraction,
        shear.constants.dy,
    )


@compiled
def contact_slopes(shear: ShearInputs, pressure_slope: Array, stress_slope: Array):
    """Return the derivatives of the contact forces to the film thickness.

    They are those to the film thickness of a cell and of its neighbours.

    Parameters
    ----------
    shear : friction.ShearInputs
    pressure_slope, stress_slope : ndarray, shape (5, n_c, n_a)
        Of `contact.Contact` [Pa/m].

    Returns
    -------
    normal, along : ndarray, shape (5, n_c, n_a)
        [N/m].
    """
    _, n_c, n_a = pressure_slope.shape
    rounding = shear.constants.rounding_velocity
    normal = np.empty((5, n_c, n_a))
    along = np.empty((5, n_c, n_a))
    for k in range(5):
        for i in range(n_c):
            for j in range(n_a):
                area = shear.area[i, j]
                v = shear.velocity[i, j]
                speed = np.sqrt(v * v + rounding * rounding)
                normal[k, i, j] = area * pressure_slope[k, i, j]
                # Eq. (F2)
                along[k, i, j] = -area * stress_slope[k, i, j] * v / speed
    return normal, along


@compiled
def add_contact_changes(slope: Array, film_thickness: Array, deflection: Array, force: Array):
    """Add the changes of a contact force, as by `contact.contact_changes`, in place.

    The shape is (m, n_c, n_a).
    """
    changes = contact_changes(slope, film_thickness, deflection)
    for q in range(force.shape[0]):
        for i in range(force.shape[1]):
            for j in range(force.shape[2]):
                force[q, i, j] += changes[q, i, j]


# ---- both steps of a tangent


@compilable
def balance_slopes(
    fixed: FilmConstants, last: LastStep, slopes: FilmSlopes, around: float, along: float
) -> Array:
    """Return `film_step.film_slopes` of a step.

    around, along : derivatives of the entrainment velocities to the velocity of `slopes`.
    """
    velocity = last.shear.velocity
    axial = fixed.share * velocity
    entrainment = Entrainment(last.turning.velocity, axial)
    if fixed.bearing:
        entrainment = Entrainment(fixed.share * last.turning.velocity, axial)
    return film_slopes(
        last.film,
        slopes,
        entrainment,
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
    by_oil = fixed.surfaces.by_oil
    shares = cavitation.shares(fixed.domain.model, last.unknown, last.full)
    stencil = balance_slopes(fixed, last, last.slopes, 0.0, fixed.share)
    none = np.zeros((0, 0))
    no_stencil = np.zeros((0, 0, 0))
    weight = none
    if fixed.surfaces.compliance > 0.0:
        compliance = fixed.surfaces.compliance
        weight = compliance * coating.yielding(compliance, last.pressure_slope)
    normal = no_stencil
    along = no_stencil
    across = no_stencil
    if last.touching:
        normal, along = contact_slopes(shear, last.pressure_slope, last.stress_slope)
    if not fixed.bearing:
        film = force_slopes(shear, last.film, last.slopes, shares, under, by_oil)
        around = CircumferentialSlopes(none, none, none, none, none, none, none, none)
        return Linearisation(
            stencil, np.zeros((0, 0, 0, 0)), film, around, weight, normal, along, across
        )
    turning = last.turning
    by_pressure = np.zeros(last.unknown.shape)
    if under.ratio.size > 0:
        sheared = -shear.area * shear.shearing * turning.velocity * last.film[COUETTE]
        by_pressure = sheared * under.slope
    around = circumferential.force_slopes(
        shear,
        turning,
        _raised_slopes(last.slopes, under.ratio),
        _raised_slopes(last.slopes_around, under.ratio),
        by_pressure,
    )
    if last.touching:
        axial, tangential = circumferential.boundary_shares(shear, turning)
        along = axial * last.stress_slope
        across = tangential * last.stress_slope
    viscous = ShearInputs(
        shear.pressure,
        shear.shearing,
        shear.velocity,
        shear.film,
        np.zeros(last.unknown.shape),  # stands in `around`
        shear.area,
        shear.constants,
    )
    film = force_slopes(viscous, last.film, last.slopes, shares, under, by_oil)
    to_turning = balance_slopes(fixed, last, last.slopes_around, fixed.share, 0.0)
    return Linearisation(stencil, to_turning, film, around, weight, normal, along, across)


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

    The state at its beginning is held.

    Parameters
    ----------
    fixed : FilmConstants
    last : LastStep
    linear : Linearisation
    directions : Directions
    solver : sparse.LinearSolver or blocks.Factors
        With the factorisation of the step.
    right : ndarray, shape (m, n_c, n_a)
        Room for the changes of the signed unknown.
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
        moved = coating.pushed(linear.weight, by_contact, hard)
    apply_stencils(linear.stencil, moved, velocity, right)
    if fixed.bearing:
        added = np.empty(hard.shape)
        apply_stencils(linear.stencil_around, still, turning, added)
        right += added
    unknown = solutions(solver, last.stencil, right)  # Eq. (E6)
    film = hard
    if coated:
        share = linear.film.pressure_share
        deflection = coating.deflection_changes(linear.weight, by_contact, share, unknown)
        film = hard + deflection
    friction.force_changes(
        linear.film, film, velocity, unknown, forces[FORCE.normal], forces[FORCE.along]
    )
    if last.touching:
        add_contact_changes(linear.contact_pressure, hard, deflection, forces[FORCE.normal])
        add_contact_changes(linear.contact_shear, hard, deflection, forces[FORCE.along])
    if not fixed.bearing:
        return
    of_all = Changes(film, velocity, turning, unknown)
    circumferential.force_changes(
        linear.around, linear.film, last.turning, of_all, forces[FORCE.along], forces[FORCE.around]
    )
    if last.touching:
        add_contact_changes(linear.contact_around, hard, deflection, forces[FORCE.around])
