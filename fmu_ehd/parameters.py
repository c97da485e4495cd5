"""Parameters of a film, which are constant during a run."""

from collections import namedtuple
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..master.fmi.noted import none_yet, sentences_of
from ..master.fmi.symmetry import FILM_SYMMETRIES, odd_part
from .common.declaration import choice, declared, variables_of
from .common.faults import FAULTS
from .common.grid import Flags
from .contradictions import (
    FULL_TURN,
    OIL_SUPPLIES,
    OPENING_SUPPLIES,
    check_parameters,
    check_supply,
)
from .laws.asperity import CONTACT_LAWS
from .laws.cavitation import CAVITATION
from .laws.friction import CAVITY_SHEAR
from .laws.oil import Oil
from .laws.roughness import FLOW_FACTORS

SURFACES = ("skirt", "bearing")


@dataclass(frozen=True)
class Parameters:
    """Parameters of a film, constant during a run.

    Each number is declared here, once: unit, default, range and meaning.

    Pressures are gauge pressures with one reference. Edges are not below cavitation pressure, see
    `contradictions`.

    Parameters
    ----------
    shape : tuple of int
        (n_circumferential, n_axial).
    oil : oil.Oil
    open_cells : ndarray of bool, shape (n_c, n_a), optional
        Cut-outs.
    surface : str
        skirt: slides along the axis, and the grid rides on it; bearing: a journal that slides
        around and along in its shell (skirt and bore of the names below), on which the grid rests.
    """

    shape: tuple[int, int] = (40, 40)
    oil: Oil = field(default_factory=Oil)

    # laws
    cavitation_model: str = choice(CAVITATION)
    """Cavitation model."""
    cavity_shear: str = choice(CAVITY_SHEAR, advanced=True)
    """Part of the cavitated film that transmits shear."""
    flow_factors: str = choice(FLOW_FACTORS)
    """Flow factor model for rough surfaces."""
    contact_law: str = choice(CONTACT_LAWS, advanced=True)
    """Asperity contact law."""

    film_symmetry: str = choice(FILM_SYMMETRIES)
    """Part of the film that is computed: thrust_plane for one half, automatic for one half if the
    inputs at the start are symmetric.
    """

    # skirt and film
    bore_radius: float = declared("m", 28.25e-3, 1e-3, 1.0)
    """Radius of the cylinder bore."""
    skirt_length: float = declared("m", 27e-3, 1e-3, 2.0)
    """Axial length of the lubricated skirt."""
    cavitation_pressure: float = declared("Pa", 0.0, -2e5, 1e8)
    """Cavitation pressure, gauge."""
    cavitation_rounding: float = declared("Pa", 0.0, 0.0, 1e4, advanced=True)
    """Absolute pressure of the gas in cavities, which makes the film a smooth function of its
    inputs; 0: none.
    """
    minimum_flow_film: float = declared("m", 5e-8, 1e-9, 1e-5, advanced=True)
    """Lower limit of the film thickness in the flow equations."""

    # roughness and contact: gamma and Y of `roughness`; z_s, eta beta_a sigma, sigma/beta_a, E*,
    # mu_b, tau_0 of `asperity`
    roughness_rms: float = declared("m", 0.0, 0.0, 1e-4)
    """Composite rms roughness of skirt and bore; 0: smooth, without contact."""
    summit_height: float = declared("m", 0.0, 0.0, 1e-4)
    """Height of the mean plane of the summits above that of the surface, sum of both bodies."""
    peklenik_number_skirt: float = declared("1", 1.0, 1.0 / 9.0, 9.0)
    """Correlation length of the skirt's roughness along / across the axis."""
    peklenik_number_bore: float = declared("1", 1.0, 1.0 / 9.0, 9.0)
    """Correlation length of the bore's roughness along / across the axis."""
    roughness_share_skirt: float = declared("1", 0.8, 0.0, 1.0)
    """Fraction of the roughness variance that the skirt has."""
    asperity_product: float = declared("1", 0.04, 1e-4, 1.0)
    """Asperity density x tip radius x rms height (eta beta_a sigma)."""
    asperity_slope: float = declared("1", 1e-3, 1e-6, 1.0)
    """Ratio of rms height to tip radius of the asperities (sigma/beta_a)."""
    contact_modulus: float = declared("Pa", 6e10, 1e6, 1e12)
    """Contact modulus E*, with 1/E* = sum of (1-nu^2)/E of both bodies."""
    boundary_friction_coefficient: float = declared("1", 0.12, 0.0, 2.0)
    """Friction coefficient of asperity contact."""
    boundary_shear_strength: float = declared("Pa", 0.0, 0.0, 1e9, advanced=True)
    """Shear strength of the boundary layer in contact."""
    friction_rounding_velocity: float = declared("m/s", 1e-3, 1e-9, 1.0, advanced=True)
    """Sliding velocity below which asperity friction decreases to zero."""

    # soft layer: d, E, nu of `coating`
    coating_thickness: float = declared("m", 0.0, 0.0, 1e-3)
    """Thickness of a soft coating; 0: no coating."""
    coating_modulus: float = declared("Pa", 1e9, 1e6, 1e12)
    """Young's modulus of the coating."""
    coating_poisson: float = declared("1", 0.3, 0.0, 0.45)
    """Poisson's ratio of the coating."""

    # oil outside the film, `oil_layer`
    oil_supply: str = choice(OIL_SUPPLIES)
    """Source of the oil at the edges."""
    initial_film_fraction: float = declared("1", 1.0, 0.0, 1.0)
    """Film fraction at the start; below 1, the film has no pressure at the start."""
    initial_oil_layer: float = declared("m", 1e-5, 0.0, 1e-2)
    """Oil layer on the bore outside the skirt at the start."""
    stroke: float = declared("m", 0.1, 1e-3, 4.0)
    """Maximum travel of the skirt along the bore from its start position."""
    chamfer_capacity: float = declared("m2", 1e-7, 0.0, 1.0, advanced=True)
    """Maximum cross-section of the oil that an edge of the skirt pushes along."""
    largest_oil_layer: float = declared("m", 3e-4, 1e-6, 1e-1)
    """Maximum oil layer on the bore; splash above it runs off."""
    oil_ring_layer: float = declared("m", 2e-6, 0.0, 1e-3, condition=True)
    """Oil layer that the oil ring leaves on the bore above the skirt."""
    oil_splash: float = declared("m/s", 0.0, 0.0, 10.0, condition=True)
    """Growth rate of the oil layer below the skirt due to splash."""

    # what holds at the edges and in openings, and may change from step to step
    opening_supply: str = choice(OPENING_SUPPLIES)
    """Source of pressure and oil in openings: the lower edge or a separate supply."""
    pressure_lower_edge: float = declared("Pa", 0.0, -2e5, 1e8, condition=True)
    """Pressure at the lower edge, gauge."""
    pressure_upper_edge: float = declared("Pa", 0.0, -2e5, 1e8, condition=True)
    """Pressure at the upper edge, gauge."""
    film_fraction_lower_edge: float = declared("1", 1.0, 0.0, 1.0, condition=True)
    """Film fraction of the oil that enters at the lower edge; below 1 only at cavitation pressure.
    """
    film_fraction_upper_edge: float = declared("1", 1.0, 0.0, 1.0, condition=True)
    """Film fraction of the oil that enters at the upper edge; below 1 only at cavitation pressure.
    """
    pressure_openings: float = declared("Pa", 0.0, -2e5, 1e8, condition=True)
    """Pressure in openings with a separate supply, gauge."""
    film_fraction_openings: float = declared("1", 1.0, 0.0, 1.0, condition=True, advanced=True)
    """Film fraction of the oil that enters from openings with a separate supply; below 1 only at
    cavitation pressure.
    """
    oil_temperature_lower_edge: float = declared("K", 373.15, 233.15, 573.15, condition=True)
    """Oil temperature at the lower edge; it varies linearly to the upper edge."""
    oil_temperature_upper_edge: float = declared("K", 373.15, 233.15, 573.15, condition=True)
    """Oil temperature at the upper edge."""

    # a bearing alone
    sector_angle: float = declared("rad", FULL_TURN, 0.1, FULL_TURN)
    """Wrap angle of the shell; below 360 deg, both ends are openings."""

    open_cells: Flags | None = None
    surface: str = SURFACES[0]


TUNABLE = (
    *(v.name for v in variables_of(Parameters, condition=True)),
    "viscosity",
    "vogel_viscosity",
    "vogel_b",
    "vogel_c",
    "pressure_viscosity_coefficient",
)
"""Parameters that may change between steps."""

OF_SKIRTS = ("film_symmetry",)
OF_BEARINGS = ("sector_angle", "nodal_circumferential_force", "friction_torque")


def is_of(surface: str, name: str) -> bool:
    """Return whether a film on one of `SURFACES` has a parameter or output of a name."""
    if surface == "bearing":
        return name not in OF_SKIRTS and not name.endswith("_thrust_side")
    return name not in OF_BEARINGS


def has_image(shape: tuple[int, int], open_cells: Flags | None, surface: str) -> bool:
    """Return whether the cells of a skirt are their own mirror image, with two ends on the plane.

    Parameters are those of `Parameters`.
    """
    is_even = surface == "skirt" and shape[0] % 2 == 0
    return is_even and (open_cells is None or not odd_part(1.0 * np.asarray(open_cells)).any())


DECLARED = (
    *variables_of(Parameters),
    *variables_of(Parameters, condition=True),
    *variables_of(Oil),
)
NUMBERS = tuple(v.name for v in DECLARED if not v.choices)
CHOICES = {v.name: v.choices for v in DECLARED if v.choices}
"""Allowed values of the parameters that select a law."""
CHOSEN = tuple(CHOICES)
Numbers = namedtuple("Numbers", NUMBERS)
"""Numbers of film and oil [SI], as kernels read them."""
Chosen = namedtuple("Chosen", CHOSEN)
"""Choices of film and oil by their number in `CHOICES`, from 1 on."""


def parameters_of(values: Mapping[str, Any], **built: Any) -> Parameters:
    """Return the parameters of a film from values of film and oil [SI] by their names.

    Other names are ignored. `built` are the members of `Parameters` that are not declared.
    """
    of_oil = {v.name for v in variables_of(Oil)}
    others = {v.name: values[v.name] for v in DECLARED if v.name in values}
    oil = Oil(**{name: others.pop(name) for name in of_oil & others.keys()})
    return Parameters(oil=oil, **built, **others)


def numbers_of(parameters: Parameters) -> Numbers:
    """Return the numbers of a film and its oil."""
    values = vars(parameters.oil) | vars(parameters)
    return Numbers(*(values[name] for name in NUMBERS))


def chosen_of(parameters: Parameters) -> Chosen:
    """Return the choices of a film and its oil."""
    values = vars(parameters.oil) | vars(parameters)
    return Chosen(*(1 + CHOICES[name].index(values[name]) for name in CHOSEN))


def faults(parameters: Parameters) -> list[str]:
    """Return the contradictions between parameters that are each in range.

    Parameters
    ----------
    parameters : Parameters

    Returns
    -------
    list of str
        One sentence a fault.
    """
    x, chosen = numbers_of(parameters), chosen_of(parameters)
    cells = parameters.open_cells
    noted = none_yet()
    check_supply(x, chosen, noted)
    cut_outs = cells is not None and bool(cells.any())
    surface = parameters.surface
    mirrors = has_image(parameters.shape, cells, surface)
    check_parameters(x, chosen, surface == "bearing", cut_outs, mirrors, noted)
    return sentences_of(noted, FAULTS)
