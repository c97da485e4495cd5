"""Films of the crank in the rod's big end and in the main bearing.

Films and their forces are computed by hand. `test_multibody` compares motions and forces.
"""

import dataclasses

import numpy as np
import pytest
from pydantic import ValidationError

from piston_cosim.fmu_mfbd.dynamics.model_faults import faults
from piston_cosim.fmu_mfbd.geometry.pin import PinForces
from piston_cosim.fmu_mfbd.options import Common

from .pin_models import (
    OFFSET,
    OWN,
    PARAMETERS,
    SETS,
    SPEED,
    bodies,
    crank_model,
    crank_options,
    rough_inputs,
)


def test_gaps_and_velocities_by_hand():
    """Gaps and velocities of both crank films agree with hand calculations.

    The crank pin is 3 um right of the big end's middle and 4 um above it. The journal is 5 um left
    of the main bearing's middle and 2 um below it. The rod is inclined and its shell turns with it,
    so +x of the shell is at the rod's angle.
    """
    model = crank_model()
    state, _ = model.start(0.9, 0.0, 0.0, rough_inputs(model, 0, 0.0))
    position = state.position.copy()
    position[7:] = [3e-6, 4e-6, -5e-6, -2e-6]
    _, out = model.start_moving(0.9, position, state.velocity, rough_inputs(model, 0, 0.0))
    p = PARAMETERS
    # eye minus big end: both displacements go into the rod's angle, 8 um of 223 mm
    aside = OFFSET - p.crank_offset + p.crank_radius * np.sin(0.9) + 3e-6 + 5e-6
    psi = -np.arcsin(aside / p.rod_length)
    around = 2 * np.pi * np.arange(20) / 20
    wanted = 25e-6 - 3e-6 * np.cos(around + psi) - 4e-6 * np.sin(around + psi)
    np.testing.assert_allclose(out["big_end.film_thickness"][:, 2], wanted, atol=1e-17)
    rod_speed = -p.crank_radius * np.cos(0.9) * SPEED / np.sqrt(p.rod_length**2 - aside**2)
    np.testing.assert_allclose(
        out["big_end.circumferential_velocity"], 24e-3 * (SPEED - rod_speed), rtol=1e-12
    )
    around = 2 * np.pi * np.arange(16) / 16
    wanted = 30e-6 + 5e-6 * np.cos(around) + 2e-6 * np.sin(around)
    np.testing.assert_allclose(out["main_bearing.film_thickness"][:, 1], wanted, atol=1e-17)
    np.testing.assert_allclose(
        out["main_bearing.circumferential_velocity"], 27e-3 * SPEED, rtol=1e-14
    )
    for one in ("big_end", "main_bearing"):
        assert np.all(out[f"{one}.sliding_velocity"] == 0.0)
    shown = [out[f"{one}_displacement_{way}"] for one in OWN for way in "xy"]
    assert shown == [3e-6, 4e-6, -5e-6, -2e-6]


def test_a_picometre_of_play_keeps_its_digits():
    """The crank pin moves by a picometre in the big end: the gap by as much, to six digits."""
    model = crank_model()
    state, _ = model.start(0.9, 0.0, 0.0, rough_inputs(model, 0, 0.0))
    gaps = []
    for more in (0.0, 1e-12):
        position = state.position.copy()
        position[7:9] = [20e-6 + more, 0.0]
        _, out = model.start_moving(0.9, position, state.velocity, rough_inputs(model, 0, 0.0))
        gaps.append(out["big_end.film_thickness"])
    change = gaps[1] - gaps[0]
    assert np.abs(change).max() == pytest.approx(1e-12, rel=0.05)
    wanted = np.array([np.max(np.abs(change @ np.ones(5))) / 5])
    assert wanted == pytest.approx(np.abs(change).max(), rel=1e-6)


def test_friction_of_the_crank_by_hand():
    """Friction of the crank films drives the shells, and cell forces push them outwards.

    Half a newton a cell acts against the rotation of crank pin and journal. One newton acts on the
    first cell, along the axes of rod and block. Two newtons act on the cell a quarter turn on.
    """
    model = crank_model()
    inputs = rough_inputs(model, 0, 0.0)
    drags = {f"{name}.": -0.5 for name in OWN}
    push = [np.zeros(one.shape) for one in model.grids]
    for one in push[3:]:
        one[0, 0], one[len(one) // 4, 0] = 1.0, 2.0
    pins = tuple(
        PinForces(on, np.full(one.shape, drags.get(one.prefix, 0.0)))
        for on, one in zip(push, model.grids)
    )
    _, out = model.start(0.9, 0.0, 0.0, dataclasses.replace(inputs, pins=pins))
    p = PARAMETERS
    lean = -np.arcsin((OFFSET - p.crank_offset + p.crank_radius * np.sin(0.9)) / p.rod_length)
    for name, angle in (("big_end", lean), ("main_bearing", 0.0)):
        force = [out[f"{name}_force_x"], out[f"{name}_force_y"]]
        c, s = np.cos(angle), np.sin(angle)
        np.testing.assert_allclose(force, [c - 2 * s, s + 2 * c], atol=1e-12)
    shown = [out[f"{name}_friction_moment"] for name in OWN]
    assert shown == pytest.approx([24e-3 * 100 * 0.5, 27e-3 * 64 * 0.5], rel=1e-12)


def test_what_does_not_go_with_films_of_the_crank_is_told():
    wrong = dataclasses.replace(PARAMETERS, rod_mass=0.0, rod_inertia=0.0)
    told = "\n".join(faults(bodies(), crank_options(("big_end",)), wrong))
    assert "rod_mass: expected more than 0 kg with a film in big_end, got 0 kg" in told
    assert "rod_inertia: expected more than 0 kg.m2 with a film in big_end, got 0 kg.m2" in told
    assert faults(bodies(), crank_options(SETS[-1]), PARAMETERS) == []
    beside = {"big_end": 25e-3, "main_bearing": 27.1e-3}
    (told,) = faults(bodies(), crank_options(SETS[-1]), PARAMETERS, [*OWN.values()], beside)
    assert told == "big_end_radius: expected within 2 % of the shell, 25 mm, got 24 mm"
    with pytest.raises(
        ValidationError, match=r"film_surfaces\.0\.name: expected a new name, got 'big_end'"
    ):
        Common.model_validate(
            {
                "floating_pin": {"boss_length": "20 mm", "small_end_length": "20 mm"},
                "big_end": {"length": "30 mm"},
                "film_surfaces": [{"name": "big_end", "rows": (1, 10)}],
            }
        )
