"""Films of the crank in the rod's big end and in the main bearing: equations against Newton's on
points that move, films and closed forms by hand, the rod without play as the stiff limit.
"""

import dataclasses
import itertools

import numpy as np
import pytest
from pydantic import ValidationError

from piston_cosim.fmu_mfbd.dynamics.assembly import assemble_floating, faults
from piston_cosim.fmu_mfbd.dynamics.build_options import BuildOptions, CrankBearing
from piston_cosim.fmu_mfbd.dynamics.floating_pin import PinFilms, imbalance
from piston_cosim.fmu_mfbd.dynamics.generalised_alpha import Motion
from piston_cosim.fmu_mfbd.dynamics.model import Inputs
from piston_cosim.fmu_mfbd.dynamics.parameters import (
    BigEndParameters,
    MainBearingParameters,
    PinParameters,
)
from piston_cosim.fmu_mfbd.dynamics.pin_inertia import inertia_with_rod
from piston_cosim.fmu_mfbd.dynamics.piston_motion import Load
from piston_cosim.fmu_mfbd.dynamics.slider_crank import CrankMotion
from piston_cosim.fmu_mfbd.dynamics.system import RingForce
from piston_cosim.fmu_mfbd.geometry.pin import PinForces, PinResultants, diameters, opening_of
from piston_cosim.fmu_mfbd.options import Common
from piston_cosim.fmu_mfbd.variables import variables

from .test_floating_pin import (
    CENTRE,
    GRID,
    PARAMETERS,
    SPEED,
    STEP,
    bodies,
    floating_model,
    options,
    products_by_differences,
    shells_of,
    yielding_bodies,
)
from .test_small_end import MODES, small_end

BIG_END = BigEndParameters(big_end_radius=24e-3, big_end_clearance=25e-6)
MAIN = MainBearingParameters(
    main_bearing_radius=27e-3, main_bearing_clearance=30e-6, crank_mass=4.0
)
OWN = {"big_end": BIG_END, "main_bearing": MAIN}
RADII = {"big_end": 24e-3, "main_bearing": 27e-3}
GRIDS = {"big_end": (20, 5), "main_bearing": (16, 4)}
UNBALANCE = -0.12
OFFSET = 1e-3
"""Of the pin from the skirt's axis, as `options` has it."""
SETS = [("big_end",), ("main_bearing",), ("big_end", "main_bearing")]
of_each_set = pytest.mark.parametrize("names", SETS, ids="+".join)


def crank_options(names, modes=0):
    bearings = tuple(CrankBearing(name, GRIDS[name], 30e-3, modes=modes) for name in names)
    return dataclasses.replace(options(True), crank_bearings=bearings)


def crank_model(names=("big_end", "main_bearing"), yielding=False, young=1.0, **changes):
    parameters = dataclasses.replace(PARAMETERS, crank_unbalance=UNBALANCE, **changes)
    piston, block = bodies()
    bosses = eye = None
    shells = {}
    if yielding:
        piston, block, bosses = yielding_bodies()
        eye = small_end()
        shells = {name: small_end(young, GRIDS[name], RADII[name]) for name in names}
    own = {name: OWN[name] for name in names}
    pin = PinParameters()
    built = crank_options(names, MODES if yielding else 0)
    films = dict(crank=own, small_end=eye, crank_shells=shells)
    return assemble_floating(piston, block, built, parameters, pin, bosses, **films)


class Points:
    """The mechanism as points of mass and rods that turn, in space, by all coordinates and the
    angle of the crank: x_A, rocking angle, pin from bosses, pin from eye, angle of the pin, then
    crank pin from big end, journal from main bearing.
    """

    def __init__(self, names):
        self.names = names

    def places(self, q, angle):
        """Of piston (centre), pin, rod (centre) and crank (centre of 4 kg), of all journals from
        their shells' axes; angles of piston, pin, rod.
        """
        p = PARAMETERS
        play = dict(zip(self.names, np.split(q[7:], len(self.names))))
        b, m = (play.get(name, np.zeros(2)) for name in ("big_end", "main_bearing"))
        u = np.array([-np.sin(angle), np.cos(angle)])
        big_end = m + p.crank_radius * u - b
        pin_x = q[0] + q[2] + OFFSET - p.crank_offset
        eye_x = pin_x - q[4]
        rise = np.sqrt(p.rod_length**2 - (eye_x - big_end[0]) ** 2)
        eye = np.array([eye_x, big_end[1] + rise])
        pin = eye + q[4:6]
        A = pin - q[2:4]
        c, s = np.cos(q[1]), np.sin(q[1])
        piston = A + np.array([[c, -s], [s, c]]) @ CENTRE
        along = (eye - big_end) / p.rod_length
        rod = big_end + p.rod_centre * along
        crank = m + UNBALANCE / MAIN.crank_mass * u
        angles = np.array([q[1], q[6], -np.arcsin(along[0])])
        return np.array([piston, pin, rod, crank]), angles

    def inertias(self):
        p = PARAMETERS
        crank = MAIN.crank_mass if "main_bearing" in self.names else 0.0
        return (
            np.array([1.39, p.pin_mass, p.rod_mass, crank]),
            np.array([0.003, p.pin_mass * p.pin_radius**2 / 2, p.rod_inertia]),
        )


def derivative(f, x, h):
    """By central differences of sixth order."""
    weights = {1: 0.75, 2: -0.15, 3: 1 / 60}
    return sum(w * (f(x + k * h) - f(x - k * h)) for k, w in weights.items()) / h


def second_derivative(f, x, h):
    weights = {1: 1.5, 2: -0.15, 3: 1 / 90}
    terms = (w * (f(x + k * h) - 2 * f(x) + f(x - k * h)) for k, w in weights.items())
    return sum(terms) / h**2


def some_motion(names, seed=4):
    """Play of micrometres to millimetres, all of it in motion."""
    rng = np.random.default_rng(seed)
    n = 7 + 2 * len(names)
    return Motion(1e-3 * rng.standard_normal(n), rng.standard_normal(n), 300 * rng.random(n))


@of_each_set
def test_equations_of_motion_against_newtons_law_of_every_body(names):
    """Accelerations of all centres of mass by differences in time, of a motion with given
    derivatives; their inertia forces on every coordinate by virtual work, its directions by
    differences too. Forces of films and gas likewise: where they act, and which way that goes.
    Differences of sixth order leave 1e-9 of the largest term.
    """
    model = crank_model(names)
    points = Points(names)
    now = some_motion(names)
    crank = CrankMotion(0.7, 110.0, 900.0)
    rng = np.random.default_rng(5)
    films = {
        name: PinResultants(3e3 * rng.standard_normal(2), *rng.standard_normal(2))
        for name in ("bosses", "eye", *names)
    }
    load = Load(lateral=110.0, axial=-9e3, moment=1.5, guided=0.0, modal=np.zeros(0))
    of_crank = {name: films[name] for name in names}
    acting = PinFilms(films["bosses"], films["eye"])._replace(**of_crank)
    found = imbalance(model.bodies, load, now, crank, acting)

    def at(t):
        q = now.position + t * now.velocity + t**2 / 2 * now.acceleration
        return points.places(q, crank.angle + t * crank.speed + t**2 / 2 * crank.acceleration)

    linear = second_derivative(lambda t: at(t)[0], 0.0, 2e-4)
    angular = second_derivative(lambda t: at(t)[1], 0.0, 2e-4)
    masses, moments = points.inertias()

    def pulled(k):
        """Inertia, films and load by virtual work along coordinate k, the last one the angle."""
        everything = np.append(now.position, crank.angle)
        way = np.eye(len(everything))[k]

        def along(e):
            moved = everything + e * way
            return points.places(moved[:-1], moved[-1])

        by_place = derivative(lambda e: along(e)[0], 0.0, 1e-3)
        by_angle = derivative(lambda e: along(e)[1], 0.0, 1e-3)
        demand = np.sum(masses[:, None] * linear * by_place) + moments @ (angular * by_angle)
        piston, pin, rod = by_angle
        turn = now.position[1]
        c, s = np.cos(turn), np.sin(turn)
        lever = np.array([[c, -s], [s, c]]) @ CENTRE
        of_A = by_place[0] - piston * np.array([-lever[1], lever[0]])
        given = of_A @ [load.lateral, load.axial] + piston * load.moment
        starts = {"bosses": 2, "eye": 4} | {name: 7 + 2 * j for j, name in enumerate(names)}
        shells = {"bosses": piston, "eye": rod, "big_end": rod, "main_bearing": 0.0}
        drive = float(k == len(now.position))
        journals = {"bosses": pin, "eye": pin, "big_end": drive, "main_bearing": drive}
        for name, film in films.items():
            given += way[starts[name] : starts[name] + 2] @ film.force
            given += film.on_pin * journals[name] + film.on_shell * shells[name]
        return demand - given

    wanted = np.array([pulled(k) for k in range(len(now.position) + 1)])
    scale = np.abs(found.residual).max()
    np.testing.assert_allclose(found.residual, wanted[:-1], atol=1e-9 * scale)
    # m e^2 w' of the unbalance about the journal is part of `crank_inertia`
    own = UNBALANCE**2 / MAIN.crank_mass * crank.acceleration * ("main_bearing" in names)
    assert found.torque == pytest.approx(wanted[-1] - own, rel=1e-8)


@of_each_set
def test_inertia_of_an_upright_rod_by_hand(names):
    """Eqs. (D22), (D35): rod and crank upright, all of the bodies' energy of a motion."""
    model = crank_model(names)
    v = np.arange(1.0, 8.0 + 2 * len(names))
    play = dict(zip(names, np.split(v[7:], len(names))))
    b, m = (play.get(name, np.zeros(2)) for name in ("big_end", "main_bearing"))
    big_end = m - b
    eye = np.array([v[0] + v[2] - v[4], big_end[1]])
    pin = eye + v[4:6]
    A = pin - v[2:4]
    piston = A + v[1] * np.array([-CENTRE[1], CENTRE[0]])
    k = 72 / 223
    rod = (1 - k) * big_end + k * eye
    turn = (big_end[0] - eye[0]) / 0.223
    energy = 1.39 * piston @ piston + 0.003 * v[1] ** 2 + 0.5 * pin @ pin
    energy += 0.5 * 0.018**2 / 2 * v[6] ** 2 + 1.7 * rod @ rod + 0.017 * turn**2 + 4.0 * m @ m
    M = inertia_with_rod(model.bodies)
    assert v @ M @ v == pytest.approx(energy, rel=1e-12)
    np.testing.assert_allclose(M, M.T, rtol=1e-15)


def forces_on(model, seed, size):
    rng = np.random.default_rng(seed)
    return tuple(
        PinForces(10 * size * rng.random(one.shape), size * rng.random(one.shape))
        for one in model.grids
    )


def rough_inputs(model, seed, size=50.0, speed=SPEED):
    rng = np.random.default_rng(seed)
    push, drag = size * rng.random(GRID), -0.1 * size * rng.random(GRID)
    rings = RingForce(40.0, -60.0, 0.3)
    return Inputs(speed, 5e5, push, drag, rings, pins=forces_on(model, seed + 100, size))


def rough_way(model, steps):
    state, out = model.start(0.3, 2e-6, 1e-4, rough_inputs(model, 0, 0.0))
    for k in range(steps):
        state, out = model.advance(state, rough_inputs(model, k, speed=SPEED + k), STEP)
    return state, out


@pytest.mark.parametrize("yielding", [False, True])
@pytest.mark.parametrize("steps", [1, 6])
@of_each_set
def test_derivative_of_all_films_against_differences(names, steps, yielding):
    """As of a crank without films."""
    model = crank_model(names, yielding)
    state, _ = rough_way(model, steps)
    products = products_by_differences(model, state, rough_inputs(model, 50))
    assert {f"{name}.film_thickness" for name in names} <= products.keys()


@pytest.mark.parametrize("yielding", [False, True])
@of_each_set
def test_work_of_every_film_is_the_same_on_its_grid_and_in_the_coordinates(names, yielding):
    """Eq. (G4) against the resultants, with forces as rough as they come."""
    _, out = rough_way(crank_model(names, yielding), 5)
    for name in ("skirt", "boss_left", "boss_right", "small_end", *names):
        assert out[f"{name}.interface_work_error"] <= 1e-13


def test_shells_of_the_crank_yield_by_their_springs_and_open_their_films():
    """Crank at rest, steady forces, critical damping, as of the eye: the gap opens by the
    deflection that each modal force gives its spring. 400 us leave 1 % of the slowest mode.
    """
    critical = dict(damping_ratio=1.0, high_frequency_damping_ratio=1.0)
    model = crank_model(yielding=True, **critical)
    inputs = dataclasses.replace(rough_inputs(model, 3), crank_speed=0.0)
    state, _ = model.start(0.3, 0.0, 0.0, inputs)
    for _ in range(400):
        state, out = model.advance(state, inputs, 1e-6)
    for k, name in enumerate(OWN, 3):
        shell = small_end(1.0, GRIDS[name], RADII[name])
        force = np.einsum("ij,ijk->k", inputs.pins[k].pressure, shell.outward)
        force = force - np.einsum("ij,ijk->k", inputs.pins[k].circumferential, shell.onward)
        opened = shell.outward @ (force / shell.omega**2)
        surface, own = model.pins[k], shells_of(model)[k]
        more = out[f"{name}.film_thickness"] - surface.clearance
        more = more - opening_of(surface, own.own_place())
        np.testing.assert_allclose(more, opened, atol=2e-2 * np.abs(opened).max())
        ways = ("across", "along") if name == "big_end" else ("x", "y")
        shown = [out[f"{name}_widening_{way}"] for way in ways]
        np.testing.assert_allclose(shown, diameters(more), atol=1e-12)


def test_stiff_shells_of_the_crank_are_rigid_ones():
    """The rest is the millionth of what the softer shells give."""
    rigid = rough_way(crank_model(yielding=True, young=1e12), 6)[1]
    ends = [rough_way(crank_model(yielding=True, young=young), 6)[1] for young in (1.0, 1e6)]
    for name in OWN:
        gap = f"{name}.film_thickness"
        soft, stiff = (out[gap] - rigid[gap] for out in ends)
        assert np.abs(stiff).max() < 1e-5 * np.abs(soft).max()


def test_gaps_and_velocities_by_hand():
    """The crank pin 3 um right of and 4 um above the rod's big end, the journal 5 um left of and
    2 um below the main bearing's middle, the rod askew; the rod's shell turns with it, so what lies
    opposite of +x in it does so at the rod's angle.
    """
    model = crank_model()
    state, _ = model.start(0.9, 0.0, 0.0, rough_inputs(model, 0, 0.0))
    position = state.position.copy()
    position[7:] = [3e-6, 4e-6, -5e-6, -2e-6]
    _, out = model.start_moving(0.9, position, state.velocity, rough_inputs(model, 0, 0.0))
    p = PARAMETERS
    # eye minus big end: both displacements go into the rod's angle, 8 um of 223 mm
    aside = OFFSET - p.crank_offset + p.crank_radius * np.sin(0.9) + 3e-6 + 5e-6
    psi = -np.arcsin(aside / p.rod_length)
    around = 2 * np.pi * np.arange(20) / 20
    wanted = 25e-6 - 3e-6 * np.cos(around + psi) - 4e-6 * np.sin(around + psi)
    np.testing.assert_allclose(out["big_end.film_thickness"][:, 2], wanted, atol=1e-17)
    rod_speed = -p.crank_radius * np.cos(0.9) * SPEED / np.sqrt(p.rod_length**2 - aside**2)
    np.testing.assert_allclose(
        out["big_end.circumferential_velocity"], 24e-3 * (SPEED - rod_speed), rtol=1e-12
    )
    around = 2 * np.pi * np.arange(16) / 16
    wanted = 30e-6 + 5e-6 * np.cos(around) + 2e-6 * np.sin(around)
    np.testing.assert_allclose(out["main_bearing.film_thickness"][:, 1], wanted, atol=1e-17)
    np.testing.assert_allclose(
        out["main_bearing.circumferential_velocity"], 27e-3 * SPEED, rtol=1e-14
    )
    for one in ("big_end", "main_bearing"):
        assert np.all(out[f"{one}.sliding_velocity"] == 0.0)
    shown = [out[f"{one}_displacement_{way}"] for one in OWN for way in "xy"]
    assert shown == [3e-6, 4e-6, -5e-6, -2e-6]


@of_each_set
def test_what_drive_and_films_do_is_what_the_bodies_hold(names):
    """Forces that stay in all films, all play in motion: the energy of the points changes by the
    drive's work and what the model tells of the films'. Backward Euler on play errs by its first
    order: half the step, half of what is lost.
    """
    model = crank_model(names)
    points = Points(names)
    masses, moments = points.inertias()
    rng = np.random.default_rng(8)
    n = 7 + 2 * len(names)
    position = 1e-4 * rng.standard_normal(n)
    velocity = 0.05 * rng.standard_normal(n)
    given = dataclasses.replace(
        rough_inputs(model, 3, 20.0), gas_pressure=0.0, rings=RingForce(0.0, 0.0, 0.0)
    )

    def energy(state):
        def at(t):
            q = state.position + t * state.velocity
            return points.places(q, state.crank_angle + t * SPEED)

        linear = derivative(lambda t: at(t)[0], 0.0, 1e-4)
        angular = derivative(lambda t: at(t)[1], 0.0, 1e-4)
        return (np.sum(masses[:, None] * linear**2) + moments @ angular**2) / 2

    def lost(steps):
        state, out = model.start_moving(0.4, position, velocity, given)
        before, work, size = energy(state), 0.0, 0.0
        step = 1e-3 / steps
        for _ in range(steps):
            first = out["crank_torque"]
            state, out = model.advance(state, given, step)
            work += step * SPEED * (first + out["crank_torque"]) / 2 + out["film_work"]
            size += abs(out["film_work"])
        return energy(state) - before - work, size

    (coarse, size), (fine, _) = lost(256), lost(512)
    assert abs(fine) < 1e-3 * size
    assert coarse / fine == pytest.approx(2.0, rel=0.1)


class Bushes:
    """Springs in place of all films: F = -K d in every shell, and on the skirt. Each film's force
    is found by Newton's method on the model's own derivative, in the directions springs know.
    """

    def __init__(self, model, stiffness, skirt=5e7):
        self.model = model
        self.per_cell = [2 * stiffness / np.prod(one.shape) for one in model.grids]
        self.skirt = skirt / np.prod(GRID)
        film = model.film_surfaces[0].skirt
        sine = np.sin(film.angle)[:, None] + np.zeros(GRID)
        none = [np.zeros(one.shape) for one in model.grids]
        self.seeds = [(sine, none), (film.height[None, :] * sine, none)]
        for k, surface in enumerate(model.pins):
            for axis in surface.outward:
                here = [one.copy() for one in none]
                here[k] += axis[:, None]
                self.seeds.append((0 * sine, here))

    def lacking(self, out, amounts):
        push, pins = self.forces(amounts)
        gaps = [out[f"{one.prefix}film_thickness"] for one in self.model.grids]
        parts = [self.skirt * (1e-4 - out["skirt.film_thickness"]) - push]
        sizes = zip(self.per_cell, self.model.pins, gaps, pins)
        parts += [c * (surface.clearance - gap) - one for c, surface, gap, one in sizes]
        return parts

    def forces(self, amounts):
        base = np.full(GRID, self.skirt * 5e-5)
        push = base + sum(a * one for a, (one, _) in zip(amounts, self.seeds))
        pins = [np.zeros(one.shape) for one in self.model.grids]
        for amount, (_, parts) in zip(amounts, self.seeds):
            pins = [one + amount * part for one, part in zip(pins, parts)]
        return push, pins

    def projected(self, parts):
        """By the directions, which are orthogonal but for the skirt's two."""
        out = []
        for on_skirt, on_pins in self.seeds:
            pairs = zip(parts, [on_skirt, *on_pins])
            out.append(sum(np.sum(a * b) for a, b in pairs))
        return np.array(out)

    def given(self, amounts, gas, speed):
        push, pins = self.forces(amounts)
        films = tuple(PinForces(one, 0 * one) for one in pins)
        return Inputs(speed, gas, push, np.zeros(GRID), pins=films)

    def run(self, steps, gas, speed=SPEED, angle=0.3):
        model = self.model
        amounts = np.zeros(len(self.seeds))
        state, out = model.start(angle, 2e-6, 1e-4, self.given(amounts, gas, speed))
        way = []
        for _ in range(steps):
            for _ in range(10):
                end, out = model.advance(state, self.given(amounts, gas, speed), STEP)
                lack = self.projected(self.lacking(out, amounts))
                columns = []
                for seed in self.seeds:
                    films = tuple(PinForces(one, 0 * one) for one in seed[1])
                    got = model.directional_derivative(seed[0], 0 * seed[0], pins=films)
                    parts = [seed[0] + self.skirt * got["skirt.film_thickness"]]
                    for c, grid, one in zip(self.per_cell, model.grids, seed[1]):
                        parts.append(one + c * got[f"{grid.prefix}film_thickness"])
                    columns.append(self.projected(parts))
                change = np.linalg.solve(np.array(columns).T, lack)
                amounts = amounts + change
                if np.abs(change).max() <= 1e-9 * np.abs(amounts).max():
                    break
            state = end
            way.append(out)
        return way


@of_each_set
def test_a_crank_without_play_is_the_limit_of_stiff_films(names):
    """Springs K in the crank's films as in the pin's, against the same without play at the crank:
    apart by what the springs give, which halves with every doubling.
    """
    steps = 8
    compared = ("lateral_displacement", "rocking_angle", "side_force", "crank_torque")
    apart = []
    for stiffness in (64e9, 128e9, 256e9):
        fixed = Bushes(floating_model(), stiffness).run(steps, 6e5)
        loose = Bushes(crank_model(names), stiffness).run(steps, 6e5)
        apart.append(
            [
                max(abs(a[name] - b[name]) for a, b in zip(loose, fixed))
                / max(abs(b[name]) for b in fixed)
                for name in compared
            ]
        )
    rates = np.array(apart)
    assert rates[-1].max() < 2e-2
    np.testing.assert_allclose(rates[:-1] / rates[1:], 2.0, rtol=0.2)


def test_loads_of_a_rigid_slider_crank_in_closed_form():
    """What the stiff films carry beside the closed form of a slider-crank without play: the big end
    all of gas and of the inertia of piston, pin and rod, whose mass counts by its two places and
    by a couple (the rod is no two points), the main bearing the crank's unbalance besides. Springs
    of 2e12 N/m: 10 kN move them by 5 nm.
    """
    skirt = 5e9
    model = crank_model(crank_offset=OFFSET)
    gas, steps = 3e6, 14
    way = Bushes(model, 2e12, skirt).run(steps, gas)
    p = PARAMETERS
    r, L, w = p.crank_radius, p.rod_length, SPEED
    area = np.pi * 55e-3**2
    k = p.rod_centre / L
    for out in way[10:]:
        phi = out["crank_angle"]
        xi = r * np.sin(phi)
        f = np.sqrt(L**2 - xi**2)
        xi1, xi2 = r * w * np.cos(phi), -r * w**2 * np.sin(phi)
        rise = -r * w**2 * np.cos(phi) - (xi * xi2 + xi1**2) / f - (xi * xi1) ** 2 / f**3
        pin = np.array([r * w**2 * np.sin(phi), -r * w**2 * np.cos(phi)])
        centre = (1 - k) * pin + k * np.array([0.0, rise])
        turn = -xi2 / f - xi * xi1**2 / f**3
        along = np.array([xi, f])  # from the big end to the eye
        down = -area * gas - (1.39 + p.pin_mass) * rise  # of the pin on the rod
        # about the rod's centre: its couple is that of both ends' forces
        half = (1 - k) * along
        eye_to = half[0] * down
        big_y = p.rod_mass * centre[1] - down
        back = -k * along
        #  J psi'' = half x (E_x, down) + back x (B_x, B_y),  E_x + B_x = m G_x
        couple = p.rod_inertia * turn - eye_to - back[0] * big_y
        matrix = np.array([[-half[1], -back[1]], [1.0, 1.0]])
        _, big_x = np.linalg.solve(matrix, [couple, p.rod_mass * centre[0]])
        on_rod = np.array([big_x, big_y])
        shown = [out["big_end_force_x"], out["big_end_force_y"]]
        np.testing.assert_allclose(shown, on_rod, atol=2e-3 * float(np.linalg.norm(on_rod)))
        thrown = -UNBALANCE * w**2 * np.array([-np.sin(phi), np.cos(phi)])
        on_block = -on_rod - thrown
        shown = [out["main_bearing_force_x"], out["main_bearing_force_y"]]
        np.testing.assert_allclose(shown, on_block, atol=2e-3 * float(np.linalg.norm(on_block)))


def test_a_picometre_of_play_keeps_its_digits():
    """The crank pin moves by a picometre in the big end: the gap by as much, to six digits."""
    model = crank_model()
    state, _ = model.start(0.9, 0.0, 0.0, rough_inputs(model, 0, 0.0))
    gaps = []
    for more in (0.0, 1e-12):
        position = state.position.copy()
        position[7:9] = [20e-6 + more, 0.0]
        _, out = model.start_moving(0.9, position, state.velocity, rough_inputs(model, 0, 0.0))
        gaps.append(out["big_end.film_thickness"])
    change = gaps[1] - gaps[0]
    assert np.abs(change).max() == pytest.approx(1e-12, rel=0.05)
    wanted = np.array([np.max(np.abs(change @ np.ones(5))) / 5])
    assert wanted == pytest.approx(np.abs(change).max(), rel=1e-6)


def test_friction_of_the_crank_by_hand():
    """Half a newton a cell against the turning of crank pin and journal: it drives the shells."""
    model = crank_model()
    inputs = rough_inputs(model, 0, 0.0)
    drags = {f"{name}.": -0.5 for name in OWN}
    pins = tuple(
        PinForces(np.zeros(one.shape), np.full(one.shape, drags.get(one.prefix, 0.0)))
        for one in model.grids
    )
    _, out = model.start(0.9, 0.0, 0.0, dataclasses.replace(inputs, pins=pins))
    shown = [out[f"{name}_friction_moment"] for name in OWN]
    assert shown == pytest.approx([24e-3 * 100 * 0.5, 27e-3 * 64 * 0.5], rel=1e-12)


def test_what_does_not_go_with_films_of_the_crank_is_told():
    piston, block = bodies()
    wrong = dataclasses.replace(PARAMETERS, rod_mass=0.0, rod_inertia=0.0)
    told = "\n".join(faults(piston, block, crank_options(("big_end",)), wrong))
    assert "rod_mass: expected more than 0 kg with a film in big_end, got 0 kg" in told
    assert "rod_inertia: expected more than 0 kg.m2 with a film in big_end, got 0 kg.m2" in told
    assert faults(piston, block, crank_options(SETS[-1]), PARAMETERS) == []
    beside = {"big_end": 25e-3, "main_bearing": 27.1e-3}
    (told,) = faults(
        piston, block, crank_options(SETS[-1]), PARAMETERS, shell_radii=beside, crank=OWN
    )
    assert told == "big_end_radius: expected within 2 % of the shell, 25 mm, got 24 mm"
    wanted = "floating_pin: expected a table with big_end, main_bearing, got nothing"
    with pytest.raises(ValidationError, match=wanted):
        Common.model_validate(dict.fromkeys(OWN, {"length": "30 mm"}))
    with pytest.raises(
        ValidationError, match=r"film_surfaces\.0\.name: expected a new name, got 'big_end'"
    ):
        Common.model_validate(
            {
                "floating_pin": {"boss_length": "20 mm", "small_end_length": "20 mm"},
                "big_end": {"length": "30 mm"},
                "film_surfaces": [{"name": "big_end", "rows": (1, 10)}],
            }
        )


@of_each_set
def test_options_come_back_from_json_and_every_output_is_declared(names):
    built = crank_options(names)
    assert BuildOptions.from_json(built.to_json()) == built
    assert "crank_bearings" not in options(True).to_json()
    declared = {one.name for one in variables(built)}
    _, out = rough_way(crank_model(names), 1)
    assert set(out) <= declared
    for name, what in itertools.product(names, ("radius", "clearance")):
        assert f"{name}_{what}" in declared
    assert ("crank_mass" in declared) == ("main_bearing" in names)
