"""Parts of a step, for the model in Python and the native FMU.

They are its beginning, its forces, its memory, and the derivatives of its forces.
"""

from typing import Annotated, NamedTuple

import numpy as np

from ..master.fmi.block import is_finite
from ..master.fmi.compiled import compiled
from .balance import storage, transport
from .balance.film_step import Domain, FilmSolution, sliding_velocity
from .balance.storage import ContentHistory, EulerStep
from .balance.transport import StepRatios
from .common.faults import FAULT, refuse
from .common.grid import (
    Array,
    Cells,
    Entrainment,
    Field,
    Flags,
    sum_of_products,
)
from .common.quantities import Carriers
from .laws import friction
from .laws.asperity import MOST_OVERLAP, ContactConstants
from .laws.contact import Contact, contact
from .laws.friction import FrictionPowers, ShearConstants, ShearForces, ShearInputs
from .summary import Halves, Summary, summarise

# ---- beginning of a step


class PreviousFilm(NamedTuple):
    """Past of a film at the beginning of a step.

    unknown, unknown_before : signed unknown at the end of the last two steps, which are
    extrapolated to start the next one;
    pressure : at the end of the last step, above cavitation pressure [Pa];
    content, growth, growth_before : film fraction times stored film, 0 in openings [m], and its
    growth in the last two steps [m/s], `storage.ContentHistory`;
    deflection : of the coating [m];
    film, film_before : `oil_rows.carriers` at the end of the last two steps;
    passed, travel : volume that passed each face in the last step [m3], and travel of the
    entrainment there [m]; axial faces, of a bearing those across i, shape (n_c + 1, n_a);
    step : length of the last step [s], 0 at the start.
    """

    unknown: Field
    unknown_before: Field
    pressure: Field
    content: Field
    growth: Field
    growth_before: Field
    deflection: Field
    film: Carriers
    film_before: Carriers
    passed: Annotated[Array, "n_c + 1, n_a + 1"]
    travel: Annotated[Array, "n_c + 1, n_a + 1"]
    step: float


class EulerStart(NamedTuple):
    """Beginning of a step.

    pace : transport.StepRatios; start : storage.EulerStep;
    guess : ndarray of bool, shape (n_c, n_a), cells that are full by extrapolation of the unknown.
    """

    pace: StepRatios
    start: EulerStep
    guess: Flags


@compiled
def begin(before: PreviousFilm, step: float, cells: Cells):
    """Return the beginning of a step of length `step` [s]."""
    past = ContentHistory(before.content, before.growth, before.growth_before, before.step)
    start = storage.euler_step(past, step, cells)
    n_c, n_a = before.unknown.shape
    ratio = step / before.step if before.step > 0.0 else 0.0
    guess = np.empty((n_c, n_a), np.bool_)
    for i in range(n_c):
        for j in range(n_a):
            u = before.unknown[i, j]
            guess[i, j] = u + ratio * (u - before.unknown_before[i, j]) > 0.0
    return EulerStart(transport.pace(step, before.step, start.length), start, guess)


# ---- surfaces


class Surfaces(NamedTuple):
    """Constants of the surfaces during a run.

    area : ndarray, shape (n_c, n_a), lubricated area of each cell and its images, 0 in openings
    [m2];
    contact : asperity.ContactConstants; halves : summary.Halves;
    compliance, coating_thickness : of a coating [m/Pa], [m], 0 without;
    cavitation_pressure [Pa]; rounding_velocity : v0 of `friction` [m/s];
    by_oil : whether the oil alone shears in cavities.
    """

    area: Array
    contact: ContactConstants
    halves: Halves
    compliance: float
    coating_thickness: float
    cavitation_pressure: float
    rounding_velocity: float
    by_oil: bool


@compiled
def check_film(film_thickness: Array, surfaces: Surfaces, faults: Array):
    """Note a fault at the first film that is not finite, or where surfaces overlap most.

    The film thickness is without the deflection of a coating.
    """
    for i in range(film_thickness.shape[0]):
        for j in range(film_thickness.shape[1]):
            if not np.isfinite(film_thickness[i, j]):
                refuse(faults, FAULT.film_not_finite, i, j, film_thickness[i, j], 0.0, 0.0)
                return
    check_overlap(film_thickness, surfaces, surfaces.coating_thickness, FAULT.overlap, faults)


@compiled
def check_overlap(
    film_thickness: Array, surfaces: Surfaces, layer: float, fault: int, faults: Array
):
    """Note a fault where surfaces overlap most, if by more than Eq. (A14) allows.

    layer : thickness of a coating whose deflection is not part of the film thickness [m].
    """
    low_i = -1
    low_j = -1
    least = 0.0 - layer - MOST_OVERLAP * surfaces.contact.roughness_rms  # Eq. (A14)
    lowest = least
    for i in range(film_thickness.shape[0]):
        for j in range(film_thickness.shape[1]):
            h = film_thickness[i, j]
            if surfaces.area[i, j] > 0.0 and h <= least and (low_i < 0 or h < lowest):
                low_i = i
                low_j = j
                lowest = h
    if low_i >= 0:
        refuse(faults, fault, low_i, low_j, lowest, least, 0.0)


# ---- forces


class SolvedFilm(NamedTuple):
    """Data of a solved film for its forces; arrays of shape (n_c, n_a).

    hard_film, deflection : film thickness without the deflection of a coating; deflection [m];
    steps : ndarray, shape (2, n_c, n_a), `contact.profile_steps`;
    velocity, turning : V, and W, which is 0 on a skirt [m/s];
    quantities : ndarray, shape (6, n_c, n_a), of `films`, with the viscosity of shear under
    pressure;
    pressure, fraction : above cavitation pressure [Pa], film fraction [-];
    lower, upper : pressure at both edges, above cavitation pressure [Pa].
    """

    hard_film: Array
    deflection: Array
    steps: Array
    velocity: Array
    turning: Array
    quantities: Array
    pressure: Array
    fraction: Array
    lower: float
    upper: float


class Forces(NamedTuple):
    """Forces of a film on the skirt, and their power.

    pressure, friction : ndarray, shape (n_c, n_a), nodal forces of a cell and its images [N];
    absolute : ndarray, shape (n_c, n_a), film pressure [Pa];
    contact : contact.Contact; touching : whether any cell is in contact;
    shear : friction.ShearInputs; summary : summary.Summary;
    boundary_power : of asperity friction along the axis [W];
    stored : elastic energy of asperities and coating [J];
    volume : between the surfaces [m3].
    """

    pressure: Array
    friction: Array
    absolute: Array
    contact: Contact
    touching: bool
    shear: ShearInputs
    summary: Summary
    boundary_power: float
    stored: float
    volume: float


@compiled
def shear_inputs(film: SolvedFilm, touching: Contact, surfaces: Surfaces, domain: Domain):
    """Return the quantities that friction depends on."""
    shearing = film.fraction
    if not surfaces.by_oil:
        shearing = np.ones(film.fraction.shape)
    constants = ShearConstants(film.lower, film.upper, domain.cells.dy, surfaces.rounding_velocity)
    return ShearInputs(
        pressure=film.pressure,
        shearing=shearing,
        velocity=film.velocity,
        film=film.quantities,
        boundary_stress=touching.shear_stress,
        area=surfaces.area,
        constants=constants,
    )


@compiled
def forces(film: SolvedFilm, surfaces: Surfaces, domain: Domain, faults: Array):
    """Return contact, forces and sums of a solved film; note a fault if they are not finite.

    Eq. (A10):  U = sum over cells of  A (e + delta^2 / (2 C))

    U is the stored energy, e that by area, Eq. (A9), delta the deflection of the coating and C its
    compliance.

    Returns
    -------
    Forces
    """
    area = surfaces.area
    velocity = film.velocity
    n_c, n_a = velocity.shape
    touching = contact(
        film.hard_film,
        film.deflection,
        film.steps,
        domain.open_cells,
        surfaces.contact,
        domain.cells,
    )
    shear = shear_inputs(film, touching, surfaces, domain)
    viscous = friction.viscous_force(shear)
    boundary = friction.boundary_force(shear, film.turning)
    normal = np.empty((n_c, n_a))
    along = np.empty((n_c, n_a))
    absolute = np.empty((n_c, n_a))
    thickness = np.empty((n_c, n_a))
    boundary_power = 0.0
    stored = 0.0
    volume = 0.0
    touches = False
    for i in range(n_c):
        for j in range(n_a):
            h = film.hard_film[i, j] + film.deflection[i, j]
            thickness[i, j] = np.inf if domain.open_cells[i, j] else h
            absolute[i, j] = film.pressure[i, j] + surfaces.cavitation_pressure
            normal[i, j] = (absolute[i, j] + touching.pressure[i, j]) * area[i, j]
            along[i, j] = viscous[i, j] + boundary[i, j]
            boundary_power -= boundary[i, j] * velocity[i, j]  # Eq. (F3)
            energy = touching.energy[i, j]
            if surfaces.compliance > 0.0:
                delta = film.deflection[i, j]
                energy += delta * delta / (2.0 * surfaces.compliance)
            stored += area[i, j] * energy  # Eq. (A10)
            volume += area[i, j] * h
            touches = touches or touching.area_fraction[i, j] != 0.0
    whole = summarise(
        thickness,
        velocity,
        absolute,
        normal,
        ShearForces(viscous, boundary),
        touching.area_fraction,
        surfaces.halves,
        domain.cells,
    )
    sums = whole.radial.thrust + whole.radial.anti_thrust
    if not np.isfinite(sums + whole.friction.thrust + whole.friction.anti_thrust):
        refuse_forces(normal, along, film, faults)
    return Forces(
        pressure=normal,
        friction=along,
        absolute=absolute,
        contact=touching,
        touching=touches,
        shear=shear,
        summary=whole,
        boundary_power=boundary_power,
        stored=stored,
        volume=volume,
    )


@compiled
def refuse_forces(normal: Array, along: Array, film: SolvedFilm, faults: Array):
    """Note the first cell whose forces are not finite."""
    for i in range(normal.shape[0]):
        for j in range(normal.shape[1]):
            if not np.isfinite(normal[i, j] + along[i, j]):
                h = film.hard_film[i, j] + film.deflection[i, j]
                refuse(faults, FAULT.forces_not_finite, i, j, h, film.velocity[i, j], 0.0)
                return


# ---- results for the next step


class OilTransport(NamedTuple):
    """Oil that moved in a step.

    growth : of the content, shape (n_c, n_a) [m/s]; passed, travel : as in `PreviousFilm`.
    """

    growth: Array
    passed: Array
    travel: Array


@compiled
def oil_transport(
    before: PreviousFilm,
    begun: EulerStart,
    solution: FilmSolution,
    entrainment: Entrainment,
    step: float,
    domain: Domain,
):
    """Return the oil that moved in a step.

    Parameters
    ----------
    before : PreviousFilm
    begun : EulerStart
    solution : film_step.FilmSolution
    entrainment : grid.Entrainment
        At the end of the step [m/s].
    step : float
        [s].
    domain : film_step.Domain

    Returns
    -------
    OilTransport
    """
    n_c, n_a = before.content.shape
    pace = begun.pace
    length = begun.start.length
    growth = np.empty((n_c, n_a))
    for i in range(n_c):
        for j in range(n_a):
            growth[i, j] = (solution.content[i, j] - before.content[i, j]) / step
    flow = solution.flow_around if domain.bearing else solution.axial_flow
    velocity = sliding_velocity(entrainment, domain)
    passed = np.empty(flow.shape)
    travel = np.empty(flow.shape)
    for i in range(flow.shape[0]):
        for j in range(flow.shape[1]):
            passed[i, j] = pace.share * before.passed[i, j] + length * flow[i, j]
            moved = length * velocity[i, j]
            travel[i, j] = pace.share * before.travel[i, j] + moved  # Eq. (T15)
    return OilTransport(growth, passed, travel)


@compiled
def leaving_above(axial_flow: Array) -> float:
    """Return the oil flow over the upper edge of the cells where it leaves, >= 0 [m3/s].

    `axial_flow` is the flow through the axial faces towards the head, shape (n_c, n_a + 1).
    """
    leaving = 0.0
    for i in range(axial_flow.shape[0]):
        leaving += max(axial_flow[i, axial_flow.shape[1] - 1], 0.0)
    return leaving


class Totals(NamedTuple):
    """Totals that continue from step to step.

    friction_work, boundary_work : friction work since the start, and the part of the asperities in
    it [J]; stored, volume : as in `Forces`.
    """

    friction_work: float
    boundary_work: float
    stored: float
    volume: float


class Account(NamedTuple):
    """Sums at the end of a step.

    totals : Totals; boundary_share : of the asperities in the friction work [-]; oil : in the film
    [m3]; received_power, heat : means over the step by Eq. (A11), the heat is its bracket [W].
    """

    totals: Totals
    boundary_share: float
    oil: float
    received_power: float
    heat: float


class BalanceScalars(NamedTuple):
    """Members of `step.Scalars` that are not forces.

    flows : (lower, upper, openings); outflow : over the upper edge, where oil leaves.
    """

    boundary_share: float
    received_power: float
    flows: tuple[float, float, float]
    outflow: float
    imbalance: float
    oil_in_film: float
    heat: float


@compiled
def account(
    before: PreviousFilm,
    totals: Totals,
    acted: Forces,
    powers: FrictionPowers,
    solution: FilmSolution,
    growth: Array,
    cavitation_pressure: float,
    step: float,
):
    """Return the sums at the end of a step, with the mean power that the film took.

    Eq. (A11):  E/H = [P - sum over cells of  A (p_0 + p_1)/2 (c_1 - c_0)/H] + (U_1 - U_0)/H
                      - p_c (sum over cells of  A dh)/H

    The sum with its sign is the heat of pressure flow less the work of the pressure around the
    film: by Eq. (E1) it is flow times pressure drop over all faces, less inflow times pressure over
    edges and openings. With P, Eqs. (F3), (F8), it is the heat Q. In a full film, except for the
    error of the grid in h dp/dy,

                    Q = sum over faces of  K (p_a - p_b)^2 + sum over cells of  A c_v V^2

    with K of Eq. (E3) and c_v, the c of Eq. (F1).

    In a full film E is the work of the surfaces to round-off. The surfaces work on h, and the film
    stores the content c = f s. In a cell that fills, the surfaces do more work, which is lost. At
    the floor of the film or with flow factors, s is not h. There E omits A (p_0 + p_1)/2 (dh - ds).

    Parameters
    ----------
    before : PreviousFilm
    totals : Totals
        At the beginning.
    acted : Forces
    powers : FrictionPowers
    solution : film_step.FilmSolution
    growth : ndarray, shape (n_c, n_a)
        Of `OilTransport`.
    cavitation_pressure : float
        p_c [Pa].
    step : float
        H [s].

    Returns
    -------
    Account
    """
    friction_work = totals.friction_work + step * powers.friction
    boundary_work = totals.boundary_work + step * powers.boundary
    spent = max(friction_work, boundary_work)  # a film that pressure drives does negative work
    share = boundary_work / spent if spent > 0.0 else 0.0
    area = acted.shear.area
    pressed = 0.0
    for i in range(growth.shape[0]):
        for j in range(growth.shape[1]):
            mean = 0.5 * (before.pressure[i, j] + acted.shear.pressure[i, j])
            pressed += area[i, j] * mean * growth[i, j]
    # Eq. (A11)
    heat = powers.friction - pressed
    gained = acted.stored - totals.stored - cavitation_pressure * (acted.volume - totals.volume)
    received = heat + gained / step
    after = Totals(friction_work, boundary_work, acted.stored, acted.volume)
    return Account(after, share, sum_of_products(solution.content, area), received, heat)


@compiled
def check_finite(film: PreviousFilm, totals: Totals, faults: Array):
    """Note a fault where the next step would start from a number that is not finite."""
    works = totals.friction_work + totals.boundary_work
    if not (np.isfinite(works) and is_finite(film.film) and is_finite(film.growth)):
        refuse(faults, FAULT.overflow, 0, 0, film.step, works, 0.0)
