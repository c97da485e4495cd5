"""Chains of bodies: tables by name, differences, virtual work and momentum."""

import os

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.force_elements.element import BODIES
from piston_cosim.fmu_mfbd.mechanism.carrier import FIXED, BlockMotion
from piston_cosim.fmu_mfbd.mechanism.chain import IN_PARENT
from piston_cosim.fmu_mfbd.mechanism.cylinder import (
    NO_SLIDES,
    CylinderParts,
    FreeSlides,
    cylinder_chain,
)
from piston_cosim.fmu_mfbd.mechanism.derivative import chain_derivative
from piston_cosim.fmu_mfbd.mechanism.equations import chain_forces, forces_at
from piston_cosim.fmu_mfbd.mechanism.generalised_alpha import Motion
from piston_cosim.fmu_mfbd.mechanism.loads import AppliedForces, loads_at, no_loads
from piston_cosim.fmu_mfbd.mechanism.motion import Increments, chain_motion
from piston_cosim.fmu_mfbd.mechanism.slider_crank import CrankMotion
from piston_cosim.fmu_mfbd.mechanism.solution import (
    arrow_product,
    factorise_chain,
    solve_coupled,
    substitute_chain,
)
from piston_cosim.master.fmi.block import row_of
from piston_cosim.master.fmi.native_code import RAW
from piston_cosim.tests.verification.cases.links import Element, Link, chain_of, play

from ..command import script
from . import chain_entry
from .chains import (
    CRANK,
    CRANK_MASS,
    GAS,
    MECHANISM,
    SHAPES,
    SHELL_MODES,
    SLIDES,
    SPIN_INERTIA,
    UNBALANCE,
    coupled,
    engine,
    flexible,
    rigid,
    springs,
    tied,
    touching,
)
from .differences import derivative

STEP = 1e-4
MOVING = BlockMotion(30.0, -40.0, 900.0, 1.3)
DIGITS = 1e-13
"""Both add up to some tens of terms in another order: 1e-16 of the largest term for each."""


def motion(built, seed=1):
    """Return a motion of micrometres, pistons that slap, and slides of millimetres."""
    rng = np.random.default_rng(seed)
    m = built.chain.joints.tip.shape[1]
    k = len(built.chain.bodies.stiffness)
    scales = np.repeat([[1e-5], [0.01], [900.0]], m, axis=1)
    for b in built.pistons:
        turn = built.chain.joints.angle[b]
        scales[:, turn - 1] = 3e-5, 0.05, 800.0
        scales[:, turn] = 2e-3, 3.0, 5e4
    joints = built.chain.joints
    scales[:, joints.slide[joints.turns == IN_PARENT]] = [[3e-3], [2.0], [900.0]]
    modal = np.repeat([[1e-6], [1e-2], [1e3]], k, axis=1)
    return Motion(*(np.hstack([scales, modal]) * rng.standard_normal((3, m + k))))


def held(built, seed=2):
    """Return forces of films and skirt and on modes of any size, the gas on the bore's axis."""
    rng = np.random.default_rng(seed)
    elements, modes = built.chain.elements, len(built.chain.bodies.stiffness)
    n = len(elements.acts)
    force, moment = 9e3 * rng.standard_normal((n, 2)), 2.0 * rng.standard_normal(n)
    force[built.gas], moment[built.gas] = (0.0, -GAS), 0.0
    slopes = 3e3 * rng.standard_normal(elements.modes.sum())
    on_shapes = 3e3 * rng.standard_normal((n, elements.shapes.max(), 2))
    return AppliedForces(force, moment, 100 * rng.standard_normal(modes), slopes, on_shapes)


def loads(built, now, seed=2):
    """Return the loads of applied forces in a motion."""
    at = chain_motion(built.chain.joints, now, CRANK)
    return loads_at(built.chain, held(built, seed), at, now)


def reach(n, c1=0.5 * STEP, c2=0.25 * STEP**2):
    return Increments(np.full(n, c2), np.full(n, c1), np.ones(n))


def assert_close(own, known):
    """Compare each number, and one that is small by itself with the largest."""
    size = np.abs(known).max(initial=0.0)
    np.testing.assert_allclose(own, known, rtol=DIGITS, atol=2e-15 * size)


ON_PISTON, ON_ROD = (BODIES.index(name) for name in ("piston", "rod"))
FREED = FreeSlides(np.array([ON_ROD, *[ON_PISTON] * 2]), np.full(3, IN_PARENT), np.array(SLIDES))
"""Slides of `SLIDES` in the joints of a cylinder."""


@pytest.mark.parametrize("slides", [NO_SLIDES, FREED], ids=["tied", "sliding"])
@pytest.mark.parametrize("carrier", [FIXED, MOVING], ids=["fixed", "moving"])
def test_a_tied_pin_is_the_chain_of_its_links(carrier, slides):
    """The tables of the FMU give the forces of a chain that is built by name.

    Its pin is a body, which slides with the piston and is massless then. Its crank has no
    unbalance, which adds e'' U to the forces on the block and e U x a_O to the torque.
    """
    piston, is_free = flexible(60), slides is FREED
    mechanism = MECHANISM._replace(pin_mass=0.0) if is_free else MECHANISM
    links = engine([piston], slides=is_free, mechanism=mechanism)
    own = tied(piston, mechanism, slides)
    now = motion(own)
    given = loads(own, now)
    expected, forces = (chain_forces(one.chain, given, now, CRANK, carrier) for one in (links, own))
    assert_close(forces.residual, expected.residual)
    angle, w = CRANK.angle, CRANK.speed + carrier.w
    alpha = CRANK.acceleration + carrier.alpha
    x, y = -np.sin(angle), np.cos(angle)
    flung = UNBALANCE * np.array([-alpha * y - w**2 * x, alpha * x - w**2 * y, 0.0])
    assert_close(forces.on_block, expected.on_block - flung)
    added = UNBALANCE * (x * carrier.ay - y * carrier.ax)
    assert forces.torque == pytest.approx(expected.torque + added, rel=DIGITS)
    by = reach(len(now.position))
    arrows = (
        chain_derivative(one.chain, given, now, forces, by).arrow
        for one, forces in ((links, expected), (own, forces))
    )
    for one, other in zip(*arrows):
        for row, known in zip(one, other):
            assert_close(row, known)


@pytest.mark.parametrize("modes", [0, 8])
def test_a_cylinder_is_the_chain_by_names(modes):
    """All tables of a cylinder that is built from numbers, with films on all bearings."""
    piston = flexible(modes)
    by_name = engine([piston], True, True, yields=True).chain
    own = cylinder_chain(
        CylinderParts(
            piston=piston,
            moving=modes,
            mechanism=MECHANISM,
            spin_inertia=SPIN_INERTIA,
            crank_mass=CRANK_MASS,
            unbalance=UNBALANCE,
            floats=True,
            big_end=True,
            main_bearing=True,
            springs=springs(2 * SHAPES + 3 * SHELL_MODES),
            block_modes=0,
            block_static=0,
            shapes=SHAPES,
            big_end_modes=SHELL_MODES,
            main_bearing_modes=SHELL_MODES,
        )
    )
    for one, other in zip(own[:3], by_name[:3]):
        for name, mine, known in zip(one._fields, one, other):
            np.testing.assert_array_equal(mine, known, err_msg=name)


TWO = [flexible(8, seed) for seed in (3, 5)]
ENGINES = {
    "tied": lambda: tied(TWO[0]),
    "everything": lambda: engine(TWO[:1], True, True, True),
    "two cylinders": lambda: engine(TWO, True, True),
    "slides": lambda: engine(TWO, free=True, slides=True),
}
YIELDING = {
    "yields": lambda: engine(TWO[:1], True, True, yields=True),
    "two that yield": lambda: engine(TWO, True, True, yields=True),
}
each_engine = pytest.mark.parametrize("built", [make() for make in ENGINES.values()], ids=ENGINES)
each_that_yields = pytest.mark.parametrize(
    "built", [make() for make in (ENGINES | YIELDING).values()], ids=ENGINES | YIELDING
)


def centres(chain, at, e):
    """Return marker and point of an element from the block's origin."""
    table = chain.elements
    out = []
    reaction = table.carrier[e], table.point[e]
    action = reaction if table.at_point[e] else (table.acts[e], table.marker[e])
    for b, point in (action, reaction):
        c, s = at.axes[b] if b >= 0 else (1.0, 0.0)
        origin = at.position[b] if b >= 0 else np.zeros(2)
        out.append(origin + np.array([[c, -s], [s, c]]) @ point)
    return out


def cross(a, b):
    return a[0] * b[1] - a[1] * b[0]


@each_that_yields
def test_the_tangent_is_the_derivative(built):
    """All columns against differences of sixth order, half of them by another rule than the rest.

    Differences of 100 m/s2 have the round-off of forces of 1e4 N, 2e-12 N, over 100, and that of
    the largest term of a row.
    """
    chain = built.chain
    now = motion(built)
    given = loads(built, now)
    n, m = len(now.position), chain.joints.tip.shape[1]
    by = reach(n)
    by.velocity[: m // 2], by.position[: m // 2] = STEP, STEP**2

    def residual(change):
        moved = Motion(*(old + more * change for old, more in zip(now, by)))
        later = chain_motion(chain.joints, moved, CRANK)
        changed = loads_at(chain, held(built), later, moved)
        return forces_at(chain, changed, later, moved, MOVING).residual

    own = chain_forces(chain, given, now, CRANK, MOVING)
    whole = coupled(chain_derivative(chain, given, now, own, by).arrow, chain, own, by)
    scale = np.abs(whole).max(axis=1)
    for j, unit in enumerate(np.eye(n)):
        known = derivative(lambda x, unit=unit: residual(x * unit), 0.0, 100.0)
        np.testing.assert_array_less(np.abs(whole[:, j] - known), 2e-13 * scale + 2e-14)


@each_that_yields
def test_the_solution_and_the_product_of_a_tangent(built):
    """Right sides of many sizes, without and with coupled modes; the condition is about 1e6."""
    chain = built.chain
    now = motion(built)
    n = len(now.position)
    by = reach(n)
    own = chain_forces(chain, loads(built, now), now, CRANK, MOVING)
    arrow = chain_derivative(chain, loads(built, now), now, own, by).arrow
    factors = factorise_chain(arrow)
    right = 10 ** np.linspace(-2, 2, n)
    x = substitute_chain(factors, right)
    np.testing.assert_allclose(arrow_product(arrow, x), right, rtol=1e-9)
    x = solve_coupled(chain.bodies, own.motion, MOVING, by, factors, right)
    expected = np.linalg.solve(coupled(arrow, chain, own, by), right)
    np.testing.assert_allclose(x, expected, rtol=1e-8)


@each_that_yields
def test_forces_and_motion_agree_in_virtual_work(built):
    """Power of all elements and modal forces in space, and in coordinates and drive.

    Round-off of 20 terms.
    """
    chain = built.chain
    now = motion(built)
    given = loads(built, now)
    none = no_loads(chain)
    at = chain_motion(chain.joints, now, CRANK)
    table = chain.elements
    power = [given.modal @ now.velocity[chain.joints.tip.shape[1] :]]
    for e, wrench in enumerate(given.wrench):
        for b, centre, force, moment in zip(
            (table.acts[e], table.reacts[e]),
            centres(chain, at, e),
            (wrench[:2], -wrench[:2]),
            wrench[2:],
        ):
            if b >= 0:
                arm, (x, y, w) = centre - at.position[b], at.velocity[b]
                velocity = np.array([x - w * arm[1], y + w * arm[0]])
                power.append(force @ velocity + moment * w)
    loaded, bare = (chain_forces(chain, one, now, CRANK, MOVING) for one in (given, none))
    rows = -(loaded.residual - bare.residual) * now.velocity
    drive = -(loaded.torque - bare.torque) * CRANK.speed
    size = np.abs(power).sum() + np.abs(rows).sum() + abs(drive)
    assert sum(power) == pytest.approx(rows.sum() + drive, abs=1e-14 * size)


@each_engine
def test_pistons_are_where_their_coordinates_say(built):
    """x of A is its coordinate, with all plays and slides in between; 0.3 m have 5e-17 m."""
    now = motion(built)
    at = chain_motion(built.chain.joints, now, CRANK)
    x = [now.position[built.chain.joints.angle[b] - 1] for b in built.pistons]
    offset = MECHANISM.offset
    np.testing.assert_allclose(at.position[built.pistons, 0] - offset, x, rtol=0, atol=2e-16)


@each_that_yields
def test_momentum_and_energy(built):
    """Forces on a block at rest and power of all rows are those of momentum and energy.

    Both are differences of sixth order of a motion in time, good to 1e-9 of their sizes. Modes of
    shells and shapes without forces on them have no momentum.
    """
    chain, bodies = built.chain, built.chain.bodies
    now = motion(built)
    none = no_loads(chain)
    m = chain.joints.tip.shape[1]

    def state(t):
        q = now.position + t * now.velocity + t**2 / 2 * now.acceleration
        v = now.velocity + t * now.acceleration
        drive = CrankMotion(
            CRANK.angle + t * CRANK.speed + t**2 / 2 * CRANK.acceleration,
            CRANK.speed + t * CRANK.acceleration,
            CRANK.acceleration,
        )
        at = chain_motion(chain.joints, Motion(q, v, now.acceleration), drive)
        out = np.array([0.0, 0.0, 0.0, v[m:] @ v[m:] / 2])
        for b, mass in enumerate(bodies.mass):
            modes = slice(*bodies.first_mode[b : b + 2])
            x, dx = q[m:][modes], v[m:][modes]
            B, G = bodies.coupling[slice(*bodies.first_entry[b : b + 2])].reshape(2, len(x), len(x))
            S = bodies.S[b] + bodies.T[:, modes] @ x
            c, s = at.axes[b]
            R, (*of, w) = np.array([[c, -s], [s, c]]), at.velocity[b]
            internal = R @ (w * np.array([-S[1], S[0]]) + bodies.T[:, modes] @ dx)
            spin = (bodies.g[modes] + G @ x) @ dx
            inertia = bodies.I0[b] + 2 * bodies.b[modes] @ x + x @ B @ x
            momentum = mass * np.array(of) + internal
            out[:2] += momentum
            out[2] += cross(at.position[b], momentum) + cross(R @ S, of) + w * inertia + spin
            out[3] += mass / 2 * np.dot(of, of) + of @ internal + w * spin
            out[3] += w**2 * inertia / 2
        return out

    rates = derivative(state, 0.0, 1e-4)
    own = chain_forces(chain, none, now, CRANK, FIXED)
    force = -own.on_block + [0.0, 0.0, own.torque]
    np.testing.assert_allclose(rates[:3], force, atol=1e-9 * np.abs(force).max())
    q, v = now.position[m:], now.velocity[m:]
    held = v @ (bodies.damping * v + bodies.stiffness * q)
    rows = [*(own.residual * now.velocity), own.torque * CRANK.speed, -held]
    assert rates[3] == pytest.approx(sum(rows), abs=1e-9 * np.abs(rows).sum())


def test_a_chain_that_cannot_be_lists_all_faults():
    body = rigid(1.0)
    links = [Link(body, 0), Link(body, 0, slides=play(1), swings=True, guide=2)]
    with pytest.raises(ValueError) as raised:
        chain_of(links, [Element(2)], coordinates=2)
    assert str(raised.value).splitlines() == [
        "link 0: expected a parent from -1 to -1, got 0",
        "link 1: expected slide from 0 to 1, got 2",
        "link 1: expected guide from -1 to 1, got 2",
        "link 1: expected a body on a rod that swings, and no angle of it",
        "element 0: expected bodies below 2, got (2, -1, -1, -1)",
    ]


@pytest.mark.slow
def test_one_compiled_kernel_serves_every_chain():
    """Compiled code of one signature solves chains of 3, 4 and 7 bodies as Python does."""
    for make in (*(ENGINES | YIELDING).values(), lambda: touching(TWO[0])):
        built = make()
        now = motion(built)
        n = len(now.position)
        problem = chain_entry.ChainProblem(
            built.chain, loads(built, now), now, reach(n), CRANK, MOVING
        )
        memory, none = row_of(problem), np.zeros(0)
        own, known = np.empty(n), np.empty(n)
        chain_entry.advance(own, np.zeros(0, dtype=np.int64), memory, none)
        chain_entry.advance.py_func(known, None, memory, none)
        np.testing.assert_allclose(own, known, rtol=1e-11)  # products of matrices in another order
    assert len(chain_entry.advance.dispatcher.signatures) == 1


@pytest.mark.slow
def test_a_chain_is_machine_code_without_python():
    code = f"import runpy; runpy.run_module({chain_entry.__name__!r}, run_name='__main__')"
    sizes = script(code, env=os.environ | RAW).split()[1::2]
    assert all(1e4 < int(size) < 3e5 for size in sizes) and len(sizes) == 3
