"""Several cylinders on one mounted block.

The tests check shaking forces in closed form, the block's own equations, a block that does not
yield, and phases.
"""

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.mechanism.generalised_alpha import Motion
from piston_cosim.fmu_mfbd.mechanism.piston_motion import Load
from piston_cosim.fmu_mfbd.mechanism.slider_crank import CrankMotion, Mechanism
from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.tests.verification.cases.bodies import rigid_body
from piston_cosim.tests.verification.cases.tied import tied_forces, tied_pin

from .engines import ENGINES, PATH, alone, engine_tree, held, in_line
from .runs import module_of, run_tree

SPEED = 176.0
PISTON, PIN, ROD, SHARE = 1.39, 0.5, 1.7, 72.0 / 223.0
"""Masses [kg], and the rod's share that goes up and down with the pin."""
RADIUS, LENGTH = 72e-3, 223e-3
UNBALANCE = -0.171
POINTS = 256
"""Of a turn: orders beyond 40 are smaller than round-off."""


BLOCK = module_of(PATH.parent / "mounted_block.py")


def shaking(name, offset=0.0):
    """Return force and moment of all cylinders on their block over a revolution, (points, 6).

    The pistons are in the middle of their bores.
    """
    cylinders = ENGINES[name]
    body = rigid_body(PISTON, (0.001, 26.5e-3), 3e-3 + PISTON * 26.5e-3**2)
    mechanism = Mechanism(RADIUS, LENGTH, offset, ROD, 0.017, SHARE, PIN)
    engine = BLOCK.Engine(
        *np.zeros((3, 6, 6)),
        np.array([one.z for one in cylinders]),
        np.radians([one.bank for one in cylinders]),
    )
    load = Load(0.0, 0.0, 0.0, 0.0, np.zeros(0))
    still = Motion(np.zeros(2), np.zeros(2), np.zeros(2))
    chain = tied_pin(body, mechanism, UNBALANCE)
    turn = 2 * np.pi * np.arange(POINTS) / POINTS
    out = []
    for angle in turn:
        cranks = [CrankMotion(angle - np.radians(one.behind), SPEED, 0.0) for one in cylinders]
        forces = [tied_forces(chain, load, still, one).on_block for one in cranks]
        out.append(engine.total(*np.array([(*f[:2], 0.0) for f in forces]).T))
    return np.array(out)


def orders(curve):
    """Amplitudes of the orders 0, 1, .. of a curve over a turn."""
    found = np.abs(np.fft.rfft(curve)) / POINTS
    return np.array([found[0], *(2 * found[1:])])


def one_cylinder(offset):
    """Force along y of one cylinder over a turn.

    F_y = -(m_piston + m_pin + k m_rod) Y'' + (U + (1 - k) m_rod r) w^2 cos phi

    The rod's mass is split by its centre: k of it goes with A, the rest with the crank pin. Y'' by
    the Fourier series of Y, which is not what the kernel differentiates.
    """
    phi = 2 * np.pi * np.arange(POINTS) / POINTS
    height = RADIUS * np.cos(phi) + np.sqrt(LENGTH**2 - (offset + RADIUS * np.sin(phi)) ** 2)
    order = np.fft.rfftfreq(POINTS, 1 / POINTS)
    bent = SPEED**2 * np.fft.irfft(-(order**2) * np.fft.rfft(height), POINTS)
    turning = UNBALANCE + (1 - SHARE) * ROD * RADIUS
    return -(PISTON + PIN + SHARE * ROD) * bent + turning * SPEED**2 * np.cos(phi)


def shifted(curve, degrees):
    """Return a curve over a revolution, so many degrees later."""
    spectrum = np.fft.rfft(curve)
    order = np.arange(len(spectrum))
    return np.fft.irfft(spectrum * np.exp(-1j * order * np.radians(degrees)), POINTS)


@pytest.mark.parametrize("name", ENGINES)
@pytest.mark.parametrize("offset", [0.0, 4e-3])
def test_shaking_forces_are_the_sum_of_slider_cranks(name, offset):
    """Force along y and its moment about x, crank axis offset from the bores or not."""
    found = shaking(name, offset)
    force, moment = np.zeros(POINTS), np.zeros(POINTS)
    for one in ENGINES[name]:
        up = np.cos(np.radians(one.bank)) * shifted(one_cylinder(offset), one.behind)
        force += up
        moment -= one.z * up
    if name == "boxer":  # across, too, each bank against the other
        assert np.abs(found[:, 0]).max() < 1e-9 * 1e4
    # a second derivative of a series of 128 orders loses 4 of 16 digits
    np.testing.assert_allclose(found[:, 1], force, atol=1e-9 * 1e4)
    np.testing.assert_allclose(found[:, 3], moment, atol=1e-9 * 1e3)


def secondary():
    """Second order of the force of one cylinder without offsets, by the series of the handbooks.

    m r w^2 (l + l^3/4 + 15 l^5/128 + 35 l^7/512),   l = r/L
    """
    ratio = RADIUS / LENGTH
    series = ratio + ratio**3 / 4 + 15 * ratio**5 / 128 + 35 * ratio**7 / 512
    return (PISTON + PIN + SHARE * ROD) * RADIUS * SPEED**2 * series


@pytest.mark.parametrize(
    ("name", "first", "second"),
    [
        ("single", 1, 1),
        ("twin, 180 deg", 0, 2),
        ("twin, 360 deg", 2, 2),
        ("boxer", 0, 0),
        ("in-line four", 0, 4),
    ],
)
def test_balance_of_engines(name, first, second):
    """What each engine leaves of one cylinder's first and second order along y."""
    found = orders(shaking(name)[:, 1])
    up_and_down = (PISTON + PIN + SHARE * ROD) * RADIUS
    primary = (up_and_down + (1 - SHARE) * ROD * RADIUS + UNBALANCE) * SPEED**2
    tiny = 1e-11 * up_and_down * SPEED**2
    assert found[1] == pytest.approx(first * primary, rel=1e-12, abs=tiny)
    # the series ends with l^7: what follows is l^9 and smaller, 3e-5 of it
    assert found[2] == pytest.approx(second * secondary(), rel=5e-5, abs=tiny)
    assert np.all(found[3::2] < tiny)  # no odd order but the first, without offsets


# the block alone

VALUES = {
    "mass": 210.0,
    **{f"inertia_{axis}": value for axis, value in zip("xyz", (11.0, 8.0, 9.0))},
    **{f"centre_{axis}": value for axis, value in zip("xyz", (0.03, 0.12, 0.02))},
    "mount_x": np.array([-0.25, 0.25, -0.2, 0.3]),
    "mount_y": np.array([-0.05, -0.05, -0.02, -0.05]),
    "mount_z": np.array([-0.2, -0.2, 0.26, 0.26]),
    **{
        f"stiffness_{axis}": np.array([1.0, 2.0, 1.5, 1.0]) * k
        for axis, k in zip("xyz", (1e5, 3e5, 2e5))
    },
    "damping_time": 1e-3,
    "cylinder_z": np.array([-0.065, 0.065]),
    "bank_angle": np.array([0.3, -0.4]),
}


def test_matrices_of_the_block_by_points():
    """The matrices give the kinetic and elastic energy of a motion as computed by points.

    The points are eight masses with the block's mass, centre and inertia, and the springs.
    """
    engine = BLOCK.engine_of(VALUES)
    u, turn = np.array([0.3, -0.2, 0.5]), np.array([0.7, 1.1, -0.4])
    mass, centre = 210.0, np.array([0.03, 0.12, 0.02])
    # masses at (+-a, +-b, +-c) about the centre: J_x = m (b^2 + c^2) and so on
    J = np.array([11.0, 8.0, 9.0])
    half = np.sqrt((J.sum() / 2 - J) / mass)
    signs = np.array(np.meshgrid(*[(-1, 1)] * 3)).reshape(3, -1).T
    points = centre + signs * half
    speeds = u + np.cross(turn, points)
    q = np.array([*u, *turn])
    kinetic = mass / 8 * np.sum(speeds**2) / 2
    assert q @ engine.mass @ q / 2 == pytest.approx(kinetic, rel=1e-13)
    places = np.array([VALUES[f"mount_{axis}"] for axis in "xyz"]).T
    springs = np.array([VALUES[f"stiffness_{axis}"] for axis in "xyz"]).T
    elastic = np.sum(springs * (u + np.cross(turn, places)) ** 2) / 2
    assert q @ engine.stiffness @ q / 2 == pytest.approx(elastic, rel=1e-13)


def test_force_and_motion_do_the_same_work():
    """Power of the cylinders' forces at their places and of F along q' (Eqs. (U23), (U24))."""
    engine = BLOCK.engine_of(VALUES)
    rng = np.random.default_rng(3)
    forces, motion = rng.standard_normal((3, 2)), rng.standard_normal(6)
    x, y, turn, _ = engine.at_cylinder(motion, motion)
    power = np.sum(forces * [x, y, turn])
    assert engine.total(*forces) @ motion == pytest.approx(power, rel=1e-13)


# coupled

GRID, STOP = (16, 12), "24 deg"
ROUND_OFF = "1e-9 nm"
"""Tolerance on the film with which Newton ends at round-off."""


def computed(tree, path):
    """Results of a case's tree, every step converged."""
    results = run_tree(PATH, tree, path)
    assert results.summary["unconverged_steps"] == 0
    return results


def of(results, name):
    return results.series(name).values


SHOWN = ("lateral_displacement", "rocking_angle", "side_force", "crank_torque")


def test_a_block_that_does_not_yield_leaves_each_cylinder_alone(tmp_path):
    """On mounts of 1e30 N/m, each of two cylinders 17 deg apart is its single-piston case.

    A third cylinder, 720 deg behind the first, equals the first.
    """
    tree = held(engine_tree(in_line(0.0, 17.0, 720.0), GRID, STOP, ROUND_OFF))
    for wire in tree["wires"]:  # without energy check, which halves steps of one engine alone
        wire.pop("conjugate", None)
    together = computed(tree, tmp_path / "engine.h5")
    for k in (1, 2):
        single = computed(alone(tree, k), tmp_path / f"{k}.h5")
        for name in SHOWN:
            found, wanted = of(together, f"cylinder_{k}.{name}"), of(single, f"cylinder_{k}.{name}")
            # Newton ends at the last digits of films of 50 um; forces are stiffer than films
            np.testing.assert_allclose(found, wanted, atol=1e-9 * np.abs(wanted).max())
    for name in SHOWN:
        first, last = of(together, f"cylinder_1.{name}"), of(together, f"cylinder_3.{name}")
        np.testing.assert_allclose(last, first, atol=1e-9 * np.abs(first).max())
    assert np.abs(of(together, "block.velocity_y")).max() < 1e-20


def test_four_cylinders_on_soft_mounts(results_of):
    """Newton over nine participants, their derivatives as they offer them; the block's energy."""
    four = results_of("in_line_four")
    iterations = of(four, "coupling.iterations")[1:]
    # as many as each of them takes alone: 4 in the first steps from rest, 2 later
    assert iterations.mean() <= 3 and iterations.max() <= 4
    assert not four.summary.get("derivatives_by_differences")
    stored = np.abs(np.diff(of(four, "block.kinetic_energy"))).max()
    step = np.diff(four.time)
    assert np.abs(step * of(four, "block.power_error")[1:]).max() < 1e-9 * stored
    # momentum along y: what the block does not keep its mounts take, by the trapezoidal rule
    force = of(four, "block.shaking_force_y") - of(four, "block.mount_force_y")
    spin = of(four, "block.rotation_velocity_x")
    momentum = 210.0 * (of(four, "block.velocity_y") - 0.02 * spin)
    impulse = step * (force[1:] + force[:-1]) / 2
    impulse[0] = step[0] * force[1] / 2  # forces begin to act in the first step
    np.testing.assert_allclose(np.diff(momentum), impulse, atol=1e-9 * np.abs(impulse).max())


def test_mounts_that_do_not_hold_the_block_are_refused(tmp_path):
    """Mounts in one point hold no rotation."""
    tree = engine_tree(in_line(0.0), GRID, STOP)
    parameters = tree["participants"]["block"]["parameters"]
    parameters |= {f"mount_{axis}": ["0 mm"] * 4 for axis in "xyz"}
    with pytest.raises(
        BadInput, match="expected mounts that hold all six directions or none, got others"
    ):
        computed(tree, tmp_path / "engine.h5")
