"""What must hold for every film: symmetries, scaling laws, repeatability, conservation."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from piston_cosim.fmu_ehd.laws.oil import Oil
from piston_cosim.fmu_ehd.model import LubricationModel
from piston_cosim.fmu_ehd.parameters import Parameters

pytestmark = pytest.mark.slow  # random inputs
SHAPE = (8, 10)
STEP = 1e-4
quick = settings(max_examples=25, deadline=None)


@st.composite
def cases(draw):
    """Draw a rough film in four successive shapes, with sliding velocities that may reverse."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    level = draw(st.floats(1e-6, 3e-5))
    films = level * (1.0 + 0.8 * rng.uniform(-1.0, 1.0, (4, *SHAPE)))
    speeds = np.array([draw(st.floats(-15.0, 15.0)) for _ in range(4)])
    return films, speeds[:, None, None] * np.ones(SHAPE)


def last(films, velocities, step=STEP, **parameters):
    """Return the outputs after three steps.

    The last two are of second order unless the film loses too much oil at once.
    """
    model = LubricationModel(Parameters(SHAPE, **parameters))
    state, _ = model.start(films[0], velocities[0])
    for film, velocity in zip(films[1:], velocities[1:]):
        state, outputs = model.advance(state, film, velocity, step)
    return outputs


def close(a, b):
    """Equal up to round-off of the solution, whose condition is some 1e4."""
    return np.abs(a - b).max() <= 1e-9 * max(np.abs(b).max(), 1e-300)


TURNED = {
    "mirrored about the thrust plane": (lambda field: field[..., ::-1, :], 1.0),
    "upside down, sliding reversed": (lambda field: field[..., ::-1], -1.0),
    "rotated": (lambda field: np.roll(field, 3, axis=-2), 1.0),
}
"""Films, and the sign of sliding and friction, that turn the answer in the same way."""


@pytest.mark.parametrize("name", TURNED)
@quick
@given(case=cases())
def test_a_turned_film_has_the_turned_answer(name, case):
    turn, sign = TURNED[name]
    films, velocities = case
    straight, turned = last(films, velocities), last(turn(films).copy(), sign * velocities)
    assert close(turned["nodal_pressure_force"], turn(straight["nodal_pressure_force"]))
    assert close(turned["nodal_friction_force"], sign * turn(straight["nodal_friction_force"]))


@quick
@given(cases())
def test_double_viscosity_doubles_every_force(case):
    films, velocities = case
    single, double = (
        last(films, velocities, oil=Oil(viscosity=0.01)),
        last(films, velocities, oil=Oil(viscosity=0.02)),
    )
    assert close(double["nodal_pressure_force"], 2.0 * single["nodal_pressure_force"])
    assert close(double["nodal_friction_force"], 2.0 * single["nodal_friction_force"])
    assert close(double["film_fraction"], single["film_fraction"])


@quick
@given(cases())
def test_twice_the_speed_in_half_the_time_doubles_the_pressure(case):
    films, velocities = case
    slow, fast = last(films, velocities), last(films, 2.0 * velocities, step=0.5 * STEP)
    assert close(fast["nodal_pressure_force"], 2.0 * slow["nodal_pressure_force"])
    assert close(fast["film_fraction"], slow["film_fraction"])


@quick
@given(cases(), st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_oil_is_conserved_and_the_film_is_never_more_than_full(case, lower, upper):
    films, velocities = case
    outputs = last(
        films, velocities, film_fraction_lower_edge=lower, film_fraction_upper_edge=upper
    )
    assert outputs["mass_imbalance"] <= 1e-12
    assert (
        outputs["film_fraction"].min() >= -1e-15 and outputs["film_fraction"].max() <= 1.0 + 1e-12
    )
    assert outputs["pressure"].min() >= -1e-9 * max(outputs["maximum_pressure"], 1.0)


@quick
@given(st.integers(0, 2**32 - 1), st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_no_jump_of_film_velocity_or_step_breaks_the_film(seed, lower, upper):
    rng = np.random.default_rng(seed)
    supply = dict(film_fraction_lower_edge=lower, film_fraction_upper_edge=upper)
    model = LubricationModel(Parameters(SHAPE, roughness_rms=1e-6, **supply))
    state, _ = model.start(np.full(SHAPE, 1e-5), np.zeros(SHAPE))
    for _ in range(15):
        film = 10.0 ** rng.uniform(-7.0, -4.5) * rng.uniform(-0.3, 1.0, SHAPE)
        film = np.maximum(film, -1.4e-6)  # here and there it overlaps, Eq. (A14)
        step = STEP * 10.0 ** rng.uniform(-2.0, 2.0)
        state, outputs = model.advance(state, film, np.full(SHAPE, rng.uniform(-15.0, 15.0)), step)
        assert outputs["mass_imbalance"] <= 1e-12
        assert (
            outputs["film_fraction"].min() >= -1e-12
            and outputs["film_fraction"].max() <= 1.0 + 1e-12
        )
