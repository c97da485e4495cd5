import numpy as np
import pytest

from piston_cosim.fmu_ehd.balance import flows, reynolds
from piston_cosim.fmu_ehd.balance.flows import Filling
from piston_cosim.fmu_ehd.balance.storage import EulerStep
from piston_cosim.fmu_ehd.common.faults import NotConverged
from piston_cosim.fmu_ehd.common.grid import Edges, Entrainment, unlimited_supply
from piston_cosim.fmu_ehd.laws import cavitation
from piston_cosim.fmu_ehd.parameters import Parameters
from piston_cosim.tests.verification.cases.film import flow_film
from piston_cosim.tests.verification.cases.grids import FilmStep, Grid
from piston_cosim.tests.verification.cases.motored import film_after

NO_LIFT = flows.no_lift((7, 9))


def problem(ring, seed=0, shape=(7, 9)):
    """Return a rough, partly starved film with entrainment in both directions."""
    rng = np.random.default_rng(seed)
    grid = Grid(shape, 7e-3, 9e-3, ring)
    edges = Edges(
        np.array([1e4, 0.0, 2e4, 0.0, 0.0]),
        np.array([0.9, 0.6, 1.0, 0.5, 1.0]),
        unlimited_supply(shape),
    )
    film = 2e-6 * (1.0 + 3.0 * rng.random(shape))
    across, along = rng.standard_normal((2, *shape))
    content = film * np.minimum(1.0, 0.7 + 0.5 * rng.random(shape))
    return grid, edges, film, Entrainment(across, along), content


@pytest.mark.parametrize("ring", [True, False])
def test_every_cell_balances(ring):
    grid, edges, film, entrainment, content = problem(ring)
    solution = FilmStep(grid).solve(
        flow_film(film, 0.01), entrainment, edges, EulerStep(content, 1e-4), content >= film
    )
    assert 0 < np.count_nonzero(solution.full) < film.size  # both kinds of cells are there
    no_opening = np.zeros(film.shape, dtype=bool)
    faces = reynolds.faces(flow_film(film, 0.01), entrainment, no_opening, grid.cells)
    filling = Filling(solution.pressure, solution.film_fraction, NO_LIFT)
    out, edge_flow, *_ = flows.outflow(filling, faces, edges, ring)
    growth = grid.cell_area / 1e-4 * (solution.content - content)
    assert np.abs(out + growth).max() <= 1e-12 * np.abs(growth).max()
    assert abs(edge_flow.sum() + out.sum()) <= 1e-14 * np.abs(out).sum()


def test_switching_singly_finds_the_same_film():
    grid, edges, film, entrainment, content = problem(True)
    start = np.ones(grid.shape, dtype=bool)
    found = []
    for switches_singly in (False, True):
        step = FilmStep(grid)
        if switches_singly:
            step.domain = step.domain._replace(together=0)
        flow = flow_film(film, 0.01)
        found.append(step.solve(flow, entrainment, edges, EulerStep(content, 1e-4), start))
    together, singly = found
    assert singly.iterations > together.iterations
    assert np.array_equal(singly.full, together.full)
    assert np.allclose(singly.unknown, together.unknown, rtol=1e-9)


def test_a_solution_that_is_not_finite_is_refused():
    grid, edges, film, entrainment, content = problem(True)
    flow = flow_film(film, 1e-320)
    with pytest.raises(NotConverged):
        FilmStep(grid).solve(flow, entrainment, edges, EulerStep(content, 1e-4), content >= film)


def test_a_full_region_spreads_over_the_film_by_a_cell_an_iteration():
    """A full region spreads over the film by one cell per iteration.

    One cell of a film at rest is squeezed, and pressure reaches all of it within a step.
    If cells switch singly, the film is the same after hundreds of iterations.
    """
    shape = (30, 30)
    films = np.full((3, *shape), 1e-5)
    films[:, 2, 3] = 2e-5, 2e-5, 1.99e-5
    found = []
    for switches_singly in (False, True):
        with pytest.MonkeyPatch.context() as patch:
            if switches_singly:
                patch.setattr(cavitation, "at_once", lambda n_c, n_a: cavitation.ALL_AT_ONCE)
            found.append(film_after(Parameters(shape), films, step=5e-5).outputs)
    spread, singly = found
    assert 25 < spread["solver_iterations"] <= sum(shape) < singly["solver_iterations"]
    assert spread["pressure"].max() > 1e5
    assert np.abs(spread["pressure"] - singly["pressure"]).max() <= 1e-12 * spread["pressure"].max()
