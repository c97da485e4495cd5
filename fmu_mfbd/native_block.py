"""The memory of bodies that need no Python: what its rows hold (`master.fmi.block`)."""

from typing import Annotated, NamedTuple

import numpy as np

from ..master.fmi.block import (
    FIRST_STATE,
    alike,
    checker,
    flatten,
    given_part,
    has_room,
    is_head,
    length_of,
    part,
    room_of,
)
from ..master.fmi.compiled import compilable, compiled, numbered, packed
from .dynamics.assembly import BodySetup
from .dynamics.block_force import BlockForce
from .dynamics.carrier import FIXED
from .dynamics.drive import Scalars
from .dynamics.parameters import Settings
from .dynamics.pin_coordinates import COORDINATES
from .dynamics.pin_instant import PinScalars
from .dynamics.pin_shells import EYE
from .dynamics.piston_motion import RIGID
from .dynamics.response import StepEnd
from .dynamics.state import PistonState
from .dynamics.step import FIELDS, BodyModel, Linearisation, StepInputs
from .dynamics.system import RingForce
from .geometry.film import Limits
from .geometry.surfaces import are_films, are_pins

Number = Annotated[np.ndarray, "1"]
"""An array of one, for what changes."""

# ---- where variables lie

NOWHERE = -1

_, settings_from = packed(Settings)


EACH = "within(x, -1.0, reals)"
Place = Annotated[int, "-1 <= x < reals"]
Count = Annotated[int, "0 <= x < integers"]
OfModes = Annotated[int, "has_room(x, bodies.piston_modes + bodies.block_modes, reals)"]
OfEye = Annotated[
    int,
    "has_room(x, bodies.shell_modes - bodies.big_end_modes - bodies.main_bearing_modes, reals)",
]
OfFields = Annotated[np.ndarray, "films", "are_fields(x, cells, reals)"]
"""Positions of variables, by their conditions in a file."""


class OutputPlaces(NamedTuple):
    """Positions of outputs that are not scalars of a step, and of two that are."""

    cylinder_pressure: Place
    side_force_demand: Place
    modal_coordinate: OfModes
    modal_velocity: OfModes
    residual_evaluations: Count
    jacobian_evaluations: Count
    small_end_modal_coordinate: OfEye
    small_end_modal_velocity: OfEye


class FieldPlaces(NamedTuple):
    """First positions of the fields of films, and their numbers of cells: arrays over surfaces.

    push, drag : nodal forces, normal and tangential; work_error : the output of this name. For a
    tangent the forces are seeds, thickness and sliding are products.
    """

    push: OfFields
    drag: OfFields
    thickness: OfFields
    sliding: OfFields
    work_error: Annotated[np.ndarray, "films", EACH]
    cells: Annotated[np.ndarray, "films", "within(x, 1.0, reals)"]


OfRings = Annotated[np.ndarray, f"{len(RingForce._fields)}", EACH]
OfCarrier = Annotated[np.ndarray, f"{len(FIXED)}", EACH]
OfBlock = Annotated[np.ndarray, f"{len(BlockForce._fields)}", EACH]


class VariablePlaces(NamedTuple):
    """Positions among the variables, `NOWHERE` if there is none.

    settings, scalars, pin_scalars : of `Settings`, `Scalars` and `PinScalars`, in their order;
    inputs : of the numbers of `StepInputs`;
    rings, carrier : of `variables.RINGS` and `variables.BLOCK`; on_block : of the forces on a
    mounted block; motion : of the derivatives `model.MOTION`.
    """

    settings: Annotated[np.ndarray, f"{len(Settings._fields)}", EACH]
    scalars: Annotated[np.ndarray, f"{len(Scalars._fields)}", EACH]
    pin_scalars: Annotated[np.ndarray, f"{len(PinScalars._fields)}", EACH]
    gas_source: Count
    crank_free: Count
    crank_speed: Place
    inputs: Annotated[np.ndarray, f"{len(StepInputs._fields) - len(FIELDS)}", EACH]
    rings: OfRings
    rings_seed: OfRings
    carrier: OfCarrier
    carrier_seed: OfCarrier
    on_block: OfBlock
    on_block_product: OfBlock
    motion_product: Annotated[np.ndarray, "3", EACH]
    outputs: OutputPlaces
    skirt: FieldPlaces
    skirt_tangent: Annotated[FieldPlaces, "are_same(x.cells, skirt.cells)"]
    pins: FieldPlaces
    pins_tangent: Annotated[FieldPlaces, "are_same(x.cells, pins.cells)"]


# ---- what the rows hold


class NativeSetup(NamedTuple):
    """Constant part of a memory.

    start_given, start_angle, start_speed, start_position, start_velocity : start of the build
    options, if there is one; has_common : whether derivatives have a common part; evaluations,
    tangents : work so far.
    """

    places: VariablePlaces
    bodies: BodySetup
    start_given: bool
    start_angle: float
    start_speed: float
    start_position: Annotated[np.ndarray, "coordinates"]
    start_velocity: Annotated[np.ndarray, "coordinates"]
    has_common: Number
    evaluations: Number
    tangents: Number


PART_OF = numbered("given", "model", "state", "begun", "last", "common", "faults")
"""Numbers of the parts of a memory."""
_, _given = flatten(NativeSetup)
put_model, _model = flatten(BodyModel)
put_state, _state = flatten(PistonState)
is_state = alike(PistonState)
put_last, _last = flatten(StepEnd)
put_common, _common = flatten(Linearisation)
length_of_model = length_of(BodyModel)


# ---- what a file may hold


@compilable
def are_fields(places: np.ndarray, cells: np.ndarray, reals: int):
    """Return whether there are fields of so many cells at these positions."""
    for k in range(len(places)):
        if not has_room(places[k], int(cells[k]), reals):
            return False
    return True


@compilable
def are_same(one: np.ndarray, other: np.ndarray):
    """Return whether two vectors are equal."""
    same = len(one) == len(other)
    for k in range(len(one) if same else 0):
        same = same and one[k] == other[k]
    return same


_check = checker(NativeSetup, "reals, integers", are_fields=are_fields, are_same=are_same)
PARTS = float(len(PART_OF))
_room_of_state = room_of(PistonState, "n, w, s")
_room_of_last = room_of(StepEnd, "n, m")
_room_of_common = room_of(Linearisation, "n, m")


@compilable
def are_bodies(bodies: BodySetup, places: VariablePlaces, coordinates: int):
    """Return whether all films and coordinates of bodies from a file fit each other."""
    fit = bodies.fit
    films = 1.0 * fit.has_big_end + fit.has_main_bearing
    piston, block = len(bodies.piston_omega), len(bodies.block_omega)
    shells = len(bodies.shell_omega)
    most = np.full(EYE + 1 + int(films), piston)
    most[EYE] = shells - bodies.big_end_modes - bodies.main_bearing_modes
    if fit.has_main_bearing:
        most[-1] = bodies.main_bearing_modes
    if fit.has_big_end:
        most[EYE + 1] = bodies.big_end_modes
    floats = len(places.pins.cells) > 0
    modes = shells + 2 * int(films) if floats else block
    limits = Limits(fit.skirt_lower, fit.skirt_upper, fit.bore_lower, fit.bore_upper)
    return (
        coordinates == (COORDINATES if floats else RIGID) + piston + modes
        and floats == fit.floats
        and are_films(bodies.surfaces, places.skirt.cells, piston, block, limits)
        and are_pins(bodies.pin_surfaces, places.pins.cells, most)
    )


@compilable
def is_sound(real: np.ndarray, integer: np.ndarray, memory: np.ndarray):
    """Return whether a memory from a file has no position or length out of range.

    Whether the model has room is known at the start only.
    """
    row = given_part(memory, PARTS)
    if len(row) == 0 or _check(row, len(real), len(integer)) != len(row):
        return False
    given = _given(row)
    n = len(given.start_position)
    m = max(n, len(FIXED))
    model = int(memory[FIRST_STATE]) - len(memory)
    state = _room_of_state(n, 0, 0)
    lengths = (model, state, state, _room_of_last(m, m), _room_of_common(m, m))
    return (
        model >= 0
        and are_bodies(given.bodies, given.places, n)
        and is_head(memory, lengths, 1.0, 0)
    )


@compiled
def given_of(memory: np.ndarray):
    """Return `NativeSetup`; writing into its arrays changes the memory."""
    return _given(part(memory, PART_OF.given))


@compiled
def state_of(memory: np.ndarray):
    """Return a copy of the state."""
    return _state(part(memory, PART_OF.state).copy())


@compiled
def last_of(memory: np.ndarray):
    """Return the end of the last step."""
    return _last(part(memory, PART_OF.last))


@compiled
def common_of(memory: np.ndarray):
    """Return the common part of all derivatives at the end of the last step."""
    return _common(part(memory, PART_OF.common))


@compiled
def model_of(memory: np.ndarray):
    """Return the model for the parameters of the last start."""
    return _model(part(memory, PART_OF.model))
