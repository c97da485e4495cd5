"""Rough surfaces, asperity contact and coating against published tables and formulas.

Every published coefficient of Patir and Cheng is typed here a second time. The model must give
flow and force with it: pressure flow and sliding flow, axial force and power. The roughness is on
the skirt, on the bore, or on both.

References
----------
[Patir1978] N. Patir, H. S. Cheng, J. Lubr. Technol. 100 (1978) 12-17, table 1.
[Patir1979] N. Patir, H. S. Cheng, J. Lubr. Technol. 101 (1979) 220-229, tables 1 to 4.
[Greenwood1970] J. A. Greenwood, J. H. Tripp, Proc. Instn Mech. Engrs 185 (1970) 625-633.
[Johnson1985] K. L. Johnson, Contact Mechanics, Cambridge 1985, section 5.8.
"""

from math import cosh, erf, exp, gamma, pi, sqrt, tanh

import numpy as np
import pytest
from scipy.integrate import quad

from piston_cosim.fmu_ehd.laws import roughness
from piston_cosim.fmu_ehd.laws.asperity import fitted_integral, gaussian_integral

from . import sleeve
from .sleeve import AREA, LENGTH, RADIUS, VISCOSITY, WIDTH, near

SHAPE = (4, 6)
SIGMA = 0.8e-6  # [m]

# gamma: C, r of phi_x [Patir1978] | A1, a1, a2, a3, A2 of Phi_s | A3, a4, a5, a6 of Phi_fs |
# D, s of phi_fp [Patir1979]
PUBLISHED = {
    1 / 9: (1.48, 0.42, 2.046, 1.12, 0.78, 0.03, 1.856, 14.1, 2.45, 2.30, 0.10, 1.51, 0.52),
    1 / 6: (1.38, 0.42, 1.962, 1.08, 0.77, 0.03, 1.754, 13.4, 2.42, 2.30, 0.10, 1.51, 0.54),
    1 / 3: (1.18, 0.42, 1.858, 1.01, 0.76, 0.03, 1.561, 12.3, 2.32, 2.30, 0.10, 1.47, 0.58),
    1.0: (0.90, 0.56, 1.899, 0.98, 0.92, 0.05, 1.126, 11.1, 2.31, 2.38, 0.11, 1.40, 0.66),
    3.0: (0.225, 1.5, 1.560, 0.85, 1.13, 0.08, 0.556, 9.8, 2.25, 2.80, 0.18, 0.98, 0.79),
    6.0: (0.520, 1.5, 1.290, 0.62, 1.09, 0.08, 0.388, 10.1, 2.25, 2.90, 0.18, 0.97, 0.91),
    9.0: (0.870, 1.5, 1.011, 0.54, 1.07, 0.08, 0.295, 8.7, 2.15, 2.97, 0.18, 0.73, 0.91),
}
LOWEST = {1 / 9: 1.0, 1 / 6: 1.0, 1 / 3: 0.75, 1.0: 0.5, 3.0: 0.5, 6.0: 0.5, 9.0: 0.5}


def phi_x(h, g):
    """[Patir1978]: 1 - C exp(-r H) for gamma <= 1, 1 + C H^-r above."""
    c, r = PUBLISHED[g][:2]
    return 1.0 - c * exp(-r * h) if g <= 1.0 else 1.0 + c * h**-r


def phi_s(h, g):
    """[Patir1979]: A1 H^a1 exp(-a2 H + a3 H^2) to H = 5, A2 exp(-H/4) above."""
    a1, p, q, r, a2 = PUBLISHED[g][2:7]
    return a1 * h**p * exp(-q * h + r * h * h) if h <= 5.0 else a2 * exp(-0.25 * h)


def phi_fs(h, g):
    """[Patir1979]: A3 H^a4 exp(-a5 H + a6 H^2) below H = 7, 0 from there."""
    a3, p, q, r = PUBLISHED[g][7:11]
    return a3 * h**p * exp(-q * h + r * h * h) if h < 7.0 else 0.0


def phi_fp(h, g):
    """[Patir1979]: 1 - D exp(-s H)."""
    d, s = PUBLISHED[g][11:]
    return 1.0 - d * exp(-s * h)


def phi_f(h):
    """Return phi_f of [Patir1979], h E(1/h_T), by quadrature with the pole apart.

    The density of heights is d(t) = (35/96) [1 - (t/3)^2]^3 in t = height/sigma.
    Films below sigma/100 are left out of 1/h_T to first order:

    int (d(t) - d(-h))/(h + t) dt + d(-h) ln[(h + 3)/0.01]
    """

    def density(t):
        return 35.0 / 96.0 * max(1.0 - (t / 3.0) ** 2, 0.0) ** 3

    pole = density(-h)
    regular = quad(lambda t: (density(t) - pole) / (h + t), max(-3.0, -h), 3.0, limit=200)[0]
    return h * (regular + pole * np.log((h + 3.0) / 0.01))


def gap(h):
    """E(max(h + t, 0)) of Gaussian heights, over sigma."""
    return h / 2.0 * (1.0 + erf(h / sqrt(2.0))) + exp(-h * h / 2.0) / sqrt(2.0 * pi)


def stepped(film, velocity=0.0, shape=SHAPE, **changes):
    """Return the outputs of one step of a constant film, or of a list of films in turn."""
    return sleeve.stepped(shape, film, velocity, **changes)


def rough(separation, velocity, gamma_, share, **changes):
    """Return the same for a parallel rough film with negligible contact pressure."""
    return stepped(
        separation * SIGMA,
        velocity,
        roughness_rms=SIGMA,
        flow_factors="patir_cheng_1978",
        roughness_share_skirt=share,
        boundary_friction_coefficient=0.0,
        **dict(peklenik_number_skirt=gamma_, peklenik_number_bore=gamma_) | changes,
    )


# ---- flow factors


@pytest.mark.parametrize("g", PUBLISHED)
@pytest.mark.parametrize("h", [1.5, 3.0, 6.0])
@pytest.mark.parametrize("share", [1.0, 0.5, 0.3, 0.0])
def test_pressure_flow_and_its_force(g, h, share):
    """Flow h^3 phi_x/(12 mu) dp/L B. The oil that flows up drags the bore along by dp/L times

    Y = 1     phi_fp h/2, [Patir1979]: the bore is smooth
    Y = 0     h - phi_fp h/2: the skirt is smooth, and both together carry h dp/L
    between   Y of the first and 1 - Y of the second; h/2 where both are alike

    and the skirt by the opposite. 1e-6: the table between its points.
    """
    o = rough(h, 0.0, g, share, pressure_lower_edge=4e5, pressure_upper_edge=1e5)
    flow = (h * SIGMA) ** 3 / (12.0 * VISCOSITY) * 3e5 / LENGTH * WIDTH
    assert o["flow_lower_edge"] == near(phi_x(h, g) * flow, rel=1e-6)
    smooth = phi_fp(h, g) * h / 2.0
    bore = (share * smooth + (1.0 - share) * (h - smooth)) * SIGMA
    assert o["friction_force_hydrodynamic"] == near(-bore * 3e5 / LENGTH * AREA, rel=1e-6)
    assert o["friction_power"] == 0.0


@pytest.mark.parametrize("g", PUBLISHED)
@pytest.mark.parametrize("h", [0.8, 1.5, 3.0, 6.0, 8.0])
@pytest.mark.parametrize("share, velocity", [(1.0, 3.0), (0.3, 3.0), (0.3, -3.0), (0.0, -3.0)])
def test_sliding_flow_force_and_power(g, h, share, velocity):
    """Sliding flow, force and power follow [Patir1979] in the frame of the skirt.

    With w = 2 Y - 1 = (sigma_skirt^2 - sigma_bore^2)/sigma^2:

    flow      U/2 (h_T - w sigma Phi_s),   a rough skirt keeps oil with it
    force     mu V/h (phi_f + Phi_fs),         whichever surface is rough

    [Patir1979] gives two stresses: phi_f + Phi_fs of the smooth moving surface under a rough one at
    rest, and phi_f - Phi_fs of the rough one. The rest of the rough one's force is pressure on its
    slopes. 2e-5: the tables between their points.
    """
    o = rough(h, velocity, g, share)
    w = 2.0 * share - 1.0
    flow = velocity / 2.0 * SIGMA * (gap(h) - w * phi_s(h, g)) * WIDTH
    assert o["flow_upper_edge"] == near(flow, rel=2e-5)
    assert o["flow_lower_edge"] == near(-flow, rel=2e-5)
    couette = VISCOSITY * velocity / (h * SIGMA) * AREA
    force = couette * (phi_f(h) + phi_fs(h, g))
    assert o["friction_force_hydrodynamic"] == near(-force, rel=2e-5)
    assert o["friction_power"] == near(force * velocity, rel=2e-5)


@pytest.mark.parametrize("g", PUBLISHED)
@pytest.mark.parametrize("h", [1.0, 1.5, 2.0, 3.0, 4.0, 5.0])
def test_force_of_a_gradient_and_flow_of_sliding_are_one_number(g, h):
    """Reciprocity of a slow viscous flow: pressure force and sliding flow have one coefficient.

    A pressure gradient exerts b dp/dy on the sliding bore; sliding carries V t/2 through the film.
    Because b = t/2, phi_fp H = H_T - Phi_s. Both are fits of one paper to two different averages.
    0.03: twice the width of the points in the paper's figures.
    """
    assert phi_fp(h, g) == pytest.approx((gap(h) - phi_s(h, g)) / h, abs=0.03)


def test_published_shear_stress_factor():
    """phi_f of [Patir1979] at H = 0.5, 1, 2, 3, 6, to its printed digits."""
    known = {0.5: 0.9070, 1.0: 1.6366, 2.0: 1.7460, 3.0: 1.1666, 6.0: 1.0299}
    for h, value in known.items():
        assert phi_f(h) == pytest.approx(value, abs=1e-4)  # cut, not rounded
        assert roughness.shear_stress_factor(h).value == pytest.approx(value, abs=1e-4)


@pytest.mark.parametrize("g", PUBLISHED)
def test_factors_hold_below_the_published_range(g):
    h = LOWEST[g]
    for below in (0.2, h - 0.01):
        assert roughness.pressure_flow_factor(below, g).value == near(phi_x(h, g))
    assert roughness.pressure_stress_factor(0.1, g).value == near(phi_fp(0.5, g))


@pytest.mark.parametrize("around", [6.0, 1 / 6])
def test_squeeze_flows_by_both_factors(around):
    """A rough sleeve that moves towards the thrust side, h = c - e sin(theta): with k = h^3/(12 mu)

    phi_a p_yy + phi_c/R^2 p_tt = 12 mu dh_T/dt / c^3,   phi_a = phi_x(H, gamma), phi_c = phi_x(H,
    1/gamma), dh_T/dh = (1 + erf(H/sqrt 2))/2
    p = p_e + A [1 - cosh(m y/R)/cosh(m L/2R)] sin(theta),   m^2 = phi_c/phi_a,
    A = 12 mu edot (dh_T/dh) R^2/(phi_c c^3)

    Grooves along the axis (gamma 6) let oil past along it. 2e-3: second order on 48 x 40 cells.
    """
    shape, h, edge, step = (48, 40), 1.5, 2e8, 1e-4
    film = h * SIGMA
    theta = (np.arange(48) + 0.5) * 2.0 * np.pi / 48
    shift = 1e-5 * film
    closed = film - shift * np.sin(theta)[:, None]
    o = stepped(
        [film, closed],
        shape=shape,
        roughness_rms=SIGMA,
        flow_factors="patir_cheng_1978",
        peklenik_number_skirt=around,
        peklenik_number_bore=around,
        pressure_lower_edge=edge,
        pressure_upper_edge=edge,
    )
    along, across = phi_x(h, around), phi_x(h, 1.0 / around)
    stored = 0.5 * (1.0 + erf(h / sqrt(2.0)))
    amplitude = 12.0 * VISCOSITY * shift / step * stored * RADIUS**2 / (across * film**3)
    m = sqrt(across / along)
    y = ((np.arange(40) + 0.5) / 40 - 0.5) * LENGTH
    profile = 1.0 - np.cosh(m * y / RADIUS) / cosh(m * LENGTH / (2.0 * RADIUS))
    expected = amplitude * np.outer(np.sin(theta), profile)
    assert np.abs(o["pressure"] - edge - expected).max() <= 2e-3 * np.abs(expected).max()
    half = m * LENGTH / (2.0 * RADIUS)
    push = np.pi * RADIUS * amplitude * LENGTH * (1.0 - tanh(half) / half)
    wet = (o["pressure"] - edge) * WIDTH * LENGTH / (48 * 40)
    assert (wet * np.sin(theta)[:, None]).sum() == near(push, rel=2e-3)


@pytest.mark.parametrize("share", [0.7, 0.2])
@pytest.mark.parametrize("skirt, bore", [(6.0, 1 / 3), (1 / 9, 3.0)])
def test_skirt_and_bore_have_grooves_of_their_own(skirt, bore, share):
    """Skirt and bore have separate grooves, weighted by the variances of both.

    This holds for the flow of a gradient and of sliding, and for the force of both.
    Sliding carries h_T - sigma (Y Phi_s - (1 - Y) Phi_b), as in [Patir1979] for different gammas.
    2e-5: the tables between their points.
    """
    h, velocity, rest = 2.0, 3.0, 1.0 - share
    given = dict(peklenik_number_bore=bore, pressure_lower_edge=4e7, pressure_upper_edge=1e7)
    still = rough(h, 0.0, skirt, share, **given)
    steady = rough(h, velocity, skirt, share, peklenik_number_bore=bore)
    pressed = (h * SIGMA) ** 3 / (12.0 * VISCOSITY) * 3e7 / LENGTH * WIDTH
    factor = share * phi_x(h, skirt) + rest * phi_x(h, bore)
    assert still["flow_lower_edge"] == near(factor * pressed, rel=2e-5)
    held = share * phi_s(h, skirt) - rest * phi_s(h, bore)
    carried = velocity / 2.0 * SIGMA * (gap(h) - held) * WIDTH
    assert steady["flow_upper_edge"] == near(carried, rel=2e-5)
    on_bore = share * phi_fp(h, skirt) / 2.0 + rest * (1.0 - phi_fp(h, bore) / 2.0)
    push = on_bore * h * SIGMA * 3e7 / LENGTH * AREA
    assert still["friction_force_hydrodynamic"] == near(-push, rel=2e-5)
    drag = phi_f(h) + share * phi_fs(h, skirt) + rest * phi_fs(h, bore)
    shear = VISCOSITY * velocity / (h * SIGMA) * AREA * drag
    assert steady["friction_force_hydrodynamic"] == near(-shear, rel=2e-5)


def test_between_published_numbers_factors_are_linear_in_the_logarithm():
    """Between published numbers the factors are linear in ln(gamma).

    gamma = 2 is ln 2/ln 3 = 0.63093 of the way from 1 to 3, at H = 2 by hand:
    phi_x = 0.36907 (1 - 0.9 exp(-1.12)) + 0.63093 (1 + 0.225 x 2^-1.5).
    """
    expected = 0.3690702 * (1.0 - 0.9 * 0.3262798) + 0.6309298 * (1.0 + 0.225 * 0.3535534)
    o = rough(2.0, 0.0, 2.0, 0.5, pressure_upper_edge=1e5)
    flow = (2.0 * SIGMA) ** 3 / (12.0 * VISCOSITY) * 1e5 / LENGTH * WIDTH
    assert o["flow_upper_edge"] == near(expected * flow, rel=1e-6)


# ---- asperity contact


PRODUCT, SLOPE, MODULUS = 0.047, 3.1e-3, 4.4e10
# H: F_5/2 and F_2 of [Greenwood1970], exact to the digits printed
INTEGRALS = {
    0.0: (6.16634e-1, 0.5),
    1.0: (8.05623e-2, 7.53398e-2),
    2.0: (5.42371e-3, 5.76873e-3),
    3.0: (1.70873e-4, 2.03435e-4),
}


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

    p = (16 sqrt 2 pi/15)(eta beta sigma)^2 sqrt(sigma/beta) E* F_5/2, 1/E* = sum (1 - nu^2)/E;
    A_c/A = pi^2 (eta beta sigma)^2 F_2; friction (mu_b p + tau_0 A_c/A) V/sqrt(V^2 + v_0^2) against
    sliding, here at V = -3/4 v_0: 3/5. 1e-5: digits of the integrals.
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
    bent = tilt * (y - 0.5) + barrel * (2.0 * y - 1.0) ** 2
    return 0.5 + np.where(unit % 8 < 4, 0.0, 10.0) + bent


@pytest.mark.parametrize("cells", [40, 80, 160])
@pytest.mark.parametrize("tilt, barrel", [(0.0, 0.0), (40.0, 0.0), (8.0, 20.0)])
def test_contact_on_lands_does_not_see_the_grooves(cells, tilt, barrel):
    """Contact on lands is independent of the grooves of 10 sigma between them.

    The lands are flat, tilted by up to one sigma in a cell, or also barrelled. The reference is the
    sum over the exact profile with 64 points in the smallest cell.
    0.4 %: at its two ends a land is straight within the cell, without the barrel's curvature.
    """
    y, fine = ((np.arange(n) + 0.5) / n for n in (cells, 64 * 160))
    film = np.tile(stepped_gap(y, tilt, barrel) * SIGMA, (4, 1))
    o = stepped(film, 0.0, film.shape, roughness_rms=SIGMA, contact_modulus=MODULUS)
    flat = stepped(SIGMA, 0.0, (4, 4), roughness_rms=SIGMA, contact_modulus=MODULUS)
    gap = stepped_gap(fine, tilt, barrel)
    overlap = -2.5 * gaussian_integral(1.5, 0.0) * np.minimum(gap, 0.0)  # along the tangent
    exact = (gaussian_integral(2.5, np.maximum(gap, 0.0)) + overlap).mean()
    found = o["asperity_pressure"].mean() / flat["asperity_pressure"][0, 0]
    assert found == near(exact / gaussian_integral(2.5, 1.0), rel=1e-6 if barrel == 0.0 else 4e-3)


def test_a_step_is_steeper_than_twice_the_gap_beside_it():
    """Eq. (A12): a step is steeper than twice the gaps next to it.

    Jumps of 0.9, 2, 0.9 sigma are a step, so that the cell before it is straight.
    With 1.1 before or after it they are none, nor are jumps of a tenth.
    """

    def force(gap):
        return gaussian_integral(2.5, gap)

    for scale, jumps, straight in (
        (1.0, (0.9, 2.0, 0.9), True),
        (1.0, (1.1, 2.0, 0.9), False),
        (1.0, (0.9, 2.0, 1.1), False),
        (0.1, (0.9, 2.0, 0.9), False),
    ):
        gap = 1.0 + scale * np.cumsum([0.0, *jumps])
        film = np.tile(gap * SIGMA, (4, 1))
        pressure = stepped(film, 0.0, (4, 4), roughness_rms=SIGMA)["asperity_pressure"][0]
        beyond = 2.0 * gap[1] - gap[0] if straight else gap[2]
        means = cell_mean(force, 2.0 * gap[0] - gap[1], gap[0], gap[1])
        means = cell_mean(force, gap[0], gap[1], beyond) / means
        assert pressure[1] / pressure[0] == near(means, rel=1e-6)


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
    """Overlap continues along the tangent: p(-2)/p(0) = 1 + 5 F_3/2(0)/F_5/2(0).

    F_n(0) = 2^((n-1)/2) Gamma((n+1)/2)/sqrt(2 pi), F' = -n F_(n-1).
    """
    at_zero = {n: 2 ** ((n - 1) / 2) * gamma((n + 1) / 2) / sqrt(2 * pi) for n in (1.5, 2.5)}
    pressure = [
        stepped([gap * SIGMA], roughness_rms=SIGMA)["asperity_pressure"][1, 2]
        for gap in (0.0, -2.0)
    ]
    assert pressure[1] / pressure[0] == near(1.0 + 5.0 * at_zero[1.5] / at_zero[2.5], rel=1e-9)


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
