"""Numbers of the film by closed form: pressure, flow, load, shear, power, cavitation, edges, time.

Nothing here is computed by the code under test: every expected number is a formula written out in
the test, with its source. Edges differ, sliding goes both ways, grids have n_c != n_a, and bore
radius and skirt length are no multiples of each other, so that a sign or a swap shows.

Signs: j runs from the lower to the upper edge, the skirt slides at V over the bore, and the oil
between them at V/2. Seen from the skirt, on which the grid rides, it therefore moves at -V/2.

References
----------
[Hamrock2004] B. J. Hamrock, S. R. Schmid, B. O. Jacobson, Fundamentals of Fluid Film Lubrication,
2nd ed., Marcel Dekker 2004.
"""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from piston_cosim.fmu_ehd.model import LubricationModel
from piston_cosim.fmu_ehd.summary import halves

from .sleeve import LENGTH, RADIUS, VISCOSITY, WIDTH, near, parameters, stepped

STEADY = 1e6  # [s], a step so long that storage is 1e-10 of the flow


def along(cells):
    """y/L of the cell centres."""
    return (np.arange(cells) + 0.5) / cells


# ---- full film, axial flow


def test_a_groove_around_the_skirt_with_a_supply_of_its_own():
    """Pressure falls evenly from the groove to both edges, by hand: each land carries

    q = -V h/2 - h^3/(12 mu) dp/dy

    and the groove gives what both edges take. Lands of 9 and 5 um, the groove's own film is looked
    at nowhere; it presses on nothing. Round-off: an even film is exact on every grid.
    """
    cells, groove, velocity = 30, 12, -4.0
    lower, supply = 1.0e5, 4.0e5
    film = np.where(np.arange(cells) < groove, 9e-6, 5e-6)
    film[groove] = 2e-3
    mask = np.broadcast_to(np.arange(cells) == groove, (4, cells))
    o = stepped(
        (4, cells),
        film,
        velocity,
        open_cells=mask,
        pressure_lower_edge=lower,
        opening_supply="own",
        pressure_openings=supply,
    )
    a = LENGTH * groove / cells
    b = LENGTH * (cells - groove - 1) / cells
    y = along(cells) * LENGTH
    expected = np.where(y < a, lower + (supply - lower) * y / a, supply * (LENGTH - y) / b)
    expected[groove] = supply
    assert o["pressure"][1] == near(expected, rel=1e-11)
    drag = -velocity / 2.0
    into = WIDTH * (drag * 9e-6 - 9e-6**3 / (12.0 * VISCOSITY) * (supply - lower) / a)
    out = WIDTH * (drag * 5e-6 + 5e-6**3 / (12.0 * VISCOSITY) * supply / b)
    assert o["flow_lower_edge"] == near(into, rel=1e-10)
    assert o["flow_upper_edge"] == near(-out, rel=1e-10)
    assert o["flow_openings"] == near(out - into, rel=1e-10)
    area = WIDTH / 4.0 * LENGTH / cells
    force = area * expected
    force[groove] = 0.0
    assert o["nodal_pressure_force"][3] == near(force, rel=1e-11)
    # shear of Eq. (F1), also in the cells beside the groove
    shear = -VISCOSITY * velocity / 5e-6 - 5e-6 / 2.0 * supply / b
    assert o["nodal_friction_force"][0, groove + 1 :] == near(
        np.full(cells - groove - 1, area * shear), rel=1e-9
    )


def test_a_window_that_is_starved_starves_the_film_behind_it():
    """A starved window starves the film behind it.

    Oil moves up past a window that covers the whole width with a share f = 0.4.
    The land above carries f h U/2 over the upper edge.
    The window takes the rest of the oil from below. 1e-6 as for `test_starved_edges`.
    """
    mask = np.broadcast_to(np.arange(9) == 4, (4, 9))
    o = stepped(
        (4, 9),
        8e-6,
        -3.0,
        step=STEADY,
        open_cells=mask,
        opening_supply="own",
        film_fraction_openings=0.4,
    )
    flow = 8e-6 * 3.0 / 2.0 * WIDTH
    assert o["film_fraction"][2, 5:] == near(np.full(4, 0.4), rel=1e-6)
    assert o["flow_lower_edge"] == near(flow, rel=1e-6)
    assert o["flow_upper_edge"] == near(-0.4 * flow, rel=1e-6)
    assert o["flow_openings"] == near(-0.6 * flow, rel=1e-6)


def test_what_a_window_takes_closes_the_balance_of_a_steady_film():
    """The oil that comes over both edges of a steady film leaves through a window of 2 x 3 cells.

    1e-8: storage in a step of 1e6 s.
    """
    mask = np.zeros((8, 12), dtype=bool)
    mask[2:4, 5:8] = True
    film = 8e-6 * (1.0 + 0.3 * np.sin(np.arange(8) * np.pi / 4.0))[:, None] * (1.5 - along(12))
    o = stepped(
        (8, 12),
        film,
        -3.0,
        step=STEADY,
        open_cells=mask,
        opening_supply="own",
        pressure_openings=2e5,
    )
    assert abs(o["flow_openings"]) > 0.1 * abs(o["flow_lower_edge"])
    assert o["flow_openings"] == near(-(o["flow_lower_edge"] + o["flow_upper_edge"]), rel=1e-8)


def test_step_bearing_between_two_edge_pressures():
    """Rayleigh's step with p_l and p_u at the edges, by hand: linear pressure on either side,

    q = -V h_a/2 - k_a (p_s - p_l)/a = -V h_b/2 - k_b (p_u - p_s)/b,   k = h^3/(12 mu)

    gives p_s at the step. Round-off: a stepped film is exact on every grid.
    """
    cells, first = 30, 12
    lower, upper, velocity = 3.0e5, 1.2e5, -4.0
    film = np.where(np.arange(cells) < first, 9e-6, 5e-6)
    o = stepped((4, cells), film, velocity, pressure_lower_edge=lower, pressure_upper_edge=upper)
    a = LENGTH * first / cells
    b = LENGTH - a
    k_a = 9e-6**3 / (12.0 * VISCOSITY)
    k_b = 5e-6**3 / (12.0 * VISCOSITY)
    drag = -velocity / 2.0 * (9e-6 - 5e-6)
    step = (drag + k_a * lower / a + k_b * upper / b) / (k_a / a + k_b / b)
    assert step > lower  # the oil moves up, into the thinner film
    y = along(cells) * LENGTH
    expected = np.where(y < a, lower + (step - lower) * y / a, step + (upper - step) * (y - a) / b)
    assert o["pressure"][2] == near(expected, rel=1e-11)
    flow = WIDTH * (-velocity * 9e-6 / 2.0 - k_a * (step - lower) / a)
    assert o["flow_lower_edge"] == near(flow, rel=1e-11)
    assert o["flow_upper_edge"] == near(-flow, rel=1e-11)
    area = WIDTH / 4.0 * LENGTH / cells
    assert o["nodal_pressure_force"][1] == near(expected * area, rel=1e-11)
    # the opposite of the shear on the bore in the lower part, -mu V/h + h/2 dp/dy
    gradient = (step - lower) / a
    shear = -VISCOSITY * velocity / 9e-6 + 9e-6 / 2.0 * gradient
    assert o["nodal_friction_force"][3, 4] == near(area * shear, rel=1e-9)
    # the first cell takes the pressure of the edge itself
    assert o["nodal_friction_force"][3, 0] == near(area * shear, rel=1e-9)
    last = -VISCOSITY * velocity / 5e-6 + 5e-6 / 2.0 * (upper - step) / b
    assert o["nodal_friction_force"][3, -1] == near(area * last, rel=1e-9)
    power = -velocity * o["nodal_friction_force"].sum()
    assert o["friction_power"] == near(power)
    # shear on the skirt, -mu V/h - h/2 dp/dy, and p on the face of its step: besides the force,
    # what the edge pressures put on both ends of the film, p_l h_a - p_u h_b
    sheared = -VISCOSITY * velocity * (a / 9e-6 + b / 5e-6)
    sheared -= 9e-6 / 2.0 * (step - lower) + 5e-6 / 2.0 * (upper - step)
    pressed = step * (9e-6 - 5e-6)
    ends = lower * 9e-6 - upper * 5e-6
    # the difference over two cells blurs the kink at the step: dy/8 (change of dp/dy) (h_a - h_b)
    kink = LENGTH / cells / 8.0 * ((upper - step) / b - gradient) * (9e-6 - 5e-6)
    total = (sheared + pressed - ends + kink) * WIDTH
    assert o["nodal_friction_force"].sum() == near(total, rel=1e-9)


def test_conditions_of_a_step_take_the_place_of_the_parameters():
    """Pressure flow through a parallel film: q = h^3/(12 mu) (p_l - p_u)/L B. Round-off."""
    given = dict(pressure_lower_edge=2e5, pressure_upper_edge=5e5)
    o = stepped((4, 6), 8e-6, 0.0, conditions=given, pressure_lower_edge=9e5)
    flow = 8e-6**3 / (12.0 * VISCOSITY) * (2e5 - 5e5) / LENGTH * WIDTH
    assert o["flow_lower_edge"] == near(flow, rel=1e-11)
    assert o["pressure"][0] == near(2e5 + 3e5 * along(6), rel=1e-11)


def test_start_is_linear_between_the_edges_and_shears_at_once():
    o = stepped((4, 5), [7e-6], 3.0, pressure_lower_edge=4e5, pressure_upper_edge=1e5)
    assert o["pressure"][1] == near(4e5 - 3e5 * along(5), rel=1e-12)
    # -mu V/h + h/2 dp/dy with dp/dy = -3e5/L
    area = WIDTH * LENGTH
    expected = area * (-VISCOSITY * 3.0 / 7e-6 - 3.5e-6 * 3e5 / LENGTH)
    assert o["friction_force_hydrodynamic"] == near(expected, rel=1e-12)


def test_no_oil_sees_a_film_below_the_floor():
    """h_min in place of h for flow and shear, h itself for the output. Round-off."""
    floor = 3e-7
    o = stepped((4, 6), 1e-7, 2.0, minimum_flow_film=floor, pressure_upper_edge=1e6)
    flow = floor**3 / (12.0 * VISCOSITY) * 1e6 / LENGTH * WIDTH + 2.0 / 2.0 * floor * WIDTH
    assert o["flow_upper_edge"] == near(flow, rel=1e-9)
    shear = VISCOSITY * 2.0 / floor - floor / 2.0 * 1e6 / LENGTH
    assert o["friction_force_hydrodynamic"] == near(-shear * WIDTH * LENGTH, rel=1e-9)
    assert o["minimum_film_thickness"] == 1e-7


# ---- full film, both directions


def squeezed(depth, cells):
    """int over the skirt of 1 - cosh(y/R)/cosh(L/2R), with `depth` = sqrt(k_c/k_a)."""
    half = depth * LENGTH / (2.0 * RADIUS)
    return LENGTH * (1.0 - np.tanh(half) / half)


def test_squeeze_of_a_short_sleeve():
    """Squeeze of a short sleeve that moves by e towards the thrust side in a step H.

    The film is h = c - e sin(theta). By separation of variables, with
    k_a p_yy + k_c/R^2 p_tt = hdot and p = p_e at both edges:

    p = p_e + 12 mu edot R^2/c^3 [1 - cosh(y/R)/cosh(L/2R)] sin(theta)

    e is 1e-5 of c. 1e-3, and 2e-3 in sums: second order on 48 cells around.
    """
    shape, film, edge, step = (48, 40), 1e-5, 2e6, 1e-4
    theta = np.arange(48) * 2.0 * np.pi / 48
    shift = 1e-5 * film
    closed = film - shift * np.sin(theta)[:, None]
    edges = dict(pressure_lower_edge=edge, pressure_upper_edge=edge)
    o = stepped(shape, [film, closed], step=step, **edges)
    amplitude = 12.0 * VISCOSITY * shift / step * RADIUS**2 / film**3
    y = (along(40) - 0.5) * LENGTH
    profile = 1.0 - np.cosh(y / RADIUS) / np.cosh(LENGTH / (2.0 * RADIUS))
    expected = amplitude * np.outer(np.sin(theta), profile)
    assert np.abs(o["pressure"] - edge - expected).max() <= 1e-3 * np.abs(expected).max()
    # across the thrust plane: edge pressure 2 R L p_e, squeeze pi/2 R amplitude int(profile)
    common = 2.0 * RADIUS * LENGTH * edge
    push = np.pi / 2.0 * RADIUS * amplitude * squeezed(1.0, 40)
    assert o["radial_force_thrust_side"] == near(common + push, rel=2e-3)
    difference = o["radial_force_thrust_side"] - o["radial_force_anti_thrust_side"]
    assert difference == near(2.0 * push, rel=2e-3)
    assert o["minimum_film_thickness_thrust_side"] == near(closed.min())
    assert o["minimum_film_thickness_anti_thrust_side"] == closed[24].min() == near(film)


def test_halves_meet_on_the_pin_axis():
    """The halves meet on the pin axis.

    Of five cells around, the second is on the thrust line. The first reaches from -18 to 54 deg,
    the third from 126 to 198 deg. Three quarters of each count on the thrust side.
    """
    film = np.array([4e-6, 5e-6, 6e-6, 7e-6, 9e-6])[:, None]
    o = stepped((5, 4), film, 2.0)
    shear = -VISCOSITY * 2.0 / film[:, 0] * WIDTH * LENGTH / 5.0
    # the film is the same all along the skirt: no pressure, Couette shear to round-off
    assert o["friction_force_thrust_side"] == near(
        0.75 * shear[0] + shear[1] + 0.75 * shear[2], rel=1e-12
    )
    assert o["friction_force_anti_thrust_side"] == near(
        0.25 * shear[0] + 0.25 * shear[2] + shear[3] + shear[4], rel=1e-12
    )
    assert o["minimum_film_thickness_thrust_side"] == 4e-6
    assert o["minimum_film_thickness_anti_thrust_side"] == 4e-6


def test_halves_of_a_grid_with_cells_on_or_beside_the_pin_axis():
    """Four cells: two on the pin axis count half. Six: three on each side."""
    four = halves(4)
    assert list(four.share) == [0.5, 1.0, 0.5, 0.0]
    assert four.sine == pytest.approx([0.0, 1.0, 0.0, -1.0], abs=1e-15)
    assert list(halves(6).share) == [1.0, 1.0, 1.0, 0.0, 0.0, 0.0]
    assert halves(6).sine == pytest.approx([0.5, 1.0, 0.5, -0.5, -1.0, -0.5])


# ---- cavitation


@pytest.mark.parametrize("velocity, edge", [(-3.0, "lower"), (3.0, "upper")])
@pytest.mark.parametrize("shear", ["film_fraction", "full_film"])
def test_starved_edges(velocity, edge, shear):
    """A parallel film fed with a share f of oil stays at f: flow f h U/2, shear f mu V/h.

    1e-6: what storage is worth in a step of 1e6 s, and f of the other edge does not show.
    """
    fed = {"lower": 0.6, "upper": 0.7}
    o = stepped(
        (4, 6),
        8e-6,
        velocity,
        step=STEADY,
        film_fraction_lower_edge=0.6,
        film_fraction_upper_edge=0.7,
        cavity_shear=shear,
    )
    share = fed[edge]
    assert o["film_fraction"] == near(np.full((4, 6), share), rel=1e-6)
    flow = share * 8e-6 * 3.0 / 2.0 * WIDTH
    other = "upper" if edge == "lower" else "lower"
    assert o[f"flow_{edge}_edge"] == near(flow, rel=1e-6)
    assert o[f"flow_{other}_edge"] == near(-flow, rel=1e-6)
    filled = share if shear == "film_fraction" else 1.0
    force = filled * VISCOSITY * 3.0 / 8e-6 * WIDTH * LENGTH
    assert o["friction_force_hydrodynamic"] == near(-np.sign(velocity) * force, rel=1e-6)
    assert o["friction_power"] == near(3.0 * force, rel=1e-6)


def slider(s):
    """Film of the parabolic slider over h_o, s = y/L."""
    return 1.0 + 0.5 * (2.0 * s - 1.0) ** 2


def slider_pressure(flow, s):
    """p h_o^2/(mu U L) at s, from 0 at s = 0: 6 int (h - flow)/h^3, [Hamrock2004]."""
    return 6.0 * quad(lambda t: (slider(t) - flow) / slider(t) ** 3, 0.0, s)[0]


@pytest.mark.parametrize("name", ["reynolds", "gumbel", "full_film"])
@pytest.mark.parametrize("velocity", [-5.0, 5.0])
def test_parabolic_slider(name, velocity):
    """Slider with the parabolic film h = h_o [1 + (2 y/L - 1)^2/2].

    Reynolds: exit p = dp/dy = 0 at 0.7065 L, with p* = 0.13425 and W* = 0.05284; full film:
    p(L) = 0; Gumbel: its positive half.
    5e-4: second order on 200 cells; the exit of the film is within a cell.
    """
    thin, speed = 5e-6, abs(velocity)
    cells = 200
    o = stepped(
        (4, cells), thin * slider(along(cells)), velocity, cavitation_model=name, step=STEADY
    )
    if name == "reynolds":
        end = brentq(lambda s: slider_pressure(slider(s), s), 0.55, 0.95)
        flow = slider(end)
        assert end == pytest.approx(0.7065, abs=5e-5)
    else:
        end, flow = 1.0, brentq(lambda f: slider_pressure(f, 1.0), 1.0, 1.5)
    s = along(cells) if velocity < 0.0 else along(cells)[::-1]
    exact = np.array([slider_pressure(flow, min(x, end)) for x in s])
    if name == "gumbel":
        exact = np.maximum(exact, 0.0)
    scale = VISCOSITY * speed * LENGTH / thin**2
    assert np.abs(o["pressure"][3] / scale - exact).max() <= 5e-4 * exact.max()
    assert o["maximum_pressure"] / scale == near(exact.max(), rel=5e-4)
    load = o["nodal_pressure_force"].sum() / (scale * LENGTH * WIDTH)
    assert load == pytest.approx(exact.mean(), abs=5e-4 * exact.max())
    if name == "reynolds":
        assert exact.max() == near(0.13425, rel=2e-4)  # the peak is between centres
        assert load == near(0.05284, rel=1e-3)
    assert np.all(o["film_fraction"] == 1.0)


# ---- time


def test_squeeze_that_speeds_up_over_steps_of_any_length():
    """A flat film h = h0 - a t - b t^2 between its edges: with dh/dt at the end of the step

    p = p_e - 6 mu dh/dt / h^3 [y (L - y) + dy^2/4]

    (parabola of the continuous film, and what half cells at the edges add). Second order in time is
    exact for a film quadratic in time from the third step on, whatever the steps: the first knows
    no past, and the second none that its growth could be held against. Inflow over each edge is
    B L/2 dh/dt. 1e-9: round-off of the differences of film content.
    """
    shape, edge = (4, 9), 5e6
    model = LubricationModel(parameters(shape, pressure_lower_edge=edge, pressure_upper_edge=edge))

    def film(t):
        return 12e-6 - 2e-3 * t - 3.0 * t * t

    still, time, before = np.zeros(shape), 0.0, film(0.0)
    state, _ = model.start(np.full(shape, before), still)
    y = along(9) * LENGTH
    parabola = y * (LENGTH - y) + (LENGTH / 9) ** 2 / 4.0
    for number, step in enumerate((1e-4, 1.3e-4, 0.7e-4, 1.4e-4)):
        time += step
        h = film(time)
        state, o = model.advance(state, np.full(shape, h), still, step)
        # the first two are backward Euler
        rate = (h - before) / step if number <= 1 else -2e-3 - 6.0 * time
        before = h
        expected = edge - 6.0 * VISCOSITY * rate / h**3 * parabola
        assert o["pressure"][2] == near(expected, rel=1e-9)
        assert o["flow_lower_edge"] == near(WIDTH * LENGTH / 2.0 * rate, rel=1e-8)
        assert o["flow_upper_edge"] == near(WIDTH * LENGTH / 2.0 * rate, rel=1e-8)


def test_a_step_that_grows_more_than_twice_counts_as_twice():
    """A step that grows more than twice counts as twice.

    c_e = c_n + beta (c_n - c_(n-1)), beta = w^2/(1 + 2 w) with w = 2: beta = 0.8, and
    H_e = H - 0.8 H_n, for w = 3: rate = (c - c_e)/(H - 0.8 H/3).
    """
    shape, edge = (4, 6), 5e6
    model = LubricationModel(parameters(shape, pressure_lower_edge=edge, pressure_upper_edge=edge))
    still = np.zeros(shape)
    films, steps = (12.0e-6, 11.9e-6, 11.8e-6, 11.1e-6), (1e-4, 1e-4, 3e-4)
    state, _ = model.start(np.full(shape, films[0]), still)
    for h, step in zip(films[1:], steps):
        state, o = model.advance(state, np.full(shape, h), still, step)
    start = films[2] + 0.8 * (films[2] - films[1])
    rate = (films[3] - start) / (3e-4 - 0.8 * 1e-4)
    assert o["flow_lower_edge"] == near(WIDTH * LENGTH / 2.0 * rate, rel=1e-9)
