import numpy as np
import pytest
from scipy.integrate import trapezoid

from piston_cosim.fmu_ehd import roughness
from piston_cosim.fmu_ehd.films import CONDUCTIVITY_A, rough_film, smooth_film
from piston_cosim.fmu_ehd.model import LubricationModel
from piston_cosim.fmu_ehd.oil import Oil
from piston_cosim.fmu_ehd.parameters import Parameters

SHAPE = (6, 5)
SIGMA = 1e-6


def rough(film, share=0.8, gamma=2.0):
    """Values and slopes of rough surfaces with sigma = 1 um."""
    table = roughness.factor_table(share, gamma, 0.5 * gamma)
    return rough_film(film, np.full_like(film, 0.01), 1e-9, SIGMA, table)


def test_thick_rough_film_is_smooth():
    film = np.array([[31.9e-6]])
    for value, reference in zip(
        rough(film)[0], smooth_film(film, np.full_like(film, 0.01), 1e-9)[0]
    ):
        if reference[0, 0] > 0.0:
            assert value[0, 0] == pytest.approx(
                reference[0, 0], rel=5e-3
            )  # phi - 1 of grooves along falls as H^-1.5


@pytest.mark.parametrize("law", ["smooth", "rough"])
def test_slopes_are_derivatives_and_all_films_stay_positive(law):
    film = np.linspace(-3e-6, 34e-6, 1501)[None]

    def values(h):
        return smooth_film(h, np.full_like(h, 0.01), 1e-7) if law == "smooth" else rough(h)

    size = 1e-13
    value, slope = values(film)
    difference = (values(film + size)[0] - values(film - size)[0]) / (2.0 * size)
    error = np.abs(difference - slope) / np.abs(slope).max(axis=(1, 2), keepdims=True).clip(1e-30)
    assert (
        np.mean(error > 1e-3) < 0.02
    )  # round-off of the difference; the points at a floor or a table's end have none
    assert np.all(value[: CONDUCTIVITY_A + 1] > 0.0)


@pytest.mark.parametrize("share, sign", [(1.0, -1.0), (0.5, 0.0), (0.0, 1.0)])
def test_a_rough_skirt_holds_oil_back_and_a_rough_bore_carries_it(share, sign):
    model = LubricationModel(
        Parameters(
            SHAPE, roughness_rms=SIGMA, flow_factors="patir_cheng_1978", roughness_share_skirt=share
        )
    )
    film, velocity = np.full(SHAPE, 2e-6), np.full(SHAPE, 2.0)
    state, _ = model.start(film, velocity)
    flow = model.advance(state, film, velocity, 1e-4)[1]["flow_upper_edge"] / (
        2.0 * np.pi * 28.25e-3
    )
    expected = SIGMA * (
        roughness.average_gap(2.0).value + sign * roughness.shear_flow_factor(2.0, 1.0).value
    )  # U = 1 m/s, Eq. (E8)
    assert flow == pytest.approx(expected, rel=1e-6)  # Hermite table


def test_peklenik_number_between_tabulated_ones_is_between_their_factors():
    for factor in (
        roughness.pressure_flow_factor,
        roughness.shear_flow_factor,
        roughness.pressure_stress_factor,
    ):
        for h in np.linspace(1.0, 6.0, 11):
            low, middle, high = (factor(h, gamma).value for gamma in (1.0, np.sqrt(3.0), 3.0))
            assert middle == pytest.approx(0.5 * (low + high))


def test_factors_are_those_of_the_published_table():
    # [Patir1978], [Patir1979] by hand: 1 - 1.18 exp(-0.42 x 2); 1 + 0.52 x 3^-1.5; 1.899
    # exp(-0.87); 1.126 exp(-1.5)
    assert roughness.pressure_flow_factor(2.0, 1 / 3).value == pytest.approx(0.490581, rel=1e-5)
    assert roughness.pressure_flow_factor(3.0, 6.0).value == pytest.approx(1.100074, rel=1e-5)
    assert roughness.shear_flow_factor(1.0, 1.0).value == pytest.approx(0.795589, rel=1e-5)
    assert roughness.shear_flow_factor(6.0, 1.0).value == pytest.approx(0.251245, rel=1e-5)


def test_average_gap_is_its_integral():
    heights = np.linspace(-8.0, 8.0, 160001)
    density = np.exp(-(heights**2) / 2.0) / np.sqrt(2.0 * np.pi)
    for separation in (-1.0, 0.0, 1.5):
        integral = trapezoid(np.maximum(separation + heights, 0.0) * density, heights)
        assert roughness.average_gap(separation).value == pytest.approx(
            integral, rel=1e-7
        )  # trapezoid rule


def test_thinned_oil_halves_couette_stress_at_the_critical_shear_rate():
    oil = Oil(
        shear_thinning_law="cross_1965",
        high_shear_ratio=1e-9,
        critical_shear_rate_a=5.0,
        critical_shear_rate_b=0.0,
    )
    film, velocity = np.full(SHAPE, 1e-5), np.full(SHAPE, 1.0)  # 1e5 1/s
    friction = []
    for chosen in (Oil(), oil):
        model = LubricationModel(Parameters(SHAPE, chosen))
        state, _ = model.start(film, velocity)
        friction.append(
            model.advance(state, film, velocity, 1e-4)[1]["friction_force_hydrodynamic"]
        )
    assert friction[1] == pytest.approx(0.5 * friction[0], rel=1e-6)  # the high-shear ratio


@pytest.mark.parametrize(
    "row", roughness.COEFFICIENTS, ids=[f"{gamma:.3g}" for gamma in roughness.PEKLENIK]
)
def test_branches_of_the_shear_flow_factor_meet(row):
    near = row.A1 * 5.0**row.a1 * np.exp(-row.a2 * 5.0 + row.a3 * 25.0)
    assert near == pytest.approx(
        row.A2 * np.exp(-1.25), rel=1e-3
    )  # exponents are printed to 0.01, amplitudes to 0.001
