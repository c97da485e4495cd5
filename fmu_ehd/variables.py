"""The variables of the lubrication FMU, each declared once."""

from master.fmi.variables import Variable, constant

CONTRACT_VERSION = 1

# FMU parameter -> field of `model.Parameters` with the same name
PARAMETERS = [
    Variable("bore_radius", "m", "parameter", "Radius of the cylinder bore", 28.25e-3, minimum=1e-3, maximum=1.0),
    Variable("skirt_length", "m", "parameter", "Axial length of the lubricated skirt", 27e-3, minimum=1e-3, maximum=2.0),
    Variable("viscosity", "Pa.s", "parameter", "Dynamic viscosity of the oil", 0.01, minimum=1e-5, maximum=1e3),
    Variable("pressure_lower_edge", "Pa", "parameter", "Pressure at the lower edge, gauge", 0.0, minimum=-2e5, maximum=1e8),
    Variable("pressure_upper_edge", "Pa", "parameter", "Pressure at the upper edge, gauge", 0.0, minimum=-2e5, maximum=1e8),
    Variable("cavitation_pressure", "Pa", "parameter", "Cavitation pressure, gauge", 0.0, minimum=-2e5, maximum=1e8),
    Variable("film_fraction_lower_edge", "1", "parameter", "Film fraction of the oil entering at the lower edge", 1.0,
             minimum=0.0, maximum=1.0),
    Variable("film_fraction_upper_edge", "1", "parameter", "Film fraction of the oil entering at the upper edge", 1.0,
             minimum=0.0, maximum=1.0),
    Variable("minimum_flow_film", "m", "parameter", "Film thickness below which the oil sees no thinner film", 5e-8,
             minimum=1e-9, maximum=1e-5),
    Variable("roughness_rms", "m", "parameter", "Composite rms roughness of skirt and bore; 0 = smooth, no asperity contact", 0.0,
             minimum=0.0, maximum=1e-4),
    Variable("asperity_product", "1", "parameter", "Asperity density x tip radius x rms height (eta beta sigma)", 0.04,
             minimum=1e-4, maximum=1.0),
    Variable("asperity_slope", "1", "parameter", "Rms height / tip radius (sigma/beta)", 1e-3, minimum=1e-6, maximum=1.0),
    Variable("contact_modulus", "Pa", "parameter", "Contact modulus E*, 1/E* = sum of (1-nu^2)/E of both bodies", 6e10,
             minimum=1e6, maximum=1e12),
    Variable("boundary_friction_coefficient", "1", "parameter", "Friction coefficient of asperity contact", 0.12,
             minimum=0.0, maximum=2.0),
    Variable("friction_rounding_velocity", "m/s", "parameter", "Velocity below which asperity friction fades", 1e-3,
             minimum=1e-9, maximum=1.0),
]

DERIVATIVE_INPUTS = ("film_thickness", "sliding_velocity")
DERIVATIVE_OUTPUTS = ("nodal_pressure_force", "nodal_friction_force")


def variables(shape, fields=True):
    """Variable table of the FMU for a grid.

    Parameters
    ----------
    shape : tuple of int
        (n_circumferential, n_axial).
    fields : bool
        False leaves the three diagnostic fields out.

    Returns
    -------
    list of master.fmi.variables.Variable
    """
    diagnostic = [
        Variable("pressure", "Pa", "output", "Hydrodynamic pressure, gauge", nominal=1e6, shape=shape),
        Variable("asperity_pressure", "Pa", "output", "Asperity contact pressure", nominal=1e6, shape=shape),
        Variable("film_fraction", "1", "output", "Share of the film filled with oil", 1.0, nominal=1.0, shape=shape),
    ]
    return [
        constant("n_circumferential", shape[0], "Cells around the skirt"),
        constant("n_axial", shape[1], "Cells along the skirt"),
        constant("contract_version", CONTRACT_VERSION, "Version of the lubrication contract"),
        *PARAMETERS,
        Variable("film_thickness", "m", "input", "Radial distance bore minus skirt at the end of the step, may be <= 0", 1e-5,
                 nominal=1e-5, shape=shape),
        Variable("sliding_velocity", "m/s", "input", "Axial velocity of skirt minus bore at the end of the step", 0.0,
                 nominal=1.0, shape=shape),
        Variable("nodal_pressure_force", "N", "output", "(Hydrodynamic + asperity pressure) x cell area", nominal=1.0,
                 shape=shape),
        Variable("nodal_friction_force", "N", "output", "Axial shear force on the skirt", nominal=0.1, shape=shape),
        *(diagnostic if fields else []),
        Variable("minimum_film_thickness", "m", "output", "Thinnest film", nominal=1e-5),
        Variable("maximum_pressure", "Pa", "output", "Highest hydrodynamic pressure, gauge", nominal=1e6),
        Variable("friction_force_hydrodynamic", "N", "output", "Viscous shear force on the skirt", nominal=10.0),
        Variable("friction_force_asperity", "N", "output", "Asperity friction force on the skirt", nominal=10.0),
        Variable("friction_power", "W", "output", "Power that sliding costs", nominal=100.0),
        Variable("flow_lower_edge", "m3/s", "output", "Oil flow into the film over the lower edge", nominal=1e-6),
        Variable("flow_upper_edge", "m3/s", "output", "Oil flow into the film over the upper edge", nominal=1e-6),
        Variable("mass_imbalance", "1", "output", "|inflow - growth of film content| / throughput of the step"),
        Variable("contact_area_fraction", "1", "output", "Real contact area / skirt area"),
        Variable("solver_iterations", "1", "output", "Factorisations in the last step", 0),
    ]
