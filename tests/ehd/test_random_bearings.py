"""Random bearings under load: each one with an oil supply is balanced, each other one rejected."""

from typing import Any, NamedTuple

import numpy as np
import pytest

import piston_cosim as pc
from piston_cosim.fmu_ehd.journal import film_force

from .test_steady import oval_shell


class Bearing(NamedTuple):
    """Film, load on its journal [N], clearance [m], elastic shells, and inputs of a call.

    fed : whether the film has an oil supply.
    """

    film: pc.Film
    load: np.ndarray
    clearance: float
    shells: list[Any]
    inputs: dict[str, float]
    fed: bool


def uniform(rng, low, high):
    """Return a number whose logarithm is uniform."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def drawn(seed):
    """Return a random bearing."""
    rng = np.random.default_rng(seed)
    grid = int(rng.integers(24, 80)), int(rng.integers(3, 14))
    radius = uniform(rng, 8e-3, 0.1)
    length = 2 * radius * uniform(rng, 0.2, 1.5)
    clearance = radius * uniform(rng, 5e-4, 2e-3)
    speed = uniform(rng, 0.05, 20.0)
    viscosity = uniform(rng, 3e-3, 0.2)
    rough = rng.random() < 0.4
    parameters: dict[str, Any] = dict(viscosity=viscosity)
    if rough:
        parameters |= dict(roughness_rms=clearance * uniform(rng, 3e-3, 3e-2))
        if rng.random() < 0.4:
            parameters["flow_factors"] = "patir_cheng_1978"
    coated = rng.random() < 0.25
    if coated:
        thickness, modulus = uniform(rng, 5e-6, 3e-5), uniform(rng, 5e8, 1e10)
        parameters |= dict(coating_thickness=thickness, coating_modulus=modulus)
    law = rng.choice(["none", "barus_1893", "roelands_1966"])
    alpha = 1e-8
    if law != "none":
        alpha = uniform(rng, 5e-9, 3e-8)
        parameters |= dict(pressure_viscosity_law=law, pressure_viscosity_coefficient=alpha)
    # the load as eccentricity of a short bearing, Eq. (V6)
    e = rng.uniform(0.05, 0.98 if rough else 0.93)
    square = 1 - e**2
    ratio = length / radius / 2
    load = viscosity * speed * length * (radius / clearance) ** 2 * ratio**2 / (1 + ratio**2)
    load *= e / square**2 * np.sqrt(16 * e**2 + np.pi**2 * square)
    load = min(load, 0.15 / alpha * length * 2 * radius)  # in the range of the pressure law
    direction = rng.uniform(0, 2 * np.pi)
    shells = []
    if rng.random() < 0.3:
        # a share of the clearance for the load on a mode
        shells = [oval_shell(grid, load / (4.0 * clearance * uniform(rng, 0.01, 1.0)))]
    supply = rng.choice(["edges", "edge", "groove", "hole", "ambient", "none"])
    inputs = dict(circumferential_velocity=speed * rng.choice([-1.0, 1.0]))
    cells = None
    high = uniform(rng, 1e4, 1e6)
    if supply in ("edges", "edge"):
        inputs["pressure_lower_edge"] = high
        if supply == "edges":
            inputs["pressure_upper_edge"] = high
    if supply in ("groove", "hole"):
        cells = np.zeros(grid, dtype=bool)
        # within 60 degrees of the side opposite to the load
        opposite = direction + np.pi + rng.uniform(-np.pi / 3, np.pi / 3)
        first = int(opposite / (2 * np.pi) * grid[0])
        rows = (first + np.arange(rng.integers(1, 4))) % grid[0]
        if supply == "groove":
            cells[rows] = True
        else:
            cells[rows, grid[1] // 2] = True
        parameters |= dict(opening_supply="own")
        inputs["pressure_openings"] = high * rng.integers(2)
    if supply == "ambient":
        parameters["cavitation_pressure"] = -float(rng.uniform(2e4, 1e5))
    film = pc.Film(
        grid,
        surface="bearing",
        bore_radius=radius,
        skirt_length=length,
        open_cells=cells,
        **parameters,
    )
    force = load * np.array([np.cos(direction), np.sin(direction)])
    return Bearing(film, force, clearance, shells, inputs, supply != "none")


def outcome(bearing):
    """Return the force out of balance over the load, or the sentence of a rejection."""
    film, load, clearance, shells, inputs, _ = bearing
    try:
        outputs = film.equilibrium(load, clearance, shells=shells, **inputs)
    except (pc.BadInput, pc.Discard) as trouble:
        return str(trouble)
    forces = outputs["nodal_pressure_force"], outputs["nodal_circumferential_force"]
    return np.hypot(*(film_force(*forces) + load)) / np.hypot(*load)


def check(seeds):
    """Every bearing with a supply is balanced to the tolerance, every other one is rejected."""
    for seed in seeds:
        bearing = drawn(seed)
        found = outcome(bearing)
        if bearing.fed:
            assert isinstance(found, float) and found <= 1e-9, f"{seed}: {found}"
        else:
            assert "oil supply: expected" in str(found), f"{seed}: {found}"


def test_random_bearings_are_balanced_or_have_no_supply():
    """The first position from which the search starts fails in 5, and 4 has no supply."""
    check(range(10))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:pressure_viscosity_law")
def test_sixty_random_bearings_are_balanced_or_have_no_supply():
    check(range(10, 70))
