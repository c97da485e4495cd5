"""The parameters of the body FMU: what a user may set."""

from dataclasses import dataclass, field
from typing import Any


def _declared(
    unit: str,
    description: str,
    start: float,
    minimum: float | None = None,
    maximum: float | None = None,
) -> Any:
    """A parameter's default and, for the table of variables, its unit, description and range."""
    metadata = dict(unit=unit, description=description, minimum=minimum, maximum=maximum)
    return field(default=start, metadata=metadata)


GAS_SOURCES = ("either", "table", "input", "sum")
"""Values of `gas_source`; a native FMU knows them by their numbers from 1 on."""
GAS_TWICE = (
    "gas_pressure: the input and the built-in table are both used and add up; set gas_source to "
    "table, input or sum"
)
"""Warning of a body whose gas pressure is given twice without a choice."""
NO_GAS_TABLE = "gas_source = table: the build has no table of gas pressure ([gas] in its table)"
"""Fault of a body that has no table to take its gas pressure from."""


@dataclass(frozen=True)
class Parameters:
    """Values of all parameters in SI. This is their one declaration: the table of variables
    (`variables.parameters`) is read from it; the defaults are those of the shipped case.
    """

    radial_clearance: float = _declared(
        "m", "Bore radius minus skirt radius at the thrust faces, mid skirt", 25e-6, 1e-6, 1e-3
    )
    barrel: float = _declared(
        "m", "Radial drop of the skirt profile at its upper and lower edge", 30e-6, 0.0, 1e-3
    )
    ovality: float = _declared(
        "m", "Skirt diameter across the thrust faces minus that along the pin", 150e-6, 0.0, 2e-3
    )
    skirt_growth_lower: float = _declared(
        "m",
        "Radial thermal growth of the skirt at its lower edge, linear to the upper one",
        0.0,
        -1e-3,
        1e-3,
    )
    skirt_growth_upper: float = _declared(
        "m", "Radial thermal growth of the skirt at its upper edge", 0.0, -1e-3, 1e-3
    )
    bore_growth_lower: float = _declared(
        "m",
        "Radial thermal growth of the bore at its lower end, linear to the upper one",
        0.0,
        -1e-3,
        1e-3,
    )
    bore_growth_upper: float = _declared(
        "m", "Radial thermal growth of the bore at its upper end", 0.0, -1e-3, 1e-3
    )
    crank_radius: float = _declared("m", "Half the stroke", 24.75e-3, 1e-3, 0.5)
    rod_length: float = _declared("m", "Between the eyes", 0.1, 5e-3, 2.0)
    crank_offset: float = _declared("m", "x of the crank axis from the bore axis", 0.0, -0.1, 0.1)
    rod_mass: float = _declared("kg", "Connecting rod", 0.14, 0.0, 100.0)
    rod_inertia: float = _declared(
        "kg.m2", "Of the rod about its centre of mass", 2.2e-4, 0.0, 10.0
    )
    rod_centre: float = _declared(
        "m", "Distance of the rod's centre of mass from the big end", 0.03, 0.0, 2.0
    )
    pin_mass: float = _declared(
        "kg", "Piston pin (and what else moves with A without turning)", 0.03, 0.0, 20.0
    )
    pin_friction_coefficient: float = _declared(
        "1", "Coulomb friction between pin and piston; 0: none", 0.01, 0.0, 1.0
    )
    pin_radius: float = _declared(
        "m", "Arm of the friction at the pin; 0: a quarter of the skirt's radius", 0.0, 0.0, 0.1
    )
    pin_friction_speed: float = _declared(
        "rad/s",
        "Relative angular velocity at which Coulomb friction has 76 % of its size",
        5.0,
        1e-3,
        1e3,
    )
    pin_friction_damping: float = _declared(
        "N.m.s/rad",
        "Viscous friction at the pin: moment by relative angular velocity",
        0.0,
        0.0,
        1e3,
    )
    top_ring_height: float = _declared(
        "m",
        "Of the top ring above the pin: gas widens the bore above it; 0: gas leaves the bore alone",
        0.0,
        0.0,
        1.0,
    )
    second_ring_height: float = _declared(
        "m", "Of the second ring above the pin: land_pressure stands between the two", 0.0, 0.0, 1.0
    )
    land_pressure_share: float = _declared(
        "1",
        "Of the gas pressure that stands between the two rings, beside land_pressure; 0: none does",
        0.0,
        0.0,
        1.0,
    )
    gas_source: str = field(
        default=GAS_SOURCES[0],
        metadata=dict(
            unit="1",
            description="Gas pressure on the piston: table (built in), input (gas_pressure), their "
            "sum, or either: also their sum, with a warning if both are used",
            choices=GAS_SOURCES,
        ),
    )
    crank_unbalance: float = _declared(
        "kg.m",
        "Mass times distance of the crank towards its pin, less than 0 with counterweights: enters "
        "force_on_block of a mounted block and on the film of a main_bearing, on nothing else",
        0.0,
        -100.0,
        100.0,
    )
    crank_free: int = _declared(
        "1", "0: crank at given speed, 1: free, driven by gas and load torque", 0, 0, 1
    )
    crank_inertia: float = _declared(
        "kg.m2", "Crank, flywheel and what they drive", 0.01, 1e-6, 1e4
    )
    load_torque: float = _declared("N.m", "Torque that a free crank works against", 0.0, -1e5, 1e5)
    pin_tilt: float = _declared(
        "rad",
        "Held rotation of pin and piston about +x: a pin that is not square to the bore's axis",
        0.0,
        -0.01,
        0.01,
    )
    start_crank_angle: float = _declared("rad", "Crank angle at the start", 0.0)
    start_lateral_displacement: float = _declared("m", "Of A at the start", 0.0, -1e-3, 1e-3)
    start_rocking_angle: float = _declared("rad", "At the start", 0.0, -0.05, 0.05)
    damping_ratio: float = _declared(
        "1", "Modal damping ratio below the transition frequency", 0.02, 0.0, 2.0
    )
    high_frequency_damping_ratio: float = _declared(
        "1", "Modal damping ratio above it", 0.5, 0.0, 2.0
    )
    damping_transition_frequency: float = _declared(
        "Hz", "Where the strong damping begins", 20e3, 0.0, 1e9
    )
    quasi_static_frequency: float = _declared(
        "Hz", "Modes above it follow their load without inertia", 1e9, 0.0, 1e9
    )
    rayleigh_mass_factor: float = _declared(
        "1/s", "Further damping proportional to mass", 0.0, 0.0, 1e6
    )
    rayleigh_stiffness_factor: float = _declared(
        "s", "Further damping proportional to stiffness", 0.0, 0.0, 1.0
    )
    spectral_radius: float = _declared(
        "1", "Of the time integrator at infinite frequency", 0.6, 0.0, 1.0
    )


@dataclass(frozen=True)
class PinParameters:
    """Those of a body FMU whose pin floats, beside `Parameters`, in SI."""

    boss_clearance: float = _declared(
        "m", "Radius of the piston's bosses minus that of the pin", 10e-6, 1e-7, 1e-3
    )
    small_end_clearance: float = _declared(
        "m", "Radius of the rod's eye minus that of the pin", 15e-6, 1e-7, 1e-3
    )
    pin_inertia: float = _declared(
        "kg.m2",
        "Of the floating pin about its axis; 0: that of a solid cylinder of its mass and radius",
        0.0,
        0.0,
        1.0,
    )


@dataclass(frozen=True)
class AxisParameters:
    """Those of a body FMU whose floating pin tilts or bends, beside `PinParameters`, in SI; the
    pin's density is its mass by its volume, relief is what keeps it from bearing at edges.
    """

    pin_length: float = _declared(
        "m",
        "Of the floating pin; 0: from the outer end of one boss to that of the other",
        0.0,
        0.0,
        1.0,
    )
    pin_bore_radius: float = _declared(
        "m", "Of the bore along the floating pin; 0: a solid one", 0.0, 0.0, 0.5
    )
    pin_young: float = _declared("Pa", "Young's modulus of the floating pin", 206e9, 1e8, 1e12)
    pin_poisson: float = _declared("1", "Poisson's ratio of the floating pin", 0.3, 0.0, 0.49)
    boss_relief: float = _declared(
        "m", "By which a boss is wider in radius at its ends than amid, a parabola", 0.0, 0.0, 1e-3
    )
    small_end_relief: float = _declared(
        "m", "By which the rod's eye is wider at its ends than amid, a parabola", 0.0, 0.0, 1e-3
    )


@dataclass(frozen=True)
class BigEndParameters:
    """Those of a body FMU whose rod turns on the crank in a film, beside `PinParameters`, in SI."""

    big_end_radius: float = _declared("m", "Of the crank pin in the rod", 24e-3, 1e-3, 1.0)
    big_end_clearance: float = _declared(
        "m", "Radius of the rod's big end minus that of the crank pin", 25e-6, 1e-7, 1e-3
    )


@dataclass(frozen=True)
class MainBearingParameters:
    """Those of a body FMU whose crank turns in the block in a film, beside `PinParameters`, in SI:
    one bearing that carries one cylinder; `crank_unbalance` acts on it.
    """

    main_bearing_radius: float = _declared(
        "m", "Of the crank's journal in the block", 27e-3, 1e-3, 1.0
    )
    main_bearing_clearance: float = _declared(
        "m", "Radius of the shell in the block minus that of the journal", 30e-6, 1e-7, 1e-3
    )
    crank_mass: float = _declared(
        "kg", "Of the crank, as much as moves with this bearing", 5.0, 1e-3, 1e4
    )


CRANK_PARAMETERS = {"big_end": BigEndParameters, "main_bearing": MainBearingParameters}
"""Surface of the crank -> its parameters."""


@dataclass(frozen=True)
class SpaceParameters:
    """Those of a body FMU whose piston moves in space, beside `Parameters`, in SI; what holds the
    piston across its plane beside the film is our own choice (`motion_in_space`).
    """

    pin_axial_play: float = _declared(
        "m",
        "Way of the piston along the pin to either side before boss meets rod",
        0.5e-3,
        0.0,
        0.1,
    )
    pin_axial_stiffness: float = _declared(
        "N/m", "Of boss against rod along the pin, beyond the play", 1e7, 0.0, 1e12
    )
    pin_axial_damping: float = _declared(
        "N.s/m", "Of the motion along the pin in the rod's eye", 10.0, 0.0, 1e6
    )
    pin_tilt_play: float = _declared(
        "rad", "Tilt of the pin in the rod's eye before both its ends bear", 1e-3, 0.0, 0.1
    )
    pin_tilt_stiffness: float = _declared(
        "N.m/rad", "Of rod and eye against roll and yaw, beyond the play", 3e4, 0.0, 1e9
    )
    pin_tilt_damping: float = _declared(
        "N.m.s/rad", "Of roll and yaw in the rod's eye", 1.0, 0.0, 1e6
    )
    pin_cross_inertia: float = _declared(
        "kg.m2",
        "Of the pin about a diameter, at its middle; 0: that of a solid cylinder of its mass and "
        "radius, 1.5 skirt radii long",
        0.0,
        0.0,
        10.0,
    )
