"""The parameters of the body FMU: what a user may set."""

from collections import namedtuple
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any, TypeVar

from ...master.fmi.symmetry import FILM_SYMMETRIES
from ..force_elements import FORCE_ELEMENTS
from ..force_elements.element import declared as _declared

Kind = TypeVar("Kind")

GAS_SOURCES = ("either", "table", "input", "sum")
"""Values of `gas_source`; in a native FMU their numbers from 1 on."""
GAS_TWICE = (
    "gas_pressure: the input and the built-in table are both used and add up; set gas_source to "
    "table, input or sum"
)
"""Warning of a body whose gas pressure is given twice without a choice."""
TORQUE_UNUSED = "load_torque: it has no effect on a crank of prescribed speed; set crank_free = 1"
"""Warning of a load torque on a crank that does not follow it."""
TUNABLE = (
    "damping_ratio",
    "high_frequency_damping_ratio",
    "damping_transition_frequency",
)
"""Parameters that may change between steps: the damping of all modes."""
Damping = namedtuple("Damping", TUNABLE)
NO_GAS_TABLE = "gas_source: expected a table build.gas with gas_source = table, got none"
"""Fault of a body that has no table to take its gas pressure from."""


def _choice(allowed: tuple[str, ...], advanced: bool = False) -> Any:
    """Declare a choice, whose first value is the default."""
    known = dict(unit="1", choices=allowed, advanced=advanced)
    return field(default=allowed[0], metadata=known)


@dataclass(frozen=True)
class Parameters:
    """Values of all parameters in SI.

    This is their only declaration, which `variables.parameters` reads. The defaults are those of
    the shipped case.
    """

    radial_clearance: float = _declared("m", 25e-6, 1e-6, 1e-3)
    """Bore radius minus skirt radius at the thrust faces, at mid-height of the skirt."""
    barrel: float = _declared("m", 30e-6, 0.0, 1e-3)
    """Radial drop of the skirt profile at its upper and lower edges."""
    ovality: float = _declared("m", 150e-6, 0.0, 2e-3)
    """Skirt diameter across the thrust faces minus the diameter along the pin."""
    skirt_growth_lower: float = _declared("m", 0.0, -1e-3, 1e-3)
    """Radial thermal growth of the skirt at its lower edge; it varies linearly to the upper edge.
    """
    skirt_growth_upper: float = _declared("m", 0.0, -1e-3, 1e-3)
    """Radial thermal growth of the skirt at its upper edge."""
    bore_growth_lower: float = _declared("m", 0.0, -1e-3, 1e-3)
    """Radial thermal growth of the bore at its lower end; it varies linearly to the upper end."""
    bore_growth_upper: float = _declared("m", 0.0, -1e-3, 1e-3)
    """Radial thermal growth of the bore at its upper end."""
    piston_expansion: float = _declared("1/K", 20e-6, 0.0, 1e-4)
    """Coefficient of thermal expansion of the piston."""
    bore_expansion: float = _declared("1/K", 11e-6, 0.0, 1e-4)
    """Coefficient of thermal expansion of the bore."""
    reference_temperature: float = _declared("K", 293.15, 200.0, 1000.0)
    """Temperature at which piston_temperature and bore_temperature have no effect."""
    crank_radius: float = _declared("m", 24.75e-3, 1e-3, 0.5)
    """Crank radius, half the stroke."""
    rod_length: float = _declared("m", 0.1, 5e-3, 2.0)
    """Length of the connecting rod between the axes of its ends."""
    crank_offset: float = _declared("m", 0.0, -0.1, 0.1)
    """Offset of the crank axis from the bore axis along x."""
    rod_mass: float = _declared("kg", 0.14, 0.0, 100.0)
    """Mass of the connecting rod."""
    rod_inertia: float = _declared("kg.m2", 2.2e-4, 0.0, 10.0)
    """Moment of inertia of the connecting rod about its centre of mass."""
    rod_centre: float = _declared("m", 0.03, 0.0, 2.0)
    """Distance of the rod's centre of mass from the big end."""
    pin_mass: float = _declared("kg", 0.03, 0.0, 20.0)
    """Mass of the piston pin and of parts that move with pin point A without rotation."""
    pin_friction_coefficient: float = _declared("1", 0.01, 0.0, 1.0)
    """Coulomb friction coefficient between pin and piston; 0: no friction."""
    pin_radius: float = _declared("m", 0.0, 0.0, 0.1)
    """Lever arm of the friction at the pin; 0: a quarter of the skirt radius."""
    pin_friction_speed: float = _declared("rad/s", 5.0, 1e-3, 1e3, advanced=True)
    """Relative angular velocity at which Coulomb friction reaches 76 % of its maximum."""
    pin_friction_damping: float = _declared("N.m.s/rad", 0.0, 0.0, 1e3, advanced=True)
    """Viscous friction at the pin: moment per relative angular velocity."""
    top_ring_height: float = _declared("m", 0.0, 0.0, 1.0)
    """Height of the top ring above pin point A, above which gas widens the bore; 0: no gas on the
    bore.
    """
    second_ring_height: float = _declared("m", 0.0, 0.0, 1.0)
    """Height of the second ring above pin point A; land_pressure acts between both rings."""
    land_pressure_share: float = _declared("1", 0.0, 0.0, 1.0)
    """Fraction of the gas pressure that acts between both rings, in addition to land_pressure."""
    gas_source: str = _choice(GAS_SOURCES, advanced=True)
    """Source of the gas pressure: built-in table, input gas_pressure, or their sum; either also
    adds them, and warns if both are used.
    """
    film_symmetry: str = _choice(FILM_SYMMETRIES)
    """Part of the skirt's films that is computed: thrust_plane for one half, automatic for one half
    if bodies and forces at the start are symmetric.
    """
    crank_unbalance: float = _declared("kg.m", 0.0, -100.0, 100.0)
    """Mass times distance of the crank towards its pin; negative with counterweights. It affects
    only forces on the block and the film of a main_bearing.
    """
    crank_free: int = _declared("1", 0, 0, 1)
    """0: prescribed crank speed, 1: free crank, driven by gas pressure and load torque."""
    crank_inertia: float = _declared("kg.m2", 0.01, 1e-6, 1e4)
    """Moment of inertia of crank, flywheel and driven parts."""
    pin_tilt: float = _declared("rad", 0.0, -0.01, 0.01)
    """Constant rotation of pin and piston about +x, for a pin that is not square to the bore axis.
    """
    start_crank_angle: float = _declared("rad", 0.0)
    """Crank angle at the start."""
    start_lateral_displacement: float = _declared("m", 0.0, -1e-3, 1e-3, advanced=True)
    """Lateral displacement of pin point A at the start."""
    start_rocking_angle: float = _declared("rad", 0.0, -0.05, 0.05, advanced=True)
    """Rocking angle at the start."""
    damping_ratio: float = _declared("1", 0.02, 0.0, 2.0)
    """Modal damping ratio below the transition frequency."""
    high_frequency_damping_ratio: float = _declared("1", 0.5, 0.0, 2.0)
    """Modal damping ratio above the transition frequency."""
    damping_transition_frequency: float = _declared("Hz", 20e3, 0.0, 1e9)
    """Frequency above which high_frequency_damping_ratio applies."""
    quasi_static_frequency: float = _declared("Hz", 1e9, 0.0, 1e9)
    """Frequency above which modes follow their load without inertia."""
    spectral_radius: float = _declared("1", 0.6, 0.0, 1.0, advanced=True)
    """Spectral radius of the time integrator at infinite frequency."""
    impact_resolution: float = _declared("m", 10e-9, 0.0, 1.0)
    """Displacement within a step from which shorter steps resolve an impact; 1 m for never."""


@dataclass(frozen=True)
class PinParameters:
    """Parameters of a body FMU whose pin floats, in addition to `Parameters`, in SI."""

    boss_clearance: float = _declared("m", 10e-6, 1e-7, 1e-3)
    """Radius of the piston bosses minus radius of the pin."""
    small_end_clearance: float = _declared("m", 15e-6, 1e-7, 1e-3)
    """Radius of the rod's small end minus radius of the pin."""
    pin_inertia: float = _declared("kg.m2", 0.0, 0.0, 1.0, advanced=True)
    """Moment of inertia of the floating pin about its axis; 0: solid cylinder of its mass and
    radius.
    """


@dataclass(frozen=True)
class AxisParameters:
    """Parameters of a floating pin that tilts or bends, in addition to `PinParameters`, in SI.

    The pin's density is its mass divided by its volume. Relief keeps it from bearing at edges.
    """

    pin_length: float = _declared("m", 0.0, 0.0, 1.0)
    """Length of the floating pin; 0: distance between the outer ends of the bosses."""
    pin_bore_radius: float = _declared("m", 0.0, 0.0, 0.5)
    """Inner radius of the floating pin; 0: solid pin."""
    pin_young: float = _declared("Pa", 206e9, 1e8, 1e12)
    """Young's modulus of the floating pin."""
    pin_poisson: float = _declared("1", 0.3, 0.0, 0.49)
    """Poisson's ratio of the floating pin."""
    boss_relief: float = _declared("m", 0.0, 0.0, 1e-3)
    """Parabolic radial relief at the ends of a boss."""
    small_end_relief: float = _declared("m", 0.0, 0.0, 1e-3)
    """Parabolic radial relief at the ends of the rod's small end."""


@dataclass(frozen=True)
class BigEndParameters:
    """Parameters of a big end that turns on a film, in addition to `PinParameters`, in SI."""

    big_end_radius: float = _declared("m", 24e-3, 1e-3, 1.0)
    """Radius of the crank pin."""
    big_end_clearance: float = _declared("m", 25e-6, 1e-7, 1e-3)
    """Radius of the rod's big end minus radius of the crank pin."""


@dataclass(frozen=True)
class MainBearingParameters:
    """Parameters of a crank with a film in the block, in addition to `PinParameters`, in SI.

    One bearing carries one cylinder, and `crank_unbalance` acts on it.
    """

    main_bearing_radius: float = _declared("m", 27e-3, 1e-3, 1.0)
    """Radius of the main journal of the crank."""
    main_bearing_clearance: float = _declared("m", 30e-6, 1e-7, 1e-3)
    """Radius of the main bearing shell minus radius of the main journal."""
    crank_mass: float = _declared("kg", 5.0, 1e-3, 1e4)
    """Mass of the crank that moves with this bearing."""


@dataclass(frozen=True)
class SkirtTemperatureParameters:
    """Parameter of a skirt whose temperature the build options give, in SI."""

    skirt_temperature_rise: float = _declared("K", 0.0, -300.0, 300.0)
    """Temperature of the skirt at its upper edge minus that at its lower edge, linear in height
    about piston_temperature.
    """


@dataclass(frozen=True)
class BoreTemperatureParameters:
    """Parameter of a bore whose temperature the build options give, in SI."""

    bore_temperature_rise: float = _declared("K", 0.0, -300.0, 300.0)
    """Temperature of the bore at its upper end minus that at its lower end, linear in height about
    bore_temperature.
    """


REFERENCE = float(Parameters().reference_temperature)
"""Temperature of piston and bore without growth [K]."""

CRANK_PARAMETERS = {"big_end": BigEndParameters, "main_bearing": MainBearingParameters}
"""Surface of the crank -> its parameters."""

CHOICES = {"gas_source": GAS_SOURCES, "film_symmetry": FILM_SYMMETRIES}
"""Values of the parameters that are choices; in kernels their numbers from 1 on."""
WALL_PARAMETERS = {"skirt": SkirtTemperatureParameters, "bore": BoreTemperatureParameters}
"""Wall -> parameters of its temperature."""
ELEMENT_PARAMETERS = tuple(dict.fromkeys(one.parameters for one in FORCE_ELEMENTS))
"""Parameters of force elements, which every body FMU has. Several elements may share a class."""
DECLARED = (
    Parameters,
    PinParameters,
    AxisParameters,
    *CRANK_PARAMETERS.values(),
    *WALL_PARAMETERS.values(),
    *ELEMENT_PARAMETERS,
)
Settings = namedtuple("Settings", (one.name for kind in DECLARED for one in fields(kind)))
Settings.__annotations__ = dict.fromkeys(Settings._fields, float)
"""`Parameters` and those of pin and crank for kernels: floats, 0 if absent."""


def parameters_from(kind: type[Kind], values: Mapping[str, Any]) -> Kind:
    """Return the parameters of a class from values by name; the others have their defaults."""
    return kind(**{name: values[name] for name in vars(kind()) if name in values})


def settings_of(*chosen: Any) -> Settings:
    """Return all parameters of the given classes as numbers, those of other classes as 0."""
    values = {name: value for one in chosen for name, value in vars(one).items()}
    for name, choices in CHOICES.items():
        values[name] = 1 + choices.index(values[name])
    return Settings(*(float(values.get(name, 0.0)) for name in Settings._fields))


@dataclass(frozen=True)
class SpaceParameters:
    """Parameters of a piston that moves in space, in addition to `Parameters`, in SI.

    The supports of the piston across its plane are our own choice (`motion_in_space`).
    """

    pin_axial_play: float = _declared("m", 0.5e-3, 0.0, 0.1)
    """Axial play of the piston along the pin to either side, before the boss touches the rod."""
    pin_axial_stiffness: float = _declared("N/m", 1e7, 0.0, 1e12)
    """Contact stiffness of boss and rod along the pin, beyond the play."""
    pin_axial_damping: float = _declared("N.s/m", 10.0, 0.0, 1e6)
    """Damping of the motion along the pin in the small end."""
    pin_tilt_play: float = _declared("rad", 1e-3, 0.0, 0.1)
    """Tilt of the pin in the small end at which both ends touch."""
    pin_tilt_stiffness: float = _declared("N.m/rad", 3e4, 0.0, 1e9)
    """Stiffness of rod and small end against roll and yaw, beyond the play."""
    pin_tilt_damping: float = _declared("N.m.s/rad", 1.0, 0.0, 1e6)
    """Damping of roll and yaw in the small end."""
    pin_cross_inertia: float = _declared("kg.m2", 0.0, 0.0, 10.0)
    """Moment of inertia of the pin about a diameter at its middle; 0: solid cylinder of its mass
    and radius, 1.5 skirt radii long.
    """
