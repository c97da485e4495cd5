"""Viscosity over temperature, pressure and shear rate by hand, as shear and flow of a film.

References
----------
[Vogel1921], [Walther1931] (ASTM D341), [Barus1893], [Roelands1966], [Cross1965], [Carreau1972]: the
formulas are in the tests. ISO 3448: viscosity grades.
"""

from functools import partial
from math import exp, log, log10

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from piston_cosim.fmu_ehd.laws.oil import Oil
from piston_cosim.fmu_ehd.laws.piezoviscosity import (
    PRESSURE_VISCOSITY_LAWS,
    TABLE,
    pressure_law,
    reduced_pressure,
    viscosity_ratio,
)

from . import sleeve
from .sleeve import AREA, LENGTH, WIDTH

SHAPE = (4, 6)
FILM = 7e-6  # [m]
near = partial(sleeve.near, rel=1e-10)


def stepped(oil, velocity, **changes):
    """Return the outputs of one step of a constant parallel film."""
    return sleeve.stepped(SHAPE, FILM, velocity, oil=oil, **changes)


def sheared(oil, celsius, velocity=2.0):
    """Viscosity that the shear of a film at one temperature shows [Pa s]."""
    kelvin = 273.15 + celsius
    o = stepped(oil, velocity, oil_temperature_lower_edge=kelvin, oil_temperature_upper_edge=kelvin)
    return -o["friction_force_hydrodynamic"] * FILM / (velocity * AREA)


# ---- temperature


def test_constant():
    assert sheared(Oil(viscosity=0.0173), 60.0) == near(0.0173)


@pytest.mark.parametrize(
    "celsius, viscosity", [(60.0, 25.6e-3), (100.0, 8.16e-3), (150.0, 3.21e-3)]
)
def test_vogel(celsius, viscosity):
    """nu = 0.076642 exp[1009.863/(109.047 + t)] cSt at 850 kg/m3, by hand to three digits."""
    oil = Oil(viscosity_law="vogel_1921")  # the constants of that oil are the defaults
    assert sheared(oil, celsius) == near(viscosity, rel=2e-3)
    exact = 850.0 * 0.076642e-6 * exp(1009.863 / (109.047 + celsius))
    assert sheared(oil, celsius) == near(exact, rel=1e-5)  # K has six digits
    other = Oil(viscosity_law="vogel_1921", vogel_viscosity=1.3e-4, vogel_b=800.0, vogel_c=120.0)
    assert sheared(other, celsius) == near(1.3e-4 * exp(800.0 / (120.0 + celsius)))


def test_walther():
    """Walther's law is lg lg(nu + 0.7) = A - M lg T, nu in mm2/s, T in K.

    By hand with A = 8.93, M = 3.47 at 330 K: lg 330 = 2.5185139, A - M lg T = 0.1907566,
    10^. = 1.5515173, 10^. = 35.605545 mm2/s + 0.7.
    """
    oil = Oil(viscosity_law="walther_1931", walther_a=8.93, walther_m=3.47, density=871.0)
    assert sheared(oil, 330.0 - 273.15) == near(871.0 * 34.905545e-6, rel=1e-6)


def test_two_points():
    """The viscosity passes through two points: ISO VG 46 has 46 mm2/s at 40 C and 6.8 at 100 C.

    The density is 870 kg/m3. Between the points lg lg(nu + 0.7) is linear in lg T (ASTM D341).
    At 70 C by hand: lg lg 46.7 = 0.2225, lg lg 7.5 = -0.0579.
    """
    oil = Oil(
        viscosity_law="two_point",
        viscosity_40=870.0 * 46e-6,
        viscosity_100=870.0 * 6.8e-6,
        density=870.0,
    )
    assert sheared(oil, 40.0) == near(870.0 * 46e-6)
    assert sheared(oil, 100.0) == near(870.0 * 6.8e-6)
    high, low = log10(log10(46.7)), log10(log10(7.5))
    assert (high, low) == (pytest.approx(0.2225, abs=1e-4), pytest.approx(-0.0579, abs=1e-4))
    way = log(343.15 / 313.15) / log(373.15 / 313.15)
    between = 10.0 ** (10.0 ** (high + (low - high) * way)) - 0.7
    assert sheared(oil, 70.0) == near(870.0e-6 * between)


@pytest.mark.parametrize("velocity", [2.0, -2.0])
def test_oil_is_hotter_where_the_hot_edge_is(velocity):
    """Vogel's oil is hotter near the hot edge; its temperature is linear, 350 K below, 420 K above.

    Compared are the shear of each cell, and the pressure flow through the cells in series,
    1/sum (12 mu_j dy/h^3).
    """
    given = dict(oil_temperature_lower_edge=350.0, oil_temperature_upper_edge=420.0)
    oil = Oil(viscosity_law="vogel_1921")
    kelvin = 350.0 + 70.0 * (np.arange(6) + 0.5) / 6.0
    mu = np.array([6.51457e-5 * exp(1009.863 / (t - 273.15 + 109.047)) for t in kelvin])
    expected = -mu * velocity / FILM * AREA / 24.0
    for o in (stepped(oil, velocity, **given), stepped(oil, velocity, conditions=given)):
        assert o["nodal_friction_force"][1] == near(expected)
    o = stepped(oil, 0.0, pressure_lower_edge=3e5, **given)
    flow = 3e5 / (12.0 * mu * LENGTH / 6.0 / FILM**3).sum() * WIDTH
    assert o["flow_lower_edge"] == near(flow)


def test_a_field_of_temperature_takes_the_place_of_the_edges():
    kelvin = 340.0 + 10.0 * np.arange(24.0).reshape(SHAPE) / 3.0
    o = stepped(Oil(viscosity_law="vogel_1921"), 2.0, conditions=dict(oil_temperature=kelvin))
    mu = 6.51457e-5 * exp(1009.863 / (kelvin[3, 1] - 273.15 + 109.047))
    assert o["friction_force_hydrodynamic"] < 0.0
    # the film is parallel and full: no cell's pressure depends on its viscosity where none is given
    assert o["nodal_friction_force"][3, 1] == near(-mu * 2.0 / FILM * AREA / 24.0)


# ---- pressure


@pytest.mark.parametrize("law", ["barus_1893", "roelands_1966"])
def test_pressure_makes_oil_thick(law):
    """Pressure makes oil thick, mu = mu_0 r(p), here between 200 and 20 MPa.

    The flow is q = h^3/(12 mu_0 L) int dp/r. The integral up to p is linear in y.
    The shear stress is mu_0 r(p) V/h.

    Barus: r = exp(alpha p). Roelands: r = exp{(ln mu_0 + 9.67)[(1 + p/1.96e8)^Z - 1]}, Z = alpha
    1.96e8/(ln mu_0 + 9.67). 1e-8: tables and quadrature.
    """
    mu, alpha, lower, upper = 0.021, 1.9e-8, 200e6, 20e6
    level = log(mu) + 9.67

    def ratio(p):
        if law == "barus_1893":
            return exp(alpha * p)
        return exp(level * ((1.0 + p / 1.96e8) ** (alpha * 1.96e8 / level) - 1.0))

    def reduced(low, high):
        return quad(lambda p: 1.0 / ratio(p), low, high, epsrel=1e-12)[0]

    if law == "barus_1893":
        by_hand = (exp(-alpha * upper) - exp(-alpha * lower)) / alpha
        assert reduced(upper, lower) == near(by_hand)
    oil = Oil(viscosity=mu, pressure_viscosity_law=law, pressure_viscosity_coefficient=alpha)
    edges = dict(pressure_lower_edge=lower, pressure_upper_edge=upper)
    o = stepped(oil, 0.0, **edges)
    whole = reduced(upper, lower)
    assert o["flow_lower_edge"] == near(FILM**3 / (12.0 * mu) * whole / LENGTH * WIDTH, rel=1e-8)
    for j in (0, 3, 5):
        left = whole * (1.0 - (j + 0.5) / 6.0)
        pressure = brentq(lambda p: reduced(upper, p) - left, upper, lower, rtol=1e-14)  # noqa: B023
        assert o["pressure"][2, j] == near(pressure, rel=1e-8)
    for velocity in (3.0, -3.0):
        sliding = stepped(oil, velocity, **edges)
        for j in (1, 4):
            thick = mu * ratio(sliding["pressure"][0, j]) / FILM * velocity
            gap = sliding["nodal_friction_force"] - o["nodal_friction_force"]
            # the pressure flow is the same: Couette shear alone is left
            assert gap[0, j] == near(-thick * AREA / 24.0, rel=1e-8)


@pytest.mark.parametrize("kind", ["barus_1893", "roelands_1966"])
def test_beyond_its_limit_an_oil_is_a_thousand_times_as_thick(kind):
    """mu = 1000 mu_0 and dmu/dp = 0; dq/dp is 1/1000."""
    number = getattr(PRESSURE_VISCOSITY_LAWS, kind)
    law = pressure_law(number, 2e-8, np.full((2, 2), 0.02), np.ones((2, 2)), np.zeros(TABLE))
    ratio, slope = viscosity_ratio(law, 0.999 * law.limit)
    assert 900.0 < ratio < 1000.0 and slope > 0.0
    assert viscosity_ratio(law, 1.5 * law.limit) == pytest.approx((1000.0, 0.0), rel=1e-9)
    more = reduced_pressure(law, 1.5 * law.limit) - reduced_pressure(law, law.limit)
    assert more == near(0.5e-3 * law.limit, rel=1e-7)


# ---- shear rate


@pytest.mark.parametrize("velocity", [4.0, -4.0])
@pytest.mark.parametrize("law, n", [("cross_1965", 0.8), ("carreau_1972", 0.4)])
def test_shear_makes_oil_thin(law, n, velocity):
    """Shear at gamma' = |V|/h makes oil thin.

    lg gamma'_c = a + b T_o, in C: 4.1 + 0.012 x 80 = 5.06.

    Cross: mu/mu_0 = m + (1 - m)/[1 + (gamma'/gamma'_c)^n].
    Carreau: mu/mu_0 = m + (1 - m)[1 + (gamma'/gamma'_c)^2]^((n - 1)/2).
    Pressure flow along the sliding direction meets d(mu g)/dg.
    """
    oil = Oil(
        viscosity=0.02,
        shear_thinning_law=law,
        shear_thinning_exponent=n,
        high_shear_ratio=0.55,
        critical_shear_rate_a=4.1,
        critical_shear_rate_b=0.012,
    )

    def stress(rate):
        x = rate / 10.0**5.06
        fall = 1.0 / (1.0 + x**n) if law == "cross_1965" else (1.0 + x * x) ** ((n - 1.0) / 2.0)
        return 0.02 * (0.55 + 0.45 * fall) * rate

    rate = 4.0 / FILM
    thinned = stress(rate) / rate
    tangent = (stress(1.0001 * rate) - stress(0.9999 * rate)) / (0.0002 * rate)
    assert thinned < 0.017
    assert sheared(oil, 80.0, velocity) == near(thinned)
    warm = dict(oil_temperature_lower_edge=353.15, oil_temperature_upper_edge=353.15)
    still = stepped(oil, velocity, **warm)
    pressed = stepped(oil, velocity, pressure_lower_edge=3e5, **warm)
    flow = FILM**3 / (12.0 * tangent) * 3e5 / LENGTH * WIDTH
    # the difference quotient is of second order
    assert pressed["flow_lower_edge"] - still["flow_lower_edge"] == near(flow, rel=1e-7)
