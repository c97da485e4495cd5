"""What a film takes from the bodies that move it: what it stores and rubs into heat, less what the
pressure around it does.
"""

import numpy as np
import pytest

from piston_cosim.fmu_ehd.model import LubricationModel
from piston_cosim.fmu_ehd.parameters import Parameters
from piston_cosim.tests.verification.cases.bearings import RADIUS, SPEED, bearing, eccentric

SHAPE = (8, 6)
STILL = np.zeros(SHAPE)


def flat(gap):
    """A film of one thickness [m]."""
    return np.full(SHAPE, gap)


@pytest.mark.parametrize("coating", [0.0, 20e-6])
def test_contact_gives_back_what_it_took(coating):
    """Asperities, and a coating in series with them, pressed from 12 to 1 um and back so slowly
    that the oil does nothing: what is stored is the work of the forces.
    """
    p = Parameters(SHAPE, roughness_rms=2e-6, coating_thickness=coating)
    model = LubricationModel(p)
    way = np.linspace(12e-6, 1e-6, 441)
    state, outputs = model.start(flat(way[0]), STILL)
    begun = outputs["stored_energy"]
    force, work, taken = outputs["nodal_pressure_force"].sum(), 0.0, 0.0
    for before, gap in zip(way, way[1:]):
        state, outputs = model.advance(state, flat(gap), STILL, 1e3)
        after = outputs["nodal_pressure_force"].sum()
        work -= (force + after) / 2 * (gap - before)
        force = after
        taken += outputs["energy_gain"]
    stored = outputs["stored_energy"] - begun
    # the trapezoidal rule on an eightieth of the roughness: 1/80^2/12 of the energy, and of the
    # oil pressed out in 1e3 s nothing
    assert stored == pytest.approx(work, rel=1e-4)
    assert taken == pytest.approx(stored, rel=1e-12)
    for gap in way[::-1]:
        state, outputs = model.advance(state, flat(gap), STILL, 1e3)
        taken += outputs["energy_gain"]
    assert abs(taken) <= 1e-9 * stored


def test_what_turns_a_steady_journal_is_heat():
    """Eccentric by 0.8, nothing squeezes, ends without pressure: all that its moment about its own
    axis does, shear and pressure on the slope of the film, and no more.
    """
    shape = (60, 10)
    model = bearing(shape, RADIUS, cavitation_model="gumbel", cavity_shear="full_film")
    still, turning = np.zeros(shape), np.full(shape, SPEED)
    film = eccentric(shape, 0.8)
    state, _ = model.start(film, still, turning)
    for _ in range(2):
        state, outputs = model.advance(state, film, still, 1e-2, turning)
    assert outputs["energy_gain"] == pytest.approx(1e-2 * outputs["friction_power"], rel=1e-12)
    assert outputs["friction_power"] > -1.1 * outputs["friction_torque"] * SPEED / RADIUS


def test_sliding_turns_work_into_heat():
    """A full film of 10 um, nothing pressed: mu V^2 / h on the area, in steps of 0.1 ms; as much as
    its friction takes.
    """
    model = LubricationModel(Parameters(SHAPE))
    sliding = np.full(SHAPE, 5.0)
    state, _ = model.start(flat(1e-5), sliding)
    _, outputs = model.advance(state, flat(1e-5), sliding, 1e-4)
    p = model.parameters
    area = 2.0 * np.pi * p.bore_radius * p.skirt_length
    heat = 1e-4 * area * p.oil.viscosity * 25.0 / 1e-5
    assert outputs["energy_gain"] == pytest.approx(heat, rel=1e-12)
    assert outputs["energy_gain"] == pytest.approx(1e-4 * outputs["friction_power"], rel=1e-12)


@pytest.mark.parametrize("cavitation, edges", [(0.0, 3e5), (2e4, 2e4), (-5e4, 1e5)])
def test_what_the_pressure_around_does_is_not_taken_from_the_bodies(cavitation, edges):
    """Plates that part from 10 to 12 um so slowly that p is that of the edges everywhere: the film
    gives the bodies p dV, which came in with the oil.
    """
    model = LubricationModel(
        Parameters(
            SHAPE,
            cavitation_pressure=cavitation,
            pressure_lower_edge=edges,
            pressure_upper_edge=edges,
        )
    )
    state, _ = model.start(flat(1e-5), STILL)
    _, outputs = model.advance(state, flat(1.2e-5), STILL, 1e6)
    opened = model.area.sum() * 2e-6
    # oil drawn in over 1e6 s costs 1e-9 of the pressure
    assert outputs["energy_gain"] == pytest.approx(-edges * opened, rel=1e-8)
