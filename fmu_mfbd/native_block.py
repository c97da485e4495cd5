"""The memory of bodies that need no Python: one flat block of float64 numbers, whose head says
where each part begins. What stands in a part is told here once, its length by `layout`.

Tables of single precision and whole numbers lie in it by their bits.
"""

from collections import namedtuple
from dataclasses import fields

import numpy as np

from ..master.fmi.compiled import compiled
from .dynamics.assembly import mechanism
from .dynamics.drive import Scalars
from .dynamics.floating_frame import FlexibleBody
from .dynamics.gas_on_bore import BoreWall
from .dynamics.instant import Block, System
from .dynamics.parameters import Parameters
from .dynamics.quasi_static import StaticModes
from .geometry.film import Bore, FilmSurface, Skirt
from .geometry.modal_field import ModalField

WHOLE, FIRST_STATE, STATES, FIRST_FAULT, PARTS_FROM = range(5)
"""The head: lengths that `native_size` tells, then where parts begin."""

GIVEN = (
    "counts",
    "constants",
    "places",
    "angle",
    "height",
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
)
FIELDS = ("skirt_radial", "skirt_axial", "bore_radial", "bore_axial")
OF_FIELD = ("sizes", "table", "mode", "kind", "image", "share")
MADE = (
    "settings",
    "gap",
    "shape",
    "wall_above_now",
    "wall_at_now",
    "piston_stiffness",
    "piston_damping",
    "block_stiffness",
    "block_damping",
    "none",
)
"""At the start, from the parameters."""
STATE = ("numbers", "position", "velocity", "acceleration", "auxiliary", "other_forces")
"""In one piece."""
LAST = (
    "last_numbers",
    "last_position",
    "last_velocity",
    "last_acceleration",
    "modal_load",
    "linear_numbers",
    "top",
    "left",
    "diagonal",
    "coupling",
)
"""What a derivative at the end of the last step asks for."""
PARTS = (
    *GIVEN,
    *(f"{field}_{part}" for field in FIELDS for part in OF_FIELD),
    *MADE,
    *STATE,
    *LAST,
    "faults",
)
(
    COUNTS,
    CONSTANTS,
    PLACES,
    ANGLE,
    HEIGHT,
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
) = range(len(GIVEN))
SKIRT_RADIAL, SKIRT_AXIAL, BORE_RADIAL, BORE_AXIAL = (
    len(GIVEN) + k * len(OF_FIELD) for k in range(len(FIELDS))
)
(
    SETTINGS,
    GAP,
    SHAPE,
    WALL_ABOVE_NOW,
    WALL_AT_NOW,
    PISTON_STIFFNESS,
    PISTON_DAMPING,
    BLOCK_STIFFNESS,
    BLOCK_DAMPING,
    NONE,
) = (len(GIVEN) + len(FIELDS) * len(OF_FIELD) + k for k in range(len(MADE)))
NUMBERS, POSITION, VELOCITY, ACCELERATION, AUXILIARY, OTHER_FORCES = (
    NONE + 1 + k for k in range(len(STATE))
)
(
    LAST_NUMBERS,
    LAST_POSITION,
    LAST_VELOCITY,
    LAST_ACCELERATION,
    MODAL_LOAD,
    LINEAR_NUMBERS,
    TOP,
    LEFT,
    DIAGONAL,
    COUPLING,
) = (OTHER_FORCES + 1 + k for k in range(len(LAST)))
FAULTS_AT = len(PARTS) - 1

COUNTED = ("circumferential", "axial", "piston_modes", "block_modes", "stations")
CIRCUMFERENTIAL, AXIAL, PISTON_MODES, BLOCK_MODES, STATIONS = range(len(COUNTED))

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
) = range(len(CONSTANT))

# ---- numbers of the state, and of the last step

OF_STATE = ("time", "crank_angle", "crank_speed", "crank_acceleration", "kinetic", "steps")
TIME, CRANK_ANGLE, CRANK_SPEED, CRANK_ACCELERATION, KINETIC, STEPS = range(len(OF_STATE))
OF_COEFFICIENTS = 8
OF_LOAD = OF_COEFFICIENTS
OF_CRANK = OF_LOAD + 4
GUIDED = OF_CRANK + 3
IS_LINEAR = GUIDED + 1
EVALUATIONS = IS_LINEAR + 1
TANGENTS = EVALUATIONS + 1
LAST_COUNT = TANGENTS + 1
LINEAR_COUNT = 14

# ---- where numbers lie among the variables

SETTING = tuple(one.name for one in fields(Parameters))
SETTING_COUNT = len(SETTING)
Settings = namedtuple("Settings", SETTING)
"""`Parameters`, as kernels know them: floats."""
INPUTS = (
    "nodal_pressure_force",
    "nodal_friction_force",
    "gas_pressure",
    "land_pressure",
    "ring_side_force",
    "ring_axial_force",
    "ring_moment",
    "crank_speed",
)
OUTPUTS = (
    *Scalars._fields,
    "cylinder_pressure",
    "side_force_demand",
    "film_thickness",
    "sliding_velocity",
    "interface_work_error",
    "modal_coordinate",
    "modal_velocity",
    "residual_evaluations",
    "jacobian_evaluations",
)
(
    CYLINDER_PRESSURE,
    SIDE_FORCE_DEMAND,
    FILM_THICKNESS,
    SLIDING_VELOCITY,
    WORK_ERROR,
    MODAL_COORDINATE,
    MODAL_VELOCITY,
    RESIDUAL_EVALUATIONS,
    JACOBIAN_EVALUATIONS,
) = range(len(Scalars._fields), len(OUTPUTS))
ENERGY_GAIN = OUTPUTS.index("energy_gain")
ENERGY_SIZE = OUTPUTS.index("energy_size")
FORCE, DRAG, GAS, LAND, RINGS = range(5)
CRANK_SPEED_GIVEN = INPUTS.index("crank_speed")
"""Places among INPUTS; three numbers of the rings."""
OF_INPUTS = len(SETTING)
OF_OUTPUTS = OF_INPUTS + len(INPUTS)
OF_SEEDS = OF_OUTPUTS + len(OUTPUTS)
SEEDED_RINGS = OF_SEEDS + 2
OF_PRODUCTS = SEEDED_RINGS + 3
NOWHERE = -1.0

OF_A_FAULT = 6
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
def count(memory, k):
    """One of `COUNTED`."""
    return int(part(memory, COUNTS)[k])


@compiled
def settings_of(memory):
    """Parameters of the last start."""
    x = part(memory, SETTINGS)
    return Settings(
        x[0],
        x[1],
        x[2],
        x[3],
        x[4],
        x[5],
        x[6],
        x[7],
        x[8],
        x[9],
        x[10],
        x[11],
        x[12],
        x[13],
        x[14],
        x[15],
        x[16],
        x[17],
        x[18],
        x[19],
        x[20],
        x[21],
        x[22],
        x[23],
        x[24],
        x[25],
        x[26],
        x[27],
        x[28],
        x[29],
        x[30],
        x[31],
        x[32],
        x[33],
        x[34],
        x[35],
    )


@compiled
def field_of(memory: np.ndarray, first: int) -> ModalField:
    """The modal field whose parts begin with the `first` of `PARTS`."""
    sizes = part(memory, first)
    groups = int(sizes[0])
    classes = int(sizes[3])
    width = int(sizes[4])
    table = part(memory, first + 1).view(np.float32)
    length = int(sizes[1])
    return ModalField(
        table[: 4 * groups * length].reshape((4 * groups, length)),
        part(memory, first + 2).view(np.int64),
        part(memory, first + 3).view(np.int64),
        int(sizes[2]),
        classes,
        width,
        part(memory, first + 4).view(np.int64).reshape((classes, width)),
        part(memory, first + 5),
    )


@compiled
def system_of(memory: np.ndarray) -> System:
    """Both bodies, the mechanism and the film, as `assembly.assemble` makes them."""
    x = part(memory, CONSTANTS)
    c = count(memory, CIRCUMFERENTIAL)
    k = count(memory, PISTON_MODES)
    m = count(memory, BLOCK_MODES)
    s = count(memory, STATIONS)
    settings = settings_of(memory)
    lowest = part(memory, HEIGHTS)[0]
    none = part(memory, NONE)
    static = StaticModes(none, none.reshape((2, 0)), none, none)
    shape = part(memory, SHAPE)
    skirt = Skirt(
        part(memory, ANGLE),
        part(memory, HEIGHT),
        part(memory, GAP).reshape((c, count(memory, AXIAL))),
        x[BORE_RADIUS],
        x[PIN_OFFSET],
        field_of(memory, SKIRT_RADIAL),
        field_of(memory, SKIRT_AXIAL),
    )
    bore = Bore(
        lowest - x[SPACING],
        x[SPACING],
        field_of(memory, BORE_RADIAL),
        field_of(memory, BORE_AXIAL),
        shape.reshape((s + 2, c)),
    )
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
        (FilmSurface(skirt, bore),),
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
