"""What must hold for any motion, any force and any shape."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from piston_cosim.fmu_mfbd.geometry.film import (
    NodalForces,
    Skirt,
    bore_splines,
    film_now,
    generalised,
    opening,
    sliding,
    window_at,
)
from piston_cosim.fmu_mfbd.geometry.grid import cell_centres
from piston_cosim.fmu_mfbd.geometry.modal_field import modal_field
from piston_cosim.fmu_mfbd.geometry.profile import barrel, ovality
from piston_cosim.fmu_mfbd.mechanism.generalised_alpha import Motion, coefficients
from piston_cosim.fmu_mfbd.mechanism.piston_motion import Load
from piston_cosim.fmu_mfbd.mechanism.slider_crank import CrankMotion, Mechanism, height
from piston_cosim.tests.verification.cases.bodies import rigid_body
from piston_cosim.tests.verification.cases.tied import tied_forces, tied_pin

pytestmark = pytest.mark.slow  # random inputs
small = st.floats(-1e-4, 1e-4)
seeds = st.integers(0, 2**32 - 1)


def film(seed):
    """Return a skirt and a bore with random modes, and the window at a random height."""
    rng = np.random.default_rng(seed)
    angle, rows = cell_centres(8, 5, -0.01, 0.008)
    skirt = Skirt(
        angle,
        rows,
        np.full((8, 5), 2e-5),
        0.028,
        1e-3,
        *(modal_field(rng.standard_normal((8, 5, 3))) for _ in range(2)),
        np.arange(8.0),
    )
    bore = bore_splines(
        np.linspace(0.0, 0.1, 12),
        *rng.standard_normal((2, 8, 12, 2)),
        shape=1e-5 * rng.standard_normal((8, 12)),
    )
    return rng, skirt, bore, window_at(bore.lowest, bore.spacing, rng.uniform(0.02, 0.08), rows)


@settings(max_examples=40, deadline=None)
@given(seeds)
def test_virtual_work_for_any_force_and_motion(seed):
    """sum F dh + sum f dv = Q . dq for every direction dq."""
    rng, skirt, bore, window = film(seed)
    push, drag = rng.standard_normal((2, 8, 5))
    x, turn, climb = rng.standard_normal(3)
    q, p = rng.standard_normal(3), rng.standard_normal(2)
    Q = generalised(skirt, bore, window, NodalForces(push, drag))
    # pressure works on x, angle and modes; friction on climb, angle and modes
    grid = np.sum(push * opening(skirt, bore, window, x, turn, q, p)) + np.sum(
        drag * sliding(skirt, bore, window, climb, turn, q, p)
    )
    own = Q.axial * climb + Q.push @ [x, turn, *q, *p]
    assert abs(grid - own) <= 1e-12 * (np.abs(push).sum() + np.abs(drag).sum()) * 10


@settings(max_examples=30, deadline=None)
@given(seeds)
def test_film_rate_is_the_derivative_of_the_film(seed):
    """Power of a unit pressure force equals the difference of film thickness along the motion.

    The motion of the skirt and an uneven bore are included.
    """
    rng, skirt, bore, _ = film(seed)
    position = 1e-5 * rng.standard_normal(7)
    velocity = 1e-2 * rng.standard_normal(7)
    A = 0.05
    climb = 3.0
    nothing, unit = np.zeros((8, 5)), np.zeros((8, 5))
    unit[rng.integers(8), rng.integers(5)] = 1.0

    def at(t):
        window = window_at(bore.lowest, bore.spacing, A + climb * t, skirt.height)
        forces = NodalForces(unit, nothing)
        now = position + velocity * t
        return film_now(skirt, bore, window, forces, climb, climb, now, velocity)

    dt = 1e-7
    difference = np.sum((at(dt).film_thickness - at(-dt).film_thickness) * unit) / (2 * dt)
    assert abs(at(0.0).power - difference) <= 1e-6 * max(abs(difference), 1e-3)


@settings(max_examples=50, deadline=None)
@given(small, st.floats(-20, 20))
def test_the_rod_keeps_its_length(lateral, crank_angle):
    mechanism = Mechanism(0.025, 0.1, 1e-3, 0.1, 1e-4, 0.3, 0.0)
    Y = height(mechanism, lateral, crank_angle).height
    pin = -0.025 * np.sin(crank_angle), 0.025 * np.cos(crank_angle)
    assert np.isclose(np.hypot(1e-3 + lateral - pin[0], Y - pin[1]), 0.1, rtol=1e-14)


@settings(max_examples=50, deadline=None)
@given(st.floats(0, 6.28), st.floats(10, 1000))
def test_torque_of_a_guided_piston_averages_to_nothing(angle, speed):
    """Without offsets, torque(phi) + torque(-phi) = 0.

    Inertia alone returns in one half turn the work that it took in the other.
    """
    mechanism = Mechanism(0.025, 0.1, 0.0, 0.2, 2e-4, 0.3, 0.1)
    nothing = Load(0.0, 0.0, 0.0, 0.0, np.zeros(0))
    still = Motion(np.zeros(2), np.zeros(2), np.zeros(2))
    chain = tied_pin(rigid_body(0.3, (0.0, 0.01), 2e-4), mechanism, 0.0)
    there, back = (
        tied_forces(chain, nothing, still, CrankMotion(phi, speed, 0.0)).torque
        for phi in (angle, -angle)
    )
    assert abs(there + back) <= 1e-12 * 0.6 * 0.025**2 * speed**2


@settings(max_examples=50, deadline=None)
@given(st.floats(0, 1), st.floats(1e-7, 1e-2))
def test_generalised_alpha_is_of_second_order_for_any_damping(rho, step):
    c = coefficients(step, rho)
    assert (
        np.isclose(c.gamma, 0.5 - c.alpha_m + c.alpha_f)
        and c.alpha_m <= c.alpha_f + 1e-15 <= 0.5 + 1e-14
    )
    assert c.beta >= 0.25 + (c.alpha_f - c.alpha_m) / 2 - 1e-12


@settings(max_examples=50, deadline=None)
@given(st.floats(0, 1e-3), st.floats(0, 1e-3))
def test_profiles_only_take_away(drop, difference):
    angle, rows = cell_centres(24, 10, -0.01, 0.012)
    gap = barrel(rows, -0.01, 0.012, drop) + ovality(angle, difference)[:, None]
    assert gap.min() >= 0 and gap.max() <= drop + difference / 2 + 1e-18
