import numpy as np
import pytest
from scipy.integrate import quad

from piston_cosim.fmu_ehd.common.grid import Cells
from piston_cosim.fmu_ehd.laws import asperity
from piston_cosim.fmu_ehd.laws.contact import contact as contact_of_cells
from piston_cosim.fmu_ehd.laws.contact import has_narrow_steps
from piston_cosim.fmu_ehd.parameters import Parameters
from piston_cosim.tests.verification.cases.motored import film_after

RING = Cells(1.0, 1.0, ring=True, mirrored=False)
SECTOR = RING._replace(ring=False)
UNIT = asperity.ContactConstants(1.0, 1.0, 1.0, 0.1, 0.0, 0.0, asperity.contact_table())


def contact(film, roughness_rms=1.0, **changes):
    """Contact at points with all scales 1 and a friction coefficient of 0.1, but for `changes`."""
    constants = UNIT._replace(roughness_rms=roughness_rms, **changes)
    points = [asperity.point_contact(gap, constants) for gap in film]
    return asperity.PointContact(*np.array(points).T)


@pytest.mark.parametrize("height", [0.0, 0.7])
def test_slope_is_the_derivative_across_table_cells_and_overlap(height):
    film = np.linspace(-2.0, 9.0, 1001)
    size = 1e-6
    slope = contact(film, summit_height=height).pressure_slope
    above, below = (contact(film + by, summit_height=height).pressure for by in (size, -size))
    difference = (above - below) / (2.0 * size)
    assert (
        np.abs(slope - difference).max() <= 1e-8
    )  # the second derivative jumps at the table's points


@pytest.mark.parametrize("law", asperity.CONTACT_LAWS)
@pytest.mark.parametrize("separation", [-1.5, -0.2, 0.0, 0.7, 2.3, 3.5])
def test_energy_is_the_work_of_closing_the_gap(law, separation):
    """Eq. (A9) against quadrature of the pressure from far away to the gap; sigma 2, p_0 3."""
    constants = asperity.ContactConstants(2.0, 3.0, 1.0, 0.1, 0.0, 0.0, asperity.contact_table(law))
    gap = 2.0 * separation
    # pieces of the table's cells; the fit ends at H = 4
    edges = np.concatenate([[gap], np.linspace(max(gap, 0.0), 16.0, 101)[int(gap >= 0.0) :]])
    work = sum(
        quad(lambda h: asperity.point_contact(h, constants).pressure, a, b)[0]
        for a, b in zip(edges, edges[1:])
    )
    energy = asperity.point_contact(gap, constants).energy
    # the table's cubics: 1e-10 of F at 0, over a length of some H
    assert energy == pytest.approx(work, rel=1e-6, abs=1e-8)


def test_higher_summits_touch_as_a_thinner_film_does():
    """Eq. (A13): the contact of a film that is thicker by z_s, over curved cells and a step."""
    film = 1e-6 * (2.0 + np.linspace(-3.0, 4.0, 96).reshape(12, 8) ** 2)
    film[:, :3] += 4e-6
    found = []
    for height in (0.0, 2e-6):
        rough = Parameters(film.shape, roughness_rms=1e-6, summit_height=height)
        found.append(film_after(rough, [film + height] * 2, 1.0, 1e-3).outputs)
    low, high = found
    assert low["asperity_pressure"].max() > 1e4
    for name in ("asperity_pressure", "contact_area_fraction", "stored_energy"):
        # round-off of the film thickness, times the slope of the contact over its value
        np.testing.assert_allclose(high[name], low[name], rtol=1e-12)


def test_a_sloped_cell_touches_with_its_corner():
    """On the plane H = 17.5 + 20 x + 20 y a corner of the cell touches.

    Of the four Gauss points each way, which are 0.43 and 0.17 from the centre, only the outermost
    three combinations are below H = 8.
    """
    x = np.array([-1.0, 0.0, 1.0])
    film = 17.5 + 20.0 * np.add.outer(x, x)
    no_step, closed = np.zeros((2, 3, 3)), np.zeros((3, 3), bool)
    found = contact_of_cells(film, np.zeros((3, 3)), no_step, closed, UNIT, SECTOR)
    outer, inner = np.sqrt(3.0 / 7.0 + np.array([2.0, -2.0]) / 7.0 * np.sqrt(1.2)) / 2.0
    least, most = np.array([18.0 - np.sqrt(30.0), 18.0 + np.sqrt(30.0)]) / 72.0
    corner, beside = contact(17.5 - 20.0 * np.array([2.0 * outer, outer + inner])).pressure
    expected = least * least * corner + 2.0 * least * most * beside
    assert found.pressure[1, 1] == pytest.approx(expected, rel=1e-12)


def test_smooth_surfaces_do_not_touch():
    o = film_after(Parameters((4, 3), boundary_shear_strength=1e6), [1e-9], 1.0).outputs
    assert o["contact_area_fraction"] == o["friction_force_asperity"] == 0.0


def test_a_narrow_land_is_found_where_there_is_a_film():
    """A narrow land counts only where there is a film.

    The land is one cell wide and 10 um high, across a skirt 1 um rough.
    The same cells cut out do not count, nor does a land lower than the roughness.
    """
    film = np.full((8, 6), 12e-6)
    film[:, 3] = 2e-6
    nowhere = np.zeros(film.shape, dtype=bool)
    assert has_narrow_steps(film, nowhere, 1e-6, RING)
    assert not has_narrow_steps(film, film < 5e-6, 1e-6, RING)
    assert not has_narrow_steps(film, nowhere, 11e-6, RING)
