import tomllib

import numpy as np
import pytest
from scipy.integrate import trapezoid

from piston_cosim.fmu_ehd.build import oil_values
from piston_cosim.fmu_ehd.oil import Barus1893, Oil, Roelands1966
from piston_cosim.models import MODELS

OILS = ("engine_oil_vogel_cross", "light_machine_oil", "heavy_machine_oil", "medicinal_white_oil")


@pytest.fixture(scope="module")
def library():
    return tomllib.loads((MODELS / "oils.toml").read_text())


def test_no_oil_of_the_library_is_left_out(library):
    assert set(OILS) == set(library)


@pytest.mark.parametrize("law", [Barus1893, Roelands1966])
def test_reduced_pressure_is_its_integral_and_inverts(law):
    oil = law(2e-8, 0.03)
    pressure = np.array([0.0, 1e5, 1e7, 1e8])
    grid = np.linspace(0.0, 1.0, 20001)
    integral = [trapezoid(1.0 / oil.ratio(p * grid)[0], p * grid) for p in pressure]
    assert oil.reduced(pressure) == pytest.approx(integral, rel=1e-7)  # trapezoid rule
    assert oil.pressure(oil.reduced(pressure)) == pytest.approx(
        pressure, rel=1e-9, abs=1e-3
    )  # table


@pytest.mark.parametrize("law", [Barus1893, Roelands1966])
def test_ratio_has_slope_alpha_at_zero_and_its_own_slope_elsewhere(law):
    oil = law(2e-8, 0.03)
    assert oil.ratio(0.0)[1] == pytest.approx(2e-8)
    difference = (oil.ratio(5e7 + 1e3)[0] - oil.ratio(5e7 - 1e3)[0]) / 2e3
    assert oil.ratio(5e7)[1] == pytest.approx(difference, rel=1e-8)


@pytest.mark.parametrize("law", [Barus1893, Roelands1966])
def test_every_reduced_pressure_has_a_pressure_that_goes_back(law):
    oil = law(2e-8, 0.03)
    reduced = np.array([1e6, 4.5e7, 6e7, 1e9])
    pressure = oil.pressure(reduced)
    assert np.all(np.diff(pressure) > 0.0)
    assert oil.reduced(pressure) == pytest.approx(reduced, rel=1e-9)
    assert oil.ratio(pressure[-1]) == (pytest.approx(1e3), 0.0)  # LARGEST_RATIO


def test_two_points_are_met():
    oil = Oil(viscosity_law="two_point", viscosity_40=0.08, viscosity_100=0.01)
    assert oil.low_shear_viscosity(np.array([313.15, 373.15])) == pytest.approx([0.08, 0.01])


@pytest.mark.parametrize("law, exponent", [("cross_1965", 0.8), ("carreau_1972", 0.5)])
def test_thinning_falls_from_one_to_the_high_shear_ratio_with_its_own_slope(law, exponent):
    oil = Oil(shear_thinning_law=law, shear_thinning_exponent=exponent, high_shear_ratio=0.6)
    temperature = np.full(3, 373.15)
    factor, slope = oil.thinning(np.array([0.0, 1e6, 1e14]), temperature)
    assert factor[[0, 2]] == pytest.approx([1.0, 0.6], abs=2e-3)
    size = 1.0
    difference = (
        oil.thinning(1e6 + size, temperature)[0] - oil.thinning(1e6 - size, temperature)[0]
    ) / (2.0 * size)
    assert slope[1] == pytest.approx(difference[1], rel=1e-6)


@pytest.mark.parametrize("name", OILS)
def test_every_oil_of_the_library_is_usable_and_sourced(name, library):
    faults = []
    values = oil_values(name, library[name], faults)
    assert faults == []
    viscosity = Oil(**values).low_shear_viscosity(np.array([313.15, 373.15, 423.15]))
    assert np.all(np.diff(viscosity) < 0.0) and 1e-3 < viscosity[1] < 0.1


def test_points_of_a_library_oil_are_met(library):
    oil = Oil(**oil_values("heavy_machine_oil", library["heavy_machine_oil"], []))
    assert oil.low_shear_viscosity(np.array([303.15, 333.15, 373.15])) == pytest.approx(
        [0.153, 0.034, 0.0091], rel=1e-9
    )


def test_library_faults_are_reported_together():
    faults = []
    oil_values(
        "x", dict(viscosity="1 m", vogel_b="1e6 K", grade="a", viscosity_law="linear"), faults
    )
    text = "\n".join(faults)
    words = (
        "viscosity has no source",
        "'1 m'",
        "vogel_b = 1e+06 K",
        "grade is no parameter",
        "'linear'",
    )
    assert all(word in text for word in words)
