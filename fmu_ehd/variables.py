"""The variables of the lubrication FMU, each declared once."""

from collections.abc import Collection, Mapping
from dataclasses import replace

from ..master.fmi.variables import Variable, constant
from .declaration import choices_of, variables_of
from .oil import Oil
from .parameters import Parameters

CONTRACT_VERSION = 2

# allowed values of the parameters that choose a law
CHOICES = choices_of(Parameters) | choices_of(Oil)

OIL_VARIABLES = variables_of(Oil)
FILM_VARIABLES = variables_of(Parameters)
CONDITION_VARIABLES = variables_of(Parameters, condition=True)  # may be inputs

# outputs that an FMU may be built without
DIAGNOSTIC_FIELDS = ("pressure", "asperity_pressure", "film_fraction")

DERIVATIVE_INPUTS = ("film_thickness", "sliding_velocity")
DERIVATIVE_OUTPUTS = ("nodal_pressure_force", "nodal_friction_force")


def variables(
    shape: tuple[int, int],
    fields: bool = True,
    inputs: Collection[str] = (),
    starts: Mapping[str, float | str] | None = None,
) -> list[Variable]:
    """Variable table of the FMU for a grid.

    Parameters
    ----------
    shape : tuple of int
        (n_circumferential, n_axial).
    fields : bool
        False leaves the three diagnostic fields out.
    inputs : collection of str
        Names in `CONDITION_VARIABLES` that are inputs instead of parameters; "oil_temperature" adds
        a field input that replaces the two edge temperatures.
    starts : mapping, optional
        Start values of parameters, in place of the defaults (an oil of the library).

    Returns
    -------
    list of master.fmi.variables.Variable
    """
    conditions = [
        replace(v, causality="input") if v.name in inputs else v for v in CONDITION_VARIABLES
    ]
    if "oil_temperature" in inputs:
        conditions.append(
            Variable(
                "oil_temperature",
                "K",
                "input",
                "Oil temperature",
                373.15,
                nominal=373.15,
                shape=shape,
            )
        )
    parameters = [
        replace(v, start=starts[v.name]) if starts and v.name in starts else v
        for v in FILM_VARIABLES + OIL_VARIABLES
    ]
    diagnostic = [
        Variable(
            "pressure", "Pa", "output", "Hydrodynamic pressure, gauge", nominal=1e6, shape=shape
        ),
        Variable(
            "asperity_pressure",
            "Pa",
            "output",
            "Asperity contact pressure",
            nominal=1e6,
            shape=shape,
        ),
        Variable(
            "film_fraction",
            "1",
            "output",
            "Share of the film filled with oil",
            1.0,
            nominal=1.0,
            shape=shape,
        ),
    ]
    return [
        constant("n_circumferential", shape[0], "Cells around the skirt"),
        constant("n_axial", shape[1], "Cells along the skirt"),
        constant("contract_version", CONTRACT_VERSION, "Version of the lubrication contract"),
        *parameters,
        *conditions,
        Variable(
            "film_thickness",
            "m",
            "input",
            "Radial distance bore minus skirt at the end of the step, may be <= 0",
            1e-5,
            nominal=1e-5,
            shape=shape,
        ),
        Variable(
            "sliding_velocity",
            "m/s",
            "input",
            "Axial velocity of skirt minus bore at the end of the step",
            0.0,
            nominal=1.0,
            shape=shape,
        ),
        Variable(
            "nodal_pressure_force",
            "N",
            "output",
            "(Hydrodynamic + asperity pressure) x cell area",
            nominal=1.0,
            shape=shape,
        ),
        Variable(
            "nodal_friction_force",
            "N",
            "output",
            "Axial force of film and asperities on the skirt; its opposite acts on the bore",
            nominal=0.1,
            shape=shape,
        ),
        *(diagnostic if fields else []),
        Variable("minimum_film_thickness", "m", "output", "Thinnest film", nominal=1e-5),
        Variable(
            "maximum_pressure", "Pa", "output", "Highest hydrodynamic pressure, gauge", nominal=1e6
        ),
        Variable(
            "friction_force_hydrodynamic",
            "N",
            "output",
            "Axial force of the film on the skirt; its opposite acts on the bore",
            nominal=10.0,
        ),
        Variable(
            "friction_force_asperity",
            "N",
            "output",
            "Axial force of asperities on the skirt; its opposite acts on the bore",
            nominal=10.0,
        ),
        Variable(
            "friction_power",
            "W",
            "output",
            "Power that sliding costs, - axial force x velocity",
            nominal=100.0,
        ),
        Variable(
            "minimum_film_thickness_thrust_side",
            "m",
            "output",
            "Thinnest film of the thrust half",
            nominal=1e-5,
        ),
        Variable(
            "radial_force_thrust_side",
            "N",
            "output",
            "Force across the thrust plane, pushing apart, of the thrust half",
            nominal=100.0,
        ),
        Variable(
            "friction_force_thrust_side",
            "N",
            "output",
            "Axial force on the skirt of the thrust half",
            nominal=10.0,
        ),
        Variable(
            "minimum_film_thickness_anti_thrust_side",
            "m",
            "output",
            "Thinnest film of the anti-thrust half",
            nominal=1e-5,
        ),
        Variable(
            "radial_force_anti_thrust_side",
            "N",
            "output",
            "Force across the thrust plane, pushing apart, of the anti-thrust half",
            nominal=100.0,
        ),
        Variable(
            "friction_force_anti_thrust_side",
            "N",
            "output",
            "Axial force on the skirt of the anti-thrust half",
            nominal=10.0,
        ),
        Variable(
            "flow_lower_edge",
            "m3/s",
            "output",
            "Oil flow into the film over the lower edge at the end of the step",
            nominal=1e-6,
        ),
        Variable(
            "flow_upper_edge",
            "m3/s",
            "output",
            "Oil flow into the film over the upper edge at the end of the step",
            nominal=1e-6,
        ),
        Variable(
            "mass_imbalance",
            "1",
            "output",
            "|inflow - growth of film content| / throughput, rates at the end of the step",
        ),
        Variable("contact_area_fraction", "1", "output", "Real contact area / skirt area"),
        Variable("solver_iterations", "1", "output", "Factorisations in the last step", 0),
    ]
