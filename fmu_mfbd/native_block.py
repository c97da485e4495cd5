"""The memory of bodies that need no Python: one flat block of float64 numbers, whose head says
where each part begins. What parts there are is said here, their lengths in `native.given`. One of
them is a block of film surfaces by itself, as many as there are (`geometry.surfaces`).
"""

from collections import namedtuple
from dataclasses import fields

import numpy as np

from ..master.fmi.compiled import compiled, packed
from .dynamics.assembly import mechanism, pin_radius, pin_spin_inertia
from .dynamics.carrier import Carrier
from .dynamics.drive import Scalars
from .dynamics.floating_frame import FlexibleBody
from .dynamics.floating_pin import Bodies, Crankshaft, EyeModes
from .dynamics.gas_on_bore import BoreWall
from .dynamics.generalised_alpha import Coefficients
from .dynamics.instant import Block, Linear, System
from .dynamics.parameters import CRANK_PARAMETERS, Parameters, PinParameters
from .dynamics.pin_instant import PinScalars, PinSystem
from .dynamics.piston_motion import Load
from .dynamics.quasi_static import StaticModes
from .dynamics.slider_crank import CrankMotion
from .geometry.pin_shapes import AxisShapes
from .geometry.pin_surfaces import pins_of
from .geometry.surfaces import count_of

WHOLE, FIRST_STATE, STATES, FIRST_FAULT, PARTS_FROM = range(5)
"""The head: lengths that `native_size` tells, then where parts begin."""

GIVEN = (
    "counts",
    "constants",
    "places",
    "film_places",
    "surfaces",
    "measured",
    "heights",
    "widening",
    "inverse",
    "band_above",
    "band_ratio",
    "gas_angle",
    "gas_pressure",
    "start_position",
    "start_velocity",
    "first_moment",
    "T",
    "b",
    "B",
    "g",
    "G",
    "piston_omega",
    "gas_force",
    "block_omega",
    "wall_above",
    "wall_at",
    "pin_surfaces",
    "eye_omega",
)
MADE = (
    "settings",
    "wall_above_now",
    "wall_at_now",
    "piston_stiffness",
    "piston_damping",
    "block_stiffness",
    "block_damping",
    "eye_stiffness",
    "eye_damping",
    "inertia",
    "with_rod",
    "none",
)
"""At the start, from the parameters; gaps and the bore's shape besides, in the surfaces."""
STATE = ("numbers", "position", "velocity", "acceleration", "auxiliary", "other_forces")
"""In one piece."""
LAST = (
    "last_numbers",
    "last_coefficients",
    "last_load",
    "last_carrier",
    "last_crank",
    "last_position",
    "last_velocity",
    "last_acceleration",
    "modal_load",
    "linear_numbers",
    "top",
    "left",
    "diagonal",
    "coupling",
    "columns",
    "factors",
    "order",
)
"""What a derivative at the end of the last step asks for; the last two of a floating pin: its
tangent, factorised.
"""
PARTS = (*GIVEN, *MADE, *STATE, *LAST, "faults")
(
    COUNTS,
    CONSTANTS,
    PLACES,
    FILM_PLACES,
    SURFACES,
    MEASURED,
    HEIGHTS,
    WIDENING,
    INVERSE,
    BAND_ABOVE,
    BAND_RATIO,
    GAS_ANGLE,
    GAS_PRESSURE,
    START_POSITION,
    START_VELOCITY,
    FIRST_MOMENT,
    T,
    SMALL_B,
    B,
    SMALL_G,
    G,
    PISTON_OMEGA,
    GAS_FORCE,
    BLOCK_OMEGA,
    WALL_ABOVE,
    WALL_AT,
    PIN_SURFACES_AT,
    EYE_OMEGA,
) = range(len(GIVEN))
(
    SETTINGS,
    WALL_ABOVE_NOW,
    WALL_AT_NOW,
    PISTON_STIFFNESS,
    PISTON_DAMPING,
    BLOCK_STIFFNESS,
    BLOCK_DAMPING,
    EYE_STIFFNESS,
    EYE_DAMPING,
    INERTIA_MATRIX,
    WITH_ROD,
    NONE,
) = (len(GIVEN) + k for k in range(len(MADE)))
NUMBERS, POSITION, VELOCITY, ACCELERATION, AUXILIARY, OTHER_FORCES = (
    NONE + 1 + k for k in range(len(STATE))
)
(
    LAST_NUMBERS,
    LAST_COEFFICIENTS,
    LAST_LOAD,
    LAST_CARRIER,
    LAST_CRANK,
    LAST_POSITION,
    LAST_VELOCITY,
    LAST_ACCELERATION,
    MODAL_LOAD,
    LINEAR_NUMBERS,
    TOP,
    LEFT,
    DIAGONAL,
    COUPLING,
    COLUMNS,
    FACTORS,
    ORDER,
) = (OTHER_FORCES + 1 + k for k in range(len(LAST)))
FAULTS_AT = len(PARTS) - 1

COUNTED = ("cells", "piston_modes", "block_modes", "stations", "pin_cells")
CELLS, PISTON_MODES, BLOCK_MODES, STATIONS, PIN_CELLS = range(len(COUNTED))
"""Cells of all surfaces of the skirt together, of pin and crank."""

CONSTANT = (
    "mass",
    "inertia",
    "piston_radius",
    "skirt_lower",
    "skirt_upper",
    "pin_offset",
    "bore_radius",
    "spacing",
    "gas_cycle",
    "bands_given",
    "start_given",
    "start_angle",
    "has_big_end",
    "has_main_bearing",
    "boss_radius",
    "eye_radius",
)
(
    MASS,
    INERTIA,
    PISTON_RADIUS,
    SKIRT_LOWER,
    SKIRT_UPPER,
    PIN_OFFSET,
    BORE_RADIUS,
    SPACING,
    GAS_CYCLE,
    BANDS_GIVEN,
    START_GIVEN,
    START_ANGLE,
    HAS_BIG_END,
    HAS_MAIN_BEARING,
    BOSS_RADIUS,
    EYE_RADIUS,
) = range(len(CONSTANT))
"""The last two in the meshes of what yields; 0 of rigid ones."""

# ---- numbers of the state, and of the last step

OF_STATE = ("time", "crank_angle", "crank_speed", "crank_acceleration", "kinetic", "steps")
TIME, CRANK_ANGLE, CRANK_SPEED, CRANK_ACCELERATION, KINETIC, STEPS = range(len(OF_STATE))
OF_LAST = ("guided", "is_linear", "evaluations", "tangents")
GUIDED, IS_LINEAR, EVALUATIONS, TANGENTS = range(len(OF_LAST))

# ---- where numbers lie among the variables

DECLARED = (Parameters, PinParameters, *CRANK_PARAMETERS.values())
SETTING = tuple(one.name for kind in DECLARED for one in fields(kind))
SETTING_COUNT = len(SETTING)
Settings = namedtuple("Settings", SETTING)
"""`Parameters` and those of pin and crank, as kernels know them: floats, 0 of what is not there."""
INPUTS = (
    "gas_pressure",
    "land_pressure",
    "ring_side_force",
    "ring_axial_force",
    "ring_moment",
    "crank_speed",
    "block_acceleration_x",
    "block_acceleration_y",
    "block_angular_acceleration",
    "block_angular_velocity",
)
"""The last four of a mounted block alone; of another they lie nowhere, as its outputs."""
OUTPUTS = (
    *Scalars._fields,
    "cylinder_pressure",
    "side_force_demand",
    "modal_coordinate",
    "modal_velocity",
    "residual_evaluations",
    "jacobian_evaluations",
    "force_on_block_x",
    "force_on_block_y",
    "moment_on_block",
    "main_bearing_force_x",
    "main_bearing_force_y",
)
(
    CYLINDER_PRESSURE,
    SIDE_FORCE_DEMAND,
    MODAL_COORDINATE,
    MODAL_VELOCITY,
    RESIDUAL_EVALUATIONS,
    JACOBIAN_EVALUATIONS,
    ON_BLOCK,
) = range(len(Scalars._fields), len(OUTPUTS) - 4)
ENERGY_GAIN = OUTPUTS.index("energy_gain")
ENERGY_SIZE = OUTPUTS.index("energy_size")
GAS, LAND, RINGS = range(3)
CRANK_SPEED_GIVEN = INPUTS.index("crank_speed")
CARRIED = INPUTS.index("block_acceleration_x")
"""Places among INPUTS; three numbers of the rings, four of the block's motion."""
SEEDED = (*INPUTS[RINGS:CRANK_SPEED_GIVEN], *INPUTS[CARRIED:])
CARRIED_SEEDS = CRANK_SPEED_GIVEN - RINGS
PRODUCED = (
    "lateral_velocity",
    "rocking_velocity",
    "piston_velocity",
    *OUTPUTS[ON_BLOCK : ON_BLOCK + 3],
)
BLOCK_PRODUCTS = PRODUCED.index("force_on_block_x")
OF_INPUTS = len(SETTING)
OF_OUTPUTS = OF_INPUTS + len(INPUTS)
OF_SEEDS = OF_OUTPUTS + len(OUTPUTS)
OF_PRODUCTS = OF_SEEDS + len(SEEDED)
PIN_OUTPUTS = (
    *PinScalars._fields,
    "small_end_modal_coordinate",
    "small_end_modal_velocity",
)
"""Further outputs of a floating pin."""
OF_PIN_OUTPUTS = OF_PRODUCTS + len(PRODUCED)
EYE_COORDINATE = len(PinScalars._fields)
EYE_VELOCITY = EYE_COORDINATE + 1
NOWHERE = -1.0

# ---- where fields begin among the variables, a row of `film_places` for each surface of the skirt,
# ---- then for each film of pin and crank

OF_FILM = (
    "nodal_pressure_force",
    "nodal_friction_force",
    "film_thickness",
    "sliding_velocity",
    "interface_work_error",
)
FORCE, DRAG, FILM_THICKNESS, SLIDING_VELOCITY, WORK_ERROR = range(len(OF_FILM))
ON_PIN = {
    "nodal_friction_force": "nodal_circumferential_force",
    "sliding_velocity": "circumferential_velocity",
}
"""What stands in their place for films of pin and crank."""
FILM_SEEDS = OF_FILM[FORCE : DRAG + 1]
FILM_PRODUCTS = OF_FILM[FILM_THICKNESS : SLIDING_VELOCITY + 1]
FORCE_SEED, DRAG_SEED, THICKNESS_PRODUCT, SLIDING_PRODUCT, FILM_CELLS = range(
    len(OF_FILM), len(OF_FILM) + 5
)
FILM_ROW = FILM_CELLS + 1
"""The last number of a row is not a place, but how many cells the surface has."""

OF_A_FAULT = 6
FAULT, FAULT_I, _, FAULT_A, FAULT_B, FAULT_C = range(OF_A_FAULT)
MOST_FAULTS = 8


@compiled
def part(memory: np.ndarray, k: int) -> np.ndarray:
    """The k-th of `PARTS`."""
    return memory[int(memory[PARTS_FROM + k]) : int(memory[PARTS_FROM + k + 1])]


@compiled
def place(memory, k):
    """Where among the variables the k-th number lies; -1 for nowhere."""
    return int(part(memory, PLACES)[k])


@compiled
def film_place(memory, surface, k):
    """Where a field of a surface begins among the variables, `OF_FILM` and what follows."""
    return int(part(memory, FILM_PLACES)[FILM_ROW * surface + k])


@compiled
def films(memory):
    """Number of film surfaces of the skirt."""
    return count_of(part(memory, SURFACES))


@compiled
def pin_films(memory):
    """Number of films of pin and crank, 0 of a tied pin."""
    return pins_of(part(memory, PIN_SURFACES_AT))


@compiled
def count(memory, k):
    """One of `COUNTED`."""
    return int(part(memory, COUNTS)[k])


_, settings_from = packed(Settings)
put_coefficients, coefficients_from = packed(Coefficients)
put_load, load_from = packed(Load, "modal", "carrier")
put_crank, crank_from = packed(CrankMotion)
put_carrier, carrier_from = packed(Carrier)
put_linear, linear_from = packed(Linear, "arrow", "coupling")


@compiled
def settings_of(memory):
    """Parameters of the last start."""
    return settings_from(part(memory, SETTINGS))


@compiled
def system_of(memory: np.ndarray) -> System:
    """Both bodies, the mechanism and the film, as `assembly.assemble` makes them."""
    x = part(memory, CONSTANTS)
    k = count(memory, PISTON_MODES)
    m = count(memory, BLOCK_MODES)
    s = count(memory, STATIONS)
    settings = settings_of(memory)
    lowest = part(memory, HEIGHTS)[0]
    none = part(memory, NONE)
    static = StaticModes(none, none.reshape((2, 0)), none, none)
    return System(
        FlexibleBody(
            x[MASS],
            part(memory, FIRST_MOMENT),
            x[INERTIA],
            part(memory, T).reshape((2, k)),
            part(memory, SMALL_B),
            part(memory, B).reshape((k, k)),
            part(memory, SMALL_G),
            part(memory, G).reshape((k, k)),
            part(memory, PISTON_STIFFNESS),
            part(memory, PISTON_DAMPING),
        ),
        static,
        Block(part(memory, BLOCK_STIFFNESS), part(memory, BLOCK_DAMPING)),
        static,
        mechanism(x[PISTON_RADIUS], x[PIN_OFFSET], settings),
        part(memory, SURFACES),
        x[PIN_OFFSET],
        part(memory, GAS_FORCE),
        BoreWall(
            lowest,
            x[SPACING],
            part(memory, WALL_ABOVE_NOW).reshape((s, m)),
            part(memory, WALL_AT_NOW).reshape((s, m)),
            settings.top_ring_height,
            settings.second_ring_height,
            settings.land_pressure_share,
        ),
    )


@compiled
def pin_system_of(memory: np.ndarray, system: System) -> PinSystem:
    """The same with a floating pin, as `assembly.assemble_floating` makes it."""
    x = part(memory, CONSTANTS)
    settings = settings_of(memory)
    none = part(memory, NONE)
    n = len(part(memory, ORDER))
    has_bearing = x[HAS_MAIN_BEARING] > 0.0
    radius = pin_radius(x[PISTON_RADIUS], settings)
    bodies = Bodies(
        system.piston,
        system.mechanism,
        pin_spin_inertia(settings.pin_mass, radius, settings.pin_inertia),
        AxisShapes(none, none, none, none, none),
        EyeModes(part(memory, EYE_STIFFNESS), part(memory, EYE_DAMPING)),
        Crankshaft(
            x[HAS_BIG_END] > 0.0,
            has_bearing,
            settings.crank_mass if has_bearing else 0.0,
            settings.crank_unbalance if has_bearing else 0.0,
        ),
    )
    return PinSystem(
        system,
        bodies,
        part(memory, PIN_SURFACES_AT),
        part(memory, INERTIA_MATRIX).reshape((n, n)),
        part(memory, WITH_ROD).reshape((n, n)),
    )
