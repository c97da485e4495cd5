"""The storage term: exact rates, oil kept in steps of any length, calm where steps jump."""

import numpy as np
import pytest

from piston_cosim.fmu_ehd.balance import storage
from piston_cosim.fmu_ehd.balance.storage import ContentHistory
from piston_cosim.fmu_ehd.common.grid import Cells
from piston_cosim.fmu_ehd.model import LubricationModel
from piston_cosim.fmu_ehd.parameters import Parameters
from piston_cosim.fmu_ehd.step_parts import begin
from piston_cosim.tests.verification.cases.motored import (
    DEGREE,
    film_after,
    motored_film,
    motored_until,
)

SHAPE = (12, 10)
CELLS = Cells(1e-3, 1e-3, ring=True, mirrored=False)


def euler_step(past, step):
    return storage.euler_step(past, step, CELLS)


def going_on(now, before, step):
    """Past of a film that grew in its last two steps alike."""
    growth = (now - before) / step
    return ContentHistory(now, growth, growth, step)


def rate_of_change(course, ends):
    """dc/dt at the last of three times by Eq. (T1), for a content that is `course` of the time."""
    before, now, after = (np.full((1, 1), course(t)) for t in ends)
    last = ends[1] - ends[0]
    content, step = euler_step(going_on(now, before, last), ends[2] - ends[1])
    return ((after - content) / step).item()


@pytest.mark.parametrize("ratio", [0.01, 0.5, 1.0, 2.0])
def test_a_content_quadratic_in_time_has_its_exact_rate(ratio):
    assert rate_of_change(
        lambda t: 5.0 + 3.0 * t - 2.0 * t**2, (0.0, 0.1, 0.1 + 0.1 * ratio)
    ) == pytest.approx(3.0 - 0.4 * (1.0 + ratio))


@pytest.mark.parametrize("ratio", [0.01, 1.0, 5.0, 100.0])
def test_a_content_linear_in_time_has_its_exact_rate_whatever_the_steps(ratio):
    ends = (0.0, 0.1, 0.1 + 0.1 * ratio)
    assert rate_of_change(lambda t: 5.0 - 0.3 * t, ends) == pytest.approx(-0.3)


def test_the_first_step_is_backward_euler():
    content = np.random.default_rng(0).random(SHAPE)
    past, step = euler_step(ContentHistory(content, 0.0 * content, 0.0 * content, 0.0), 0.1)
    assert np.array_equal(past, content) and step == 0.1


@pytest.mark.parametrize("ratio", [2.0, 3.0, 100.0])
def test_an_error_of_the_last_step_is_not_enlarged_however_the_step_grows(ratio):
    before, error = np.ones(SHAPE), 1e-9 * np.random.default_rng(0).standard_normal(SHAPE)
    past, _ = euler_step(going_on(before + error, before, 0.1), 0.1 * ratio)
    assert np.all(
        np.abs(past - before - error) < 0.81 * np.abs(error)
    )  # zero-stable: beta stays at 4/5


def test_no_cell_ever_owes_oil():
    before, now = np.ones(SHAPE), np.full(SHAPE, 0.9)
    now[3, 4] = 0.2501
    past, step = euler_step(going_on(now, before, 0.1), 0.1)
    assert 0.0 < past.min() < 0.2 and step == pytest.approx(0.2 / 3.0)
    now[3, 4] = 0.2499  # more than 3/4 is gone: backward Euler
    past, step = euler_step(going_on(now, before, 0.1), 0.1)
    assert np.array_equal(past, now) and step == 0.1


@pytest.mark.parametrize(
    "growth, before, expected",
    [
        ([1.0, 2.0], [1.0, 2.0], 1.0),
        ([1.0, 2.0], [0.0, 0.0], 0.0),  # the oil sets in
        ([0.0, 0.0], [1.0, 2.0], 0.0),  # it stopped
        ([1.0, 2.0], [-1.0, -2.0], 0.0),  # it turned round
        ([0.3, 0.0], [1.0, 0.0], 1.0),  # 4 x 0.3 / 1
        ([0.2, 0.0], [1.0, 0.0], 0.8),
        ([1.0, 0.0], [0.2, 0.0], 0.8),
        ([1.0, 3.0], [4.0, -1.0], 4.0 * 1.0 / 17.0),
        ([1e-11, 0.0], [1e-11, 0.0], 0.0),  # round-off of a content of 1
        ([1e-5, 0.0], [1e-5, 0.0], 1.0),  # a plate that closes at 1 mm/s on 100 um in 1 us
    ],
)
def test_memory_by_hand(growth, before, expected):
    """4 r_n.r_{n-1}/max(r_n.r_n, r_{n-1}.r_{n-1}) from 0 to 1."""
    content = np.ones((1, 2))
    past = ContentHistory(content, np.array([growth]), np.array([before]), 1.0)
    assert storage.memory(past, CELLS) == pytest.approx(expected, rel=1e-14)


def test_memory_of_half_a_film_counts_images():
    """Three rows of four, of which the middle one counts twice: 4 (0.1 + 2 x 0.02) / 3."""
    column = np.array([[1.0], [1.0], [0.0]])
    past = ContentHistory(np.ones((3, 1)), column, np.array([[0.1], [0.02], [5e-1]]), 1.0)
    half = CELLS._replace(ring=False, mirrored=True)
    assert storage.memory(past, half) == pytest.approx(4.0 * 0.14 / 3.0, rel=1e-14)


@pytest.mark.parametrize("thinner", [18e-6, 10e-6])
def test_a_film_squeezed_in_one_step_and_held_stays_full(thinner):
    """Oil does not shrink: nothing opens, and the next squeeze presses at once."""
    films = [20e-6] * 3 + [thinner] * 6
    held = film_after(Parameters(SHAPE), films, step=5e-5).outputs
    assert held["film_fraction"].min() == pytest.approx(1.0, abs=1e-12)
    pressed = film_after(Parameters(SHAPE), [*films, 0.99 * thinner], step=5e-5).outputs
    assert pressed["maximum_pressure"] > 1e3


@pytest.mark.parametrize("share", [0.0, 0.25, 0.5, 0.75, 0.99])
@pytest.mark.parametrize("step", [5e-5, 5e-6])
def test_load_of_plates_that_close_on_a_cavity(share, step):
    """Plates that close on a cavity have the exact load, to round-off (1e-9).

    They approach at V and close a `share` of a step before its end. From then on the mean pressure
    between both edges is mu V L^2/h^3, as p'' = -12 mu V/h^3. On n cells along, it is 1 + 2/n^2
    times as large, because the edges are half a cell away.
    """
    full, speed = 10e-6, 2e-3
    parameters = Parameters((4, 10))
    model = LubricationModel(parameters)
    one, still = np.ones(parameters.shape), np.zeros(parameters.shape)
    opened = full + speed * step * (10.0 + share)
    state, _ = model.start(full * one, still)
    for _ in range(4):
        state, outputs = model.advance(state, opened * one, still, step)
    assert outputs["maximum_pressure"] == 0.0
    for k in range(1, 20):
        film = opened - speed * step * k
        state, outputs = model.advance(state, film * one, still, step)
        if k > 11:
            exact = parameters.oil.viscosity * speed * parameters.skirt_length**2 / film**3
            mean = outputs["nodal_pressure_force"].sum() / model.area.sum()
            assert mean == pytest.approx(exact * (1.0 + 2.0 / 10**2), rel=1e-9)


def random_ends(seed, last):
    """Return the ends of steps [s] over `last` degrees, each 0.01 to 3 degrees long."""
    lengths = 10.0 ** np.random.default_rng(seed).uniform(-2.0, 0.5, 20 * last)
    ends = np.cumsum(lengths)
    return ends[ends < last] * DEGREE


def test_oil_of_a_cycle_in_random_steps_is_the_weighted_sum_of_the_inflows():
    model = LubricationModel(
        Parameters(SHAPE, film_fraction_upper_edge=0.5, pressure_lower_edge=1e5)
    )
    start, _ = model.start(*motored_film(SHAPE, 0.0))
    state, last, inflows, lengths, shares = start, 0.0, [], [], []
    for end in random_ends(0, 720):
        length = begin(state.film, end - last, model.fixed.domain.cells).start.length
        lengths.append(length)
        shares.append((end - last - length) / state.film.step if state.film.step else 0.0)
        state, outputs = model.advance(state, *motored_film(SHAPE, end), end - last)
        inflows.append(outputs["flow_lower_edge"] + outputs["flow_upper_edge"])
        last = end
    weights, carried = np.empty(len(lengths)), 1.0
    for k in reversed(range(len(lengths))):  # G = beta G_n + H_e Q of `storage`, telescoped
        weights[k] = lengths[k] * carried
        carried = 1.0 + shares[k] * carried
    grown = model.area.max() * (state.film.content - start.film.content).sum()
    moved = np.abs(weights * inflows).sum()
    assert weights.sum() == pytest.approx(last, rel=1e-12)
    assert abs(grown - weights @ inflows) <= 1e-12 * moved  # round-off
    assert (
        abs(grown - np.diff([0.0, *random_ends(0, 720)]) @ inflows) > 1e-4 * moved
    )  # those of backward Euler would not do


def test_an_opened_film_keeps_its_oil_in_steps_of_any_length():
    model = LubricationModel(Parameters(SHAPE))
    still = np.zeros(SHAPE)
    state, _ = model.start(np.full(SHAPE, 1e-5), still)
    for step in 10.0 ** np.random.default_rng(1).uniform(-6.0, -3.0, 60):
        film = 1e-5 + 1e-2 * step  # without pressure nothing flows, however the film moves
        state, outputs = model.advance(state, np.full(SHAPE, film), still, step)
        assert np.abs(state.film.content - 1e-5).max() <= 1e-15 * 1e-5 * 60  # round-off
        assert outputs["film_fraction"] == pytest.approx(1e-5 / film, rel=1e-12)


def test_a_steady_film_stays_when_the_step_changes():
    model, state, history = motored_until(
        Parameters(SHAPE, roughness_rms=1e-6), np.arange(1, 101) * DEGREE
    )
    film, velocity = motored_film(SHAPE, 100 * DEGREE)
    for _ in range(3000):
        state, outputs = model.advance(state, film, velocity, DEGREE)
    steady = outputs["nodal_pressure_force"]
    assert outputs["film_fraction"].min() < 0.9  # a part of it is cavitated
    for factor in (100.0, 0.01, 1.0, 0.01, 100.0):
        state, outputs = model.advance(state, film, velocity, factor * DEGREE)
        assert (
            np.abs(outputs["nodal_pressure_force"] - steady).max() <= 1e-9 * steady.max()
        )  # condition x round-off / 0.01


def test_the_step_after_a_start_from_a_steady_film_is_steady():
    model = LubricationModel(
        Parameters(SHAPE, pressure_lower_edge=2e5)
    )  # parallel and at rest: pressure linear, as at the start
    film, still = np.full(SHAPE, 1e-5), np.zeros(SHAPE)
    state, first = model.start(film, still)
    for factor in (1.0, 10.0, 0.1):
        state, outputs = model.advance(state, film, still, factor * DEGREE)
        assert outputs["nodal_pressure_force"] == pytest.approx(
            first["nodal_pressure_force"], rel=1e-9
        )
