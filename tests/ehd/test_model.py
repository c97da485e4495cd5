import numpy as np
import pytest

from fmu_ehd.model import LubricationModel, Parameters, faults
from fmu_ehd.verification import DEGREE, motored, motored_film, tangent_error

SHAPE = (12, 10)


def test_mass_balances_in_every_step_of_a_motored_cycle():
    _, state, history = motored(Parameters(SHAPE), 720)
    assert max(o["mass_imbalance"] for o in history) <= 1e-12  # round-off
    assert min(o["film_fraction"].min() for o in history) < 0.7  # the film did rupture
    assert max(o["film_fraction"].max() for o in history) <= 1.0 + 1e-12


@pytest.mark.parametrize("changes", [
    dict(roughness_rms=1e-6), dict(film_fraction_lower_edge=0.8, film_fraction_upper_edge=0.8),
    dict(pressure_upper_edge=2e5, cavitation_pressure=-5e4)], ids=["contact", "starved", "edge pressure"])
def test_tangent_is_the_central_difference(changes):
    assert tangent_error(Parameters(SHAPE, **changes)) <= 1e-7  # third derivative x (1e-5)^2


def test_overlap_survives_and_pushes_apart():
    model, state, _ = motored(Parameters(SHAPE, roughness_rms=1e-6), 20)
    film, velocity = motored_film(SHAPE, 21 * DEGREE)
    film[3, 4] = -2e-6
    _, outputs = model.advance(state, film, velocity, DEGREE)
    assert outputs["minimum_film_thickness"] == -2e-6
    assert outputs["asperity_pressure"][3, 4] == outputs["asperity_pressure"].max() > 1e7
    assert all(np.isfinite(value).all() for value in outputs.values())


def test_shear_on_a_parallel_film_is_couette():
    model = LubricationModel(Parameters(SHAPE))
    film, velocity = np.full(SHAPE, 1e-5), np.full(SHAPE, 2.0)
    state, _ = model.start(film, velocity)
    _, outputs = model.advance(state, film, velocity, DEGREE)
    area = 2.0 * np.pi * 28.25e-3 * 27e-3
    assert outputs["friction_force_hydrodynamic"] == pytest.approx(-0.01 * 2.0 / 1e-5 * area)
    assert outputs["friction_power"] == pytest.approx(0.01 * 4.0 / 1e-5 * area)
    assert outputs["flow_lower_edge"] == pytest.approx(-1e-5 * 2.0 * np.pi * 28.25e-3)  # the skirt moves up, the oil stays behind
    assert outputs["flow_upper_edge"] == pytest.approx(1e-5 * 2.0 * np.pi * 28.25e-3)


def test_cavitation_pressure_shifts_the_datum_alone():
    gauge, absolute = (motored(Parameters(SHAPE, pressure_lower_edge=p, pressure_upper_edge=p, cavitation_pressure=p), 60)[2][-1]
                       for p in (0.0, 1e5))
    scale = gauge["maximum_pressure"]
    assert np.abs(absolute["pressure"] - 1e5 - gauge["pressure"]).max() <= 1e-9 * scale  # round-off of the datum
    assert np.abs(absolute["film_fraction"] - gauge["film_fraction"]).max() <= 1e-12


def test_starting_outputs_are_a_full_film_between_the_edge_pressures():
    model = LubricationModel(Parameters(SHAPE, pressure_lower_edge=1e5))
    state, outputs = model.start(*motored_film(SHAPE, 0.0))
    assert np.all(outputs["film_fraction"] == 1.0)
    assert np.all(np.diff(outputs["pressure"], axis=1) < 0.0)
    assert np.array_equal(state.content, motored_film(SHAPE, 0.0)[0])


def test_edge_below_cavitation_pressure_is_a_fault():
    found = faults(Parameters(pressure_lower_edge=-1e4, pressure_upper_edge=-2e4))
    assert len(found) == 2 and "pressure_lower_edge = -10000 Pa" in found[0]
