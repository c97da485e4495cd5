"""Transport of oil through a cavitated film: sharp fronts, order, bounds, mass, repeat."""

from typing import NamedTuple

import numpy as np
import pytest

import piston_cosim as pc
from piston_cosim.fmu_ehd import oil_rows
from piston_cosim.fmu_ehd.balance.transport import StepRatios
from piston_cosim.fmu_ehd.common.grid import Edges
from piston_cosim.fmu_ehd.common.quantities import CARRIERS
from piston_cosim.fmu_ehd.model import LubricationModel
from piston_cosim.fmu_ehd.parameters import Parameters
from piston_cosim.fmu_ehd.step_parts import PreviousFilm
from piston_cosim.tests.verification.cases.grids import FilmStep, Grid
from piston_cosim.tests.verification.cases.motored import (
    DEGREE,
    UNEVEN,
    SkirtMotion,
    film_after,
    motored_tangent_error,
    motored_until,
    tangent_error,
)

FILM = 1e-5  # [m]
ENTRAINMENT = 5.0  # [m/s], from the lower edge to the upper one
EMPTY, FULLER = 0.2, 0.8  # film fraction before and behind the front


class Transport(NamedTuple):
    """Transport of oil along the skirt; `distance` is in skirt lengths since t = 0.

    `fraction` is the film fraction along the skirt. The largest mass imbalance, the highest and the
    lowest film fraction are those of all steps since.
    """

    fraction: np.ndarray
    distance: float
    imbalance: float
    highest: float
    lowest: float


def carry(cells, courant, supply, distance=0.5, sign=1.0, bearing=False):
    """Run a parallel film between starved edges with supply(skirt lengths since t = 0) at inlet.

    The film of a bearing is a sector that is as long around as a skirt along its axis.
    """
    p = Parameters((4, cells), film_fraction_lower_edge=EMPTY, film_fraction_upper_edge=EMPTY)
    slides = np.full(p.shape, -2.0 * ENTRAINMENT * sign), None
    inlet = "film_fraction_lower_edge" if sign > 0.0 else "film_fraction_upper_edge"
    step = courant * p.skirt_length / cells / ENTRAINMENT
    if bearing:
        p = Parameters(
            (cells, 4),
            surface="bearing",
            sector_angle=np.pi,
            bore_radius=p.skirt_length / np.pi,
            opening_supply="own",
            film_fraction_openings=EMPTY,
            film_fraction_lower_edge=EMPTY,
            film_fraction_upper_edge=EMPTY,
        )
        slides = np.zeros(p.shape), np.full(p.shape, 2.0 * ENTRAINMENT * sign)
        inlet = "film_fraction_openings"
    model = LubricationModel(p)
    film = np.full(p.shape, FILM)
    state, _ = model.start(film, *slides)
    filling = int(np.ceil(2.0 * cells / courant))  # until the oil of the start is gone
    fractions = []
    imbalances = []
    for k in range(filling + round(distance * cells / courant)):
        since = (k + 1 - filling) * courant / cells
        motion = film, slides[0], step, slides[1]
        state, outputs = model.advance(state, *motion, **{inlet: supply(since)})
        imbalances.append(outputs["mass_imbalance"])
        if k >= filling:
            fraction = outputs["film_fraction"]
            fractions.append(fraction[:, 0] if bearing else fraction[0])
    fractions = np.array(fractions)
    last = fractions[-1] if sign > 0.0 else fractions[-1][::-1]
    return Transport(last, since, max(imbalances), fractions.max(), fractions.min())


def front(since):
    """Return the film fraction of a front that enters at t = 0."""
    return EMPTY if since <= 0.0 else FULLER


def cells_of_the_front(fraction):
    """Cells between 10 and 90 % of the front."""
    share = (fraction - EMPTY) / (FULLER - EMPTY)
    return np.count_nonzero((share > 0.1) & (share < 0.9))


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("courant", [0.2, 1.0, 1.5])
def test_a_front_stays_sharp_in_both_directions(courant, sign):
    run = carry(80, courant, front, sign=sign)
    assert cells_of_the_front(run.fraction) <= 5  # upwind: 16 after 40 cells
    assert run.highest <= FULLER + 1e-9
    assert run.lowest >= EMPTY - 1e-9
    assert run.imbalance <= 1e-12  # round-off
    # the oil that came in got as far, to half a step of entry and half a cell
    ahead = (run.fraction - EMPTY).sum() / (FULLER - EMPTY) / 80
    assert ahead == pytest.approx(run.distance, abs=0.5 * (1.0 + courant) / 80)


def test_a_front_converges_with_the_grid():
    def error(cells):
        run = carry(cells, 0.4, front)
        y = (np.arange(cells) + 0.5) / cells
        return np.abs(run.fraction - np.where(y < run.distance, FULLER, EMPTY)).mean()

    # a jump moved by a scheme of order p converges with p/(p+1): upwind 1/2, here 3/4
    assert np.log2(error(40) / error(80)) >= 0.65


def test_a_smooth_film_fraction_is_carried_with_second_order():
    def wave(since):
        return 0.5 + 0.2 * np.cos(4.0 * np.pi * since)

    def error(cells):
        run = carry(cells, 0.4, wave)
        y = (np.arange(cells) + 0.5) / cells
        return np.abs(run.fraction - wave(run.distance - y)).mean()

    for sign in (1.0, -1.0):  # also over the edges
        assert carry(20, 0.4, wave, sign=sign).imbalance <= 1e-12  # round-off
    errors = [error(cells) for cells in (20, 40, 80)]
    assert np.log2(errors[1] / errors[2]) >= 1.8  # first order is 1
    assert errors[2] <= 2.5e-3


ENTERING, ZONE, TRAVEL = 0.6, 0.5, 0.1  # f_in, f_z [-], travel of the step [cells]


def lift_of(contents, pressures, flows, sign, film_before=1.0, distance=TRAVEL):
    """Lift of a parallel film of one row, in order along the flow, after steps without memory."""
    n_a = len(contents)
    along = slice(None, None, sign)
    grid = Grid((1, n_a), 1.0, float(n_a))
    content, pressure = (np.array([row[along]]) for row in (contents, pressures))
    unknown = np.where(pressure > 0.0, pressure, content - 1.0)
    travel = np.full((1, n_a + 1), sign * distance)
    still, carriers = np.zeros((1, n_a)), np.ones((CARRIERS, 1, n_a))
    passed = sign * distance * np.array([flows[along]])
    before = PreviousFilm(
        unknown=unknown,
        unknown_before=unknown,
        pressure=pressure,
        content=content,
        growth=still,
        growth_before=still,
        deflection=still,
        film=carriers,
        film_before=film_before * carriers,
        passed=passed,
        travel=travel,
        step=1.0,
    )
    limit = np.full((1, n_a + 1), np.inf)
    edges = Edges(np.zeros(5), np.full(5, ENTERING), limit)
    pace = StepRatios(1.0, 0.0, 1.0)
    return oil_rows.lift(before, pace, edges, 1.0, FilmStep(grid).domain).fraction[0][along]


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("share", [0.2, 0.5, 0.9])
def test_lift_at_the_front_of_a_full_zone_by_hand(share, sign):
    """Eq. (T16), with the share of its cell that is full at the end of the step."""
    reached = share + TRAVEL * (ENTERING - ZONE) / (1.0 - ENTERING)
    contents = [ENTERING, ENTERING, ENTERING + (1.0 - ENTERING) * share, 1.0, 1.0, 1.0]
    flows = [ENTERING, ENTERING, ENTERING, ZONE, ZONE, ZONE, ZONE]
    lift = lift_of(contents, [0.0, 0.0, 0.0, 1.0, 2.0, 1.0], flows, sign)
    expected = 0.5 * (1.0 - ENTERING) + (ENTERING - ZONE) * (reached - 0.5)
    assert lift[3] == pytest.approx(expected, rel=1e-12)
    assert lift[[0, 1, 4, 5, 6]] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("sign", [1, -1])
def test_a_front_goes_on_when_its_cell_fills(sign):
    contents = [ENTERING, ENTERING, 0.995, 1.0, 1.0, 1.0]
    flows = [ENTERING, ENTERING, ENTERING, ZONE, ZONE, ZONE, ZONE]
    lift = lift_of(contents, [0.0, 0.0, 0.0, 1.0, 2.0, 1.0], flows, sign)
    assert lift[2] == pytest.approx(0.5 * (1.0 - ENTERING) - 0.5 * (ENTERING - ZONE), rel=1e-12)
    assert lift[3] == 0.0


@pytest.mark.parametrize("sign", [1, -1])
def test_a_cell_gives_a_full_zone_no_more_oil_than_there_is(sign):
    """0.4 + 0.3 by Eq. (T16), but 0.2 is in the cell, and 2/3 of 0.2 comes in."""
    contents = [0.2, 0.2, 0.2, 1.0, 1.0, 1.0]
    flows = [0.2, 0.2, 0.2, 0.2, 0.8, 0.8, 0.8]
    pressures = [0.0, 0.0, 0.0, 1.0, 2.0, 1.0]
    lift = lift_of(contents, pressures, flows, sign, distance=2.0 / 3.0)
    assert lift[3] == pytest.approx((0.2 + 0.2 * 2.0 / 3.0) * 1.5, rel=1e-12)


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("share, at", [(0.8, 3), (0.9975, 2)])
def test_oil_that_a_growing_film_takes_passes_the_front(share, at, sign):
    """The film grows by 1 % in the step, as in the last one: 0.01 in each full cell."""
    contents = [ENTERING, ENTERING, ENTERING + (1.0 - ENTERING) * share, 1.0, 1.0, 1.0]
    flows = [ENTERING, ENTERING, ENTERING, 0.4, ZONE, ZONE, ZONE]
    lift = lift_of(contents, [0.0, 0.0, 0.0, 1.0, 2.0, 1.0], flows, sign, film_before=0.99)
    entering = ENTERING / 1.01
    passing = (TRAVEL * ZONE + 0.01 * (4 - at)) / (TRAVEL * 1.01)
    reached = 0.0
    if at == 3:
        content = contents[2] + TRAVEL * (ENTERING - 0.4)
        reached = (content / 1.01 - entering) / (1.0 - entering)
    expected = 0.5 * (1.0 - entering) + (entering - passing) * (reached - 0.5)
    assert lift[at] == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(
    "last, expected",
    [
        (0.5, 0.42 - 0.518),  # (0.4 + 0.44) / 2 leaves in a step of Heun
        (0.2, 0.0 - 0.26),  # nothing leaves
        (0.9, 0.9703125 - 0.86296875),  # Eq. (T14): (0.975 + 0.965625) / 2 leaves
    ],
)
def test_lift_at_an_edge_that_oil_leaves_over_by_hand(last, expected, sign):
    """Eq. (T17), less what the last cell has at the end of the step; 0.6 enters it."""
    contents = [ENTERING] * 5 + [last]
    lift = lift_of(contents, [0.0] * 6, [ENTERING] * 7, sign)
    assert lift[6] == pytest.approx(expected, rel=1e-12)
    assert lift[:6] == pytest.approx(0.0, abs=1e-12)


def test_the_volumes_that_pass_the_faces_are_those_that_cells_gain():
    _, state, _ = motored_until(Parameters((12, 10)), np.arange(1, 101) * DEGREE)
    # the ring closes: what circumferential faces pass cancels in a station
    gained = (state.film.growth * state.film.step).sum(axis=0)
    p = Parameters((12, 10))
    area = 2.0 * np.pi * p.bore_radius / 12 * p.skirt_length / 10
    passed = -np.diff(state.film.passed, axis=1).sum(axis=0) / area
    assert gained == pytest.approx(passed, abs=1e-12 * state.film.content.sum())  # round-off


def test_the_tangent_holds_with_a_front_in_the_film():
    p = Parameters((4, 20), film_fraction_lower_edge=FULLER, film_fraction_upper_edge=EMPTY)
    model = LubricationModel(p)
    wedge = np.broadcast_to(np.linspace(2.0, 1.0, 20) * FILM, p.shape).copy()
    inputs = SkirtMotion(wedge, np.full(p.shape, -2.0 * ENTRAINMENT))
    state, _ = model.start(*inputs)
    for k in range(120):
        supply = FULLER if k > 90 else EMPTY
        state, _ = model.advance(state, *inputs, UNEVEN, film_fraction_lower_edge=supply)
    # third derivative times the difference squared
    assert tangent_error(model, state, inputs) <= 1e-7
    fraction = (state.film.content / wedge)[0]
    assert fraction.max() - fraction.min() > 0.5  # front and full film, both there


def test_a_velocity_that_jumps_leaves_no_debt_of_oil():
    rng = np.random.default_rng(4)
    p = Parameters((4, 20), film_fraction_lower_edge=0.1, film_fraction_upper_edge=0.1)
    model = LubricationModel(p)
    film = np.full(p.shape, FILM)
    state, _ = model.start(film, np.zeros(p.shape))
    for _ in range(300):
        velocity = np.full(p.shape, 10.0 * rng.standard_normal())
        step = DEGREE * 10.0 ** rng.uniform(-1.0, 1.0)
        supply = rng.random()
        state, outputs = model.advance(state, film, velocity, step, film_fraction_lower_edge=supply)
        assert outputs["film_fraction"].min() >= -1e-15
        assert outputs["film_fraction"].max() <= 1.0 + 1e-12
        assert outputs["mass_imbalance"] <= 1e-12


def test_a_velocity_next_to_nothing_carries_nothing():
    rng = np.random.default_rng(0)
    films = 1e-6 * (1.0 + 0.8 * rng.uniform(-1.0, 1.0, (4, 12, 10)))
    crawling = np.full((12, 10), 2.225e-313)  # its swept volumes are 0 in double precision
    model = LubricationModel(Parameters((12, 10)))
    state, _ = model.start(films[0], crawling)
    state, _ = model.advance(state, films[1], crawling, DEGREE)
    state, _ = model.advance(state, films[2], crawling, 0.7 * DEGREE)
    _, outputs = model.advance(state, films[3], np.ones((12, 10)), DEGREE)
    assert np.isfinite(outputs["nodal_pressure_force"]).all()


def test_the_tangent_of_a_starved_film_holds_the_lift():
    # while nothing switches; third derivative times the difference squared
    starved = Parameters((12, 10), film_fraction_lower_edge=0.8, film_fraction_upper_edge=0.8)
    assert motored_tangent_error(starved) <= 1e-8


def test_a_velocity_of_next_to_nothing_is_rest():
    p = Parameters((6, 10), film_fraction_lower_edge=EMPTY)
    squeezed = FILM * (1.0 + 0.1 * np.sin(np.arange(60.0))).reshape(p.shape)

    def pressed(velocity):
        films = [FILM, squeezed, squeezed[::-1], squeezed]
        return film_after(p, films, velocity, 1e-5).outputs["nodal_pressure_force"]

    # a volume of 1e-313 m3 is no divisor
    assert np.array_equal(pressed(-2e-313), pressed(0.0))


@pytest.mark.parametrize("travel", [1e-6, 8.0, 16.1, 1e12])
def test_a_step_of_any_length_leaves_a_steady_film_as_it_is(travel):
    """A zone of full cells on scarce oil, then one step in which oil travels so many cells.

    Before and after it, oil travels one cell in a step. The load is the same to round-off.
    """
    cells, length, entrainment = 40, 0.04, 5.0
    height = 2.0 * (np.arange(cells) + 0.5) / cells - 1.0
    thickness = np.broadcast_to(8e-6 + 20e-6 * height**2, (2, cells)).copy()
    conditions = dict(film_thickness=thickness, sliding_velocity=-2.0 * entrainment)
    film = pc.Film(
        (2, cells),
        skirt_length=length,
        viscosity=0.01,
        film_fraction_lower_edge=0.31,
        film_fraction_upper_edge=0.3,
        initial_film_fraction=0.0,
    )
    film.start(**conditions)
    one = length / cells / entrainment
    for _ in range(20 * cells):
        settled = film.step(step=one, **conditions)
    assert 5 < (settled["pressure"][0] > 0.0).sum() < 20
    load = settled["nodal_pressure_force"].sum()
    for step in (travel * one, one, one):
        after = film.step(step=step, **conditions)["nodal_pressure_force"].sum()
        assert after == pytest.approx(load, rel=1e-9)  # its last steps changed it by less


def turning_bearing(cells, shift, sign):
    """Pressures of a bearing on scarce oil from a groove, turned by `shift` cells, after 80 steps.

    Film thickness, velocity and length of the steps change.
    """
    around = (np.arange(cells) - shift) % cells
    angle = 2.0 * np.pi * (around + 0.5) / cells
    groove = np.repeat((around < 3)[:, None], 4, axis=1)
    film = pc.Film(
        (cells, 4),
        surface="bearing",
        open_cells=groove,
        opening_supply="own",
        film_fraction_openings=0.6,
        film_fraction_lower_edge=0.0,
        film_fraction_upper_edge=0.0,
        bore_radius=0.025,
        skirt_length=0.02,
        viscosity=0.01,
    )
    once = np.ones((cells, 4))
    film.start(25e-6 * once, circumferential_velocity=5.0 * sign)
    pressures, imbalances = [], []
    for k in range(80):
        phase = 0.05 * k
        thickness = 25e-6 * (1.0 - 0.7 * np.cos(angle - 2.0 + 0.5 * np.sin(phase)))
        outputs = film.step(
            thickness[:, None] * once,
            (1.0 + 0.5 * (k % 3)) * 5e-4,
            circumferential_velocity=5.0 * sign * (1.0 + 0.3 * np.sin(phase)),
        )
        pressures.append(np.roll(outputs["pressure"], -shift, axis=0))
        imbalances.append(outputs["mass_imbalance"])
    return np.array(pressures), max(imbalances)


@pytest.mark.parametrize("sign", [1, -1])
def test_a_ring_has_no_seam(sign):
    pressures, imbalance = turning_bearing(24, 0, sign)
    assert imbalance <= 1e-12  # round-off
    assert pressures.max() > 1e5
    for shift in (1, 11, 23):
        turned, _ = turning_bearing(24, shift, sign)
        assert turned == pytest.approx(pressures, abs=1e-9 * pressures.max())  # of the solver


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_bearing_carries_oil_as_a_skirt_does(sign):
    along, around = (carry(40, 0.7, front, sign=sign, bearing=bearing) for bearing in (False, True))
    assert around.imbalance <= 1e-12  # round-off
    assert around.fraction == pytest.approx(along.fraction, abs=1e-12)


def forces_on_an_orbit(cells):
    """Return forces on a journal on an orbit in a bearing with a groove, shape (steps, 2) [N].

    The journal turns 50 times a second, and an orbit takes two turns. The first orbit is not part
    of the result.
    """
    turn, radius, clearance, steps = 0.02, 0.024, 24e-6, 120
    angle = 2.0 * np.pi * (np.arange(cells) + 0.5) / cells
    groove = np.zeros((cells, 4), bool)
    groove[(angle > np.pi / 3.0) & (angle < np.pi / 2.0), 1:3] = True
    film = pc.Film(
        (cells, 4),
        surface="bearing",
        open_cells=groove,
        opening_supply="own",
        pressure_openings=3e5,
        film_fraction_lower_edge=0.0,
        film_fraction_upper_edge=0.0,
        bore_radius=radius,
        skirt_length=0.02,
        viscosity=0.008,
    )
    speed = 2.0 * np.pi / turn * radius
    around = np.stack([np.cos(angle), np.sin(angle)])
    forces = []
    for k in range(4 * steps + 1):
        phase = np.pi * k / steps
        x = 0.72 * np.cos(phase) + 0.1 * np.cos(4.0 * phase)
        y = 0.55 * np.sin(phase + 0.4)
        thickness = clearance * (1.0 - x * around[0] - y * around[1])
        moved = np.repeat(thickness[:, None], 4, axis=1)
        if k == 0:
            film.start(moved, circumferential_velocity=speed)
            continue
        outputs = film.step(moved, turn / steps, circumferential_velocity=speed)
        if k > 2 * steps:
            forces.append(around @ outputs["nodal_pressure_force"].sum(axis=1))
    return np.array(forces)


def test_the_force_of_a_journal_on_an_orbit_converges_with_the_cells():
    fine = forces_on_an_orbit(144)
    for cells, allowed in ((48, 0.01), (72, 0.005)):  # with oil of first order 0.017 and 0.009
        errors = forces_on_an_orbit(cells) - fine
        share = np.sqrt((errors**2).mean(axis=0)).max() / np.ptp(fine, axis=0).max()
        print(f"{cells} cells: {share:.2%} of the range of the larger force")
        assert share <= allowed
