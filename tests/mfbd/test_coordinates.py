"""Films and derivatives by the coordinates of the bodies, Eq. (Q13)."""

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.dynamics.model import stacked
from piston_cosim.fmu_mfbd.dynamics.state import step_coefficients
from piston_cosim.fmu_mfbd.dynamics.step import (
    coordinate_change,
    crank_after,
    film_measures,
    films_at,
    moved_by,
    response_to,
)

from .differences import rough_change
from .pin_models import MODELS, SPEED, STEP, rough_inputs, rough_way

MOST = ["all flexible", "tied, rubbing, all flexible", "static"]


@pytest.mark.parametrize("name", MOST)
def test_films_placed_at_the_end_of_a_step_are_its_films(name):
    model = MODELS[name]()
    before, _ = rough_way(model, 4)
    inputs = rough_inputs(model, 4)
    crank = crank_after(model.model, before, STEP, SPEED)
    c = step_coefficients(before, STEP, model.model.settings.spectral_radius)
    state, out = model.advance(before, inputs, STEP)
    placed = films_at(model.model, before, c, crank, stacked(inputs), state.position)
    for films, grids, turning in (
        (placed.skirt, model.films, "sliding_velocity"),
        (placed.pins, model.grids, "circumferential_velocity"),
    ):
        for kind, field in (
            ("film_thickness", films.film_thickness),
            (turning, films.sliding_velocity),
        ):
            known = np.concatenate([out[f"{one.prefix}{kind}"].ravel() for one in grids])
            # positions to the last digits, from which a step has them by its accelerations
            np.testing.assert_allclose(field, known, rtol=1e-9, atol=1e-9 * np.abs(known).max())


@pytest.mark.parametrize("name", MOST)
def test_a_derivative_by_way_of_the_coordinates_is_that_of_the_films(name):
    """Exactly, and roughly where modes do not slide and are not coupled.

    The forces of this test are as large along the surfaces as across, where modes slide the most.
    """
    model = MODELS[name]()
    rough_way(model, 4)
    last = model._last
    seeds = stacked(rough_change(model, rough_inputs(model, 4)))
    whole = response_to(model.model, last, seeds, np.zeros(4))
    coordinates = coordinate_change(model.model, last, seeds, True)
    films = moved_by(model.model, last, coordinates, True)
    rough = moved_by(model.model, last, coordinate_change(model.model, last, seeds, False), False)
    for known, exact, about in (
        (whole.film_thickness, films.skirt.film_thickness, rough.skirt.film_thickness),
        (whole.pin_film_thickness, films.pins.film_thickness, rough.pins.film_thickness),
        (whole.sliding_velocity, films.skirt.sliding_velocity, rough.skirt.sliding_velocity),
    ):
        size = np.abs(known).max()
        np.testing.assert_allclose(exact, known, rtol=0, atol=1e-12 * size)
        assert 0.0 < np.abs(about - known).max() < size
    assert films.moved.velocity[0] == pytest.approx(whole.lateral_velocity, rel=1e-12)


def test_the_measure_of_a_coordinate_is_what_it_does_to_the_films():
    """Thickness, and velocity times the step. A rigid bore does so alike at every height."""
    model = MODELS["rigid"]()
    rough_way(model, 4)
    measured = film_measures(model.model, model._last)
    assert (measured > 0.0).all()  # an angle of the pin changes velocities alone
    for k, own in enumerate(measured):
        unit = np.zeros(len(measured))
        unit[k] = 1.0
        films = moved_by(model.model, model._last, unit, True)
        changes = [(one.film_thickness, STEP * one.sliding_velocity) for one in films[-2:]]
        assert own == pytest.approx(np.sqrt(sum(x @ x + v @ v for x, v in changes)), rel=1e-9)
