"""What changes between two steps: thermal growth of piston and bore, and the damping of modes."""

import dataclasses

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.dynamics.assembly import assemble
from piston_cosim.fmu_mfbd.dynamics.parameters import (
    TUNABLE,
    Damping,
    Parameters,
    settings_of,
)
from piston_cosim.fmu_mfbd.dynamics.thermal_growth import Radii, thermal_opening

from .pin_models import PARAMETERS, all_that_yields, crank_model, rough_inputs
from .test_model import STEP, inputs, run
from .test_motion_in_space import space_model

WARM, HOT = 293.15, 393.15
USUAL = Parameters()
ACCOUNT = ("film_power", "received_power", "thermal_opening")
COUNTS = ("residual_evaluations", "jacobian_evaluations")


@pytest.fixture
def built(reduced):
    """Make the small bodies with some parameters."""
    options, piston, block = reduced

    def make(**values):
        return assemble(piston, block, options, Parameters(crank_offset=1e-3, **values))

    return make


def taken(model, steps=4, **given):
    """State and outputs after some steps, and of one more with other inputs."""
    state, _ = run(model, steps)
    last = dataclasses.replace(inputs(model, steps), **given)
    return (*model.advance(state, last, STEP), last)


def same(one, other, but=()):
    """Assert that all outputs but some have the same bits."""
    assert one.keys() == other.keys()
    for name, value in one.items():
        if name not in (*but, *COUNTS):
            np.testing.assert_array_equal(value, other[name], err_msg=name)


def test_growth_by_hand():
    """A piston grows by 103.5 um and a bore by 24.7775 um in radius.

    The piston has 90 mm, 23e-6/K and 100 K. The bore has 90.1 mm, 11e-6/K and 50 K.
    """
    p = settings_of(Parameters(piston_expansion=23e-6, bore_expansion=11e-6))
    radii = Radii(45e-3, 45.05e-3)
    assert thermal_opening(radii, HOT, WARM, p) == pytest.approx(-103.5e-6, rel=1e-12)
    assert thermal_opening(radii, WARM, WARM + 50.0, p) == pytest.approx(24.7775e-6, rel=1e-12)
    cold = p._replace(reference_temperature=HOT)
    assert thermal_opening(radii, HOT, WARM, cold) == pytest.approx(-49.555e-6, rel=1e-12)


def test_at_the_reference_temperature_nothing_grows(built):
    """Whatever the coefficients: the bits of a body that cannot grow."""
    growing = built(piston_expansion=5e-5, bore_expansion=3e-5)
    rigid = built(piston_expansion=0.0, bore_expansion=0.0)
    _, out, _ = taken(growing)
    same(out, taken(rigid)[1])
    same(out, taken(rigid, piston_temperature=HOT, bore_temperature=HOT)[1])
    assert out["thermal_opening"] == 0.0


def test_growth_closes_the_film_and_does_work_on_it(built):
    """Forces of the films push back against growth. In the next step nothing grows on."""
    model = built()
    _, cold, _ = taken(model)
    state, hot, last = taken(model, piston_temperature=WARM + 5.0, bore_temperature=WARM + 2.0)
    radii = model.model.radii
    opening = 11e-6 * radii.bore * 2.0 - 20e-6 * radii.skirt * 5.0
    assert hot["thermal_opening"] == pytest.approx(opening, rel=1e-12) and opening < -1e-6
    same(cold, hot, (*ACCOUNT, "film_thickness"))
    gap = hot["film_thickness"] - cold["film_thickness"]
    np.testing.assert_allclose(gap, opening, rtol=1e-9)
    work = last.pressure_force.sum() * opening / STEP
    for name in ("film_power", "received_power"):
        added = hot[name] - cold[name]
        assert added == pytest.approx(work, rel=1e-9 * abs(hot[name] / work) + 1e-12)
    still = model.advance(state, last, STEP)[1]
    cool = model.advance(state._replace(thermal_opening=0.0), last, STEP)[1]
    added = cool["film_power"] - still["film_power"]
    assert added == pytest.approx(work, rel=1e-9 * abs(still["film_power"] / work) + 1e-12)


def damped(values, of=USUAL):
    """Return the damping of parameters with some changed."""
    return Damping(*(values.get(name, getattr(of, name)) for name in TUNABLE))


OTHER = dict(
    damping_ratio=0.3,
    high_frequency_damping_ratio=0.7,
    damping_transition_frequency=2e4,
)
HARD = dataclasses.replace(PARAMETERS, **OTHER)
FLEXIBLE = {
    "pin that bends": all_that_yields,
    "crank": lambda p=PARAMETERS: crank_model(
        yielding=True, **{name: getattr(p, name) for name in TUNABLE}
    ),
}


def test_damping_acts_from_the_next_step_on(built):
    """As of a body that was built with it, to the bit; and no longer, once it is set back."""
    model, other = built(), built(**OTHER)
    state, out, last = taken(model)
    model.damp(damped(OTHER))
    ends = [one.advance(state, last, STEP)[1] for one in (model, other)]
    same(*ends)
    model.damp(damped({}))
    usual = built().advance(state, last, STEP)[1]
    same(model.advance(state, last, STEP)[1], usual)
    assert np.abs(ends[0]["modal_velocity"] - usual["modal_velocity"]).max() > 1e-6


@pytest.mark.parametrize("name", FLEXIBLE)
def test_damping_of_pin_and_shells_acts_from_the_next_step_on(name):
    model, other = FLEXIBLE[name](), FLEXIBLE[name](HARD)
    state, _ = model.start(0.3, 2e-6, 1e-4, rough_inputs(model, 0, 0.0))
    for k in range(3):
        state, _ = model.advance(state, rough_inputs(model, k), STEP)
    usual = model.advance(state, rough_inputs(model, 3), STEP)[1]
    model.damp(damped(OTHER))
    ends = [one.advance(state, rough_inputs(one, 3), STEP)[1] for one in (model, other)]
    same(*ends)
    model.damp(damped({}, PARAMETERS))
    same(model.advance(state, rough_inputs(model, 3), STEP)[1], usual)
    assert np.abs(ends[0]["modal_velocity"] - usual["modal_velocity"]).max() > 0.0


def test_a_piston_in_space_grows_and_takes_a_damping():
    """It has no modes, so that damping changes nothing."""
    model = space_model()
    given = rough_inputs(model, 3)
    state, _ = model.start(0.3, 2e-6, 1e-4, rough_inputs(model, 0))
    cold = model.advance(state, given, STEP)[1]
    model.damp(damped(OTHER))
    hot = model.advance(state, dataclasses.replace(given, piston_temperature=HOT), STEP)[1]
    same(cold, hot, (*ACCOUNT, "film_thickness"))
    opening = -20e-6 * 54.95e-3 * 100.0
    np.testing.assert_allclose(hot["film_thickness"] - cold["film_thickness"], opening, rtol=1e-9)
