"""Asperity contact and coating against published numbers and formulas.

References
----------
[Greenwood1970] J. A. Greenwood, J. H. Tripp, Proc. Instn Mech. Engrs 185 (1970) 625-633.
[Johnson1985] K. L. Johnson, Contact Mechanics, Cambridge 1985, section 5.8.
"""

from math import gamma, pi, sqrt

import numpy as np
import pytest

from piston_cosim.fmu_ehd.laws.asperity import fitted_integral, gaussian_integral

from . import sleeve
from .sleeve import AREA, VISCOSITY, WIDTH, near

SHAPE = (4, 6)
SIGMA = 0.8e-6  # [m]
PRODUCT, SLOPE, MODULUS = 0.047, 3.1e-3, 4.4e10
# H: F_5/2 and F_2 of [Greenwood1970], exact to the digits printed
INTEGRALS = {
    0.0: (6.16634e-1, 0.5),
    1.0: (8.05623e-2, 7.53398e-2),
    2.0: (5.42371e-3, 5.76873e-3),
    3.0: (1.70873e-4, 2.03435e-4),
}


def stepped(film, velocity=0.0, shape=SHAPE, **changes):
    """Return the outputs of one step of a constant film, or of a list of films in turn."""
    return sleeve.stepped(shape, film, velocity, **changes)


def touching(h, velocity=0.0, **changes):
    return stepped(
        max(h, 1e-9) * SIGMA,  # a film of 0 everywhere is refused
        velocity,
        roughness_rms=SIGMA,
        asperity_product=PRODUCT,
        asperity_slope=SLOPE,
        contact_modulus=MODULUS,
        **changes,
    )


@pytest.mark.parametrize("h", INTEGRALS)
def test_contact_pressure_area_and_friction(h):
    """Contact pressure, area and friction follow [Greenwood1970].

    p = (16 sqrt 2 pi/15)(eta beta_a sigma)^2 sqrt(sigma/beta_a) E* F_5/2, 1/E* = sum (1 - nu^2)/E;
    A_c/A = pi^2 (eta beta_a sigma)^2 F_2; friction (mu_b p + tau_0 A_c/A) V/sqrt(V^2 + v_0^2)
    against sliding, here at V = -3/4 v_0: 3/5. 1e-5: digits of the integrals.
    """
    force, area = INTEGRALS[h]
    o = touching(
        h,
        -0.75e-2,
        boundary_friction_coefficient=0.09,
        boundary_shear_strength=5e6,
        friction_rounding_velocity=1e-2,
    )
    pressure = 16.0 * sqrt(2.0) * pi / 15.0 * PRODUCT**2 * sqrt(SLOPE) * MODULUS * force
    share = pi**2 * PRODUCT**2 * area
    assert o["asperity_pressure"][2, 3] == near(pressure, rel=1e-5)
    assert o["contact_area_fraction"] == near(share, rel=1e-5)
    rubbing = (0.09 * pressure + 5e6 * share) * 0.6 * AREA
    assert o["friction_force_asperity"] == near(rubbing, rel=1e-5)
    cell = AREA / 24.0
    assert o["nodal_pressure_force"][1, 4] == near(
        (o["pressure"][1, 4] + pressure) * cell, rel=1e-5
    )
    viscous = VISCOSITY * 0.75e-2 / max(h * SIGMA, 5e-8) * cell
    assert o["nodal_friction_force"][1, 4] == near(viscous + rubbing / 24.0, rel=1e-5)
    assert o["friction_power"] == near(0.75e-2 * (24.0 * viscous + rubbing), rel=1e-5)


WEIGHTS = np.array([18.0 - sqrt(30.0), 18.0 + sqrt(30.0)]) / 72.0  # Gauss, four points on [0, 1]
OFFSETS = np.sqrt(3.0 / 7.0 + np.array([2.0, -2.0]) / 7.0 * sqrt(1.2)) / 2.0


def cell_mean(function, before, own, after):
    """Mean over a cell of a function of the parabola through three gaps, by Gauss' four points."""
    mean = 0.0
    for weight, offset in zip(WEIGHTS, OFFSETS):
        for x in (-offset, offset):
            gap = own + x * (after - before) / 2.0 + x * x * (after - 2.0 * own + before) / 2.0
            mean += weight * function(gap)
    return mean


def test_contact_of_a_cell_is_the_mean_over_its_parabola():
    """The contact of a cell is the mean over the parabola through itself and its neighbours.

    H is 1 to 3.2 around, without a step.
    """
    around = np.array([1.0, 1.5, 2.2, 2.9, 3.2, 2.6, 2.1, 1.4])
    film = around[:, None] * SIGMA
    o = stepped(
        film,
        5.0,
        (8, 3),
        roughness_rms=SIGMA,
        asperity_product=PRODUCT,
        boundary_shear_strength=1e9,
    )
    means = [
        cell_mean(lambda gap: gaussian_integral(2.5, gap), around[i - 1], around[i], after)
        for i, after in enumerate(np.roll(around, -1))
    ]
    pressure = o["asperity_pressure"][:, 1] / o["asperity_pressure"][0, 1]
    assert pressure == near(np.array(means) / means[0], rel=1e-7)  # the table between its points
    areas = [
        cell_mean(lambda gap: gaussian_integral(2.0, gap), around[i - 1], around[i], after)
        for i, after in enumerate(np.roll(around, -1))
    ]
    share = pi**2 * PRODUCT**2 * np.mean(areas)
    assert o["contact_area_fraction"] == near(share, rel=1e-7)


def test_contact_at_an_edge_and_beside_a_cut_out_goes_on_straight():
    """Contact at an edge and next to a cut-out continues straight.

    H is 1, 1.5, 2.2 along: straight from 0.75 to 1.25 in the first cell, 1.85 to 2.55 in the last.
    If the middle one is cut out, both use no neighbour.
    """
    film = np.tile(np.array([1.0, 1.5, 2.2]) * SIGMA, (4, 1))
    middle = np.tile([False, True, False], (4, 1))
    whole, cut = (
        stepped(film, 0.0, (4, 3), roughness_rms=SIGMA, open_cells=mask)["asperity_pressure"][2]
        for mask in (None, middle)
    )

    def force(gap):
        return gaussian_integral(2.5, gap)

    means = [cell_mean(force, 0.5, 1.0, 1.5), cell_mean(force, 1.0, 1.5, 2.2)]
    means += [cell_mean(force, 1.5, 2.2, 2.9)]
    assert whole / whole[1] == near(np.array(means) / means[1], rel=1e-7)
    assert cut[2] / cut[0] == near(force(2.2) / force(1.0), rel=1e-7)
    assert cut[0] / whole[0] == near(force(1.0) / means[0], rel=1e-7)
    assert cut[1] == 0.0


def stepped_gap(y, tilt, barrel):
    """H on lands and in grooves of 4 of 40 units of the length, y from 0 to 1."""
    unit = np.floor(40.0 * y)
    bent = tilt * (y - 0.03) + barrel * (2.0 * y - 1.0) ** 2
    return 0.5 + np.where(unit % 8 < 4, 0.0, 10.0) + bent


@pytest.mark.parametrize("cells", [40, 80, 160])
@pytest.mark.parametrize("tilt, barrel", [(0.0, 0.0), (40.0, 0.0), (8.0, 20.0)])
def test_contact_on_lands_does_not_see_the_grooves(cells, tilt, barrel):
    """Contact on lands is independent of the grooves of 10 sigma between them.

    The lands are flat, tilted by up to one sigma in a cell, or also barrelled. The reference is the
    sum over the exact profile with 64 points in the smallest cell.
    2e-4: Gauss points in a cell that is tilted by sigma. 0.4 %: at its two ends a land is straight
    within the cell, without the barrel's curvature.
    """
    y, fine = ((np.arange(n) + 0.5) / n for n in (cells, 64 * 160))
    film = np.tile(stepped_gap(y, tilt, barrel) * SIGMA, (4, 1))
    o = stepped(film, 0.0, film.shape, roughness_rms=SIGMA, contact_modulus=MODULUS)
    flat = stepped(SIGMA, 0.0, (4, 4), roughness_rms=SIGMA, contact_modulus=MODULUS)
    gap = stepped_gap(fine, tilt, barrel)
    overlap = -2.5 * gaussian_integral(1.5, 0.0) * np.minimum(gap, 0.0)  # along the tangent
    exact = (gaussian_integral(2.5, np.maximum(gap, 0.0)) + overlap).mean()
    found = o["asperity_pressure"].mean() / flat["asperity_pressure"][0, 0]
    assert found == near(exact / gaussian_integral(2.5, 1.0), rel=2e-4 if barrel == 0.0 else 4e-3)


def test_a_step_is_steeper_than_the_gap_beside_it():
    """Eqs. (A12), (A15): a step is at least four times as steep as the gaps next to it.

    Jumps of 0.4, 2, 0.4 sigma are a step, so that the cell before it is straight. With 1.1 before
    or after it they are none, nor are jumps of a twentieth. 0.75 before and after it gives the
    weight S(1/2)^2 = 1/4, and jumps of a factor 0.09375 give S(1/2) = 1/2.
    """

    def force(gap):
        return gaussian_integral(2.5, gap)

    for scale, jumps, weight in (
        (1.0, (0.4, 2.0, 0.4), 1.0),
        (1.0, (1.1, 2.0, 0.4), 0.0),
        (1.0, (0.4, 2.0, 1.1), 0.0),
        (0.05, (0.4, 2.0, 0.4), 0.0),
        (1.0, (0.75, 2.0, 0.75), 0.25),
        (0.09375, (0.4, 2.0, 0.4), 0.5),
    ):
        gap = 1.0 + scale * np.cumsum([0.0, *jumps])
        film = np.tile(gap * SIGMA, (4, 1))
        pressure = stepped(film, 0.0, (4, 4), roughness_rms=SIGMA)["asperity_pressure"][0]
        beyond = (1.0 - weight) * gap[2] + weight * (2.0 * gap[1] - gap[0])
        means = cell_mean(force, 2.0 * gap[0] - gap[1], gap[0], gap[1])
        means = cell_mean(force, gap[0], gap[1], beyond) / means
        assert pressure[1] / pressure[0] == near(means, rel=1e-6)


@pytest.mark.parametrize("jump", [0.125, 0.1875, 0.25, 2.0])
@pytest.mark.parametrize("ratio", [0.25, 0.375, 0.5])
def test_contact_is_once_differentiable_in_the_profile(jump, ratio):
    """Differences to both sides agree at the ends and in the middle of the bands of Eq. (A12).

    They differ by a second derivative times the difference, which S makes at most 6 over the width
    of its band squared: 6 (0.1 nm / 62 nm) = 1 % of the jump over 62 nm, and a few in a sum.
    """
    change = np.array([0.3, -1.0, 0.7, 0.2])

    def load(size):
        gap = 1.0 + jump * np.cumsum([0.0, ratio, 1.0, ratio])
        film = np.tile(gap * SIGMA + size * change, (4, 1))
        return stepped(film, 0.0, (4, 4), roughness_rms=SIGMA)["asperity_pressure"].sum()

    after, before = (load(1e-10) - load(0.0)) / 1e-10, (load(0.0) - load(-1e-10)) / 1e-10
    assert after == pytest.approx(before, rel=0.05)


def test_a_gap_that_bends_makes_no_step():
    """A gap that bends makes no step; steps of the profile at the start stay.

    Bodies press a gap flat from the fourth cell on. There the jump of the gap passes a quarter of
    the roughness, which would be a step of a profile. Contact follows only the gap, to dp/p of
    some 3 H dH for dH = 2e-4.
    """

    def pressure(start, then, around):
        films = [film * around for film in (start, *then)]
        return stepped(films, shape=(8, 4), roughness_rms=SIGMA)["asperity_pressure"]

    even = np.full((8, 4), SIGMA)
    before, after = (
        pressure(
            20.0,
            [np.array([25.5, 18.1, 10.5, 2.9, 2.9 + jump, 3.1, 10.5, 18.1])[:, None]],
            even,
        )[3, 1]
        for jump in (0.2499, 0.2501)
    )
    assert after == near(before, rel=2e-3)

    land = np.where(np.arange(8) % 8 < 4, 0.0, 10.0)[:, None]
    flat = pressure(1.0, [1.0, 1.0], even)
    assert pressure(land + 2.0, [land + 1.5, land + 1.0], even)[:4] == near(flat[:4], rel=1e-9)


@pytest.mark.parametrize("cells, distance", [(40, 0.04), (42, 0.03), (82, 0.005)])
@pytest.mark.parametrize("least", [0.5e-6, 1.5e-6])
def test_contact_does_not_depend_on_the_grid(cells, distance, least):
    """Asperity friction does not depend on the grid; the reference has 320 cells around.

    A skirt of 180 um ovality and 20 um barrel, 0.5 um rough, is rocked and shifted until its thrust
    line comes to `least`. The error left is the fourth derivative of the ovality in a cell.
    Contact at centres alone was wrong by a factor.
    """

    def rubbing(n):
        turn = (np.arange(n) - n // 4)[:, None] * 2.0 * pi / n  # from the thrust line
        y = (np.arange(40) + 0.5) / 40.0 - 0.5
        gap = 20e-6 + 45e-6 * (1.0 - np.cos(2.0 * turn)) + 20e-6 * (2.0 * y) ** 2
        film = gap - (20e-6 - least + 10e-6 * y) * np.cos(turn)
        o = stepped([film], 5.0, film.shape, bore_radius=36.5e-3, roughness_rms=0.5e-6)
        return o["friction_force_asperity"]

    assert rubbing(cells) == near(rubbing(320), rel=distance)


def test_overlap_goes_on_along_the_tangent():
    """Overlap continues along the tangent: p(-1)/p(0) = 1 + 5/2 F_3/2(0)/F_5/2(0).

    F_n(0) = 2^((n-1)/2) Gamma((n+1)/2)/sqrt(2 pi), F' = -n F_(n-1).
    """
    at_zero = {n: 2 ** ((n - 1) / 2) * gamma((n + 1) / 2) / sqrt(2 * pi) for n in (1.5, 2.5)}
    pressure = [
        stepped([gap * SIGMA], roughness_rms=SIGMA)["asperity_pressure"][1, 2]
        for gap in (0.0, -1.0)
    ]
    assert pressure[1] / pressure[0] == near(1.0 + 2.5 * at_zero[1.5] / at_zero[2.5], rel=1e-9)


def test_power_fit():
    """F_5/2 = 4.4086e-5 (4 - H)^6.804 at H = 1.7, none from H = 4 on; the area stays exact."""
    o = touching(1.7, contact_law="power_fit")
    pressure = 16.0 * sqrt(2.0) * pi / 15.0 * PRODUCT**2 * sqrt(SLOPE) * MODULUS
    # 1e-6: the table between its points
    assert o["asperity_pressure"][0, 0] == near(pressure * 4.4086e-5 * 2.3**6.804, rel=1e-6)
    assert fitted_integral(np.array([4.5]))[0][0] == 0.0
    expected = pi**2 * PRODUCT**2 * gaussian_integral(2.0, 1.7)
    assert o["contact_area_fraction"] == near(expected, rel=1e-6)


# ---- coating


def test_coating_opens_the_film_by_its_compliance():
    """A coating opens the film by its compliance: shear and flow see h + w.

    [Johnson1985]: a bonded layer yields by d (1 + nu)(1 - 2 nu)/[E (1 - nu)] p. Under an even
    pressure of 40 MPa with d = 60 um, E = 0.8 GPa and nu = 0.4 this is 1.4 um.
    """
    pressure, film = 40e6, 5e-6
    given = dict(
        pressure_lower_edge=pressure,
        pressure_upper_edge=pressure,
        coating_thickness=60e-6,
        coating_modulus=0.8e9,
        coating_poisson=0.4,
    )
    o = stepped(film, 2.0, **given)
    # the layer yields within the step and draws oil in from both edges; far from them in time
    opened = film + 60e-6 * 1.4 * 0.2 / (0.8e9 * 0.6) * o["pressure"]
    assert o["nodal_friction_force"].sum() == near(
        (-VISCOSITY * 2.0 / opened * AREA / 24.0).sum(), rel=1e-2
    )
    o = stepped([film] * 4, 2.0, step=1e3, **given)  # long enough to fill
    opened = film + 60e-6 * 1.4 * 0.2 / (0.8e9 * 0.6) * pressure
    assert opened == near(6.4e-6, rel=1e-9)
    assert o["minimum_film_thickness"] == near(opened, rel=1e-6)
    assert o["flow_upper_edge"] == near(opened * WIDTH, rel=1e-6)
    force = VISCOSITY * 2.0 / opened * AREA
    assert o["friction_force_hydrodynamic"] == near(-force, rel=1e-6)
