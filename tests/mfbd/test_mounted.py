"""A cylinder in a block that moves.

Derivatives of a step are differences. Its inertia forces are those of `test_virtual_work`.
"""

import dataclasses

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.dynamics.assembly import assemble
from piston_cosim.fmu_mfbd.dynamics.model import MOTION, ON_BLOCK, Inputs
from piston_cosim.fmu_mfbd.dynamics.parameters import Parameters
from piston_cosim.fmu_mfbd.dynamics.system import RingForce
from piston_cosim.fmu_mfbd.mechanism.carrier import BlockMotion

from .differences import products_by_differences
from .test_model import SPEED, STEP, forces

UNBALANCE = -0.012
"""Of the crank [kg m]."""

MOVING = BlockMotion(3.0, -5.0, 40.0, 1.7)
"""A block that shakes harder than any on mounts."""


def skewed(reduced, mounted, **values):
    """Return the small flexible bodies with a skewed mechanism, an unbalance and static modes."""
    options, piston, block = reduced
    parameters = Parameters(
        crank_offset=1e-3, crank_unbalance=UNBALANCE, quasi_static_frequency=22e3, **values
    )
    return assemble(piston, block, dataclasses.replace(options, mounted=mounted), parameters)


@pytest.fixture
def mounted(reduced):
    """In a block that moves."""
    return skewed(reduced, True)


def taken(model, steps=4):
    """State and outputs after some steps, and those of another with changed last inputs."""
    nothing = 0.0 * forces(model)[0]
    state, out = model.start(0.3, 2e-6, 1e-4, Inputs(SPEED, 0.0, nothing, nothing, carrier=MOVING))
    for k in range(steps):
        before = state
        state, out = model.advance(
            before, Inputs(SPEED, 5e5, *forces(model, k), carrier=MOVING), STEP
        )
    return before, out


def test_gas_below_the_piston_pushes_back(reduced):
    """The net gas force is that of the pressure difference, to the bit.

    The side force of a change is its force times the slope of the rod.
    """
    model = skewed(reduced, False)
    outputs = []
    for above, below in ((5e5, 1e5), (4e5, 0.0), (5e5, 0.0)):
        inputs = Inputs(SPEED, above, *forces(model), crankcase_pressure=below)
        outputs.append(model.start(0.3, 2e-6, 1e-4, inputs)[1])
    both, difference, alone = outputs
    for name, value in difference.items():
        if name != "cylinder_pressure" and not name.endswith("_evaluations"):
            np.testing.assert_array_equal(both[name], value)
    m = model.system.mechanism
    aside = m.offset + m.crank_radius * np.sin(0.3)
    slope = aside / np.sqrt(m.rod_length**2 - aside**2)
    added = abs(alone["side_force_demand"] - both["side_force_demand"])
    assert added == pytest.approx(1e5 * model.model.gas_area * slope, rel=1e-9)


def test_derivatives_with_the_motion_of_the_block_are_differences(mounted):
    """Central differences of the last step, with the round-off of a moment that hardly changes."""
    before, _ = taken(mounted)
    push, drag = forces(mounted, 3)
    base = Inputs(SPEED, 5e5, push, drag, carrier=MOVING)
    still = Inputs(0.0, 0.0, 0.0 * push, 0.0 * drag)
    directions = [
        dataclasses.replace(still, carrier=BlockMotion(*(1e-3 * one))) for one in np.eye(4)
    ]
    rng = np.random.default_rng(8)
    everything = dataclasses.replace(
        still,
        pressure_force=rng.random(push.shape),
        friction_force=0.1 * rng.random(push.shape),
        rings=RingForce(3.0, -7.0, 0.2),
        carrier=BlockMotion(*rng.random(4)),
    )
    for change, size in [(one, 1e3) for one in directions] + [(everything, 1e-1)]:
        products = products_by_differences(mounted, before, base, change, STEP, 1e-5, size)
        assert {*ON_BLOCK, *MOTION, "film_thickness", "sliding_velocity"} == products.keys()


def test_derivatives_of_the_moment_contain_slopes_of_the_bore(reduced):
    """An even pressure turns the block by the slopes of a steep, soft bore alone.

    The bore widens by 5 mm over its height, its modes are a hundred times as soft, and the film
    carries 98 kN. The slopes that follow the pressure then are 1.3 % of the change of the moment.
    """
    options, piston, block = reduced
    soft = options, piston, dataclasses.replace(block, omega=0.1 * block.omega)
    model = skewed(soft, True, bore_growth_upper=5e-3)
    before, _ = taken(model)
    push, drag = forces(model, 3)
    base = Inputs(SPEED, 5e5, 1e3 * push, drag, carrier=MOVING)
    change = Inputs(0.0, 0.0, np.ones(push.shape), 0.0 * drag)
    products_by_differences(model, before, base, change, STEP, 1e-5)
