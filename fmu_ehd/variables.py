"""The variables of the lubrication FMU, each declared once.

On a bearing skirt and bore are journal and shell; the grid, and with it the film thickness, rests
on the shell.
"""

from collections.abc import Collection, Mapping
from dataclasses import replace

from ..master.fmi.variables import Variable, constant, input_variable, output_variable
from .declaration import variables_of
from .oil import Oil
from .parameters import OF_BEARINGS, TUNABLE, Parameters

CONTRACT_VERSION = 2

OIL_VARIABLES = variables_of(Oil)
FILM_VARIABLES = variables_of(Parameters)
CONDITION_VARIABLES = variables_of(Parameters, condition=True)  # may be inputs

KELVIN = next(
    (v.minimum, v.maximum) for v in CONDITION_VARIABLES if v.name == "oil_temperature_lower_edge"
)

# outputs that an FMU may be built without
DIAGNOSTIC_FIELDS = ("pressure", "asperity_pressure", "film_fraction")

DERIVATIVE_INPUTS = ("film_thickness", "sliding_velocity")
DERIVATIVE_OUTPUTS = ("nodal_pressure_force", "nodal_friction_force")
# a bearing's, beside these
TURNING_INPUT = "circumferential_velocity"
TURNING_OUTPUT = "nodal_circumferential_force"


def variables(
    shape: tuple[int, int],
    fields: bool = True,
    inputs: Collection[str] = (),
    starts: Mapping[str, float | str] | None = None,
    surface: str = "skirt",
) -> list[Variable]:
    """Variable table of the FMU for a grid.

    Parameters
    ----------
    shape : tuple of int
        (n_circumferential, n_axial).
    fields : bool
        False leaves the three diagnostic fields out.
    inputs : collection of str
        Names in `CONDITION_VARIABLES` that are inputs instead of tunable parameters;
        "oil_temperature" adds a field input that replaces the two edge temperatures.
    starts : mapping, optional
        Start values of parameters, in place of the defaults (an oil of the library).
    surface : str
        One of `parameters.SURFACES`.

    Returns
    -------
    list of master.fmi.variables.Variable
    """
    conditions = [
        replace(v, causality="input") if v.name in inputs else replace(v, tunable=True)
        for v in CONDITION_VARIABLES
    ]
    if "oil_temperature" in inputs:
        conditions.append(
            input_variable(
                "oil_temperature", "K", "Oil temperature", 373.15, 373.15, shape, limits=KELVIN
            )
        )
    parameters = [
        replace(v, start=(starts or {}).get(v.name, v.start), tunable=v.name in TUNABLE)
        for v in film_variables(surface) + OIL_VARIABLES
    ]
    bearing = surface == "bearing"
    return [
        constant("n_circumferential", shape[0], "Number of cells around the skirt"),
        constant("n_axial", shape[1], "Number of cells along the skirt"),
        constant("contract_version", CONTRACT_VERSION, "Version of the lubrication contract"),
        *parameters,
        *conditions,
        *_interface(shape),
        *(_turning(shape) if bearing else []),
        *(_diagnostics(shape) if fields else []),
        *(v for v in SUMMARY if not (bearing and v.name.endswith("_thrust_side"))),
        *([FRICTION_TORQUE] if bearing else []),
    ]


def film_variables(surface: str) -> list[Variable]:
    """Rows of the parameters of a film that are no conditions, for one of `parameters.SURFACES`."""
    if surface == "bearing":
        return FILM_VARIABLES
    return [v for v in FILM_VARIABLES if v.name not in OF_BEARINGS]


def _interface(shape):
    """Return the variables that film and bodies exchange."""
    return [
        input_variable(
            "film_thickness",
            "m",
            "Radial distance from skirt to bore at the end of the step; negative where "
            "they overlap",
            1e-5,
            1e-5,
            shape,
        ),
        input_variable(
            "sliding_velocity",
            "m/s",
            "Axial velocity of the skirt relative to the bore at the end of the step",
            0.0,
            1.0,
            shape,
        ),
        output_variable(
            "nodal_pressure_force",
            "N",
            "Sum of hydrodynamic and asperity pressure, times the cell area",
            1.0,
            shape,
        ),
        output_variable(
            "nodal_friction_force",
            "N",
            "Axial force of film and asperities on the skirt; the opposite force acts on the bore",
            0.1,
            shape,
        ),
    ]


def _turning(shape):
    """Return the variables that a bearing exchanges in addition."""
    return [
        input_variable(
            TURNING_INPUT,
            "m/s",
            "Circumferential velocity of the journal relative to the shell at the end of "
            "the step, positive with ascending i",
            0.0,
            1.0,
            shape,
        ),
        output_variable(
            TURNING_OUTPUT,
            "N",
            "Circumferential force of film and asperities on the journal, positive with "
            "ascending i; the opposite force acts on the shell",
            0.1,
            shape,
        ),
    ]


def _diagnostics(shape):
    """Return the fields of `DIAGNOSTIC_FIELDS`."""
    return [
        output_variable("pressure", "Pa", "Hydrodynamic pressure, gauge", 1e6, shape),
        output_variable("asperity_pressure", "Pa", "Asperity contact pressure", 1e6, shape),
        output_variable(
            "film_fraction",
            "1",
            "Fraction of the film that is filled with oil",
            1.0,
            shape,
            start=1.0,
        ),
    ]


SUMMARY = (
    output_variable("minimum_film_thickness", "m", "Minimum film thickness", 1e-5),
    output_variable("maximum_pressure", "Pa", "Maximum hydrodynamic pressure, gauge", 1e6),
    output_variable(
        "friction_force_hydrodynamic",
        "N",
        "Axial force of the film on the skirt; the opposite force acts on the bore",
        10.0,
    ),
    output_variable(
        "friction_force_asperity",
        "N",
        "Axial force of the asperities on the skirt; the opposite force acts on the bore",
        10.0,
    ),
    output_variable(
        "friction_power", "W", "Friction power: minus the force times the sliding velocity", 100.0
    ),
    output_variable(
        "boundary_friction_share",
        "1",
        "Fraction of the friction work since the start that is due to asperities",
    ),
    output_variable(
        "minimum_film_thickness_thrust_side", "m", "Minimum film thickness of the thrust half", 1e-5
    ),
    output_variable(
        "radial_force_thrust_side",
        "N",
        "Force of the thrust half towards the thrust side; positive separates skirt and bore",
        100.0,
    ),
    output_variable(
        "friction_force_thrust_side", "N", "Axial force on the thrust half of the skirt", 10.0
    ),
    output_variable(
        "minimum_film_thickness_anti_thrust_side",
        "m",
        "Minimum film thickness of the anti-thrust half",
        1e-5,
    ),
    output_variable(
        "radial_force_anti_thrust_side",
        "N",
        "Force of the anti-thrust half towards the anti-thrust side; positive "
        "separates skirt and bore",
        100.0,
    ),
    output_variable(
        "friction_force_anti_thrust_side",
        "N",
        "Axial force on the anti-thrust half of the skirt",
        10.0,
    ),
    output_variable(
        "flow_lower_edge",
        "m3/s",
        "Oil flow into the film through the lower edge at the end of the step",
        1e-6,
    ),
    output_variable(
        "flow_upper_edge",
        "m3/s",
        "Oil flow into the film through the upper edge at the end of the step",
        1e-6,
    ),
    output_variable("stored_energy", "J", "Elastic energy of asperities and coating", 1e-3),
    output_variable(
        "energy_gain",
        "J",
        "Energy stored and dissipated over the step, minus the work of the pressure "
        "around the film",
        1e-3,
    ),
    output_variable(
        "flow_openings",
        "m3/s",
        "Oil flow into the film from cut-outs at the end of the step",
        1e-6,
    ),
    output_variable("oil_in_film", "m3", "Oil volume in the film", 1e-8),
    output_variable(
        "oil_on_bore",
        "m3",
        "Oil volume on the bore and at the edges of the skirt; 0 for oil_supply = edges",
        1e-8,
    ),
    output_variable(
        "oil_supplied",
        "m3",
        "Oil volume supplied by ring and splash since the start, minus the oil that ran off",
        1e-8,
    ),
    output_variable(
        "mass_imbalance",
        "1",
        "Relative mass imbalance at the end of the step: |inflow - growth of film "
        "content| / throughput",
    ),
    output_variable(
        "contact_area_fraction", "1", "Ratio of the real contact area to the skirt area"
    ),
    output_variable(
        "friction_power_hydrodynamic", "W", "Part of the friction power due to the film", 100.0
    ),
    output_variable(
        "friction_power_asperity", "W", "Part of the friction power due to asperities", 100.0
    ),
    output_variable(
        "heat_generated",
        "W",
        "Heat of sliding and squeezing in the film, mean over the step; surfaces of equal "
        "temperature receive half each",
        100.0,
    ),
    output_variable(
        "outflow_upper_edge",
        "m3/s",
        "Oil flow out of the film at the upper edge, over the cells where it leaves; at the end "
        "of the step",
        1e-6,
    ),
    output_variable("solver_iterations", "1", "Number of factorisations in the last step", start=0),
)
"""Outputs that sum the film up."""

FRICTION_TORQUE = output_variable(
    "friction_torque",
    "N.m",
    "Moment of the circumferential forces on the journal about the axis of the shell",
    1.0,
)
