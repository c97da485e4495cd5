"""`piston_cosim.bearing`: one call against tables and closed forms, its faults and its picture."""

from dataclasses import replace

import numpy as np
import pytest

import piston_cosim as pc
from piston_cosim.fmu_ehd import bearing as one
from piston_cosim.tests.verification.cases import bearings

RADIUS, CLEARANCE, TURNING, VISCOSITY = 25e-3, 25e-6, 300.0, 0.02
OIL_FILM = dict(radius="25 mm", clearance="25 um", speed="300 rad/s", oil="20 mPa s")
SMALL = dict(length="25 mm", load="2 kN") | OIL_FILM

# [Raimondi1958]: (L/D, e) -> load over the projected area, divided by the maximum pressure
PRESSURE_RATIOS = {(1.0, 0.4): 0.484, (0.5, 0.6): 0.365, (0.25, 0.8): 0.240}


def load_of(number, length):
    """Return the load of a Sommerfeld number [N]."""
    revolutions = TURNING / (2.0 * np.pi)
    return VISCOSITY * revolutions * 2.0 * RADIUS * length / number * (RADIUS / CLEARANCE) ** 2


@pytest.mark.parametrize("ratio, eccentricity", PRESSURE_RATIOS)
def test_a_bearing_is_that_of_the_table(ratio, eccentricity):
    """Table of [Raimondi1958] by the Sommerfeld number; 1.6 %, as in `verify ehd`."""
    number, attitude, friction, flow, side = bearings.TABLE[ratio, eccentricity]
    length = 2.0 * RADIUS * ratio
    load = load_of(number, length)
    found = pc.bearing(length=f"{length} m", load=f"{load:.12g} N", **OIL_FILM)
    assert found.sommerfeld_number == pytest.approx(number, rel=1e-9)
    # 1.6 % of S over d ln S/de = -(1/e + 4 e/(1 - e^2)) of a short bearing
    allowed = 0.016 / (1.0 / eccentricity + 4.0 * eccentricity / (1.0 - eccentricity**2))
    assert found.eccentricity_ratio == pytest.approx(eccentricity, abs=allowed)
    assert np.degrees(found.attitude_angle) == pytest.approx(attitude, abs=1.0)
    assert found.friction_coefficient * RADIUS / CLEARANCE == pytest.approx(friction, rel=0.016)
    unit = RADIUS * CLEARANCE * TURNING / (2.0 * np.pi) * length
    # three digits of Q and of its share
    assert found.side_flow / unit == pytest.approx(flow * side, rel=0.02)
    pressure = load / (2.0 * RADIUS * length) / found.maximum_pressure
    assert pressure == pytest.approx(PRESSURE_RATIOS[ratio, eccentricity], rel=0.016)
    # the peak is between the load and the thinnest film
    assert 0.0 < found.maximum_pressure_angle < found.attitude_angle
    assert found.minimum_film_thickness == pytest.approx(
        CLEARANCE * (1.0 - found.eccentricity_ratio), rel=1e-12
    )


def short_bearing(e):
    """Return C K/W and C omega D/W of a short bearing by x and y of the load, half Sommerfeld.

    Closed forms as in E. Kraemer, Dynamics of rotors and foundations, Springer 1993.
    """
    square, pi = 1.0 - e**2, np.pi
    s = np.sqrt(square)
    scale = 1.0 / (pi**2 * square + 16.0 * e**2) ** 1.5
    cross = pi * (pi**2 * square**2 - 16.0 * e**4) / (e * s)
    other = -pi * (pi**2 * square * (1.0 + 2.0 * e**2) + 32.0 * e**2 * (1.0 + e**2)) / (e * s)
    direct = 4.0 * (pi**2 * (1.0 + 2.0 * e**2) + 32.0 * e**2 * (1.0 + e**2) / square)
    k = [[4.0 * (pi**2 * (2.0 - e**2) + 16.0 * e**2), cross], [other, direct]]
    squeeze = pi**2 * (1.0 + 2.0 * e**2) - 16.0 * e**2
    along = 2.0 * pi * (pi**2 * square**2 + 48.0 * e**2) / (e * s)
    d = [[2.0 * pi * s * squeeze / e, -8.0 * squeeze], [-8.0 * squeeze, along]]
    return scale * np.array(k), scale * np.array(d)


@pytest.mark.parametrize("e", [0.4, 0.6])
def test_a_short_bearing_is_that_of_the_closed_form(e):
    """Eq. (V6), stiffness and damping, L/D = 0.06; the clearance is so thin that shear is small.

    Half of Sommerfeld's pressure ends inside a cell, so that the uncertainty is large.
    """
    ratio, radius, clearance = 0.06, 1.0, 1e-5
    square, length = 1.0 - e**2, 2.0 * radius * 0.06
    unit = VISCOSITY * TURNING * radius * length**3 / (4.0 * clearance**2)
    load = unit * e / square**2 * np.sqrt(16.0 * e**2 + np.pi**2 * square)
    found = pc.bearing(
        **SMALL
        | dict(radius="1 m", clearance="10 um", length=f"{length} m", load=f"{load:.12g} N"),
        cavitation_model="gumbel",
        minimum_flow_film="1 nm",
    )
    # corrections of the short bearing, and shear of 4 C R/L^2 of the load
    neglected = ratio**2 + 4.0 * clearance * radius / length**2
    attitude = np.arctan2(np.pi * np.sqrt(square), 4.0 * e)
    apart = found.uncertainty
    assert abs(found.eccentricity_ratio - e) <= apart["eccentricity_ratio"] + neglected * e
    assert abs(found.attitude_angle - attitude) <= apart["attitude_angle"] + neglected
    names = "dimensionless_stiffness", "dimensionless_damping"
    for name, exact in zip(names, short_bearing(e)):
        allowed = apart[name] + 2.0 * neglected * np.abs(exact).max()
        assert (np.abs(getattr(found, name) - exact) <= allowed).all(), name
        assert np.abs(apart[name]).max() <= 0.05 * np.abs(exact).max(), name


@pytest.fixture(scope="module")
def flooded():
    return pc.bearing(**SMALL)


@pytest.fixture(scope="module")
def grooved():
    return pc.bearing(**SMALL, supply="groove", supply_pressure="2 bar")


def test_damping_is_symmetric_and_stiffness_is_not(flooded, grooved):
    for found in (flooded, grooved):
        (_, xy), (yx, _) = found.damping
        # cavities keep their boundaries; cells of them are filled in part
        assert abs(xy - yx) <= 0.01 * np.abs(found.damping).max()
        # a rotating film pushes the journal ahead: the cause of whirl
        assert found.stiffness[1, 0] < 0.0 < found.stiffness[0, 1]
        scale = CLEARANCE / 2000.0
        assert found.dimensionless_stiffness == pytest.approx(scale * found.stiffness)
        assert found.dimensionless_damping == pytest.approx(TURNING * scale * found.damping)


def test_stiffness_is_the_slope_of_the_position(flooded):
    """A load along y that grows by 1 % moves the journal by K^-1; it stays the load's own axis."""
    more = pc.bearing(**SMALL | dict(load="2.02 kN"))
    less = pc.bearing(**SMALL | dict(load="1.98 kN"))
    moved = CLEARANCE * (more.film["position"] - less.film["position"])
    # the groove follows the thickest film here, and is fixed in K; and the third derivative
    assert flooded.stiffness @ moved == pytest.approx([0.0, -40.0], abs=2.0)


def test_units_do_not_change_a_bearing(flooded):
    written = dict(radius="2.5 cm", length="0.025 m", clearance="0.025 mm", load="0.002 MN")
    again = pc.bearing(**written, speed=f"{300 * 30 / np.pi:.15g} rpm", oil="0.02 Pa s")
    for name in one.ROWS:
        # units are converted in floating point, and equilibrium has a tolerance of 1e-9
        assert getattr(again, name) == pytest.approx(getattr(flooded, name), rel=1e-6), name


def test_a_groove_feeds_what_leaves_the_sides(flooded, grooved):
    drained = pc.bearing(**SMALL, supply="groove")
    assert drained.side_flow < grooved.side_flow
    # a groove opposite to the load is not where the film is thickest, and is shorter
    assert drained.side_flow < flooded.side_flow
    assert grooved.film["pressure"].max() > 2e5
    turned = pc.bearing(**SMALL, supply="groove", supply_pressure="2 bar", groove_angle="270 deg")
    fed = [(one.film["pressure"] == 2e5).any(axis=1) for one in (grooved, turned)]
    angles = [
        np.degrees(one.film["angle"][rows]) % 360.0 for one, rows in zip((grooved, turned), fed)
    ]
    for middle, angle in zip((180.0, 270.0), angles):
        assert angle.mean() == pytest.approx(middle, abs=1e-9) and len(angle) == 4
    assert abs(turned.eccentricity_ratio - grooved.eccentricity_ratio) > 1e-4


def test_an_oil_of_the_library_has_its_viscosity_at_the_temperature():
    oil = pc.Film((4, 4), oil="sae_5w_30").model.parameters.oil
    given = SMALL | dict(oil="SAE 5W-30 at 90 degC")
    found = pc.bearing(**given)
    assert found.viscosity == pytest.approx(float(oil.low_shear_viscosity(np.array(363.15))))
    same = pc.bearing(**given | dict(oil=f"{found.viscosity:.15g} Pa s"))
    assert same.eccentricity_ratio == pytest.approx(found.eccentricity_ratio, rel=1e-9)


def test_rough_surfaces_carry_a_part_of_the_load_of_a_slow_journal():
    slow = SMALL | dict(speed="20 rpm")
    rough = pc.bearing(**slow, roughness_rms="0.3 um", summit_height="0.6 um")
    smooth = pc.bearing(**slow)
    assert rough.rough and not smooth.rough
    assert rough.friction_coefficient > 5.0 * smooth.friction_coefficient
    assert rough.minimum_film_thickness > smooth.minimum_film_thickness


FAULTS = {
    "radius": ("25", "radius: expected a quantity in m, got '25'; write for example '25 mm'"),
    "length": ("25 km", "length: expected 0.001 to 2 m, got 25 km"),
    "clearance": (None, "clearance: expected a quantity in m, got nothing"),
    "speed": (3000, "speed: expected a quantity in rad/s, got 3000; write for example '3000 rpm'"),
    "load": ("-1 kN", "load: expected 0.001 to 1e+09 N, got -1 kN"),
    "oil": ("SAE 5W-30", "oil: expected a temperature after the name, got 'SAE 5W-30'"),
    "supply": ("pump", "supply: expected one of flooded, groove, got unknown supply 'pump'"),
    "grid": ((100, 24), "grid: expected multiples of 120 and 24 cells, got (100, 24)"),
    "bore_radius": ("1 mm", "bore_radius: expected no value, which the inputs set, got '1 mm'"),
    "viscosty": ("1 Pa s", "unknown parameter 'viscosty'; did you mean 'viscosity'"),
}


def test_all_faults_are_reported_at_once():
    with pytest.raises(pc.BadInput) as trouble:
        pc.bearing(**SMALL | {name: value for name, (value, _) in FAULTS.items()})
    assert len(trouble.value.faults) == len(FAULTS)
    for _, text in FAULTS.values():
        assert any(text in fault for fault in trouble.value.faults), text


@pytest.mark.parametrize(
    "changes, text",
    [
        (dict(clearance="3 mm"), "clearance: expected 1e-06 to 0.1 of the radius, got 0.12"),
        (dict(supply_pressure="1 bar"), "supply_pressure: expected supply='groove' with it"),
        (dict(oil="SAE 10W-31 at 90 degC"), "oil: expected one of engine_oil_vogel_cross,"),
        (dict(oil="20 mPa"), "oil: expected a quantity in Pa.s, got '20 mPa'"),
        (dict(oil="-3 mPa s"), "oil: expected 1e-05 to 1000 Pa.s, got -3 mPa s; a name"),
        (dict(oil="SAE 5W-30 at 900 degC"), "oil: expected 233.15 to 573.15 K, got 900 degC"),
        (dict(viscosity="3 mPa s"), "viscosity: expected no value, which the inputs set"),
        (dict(oil=None), "oil: expected a quantity in Pa.s, got nothing"),
        (dict(oil="sae_5w_30 at 5 bar"), "oil: expected a quantity in K, got '5 bar'; write"),
        (dict(roughness_rms=0.3), "roughness_rms: expected a quantity in m, got 0.3; write for"),
        (dict(roughness_rms="0.3 m"), "roughness_rms: expected 0 to 0.0001 m, got 0.3 m"),
        (dict(cavitation_model="foo"), "cavitation_model: expected one of jfo, reynolds,"),
        (
            dict(oil_temperature_lower_edge="900 degC"),
            "oil_temperature_lower_edge: expected 233.15 to 573.15 K, got 900 degC",
        ),
    ],
)
def test_a_fault_is_reported(changes, text):
    begun = []
    with pytest.raises(pc.BadInput) as trouble:
        pc.bearing(**SMALL | changes, progress=begun.append)
    assert len(trouble.value.faults) == 1 and text in str(trouble.value)
    assert not begun


def test_the_table_states_supply_definitions_and_uncertainties(flooded, grooved):
    text = str(flooded)
    assert text.count("+-") == len(one.ROWS) - 1 + 4 * len(one.MATRICES) + 1
    assert "oil supply flooded: the film begins full" in text and "cavitation model jfo" in text
    assert "oil supply groove: axial groove, 12 deg wide" in str(grooved)
    assert one.SMOOTH in text and one.SMOOTH not in str(replace(flooded, rough=True))
    assert "S = mu N D L/W (R/C)^2" in text and "y points against the load" in text
    (row,) = (line for line in text.split("\n") if line.startswith("minimum film"))
    assert float(row.split()[3]) == pytest.approx(1e6 * flooded.minimum_film_thickness, abs=0.05)


@pytest.mark.parametrize(
    "value, uncertainty, text",
    [
        (-12345.0, 567.0, "-12300 +- 600"),
        (0.0123456, 0.0, "0.012346"),
        (1.5, float("nan"), "1.5 +- unknown"),
    ],
)
def test_a_value_has_the_digits_of_its_uncertainty(value, uncertainty, text):
    assert one._row("load", value, uncertainty, "x") == f"{'load':32s} {text} x"


def test_the_uncertainty_is_that_of_three_grids():
    """By hand: order 1 gives 5/4 of the error, order 2 15/4 of it, and a crossing a quarter."""
    for values, wanted in (
        ((10.1, 10.2, 10.4), 0.125),
        ((10.1, 10.4, 11.6), 0.375),
        ((10.0, 10.0, 10.8), 0.25),
    ):
        levels = [dict(figure=value) for value in values]
        assert one._uncertainty(levels)["figure"] == pytest.approx(wanted)
    assert np.isnan(one._uncertainty([dict(figure=1.0), dict(figure=1.1), None])["figure"])


def test_a_coarse_grid_without_solution_leaves_the_uncertainty_unknown(monkeypatch):
    solved = one._solved

    def only_fine(x, parameters, grid, *others):
        if grid[0] < 60:
            raise pc.Discard("no position")
        return solved(x, parameters, grid, *others)

    monkeypatch.setattr(one, "_solved", only_fine)
    found = pc.bearing(**SMALL)
    assert np.isnan(found.uncertainty["eccentricity_ratio"])
    assert str(found).count("+- unknown") == len(one.ROWS) - 1 + 4 * len(one.MATRICES)
    assert str(found).endswith(one.NO_UNCERTAINTY)


def test_the_picture_marks_the_peak_and_the_thinnest_film(flooded):
    section, curves, film = flooded.plot().axes
    (peak,) = (line for line in curves.lines if line.get_marker() == "o")
    assert peak.get_xdata()[0] == np.degrees(flooded.maximum_pressure_angle)
    assert peak.get_ydata()[0] == flooded.maximum_pressure / 1e6
    curve = film.lines[0]
    lowest = curve.get_xdata()[np.argmin(curve.get_ydata())]
    # within half a cell
    assert lowest == pytest.approx(np.degrees(flooded.attitude_angle), abs=1.5)
    # the journal is below and to the right of the shell for a load downwards
    (line,) = (line for line in section.lines if line.get_marker() == "o")
    assert line.get_xdata()[1] > 0.0 > line.get_ydata()[1]


@pytest.mark.slow
def test_known_answers_are_inside_the_uncertainty():
    """Figures on a grid twice as fine: 19 of 20 inside, which itself has a quarter of the error.

    Their median uncertainty is at most 5 times the distance.
    """
    inside, shares = [], []
    for ratio in (0.25, 1.0):
        for supply in one.SUPPLIES:
            for number in (1.0, 0.2, 0.05):
                length = 2.0 * RADIUS * ratio
                load = load_of(number / ratio**2 if ratio < 1.0 else number, length)
                given = OIL_FILM | dict(length=f"{length} m", load=f"{load:.12g} N", supply=supply)
                found, finer = (pc.bearing(**given, grid=(120 * n, 24 * n)) for n in (1, 2))
                for name in {*one.ROWS, "stiffness", "damping"} - {"sommerfeld_number"}:
                    apart = np.abs(getattr(found, name) - getattr(finer, name))
                    inside += list(np.ravel(found.uncertainty[name] >= 4.0 / 3.0 * apart))
                    shares += list(np.ravel(found.uncertainty[name] / apart))
    assert np.mean(inside) >= 0.95 and len(inside) >= 40
    assert np.median(shares) <= 5.0
