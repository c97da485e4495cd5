"""The steady state of a film alone: closed form, published table, errors."""

import numpy as np
import pytest

import piston_cosim as pc
from piston_cosim.fmu_ehd.laws.cavitation import NotConverged
from piston_cosim.tests.verification.cases import bearings

RADIUS, LENGTH, VISCOSITY, SPEED, LEAST = 28.25e-3, 27e-3, 0.02, 8.0, 10e-6
BEARING = (160, 40)


def pad_error(cells, ratio):
    """Relative error of an inclined pad's load, h = h0 (1 + K (1 - y/L))."""
    film = pc.Film((4, cells), bore_radius=RADIUS, skirt_length=LENGTH, viscosity=VISCOSITY)
    y = (np.arange(cells) + 0.5) / cells
    thickness = np.broadcast_to(LEAST * (1.0 + ratio * (1.0 - y)), (4, cells))
    outputs = film.steady(thickness, sliding_velocity=-SPEED)
    load = outputs["nodal_pressure_force"].sum() / (2 * np.pi * RADIUS)
    scale = 6 * VISCOSITY * SPEED * (LENGTH / LEAST) ** 2
    return abs(load / (scale * (np.log(1 + ratio) - 2 * ratio / (2 + ratio)) / ratio**2) - 1.0)


@pytest.mark.parametrize("ratio", [0.5, 1.0, 2.0])
def test_an_inclined_pad_converges_to_its_closed_form_with_second_order(ratio):
    coarse, fine = pad_error(40, ratio), pad_error(80, ratio)
    assert fine < 1e-3  # 5e-4 at K = 2
    assert np.log2(coarse / fine) == pytest.approx(2.0, abs=0.1)


def journal(eccentricity, **parameters):
    """The film of a bearing of L/D = 1 and its thickness."""
    film = pc.Film(
        BEARING,
        surface="bearing",
        bore_radius=bearings.RADIUS,
        skirt_length=2.0 * bearings.RADIUS,
        viscosity=bearings.VISCOSITY,
        minimum_flow_film=1e-9,
        **parameters,
    )
    return film, bearings.eccentric(BEARING, eccentricity)


@pytest.mark.parametrize("eccentricity", [0.4, 0.6, 0.8])
def test_a_cavitated_journal_bearing_agrees_with_the_table(eccentricity):
    """Sommerfeld number and attitude angle of [Raimondi1958], allowed as in `verify ehd`."""
    film, thickness = journal(eccentricity, open_cells=bearings.grooved(BEARING))
    outputs = film.steady(thickness, circumferential_velocity=bearings.SPEED)
    assert outputs["film_fraction"].min() < 0.9
    x, y = bearings.resultant(outputs["nodal_pressure_force"])
    speed = bearings.SPEED / bearings.RADIUS / (2.0 * np.pi)
    area = (2.0 * bearings.RADIUS) ** 2
    ratio = bearings.CLEARANCE / bearings.RADIUS
    sommerfeld = bearings.VISCOSITY * speed * area / np.hypot(x, y) / ratio**2
    expected, attitude, *_ = bearings.TABLE[1.0, eccentricity]
    assert sommerfeld == pytest.approx(expected, rel=0.016)
    assert np.degrees(np.arctan2(-y, x)) == pytest.approx(attitude, abs=1.0)


def test_short_steps_reach_the_same_state():
    film, thickness = journal(0.6, open_cells=bearings.grooved(BEARING))
    steady = film.steady(thickness, circumferential_velocity=bearings.SPEED)
    film.start(thickness, circumferential_velocity=bearings.SPEED)
    for length in 4.0 ** np.arange(-7, 8):
        outputs = film.step(thickness, length, circumferential_velocity=bearings.SPEED)
    peak = steady["pressure"].max()
    assert np.abs(outputs["pressure"] - steady["pressure"]).max() <= 1e-9 * peak
    assert np.abs(outputs["film_fraction"] - steady["film_fraction"]).max() <= 1e-9


def test_the_steady_film_stays_in_the_next_step():
    film, thickness = journal(0.8, open_cells=bearings.grooved(BEARING))
    steady = film.steady(thickness, circumferential_velocity=bearings.SPEED)
    after = film.step(thickness, 1e-4, circumferential_velocity=bearings.SPEED)
    peak = steady["pressure"].max()
    assert np.abs(after["pressure"] - steady["pressure"]).max() <= 1e-8 * peak
    assert after["friction_power"] == pytest.approx(steady["friction_power"], rel=1e-8)


def test_a_step_may_be_an_integer():
    film = pc.Film((4, 8))
    film.start(1e-5, sliding_velocity=1.0)
    assert film.step(1e-5, 1, sliding_velocity=1.0)["film_fraction"].max() <= 1.0


def test_a_film_that_does_not_become_steady_raises_and_keeps_its_state(monkeypatch):
    film = pc.Film((4, 8))
    film.start(1e-5, sliding_velocity=1.0)
    state = film.state

    def fail(*_, **__):
        raise NotConverged("no solution")

    monkeypatch.setattr(film.model, "advance", fail)
    with pytest.raises(pc.Discard, match="the film does not become steady: no solution"):
        film.steady(1e-5, sliding_velocity=1.0)
    assert film.state is state


def test_a_change_above_the_tolerance_raises():
    film, thickness = journal(0.6, open_cells=bearings.grooved(BEARING))
    with pytest.raises(pc.Discard, match="expected a change of at most -1, got"):
        film.steady(thickness, circumferential_velocity=bearings.SPEED, tolerance=-1.0)


def test_oil_from_the_bore_is_rejected():
    film = pc.Film((4, 8), oil_supply="bore")
    with pytest.raises(pc.BadInput, match="oil_supply: expected edges for a steady film, got bore"):
        film.steady(1e-5, sliding_velocity=1.0)
