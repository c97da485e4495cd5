"""First part of the memory of native bodies: what depends on no parameter."""

from typing import Any

import numpy as np

from ..master.fmi.block import memory_of, room, row_of
from ..master.fmi.errors import BadInput
from ..master.fmi.noted import ROOM
from ..master.fmi.slave import PRODUCT, SEED, reserved
from .dynamics.assembly import assembled, body_faults, load_bodies, setup_of
from .dynamics.block_force import BlockForce
from .dynamics.build_options import BuildOptions
from .dynamics.carrier import FIXED
from .dynamics.drive import Scalars
from .dynamics.model import MOTION
from .dynamics.parameters import Parameters, Settings, settings_of
from .dynamics.pin_coordinates import COORDINATES
from .dynamics.pin_instant import PinScalars
from .dynamics.piston_motion import RIGID
from .dynamics.response import StepEnd
from .dynamics.state import PistonState
from .dynamics.step import FIELDS, Linearisation, StepInputs
from .native_block import (
    NOWHERE,
    FieldPlaces,
    NativeSetup,
    OutputPlaces,
    VariablePlaces,
)
from .variables import BLOCK, FILM, FORCES, PIN_FILM, PIN_FORCES, RINGS

NEEDS = Parameters(top_ring_height=1.0, bore_growth_lower=1.0)
"""Parameters for which a memory has room: gas on the wall and a bore that grows."""


def given(slave: Any) -> np.ndarray:
    """Return the constant part of the memory of an FMU: head and parts without parameters.

    Parameters
    ----------
    slave : slave.Mfbd
        Its resources hold the reduced bodies.
    """
    options: BuildOptions = slave.built
    bodies = load_bodies(slave.resources, options)
    if wrong := body_faults(bodies, options):
        raise BadInput(wrong)
    setup = setup_of(bodies, options, NEEDS)
    n = coordinates(options, len(bodies.piston.omega), len(bodies.block.omega))
    begin = options.start
    given = NativeSetup(
        places=_places(slave),
        bodies=setup,
        start_given=begin is not None,
        start_angle=begin.crank_angle if begin else 0.0,
        start_speed=begin.rotation_speed if begin else 0.0,
        start_position=begin.position() if begin else np.zeros(n),
        start_velocity=begin.velocity() if begin else np.zeros(n),
        has_common=np.zeros(1),
        evaluations=np.zeros(1),
        tangents=np.zeros(1),
    )
    model = assembled(setup, settings_of(NEEDS))
    square = np.zeros((n, n) if options.floating_pin else (0, 0))
    parts = model.parts._replace(inertia=square, with_rod=square)
    m = max(n, len(FIXED))
    lengths = {
        "model": row_of(model._replace(parts=parts)).size,
        "state": room(PistonState, n=n, w=0, s=0),
        "begun": room(PistonState, n=n, w=0, s=0),
        "last": room(StepEnd, n=m, m=m),
        "common": room(Linearisation, n=m, m=m),
        "faults": ROOM,
    }
    return memory_of({"given": row_of(given)}, lengths)


def coordinates(options: BuildOptions, piston_modes: int, block_modes: int) -> int:
    """Return how many the bodies have."""
    pin = options.floating_pin
    if pin is None:
        return RIGID + piston_modes + block_modes
    crank = sum(2 + one.modes for one in options.crank_bearings)
    return COORDINATES + piston_modes + pin.small_end_modes + crank


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

    integers = "gas_source", "crank_free"
    skirt, pins = slave.built.film_grids(), slave.built.pin_grids()
    of_tangent = SEED, SEED, PRODUCT, PRODUCT
    return VariablePlaces(
        settings=each("" if name in integers else name for name in Settings._fields),
        scalars=each(Scalars._fields),
        pin_scalars=each(PinScalars._fields),
        gas_source=place("gas_source"),
        crank_free=place("crank_free"),
        crank_speed=place("crank_speed"),
        inputs=each(name for name in StepInputs._fields if name not in FIELDS),
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
