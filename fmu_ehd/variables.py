"""The variables of the lubrication FMU, each declared once."""

from dataclasses import replace

from ..master.fmi.variables import Variable, constant

CONTRACT_VERSION = 1

# allowed values of the parameters that choose a law
CHOICES = {
    "cavitation_model": ("jfo", "reynolds", "gumbel", "full_film"),
    "cavity_shear": ("film_fraction", "full_film"),
    "viscosity_law": ("constant", "vogel_1921", "walther_1931", "two_point"),
    "pressure_viscosity_law": ("none", "barus_1893", "roelands_1966"),
    "shear_thinning_law": ("none", "cross_1965", "carreau_1972"),
    "flow_factors": ("none", "patir_cheng_1978"),
    "contact_law": ("greenwood_tripp_1970", "power_fit"),
}


def _parameter(name, unit, start, low, high, description):
    return Variable(name, unit, "parameter", description, start, minimum=low, maximum=high)


def _choice(name, description):
    return Variable(
        name, "1", "parameter", f"{description}: {', '.join(CHOICES[name])}", CHOICES[name][0]
    )


OIL = [  # FMU parameter = field of `oil.Oil`
    _choice("viscosity_law", "Viscosity by temperature"),
    _choice("pressure_viscosity_law", "Viscosity by pressure"),
    _choice("shear_thinning_law", "Viscosity by shear rate"),
    _parameter("viscosity", "Pa.s", 0.01, 1e-5, 1e3, "Dynamic viscosity (constant)"),
    _parameter(
        "vogel_viscosity", "Pa.s", 6.51457e-5, 1e-9, 1e2, "K of mu = K exp(B/(t + C)) (vogel_1921)"
    ),
    _parameter("vogel_b", "K", 1009.863, 0.0, 1e4, "B (vogel_1921)"),
    _parameter("vogel_c", "K", 109.047, 50.0, 300.0, "C, t in degrees Celsius (vogel_1921)"),
    _parameter(
        "walther_a", "1", 8.0, 1.0, 20.0, "A of lg lg(nu + 0.7) = A - M lg T (walther_1931)"
    ),
    _parameter("walther_m", "1", 3.1, 0.1, 8.0, "M (walther_1931)"),
    _parameter("density", "kg/m3", 850.0, 500.0, 2000.0, "Density (walther_1931, two_point)"),
    _parameter("viscosity_40", "Pa.s", 0.06, 1e-3, 1e2, "Dynamic viscosity at 40 C (two_point)"),
    _parameter("viscosity_100", "Pa.s", 0.009, 5e-4, 1e1, "Dynamic viscosity at 100 C (two_point)"),
    _parameter(
        "pressure_viscosity_coefficient", "1/Pa", 1.5e-8, 1e-10, 1e-7, "alpha = d ln mu/dp at p = 0"
    ),
    _parameter("high_shear_ratio", "1", 0.74, 1e-3, 1.0, "Viscosity at high over low shear rate"),
    _parameter(
        "shear_thinning_exponent",
        "1",
        1.0,
        0.1,
        4.0,
        "n of the shear thinning law, below 1 in carreau_1972",
    ),
    _parameter(
        "critical_shear_rate_a",
        "1",
        2.5,
        -5.0,
        15.0,
        "a of lg g_c = a + b t, g_c critical shear rate in 1/s",
    ),
    _parameter("critical_shear_rate_b", "1/K", 0.0213, -0.1, 0.1, "b, t in degrees Celsius"),
]

CONDITIONS = [  # may be inputs
    _parameter("pressure_lower_edge", "Pa", 0.0, -2e5, 1e8, "Pressure at the lower edge, gauge"),
    _parameter("pressure_upper_edge", "Pa", 0.0, -2e5, 1e8, "Pressure at the upper edge, gauge"),
    _parameter(
        "film_fraction_lower_edge",
        "1",
        1.0,
        0.0,
        1.0,
        "Film fraction of the oil entering at the lower edge",
    ),
    _parameter(
        "film_fraction_upper_edge",
        "1",
        1.0,
        0.0,
        1.0,
        "Film fraction of the oil entering at the upper edge",
    ),
    _parameter(
        "oil_temperature_lower_edge",
        "K",
        373.15,
        233.15,
        573.15,
        "Oil temperature at the lower edge, linear between",
    ),
    _parameter(
        "oil_temperature_upper_edge",
        "K",
        373.15,
        233.15,
        573.15,
        "Oil temperature at the upper edge",
    ),
]

FILM = [  # FMU parameter = field of `model.Parameters`
    _choice("cavitation_model", "Cavitation"),
    _choice("cavity_shear", "Share of the cavitated film that shears"),
    _choice("flow_factors", "Average flow between rough surfaces"),
    _choice("contact_law", "Asperity contact"),
    _parameter("bore_radius", "m", 28.25e-3, 1e-3, 1.0, "Radius of the cylinder bore"),
    _parameter("skirt_length", "m", 27e-3, 1e-3, 2.0, "Axial length of the lubricated skirt"),
    _parameter("cavitation_pressure", "Pa", 0.0, -2e5, 1e8, "Cavitation pressure, gauge"),
    _parameter(
        "minimum_flow_film",
        "m",
        5e-8,
        1e-9,
        1e-5,
        "Film thickness below which the oil sees no thinner film",
    ),
    _parameter(
        "roughness_rms",
        "m",
        0.0,
        0.0,
        1e-4,
        "Composite rms roughness of skirt and bore; 0 = smooth, no contact",
    ),
    _parameter(
        "peklenik_number",
        "1",
        1.0,
        1.0 / 9.0,
        9.0,
        "Roughness correlation length along over across the axis",
    ),
    _parameter(
        "roughness_share_skirt", "1", 0.8, 0.0, 1.0, "Skirt's share of the roughness variance"
    ),
    _parameter(
        "asperity_product",
        "1",
        0.04,
        1e-4,
        1.0,
        "Asperity density x tip radius x rms height (eta beta sigma)",
    ),
    _parameter("asperity_slope", "1", 1e-3, 1e-6, 1.0, "Rms height / tip radius (sigma/beta)"),
    _parameter(
        "contact_modulus",
        "Pa",
        6e10,
        1e6,
        1e12,
        "Contact modulus E*, 1/E* = sum of (1-nu^2)/E of both bodies",
    ),
    _parameter(
        "boundary_friction_coefficient",
        "1",
        0.12,
        0.0,
        2.0,
        "Friction coefficient of asperity contact",
    ),
    _parameter(
        "boundary_shear_strength",
        "Pa",
        0.0,
        0.0,
        1e9,
        "Shear strength of the boundary layer in contact",
    ),
    _parameter(
        "friction_rounding_velocity",
        "m/s",
        1e-3,
        1e-9,
        1.0,
        "Velocity below which asperity friction fades",
    ),
    _parameter("coating_thickness", "m", 0.0, 0.0, 1e-3, "Thickness of a soft coating; 0 = none"),
    _parameter("coating_modulus", "Pa", 1e9, 1e6, 1e12, "Young's modulus of the coating"),
    _parameter("coating_poisson", "1", 0.3, 0.0, 0.45, "Poisson's ratio of the coating"),
]

DERIVATIVE_INPUTS = ("film_thickness", "sliding_velocity")
DERIVATIVE_OUTPUTS = ("nodal_pressure_force", "nodal_friction_force")


def variables(shape, fields=True, inputs=(), starts=None):
    """Variable table of the FMU for a grid.

    Parameters
    ----------
    shape : tuple of int
        (n_circumferential, n_axial).
    fields : bool
        False leaves the three diagnostic fields out.
    inputs : collection of str
        Names in `CONDITIONS` that are inputs instead of parameters; "oil_temperature" adds a field
        input that replaces the two edge temperatures.
    starts : dict, optional
        Start values of parameters, in place of the defaults (an oil of the library).

    Returns
    -------
    list of master.fmi.variables.Variable
    """
    conditions = [replace(v, causality="input") if v.name in inputs else v for v in CONDITIONS]
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
        replace(v, start=starts[v.name]) if starts and v.name in starts else v for v in FILM + OIL
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
            "Axial shear force on the skirt",
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
            "Viscous shear force on the skirt",
            nominal=10.0,
        ),
        Variable(
            "friction_force_asperity",
            "N",
            "output",
            "Asperity friction force on the skirt",
            nominal=10.0,
        ),
        Variable("friction_power", "W", "output", "Power that sliding costs", nominal=100.0),
        *(
            Variable(
                f"{name}_{side}_side",
                unit,
                "output",
                f"{what} of the {side.replace('_', '-')} half",
                nominal=nominal,
            )
            for side in ("thrust", "anti_thrust")
            for name, unit, what, nominal in (
                ("minimum_film_thickness", "m", "Thinnest film", 1e-5),
                ("radial_force", "N", "Force across the thrust plane, pushing apart,", 100.0),
                ("friction_force", "N", "Axial force on the skirt", 10.0),
            )
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
