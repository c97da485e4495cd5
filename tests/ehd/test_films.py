import numpy as np
import pytest
from scipy.integrate import quad

from piston_cosim.fmu_ehd.balance.films import rough_film
from piston_cosim.fmu_ehd.common.quantities import CONDUCTIVITY_A, COUETTE, STORED
from piston_cosim.fmu_ehd.laws import roughness

SIGMA = 1e-6


def rough(film, share=0.8, gamma=2.0):
    """Values and slopes of rough surfaces with sigma = 1 um."""
    table = roughness.factor_table(share, gamma, 0.5 * gamma)
    return rough_film(film, np.full_like(film, 0.01), 1e-9, SIGMA, table)


def test_slopes_are_derivatives_and_all_films_stay_positive():
    film = np.linspace(-3e-6, 34e-6, 1501)[None]
    size = 1e-13
    value, slope = rough(film)
    difference = (rough(film + size)[0] - rough(film - size)[0]) / (2.0 * size)
    error = np.abs(difference - slope) / np.abs(slope).max(axis=(1, 2), keepdims=True).clip(1e-30)
    assert (
        np.mean(error > 1e-3) < 0.02
    )  # round-off of the difference; the points at a floor or a table's end have none
    assert np.all(value[: CONDUCTIVITY_A + 1] > 0.0)


def mean_inverse_gap(separation):
    """E(sigma/h_T) of Eq. (R4) by quadrature, over the local films above sigma/100."""
    z = separation / 3.0
    lowest = max(1.0 / 300.0 - z, -1.0)
    return quad(lambda s: 35.0 / 96.0 * (1.0 - s * s) ** 3 / (z + s), lowest, 1.0, limit=200)[0]


@pytest.mark.parametrize("separation", [1.0, 0.2, 0.02, 0.0, -0.5, -1.0, -2.0])
def test_mean_gap_and_couette_stress_near_and_in_overlap(separation):
    """Eqs. (R1) and (R4), with Phi_fs of Eq. (R5) above, hold near and in overlap.

    2.1e-3: the closed form of (R4) leaves out terms of first order in the cut-off.
    They are 35/96 x 1.7/300 with the largest slope of (1 - s^2)^3. 1e-6: the table.
    """
    film = np.array([[separation * SIGMA]])
    quantities, _ = rough(film, gamma=1.0, share=1.0)
    assert quantities[STORED, 0, 0] / SIGMA == pytest.approx(
        roughness.average_gap(separation).value, rel=1e-6
    )
    sliding = roughness.sliding_stress_factor(separation, 1.0).value
    exact = mean_inverse_gap(separation) + (sliding / separation if separation > 0.0 else 0.0)
    assert quantities[COUETTE, 0, 0] * SIGMA / 0.01 == pytest.approx(exact, abs=2.1e-3)


def test_mean_gap_and_couette_stress_by_hand():
    """h_T(-0.5) = -0.5 x 0.308538 + 0.352065; at H -> 0 35/96 (ln 300 - 11/12) mu/sigma."""
    assert rough(np.array([[-0.5e-6]]))[0][STORED, 0, 0] == pytest.approx(0.197797e-6, rel=1e-5)
    touching = rough(np.array([[1e-12]]))[0][COUETTE, 0, 0] * SIGMA / 0.01
    assert touching == pytest.approx(1.745303, rel=1e-5)
