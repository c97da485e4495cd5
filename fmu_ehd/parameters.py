"""What is fixed for a run."""

from dataclasses import dataclass, field

import numpy as np

from .oil import Oil


@dataclass(frozen=True)
class Parameters:
    """What is fixed for a run; names, units and ranges in `variables.py`.

    Parameters
    ----------
    shape : tuple of int
        (n_circumferential, n_axial).
    oil : oil.Oil
    cavitation_model, flow_factors, contact_law, cavity_shear : str
        Chosen laws, keys of `variables.CHOICES`.
    bore_radius, skirt_length, minimum_flow_film, roughness_rms : float
        [m].
    pressure_lower_edge, pressure_upper_edge, cavitation_pressure, contact_modulus,
    boundary_shear_strength : float
        [Pa], pressures on one datum, edges not below cavitation.
    film_fraction_lower_edge, film_fraction_upper_edge : float
        [-].
    oil_temperature_lower_edge, oil_temperature_upper_edge : float
        [K], linear between.
    asperity_product, asperity_slope, boundary_friction_coefficient : float
        eta beta sigma, sigma/beta, mu_b of `asperity` [-].
    peklenik_number, roughness_share_skirt : float
        gamma and Y of `roughness` and `films` [-].
    friction_rounding_velocity : float
        [m/s].
    coating_thickness, coating_modulus, coating_poisson : float
        Soft layer, d [m], E [Pa], nu [-] of `coating`; 0 m = none.
    open_cells : ndarray of bool, shape (n_c, n_a), optional
        Cut-outs.
    """

    shape: tuple = (40, 40)
    oil: Oil = field(default_factory=Oil)
    cavitation_model: str = "jfo"
    flow_factors: str = "none"
    contact_law: str = "greenwood_tripp_1970"
    cavity_shear: str = "film_fraction"
    bore_radius: float = 28.25e-3
    skirt_length: float = 27e-3
    pressure_lower_edge: float = 0.0
    pressure_upper_edge: float = 0.0
    cavitation_pressure: float = 0.0
    film_fraction_lower_edge: float = 1.0
    film_fraction_upper_edge: float = 1.0
    oil_temperature_lower_edge: float = 373.15
    oil_temperature_upper_edge: float = 373.15
    minimum_flow_film: float = 5e-8
    roughness_rms: float = 0.0
    peklenik_number: float = 1.0
    roughness_share_skirt: float = 0.8
    asperity_product: float = 0.04
    asperity_slope: float = 1e-3
    contact_modulus: float = 6e10
    boundary_friction_coefficient: float = 0.12
    boundary_shear_strength: float = 0.0
    friction_rounding_velocity: float = 1e-3
    coating_thickness: float = 0.0
    coating_modulus: float = 1e9
    coating_poisson: float = 0.3
    open_cells: np.ndarray | None = None


CONDITIONS = (
    "pressure_lower_edge",
    "pressure_upper_edge",
    "film_fraction_lower_edge",
    "film_fraction_upper_edge",
    "oil_temperature_lower_edge",
    "oil_temperature_upper_edge",
)


def faults(parameters):
    """What is wrong between parameters that are each in range.

    Parameters
    ----------
    parameters : Parameters

    Returns
    -------
    list of str
        One sentence a fault.
    """
    p = parameters
    found = [
        f"pressure_{edge}_edge = {pressure:g} Pa: must not be below cavitation_pressure = {p.cavitation_pressure:g} Pa"
        for edge, pressure in (("lower", p.pressure_lower_edge), ("upper", p.pressure_upper_edge))
        if pressure < p.cavitation_pressure
    ]
    if p.oil.viscosity_law == "two_point" and p.oil.viscosity_40 <= p.oil.viscosity_100:
        found.append(
            f"viscosity_40 = {p.oil.viscosity_40:g} Pa.s: must be above viscosity_100 = {p.oil.viscosity_100:g} Pa.s"
        )
    if p.flow_factors != "none" and p.roughness_rms <= 0.0:
        found.append(f"flow_factors = {p.flow_factors}: needs roughness_rms > 0 m")
    return found
