"""Numbers by hand of single parts of the bodies: frame, rod, splines, gas, elements."""

from types import SimpleNamespace

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.dynamics.gas_on_bore import WallPressures, bore_wall
from piston_cosim.fmu_mfbd.dynamics.instant import gas_on_modes
from piston_cosim.fmu_mfbd.dynamics.system import NO_RINGS, OtherForces, RingForce
from piston_cosim.fmu_mfbd.dynamics.tables import gas_pressure, gas_table, inline_numbers
from piston_cosim.fmu_mfbd.finite_elements.element import (
    corner_stress,
    lame_constants,
    nodal_stress,
    von_mises,
)
from piston_cosim.fmu_mfbd.geometry.film import bore_splines, on_rows, window_at
from piston_cosim.fmu_mfbd.geometry.modal_field import read
from piston_cosim.fmu_mfbd.mechanism.slider_crank import (
    CrankMotion,
    Mechanism,
    height,
    side_force_demand,
)
from piston_cosim.fmu_mfbd.reduction.bases import expected_pressure
from piston_cosim.tests.verification.cases.bodies import box_mesh


def near(value, rel=1e-12):
    """Round-off."""
    return pytest.approx(value, rel=rel, abs=0.0)


def test_height_of_the_pin_by_triangles():
    """A crank of 3 m and a rod of 5 m reach 8 m; across, the rod rises by 4 m."""
    rod = Mechanism(3.0, 5.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    np.testing.assert_allclose(height(rod, 0.0, 0.0), [8.0, 0.0, 0.0], atol=1e-14)
    np.testing.assert_allclose(height(rod, 0.0, np.pi / 2), [4.0, -0.75, -3.0], rtol=1e-14)


def test_gas_pushes_the_crown_and_widens_the_bore():
    """Forces on a mode of the piston, and on an even one of a bore of 0.2 m, 0.15 m under gas."""
    wall = bore_wall(np.linspace(0.0, 0.2, 5), np.ones((8, 5, 1)), 0.04, 0.05, 0.02)
    system = SimpleNamespace(gas_force=np.array([3.0]), wall=wall)
    others = OtherForces(5e3, NO_RINGS, WallPressures(2e6, 0.0))
    on_bore = 2e6 * 2 * np.pi * 0.04 * 0.15
    np.testing.assert_allclose(gas_on_modes(system, 0.0, others), [15e3, on_bore], rtol=1e-12)


@pytest.mark.parametrize("phi", [0.4, 2.0, 4.4])
def test_side_force_that_gas_rings_and_inertia_ask_for(phi):
    """The side force follows from Newton and Euler for the rod, about the crank pin C.

    Accelerations are second differences of positions. The force P on the piston has P_y = p A -
    F_ry + m Y''. The moment (A - C) x (-P) balances the rod's inertia. The bore holds P_x + F_rx.
    The tolerance is 1e-6: differences over 1e-3 rad are of second order.
    """
    radius, length, offset, mass, inertia, share = 0.04, 0.13, 8e-4, 0.6, 2e-3, 0.3
    rod = Mechanism(radius, length, offset, mass, inertia, share, pin_mass=0.2)
    speed, step = 300.0, 1e-3

    def places(angle):
        pin = radius * np.array([-np.sin(angle), np.cos(angle)])
        across = offset - pin.item(0)
        psi = -np.arcsin(across / length)
        top = pin + [across, np.sqrt(length**2 - across**2)]
        return np.array([*pin, *top, *(pin + share * (top - pin)), psi])

    here = places(phi)
    rates = (places(phi + step) - 2 * here + places(phi - step)) / step**2 * speed**2
    pin, top, centre = here[:2], here[2:4], here[4:6]
    push = 5e3 + 90.0 + 0.7 * rates.item(3)

    def cross(a, b):
        return a.item(0) * b.item(1) - a.item(1) * b.item(0)

    taken = inertia * rates.item(6) + mass * cross(centre - pin, rates[4:6])
    across, up = top - pin
    expected = (taken + across * push) / up + 130.0
    others = OtherForces(5e3, RingForce(130.0, -90.0, 0.0), WallPressures(0.0, 0.0))
    found = side_force_demand(rod, 0.7, others, CrankMotion(phi, speed, 0.0))
    assert found == near(expected, rel=1e-6)


# ---- bore splines


def test_spline_through_a_peak():
    """Natural cubic spline through 0, 0, 1, 0, 0 at unit distance.

    The second derivatives M at the inner points follow from 4 M1 + M2 = 6, 2 M1 + 4 M2 = -12: 18/7,
    -30/7. At 1, 3/2 and 2:

    0, 1/2 - (M1 + M2)/16 = 17/28, 1;  slope at 3/2: 1 - (M2 - M1)/24 = 9/7
    """
    values = np.array([0.0, 0.0, 1.0, 0.0, 0.0])[None, :, None]
    bore = bore_splines(np.arange(5.0), values, values)
    window = window_at(bore.lowest, bore.spacing, 0.0, np.array([1.0, 1.5, 2.0]))
    knots = read(bore.radial, window.first, window.knots, np.ones(1))
    # 1e-6: coefficients are kept in single precision
    expected = pytest.approx(np.array([0.0, 17.0 / 28.0, 1.0]), abs=1e-6)
    assert on_rows(window, window.value, knots)[:, 0] == expected
    assert on_rows(window, window.slope, knots)[1, 0] == pytest.approx(9.0 / 7.0, abs=1e-6)


# ---- gas


@pytest.mark.parametrize("degrees", [240.0, -120.0, 600.0])
def test_gas_between_the_last_point_and_the_first(degrees):
    """A two-stroke table from -100 deg, 10 bar, to 220 deg, 30 bar, gives 20 bar at 240 deg.

    It closes at 260 deg with 10 bar, and 240 deg is half way.
    """
    rows = inline_numbers("gas.points", [(-100, 10), (0, 70), (110, 50), (220, 30)])
    table = gas_table(rows, 2.0 * np.pi, np.pi / 180.0, 1e5)
    assert gas_pressure(table, np.radians(degrees)) == near(20e5)


# ---- elements


def test_stress_of_an_even_strain():
    """An even strain gives xx = 3e-3, yy = zz = 1e-3, xy = 4e-3.

    E = 2.5 and nu = 1/4 give lambda = mu = 1. The body is stretched by 1e-3 along x and sheared by
    4e-3 (u_y is proportional to x). The equivalent stress is sqrt(4 + 3 16) 1e-3.
    """
    assert lame_constants(2.5, 0.25) == near((1.0, 1.0))
    points, tets = box_mesh((1, 2, 1), (0.3, 0.4, 0.2))
    displacement = np.zeros_like(points)
    displacement[:, 0] = 1e-3 * points[:, 0]
    displacement[:, 1] = 4e-3 * points[:, 0]
    stress = nodal_stress(tets, corner_stress(points, tets, displacement, 2.5, 0.25))
    expected = np.array([3e-3, 1e-3, 1e-3, 4e-3, 0.0, 0.0])
    assert stress == pytest.approx(np.tile(expected, (len(points), 1)), abs=1e-15)  # round-off
    assert von_mises(stress) == near(np.full(len(points), np.sqrt(52.0) * 1e-3))


def test_pressure_is_expected_across_the_pin():
    """0.1 on the pin axis, 1.1 on the thrust side, 0.6 between; the same at both heights."""
    weight = expected_pressure(np.radians([0.0, 45.0, 90.0]), 2)
    assert weight == near(np.array([0.1, 0.1, 0.6, 0.6, 1.1, 1.1]))
