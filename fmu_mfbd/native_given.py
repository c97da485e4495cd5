"""First part of the memory of native bodies: what depends on no parameter."""

from typing import Any

import numpy as np

from ..master.fmi.block import memory_of, room, row_of
from ..master.fmi.errors import BadInput
from ..master.fmi.noted import ROOM
from ..master.fmi.slave import PRODUCT, SEED, reserved
from .dynamics.assembly import (
    ReducedBodies,
    assemble_system,
    body_faults,
    fit_of,
    load_bodies,
    pin_surfaces,
)
from .dynamics.block_force import BlockForce
from .dynamics.build_options import BuildOptions
from .dynamics.carrier import FIXED
from .dynamics.clearance import measured, surfaces
from .dynamics.drive import Scalars
from .dynamics.model import MOTION
from .dynamics.parameters import CRANK_PARAMETERS, Parameters, PinParameters
from .dynamics.pin_coordinates import COORDINATES
from .dynamics.pin_instant import PinScalars
from .dynamics.piston_motion import RIGID
from .dynamics.response import StepEnd
from .dynamics.state import PistonState
from .geometry.film import knot_rule
from .geometry.grid import cell_centres
from .geometry.profile import fourier_bore
from .geometry.surfaces import pins_in_block, with_room
from .native_block import (
    NOWHERE,
    SETTING,
    BodySetup,
    Constants,
    Direction,
    FieldPlaces,
    GasCurve,
    OutputPlaces,
    VariablePlaces,
)
from .variables import BLOCK, FILM, FORCES, PIN_FILM, PIN_FORCES, RINGS


def given(slave: Any) -> np.ndarray:
    """Return the constant part of the memory of an FMU: head and parts without parameters.

    Parameters
    ----------
    slave : slave.Mfbd
        Its resources hold the reduced bodies.
    """
    options: BuildOptions = slave.built
    bodies = load_bodies(slave.resources, options)
    if wrong := body_faults(bodies.piston, bodies.block, options, bodies.bosses):
        raise BadInput(wrong)
    begun = _begun(slave, options, bodies)
    n = max(len(begun.start_position), len(FIXED))
    lengths = {
        "state": room(PistonState, n=len(begun.start_position), w=0, s=0),
        "last": room(StepEnd, n=n, m=n),
        "direction": room(Direction, n=n, m=n),
        "faults": ROOM,
    }
    return memory_of({"given": row_of(begun)}, lengths)


def _begun(slave: Any, options: BuildOptions, bodies: ReducedBodies) -> BodySetup:
    """Return `BodySetup` before a start."""
    piston, block, bosses, eye = bodies
    angle, height = cell_centres(*options.grid, piston.skirt_lower, piston.skirt_upper)
    k, m = len(piston.omega), len(block.omega)
    rings = Parameters(top_ring_height=1.0, second_ring_height=1.0)  # of any, for the wall
    films = with_room(surfaces(piston, block, options, rings), len(block.heights))
    orders = fourier_bore(options.block.orders, angle)[:, None]
    widening = orders + measured(options.block.profiles, angle, block.heights)
    profile = np.broadcast_to(measured(options.piston.profiles, angle, height), options.grid)
    of_films = [profile[:, one.first : one.last].ravel() for one in options.film_surfaces()]
    gas, begin, pin = options.gas, options.start, options.floating_pin
    crank = {name: CRANK_PARAMETERS[name]() for name in options.crank_surfaces()}
    pins = pin_surfaces(options, 1.0, PinParameters(), crank, bosses, eye) if pin else ()
    n = coordinates(options, k, m)
    none = np.zeros(0)
    of_inertia = np.zeros((n, n) if pin else (0, 0))
    return BodySetup(
        places=_places(slave),
        constants=Constants(
            bore_radius=block.radius,
            start_given=begin is not None,
            start_angle=begin.crank_angle if begin else 0.0,
        ),
        fit=fit_of(piston, block, options, bosses, eye.eye_radius if eye else 0.0),
        system=assemble_system(piston, block, options, rings, films),
        measured=np.concatenate(of_films),
        heights=block.heights,
        widening=np.broadcast_to(widening, (len(angle), len(block.heights))),
        inverse=knot_rule(len(block.heights)),
        gas=GasCurve(gas.angle, gas.pressure, gas.cycle) if gas else GasCurve(none, none, 0.0),
        start_position=begin.position() if begin else np.zeros(n),
        start_velocity=begin.velocity() if begin else np.zeros(n),
        piston_omega=piston.omega,
        block_omega=block.omega,
        pin_surfaces=pins_in_block(pins),
        eye_omega=eye.eye_omega if eye else none,
        settings=np.zeros(len(SETTING)),
        inertia=of_inertia,
        with_rod=of_inertia,
        has_linear=np.zeros(1),
        evaluations=np.zeros(1),
        tangents=np.zeros(1),
    )


def coordinates(options: BuildOptions, piston_modes: int, block_modes: int) -> int:
    """Return how many the bodies have."""
    pin = options.floating_pin
    if pin is None:
        return RIGID + piston_modes + block_modes
    return COORDINATES + piston_modes + pin.small_end_modes + 2 * len(options.crank_bearings)


def _places(slave) -> VariablePlaces:
    """Return where everything lies among a slave's variables."""

    def place(name, kind=""):
        return slave.references.get(reserved(kind, name) if kind else name, NOWHERE)

    def each(names, kind=""):
        return np.array([place(name, kind) for name in names], dtype=float)

    def fields(films, names, kinds=("",) * 4):
        names, kinds = (*names, "interface_work_error"), (*kinds, "")
        columns = [
            [place(f"{film.prefix}{name}", kind) for film in films]
            for name, kind in zip(names, kinds)
        ]
        columns.append([np.prod(film.shape) for film in films])
        return FieldPlaces(*(np.array(column, dtype=float) for column in columns))

    no_numbers = ("gas_source", "crank_free")  # a choice, and a flag of which only 0 is covered
    skirt, pins = slave.built.film_grids(), slave.built.pin_grids()
    of_tangent = SEED, SEED, PRODUCT, PRODUCT
    return VariablePlaces(
        settings=each("" if name in no_numbers else name for name in SETTING),
        scalars=each(Scalars._fields),
        pin_scalars=each(PinScalars._fields),
        gas_source=place("gas_source"),
        gas_pressure=place("gas_pressure"),
        land_pressure=place("land_pressure"),
        crank_speed=place("crank_speed"),
        rings=each(RINGS),
        rings_seed=each(RINGS, SEED),
        carrier=each(BLOCK),
        carrier_seed=each(BLOCK, SEED),
        on_block=each(BlockForce._fields),
        on_block_product=each(BlockForce._fields, PRODUCT),
        motion_product=each(MOTION, PRODUCT),
        outputs=OutputPlaces(*map(place, OutputPlaces._fields)),
        skirt=fields(skirt, (*FORCES, *FILM)),
        skirt_tangent=fields(skirt, (*FORCES, *FILM), of_tangent),
        pins=fields(pins, (*PIN_FORCES, *PIN_FILM)),
        pins_tangent=fields(pins, (*PIN_FORCES, *PIN_FILM), of_tangent),
    )
