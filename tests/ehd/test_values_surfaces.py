"""Flow between rough surfaces against published tables and formulas.

Every published coefficient of Patir and Cheng is typed here a second time. The model must give
flow and force with it: pressure flow and sliding flow, axial force and power. The roughness is on
the skirt, on the bore, or on both.

References
----------
[Patir1978] N. Patir, H. S. Cheng, J. Lubr. Technol. 100 (1978) 12-17, table 1.
[Patir1979] N. Patir, H. S. Cheng, J. Lubr. Technol. 101 (1979) 220-229, tables 1 to 4.
"""

from math import cosh, erf, exp, pi, sqrt, tanh

import numpy as np
import pytest
from scipy.integrate import quad

from piston_cosim.fmu_ehd.balance.flow_film import FilmLaws, ShearedOil, flow_film
from piston_cosim.fmu_ehd.common.quantities import COUETTE
from piston_cosim.fmu_ehd.laws import roughness
from piston_cosim.fmu_ehd.laws.oil import Oil

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


def density(t):
    """Density of heights of [Patir1979], t = height/sigma."""
    return 35.0 / 96.0 * max(1.0 - (t / 3.0) ** 2, 0.0) ** 3


def phi_f(h):
    """Return phi_f of [Patir1979], h E(1/h_T), by quadrature with the pole apart.

    Films below sigma/100 are left out of 1/h_T to first order:

    int (d(t) - d(-h))/(h + t) dt + d(-h) ln[(h + 3)/0.01]
    """
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


def test_published_shear_stress_factor():
    """phi_f of [Patir1979] at H = 0.5, 1, 2, 3, 6, to its printed digits."""
    known = {0.5: 0.9070, 1.0: 1.6366, 2.0: 1.7460, 3.0: 1.1666, 6.0: 1.0299}
    for h, value in known.items():
        assert phi_f(h) == pytest.approx(value, abs=1e-4)  # cut, not rounded
        assert h * roughness.mean_inverse_gap(h).value == pytest.approx(value, abs=1e-4)


@pytest.mark.parametrize("h", [-2.0, -0.5, 0.5, 2.0, 4.0])
def test_oil_is_thinned_at_the_mean_shear_rate_of_the_films_that_are_left(h):
    """The mean of V/h_T over the area where h_T > 0, by quadrature, thins the oil; Cross, m = 0.3.

    The critical shear rate is V/sigma. The smallest film for flow has no effect.
    """
    law = Oil(
        shear_thinning_law="cross_1965",
        high_shear_ratio=0.3,
        critical_shear_rate_a=-np.log10(SIGMA),
        critical_shear_rate_b=0.0,
    ).thinning
    table = roughness.factor_table(1.0, 1.0, 1.0)
    one = np.ones((1, 1))
    oil = ShearedOil(one, 0.0 * one, VISCOSITY * one, 350.0 * one)

    def drag(separation, floor, kind):
        laws = FilmLaws(floor, SIGMA, table, law._replace(kind=kind))
        film = flow_film(separation * SIGMA * one, oil, laws)
        return film.quantities[COUETTE, 0, 0], film.slopes.by_film[COUETTE, 0, 0]

    rate = phi_f(h) / h / quad(density, max(-3.0, -h), 3.0)[0]
    thinned = 0.3 + 0.7 / (1.0 + rate)
    for floor in (1e-9, 200e-9):
        drags = [drag(h + step, floor, law.kind) for step in (-1e-4, 0.0, 1e-4)]
        assert drags[1][0] / drag(h, floor, 0)[0] == near(thinned, rel=1e-6)
        difference = (drags[2][0] - drags[0][0]) / (2e-4 * SIGMA)
        assert drags[1][1] == pytest.approx(difference, rel=1e-5)  # the step squared


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
