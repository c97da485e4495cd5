import tomllib

import numpy as np
import pytest
from scipy.integrate import quad

from piston_cosim.fmu_ehd.balance.flow_film import FilmLaws, ShearedOil, flow_film
from piston_cosim.fmu_ehd.build import oil_values
from piston_cosim.fmu_ehd.laws.oil import Oil, tangent_thinning
from piston_cosim.fmu_ehd.laws.piezoviscosity import (
    PRESSURE_VISCOSITY_LAWS,
    TABLE,
    pressure_law,
    pressure_of,
    reduced_pressure,
    viscosity_ratio,
)
from piston_cosim.models import MODELS
from piston_cosim.tests.verification.cases.thinned_pad import (
    generalised_newtonian_load,
    isotropic_load,
    model_load,
)

GRADES = {
    "sae_0w_20": (6.2, -35.0, 6.9, 9.3, 2.6),
    "sae_5w_30": (6.6, -30.0, 9.3, 12.5, 2.9),
    "sae_5w_40": (6.6, -30.0, 12.5, 16.3, 3.5),
    "sae_10w_30": (7.0, -25.0, 9.3, 12.5, 2.9),
    "sae_10w_40": (7.0, -25.0, 12.5, 16.3, 3.5),
    "sae_15w_40": (7.0, -20.0, 12.5, 16.3, 3.7),
    "sae_10w_60": (7.0, -25.0, 21.9, 26.1, 3.7),
}
"""SAE J300 (January 2015): cranking viscosity [Pa s] at most and its temperature [C], range of the
kinematic viscosity at 100 C [mm2/s], viscosity at 150 C and 1e6 1/s at least [mPa s]."""
LIBRARY = tomllib.loads((MODELS / "oils.toml").read_text())


@pytest.fixture(params=["barus_1893", "roelands_1966"])
def law(request):
    """Return a pressure law with alpha = 20 1/GPa."""
    kind = getattr(PRESSURE_VISCOSITY_LAWS, request.param)
    return pressure_law(kind, 2e-8, np.full((1, 1), 0.03), np.ones((1, 1)), np.zeros(TABLE))


def test_every_reduced_pressure_has_a_pressure_that_goes_back(law):
    reduced = [1e6, 4.5e7, 6e7, 1e9]
    pressure = [pressure_of(law, q) for q in reduced]
    assert np.all(np.diff(pressure) > 0.0)
    assert [reduced_pressure(law, p) for p in pressure] == pytest.approx(reduced, rel=1e-9)
    assert viscosity_ratio(law, pressure[-1]) == (pytest.approx(1e3), 0.0)  # LARGEST_RATIO


@pytest.mark.parametrize("alpha, mu", [(1.6e-10, 0.3), (2e-8, 0.01), (9e-8, 0.05)])
def test_reduced_pressure_is_the_integral_of_the_law_also_under_suction(alpha, mu):
    """q = int_0^p mu_0/mu dp by quadrature with mu_0/mu of Roelands' law, and back; 1e-5: table."""
    kind = PRESSURE_VISCOSITY_LAWS.roelands_1966
    law = pressure_law(kind, alpha, np.full((1, 1), mu), np.ones((1, 1)), np.zeros(TABLE))
    level = np.log(mu) + 9.67
    z = alpha * 1.96e8 / level
    for p in (-1.9e8, -5e7, -1e5, 1e5, 3e7):
        exact, _ = quad(lambda x: np.exp(level * (1.0 - (1.0 + x / 1.96e8) ** z)), 0.0, p)
        assert reduced_pressure(law, p) == pytest.approx(exact, rel=1e-5)
        assert pressure_of(law, exact) == pytest.approx(p, rel=1e-5)


def test_the_mean_of_roelands_counts_images_and_omits_openings():
    kind = PRESSURE_VISCOSITY_LAWS.roelands_1966
    viscosity, images = np.array([[0.01, 0.04, 9.0]]), np.array([[1.0, 2.0, 0.0]])
    law = pressure_law(kind, 2e-8, viscosity, images, np.zeros(TABLE))
    assert law.level == pytest.approx(np.log(0.03) + 9.67, rel=1e-15)


@pytest.mark.parametrize("name", LIBRARY)
def test_every_oil_of_the_library_is_usable_and_sourced(name):
    faults = []
    values = oil_values(name, LIBRARY[name], faults)
    assert faults == []
    viscosity = Oil(**values).low_shear_viscosity(np.array([313.15, 373.15, 423.15]))
    assert np.all(np.diff(viscosity) < 0.0) and 1e-3 < viscosity[1] < 0.1


def test_points_of_a_library_oil_are_met():
    oil = Oil(**oil_values("heavy_machine_oil", LIBRARY["heavy_machine_oil"], []))
    assert oil.low_shear_viscosity(np.array([303.15, 333.15, 373.15])) == pytest.approx(
        [0.153, 0.034, 0.0091], rel=1e-9
    )


@pytest.mark.parametrize("name", GRADES)
def test_a_grade_is_within_the_limits_of_the_standard(name):
    cranking, cold, low, high, high_shear = GRADES[name]
    oil = Oil(**oil_values(name, LIBRARY[name], []))
    temperature = 273.15 + np.array([cold, 100.0, 150.0])
    viscosity = oil.low_shear_viscosity(temperature)
    # the constants have five digits
    assert viscosity[0] == pytest.approx(cranking, rel=5e-3)
    assert 1e6 * viscosity[1] / oil.density == pytest.approx((low + high) / 2.0, rel=2e-3)
    assert low < 1e6 * viscosity[1] / oil.density < high
    assert 1e3 * viscosity[2] > high_shear  # at low shear above the limit at high shear


def test_library_faults_are_reported_together():
    faults = []
    oil_values(
        "x", dict(viscosity="1 m", vogel_b="1e6 K", grade="a", viscosity_law="linear"), faults
    )
    text = "\n".join(faults)
    words = (
        "x.viscosity: expected a source",
        "got '1 m'",
        "got 1e+06 K",
        "got unknown parameter 'grade'",
        "got unknown choice 'linear'",
    )
    assert all(word in text for word in words)


@pytest.mark.parametrize(
    "ratio, speed, error",
    [(0.74, 1.0, 0.005), (0.5, 1.0, 0.01), (0.3, 1.0, 0.015), (0.3, 10.0, 0.001)],
)
def test_a_pad_carries_the_load_of_the_generalised_newtonian_flow(ratio, speed, error):
    """A pad carries the load of the generalised Newtonian flow.

    Measured -0.25, -0.65, -1.34 and -0.04 %, of second order in the pressure gradient.
    With one viscosity for both directions the load is 3.3, 9.2, 21 and 2.9 % too large.
    """
    oil = Oil(shear_thinning_law="cross_1965", high_shear_ratio=ratio)
    load = generalised_newtonian_load(oil, speed)
    assert isotropic_load(oil, speed) > (1.0 + 3.0 * error) * load
    assert model_load(oil, speed) == pytest.approx(load, rel=error)


def test_the_stress_of_a_large_exponent_may_fall_but_the_film_still_flows():
    """Cross with n = 4: d(mu g)/dg < 0 next to g_c, where the bound m is used."""
    law = Oil(shear_thinning_law="cross_1965", shear_thinning_exponent=4.0).thinning
    critical = 10.0 ** (2.5 + 0.0213 * 100.0)
    assert tangent_thinning(law, 1.2 * critical, 373.15) == (0.74, 0.0)
    assert tangent_thinning(law, 0.0, 373.15) == (1.0, 0.0)


def test_ratio_has_slope_alpha_at_zero_and_its_own_slope_elsewhere(law):
    assert viscosity_ratio(law, 0.0)[1] == pytest.approx(2e-8)
    above, below = (viscosity_ratio(law, 5e7 + by)[0] for by in (1e3, -1e3))
    assert viscosity_ratio(law, 5e7)[1] == pytest.approx((above - below) / 2e3, rel=1e-8)


def test_thinned_film_has_its_slopes_where_it_slides_both_ways():
    law = Oil(shear_thinning_law="cross_1965", shear_thinning_exponent=0.8).thinning
    laws = FilmLaws(1e-7, 0.0, np.zeros((0, 0)), law)

    def at(film, velocity, turning):
        cell = np.full((1, 1), 1.0)
        oil = ShearedOil(velocity * cell, turning * cell, 0.01 * cell, 373.15 * cell)
        return flow_film(film * cell, oil, laws)

    _, slopes, around = at(8e-6, 0.2, -0.3)
    for slope, change in (
        (slopes.by_film, np.array([1e-10, 0.0, 0.0])),
        (slopes.by_velocity, np.array([0.0, 1e-5, 0.0])),
        (around.by_velocity, np.array([0.0, 0.0, 1e-5])),
    ):
        point = np.array([8e-6, 0.2, -0.3])
        upper, lower = at(*(point + change)), at(*(point - change))
        difference = (upper.quantities - lower.quantities) / (2.0 * change.sum())
        # third derivative times the square of the change, and round-off
        assert slope == pytest.approx(difference, rel=1e-7, abs=0.0)
