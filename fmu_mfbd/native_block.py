"""The memory of bodies that need no Python: what its rows hold (`master.fmi.block`)."""

from typing import Annotated, NamedTuple

import numpy as np

from ..master.fmi.block import alike, flatten, part
from ..master.fmi.compiled import compiled, numbered, packed
from .dynamics.assembly import BodySetup
from .dynamics.parameters import Settings
from .dynamics.response import StepEnd
from .dynamics.state import PistonState
from .dynamics.step import BodyModel, Linearisation
from .geometry.arrays import Vector

Number = Annotated[np.ndarray, "1"]
"""An array of one, for what changes."""

# ---- where variables lie

NOWHERE = -1

_, settings_from = packed(Settings)


class OutputPlaces(NamedTuple):
    """Positions of outputs that are not scalars of a step, and of two that are."""

    cylinder_pressure: int
    side_force_demand: int
    modal_coordinate: int
    modal_velocity: int
    residual_evaluations: int
    jacobian_evaluations: int
    small_end_modal_coordinate: int
    small_end_modal_velocity: int


class FieldPlaces(NamedTuple):
    """First positions of the fields of films, and their numbers of cells: arrays over surfaces.

    push, drag : nodal forces, normal and tangential; work_error : the output of this name. For a
    tangent the forces are seeds, thickness and sliding are products.
    """

    push: Vector
    drag: Vector
    thickness: Vector
    sliding: Vector
    work_error: Vector
    cells: Vector


class VariablePlaces(NamedTuple):
    """Positions among the variables, `NOWHERE` if there is none.

    settings, scalars, pin_scalars : of `Settings`, `Scalars` and `PinScalars`, in their order;
    inputs : of the numbers of `StepInputs`;
    rings, carrier : of `variables.RINGS` and `variables.BLOCK`; on_block : of the forces on a
    mounted block; motion : of the derivatives `model.MOTION`.
    """

    settings: Vector
    scalars: Vector
    pin_scalars: Vector
    gas_source: int
    crank_free: int
    crank_speed: int
    inputs: Vector
    rings: Vector
    rings_seed: Vector
    carrier: Vector
    carrier_seed: Vector
    on_block: Vector
    on_block_product: Vector
    motion_product: Vector
    outputs: OutputPlaces
    skirt: FieldPlaces
    skirt_tangent: FieldPlaces
    pins: FieldPlaces
    pins_tangent: FieldPlaces


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
    start_position: Vector
    start_velocity: Vector
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
