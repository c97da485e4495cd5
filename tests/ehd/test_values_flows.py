"""Numbers by hand of single cells and faces: edges on all sides, cavitated neighbours, tangents.

Tests of whole films are exact on rings and for full films alone; what a matrix, its tangent and a
balance have wrong alike shows here.
"""

from math import gamma, pi, sqrt

import numpy as np
import pytest

from piston_cosim.fmu_ehd.balance import flows, reynolds, tangent
from piston_cosim.fmu_ehd.balance.films import smooth_film
from piston_cosim.fmu_ehd.balance.flow_film import FilmLaws, ShearedOil, flow_film
from piston_cosim.fmu_ehd.balance.flows import Filling
from piston_cosim.fmu_ehd.balance.reynolds import Storage
from piston_cosim.fmu_ehd.balance.tangent import BY_FILM, BY_VELOCITY
from piston_cosim.fmu_ehd.common.grid import (
    CENTRE,
    EAST,
    NORTH,
    WEST,
    Cells,
    Edges,
    Entrainment,
    unlimited_supply,
)
from piston_cosim.fmu_ehd.common.quantities import (
    CONDUCTIVITY_A,
    CONDUCTIVITY_C,
    COUETTE,
    QUANTITIES,
    FilmSlopes,
)
from piston_cosim.fmu_ehd.laws import coating
from piston_cosim.fmu_ehd.laws.asperity import ContactConstants, contact_table, point_contact
from piston_cosim.fmu_ehd.laws.contact import Contact
from piston_cosim.fmu_ehd.laws.oil import SHEAR_THINNING_LAWS, Thinning
from piston_cosim.fmu_ehd.laws.piezoviscosity import TruePressure

VISCOSITY = 0.012  # [Pa s]
FILM = 6e-6  # [m]
CONDUCTIVITY = FILM**3 / (12.0 * VISCOSITY)  # [m3/(Pa s)]
DX, DY = 3e-3, 2e-3  # [m]
CELLS = Cells(DX, DY, ring=False, mirrored=False)
FLOODED = np.ones(4)
NO_PRESSURE = np.zeros(4)


def near(value, rel=1e-12):
    """Round-off: single cells are exact."""
    return pytest.approx(value, rel=rel, abs=0.0)


def parallel(shape):
    """Quantities of a smooth film FILM."""
    return smooth_film(np.full(shape, FILM), np.full(shape, VISCOSITY), 1e-8)


def steady(shape):
    """Storage of a film that does not change."""
    return Storage(np.full(shape, FILM), np.full(shape, FILM), 0.0)


def test_one_cell_between_four_edges():
    """Each edge is half a cell away: K = 2 dy/dx g across, 2 dx/dy g along; nothing slides.

    p = [K_c (p_first + p_last) + K_a (p_lower + p_upper)] / [2 (K_c + K_a)]
    """
    pressure = np.array([1e5, 3e5, 7e5, 2e5])  # lower, upper, first, last
    still = Entrainment(np.zeros((1, 1)), np.zeros((1, 1)))
    faces = reynolds.faces(parallel((1, 1))[0], still, np.zeros((1, 1), dtype=bool), CELLS)
    full = np.ones((1, 1), dtype=bool)
    edges = Edges(pressure, FLOODED, unlimited_supply((1, 1)))
    no_lift = flows.no_lift((1, 1))
    stencil, right = reynolds.assemble(full, faces, no_lift, steady((1, 1)), edges, CELLS)
    across = 2.0 * DY / DX * CONDUCTIVITY
    along = 2.0 * DX / DY * CONDUCTIVITY
    expected = (across * 9e5 + along * 4e5) / (2.0 * (across + along))
    assert right[0, 0] / stencil[CENTRE, 0, 0] == near(expected)
    filling = Filling(np.full((1, 1), expected), np.ones((1, 1)), flows.no_lift((1, 1)))
    edge_flow = flows.outflow(filling, faces, edges, False).edges
    assert edge_flow[:2] == near(along * (pressure[:2] - expected))
    assert edge_flow[2:] == near(across * (pressure[2:] - expected))


@pytest.mark.parametrize("velocity, fraction", [(4.0, 0.3), (-4.0, 0.8)])
def test_two_starved_cells_in_a_stream(velocity, fraction):
    """Two starved cells in a stream U across hold the film fraction from upstream, u = f - 1.

    The stream has 0.3 of a film at the first edge and 0.8 at the last.
    U h dy times the fraction from upstream flows over both edges.
    """
    shape = (2, 1)
    edges = Edges(NO_PRESSURE, np.array([1.0, 1.0, 0.3, 0.8]), unlimited_supply(shape))
    stream = Entrainment(np.full(shape, velocity), np.zeros(shape))
    faces = reynolds.faces(parallel(shape)[0], stream, np.zeros(shape, dtype=bool), CELLS)
    cavitated = np.zeros(shape, dtype=bool)
    stencil, right = reynolds.assemble(
        cavitated, faces, flows.no_lift(shape), steady(shape), edges, CELLS
    )
    matrix = np.array(
        [
            [stencil[CENTRE, 0, 0], stencil[EAST, 0, 0]],
            [stencil[WEST, 1, 0], stencil[CENTRE, 1, 0]],
        ]
    )
    assert 1.0 + np.linalg.solve(matrix, right[:, 0]) == near(np.full(2, fraction))
    filling = Filling(np.zeros(shape), np.full(shape, fraction), flows.no_lift(shape))
    edge_flow = flows.outflow(filling, faces, edges, False).edges
    flow = velocity * FILM * DY * fraction
    assert edge_flow[2:] == near(np.array([flow, -flow]))


@pytest.mark.parametrize("velocity, upstream", [(4.0, 0.3), (-4.0, 0.8)])
def test_flow_between_two_starved_cells_follows_film_and_velocity(velocity, upstream):
    """The flow between two starved cells is q = w U h f with f upstream.

    Its derivative is half of w U f by the other cell's film, half of w h f by its velocity.
    The cells hold 0.3 and 0.8 of a film, one behind the other along the skirt.
    """
    shape = (1, 2)
    film, by_film = parallel(shape)
    slopes = FilmSlopes(by_film, np.zeros((0, *shape)))
    stream = Entrainment(np.zeros(shape), np.full(shape, velocity))
    follow = Entrainment(np.zeros(shape), np.ones(shape))
    filling = Filling(np.zeros(shape), np.array([[0.3, 0.8]]), flows.no_lift(shape))
    edges = Edges(NO_PRESSURE, FLOODED, unlimited_supply(shape))
    covered = np.zeros(shape, dtype=bool)
    stencil = tangent.linearise(film, slopes, (stream, follow), filling, edges, covered, CELLS, 0.0)
    assert stencil[BY_FILM, NORTH, 0, 0] == near(0.5 * DX * velocity * upstream)
    assert stencil[BY_VELOCITY, NORTH, 0, 0] == near(0.5 * DX * FILM * upstream)


def test_below_the_floor_nothing_follows_the_film():
    """Below the smallest film all derivatives by the film are 0.

    Above: s' = t' = 1, g' = h^2/(4 mu), c' = -mu/h^2, b' = 1/2.
    Below, the quantities are those of the smallest film, c = mu/h_min.
    """
    film = np.array([[2e-7, FILM]])
    quantities, slopes = smooth_film(film, np.full((1, 2), VISCOSITY), 5e-7)
    assert np.array_equal(slopes[:, 0, 0], np.zeros(QUANTITIES))
    bend = FILM**2 / (4.0 * VISCOSITY)
    expected = [1.0, 1.0, bend, bend, -VISCOSITY / FILM**2, 0.5]
    assert slopes[:, 0, 1] == near(np.array(expected))
    assert quantities[COUETTE, 0, 0] == near(VISCOSITY / 5e-7)


def test_thinned_film_follows_film_and_velocity():
    """A shear-thinned film follows film and velocity: Cross, n = 1, m = 1/5.

    At three times the critical shear rate g_c = 1/h per second, mu/mu_0 = 1/5 + 4/5 / 4 = 2/5.
    The derivative is -1/(20 g_c) = -h/20 s at V = -3 m/s. It is 3/(20 h) 1/m by the film and
    1/20 s/m by the velocity; c = mu/h.
    Flow along the sliding direction meets mu_t/mu_0 = 1/5 + 4/5 / 4^2 = 1/4, with the derivative
    -2 x 4/5 / 4^3 / g_c = -h/40 s. Flow across meets mu: g_a = h^3/(12 mu_t), g_c = h^3/(12 mu).
    Below the smallest film it follows the velocity alone. W shears the oil as V does.
    At rest the oil is not thinned.
    """
    law = Thinning(SHEAR_THINNING_LAWS.cross_1965, 0.2, 1.0, -np.log10(FILM), 0.0)
    laws = FilmLaws(FILM, 0.0, np.zeros((0, 0)), law)
    thickness = FILM * np.array([[1.0 + 1e-15, 0.5, 0.5, 0.5]])
    velocity = np.array([[-3.0, -3.0, 0.0, 0.0]])
    turning = np.array([[0.0, 0.0, 3.0, 0.0]])
    viscosity = np.full((1, 4), VISCOSITY)
    sheared = ShearedOil(velocity, turning, viscosity, np.full((1, 4), 350.0))
    film, slopes, around = flow_film(thickness, sheared, laws)
    couette = VISCOSITY / FILM
    assert film[COUETTE, 0] == near(couette * np.array([0.4, 0.4, 0.4, 1.0]))
    assert slopes.by_film[COUETTE, 0] == near(
        np.array([couette * (0.15 / FILM - 0.4 / FILM), 0.0, 0.0, 0.0])
    )
    assert slopes.by_velocity[COUETTE, 0] == near(couette * 0.05 * np.array([1.0, 1.0, 0.0, 0.0]))
    assert around.by_velocity[COUETTE, 0] == near(-couette * 0.05 * np.array([0.0, 0.0, 1.0, 0.0]))
    # quantity, viscosity ratio of each cell, its derivative to V in the first
    for name, ratio, slope in (
        (CONDUCTIVITY_A, np.array([0.25, 0.25, 0.4, 1.0]), 1.0 / 40.0),
        (CONDUCTIVITY_C, np.array([0.4, 0.4, 0.25, 1.0]), 1.0 / 20.0),
    ):
        assert film[name, 0] == near(CONDUCTIVITY / ratio)
        by_ratio = CONDUCTIVITY / ratio[0] ** 2
        steeper = CONDUCTIVITY / ratio[0] * 3.0 / FILM - by_ratio * 3.0 * slope / FILM
        assert slopes.by_film[name, 0, 0] == near(steeper)
        assert slopes.by_velocity[name, 0, 0] == near(-by_ratio * slope)


def test_contact_at_no_distance_follows_the_film():
    """F_n' = -n F_(n-1), F_n(0) = 2^((n-1)/2) Gamma((n+1)/2)/sqrt(2 pi), with sigma = 2:

    p = 3 F_5/2, A_c/A = 0.1 F_2, tau = 0.2 p + 7 A_c/A, and their slopes to the film over sigma.
    """
    # 0.0 is a point of the table, where values and slopes are those of the integrals
    force = {n: 2 ** ((n - 1) / 2) * gamma((n + 1) / 2) / sqrt(2 * pi) for n in (1.0, 1.5, 2.5)}
    at = point_contact(0.0, ContactConstants(2.0, 3.0, 0.1, 0.2, 7.0, 0.0, contact_table()))
    slope = -3.0 * 2.5 * force[1.5] / 2.0
    assert at.pressure == near(3.0 * force[2.5])
    assert at.pressure_slope == near(slope)
    assert at.area_fraction == near(0.05)
    assert at.shear_stress == near(0.6 * force[2.5] + 0.35)
    assert at.shear_stress_slope == near(0.2 * slope - 7.0 * 0.1 * 2.0 * force[1.0] / 2.0)


def test_layer_and_asperities_are_springs_in_series():
    """The layer and the asperities are springs in series.

    The stiffness is 1/c = 4e13 Pa/m of the layer and 8e13 Pa/m of the asperities. The asperities
    take the share k = 4/(4 + 8) of a change of the distance, wherever in the cell they are.
    Pressure of the oil moves the layer by k c times the pressure.

    offset = k (c p_a - w_0) with the oil at p = 0, here 1e-7 (1/3)(5 - 2) m.
    """
    c = 2.5e-14
    one = np.ones((1, 1))
    shares = np.array([0.5, 0.2, 0.1, 0.15, 0.05])[:, None, None]
    touching = Contact(2e7 * one, 0.0 * one, 0.0 * one, -8e13 * shares, 0.0 * shares, 0.0 * one)
    assert coating.yielding(c, touching.pressure_slope) == near(np.full((1, 1), 1.0 / 3.0))
    still = TruePressure(0.0 * one, np.zeros((0, 0)), np.zeros((0, 0)))
    weight, offset = coating.linear_deflection(c, 2e-7 * one, touching, still, 0.0 * one, one < 0.0)
    assert weight == near(c / 3.0 * one)
    assert offset == near(1e-7 * one)
