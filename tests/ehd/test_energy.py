"""Energy that a film takes from the bodies that move it.

It is the energy stored and turned into heat, less the work of the pressure around the film.
"""

import numpy as np
import pytest

from piston_cosim.fmu_ehd.balance import reynolds
from piston_cosim.fmu_ehd.balance.films import smooth_film
from piston_cosim.fmu_ehd.common.grid import Entrainment
from piston_cosim.fmu_ehd.laws.oil import Oil
from piston_cosim.fmu_ehd.model import LubricationModel
from piston_cosim.fmu_ehd.parameters import Parameters
from piston_cosim.tests.verification.cases.bearings import RADIUS, SPEED, bearing, eccentric
from piston_cosim.tests.verification.cases.motored import film_after, opening

SHAPE = (8, 6)
STILL = np.zeros(SHAPE)
SLOW = 1e9  # [s]


def flat(gap):
    """Return a film of one thickness [m]."""
    return np.full(SHAPE, gap)


@pytest.mark.parametrize("coating", [0.0, 20e-6])
def test_contact_gives_back_what_it_took(coating):
    """Contact returns the energy that it took: the stored energy is the work of the forces.

    Asperities, and a coating in series with them, are pressed from 12 to 1 um and back.
    Steps of 1e9 s are so slow that the oil has no effect.
    """
    p = Parameters(SHAPE, roughness_rms=2e-6, coating_thickness=coating)
    model = LubricationModel(p)
    way = np.linspace(12e-6, 1e-6, 441)
    state, outputs = model.start(flat(way[0]), STILL)
    begun = outputs["stored_energy"]
    force, work, taken = outputs["nodal_pressure_force"].sum(), 0.0, 0.0
    for before, gap in zip(way, way[1:]):
        state, outputs = model.advance(state, flat(gap), STILL, SLOW)
        after = outputs["nodal_pressure_force"].sum()
        work -= (force + after) / 2 * (gap - before)
        force = after
        taken += SLOW * outputs["received_power"]
    stored = outputs["stored_energy"] - begun
    # the trapezoidal rule on an eightieth of the roughness: 1/80^2/12 of the energy
    assert stored == pytest.approx(work, rel=1e-4)
    # the oil that is pressed out takes 3e-11 of the energy
    assert taken == pytest.approx(stored, rel=1e-10)
    for gap in way[::-1]:
        state, outputs = model.advance(state, flat(gap), STILL, SLOW)
        taken += SLOW * outputs["received_power"]
    assert abs(taken) <= 1e-9 * stored


def test_what_turns_a_steady_journal_is_heat():
    """The work that turns a steady journal is heat.

    The eccentricity is 0.8, nothing is squeezed, and the ends have no pressure.
    The heat is the whole work of the moment about the journal's own axis.
    This moment consists of shear and of pressure on the slope of the film.
    """
    shape = (60, 10)
    model = bearing(shape, RADIUS, cavitation_model="gumbel", cavity_shear="full_film")
    films = [eccentric(shape, 0.8)] * 3
    outputs = film_after(model.parameters, films, step=1e-2, turning=SPEED).outputs
    assert outputs["received_power"] == pytest.approx(outputs["friction_power"], rel=1e-12)
    assert outputs["friction_power"] > -1.1 * outputs["friction_torque"] * SPEED / RADIUS


def test_sliding_turns_work_into_heat():
    """Sliding turns work into heat, mu V^2 / h on the area, as much as its friction takes.

    The film is full, 10 um thick and without pressure; the steps are 0.1 ms.
    """
    p = Parameters(SHAPE)
    outputs = film_after(p, [1e-5] * 2, 5.0).outputs
    area = 2.0 * np.pi * p.bore_radius * p.skirt_length
    heat = area * p.oil.viscosity * 25.0 / 1e-5
    names = "received_power", "friction_power", "heat_generated", "friction_power_hydrodynamic"
    for name in names:
        assert outputs[name] == pytest.approx(heat, rel=1e-12)
    assert outputs["friction_power_asperity"] == 0.0


@pytest.mark.parametrize("cavitation, edges", [(0.0, 3e5), (2e4, 2e4), (-5e4, 1e5)])
def test_what_the_pressure_around_does_is_not_taken_from_the_bodies(cavitation, edges):
    """The work of the pressure around the film is not taken from the bodies.

    Plates part from 10 to 12 um so slowly that p is the pressure of the edges everywhere.
    The film gives the bodies p dV, which came in with the oil.
    """
    p = Parameters(
        SHAPE,
        cavitation_pressure=cavitation,
        pressure_lower_edge=edges,
        pressure_upper_edge=edges,
    )
    model, _, outputs = film_after(p, [1e-5, 1.2e-5], step=SLOW)
    opened = model.area.sum() * 2e-6
    # oil drawn in over 1e9 s costs 1e-11 of the pressure
    assert SLOW * outputs["received_power"] == pytest.approx(-edges * opened, rel=1e-10)


HIGH = 3e8  # at the edges, so that no cell of the films below cavitates [Pa]
OWN = dict(opening_supply="own", pressure_openings=HIGH)
FULL = {
    "newtonian": dict(),
    "gauge": dict(cavitation_pressure=-2e4),
    "roelands": dict(oil=Oil(pressure_viscosity_law="roelands_1966")),
    "cross": dict(oil=Oil(shear_thinning_law="cross_1965")),
    "coating": dict(coating_thickness=2e-5),
    "cut-out": OWN | dict(open_cells=opening(SHAPE)),
    "bearing": dict(surface="bearing"),
    "sector": OWN | dict(surface="bearing", sector_angle=2.0),
}


@pytest.mark.parametrize("choice", FULL)
def test_a_full_film_takes_the_work_of_its_surfaces(choice):
    """A full film takes the work of its surfaces under random films, velocities and steps.

    It is the work of sliding and of the pressure on the film thickness, by the mean of both ends.
    """
    edges = dict(pressure_lower_edge=HIGH, pressure_upper_edge=1.1 * HIGH)
    model = LubricationModel(Parameters(SHAPE, **edges | FULL[choice]))
    rng = np.random.default_rng(0)
    film = 2e-5 + 1e-5 * rng.random(SHAPE)
    turning = STILL
    state, _ = model.start(film, STILL, turning)
    # a coating starts undeformed
    state, outputs = model.advance(state, film, STILL, 1e-4, turning)
    for step in (1e-4, 2e-4, 3e-4, 1e-4):
        before, force = film, outputs["nodal_pressure_force"]
        stored = outputs["stored_energy"]
        film = film * (1.0 + 0.02 * rng.standard_normal(SHAPE))
        if model.parameters.surface == "bearing":
            turning = 5.0 * rng.standard_normal(SHAPE)
        state, outputs = model.advance(state, film, rng.standard_normal(SHAPE), step, turning)
        assert outputs["film_fraction"].min() == 1.0
        pushed = (force + outputs["nodal_pressure_force"]) / 2 * (film - before)
        work = step * outputs["friction_power"] - pushed.sum()
        # round-off of the content, 1e-16 of 20 um, by a change of 0.2 um
        assert step * outputs["received_power"] == pytest.approx(work, rel=1e-10)
        opened = (model.area * (film - before)).sum()
        heat = work - (outputs["stored_energy"] - stored)
        heat += model.parameters.cavitation_pressure * opened  # pressures count from it
        assert step * outputs["heat_generated"] == pytest.approx(heat, rel=1e-9)


def wedge(shape, squeezed, sliding):
    """Return the energy that a wedge takes in a step, and the heat less the work of its edges [J].

    The wedge is between edges under pressure and is squeezed by a height [m].
    The heat is that of its faces and of sliding.
    """
    p = Parameters(shape, pressure_lower_edge=HIGH, pressure_upper_edge=2.0 * HIGH)
    model = LubricationModel(p)
    along = (np.arange(shape[1]) + 0.5) / shape[1]
    film = np.ascontiguousarray(np.broadcast_to(1e-5 * (1.0 + along), shape))
    velocity = np.full(shape, sliding)
    step = 1e-4
    state, _ = model.start(film + squeezed, velocity)
    state, begin = model.advance(state, film + squeezed, velocity, step)
    _, end = model.advance(state, film, velocity, step)
    viscosity = np.full(shape, p.oil.viscosity)
    quantities, _ = smooth_film(film, viscosity, p.minimum_flow_film)
    still = np.zeros(shape)
    domain = model.fixed.domain
    at_rest = Entrainment(still, still)
    faces = reynolds.faces(quantities, at_rest, domain.open_cells, domain.cells)

    def drops(pressure):
        """Pressure drops over the axial faces [Pa]."""
        before = np.full((shape[0], 1), HIGH)
        return -np.diff(np.hstack([before, pressure, 2.0 * before]))

    mean = (drops(begin["pressure"]) + drops(end["pressure"])) / 2
    heat = (faces.conductance_a * drops(end["pressure"]) * mean).sum()
    heat += (model.area * viscosity * sliding**2 / film).sum()  # Q of `account`
    edges = HIGH * end["flow_lower_edge"] + 2.0 * HIGH * end["flow_upper_edge"]
    return end["received_power"], heat - edges


def test_heat_of_pressure_flow_is_that_of_the_faces():
    """The heat of pressure flow, Q of `account`, is the heat of the faces.

    Without sliding it is so to round-off, with the mean pressure of a step.
    Under steady sliding h dp/dy differs, because flow and shear use different film thicknesses.
    """
    taken, heat = wedge(SHAPE, 2e-7, 0.0)
    assert taken == pytest.approx(heat, rel=1e-11)
    apart = []
    for cells in (8, 16):
        taken, heat = wedge((4, cells), 0.0, 5.0)
        apart.append(abs(taken / heat - 1.0))
    assert apart[0] < 1e-2
    assert apart[0] / apart[1] > 3.5  # of second order


@pytest.mark.parametrize("drop", [1e5, -1e5])
def test_oil_leaves_above_where_the_pressure_falls(drop):
    """Between pressures at both edges: q = b h^3 drop/(12 mu l), against the net inflow."""
    p = Parameters(SHAPE, pressure_lower_edge=max(drop, 0.0), pressure_upper_edge=max(-drop, 0.0))
    outputs = film_after(p, [1e-5] * 2).outputs
    width = 2 * np.pi * p.bore_radius
    flow = width * 1e-15 * drop / (12 * p.oil.viscosity * p.skirt_length)
    assert outputs["outflow_upper_edge"] == pytest.approx(max(flow, 0.0), rel=1e-10)
    assert outputs["flow_upper_edge"] == pytest.approx(-flow, rel=1e-10)


def test_oil_leaves_and_enters_above_at_once():
    """Oil leaves and enters above at the same time.

    Sliding draws oil in at the thin half, and pressure drives it out at the thick half.
    """
    film = np.repeat([[5e-6], [4e-5]], 20, axis=0)
    outputs = film_after(Parameters((40, 6), pressure_lower_edge=1e7), [film] * 3, 0.5).outputs
    inflow = outputs["flow_upper_edge"] + outputs["outflow_upper_edge"]
    assert outputs["outflow_upper_edge"] > 1e-9 and inflow > 1e-9


def test_tuned_viscosity_is_that_of_another_start():
    """A step with a changed viscosity equals that of a model that starts with it.

    The film is full and nothing is squeezed, so that the past does not matter.
    """
    thin, thick = Parameters(SHAPE), Parameters(SHAPE, oil=Oil(viscosity=0.02))
    sliding = flat(5.0)
    forces = []
    for p, changed in ((thin, {"viscosity": 0.02}), (thick, {})):
        model = LubricationModel(p)
        state, _ = model.start(flat(1e-5), sliding)
        forces.append(model.advance(state, flat(1e-5), sliding, 1e-4, **changed)[1])
    for name in ("friction_power", "nodal_friction_force"):
        np.testing.assert_allclose(forces[0][name], forces[1][name], rtol=1e-12)
