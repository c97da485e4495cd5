"""Numbers of the bodies by hand, at the slave: mechanism, loads, film geometry, modes, tables.

The bodies are written by hand as reduced bodies, so that every number is known. The mechanism is
held against Newton's and Euler's equations of its single parts with the forces between them as
unknowns, which shares nothing with the minimal coordinates of the code. Every offset is nonzero,
the grid is not square, forces differ from cell to cell.

Axes: x to the thrust side, y to the head, z along the pin; theta from +z to +x; the crank turns
about +z and leaves top dead centre towards -x.
"""

import json
import shutil
from math import cos, hypot, pi, sin, sqrt, tanh

import numpy as np
import pytest
from pythonfmu.enums import Fmi2Status

from piston_cosim.fmu_mfbd.build import prepare
from piston_cosim.fmu_mfbd.slave import Mfbd

from ..forged import outcomes

GRID = (8, 5)
BORE = 37e-3  # [m]
LOW, HIGH = -14e-3, 9e-3  # skirt edges above A [m]
BOTTOM, TOP = 40e-3, 170e-3  # bore ends above the crank axis [m]
THETA = np.arange(8) * 2.0 * pi / 8
HEIGHT = LOW + (np.arange(5) + 0.5) / 5 * (HIGH - LOW)
PISTON = dict(mass=0.31, S=np.array([0.9e-3, 1.7e-3]), I0=2.3e-4)
MECHANISM = dict(
    crank_radius=28.8e-3,
    rod_length=110e-3,
    crank_offset=1.3e-3,
    rod_mass=0.35,
    rod_inertia=6e-4,
    rod_centre=31e-3,
    pin_mass=0.07,
    pin_friction_coefficient=0.0,
)
PIN_OFFSET = 0.8e-3


def near(value, rel=1e-9):
    """Within a share of the value alone: lengths are of the size of pytest's absolute tolerance."""
    return pytest.approx(value, rel=rel, abs=0.0)


@pytest.fixture
def bodies(tmp_path, monkeypatch):
    """Return a function that writes both bodies and starts the FMU."""
    monkeypatch.setenv("PISTON_COSIM_CACHE", str(tmp_path / "cache"))

    def begin(table=None, piston=None, block=None, **values):
        """Return the initialised FMU for a build table, modes of both bodies and variables."""
        k = len((piston or {}).get("omega", ()))
        m = len((block or {}).get("omega", ()))
        held = dict(
            T=np.zeros((2, k)),
            b=np.zeros(k),
            B=np.zeros((k, k)),
            g=np.zeros(k),
            G=np.zeros((k, k)),
            omega=np.zeros(k),
            kind=np.full(k, -1),
            gas_force=np.zeros(k),
            radial=np.zeros((40, k)),
            axial=np.zeros((40, k)),
            radius=BORE - 1e-4,
            skirt_lower=LOW,
            skirt_upper=HIGH,
            pin_offset=PIN_OFFSET,
        )
        np.savez(tmp_path / "piston.npz", **(PISTON | held | (piston or {})))
        held = dict(
            omega=np.zeros(m),
            kind=np.full(m, -1),
            radial=np.zeros((8, 14, m)),
            axial=np.zeros((8, 14, m)),
            heights=np.linspace(BOTTOM, TOP, 14),
            radius=BORE,
        )
        np.savez(tmp_path / "block.npz", **(held | (block or {})))
        table = dict(table or {})
        own = {"reduced": "piston.npz", "pin_offset": f"{PIN_OFFSET} m"} | table.pop("piston", {})
        other = {"reduced": "block.npz"} | table.pop("block", {})
        build = {"grid": list(GRID), "piston": own, "block": other} | table
        options, files = prepare(build, tmp_path, lambda text: None)
        resources = tmp_path / "resources"
        resources.mkdir(exist_ok=True)
        for file in files:
            shutil.copy(file, resources)
        (resources / "build.json").write_text(json.dumps(options))
        slave = Mfbd(instance_name="bodies", resources=str(resources))
        for name, value in (MECHANISM | values).items():
            slave.views[name][...] = value
        slave.exit_initialization_mode()
        assert slave.fault is None
        return slave

    return begin


def seen(slave):
    """All variables of a slave by name, as they are now."""
    return {name: view.copy() if view.ndim else view.item() for name, view in slave.views.items()}


def forces():
    """Pressure and friction force of each cell [N], no two alike."""
    rng = np.random.default_rng(4)
    return 30.0 * rng.random(GRID), 4.0 * rng.random(GRID) - 1.0


def cross(a, b):
    return a[0] * b[1] - a[1] * b[0]


def newton_euler(o, gas, turn=0.0, load_torque=None):
    """Accelerations and forces of the single parts: piston, pin, rod, crank.

    Piston, about A:  m A'' + al Z s - w^2 s = P + film + gas + rings
                      (Z s).A'' + I0 al = M + moments
    Pin:              m_p A'' = S - P
    Rod, about G:     m_r G'' = B - S,   J psi'' = (A - G) x (-S) + (C - G) x B - M
    Joint:            A'' - C'' = psi'' Z (A - C) - psi'^2 (A - C)
    Crank:            J_c w' = T - C x B      C from the crank axis

    with Z = e_z x, P on the piston from the pin, S on the pin from the rod, B on the rod from the
    crank, M the friction of the pin on the piston, -lever |P| tanh(slip/w_0) - viscous slip.

    Parameters: o, outputs, inputs and parameters of the slave at an instant; gas [N]; turn, w'
    [rad/s2], unknown where load_torque [N m] is given. Returns a dict.
    """
    x, angle = o["lateral_displacement"], o["rocking_angle"]
    phi, speed = o["crank_angle"], o["rotation_speed"]
    r, length = o["crank_radius"], o["rod_length"]
    crank = r * np.array([-sin(phi), cos(phi)])
    crank_rate = speed * r * np.array([-cos(phi), -sin(phi)])
    pin_x = PIN_OFFSET + x - (o["crank_offset"] + crank[0])
    rod = np.array([pin_x, sqrt(length**2 - pin_x**2)])
    rod_rate = -(o["lateral_velocity"] - crank_rate[0]) / rod[1]
    share = o["rod_centre"] / length
    s = PISTON["S"]
    s = np.array([cos(angle) * s[0] - sin(angle) * s[1], sin(angle) * s[0] + cos(angle) * s[1]])
    push, drag = o["nodal_pressure_force"], o["nodal_friction_force"]
    sine = np.sin(THETA)[:, None]
    film = np.array([-(push * sine).sum(), drag.sum()])
    moment = (push * sine * HEIGHT + drag * (BORE * sine - PIN_OFFSET)).sum()
    rings = np.array([o["ring_side_force"], o["ring_axial_force"]])
    film += rings
    moment += (gas - rings[1]) * (PIN_OFFSET + x)  # along the bore's axis, x = 0
    moment += o["ring_moment"]
    m, spin = PISTON["mass"], o["rocking_velocity"]
    slip = spin - rod_rate

    def solve(rubbing):
        # unknowns: A'' (2), al, P (2), S (2), B (2), psi'', w'
        left, right = np.zeros((11, 11)), np.zeros(11)
        left[0, [0, 2, 3]] = m, -s[1], -1.0
        left[1, [1, 2, 4]] = m, s[0], -1.0
        right[:2] = film - [0.0, gas] + spin**2 * s
        left[2, :3] = -s[1], s[0], PISTON["I0"]
        right[2] = moment + rubbing
        for axis in (0, 1):
            left[3 + axis, [axis, 3 + axis, 5 + axis]] = o["pin_mass"], 1.0, -1.0
        # G'' = k A'' + (1 - k) C''; C'' = w' (-cos, -sin) r + w^2 (sin, -cos) r
        tangential = r * np.array([-cos(phi), -sin(phi)])
        centripetal = -(speed**2) * crank
        for axis in (0, 1):
            row = 5 + axis
            left[row, [axis, 5 + axis, 7 + axis]] = share * o["rod_mass"], 1.0, -1.0
            left[row, 10] = (1.0 - share) * o["rod_mass"] * tangential[axis]
            right[row] = -(1.0 - share) * o["rod_mass"] * centripetal[axis]
        upper, lower = (1.0 - share) * rod, -share * rod
        left[7, 9] = o["rod_inertia"]
        left[7, 5:7] = -upper[1], upper[0]
        left[7, 7:9] = lower[1], -lower[0]
        right[7] = -rubbing
        for axis, arm in ((0, -rod[1]), (1, rod[0])):
            left[8 + axis, [axis, 9, 10]] = 1.0, -arm, -tangential[axis]
            right[8 + axis] = centripetal[axis] - rod_rate**2 * rod[axis]
        if load_torque is None:
            left[10, 10], right[10] = 1.0, turn
        else:
            left[10, 10] = o["crank_inertia"]
            left[10, 7:9] = -crank[1], crank[0]
            right[10] = -load_torque
        return np.linalg.solve(left, right)

    rubbing = 0.0
    for _ in range(200):
        a = solve(rubbing)
        arm = o["pin_radius"] or (BORE - 1e-4) / 4  # a quarter of the skirt's radius
        size = o["pin_friction_coefficient"] * arm * hypot(a[3], a[4])
        rubbing = -size * tanh(slip / o["pin_friction_speed"]) - o["pin_friction_damping"] * slip
    return dict(
        lateral=a[0],
        climb=a[1],
        rocking=a[2],
        pin=a[3:5],
        turn=a[10],
        torque=o["crank_inertia"] * a[10] + cross(crank, a[7:9]),
        friction=rubbing,
        heat=-rubbing * slip,
        position=crank[1] + rod[1],
        velocity=crank_rate[1] + rod_rate * rod[0],
    )


RINGS = dict(ring_side_force=130.0, ring_axial_force=-90.0, ring_moment=2.5)
RUBBING = dict(
    pin_friction_coefficient=0.08,
    pin_radius=9e-3,
    pin_friction_speed=40.0,
    pin_friction_damping=2e-3,
)


AS_SHIPPED = dict(pin_friction_coefficient=0.01)  # and the arm by default


@pytest.mark.parametrize(
    "rubbing", [{}, AS_SHIPPED, RUBBING], ids=["smooth pin", "pin as shipped", "rubbing pin"]
)
@pytest.mark.parametrize("phi", [0.4, 2.0, 4.4])
def test_parts_of_the_mechanism_obey_newton_and_euler(bodies, phi, rubbing):
    """Newton and Euler hold at the start, and at the end of a step in which the crank speeds up.

    The tolerance is 1e-9: Newton's method stops at 1e-11 of the accelerations, and forces are
    differences of larger ones.
    """
    push, drag = forces()
    slave = bodies(
        start_crank_angle=phi,
        start_lateral_displacement=40e-6,
        start_rocking_angle=-2e-3,
        crank_speed=310.0,
        gas_pressure=7e5,
        nodal_pressure_force=push,
        nodal_friction_force=drag,
        **RINGS,
        **rubbing,
    )
    gas = 7e5 * pi * BORE**2
    o = seen(slave)
    assert o["crank_angle"] == phi and o["rocking_angle"] == -2e-3
    step = 1e-5
    for turn in (0.0, 2e5):
        want = newton_euler(o, gas, turn)
        size = hypot(*want["pin"])
        for key, value in zip(("pin_force_x", "pin_force_y"), want["pin"]):
            assert o[key] == pytest.approx(value, abs=1e-9 * size)
        assert o["crank_torque"] == pytest.approx(want["torque"], abs=1e-9 * size * 0.03)
        assert o["pin_friction_moment"] == pytest.approx(want["friction"], rel=1e-8)
        assert o["pin_friction_power"] == pytest.approx(want["heat"], rel=1e-8)
        assert (o["pin_friction_power"] > 0.0) == bool(rubbing)
        assert o["piston_position"] == near(want["position"], rel=1e-13)
        assert o["piston_velocity"] == near(want["velocity"])
        assert o["side_force"] == near((push * np.sin(THETA)[:, None]).sum())
        assert o["interface_work_error"] <= 1e-13
        assert o["cylinder_pressure"] == 7e5
        if turn == 0.0:
            slave.views["crank_speed"][...] = 310.0 + 2e5 * step
            assert slave.do_step(0.0, step)
            o = seen(slave)
            assert o["rotation_speed"] == near(312.0)
            assert o["crank_angle"] == near(phi + 311.0 * step)
    assert o["residual_evaluations"] > 0 and o["jacobian_evaluations"] > 0


@pytest.mark.parametrize("phi", [0.3, 1.4, 4.0])
def test_effective_inertia_is_that_of_the_kinetic_energy(bodies, phi):
    """Eq. (K28): J w^2 / 2 is the energy of crank, rod, pin and piston, by central differences."""
    o = seen(bodies(start_crank_angle=phi, crank_inertia=4e-3))

    def places(angle):
        """Return the centres of piston and rod [m], and the angle of the rod."""
        crank = o["crank_radius"] * np.array([-sin(angle), cos(angle)])
        side = PIN_OFFSET - o["crank_offset"] - crank[0]
        rod = np.array([side, sqrt(o["rod_length"] ** 2 - side**2)])
        return crank + rod, crank + o["rod_centre"] / o["rod_length"] * rod, np.arctan2(*rod)

    h = 1e-5
    piston, rod, turn = ((a - b) / (2 * h) for a, b in zip(places(phi + h), places(phi - h)))
    masses = (PISTON["mass"] + o["pin_mass"]) * piston @ piston + o["rod_mass"] * rod @ rod
    inertia = o["crank_inertia"] + masses + o["rod_inertia"] * turn**2
    assert o["effective_inertia"] == near(inertia, rel=1e-8)  # 1e-10 of the differences


@pytest.mark.parametrize("load", [35.0, -20.0])
def test_free_crank(bodies, load):
    """Its acceleration is what Newton and Euler ask for with the load as torque."""
    push, drag = forces()
    slave = bodies(
        crank_free=1,
        crank_inertia=4e-3,
        load_torque=load,
        crank_speed=250.0,
        start_crank_angle=1.1,
        gas_pressure=9e5,
        nodal_pressure_force=push,
        nodal_friction_force=drag,
    )
    want = newton_euler(seen(slave), 9e5 * pi * BORE**2, load_torque=load)
    assert want["torque"] == near(-load)
    assert seen(slave)["crank_torque"] == -load
    slave.views["crank_speed"][...] = 1.0  # a free crank heeds it no more
    assert slave.do_step(0.0, 1e-6)
    turn = (seen(slave)["rotation_speed"] - 250.0) / 1e-6
    assert turn == near(want["turn"], rel=1e-6)  # jerk over half a step, digits of the speed
    assert abs(turn) > 1e4


@pytest.mark.parametrize("count", [300, pytest.param(5000, marks=pytest.mark.slow)])
def test_forged_states_give_a_sentence(bodies, count):
    slave = bodies(crank_speed=300.0)
    assert slave.do_step(0.0, 1e-5)
    seen = outcomes(slave, count, 1e-5, 1e-5)
    assert min(seen[name] for name in ("not read", "rejected", "taken")) > 0.05 * count, seen


# ---- film geometry


def spline(place, value, second):
    """Periodic cubic at `place`, counted in points, from values and second derivatives there."""
    first = np.floor(place).astype(int)
    t = place - first
    i, k = first % len(value), (first + 1) % len(value)
    v, m = np.array(value), np.array(second)
    straight = v[i] * (1 - t) + v[k] * t
    return straight + ((1 - t) ** 3 - (1 - t)) * m[i] / 6 + (t**3 - t) * m[k] / 6


def test_film_thickness_is_the_sum_of_its_shapes(bodies, tmp_path):
    """The film thickness is the sum of clearance, shapes, growth, orders and motion.

    h = clearance + barrel + ovality - growth of the skirt + growth of the bore + orders + measured
    shapes - tilt y' cos theta - (x_A - angle y') sin theta. The tolerance is the round-off of the
    bore's splines.
    """
    (tmp_path / "skirt.csv").write_text(
        "mm/deg, 0, 90, 180, 270\n-20, 1, 2, 3, 4\n20, 5, 6, 7, 8\n"
    )
    (tmp_path / "bore.csv").write_text("mm/deg, 45, 225\n100, 3, -1\n")
    units = {"angle_unit": "1 deg", "height_unit": "1 mm", "value_unit": "1 um"}
    orders = [
        {"order": 0, "amplitude": "2 um"},
        {"order": 3, "amplitude": "5 um", "phase": "20 deg"},
    ]
    slave = bodies(
        {
            "piston": {"profiles": 2 * [{"file": "skirt.csv"} | units]},
            "block": {"profiles": [{"file": "bore.csv"} | units], "orders": orders},
        },
        radial_clearance=33e-6,
        barrel=21e-6,
        ovality=130e-6,
        skirt_growth_lower=4e-6,
        skirt_growth_upper=11e-6,
        bore_growth_lower=-3e-6,
        bore_growth_upper=9e-6,
        pin_tilt=7e-4,
        start_crank_angle=2.3,
        start_lateral_displacement=13e-6,
        start_rocking_angle=9e-4,
    )
    theta, y = THETA[:, None], HEIGHT[None, :]
    place = seen(slave)["piston_position"] + y
    # A is read where it stands with x_A = 0; here 13 um x dY/dx = 0.2 aside: 3 um on a bore that
    # widens by 12 um over 130 mm: 2e-10 m
    way = (y - LOW) / (HIGH - LOW)
    film = 33e-6 + 21e-6 * (2.0 * way - 1.0) ** 2
    film = film + 130e-6 / 4.0 * (1.0 + np.cos(2.0 * theta))
    film = film - (4e-6 + 7e-6 * way)
    film = film - 3e-6 + 12e-6 * (place - BOTTOM) / (TOP - BOTTOM)
    film = film + 2e-6 + 5e-6 * np.cos(3.0 * (theta - np.radians(20.0)))
    film = film - 7e-4 * y * np.cos(theta)
    film = film - (13e-6 - 9e-4 * y) * np.sin(theta)
    # measured: linear between two heights; around, periodic cubic splines by their second
    # derivatives M (times the square of the spacing), from M- + 4 M + M+ = 6 (v- - 2 v + v+):
    # 1, 2, 3, 4 a quarter turn apart: M = 9, -3, 3, -9; 3, -1 half a turn apart: M = -24, 24
    skirt = spline(np.degrees(theta) / 90.0, [1.0, 2.0, 3.0, 4.0], [9.0, -3.0, 3.0, -9.0])
    film = film + 2.0 * 1e-6 * (skirt + 4.0 * (y + 20e-3) / 40e-3)  # measured twice
    film = film + 1e-6 * spline((np.degrees(theta) - 45.0) / 180.0, [3.0, -1.0], [-24.0, 24.0])
    assert np.abs(seen(slave)["film_thickness"] - film).max() <= 1e-9


def moving(tmp_path, **values):
    """File of a start in motion, all rates nonzero."""
    start = dict(
        crank_angle=0.7,
        rotation_speed=280.0,
        lateral_displacement=21e-6,
        rocking_angle=-6e-4,
        lateral_velocity=0.04,
        rocking_velocity=-3.0,
    )
    start |= values
    (tmp_path / "start.json").write_text(json.dumps(start))
    return start


def test_start_in_motion_and_sliding_velocity(bodies, tmp_path):
    """v = Y' + angle' (R sin theta - d), Y' with the lateral velocity; the crank at given speed."""
    moving(tmp_path)
    slave = bodies({"start": "start.json"}, crank_speed=300.0)
    o = seen(slave)
    assert o["lateral_velocity"] == 0.04 and o["rocking_velocity"] == -3.0
    assert o["rotation_speed"] == 300.0
    climb = newton_euler(o, 0.0)["velocity"]
    expected = climb - 3.0 * (BORE * np.sin(THETA) - PIN_OFFSET)
    assert o["sliding_velocity"] == near(np.repeat(expected[:, None], 5, axis=1), rel=1e-12)
    free = bodies({"start": "start.json"}, crank_speed=300.0, crank_free=1)
    assert seen(free)["rotation_speed"] == 280.0


def test_pressure_on_a_tapered_bore_lifts(bodies):
    """In a bore that opens upwards, a pressure force F lifts the skirt by F x slope.

    The bore opens by 40 um over its 130 mm. The pin carries the lift, and the crank carries it
    through dY/dphi. The motion is the same, so that the block has the drive's moment as well.
    """
    push, _ = forces()
    given = dict(start_crank_angle=1.9, nodal_pressure_force=push)
    straight = seen(bodies(**given))
    tapered = seen(bodies(bore_growth_lower=-10e-6, bore_growth_upper=30e-6, **given))
    lift = push.sum() * 40e-6 / (TOP - BOTTOM)
    # 1e-6: differences of forces a thousand times as large
    assert tapered["pin_force_y"] - straight["pin_force_y"] == near(-lift, rel=1e-6)
    lever = straight["piston_velocity"] / straight["rotation_speed"]
    for name in ("crank_torque", "moment_on_block"):
        assert tapered[name] - straight[name] == near(-lift * lever, rel=1e-6), name
    name = "main_bearing_force_y"
    assert tapered[name] - straight[name] == near(lift, rel=1e-6)
    assert tapered["pin_force_x"] == near(straight["pin_force_x"])


# ---- modes


def flexible():
    """Two modes of each body, fields linear in height, no inertia coupling."""
    rng = np.random.default_rng(8)
    heights = np.linspace(BOTTOM, TOP, 14)[None, :, None]
    at, slope = rng.standard_normal((2, 2, 8, 1, 2))
    piston = dict(
        omega=2.0 * pi * np.array([3e3, 3e4]),
        kind=np.full(2, -1),
        gas_force=np.array([0.7, -0.4]),
        radial=rng.standard_normal((40, 2)),
        axial=rng.standard_normal((40, 2)),
    )
    block = dict(
        omega=2.0 * pi * np.array([7e3, 5e4]),
        kind=np.full(2, -1),
        radial=at[0] + 10.0 * slope[0] * heights,
        axial=at[1] + 10.0 * slope[1] * heights,
    )
    return piston, block, at, 10.0 * slope


def test_modes_move_the_film_and_forces_the_modes(bodies, tmp_path):
    """h gains - u_r q (skirt) + w_r q (bore), v gains u_y q' - w_y q'.

    The modal forces do the same work: - sum F u_r + sum f u_y + G gas_force, and sum F w_r - sum f
    w_y. The tolerance is 1e-6, as fields have single precision.
    """
    piston, block, at, slope = flexible()
    push, drag = forces()
    q = np.array([2e-6, -1e-6, 3e-6, 0.5e-6])
    rate = np.array([0.02, -0.01, -0.03, 0.04])
    moving(tmp_path, modal_coordinate=q.tolist(), modal_velocity=rate.tolist())
    slave = bodies(
        {"start": "start.json"},
        piston=piston,
        block=block,
        gas_pressure=2e5,
        nodal_pressure_force=push,
        nodal_friction_force=drag,
        damping_ratio=0.03,
        high_frequency_damping_ratio=0.4,
        damping_transition_frequency=2e4,
    )
    o = seen(slave)
    # the bore is read where A stands for x_A = 0: 21 um x dY/dx_A = 4 um aside, 1e-4 of its field
    place = (o["piston_position"] + HEIGHT)[None, :, None]
    radial, axial = at[0] + slope[0] * place, at[1] + slope[1] * place
    skirt = piston["radial"].reshape(8, 5, 2)
    along = piston["axial"].reshape(8, 5, 2)
    theta, y = THETA[:, None], HEIGHT[None, :]
    way = (y - LOW) / (HIGH - LOW)
    gap = 25e-6 + 30e-6 * (2.0 * way - 1.0) ** 2 + 37.5e-6 * (1.0 + np.cos(2.0 * theta))
    gap = gap - (21e-6 + 6e-4 * y) * np.sin(theta)
    film = gap - skirt @ q[:2] + radial @ q[2:]
    assert np.abs(o["film_thickness"] - film).max() <= 1e-9
    climb = newton_euler(o, 0.0)["velocity"]
    velocity = climb - 3.0 * (BORE * np.sin(theta) - PIN_OFFSET)
    velocity = velocity + along @ rate[:2] - axial @ rate[2:]
    assert np.abs(o["sliding_velocity"] - velocity).max() <= 1e-5
    modal = np.concatenate(
        [
            -np.einsum("ij,ijk->k", push, skirt)
            + np.einsum("ij,ijk->k", drag, along)
            + 2e5 * pi * BORE**2 * piston["gas_force"],
            np.einsum("ij,ijk->k", push, radial) - np.einsum("ij,ijk->k", drag, axial),
        ]
    )
    omega = np.concatenate([piston["omega"], block["omega"]])
    # D = 2 zeta omega, zeta by the band the frequency lies in
    zeta = np.array([0.03, 0.4, 0.03, 0.4])
    damping = 2.0 * zeta * omega
    expected = modal - damping * rate - omega**2 * q
    assert slave.do_step(0.0, 1e-10)
    change = (seen(slave)["modal_velocity"] - rate) / 1e-10
    assert change == near(expected, rel=1e-3)  # digits of the velocity, place of the bore


def test_gas_widens_the_bore(bodies, tmp_path):
    """At rest, gas adds the modal force f = int p phi R dtheta dy over the wall.

    Table and input give 0.2 MPa above the top ring and 0.05 MPa between the rings. As phi is linear
    in height, each band counts with its middle.
    """
    piston, block, at, slope = flexible()
    moving(tmp_path, modal_coordinate=[0.0] * 4, modal_velocity=[0.0] * 4)
    rings = dict(top_ring_height=16e-3, second_ring_height=12e-3, land_pressure=5e4)
    slave = bodies({"start": "start.json"}, piston=piston, block=block, gas_pressure=2e5, **rings)
    o = seen(slave)
    ring, second = o["piston_position"] + np.array([16e-3, 12e-3])
    mean_at, mean_slope = at[0].mean(axis=(0, 1)), slope[0].mean(axis=(0, 1))
    expected = np.zeros(2)
    for pressure, low, high in ((2e5, ring, TOP), (5e4, second, ring)):
        area = 2.0 * pi * BORE * (high - low)
        expected += pressure * area * (mean_at + mean_slope * (low + high) / 2.0)
    assert slave.do_step(0.0, 1e-10)
    change = seen(slave)["modal_velocity"][2:] / 1e-10
    assert change == near(expected, rel=1e-3)  # digits of the velocity, place of the bore


def test_fast_modes_follow_their_load(bodies, tmp_path):
    """Modes above quasi_static_frequency follow Omega^2 q = f - T^T a - al g + w^2 b.

    These are the acceleration of A and the rotation of the frame, 40 rad/s at the start. Slower
    modes are at rest at the start.
    """
    piston, block, *_ = flexible()
    coupling = dict(
        T=np.array([[0.0, 0.05], [0.0, -0.08]]), g=np.array([0.0, 1e-3]), b=np.array([0.0, 2e-3])
    )
    push, drag = forces()
    moving(
        tmp_path,
        lateral_displacement=0.0,
        rocking_angle=0.02,
        rocking_velocity=40.0,
        modal_coordinate=[0.0] * 4,
        modal_velocity=[0.0] * 4,
    )
    slave = bodies(
        {"start": "start.json"},
        piston=piston | coupling,
        block=block,
        quasi_static_frequency=1e4,
        gas_pressure=2e5,
        nodal_pressure_force=push,
        nodal_friction_force=drag,
    )
    o = seen(slave)
    gas = 2e5 * pi * BORE**2
    a = newton_euler(o, gas)
    skirt, along = piston["radial"].reshape(8, 5, 2), piston["axial"].reshape(8, 5, 2)
    load = -(push * skirt[..., 1]).sum() + (drag * along[..., 1]).sum() - 0.4 * gas
    ax = cos(0.02) * a["lateral"] + sin(0.02) * a["climb"]
    ay = -sin(0.02) * a["lateral"] + cos(0.02) * a["climb"]
    load += -0.05 * ax + 0.08 * ay - 1e-3 * a["rocking"] + 40.0**2 * 2e-3
    q = o["modal_coordinate"]
    assert q[1] == near(load / piston["omega"][1] ** 2, rel=1e-6)  # single precision
    place = (o["piston_position"] + HEIGHT)[None, :]
    *_, at, slope = flexible()
    radial = at[0, :, :, 1] + slope[0, :, :, 1] * place
    axial = at[1, :, :, 1] + slope[1, :, :, 1] * place
    load = (push * radial - drag * axial).sum()
    assert q[3] == near(load / block["omega"][1] ** 2, rel=1e-5)
    assert q[0] == 0.0 and q[2] == 0.0


def test_a_start_that_bends_the_gap_says_by_how_much(bodies):
    """Under 5 MPa of gas, beside modes that have inertia and start straight; these say nothing."""
    piston, block, *_ = flexible()
    given = dict(piston=piston, block=block, gas_pressure=5e6)
    straight = bodies(**given)
    bent = bodies(**given, quasi_static_frequency=1e4)
    change = seen(bent)["film_thickness"] - seen(straight)["film_thickness"]
    _, said = straight.verdict()
    assert not said
    _, said = bent.verdict()
    (status, _, text) = said.pop()
    assert status == Fmi2Status.warning
    assert f"change the gap at the start by up to {np.abs(change).max():.3g} m" in text
    assert np.abs(change).max() > 1e-9


@pytest.mark.parametrize("rho", [0.0, 0.6, 1.0])
def test_spectral_radius(bodies, tmp_path, rho):
    """Two steps of backward Euler and one of generalised alpha move a mode without load.

    Their equations are solved in the form of J. Chung, G. M. Hulbert, J. Appl. Mech. 60 (1993)
    371-375. In this form the equation of motion holds at the end of the step.
    """
    piston, block, *_ = flexible()
    moving(tmp_path, modal_coordinate=[0.0, 0.0, 2e-6, 0.0], modal_velocity=[0.0, 0.0, 0.03, 0.0])
    slave = bodies(
        {"start": "start.json"},
        piston=piston,
        block=block,
        damping_ratio=0.1,
        spectral_radius=rho,
    )
    w, h, q, v = block["omega"][0], 3e-5, 2e-6, 0.03
    # unknowns q1, v1, d1 (acceleration)
    euler = np.array([[w * w, 0.2 * w, 1.0], [1.0, -h, 0.0], [0.0, 1.0, -h]])
    q1, v1, d1 = 0.0, 0.0, 0.0
    for k in range(2):
        q1, v1, d1 = np.linalg.solve(euler, [0.0, q, v])
        assert slave.do_step(k * h, h)
        assert seen(slave)["modal_coordinate"][2] == near(q1)
        assert seen(slave)["modal_velocity"][2] == near(v1)
        q, v = q1, v1
    alpha_m, alpha_f = (2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0)
    gamma = 0.5 - alpha_m + alpha_f
    beta = 0.25 * (1.0 - alpha_m + alpha_f) ** 2
    # unknowns q2, v2, d2, a2 (auxiliary, a1 = d1)
    left = np.array(
        [
            [w * w, 0.2 * w, 1.0, 0.0],
            [0.0, 0.0, 1.0 - alpha_f, alpha_m - 1.0],
            [0.0, 1.0, 0.0, -h * gamma],
            [1.0, 0.0, 0.0, -h * h * beta],
        ]
    )
    right = [
        0.0,
        alpha_m * d1 - alpha_f * d1,
        v1 + h * (1.0 - gamma) * d1,
        q1 + h * v1 + h * h * (0.5 - beta) * d1,
    ]
    q2, v2, *_ = np.linalg.solve(left, right)
    assert slave.do_step(2 * h, h)
    assert seen(slave)["modal_coordinate"][2] == near(q2)
    assert seen(slave)["modal_velocity"][2] == near(v2)
