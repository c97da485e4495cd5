"""What must hold for any motion, any force and any shape."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from piston_cosim.fmu_mfbd.geometry.grid import cell_centres
from piston_cosim.fmu_mfbd.geometry.profile import barrel, ovality
from piston_cosim.fmu_mfbd.mechanism.generalised_alpha import Motion, coefficients
from piston_cosim.fmu_mfbd.mechanism.piston_motion import Load
from piston_cosim.fmu_mfbd.mechanism.slider_crank import CrankMotion, Mechanism, height
from piston_cosim.tests.verification.cases.bodies import rigid_body
from piston_cosim.tests.verification.cases.tied import tied_forces, tied_pin

pytestmark = pytest.mark.slow  # random inputs
small = st.floats(-1e-4, 1e-4)
seeds = st.integers(0, 2**32 - 1)


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
