"""The one system of equations that the coupled FMUs are compared with (`monolithic`), against
closed forms, and the quick figures of `piston-cosim verify coupled`.
"""

import numpy as np
import pytest

from piston_cosim.fmu_ehd.laws.asperity import gaussian_integral
from piston_cosim.tests.verification.cases import coupled
from piston_cosim.tests.verification.cases.mixed_film import height_integral
from piston_cosim.tests.verification.cases.monolithic import (
    NO_FORCE,
    PRESSURE_SCALE,
    Bodies,
    Engine,
    FilmForce,
    Monolithic,
    conductance,
)

slow = pytest.mark.slow
ENGINE = Engine(
    grid=(24, 16),
    bore_radius=40e-3,
    skirt_lower=-20e-3,
    skirt_upper=28e-3,
    radial_clearance=30e-6,
    barrel=0.0,
    ovality=0.0,
    viscosity=10e-3,
    crank_radius=43e-3,
    rod_length=143e-3,
    crank_offset=3e-3,
    pin_offset=-1e-3,
    rod_mass=0.5,
    rod_inertia=2e-3,
    rod_centre=50e-3,
    pin_mass=0.1,
    piston_mass=0.4,
    piston_inertia=5e-4,
    piston_centre=np.array([1.5e-3, 12e-3]),
    crank_speed=300.0,
)


def kinetic_energy(motion, angle):
    """Of piston, pin and rod, from positions differentiated numerically in the crank angle."""
    e = ENGINE
    x, tilt, x_rate, tilt_rate = motion
    bodies = Bodies(e)
    height, rate = bodies.height(angle, x, x_rate)
    pin, pin_rate, _ = bodies.crank_pin(angle)
    a = np.array([e.pin_offset + x, height])
    a_rate = np.array([x_rate, rate])
    turn = np.array([[np.cos(tilt), -np.sin(tilt)], [np.sin(tilt), np.cos(tilt)]])
    centre = turn @ e.piston_centre
    centre_rate = a_rate + tilt_rate * np.array([-centre[1], centre[0]])
    k = e.rod_centre / e.rod_length
    rod_rate = (1 - k) * pin_rate + k * a_rate
    along, along_rate = a - pin, a_rate - pin_rate
    turning = (along[0] * along_rate[1] - along[1] * along_rate[0]) / e.rod_length**2
    about_centre = e.piston_inertia - e.piston_mass * e.piston_centre @ e.piston_centre
    return (
        e.piston_mass * centre_rate @ centre_rate
        + about_centre * tilt_rate**2
        + e.pin_mass * a_rate @ a_rate
        + e.rod_mass * rod_rate @ rod_rate
        + e.rod_inertia * turning**2
    ) / 2


def test_newton_euler_is_lagranges_equation():
    # d/dt dT/dq' - dT/dq = Q for q = x_A and tilt, the crank given; T by the velocities alone
    bodies = Bodies(ENGINE)
    motion = np.array([40e-6, 3e-4, 0.2, -5.0])
    angle = 1.1
    force = FilmForce(700.0, 0.0, 4.0)
    x_rate, tilt_rate = bodies.accelerations(angle, motion, force)[:2]
    step = 1e-4

    def slope(index, motion, angle):
        change = np.zeros(4)
        change[index] = step
        up = kinetic_energy(motion + change, angle)
        return (up - kinetic_energy(motion - change, angle)) / (2 * step)

    dt = 1e-7
    ahead = motion + dt * np.array([motion[2], motion[3], x_rate, tilt_rate])
    behind = motion - dt * np.array([motion[2], motion[3], x_rate, tilt_rate])
    for index, load in ((0, force.lateral), (1, force.moment)):
        momentum_rate = (
            slope(index + 2, ahead, angle + dt * ENGINE.crank_speed)
            - slope(index + 2, behind, angle - dt * ENGINE.crank_speed)
        ) / (2 * dt)
        # differences of differences: six digits of terms of some 1e3 N and 1e1 N m
        assert momentum_rate - slope(index, motion, angle) == pytest.approx(load, rel=2e-3)


def test_pin_point_accelerates_upwards_as_the_rod_tells_it():
    bodies = Bodies(ENGINE)
    motion = np.array([0.0, 0.0, 0.3, 0.0])
    across, _, up = bodies.accelerations(0.7, motion, NO_FORCE)
    t = 1e-5
    heights = [
        bodies.height(0.7 + s * ENGINE.crank_speed, 0.3 * s + across * s**2 / 2, 0.0)[0]
        for s in (-t, 0.0, t)
    ]
    assert np.diff(heights, 2)[0] / t**2 == pytest.approx(up, rel=1e-5)  # t^2 of the difference


def test_oil_that_shears_between_cylinders_drags_by_petroff():
    film = Monolithic(ENGINE)
    cells = np.ones(len(film.gap))
    force = film.force(0 * cells, cells, film.gap, 7.0)
    area = 2 * np.pi * 40e-3 * 48e-3
    assert force.axial == pytest.approx(-10e-3 * 7.0 / 30e-6 * area)
    assert force.lateral == 0.0
    # the drag acts on the skirt's axis, 1 mm to the thrust side of A
    assert force.moment == pytest.approx(1e-3 * force.axial)


def test_pressure_on_the_thrust_side_pushes_and_turns():
    film = Monolithic(ENGINE)
    pressure = PRESSURE_SCALE * np.maximum(film.sine, 0) * (film.height > 20e-3)
    force = film.force(pressure, np.ones(24 * 16), np.full(24 * 16, 1e-9), 0.0)
    rows = np.unique(film.height[film.height > 20e-3])
    per_height = PRESSURE_SCALE * np.pi / 2 * 40e-3  # integral of sin^2 over half a turn
    assert force.lateral == pytest.approx(-per_height * len(rows) * film.dy, rel=1e-3)
    assert force.moment == pytest.approx(-force.lateral * rows.mean(), rel=1e-3)


def test_squeezed_disc_of_a_skirt_carries_what_the_series_says():
    # a short, concentric skirt whose bore shrinks is a strip squeezed between its edges:
    # p = 6 mu w (l^2 - y^2)/h^3 for h falling at w; here w by a position at x that moves
    film = Monolithic(ENGINE)
    h = film.gap
    y = film.height - 4e-3
    exact = 6 * ENGINE.viscosity * 1e-3 * ((24e-3) ** 2 - y**2) / h**3
    s = film.faces

    flow = -conductance(s, h, ENGINE.viscosity).value * (s.gradient @ exact)
    out = s.outflow @ flow
    # second order but for the half cells at the edges
    inner = np.ones((24, 16), bool)
    inner[:, [0, -1]] = False
    assert out.reshape(24, 16)[inner] == pytest.approx(1e-3 * film.area, rel=1e-9)


def test_heights_of_asperities_agree_with_the_parabolic_cylinder_function():
    separation = np.linspace(0, 4, 9)
    # both evaluate the same integral to round-off, which the tail shows relative to F(0)
    assert height_integral(2.5, separation) == pytest.approx(
        gaussian_integral(2.5, separation), abs=1e-13
    )


@pytest.mark.parametrize("span", [coupled.IMPACT, pytest.param(coupled.FIRST_TURN, marks=slow)])
def test_figures_of_the_motored_engine(span):
    assert [str(check) for check in coupled.motored(42, span) if not check.passed] == []


def test_figures_of_the_fired_engine():
    assert [str(check) for check in coupled.fired_checks() if not check.passed] == []


def failed(change):
    """Quantities of the fired engine whose checks fail if parameters of the film are wrong."""
    return {check.quantity for check in coupled.fired_checks(change) if not check.passed}


def test_errors_of_five_percent_in_boundary_friction_and_layer_are_seen():
    wrong = {
        "boundary_friction_coefficient": "0.126",
        "oil_ring_layer": "2.1 um",
        "initial_oil_layer": "3.15 um",
    }
    assert failed(wrong) == {
        "friction_force_asperity, scale of the curve [-]",
        "oil_in_film, scale of the curve [-]",
    }
