"""Force elements with laws: slopes, tangent, virtual work and motion by closed forms."""

from dataclasses import fields, replace

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.dynamics.assembly import assemble
from piston_cosim.fmu_mfbd.dynamics.model import MOTION, ON_FLEXIBLE_BLOCK, Inputs
from piston_cosim.fmu_mfbd.dynamics.model_faults import faults
from piston_cosim.fmu_mfbd.dynamics.system import RingForce
from piston_cosim.fmu_mfbd.force_elements import FORCE_ELEMENTS
from piston_cosim.fmu_mfbd.force_elements.element import ForceElement, PointForce, PointMotion
from piston_cosim.fmu_mfbd.force_elements.land_contact import LandParameters, land_force
from piston_cosim.fmu_mfbd.mechanism import laws
from piston_cosim.fmu_mfbd.mechanism.chain import BLOCK, Laws
from piston_cosim.fmu_mfbd.mechanism.derivative import chain_derivative
from piston_cosim.fmu_mfbd.mechanism.equations import forces_at
from piston_cosim.fmu_mfbd.mechanism.generalised_alpha import Motion
from piston_cosim.fmu_mfbd.mechanism.laws import add_laws, law_power
from piston_cosim.fmu_mfbd.mechanism.loads import loads_at, no_loads
from piston_cosim.fmu_mfbd.mechanism.motion import chain_motion

from .chains import CRANK
from .differences import derivative, products_by_differences, rough_change
from .pin_models import GRID, PARAMETERS, bodies, options, outside_model
from .test_combinations import carried_way
from .test_mechanism import ENGINES, MOVING, STEP, held, motion, reach
from .test_motion_in_space import SKEWED, flat_bodies
from .test_motion_in_space import options as space_options

SIZES = np.array([0.05, 0.1, 0.5, 5.0, 10.0, 100.0])
"""Sizes of the components of a motion between any two bodies of an engine."""
RNG = np.random.default_rng(5)
LINEAR = 500 * RNG.standard_normal((3, 6)) / SIZES
SQUARE = 500 * RNG.standard_normal((3, 6, 6)) / SIZES / SIZES[:, None]


def any_force(kind, numbers, at):
    """Return a force that depends on everything; `numbers` has its size."""
    z = np.array(at[:6])
    return PointForce(*(numbers[0] * (LINEAR @ z + SQUARE @ z @ z / 2 + np.cos(at.crank_angle))))


def any_change(kind, numbers, at, by):
    """Return its change."""
    z, dz = np.array(at[:6]), np.array(by[:6])
    return PointForce(*(numbers[0] * (LINEAR @ dz + (SQUARE @ z @ dz + SQUARE @ dz @ z) / 2)))


@pytest.fixture
def any_law(monkeypatch):
    """Let all elements have `any_force`."""
    monkeypatch.setattr(laws, "force_of", any_force)
    monkeypatch.setattr(laws, "change_of", any_change)


def connected(built):
    """Return the chain of an engine with an element between every two bodies, in both ways."""
    chain, rng = built.chain, np.random.default_rng(6)
    n = len(chain.bodies.mass)
    pairs = [(a, b) for a in range(n) for b in range(BLOCK, n) if a != b]
    acts, reacts = np.array(pairs).T
    marker = 0.05 * rng.standard_normal((len(pairs), 2))
    none = np.zeros(len(pairs), np.int64)
    rows = dict.fromkeys(("mode", "modes", "shape", "shapes"), none)
    rows |= {"acts": acts, "carrier": acts, "reacts": reacts, "axes": reacts, "play": none - 1}
    rows |= {"marker": marker, "point": marker, "at_point": np.zeros(len(pairs))}
    elements = type(chain.elements)(
        *(np.concatenate(both) for both in zip(chain.elements, type(chain.elements)(**rows)))
    )
    zero = 0.01 * rng.standard_normal((len(pairs), 2))
    own = Laws(none, zero, np.ones((len(pairs), 1)))
    return chain._replace(elements=elements, laws=own)


def forces_in(chain, now, given, carrier):
    """Return loads and forces of a chain with its laws, and its motion."""
    at = chain_motion(chain.joints, now, CRANK)
    loads = loads_at(chain, given, at, now) if given else no_loads(chain)
    add_laws(chain, at, CRANK.angle, loads)
    return loads, forces_at(chain, loads, at, now, carrier)


each_engine = pytest.mark.parametrize("built", [make() for make in ENGINES.values()], ids=ENGINES)


@each_engine
def test_the_tangent_has_the_slopes_of_laws_between_any_two_bodies(built, any_law):
    """All columns of residual, torque and force on the block, against sixth-order differences.

    Differences of 100 m/s2 have the round-off of forces of 1e4 N, over 100.
    """
    chain = connected(built)
    now, given = motion(built), held(built._replace(chain=chain))
    n, m = len(now.position), chain.joints.tip.shape[1]
    by = reach(n)
    by.velocity[: m // 2], by.position[: m // 2] = STEP, STEP**2

    def everything(change):
        moved = Motion(*(old + more * change for old, more in zip(now, by)))
        _, forces = forces_in(chain, moved, given, MOVING)
        return np.concatenate([forces.residual[:m], [forces.torque], forces.on_block])

    loads, own = forces_in(chain, now, given, MOVING)
    slope = chain_derivative(chain, loads, now, own, by)
    whole = np.vstack([slope.arrow.top, slope.torque, slope.on_block])
    scale = np.abs(whole).max(axis=1)
    for j in range(m):
        unit = np.eye(n)[j]
        known = derivative(lambda x, unit=unit: everything(x * unit), 0.0, 100.0)
        np.testing.assert_array_less(np.abs(whole[:, j] - known), 1e-11 * scale + 1e-12)


@each_engine
def test_power_of_laws_is_that_of_the_generalised_forces(built, any_law):
    """Virtual work of any law, at any joint, in coordinates and drive. Round-off of 40 terms."""
    chain = connected(built)
    now = motion(built)
    loads, loaded = forces_in(chain, now, None, MOVING)
    bare = forces_at(chain, no_loads(chain), loaded.motion, now, MOVING)
    rows = [*(loaded.residual - bare.residual) * now.velocity]
    rows.append((loaded.torque - bare.torque) * CRANK.speed)
    power = law_power(chain, loaded.motion, loads)
    size = np.abs(rows).sum()
    assert abs(power) > 1e-3 * size
    assert abs(power + sum(rows)) < 1e-13 * size


# ---- elements of the FMU


@pytest.mark.parametrize("element", FORCE_ELEMENTS, ids=lambda one: one.names()[0])
def test_the_change_of_every_element_is_the_derivative_of_its_force(element):
    """Central differences at 200 random motions that act, with random parameters in their ranges.

    The step of 1e-6 leaves 1e-9 where the force is smooth.
    """
    rng = np.random.default_rng(8)
    own = fields(element.parameters)
    acted = 0
    while acted < 200:
        ranges = (one.metadata["maximum"] for one in own)
        p = element.parameters(*(10.0 ** rng.uniform(-4, 0) * most for most in ranges))
        scale = np.append(10.0 ** rng.uniform(-4, 0) * SIZES, 1.0)
        at, by = scale * rng.uniform(-1, 1, (2, 7))
        by[-1] = 0.0
        up, down = (element.force(p, PointMotion(*at + way * by)) for way in (1e-6, -1e-6))
        known = np.subtract(up, down) / 2e-6
        if not np.any(known):
            continue
        acted += 1
        change = element.change(p, PointMotion(*at), PointMotion(*by))
        size = np.abs(known).max() + 1e-3 * np.abs(up).max()
        np.testing.assert_allclose(change, known, rtol=0.0, atol=1e-6 * size)


def test_the_force_of_a_land_that_touches_by_hand():
    """2e6 N/m, 30 um deep, 1 + 0.5 s/m times 0.2 m/s: 66 N. It never pulls."""
    p = LandParameters(2e6, 0.5, 200e-6)
    still = PointMotion(*np.zeros(7))
    for side in (1.0, -1.0):
        x = side * 230e-6
        (force, *others) = land_force(p, still._replace(x=x, vx=0.2 * side))
        assert force == pytest.approx(-66.0 * side, rel=1e-12) and others == [0.0, 0.0]
        assert land_force(p, still._replace(x=x, vx=-2.5 * side)) == (0.0, 0.0, 0.0)
        assert land_force(p, still._replace(x=side * 199e-6, vx=side)) == (0.0, 0.0, 0.0)


SPRING = LandParameters(1e6, 0.0, 0.0, 0.0)
"""Without clearance and damping the land is a linear spring, here at A."""
AT_REST = Inputs(0.0, 0.0, np.zeros(GRID), np.zeros(GRID))


def sprung(land=SPRING, **changes):
    """Return a rigid piston on a tied pin with a land contact."""
    piston, block, *_ = bodies()
    return assemble(piston, block, options(False), replace(PARAMETERS, **changes), [land])


def test_a_spring_balances_the_rings():
    """x = F/k, at rest. Without the spring the same force accelerates the piston by 20 m/s2."""
    inputs = replace(AT_REST, rings=RingForce(40.0, 0.0, 0.0))
    at = [40.0 / SPRING.land_stiffness, 0.0]
    state, out = sprung().start_moving(0.0, np.array(at), np.zeros(2), inputs)
    free, _ = sprung(LandParameters()).start_moving(0.0, np.array(at), np.zeros(2), inputs)
    # positions of 0.3 m leave 1e-16 m of x
    assert np.abs(state.acceleration).max() < 1e-9 * np.abs(free.acceleration).max()
    assert np.abs(free.acceleration).max() > 10.0
    assert out["element_power"] == 0.0


def test_power_of_a_spring_is_what_the_piston_gains():
    """Kinetic energy grows by the power of the element, and the spring gives it back.

    The trapezoidal rule with h w = 0.02 leaves 2e-4 of the energy. The first two steps, of backward
    Euler, lose (h w)^2 of it each.
    """
    model = sprung(spectral_radius=1.0)
    k, position = SPRING.land_stiffness, np.array([50e-6, 0.0])
    state, out = model.start_moving(0.0, position, np.zeros(2), AT_REST)
    size, gain, power = k * position[0] ** 2 / 2, 0.0, out["element_power"]
    for _ in range(600):
        state, out = model.advance(state, AT_REST, 3e-5)
        gain += 3e-5 * (power + out["element_power"]) / 2
        power = out["element_power"]
        stored = k * out["lateral_displacement"] ** 2 / 2
        assert state.kinetic == pytest.approx(gain, abs=2e-4 * size)
        assert state.kinetic + stored == pytest.approx(size, abs=1e-3 * size)
    assert max(abs(gain), stored) > 0.1 * size


@pytest.mark.parametrize("name", ["tied", "outside"])
def test_derivatives_of_a_step_with_contact_are_differences(name):
    """Motion, films and the forces on bearings in a block that moves, with a land that touches.

    The tolerance is that of `test_combinations`.
    """
    land = LandParameters(3e7, 0.1, 0.0, 0.03)
    model = outside_model(elements=(land,)) if name == "outside" else sprung(land)
    before, base, out = carried_way(model, MOVING)
    assert abs(out["element_power"]) > 1.0
    products = products_by_differences(model, before, base, rough_change(model, base), STEP, 3e-6)
    assert {*MOTION, *(ON_FLEXIBLE_BLOCK if model.outside else ())} <= products.keys()


def test_motion_in_space_does_not_support_force_elements():
    own = [LandParameters(1e7)]
    told = faults(flat_bodies(), space_options(SKEWED), PARAMETERS, own)
    assert "land_stiffness: expected 0 with motion in space, got 1e+07" in told


@pytest.mark.parametrize(
    "wrong, text",
    [
        (
            {"acts": "block"},
            "expected two of crank, rod, pin, piston and block, got acts = 'block'",
        ),
        ({"acts": "rod", "reacts": "rod"}, "got acts = 'rod', reacts = 'rod'"),
        ({"height": "height"}, "height: expected one of ['land_stiffness', "),
        ({"frees": {"gap": (1.0, 0.0)}}, "frees: expected acts and reacts of {'piston': 'rod', "),
    ],
)
def test_a_declaration_that_cannot_be_is_rejected(wrong, text):
    with pytest.raises(ValueError) as raised:
        ForceElement(LandParameters, land_force, land_force, **wrong)
    assert text in str(raised.value)
