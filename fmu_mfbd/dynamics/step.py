"""A step of the bodies and its derivatives, for the Python and the native FMU."""

from collections import namedtuple
from typing import Any, NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable
from ..mechanism.bdf2 import predicted_of, reach_of
from ..mechanism.carrier import FIXED, block_motion_from
from ..mechanism.cylinder import piston_of
from ..mechanism.derivative import drive_inertia
from ..mechanism.floating_frame import TURN, Y
from ..mechanism.generalised_alpha import Coefficients, Motion
from ..mechanism.loads import loads_at
from ..mechanism.motion import chain_motion
from ..mechanism.slider_crank import CrankMotion, driven, height, moved_inertia
from .account import EnergyAccount, account
from .contradictions import FAULT
from .drive import Scalars, scalars_of
from .gas_on_bore import WallPressures
from .instant import Instant, end_of_step, load_of, of_skirt
from .parameters import GAS_SOURCES, Settings
from .pin_films import applied_forces, damp_modes, film_pushes, pin_films
from .response import (
    MovedFilms,
    Response,
    StepEnd,
    StepInputs,
    moved_films,
    pushed_motion,
    response,
)
from .skirt_films import (
    AxialMotion,
    FilmChange,
    forces_by_film,
    skirt_films,
    skirt_slopes,
    total_forces,
)
from .speed_table import SpeedTable, crank_motion
from .state import PistonState, state_at
from .system import BodySystem, OtherForces, StepProblem, rigid_piston, skirt_modes
from .tables import GasTable, gas_pressure
from .thermal_growth import (
    ColdWalls,
    Radii,
    field_growth,
    field_work,
    growth_work,
    level_of,
    oil_temperatures,
    thermal_opening,
)

GAS = namedtuple("GasSource", GAS_SOURCES)(*range(1, 1 + len(GAS_SOURCES)))
"""Numbers of the choices in `GAS_SOURCES`."""

ANGLES_OF_MEASURES = 6
"""Number of crank angles of `film_measures`."""

START_PASSES = 40
"""Maximum number of iterations for the start of a free crank. Each gains a digit or more."""


class BodyModel(NamedTuple):
    """Bodies, films and parameters of a run.

    Parameters
    ----------
    parts : BodySystem
    settings : Settings
    gas : GasTable
    gas_area : float
        Area of the bore [m2].
    speed : SpeedTable
    mounted : bool
        Whether the block moves.
    radii : Radii
    cold : ColdWalls
    """

    parts: BodySystem
    settings: Settings
    gas: GasTable
    gas_area: float
    speed: SpeedTable
    mounted: bool
    radii: Radii
    cold: ColdWalls


class StepResult(NamedTuple):
    """End of a step: motion and films, outputs, and what the next step and derivatives need."""

    instant: Instant
    scalars: Scalars
    state: PistonState
    last: StepEnd
    oil_temperature: np.ndarray


@compilable
def coordinates_of(model: BodyModel) -> int:
    """Return the number of coordinates of all bodies."""
    return len(model.parts.kinds)


@compilable
def modes_of(model: BodyModel) -> tuple[int, int]:
    """Return the first and the end of the modal coordinates of piston and block."""
    first = model.parts.chain.joints.tip.shape[1]
    return first, first + skirt_modes(model.parts)


@compilable
def set_damping(model: BodyModel, p: Any) -> None:
    """Overwrite the damping of all modes."""
    damp_modes(model.parts.kinds, model.parts.chain, p)


# ---- a step


@compilable
def at_rest(crank: CrankMotion, position: np.ndarray, velocity: np.ndarray) -> PistonState:
    """Return the state before a start: a motion without accelerations."""
    none = np.zeros(len(position))
    return PistonState(
        time=0.0,
        crank_angle=crank.angle,
        crank_speed=crank.speed,
        crank_acceleration=crank.acceleration,
        crank_jerk=0.0,
        position=position,
        velocity=velocity,
        acceleration=none,
        auxiliary=none,
        mean_velocity=none,
        step=0.0,
        kinetic=0.0,
        other_forces=none,
        steps=0,
        thermal_opening=0.0,
        bore_deflection=np.zeros((0, 0)),
        field_growth=np.zeros(0),
    )


@compilable
def is_started(settings: Settings, crank: CrankMotion, state: PistonState) -> bool:
    """Return whether the start of a free crank needs no further pass.

    Eq. (K9) contains the accelerations of the piston, which change with that of the crank.
    """
    change = state.crank_acceleration - crank.acceleration
    free = settings.crank_free != 0.0
    return not free or abs(change) <= 1e-12 * abs(state.crank_acceleration)


@compilable
def crank_at_start(model: BodyModel, angle: float, speed: float) -> CrankMotion:
    """Return the motion of the crank at the start; `speed` is that without a table [rad/s]."""
    if len(model.speed.at) > 0:
        return crank_motion(model.speed, angle, 0.0, 0.0)
    return CrankMotion(angle, speed, 0.0)


@compilable
def crank_after(model: BodyModel, state: PistonState, step: float, speed: float) -> CrankMotion:
    """Return the motion of the crank a step [s] after a state.

    The crank follows its table. Without one, it has constant acceleration over the step, up to
    `speed`, the input at its end [rad/s].

    Eq. (K8):  free, order 2 in the step:  phi + h w + h^2 w'/2 + h^3 w''/6
               w + h w' + h^2 w''/2,  w' + h w''
    """
    if len(model.speed.at) > 0:
        return crank_motion(model.speed, state.crank_angle, state.time, step)
    if model.settings.crank_free == 0.0:
        now = CrankMotion(state.crank_angle, state.crank_speed, state.crank_acceleration)
        return driven(now, step, speed)
    # Eq. (K8)
    before = state.crank_acceleration
    after = before + step * state.crank_jerk
    end_speed = state.crank_speed + step * (before + after) / 2
    mean_speed = state.crank_speed + step * (2 * before + after) / 6
    return CrankMotion(state.crank_angle + step * mean_speed, end_speed, after)


@compilable
def warning_of(model: BodyModel, inputs: StepInputs) -> float:
    """Return the number of a warning in `contradictions.FAULTS`, -1 without one.

    It warns if input and table both give a gas pressure without a choice of `gas_source`, and of a
    load torque on a crank of prescribed speed, where it has no effect.
    """
    both = len(model.gas.angle) > 0 and inputs.gas_pressure != 0.0
    if both and model.settings.gas_source == GAS.either:
        return FAULT.gas_twice
    if inputs.load_torque != 0.0 and model.settings.crank_free == 0.0:
        return FAULT.torque_unused
    return -1.0


@compilable
def others_at(model: BodyModel, inputs: StepInputs, crank: CrankMotion) -> OtherForces:
    """Return the forces other than those of films, with the gas of input and table.

    Eq. (K29):  G = A_b (p - p_c)    p on the crown, p_c below the piston, A_b area of the bore
    """
    source = model.settings.gas_source
    pressure = 0.0 if source == GAS.table else inputs.gas_pressure
    if len(model.gas.angle) > 0 and source != GAS.input:
        pressure += gas_pressure(model.gas, crank.angle)
    gas = model.gas_area * (pressure - inputs.crankcase_pressure)  # Eq. (K29)
    walls = WallPressures(pressure, inputs.land_pressure)
    return OtherForces(gas, inputs.rings, walls, inputs.carrier)


@compilable
def instant_of(model: BodyModel, step: StepProblem, inputs: StepInputs) -> Instant:
    """Return everything at the end of a step; its evaluations are 0 if it is not solved."""
    return end_of_step(model.parts, step, inputs.skirt, inputs.pins)


class HeatEffect(NamedTuple):
    """Effect of the walls' temperatures on the films of the skirt at the end of a step.

    Parameters
    ----------
    opening : float
        By the levels, Eq. (I12) [m].
    growth : ndarray
        As of `thermal_growth.field_growth` [m].
    work : float
        Work of the films on the growing walls in the step [J].
    oil : ndarray
        As of `thermal_growth.oil_temperatures` [K].
    """

    opening: float
    growth: np.ndarray
    work: float
    oil: np.ndarray


@compilable
def heat_effect(
    model: BodyModel, before: PistonState, inputs: StepInputs, guide_height: float
) -> HeatEffect:
    """Return the effect of the temperatures; A is at `guide_height` above the crank axis [m]."""
    surfaces, p = model.parts.surfaces, model.settings
    skirt = level_of(inputs.fields.skirt, inputs.piston_temperature)
    bore = level_of(inputs.fields.bore, inputs.bore_temperature)
    opening = thermal_opening(model.radii, skirt, bore, p)
    growth = np.zeros(0)
    if len(inputs.fields.skirt) or len(inputs.fields.bore):
        growth = field_growth(surfaces, model.radii, p, inputs.fields)
    force = inputs.skirt.pressure
    work = growth_work(force, opening - before.thermal_opening)
    if len(growth) > 0 and len(before.field_growth) > 0:
        warmed = before.field_growth, growth
        work += field_work(surfaces, model.cold, force, guide_height, *warmed)
    return HeatEffect(opening, growth, work, oil_temperatures(surfaces, guide_height, skirt, bore))


@compilable
def result_of(
    model: BodyModel,
    before: PistonState,
    step: StepProblem,
    time: float,
    now: Instant,
    inputs: StepInputs,
) -> StepResult:
    """Return state and outputs at the end of a step.

    The films of the skirt open by thermal growth.

    Parameters
    ----------
    model : BodyModel
    before : PistonState
        At the beginning of the step, for a start `at_rest`.
    step : StepProblem
    time : float
        At the end of the step [s].
    now : Instant
    inputs : StepInputs
    """
    system = model.parts
    settings = model.settings
    crank = step.crank
    last = StepEnd(step.coefficients, now.guide_height, now.end, crank, now.linear)
    _add_slopes_of_bore(model, last, inputs.skirt.pressure)
    torque = now.torque + settings.crank_inertia * crank.acceleration
    jerk = 0.0
    if settings.crank_free != 0.0:
        freed = free_acceleration(model, last, crank, torque + inputs.load_torque)
        if step.coefficients.step > 0.0:
            jerk = (freed - before.crank_acceleration) / step.coefficients.step
        crank = CrankMotion(crank.angle, crank.speed, freed)
        torque = -inputs.load_torque
    steps = before.steps if step.coefficients.step == 0.0 else before.steps + 1
    heat = heat_effect(model, before, inputs, now.guide_height)
    opening = heat.opening
    for k in range(len(now.films.film_thickness)):
        now.films.film_thickness[k] += opening
    grown = opening, heat.growth
    state = state_at(before, step.coefficients.step, now, crank, jerk, time, steps, grown)
    energy = EnergyAccount(now.ledger.axial_work, now.ledger.accounted, 0.0)
    warm_work = 0.0
    if steps > 0:
        warm_work = heat.work
        energy = account(
            (before.kinetic, state.kinetic),
            state.position - before.position,
            (before.other_forces, now.other_forces),
            now.ledger.axial_work,
        )
    mass = rigid_piston(system).mass
    inertia = settings.crank_inertia + moved_inertia(system.mechanism, mass, step.crank.angle)
    return StepResult(
        instant=now,
        scalars=scalars_of(now, step, (torque, inertia), energy, system, (opening, warm_work)),
        state=state,
        last=last,
        oil_temperature=heat.oil,
    )


@compilable
def _lever(model, crank):
    """Return dY_0/dphi of Eq. (D70) [m], 0 if the block does not move."""
    return height(model.parts.mechanism, 0.0, crank.angle).lever if model.mounted else 0.0


@compilable
def _add_slopes_of_bore(model, last, pressure):
    """Add the slopes by modes of the bore to the derivative of the moment on the block."""
    lever = _lever(model, last.crank)
    if lever == 0.0:
        return
    modal = skirt_slopes(model.parts, last.guide_height, pressure).modal
    by = reach_of(last.coefficients, model.parts.kinds)
    first = modes_of(model)[1] - len(modal)
    for k in range(len(modal)):
        turned = lever * modal[k] * by.position[first + k]
        last.linear.on_block[TURN, first + k] -= turned  # Eq. (D70)


@compilable
def free_acceleration(model: BodyModel, last: StepEnd, crank: CrankMotion, torque: float) -> float:
    """Return the acceleration at which the torques on a free crank balance [rad/s2].

    Eq. (K9):  torque(w') + load_torque = 0,   torque linear in w'

    `torque` is the left side at the acceleration of `crank` [N m].
    """
    moved = drive_inertia(model.parts.chain, last.linear.forces, last.now, crank)
    return crank.acceleration - torque / (moved + model.settings.crank_inertia)  # Eq. (K9)


# ---- derivatives at its end


@compilable
def response_to(
    model: BodyModel, last: StepEnd, seeds: StepInputs, carried: np.ndarray
) -> Response:
    """Return the change at the end of a step with forces and the block's motion (4,)."""
    lever = _lever(model, last.crank)
    return response(model.parts, last, seeds, block_motion_from(carried), lever)


@compilable
def coordinate_change(
    model: BodyModel, last: StepEnd, seeds: StepInputs, is_exact: bool
) -> np.ndarray:
    """Return the change of all coordinates at the end of a step with forces there."""
    pushed = pushed_motion(model.parts, last, seeds, FIXED, is_exact)
    return reach_of(last.coefficients, model.parts.kinds).position * pushed.acceleration


@compilable
def moved_by(
    model: BodyModel, last: StepEnd, coordinates: np.ndarray, is_exact: bool
) -> MovedFilms:
    """Return the change of films and motion at the end of a step with all coordinates."""
    by = reach_of(last.coefficients, model.parts.kinds)
    return moved_films(model.parts, last, coordinates / by.position, is_exact)


@compilable
def film_measures(model: BodyModel, last: StepEnd) -> np.ndarray:
    """Return how much each coordinate changes the films, by the bore read along the stroke.

    Per unit of the coordinate, it is the root of the sum of squares over cells: of the change of
    film thickness, and of the change of velocity times the step. This is the root mean square over
    `ANGLES_OF_MEASURES` crank angles.
    """
    by = reach_of(last.coefficients, model.parts.kinds)
    out = np.zeros(len(by.position))
    for k in range(len(out)):
        unit = np.zeros(len(out))
        unit[k] = 1.0 / by.position[k]
        for i in range(ANGLES_OF_MEASURES):
            at = height(model.parts.mechanism, 0.0, np.pi * (i + 0.5) / ANGLES_OF_MEASURES).height
            there = StepEnd(last.coefficients, at, last.now, last.crank, last.linear)
            films = moved_films(model.parts, there, unit, False)
            for film in (films.skirt, films.pins):
                opened, slid = film.film_thickness, last.coefficients.step * film.sliding_velocity
                out[k] += (opened @ opened + slid @ slid) / ANGLES_OF_MEASURES
    return np.sqrt(out)


class PlacedFilms(NamedTuple):
    """Thickness [m] and velocity [m/s] of all films of the skirt, and of pin and crank."""

    skirt: FilmChange
    pins: FilmChange


@compilable
def films_at(
    model: BodyModel,
    before: PistonState,
    c: Coefficients,
    crank: CrankMotion,
    inputs: StepInputs,
    position: np.ndarray,
) -> PlacedFilms:
    """Return all films at coordinates at the end of a step.

    Parameters
    ----------
    model : BodyModel
    before : PistonState
        At the beginning of the step.
    c : Coefficients
        Coefficients of the step.
    crank : CrankMotion
        At its end.
    inputs : StepInputs
        Their temperatures open the films. Their forces have no effect.
    position : ndarray, shape (n,)
        Coordinates.
    """
    of = model.parts
    start = Motion(before.position, before.velocity, before.acceleration)
    predicted = predicted_of(c, start, before.auxiliary, before.mean_velocity, of.kinds)
    by = reach_of(c, of.kinds)
    unknown = (position - predicted.position) / by.position
    velocity = predicted.velocity + by.velocity * unknown
    end = Motion(position, velocity, by.acceleration * unknown)
    at = chain_motion(of.chain.joints, end, crank)
    upright = height(of.mechanism, 0.0, crank.angle)
    guide = AxialMotion(upright.height, upright.lever * crank.speed)
    parts = forces_by_film(of, guide.height, inputs.skirt)
    rising = at.velocity[piston_of(of.chain), Y]
    place, speed = of_skirt(of, end.position), of_skirt(of, end.velocity)
    skirt = skirt_films(of, guide, inputs.skirt, parts, rising, place, speed)
    pushes = film_pushes(of, inputs.pins)
    load = load_of(of, total_forces(parts), others_at(model, inputs, crank))
    loads = loads_at(of.chain, applied_forces(of, load, inputs.pins, pushes), at, end)
    pins = pin_films(of, inputs.pins, pushes, loads, at, end)
    opening = heat_effect(model, before, inputs, guide.height).opening
    return PlacedFilms(
        FilmChange(skirt.film_thickness + opening, skirt.sliding_velocity),
        FilmChange(pins.film_thickness, pins.circumferential_velocity),
    )
