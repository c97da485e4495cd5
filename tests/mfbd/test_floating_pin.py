"""A piston on a floating pin: an instant by hand, the tied pin as the stiff limit, derivatives,
moments, powers.
"""

import dataclasses

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.dynamics.assembly import assemble, assemble_floating, faults
from piston_cosim.fmu_mfbd.dynamics.build_options import (
    BlockOptions,
    BuildOptions,
    FloatingPin,
    PistonOptions,
)
from piston_cosim.fmu_mfbd.dynamics.floating_pin import PinFilms, imbalance, place_of
from piston_cosim.fmu_mfbd.dynamics.generalised_alpha import Motion
from piston_cosim.fmu_mfbd.dynamics.model import Inputs
from piston_cosim.fmu_mfbd.dynamics.parameters import Parameters, PinParameters
from piston_cosim.fmu_mfbd.dynamics.pin_coordinates import PIN
from piston_cosim.fmu_mfbd.dynamics.pin_inertia import inertia, inertia_with_rod
from piston_cosim.fmu_mfbd.dynamics.pin_shells import shell_of
from piston_cosim.fmu_mfbd.dynamics.piston_motion import LATERAL, ROCKING, Load
from piston_cosim.fmu_mfbd.dynamics.slider_crank import CrankMotion
from piston_cosim.fmu_mfbd.dynamics.system import RingForce
from piston_cosim.fmu_mfbd.geometry.pin import (
    PARALLEL,
    ModeMotion,
    PinForces,
    PinResultants,
    ShapeMotion,
    modal_push,
    opening_of,
    pin_surface,
    power_on_grid,
    resultants_on,
    shell_modes,
    slope_push,
    turned,
    yielded,
)
from piston_cosim.fmu_mfbd.reduction.reduced_body import (
    ReducedBlock,
    ReducedBosses,
    ReducedPiston,
)

GRID = (16, 12)
PIN_GRID = (24, 4)
SPEED = 176.0
STEP = np.pi / 180 / SPEED
PARAMETERS = Parameters(
    radial_clearance=50e-6,
    barrel=40e-6,
    ovality=200e-6,
    crank_radius=72e-3,
    rod_length=223e-3,
    crank_offset=2e-3,
    rod_mass=1.7,
    rod_inertia=0.017,
    rod_centre=72e-3,
    pin_mass=0.5,
    pin_radius=18e-3,
    pin_friction_coefficient=0.0,
)
CENTRE = np.array([1.5e-3, 26.5e-3])


def bodies():
    """The rigid piston of data_sheet, its centre of mass off its axis, in its bore."""
    square, none = np.zeros((0, 0)), np.zeros(0)
    piston = ReducedPiston(
        mass=1.39,
        S=1.39 * CENTRE,
        I0=0.003 + 1.39 * float(CENTRE @ CENTRE),
        T=np.zeros((2, 0)),
        b=none,
        B=square,
        g=none,
        G=square,
        omega=none,
        kind=np.zeros(0, dtype=int),
        gas_force=none,
        radial=np.zeros((GRID[0] * GRID[1], 0)),
        axial=np.zeros((GRID[0] * GRID[1], 0)),
        radius=54.95e-3,
        skirt_lower=-45.5e-3,
        skirt_upper=37.3e-3,
        pin_offset=0.0,
    )
    heights = np.linspace(90e-3, 360e-3, 64)
    table = np.zeros((GRID[0], len(heights), 0))
    block = ReducedBlock(none, np.zeros(0, dtype=int), table, table, heights, 55e-3)
    return piston, block


def options(floating):
    return BuildOptions(
        GRID,
        PistonOptions("", 0, 1e-3),
        BlockOptions("", 0),
        floating_pin=FloatingPin(PIN_GRID, 25e-3, 36e-3) if floating else None,
    )


def floating_model(**pin):
    return assemble_floating(*bodies(), options(True), PARAMETERS, PinParameters(**pin))


def tied_model():
    return assemble(*bodies(), options(False), PARAMETERS)


MODES = 3


def yielding_bodies(young=1.0):
    """The same with three modes, no two classes of their matrices alike, and their values in the
    bosses; `young` times as stiff.
    """
    rng = np.random.default_rng(7)
    piston, block = bodies()
    cells = GRID[0] * GRID[1]
    half = rng.standard_normal((2, MODES, MODES))
    piston = dataclasses.replace(
        piston,
        T=0.2 * rng.standard_normal((2, MODES)),
        b=5e-3 * rng.standard_normal(MODES),
        B=0.3 * (half[0] + half[0].T) + np.eye(MODES),
        g=5e-3 * rng.standard_normal(MODES),
        G=0.2 * (half[1] - half[1].T),
        omega=np.sqrt(young) * np.array([2.1e4, 3.3e4, 9e4]),
        kind=np.full(MODES, -1),
        gas_force=rng.standard_normal(MODES),
        radial=rng.standard_normal((cells, MODES)),
        axial=0.3 * rng.standard_normal((cells, MODES)),
    )
    a = 2 * np.pi * np.arange(PIN_GRID[0]) / PIN_GRID[0]
    wave = np.array([np.cos(n * a + p) for n, p in ((2, 0.3), (1, 1.1), (3, -0.4))]).T
    along = 1 + 0.2 * rng.standard_normal((2, PIN_GRID[1], MODES))
    outward = wave[None, :, None, :] * along[:, None]
    onward = 0.4 * np.roll(outward, 3, axis=1)
    stations = np.array([[-1.0], [1.0]]) * np.linspace(0.03, 0.05, PIN_GRID[1])
    return piston, block, ReducedBosses(outward, onward, stations, 18e-3)


def yielding_model(young=1.0, parameters=PARAMETERS):
    piston, block, bosses = yielding_bodies(young)
    return assemble_floating(piston, block, options(True), parameters, PinParameters(), bosses)


def test_film_thickness_and_forces_by_hand():
    """Four cells around, shell turned by 90 deg: its own +x is +y in space. The pin stands 3 um
    above and 1 um left of the shell's axis: 3 um along its +x, 1 um along its +y.
    """
    surface = pin_surface(0.02, 10e-6, (4, 1))
    axes = turned(np.pi / 2)
    place = np.array([-1e-6, 3e-6])
    gap = surface.clearance + opening_of(surface, axes.T @ place)
    np.testing.assert_allclose(gap[:, 0], [7e-6, 9e-6, 13e-6, 11e-6], rtol=1e-12)
    # 5 N on the first cell push against the shell's +x: downwards in space; 2 N of friction there
    # act along its +y, to the left; friction on all four cancels but in its moment
    push = np.zeros((4, 1))
    push[0] = 5.0
    drag = np.full((4, 1), 0.5)
    drag[0] += 2.0
    found = resultants_on(surface, PinForces(push, drag), place, axes)
    np.testing.assert_allclose(found.force, [-2.0, -5.0], atol=1e-15)
    assert found.on_shell == pytest.approx(-0.02 * 4.0, rel=1e-14)
    # lever: d x F = (-1e-6)(-5) - (3e-6)(-2) = 11e-6
    assert found.on_pin == pytest.approx(0.08 - 11e-6, rel=1e-12)


def test_an_instant_by_hand():
    """Crank at 90 deg with constant speed, everything displaced: every row from its own sum."""
    model = floating_model()
    w, r, L = 100.0, 72e-3, 223e-3
    position = np.array([4e-6, 2e-3, 3e-6, -7e-6, 5e-6, 6e-6, 0.4])
    velocity = np.array([0.01, -0.3, 0.002, 0.003, -0.001, 0.004, 12.0])
    acceleration = np.array([50.0, 300.0, 20.0, -30.0, 10.0, 40.0, -500.0])
    now = Motion(position, velocity, acceleration)
    crank = CrankMotion(np.pi / 2, w, 0.0)
    # the eye: 4 + 3 - 5 = 2 um beside its concentric place, which is pin minus crank offset
    xi = 1e-3 - 2e-3 + 2e-6 + r
    f = np.sqrt(L**2 - xi**2)
    f1, f2 = -xi / f, -(L**2) / f**3
    xi_v, xi_a = 0.01 + 0.002 + 0.001, 50.0 + 20.0 - 10.0 - r * w**2
    eye_y = f1 * xi_a + f2 * xi_v**2
    at = place_of(model.bodies, now, crank)
    np.testing.assert_allclose(at.piston, [50.0, eye_y + 40.0 + 30.0], rtol=1e-12)
    np.testing.assert_allclose(at.pin, [70.0, eye_y + 40.0], rtol=1e-12)
    load = Load(lateral=11.0, axial=-900.0, moment=1.5, guided=800.0, modal=np.zeros(0))
    films = PinFilms(
        PinResultants(np.array([30.0, -700.0]), 0.2, -0.3),
        PinResultants(np.array([-40.0, 650.0]), 0.5, -0.6),
    )
    s = 1.39 * turned(2e-3) @ CENTRE
    G = 1.39 * at.piston + 300.0 * np.array([-s[1], s[0]]) - 0.09 * s - [11.0, -900.0]
    K = 0.5 * at.pin
    turn = s[0] * at.piston[1] - s[1] * at.piston[0]
    turn += (0.003 + 1.39 * float(CENTRE @ CENTRE)) * 300.0 - 1.5 - 800.0 * 4e-6
    k = 72.0 / 223.0
    gx = k * 60.0 + (1 - k) * r * w**2
    gy = k * eye_y
    psi2 = -xi / f**3
    rod = k * 1.7 * (gx + f1 * gy) + 0.017 * (-1 / f) * (-xi_a / f + psi2 * xi_v**2)
    N = f1 * (G[1] + K[1]) + rod - (-1 / f) * -0.6
    wanted = [
        G[0] + K[0] + N,
        turn + 0.3,
        K[0] + N - 30.0,
        -G[1] + 700.0,
        -N + 40.0,
        G[1] + K[1] - 650.0,
        0.5 * 0.018**2 / 2 * -500.0 - 0.7,
    ]
    lack = imbalance(model.bodies, load, now, crank, films)
    np.testing.assert_allclose(lack.residual, wanted, rtol=1e-11, atol=1e-10)
    # the crank pin goes down by r dphi, the eye with it and by f1 r cos(phi) = 0 besides
    lifted = -r * (G[1] + K[1])
    rod_moment = 1.7 * (-r) * gy
    assert lack.torque == pytest.approx(lifted + rod_moment, rel=1e-11)


def test_inertia_of_the_play_by_hand():
    """Eq. (D22): with one coordinate alone in motion, and the piston carried along by two."""
    model = floating_model()
    M = inertia(model.bodies)
    assert M[PIN.eye_x, PIN.eye_x] == 0.0
    assert M[PIN.boss_y, PIN.boss_y] == pytest.approx(1.39)
    assert M[PIN.eye_y, PIN.eye_y] == pytest.approx(1.89)
    assert M[LATERAL, LATERAL] == pytest.approx(1.89)
    assert M[PIN.boss_x, PIN.boss_x] == pytest.approx(0.5)
    assert M[LATERAL, ROCKING] == pytest.approx(-1.39 * 26.5e-3)
    assert M[PIN.eye_y, ROCKING] == pytest.approx(1.39 * 1.5e-3)
    assert np.array_equal(M, M.T)


def shells_of(model):
    """Return the shells of all films of pin and crank at the end of the last step."""
    last = model._last
    mechanism = model.bodies.mechanism
    each = range(len(model.pins))
    return [shell_of(mechanism, model.layout, last.now, last.crank, k) for k in each]


def test_the_rod_swings_with_its_eye_by_hand():
    """Eq. (K12) of the eye's way x_A + a_x - e_x: 3 + 4 - 1 m/s here, and nothing of the others."""
    model = floating_model()
    velocity = np.array([3.0, 5.0, 4.0, 2.0, 1.0, 7.0, 9.0])
    more = velocity @ (inertia_with_rod(model.bodies) - inertia(model.bodies)) @ velocity / 2
    rod = (72 / 223) ** 2 * 1.7 + 0.017 / 0.223**2
    assert more == pytest.approx(rod * 6.0**2 / 2, rel=1e-12)


def test_a_shell_that_yields_by_hand():
    """One mode, u_e = 2 cos 2a q on eight cells around: at a = 0 it opens by 2 q, at 90 deg it
    closes by as much; pressure at 45 deg, where the shell falls with slope -4 sin 90 deg q, turns
    the pin. Central differences of cos 2a on eight cells: sin(2 step)/step in place of 2.
    """
    a = np.pi / 4 * np.arange(8)
    modes = shell_modes(2 * np.cos(2 * a)[:, None, None], np.sin(a)[:, None, None])
    surface = pin_surface(0.02, 10e-6, (8, 1), modes)
    q = np.array([3e-6])
    np.testing.assert_allclose(
        yielded(surface, q)[:, 0], [6e-6, 0, -6e-6, 0, 6e-6, 0, -6e-6, 0], atol=1e-20
    )
    push, drag = np.zeros((8, 1)), np.zeros((8, 1))
    push[1], drag[2] = 7.0, 5.0
    forces = PinForces(push, drag)
    np.testing.assert_allclose(slope_push(surface, push), [-7.0 * 2 * 4 / np.pi], rtol=1e-12)
    # pressure stands where the mode has no displacement, friction acts against u_t = sin 90 deg
    np.testing.assert_allclose(modal_push(surface, forces), [-5.0], atol=1e-14)
    none, straight = np.zeros(2), ShapeMotion(PARALLEL, PARALLEL)
    still = power_on_grid(surface, forces, none, none, 30.0, ModeMotion(q, 0 * q), straight)
    turned_by = -7.0 * 2 * 4 / np.pi * 3e-6 * 30.0
    assert still[0] == pytest.approx(turned_by + 5.0 * 0.02 * 30.0, rel=1e-12)
    moving = power_on_grid(surface, forces, none, none, 0.0, ModeMotion(q, q), straight)
    assert moving[0] == pytest.approx(-5.0 * 3e-6, rel=1e-12)


def test_modes_of_a_standing_engine_yield_by_their_springs():
    """Crank at rest, forces that stay, critical damping: each mode ends where its spring holds the
    modal force of gas and of all films, less what the frame's acceleration asks; the bosses open by
    its shape. 400 us damp the start to 0.2 %, what falls meanwhile turns by a per cent.
    """
    critical = dataclasses.replace(PARAMETERS, damping_ratio=1.0, high_frequency_damping_ratio=1.0)
    model = yielding_model(parameters=critical)
    rng = np.random.default_rng(3)
    push = 20 * rng.random(GRID)
    pins = tuple(PinForces(300 * rng.random(PIN_GRID), rng.random(PIN_GRID)) for _ in model.pins)
    at_rest = Inputs(0.0, 2e5, push, 0 * push, pins=pins)
    state, _ = model.start(0.3, 0.0, 0.0, at_rest)
    for _ in range(400):
        state, out = model.advance(state, at_rest, 1e-6)
    piston, _, bosses = yielding_bodies()
    a = state.acceleration
    crank = CrankMotion(0.3, 0.0, 0.0)
    now = Motion(state.position, state.velocity, a)
    frame = place_of(model.bodies, now, crank).frame
    force = np.pi * 55e-3**2 * 2e5 * piston.gas_force - push.ravel() @ piston.radial
    for k in range(2):
        force = force + np.einsum("ij,ijk->k", pins[k].pressure, bosses.boss_outward[k])
        force = force - np.einsum("ij,ijk->k", pins[k].circumferential, bosses.boss_onward[k])
    inertial = frame.ax * piston.T[0] + frame.ay * piston.T[1] + frame.alpha * piston.g
    wanted = (force - inertial) / piston.omega**2
    np.testing.assert_allclose(out["modal_coordinate"], wanted, rtol=2e-2)
    stretched = out["boss_right.film_thickness"] - model.pins[1].clearance
    d = shells_of(model)[1].own_place()
    rigid = opening_of(model.pins[1], d)
    np.testing.assert_allclose(
        stretched - rigid, bosses.boss_outward[1] @ out["modal_coordinate"], atol=1e-15
    )


def test_inertia_of_modes_by_hand():
    """Eq. (D22): a mode alone, with the piston's shift along either axis, and with its turning."""
    model = yielding_model()
    piston, *_ = yielding_bodies()
    M = inertia(model.bodies)
    assert np.array_equal(M, M.T)
    np.testing.assert_allclose(M[7:, 7:], np.eye(MODES))
    np.testing.assert_allclose(M[LATERAL, 7:], piston.T[0])
    np.testing.assert_allclose(M[PIN.boss_y, 7:], -piston.T[1])
    np.testing.assert_allclose(M[PIN.eye_y, 7:], piston.T[1])
    np.testing.assert_allclose(M[ROCKING, 7:], piston.g)


def test_a_stiff_piston_is_the_rigid_one():
    names = ("lateral_displacement", "rocking_angle", "pin_displacement_y", "side_force_demand")
    stiff_is_rigid(floating_model(), yielding_model, names)


def stiff_is_rigid(rigid, yielding, names):
    """Young's modulus times 1e6, 1e9: what modes do falls with it, and nothing else is left."""

    def way(model):
        return np.array([rough_way(model, steps)[1][name] for steps in (2, 6) for name in names])

    known = way(rigid)
    apart = [np.abs(way(yielding(young)) / known - 1).max() for young in (1e6, 1e9)]
    assert apart[1] < 1e-6
    assert apart[1] < 2e-3 * apart[0]


RINGS = RingForce(40.0, -60.0, 0.3)


def random_inputs(model, seed, size=50.0, rings=RINGS, gas=5e5):
    """Rough forces on all films."""
    rng = np.random.default_rng(seed)
    push, drag = size * rng.random(GRID), -0.1 * size * rng.random(GRID)
    pins = tuple(
        PinForces(10 * size * rng.random(PIN_GRID), size * rng.random(PIN_GRID)) for _ in model.pins
    )
    return Inputs(SPEED, gas, push, drag, rings, pins=pins)


def rough_way(model, steps):
    state, out = model.start(0.3, 2e-6, 1e-4, random_inputs(model, 0, 0.0))
    for k in range(steps):
        state, out = model.advance(state, random_inputs(model, k), STEP)
    return state, out


def products_by_differences(model, state, base):
    """All directional derivatives of a step, held against central differences of it. With unit
    changes a step is affine but for what millimetres of play and turning shells bend: 1e-6.
    """
    rng = np.random.default_rng(1)
    to_push, to_drag = rng.standard_normal((2, *GRID))
    to_pins = [PinForces(*rng.standard_normal((2, *one.shape))) for one in model.grids]
    rings = RingForce(0.3, -0.2, 0.005)
    ends = []
    for e in (1.0, -1.0):
        moved = dataclasses.replace(
            base,
            pressure_force=base.pressure_force + e * to_push,
            friction_force=base.friction_force + e * to_drag,
            rings=RingForce(*(np.array(base.rings) + e * np.array(rings))),
            pins=tuple(
                PinForces(*(one + e * to for one, to in zip(force, change)))
                for force, change in zip(base.pins, to_pins)
            ),
        )
        ends.append(model.advance(state, moved, STEP)[1])
    model.advance(state, base, STEP)
    products = model.directional_derivative(to_push, to_drag, rings, pins=tuple(to_pins))
    for name, product in products.items():
        difference = (ends[0][name] - ends[1][name]) / 2
        assert np.abs(product - difference).max() <= 1e-6 * np.abs(difference).max(), name
    return products


@pytest.mark.parametrize("make", [floating_model, yielding_model])
@pytest.mark.parametrize("steps", [1, 6])
def test_derivative_of_all_films_against_differences(steps, make):
    """A step once of backward Euler and once not."""
    model = make()
    state, _ = rough_way(model, steps)
    products = products_by_differences(model, state, random_inputs(model, 50))
    assert {"skirt.film_thickness", "boss_left.circumferential_velocity"} <= products.keys()


@pytest.mark.parametrize("make", [floating_model, yielding_model])
def test_work_of_every_film_is_the_same_on_its_grid_and_in_the_coordinates(make):
    """Eq. (G4) against the resultants, with forces as rough as they come."""
    _, out = rough_way(make(), 5)
    for name in ("skirt", "boss_left", "boss_right", "small_end"):
        assert out[f"{name}.interface_work_error"] <= 1e-13


class Springs:
    """In place of the pin's films: springs on the gap, F = -K d in every shell, and viscous drag
    D W around. In place of the skirt's film: springs on it.
    """

    def __init__(self, stiffness, drag=0.0, skirt=5e7):
        self.per_cell = 2 * stiffness / np.prod(PIN_GRID)
        self.drag = drag / np.prod(PIN_GRID)
        self.skirt = skirt / np.prod(GRID)

    def on_skirt(self, gap):
        return self.skirt * (1e-4 - gap)

    def forces(self, out, model):
        pins = tuple(
            PinForces(
                self.per_cell * (surface.clearance - out[f"{grid.prefix}film_thickness"]),
                -self.drag * out[f"{grid.prefix}circumferential_velocity"],
            )
            for grid, surface in zip(model.grids, model.pins)
        )
        return self.on_skirt(out["skirt.film_thickness"]), pins


def coupled(model, springs, steps, gas=6e5):
    """Outputs of every step with the springs, each solved by Newton's method on the model's own
    derivative, in the directions that springs know.
    """
    push, pins = np.zeros(GRID), [PinForces(np.zeros(PIN_GRID), np.zeros(PIN_GRID))] * 3
    none = np.zeros(GRID)

    def step_with(state, push, pins):
        given = Inputs(SPEED, gas, push, none, pins=tuple(pins))
        return model.advance(state, given, STEP)

    state, out = model.start(0.3, 2e-6, 1e-4, Inputs(SPEED, gas, push, none, pins=tuple(pins)))
    way = []
    e = np.array([model.pins[0].outward[k][:, None] + np.zeros(PIN_GRID) for k in (0, 1)])
    sine = np.sin(model.film_surfaces[0].skirt.angle)[:, None] + np.zeros(GRID)
    height = model.film_surfaces[0].skirt.height[None, :] * sine
    for _ in range(steps):
        for _ in range(12):
            end, out = step_with(state, push, pins)
            wanted_push, wanted_pins = springs.forces(out, model)
            lack = (
                wanted_push - push,
                [p.pressure - q.pressure for p, q in zip(wanted_pins, pins)],
            )
            drags = [p.circumferential for p in wanted_pins]
            # directions of forces on which gaps depend: two of the skirt, two of every shell
            seeds = [(one, [0, 0, 0]) for one in (sine, height)]
            for k in range(3):
                for axis in e:
                    seeds.append((none, [axis if j == k else 0 for j in range(3)]))
            columns = []
            for on_skirt, on_pins in seeds:
                given = tuple(PinForces(one + 0 * e[0], 0 * e[0]) for one in on_pins)
                got = model.directional_derivative(on_skirt, none, pins=given)
                columns.append(
                    np.concatenate(
                        [(on_skirt + springs.skirt * got["skirt.film_thickness"]).ravel()]
                        + [
                            (one + springs.per_cell * got[f"{grid.prefix}film_thickness"]).ravel()
                            for one, grid in zip(on_pins, model.grids)
                        ]
                    )
                )
            right = np.concatenate([lack[0].ravel(), *(one.ravel() for one in lack[1])])
            amounts, *_ = np.linalg.lstsq(np.array(columns).T, right, rcond=None)
            # what of the lack no gap depends on is taken as it is
            rest = right - np.array(columns).T @ amounts
            sizes = np.cumsum([push.size, *[e[0].size] * 2])
            parts = np.split(rest, sizes)
            push = push + parts[0].reshape(GRID)
            pins = [
                PinForces(q.pressure + part.reshape(PIN_GRID), drag)
                for q, part, drag in zip(pins, parts[1:], drags)
            ]
            for amount, (on_skirt, on_pins) in zip(amounts, seeds):
                push = push + amount * on_skirt
                pins = [
                    PinForces(q.pressure + amount * one, q.circumferential)
                    for q, one in zip(pins, on_pins)
                ]
            if np.abs(right).max() <= 1e-9 * np.abs(pins[0].pressure).max():
                break
        state = end
        way.append(out)
    return way


def tied_way(springs, steps, gas=6e5):
    """Likewise of the tied pin."""
    model = tied_model()
    push, none = np.zeros(GRID), np.zeros(GRID)
    state, out = model.start(0.3, 2e-6, 1e-4, Inputs(SPEED, gas, push, none))
    sine = np.sin(model.film_surfaces[0].skirt.angle)[:, None] + np.zeros(GRID)
    height = model.film_surfaces[0].skirt.height[None, :] * sine
    way = []
    for _ in range(steps):
        for _ in range(12):
            end, out = model.advance(state, Inputs(SPEED, gas, push, none), STEP)
            lack = (springs.on_skirt(out["film_thickness"]) - push).ravel()
            columns = []
            for seed in (sine, height):
                got = model.directional_derivative(seed, none)["film_thickness"]
                columns.append((seed + springs.skirt * got).ravel())
            matrix = np.array(columns).T
            (one, two), *_ = np.linalg.lstsq(matrix, lack, rcond=None)
            push = push + (lack - matrix @ [one, two]).reshape(GRID) + one * sine + two * height
            if np.abs(lack).max() <= 1e-10 * np.abs(push).max():
                break
        state = end
        way.append(out)
    return way


def test_the_tied_pin_is_the_limit_of_stiff_films():
    """A pin on springs K in all three shells, without friction, goes to the pin that is tied, at
    the rate 1/K: play under the same force halves with every doubling.
    """
    steps = 25
    tied = tied_way(Springs(1.0), steps)
    apart = []
    for stiffness in (4e9, 8e9, 16e9):
        model = floating_model()
        loose = coupled(model, Springs(stiffness), steps)
        apart.append(
            [
                max(abs(a[name] - b[name]) for a, b in zip(loose, tied))
                / max(abs(b[name]) for b in tied)
                for name in ("lateral_displacement", "rocking_angle", "side_force", "crank_torque")
            ]
        )
    rates = np.array(apart)
    assert rates[-1].max() < 2e-2
    np.testing.assert_allclose(rates[:-1] / rates[1:], 2.0, rtol=0.2)


def test_what_does_not_go_with_a_floating_pin_is_told():
    piston, block = bodies()
    wrong = dataclasses.replace(
        PARAMETERS, crank_free=1, pin_mass=0.0, pin_friction_coefficient=0.05
    )
    told = "\n".join(faults(piston, block, options(True), wrong))
    assert "crank_free: expected 0 with a floating pin, got 1" in told
    assert "pin_mass: expected more than 0 kg with a floating pin, got 0 kg" in told
    assert "pin_friction_coefficient: expected 0 with a floating pin, got 0.05; its films" in told
    assert faults(piston, block, options(True), PARAMETERS) == []
