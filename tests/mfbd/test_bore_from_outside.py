"""A bore whose deflection is an input.

Reading and its transpose are compared with the bore's own modes. Other tests cover the
sensitivity of a step and rejected inputs.
"""

import dataclasses

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.build import declared_variables
from piston_cosim.fmu_mfbd.dynamics.assembly import assemble
from piston_cosim.fmu_mfbd.dynamics.bore_from_outside import (
    film_on_bore,
    gas_on_wall,
    opening_changes,
    periodic_rule,
)
from piston_cosim.fmu_mfbd.dynamics.build_options import BoreGrid
from piston_cosim.fmu_mfbd.dynamics.gas_on_bore import WallPressures, wall_forces
from piston_cosim.fmu_mfbd.dynamics.model import MOTION, ON_BLOCK, ON_FLEXIBLE_BLOCK, Inputs
from piston_cosim.fmu_mfbd.dynamics.parameters import Parameters
from piston_cosim.fmu_mfbd.dynamics.skirt_films import forces_by_film, total_forces
from piston_cosim.fmu_mfbd.dynamics.system import RingForce
from piston_cosim.fmu_mfbd.geometry.film import NodalForces
from piston_cosim.fmu_mfbd.geometry.grid import cell_centres
from piston_cosim.fmu_mfbd.mechanism.carrier import BlockMotion
from piston_cosim.fmu_mfbd.reduction.reduced_body import no_modes
from piston_cosim.master.fmi.errors import BadInput

from .conftest import sheets
from .differences import products_by_differences
from .test_model import SPEED, STEP, forces

SKEW = {"crank_offset": 1e-3, "top_ring_height": 19e-3, "second_ring_height": 14e-3}
MOVING = BlockMotion(3.0, -5.0, 40.0, 1.7)


def outside_of(reduced, around=16, axial=24, **values):
    """Return the small piston in a block whose deflection is an input."""
    options, piston, block = reduced
    heights = np.linspace(block.heights[0], block.heights[-1], axial)
    none = no_modes(len(block.radial), axial)
    still = dataclasses.replace(block, heights=heights, **none)
    said = dataclasses.replace(options.block, modes=0, bore_from_outside=BoreGrid(around, axial))
    options = dataclasses.replace(options, block=said, mounted=True)
    return assemble(piston, still, options, Parameters(**SKEW | values))


def own_of(reduced, **values):
    """Return the small piston in its own flexible block, whose modes move only outwards."""
    options, piston, block = reduced
    block = dataclasses.replace(block, axial=0.0 * block.axial)
    return assemble(piston, block, options, Parameters(**SKEW | values)), block


@pytest.mark.parametrize("given", [12, 24, 40])
def test_periodic_rule_by_order(given):
    """Row sums are 1, the grid's own values are exact, and cos 3 theta is read to fourth order.

    The error of a cubic spline is at most 5/384 (k cell)^4 [Hall and Meyer 1976].
    """
    rule = periodic_rule(given, 33)
    np.testing.assert_allclose(rule.sum(axis=1), 1.0, atol=1e-13)
    np.testing.assert_allclose(periodic_rule(given, given), np.eye(given), atol=1e-13)
    at, _ = cell_centres(given, 1, 0.0, 1.0)
    to, _ = cell_centres(33, 1, 0.0, 1.0)
    error = np.abs(rule @ np.cos(3 * at + 0.4) - np.cos(3 * to + 0.4)).max()
    assert error < 5 / 384 * (3 * 2 * np.pi / given) ** 4


@pytest.mark.parametrize("shape", [(16, 24), (10, 15)])
def test_forces_on_the_bore_are_the_transpose_of_its_reading(reduced, shape):
    """Virtual work on both grids, of any field and any forces; round-off of sums of 192 terms."""
    model = outside_of(reduced, *shape)
    rng = np.random.default_rng(4)
    for guided in (0.0803, 0.1, 0.1137):
        field, force = rng.standard_normal(shape), rng.standard_normal(16 * 12)
        there, _ = opening_changes(model.outside, model.film_surfaces, guided, field)
        here = film_on_bore(model.outside, model.film_surfaces, guided, force)
        size = np.abs(there * force).sum()
        assert np.sum(here * field) == pytest.approx(there @ force, abs=1e-14 * size)
        # a translation of the bore is seen as one, and force balances
        theta, _ = cell_centres(shape[0], 1, 0.0, 1.0)
        assert here.sum() == pytest.approx(force.sum(), abs=1e-12 * np.abs(force).sum())
        even, _ = opening_changes(model.outside, model.film_surfaces, guided, np.ones(shape))
        np.testing.assert_allclose(even, 1.0, atol=1e-12)


def test_gas_on_the_wall_by_hand(reduced):
    """Gas force is pressure times 2 pi R times the height above each ring, even around.

    Its moment is about the bore's foot.
    """
    model = outside_of(reduced)
    _, _, block = reduced
    guided, p, land = 0.1, 4e6, 0.5e6
    found = gas_on_wall(model.outside, guided, WallPressures(p, land))
    assert np.ptp(found, axis=0).max() == 0.0
    top = block.heights[-1]
    first, second = guided + 19e-3, guided + 14e-3
    around = 2 * np.pi * block.radius
    force = around * (p * (top - first) + land * (first - second))
    moment = around * (p * (top**2 - first**2) + land * (first**2 - second**2)) / 2
    # unit values of single heights are no quadratics: cubics between the table's own heights
    assert found.sum() == pytest.approx(force, rel=1e-9)
    assert (found @ block.heights).sum() == pytest.approx(moment, rel=1e-5)


def test_a_field_from_outside_is_the_bores_own_deflection(reduced):
    """The field of the bore's own modes as an input gives the same film, piston and modal forces.

    It is updated step after step. The tolerance of 6e-8 of a deflection is the single
    precision of the modes' tables.
    """
    own, block = own_of(reduced)
    other = outside_of(reduced)
    first = np.zeros(block.radial.shape[:2])
    push, drag = forces(own, 0)
    begun, _ = own.start(0.3, 2e-6, 1e-4, Inputs(SPEED, 5e5, 0 * push, 0 * drag))
    state, _ = other.start(
        0.3, 2e-6, 1e-4, Inputs(SPEED, 5e5, 0 * push, 0 * drag, bore_deflection=first)
    )
    k = len(own.system.gas_force)
    for n in range(6):
        push, drag = forces(own, n)
        begun, out = own.advance(begun, Inputs(SPEED, 5e5, push, drag), STEP)
        field = block.radial @ begun.position[2 + k :]
        before = state
        inputs = Inputs(SPEED, 5e5, push, drag, bore_deflection=field)
        state, told = other.advance(before, inputs, STEP)
        bend = np.abs(field).max()
        assert bend > 1e-8
        np.testing.assert_allclose(
            told["film_thickness"], out["film_thickness"], rtol=0, atol=1e-6 * bend
        )
        np.testing.assert_allclose(state.position[: 2 + k], begun.position[: 2 + k], rtol=1e-12)
        guided = own._last.guide_height
        parts = forces_by_film(own.system, guided, NodalForces(push.ravel(), drag.ravel()))
        of_film = total_forces(parts).push[2 + len(own.system.gas_force) :]
        of_gas = wall_forces(own.system.wall, guided, WallPressures(5e5, 0.0))
        by_grid = np.einsum("csk,cs->k", block.radial, told["force_on_bore"])
        wanted = of_film + of_gas
        np.testing.assert_allclose(by_grid, wanted, rtol=0, atol=1e-6 * np.abs(wanted).max())
        assert told["force_on_deck"] == pytest.approx(5e5 * np.pi * block.radius**2, rel=1e-14)
        # what the bore takes of the film's work, by the film's own cells
        way, _ = opening_changes(
            other.outside, other.film_surfaces, guided, field - before.bore_deflection
        )
        rest = STEP * told["received_power"] - way @ push.ravel()
        plain = other.advance(before._replace(bore_deflection=field), inputs, STEP)[1]
        assert rest == pytest.approx(STEP * plain["received_power"], rel=1e-9)
        assert told["interface_work_error"] < 1e-13


def test_derivatives_with_a_bore_from_outside_are_differences(reduced):
    """Every output by every input at once agrees with differences.

    The tangent leaves out 2 w c1 = 1e-4 here, see test_mounted. Fields of the bore itself are
    linear and exact.
    """
    model = outside_of(reduced, 10, 15)
    rng = np.random.default_rng(8)
    push, drag = forces(model, 3)
    field = 1e-6 * rng.standard_normal((10, 15))
    state, _ = model.start(
        0.3, 2e-6, 1e-4, Inputs(SPEED, 0.0, 0 * push, 0 * drag, bore_deflection=field)
    )
    for n in range(3):
        now = Inputs(SPEED, 5e5, *forces(model, n), carrier=MOVING, bore_deflection=field)
        state, _ = model.advance(state, now, STEP)

    base = Inputs(SPEED, 5e5, push, drag, carrier=MOVING, bore_deflection=field)
    bent = dataclasses.replace(
        Inputs(0.0, 0.0, 0 * push, 0 * drag),
        bore_deflection=1e-7 * rng.standard_normal((10, 15)),
    )
    everything = dataclasses.replace(
        bent,
        pressure_force=rng.random(push.shape),
        friction_force=0.1 * rng.random(push.shape),
        rings=RingForce(3.0, -7.0, 0.2),
        carrier=BlockMotion(*rng.random(4)),
    )
    for change, within in ((bent, 1e-9), (everything, 3e-4)):
        products = products_by_differences(model, state, base, change, STEP, within)
        names = (*MOTION, *ON_BLOCK, *ON_FLEXIBLE_BLOCK, "film_thickness", "sliding_velocity")
        assert set(names) == products.keys()


RIGID = sheets(block={"bore_from_outside": {"around": 12, "axial": 20}}, mounted=True)


def changed(**block):
    return RIGID | {"block": RIGID["block"] | block}


@pytest.mark.parametrize(
    ("build", "told"),
    [
        (RIGID | {"mounted": False}, "mounted: expected true with"),
        (changed(stations=30), "stations: expected nothing with"),
        (
            changed(bore_from_outside={"around": 12, "axial": 4}),
            "axial: expected a value of at least 8, got 4",
        ),
        (
            changed(
                rigid=None, mesh="block.msh", density="7000 kg/m^3", young="1e11 Pa", poisson=0.3
            ),
            "rigid: expected a table with",
        ),
    ],
)
def test_what_does_not_go_with_a_bore_from_outside_is_refused(build, told, tmp_path):
    with pytest.raises(BadInput, match=told):
        declared_variables(build, tmp_path)
