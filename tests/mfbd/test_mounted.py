"""A cylinder in a block that moves.

Inertia forces are compared with Lagrange's equations in space. Other tests cover forces on the
block and the sensitivity of a step. A block at rest changes nothing.
"""

import dataclasses
from functools import partial

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.dynamics.assembly import assemble
from piston_cosim.fmu_mfbd.dynamics.block_force import BlockForce, block_force
from piston_cosim.fmu_mfbd.dynamics.model import MOTION, ON_BLOCK, Inputs
from piston_cosim.fmu_mfbd.dynamics.parameters import Parameters
from piston_cosim.fmu_mfbd.dynamics.pin_films import forces_of
from piston_cosim.fmu_mfbd.dynamics.system import RingForce
from piston_cosim.fmu_mfbd.mechanism.carrier import FIXED, Carrier
from piston_cosim.fmu_mfbd.mechanism.cylinder import BODY
from piston_cosim.fmu_mfbd.mechanism.generalised_alpha import Prediction
from piston_cosim.fmu_mfbd.mechanism.piston_motion import Load
from piston_cosim.fmu_mfbd.mechanism.slider_crank import CrankMotion
from piston_cosim.fmu_mfbd.mechanism.solution import solve_motion
from piston_cosim.tests.verification.cases.bodies import rigid_body
from piston_cosim.tests.verification.cases.tied import tied_forces, tied_pin

from .differences import lagrange, products_by_differences
from .test_floating_frame import SKEW, reach
from .test_model import SPEED, STEP, forces

UNBALANCE = -0.012
"""Of the crank [kg m], as a mass of 0.4 kg on the far side of its pin."""

WEIGHT = 0.4
"""Mass of the unbalance [kg]."""

MOVING = Carrier(3.0, -5.0, 40.0, 1.7)
"""A block that shakes harder than any on mounts."""


def energy_in_space(body, unbalance, position, velocity):
    """Return the kinetic energy of rod, pin, rigid piston and the crank's unbalance.

    It depends on [x_A, rocking angle, crank angle, x and y of the crank axis, angle of the block].
    Only positions are used: velocities follow from complex steps in extended precision.
    """
    step = np.longdouble(1e-30)
    t = np.clongdouble(1j) * step
    x, tilt, turn, across, up, roll = position + t * velocity

    def v(q):
        return np.imag(q) / step

    def in_space(point):
        c, s = np.cos(roll), np.sin(roll)
        return np.array([across + c * point[0] - s * point[1], up + s * point[0] + c * point[1]])

    e = np.array([-np.sin(turn), np.cos(turn)])
    P = SKEW.crank_radius * e
    A = np.array([SKEW.offset + x, 0])
    A = np.array([A[0], P[1] + np.sqrt(SKEW.rod_length**2 - (A[0] - P[0]) ** 2)])
    centre = body.S / body.mass
    c, s = np.cos(tilt), np.sin(tilt)
    C = A + np.array([c * centre[0] - s * centre[1], s * centre[0] + c * centre[1]])
    G = P + SKEW.rod_centre * (A - P)
    rod = roll - np.arcsin((A[0] - P[0]) / SKEW.rod_length)
    inertia = body.I0 - body.S @ body.S / body.mass
    # the unbalance as a mass m at e U/m less one of m on the axis, which counts among the block's
    ends = v(in_space(unbalance / WEIGHT * e)), v(in_space(0 * e))
    points = ((body.mass, C), (SKEW.pin_mass, A), (SKEW.rod_mass, G))
    return 0.5 * (
        sum(mass * v(in_space(point)) @ v(in_space(point)) for mass, point in points)
        + inertia * v(tilt + roll) ** 2
        + SKEW.rod_inertia * v(rod) ** 2
        + WEIGHT * (ends[0] @ ends[0] - ends[1] @ ends[1])
    )


@pytest.mark.parametrize("degrees", [0, 30, 60, 90, 200, 333])
def test_forces_in_a_moving_block_are_lagranges(degrees):
    """Residual, torque and loads on the block are those of Lagrange's equations.

    The case includes offsets, rod inertia and unbalance at once.
    """
    body = rigid_body(0.315, (0.002, 0.009), 3e-4)
    z, r, phi, w, dw = (
        np.array([3e-4, 0.02]),
        np.array([0.4, 11.0]),
        np.radians(degrees),
        314.0,
        5e3,
    )
    crank = CrankMotion(phi, w, dw)
    load = Load(700.0, -2000.0, 5.0, 1800.0, np.zeros(0))
    still = Prediction(z, r, np.zeros(2))
    chain, instantly = tied_pin(body, SKEW, UNBALANCE), reach(2, 0.0, 0.0)
    now = solve_motion(
        chain, forces_of(chain, load), still, np.zeros(2), instantly, crank, MOVING
    ).now
    a = now.acceleration
    place = np.array([*z, phi, 0.0, 0.0, 0.0])
    velocity = np.array([*r, w, 0.0, 0.0, MOVING.w])
    acceleration = np.array([*a, dw, MOVING.ax, MOVING.ay, MOVING.alpha])
    scale = np.array([1e-4, 1e-3, 1e-3, 1e-4, 1e-4, 1e-3], dtype=np.longdouble)

    energy = partial(energy_in_space, body, UNBALANCE)
    needed = lagrange(energy, place, velocity, acceleration, scale)
    # what turns the crank itself is the drive's, and the chain leaves it to its caller
    needed[[2, 5]] -= UNBALANCE**2 / WEIGHT * (dw + MOVING.alpha)
    loaded = tied_forces(chain, load, now, crank, MOVING)
    free = load._replace(lateral=0.0, axial=0.0, moment=0.0, axis_force=0.0)
    bare = tied_forces(chain, free, now, crank, MOVING)
    size = np.abs(needed).max()  # differences of fourth order: 1e-9 of the largest
    np.testing.assert_allclose([*bare.residual, bare.torque], needed[:3], atol=1e-9 * size)
    assert np.abs(loaded.residual).max() < 1e-9 * size
    # turning all about the crank axis: the block, and the drive, which stands outside it
    on_block = [0.0, 0.0, loaded.torque] - needed[3:]
    np.testing.assert_allclose(loaded.on_block, on_block, atol=1e-9 * size)
    # the main bearings carry the crank
    *_, x, y = block_force(load, np.zeros(2), loaded.on_block)
    np.testing.assert_allclose([x, y], -loaded.joint_wrench[BODY.crank, :2], atol=1e-9 * size)


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


def taken(model, carrier, steps=4):
    """State and outputs after some steps, and those of another with changed last inputs."""
    nothing = 0.0 * forces(model)[0]
    state, out = model.start(0.3, 2e-6, 1e-4, Inputs(SPEED, 0.0, nothing, nothing, carrier=carrier))
    for k in range(steps):
        before = state
        state, out = model.advance(
            before, Inputs(SPEED, 5e5, *forces(model, k), carrier=carrier), STEP
        )
    return before, out


def test_a_block_at_rest_changes_nothing(reduced, mounted):
    """Nor do the forces on a block that cannot move."""
    _, plain = taken(skewed(reduced, False), FIXED)
    _, out = taken(mounted, FIXED)
    assert plain.keys() == out.keys() >= set(BlockForce._fields)
    for name, value in plain.items():
        np.testing.assert_array_equal(out[name], value)


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
    before, _ = taken(mounted, MOVING)
    push, drag = forces(mounted, 3)
    base = Inputs(SPEED, 5e5, push, drag, carrier=MOVING)
    still = Inputs(0.0, 0.0, 0.0 * push, 0.0 * drag)
    directions = [dataclasses.replace(still, carrier=Carrier(*(1e-3 * one))) for one in np.eye(4)]
    rng = np.random.default_rng(8)
    everything = dataclasses.replace(
        still,
        pressure_force=rng.random(push.shape),
        friction_force=0.1 * rng.random(push.shape),
        rings=RingForce(3.0, -7.0, 0.2),
        carrier=Carrier(*rng.random(4)),
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
    before, _ = taken(model, MOVING)
    push, drag = forces(model, 3)
    base = Inputs(SPEED, 5e5, 1e3 * push, drag, carrier=MOVING)
    change = Inputs(0.0, 0.0, np.ones(push.shape), 0.0 * drag)
    products_by_differences(model, before, base, change, STEP, 1e-5)
