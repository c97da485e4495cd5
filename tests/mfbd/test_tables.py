"""Gas tables, measured profiles, bore shapes: values, and what is refused."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from piston_cosim.fmu_mfbd.build import prepare, read_tables
from piston_cosim.fmu_mfbd.dynamics.assembly import assemble
from piston_cosim.fmu_mfbd.dynamics.build_options import BuildOptions
from piston_cosim.fmu_mfbd.dynamics.model import Inputs
from piston_cosim.fmu_mfbd.dynamics.parameters import Parameters
from piston_cosim.fmu_mfbd.dynamics.speed_table import crank_motion, speed_table
from piston_cosim.fmu_mfbd.dynamics.step import GAS
from piston_cosim.fmu_mfbd.dynamics.tables import (
    TableFault,
    gas_pressure,
    gas_table,
    inline_numbers,
    profile_table,
    read_numbers,
)
from piston_cosim.fmu_mfbd.geometry.profile import (
    BoreOrder,
    MeasuredShape,
    fourier_bore,
    ovality,
    table_shape,
)
from piston_cosim.fmu_mfbd.options import read_options
from piston_cosim.fmu_mfbd.reduction.reduced_body import ReducedBlock, ReducedPiston, load
from piston_cosim.master.fmi.errors import BadInput

DEG = np.pi / 180


def curve(angle):
    return 5e5 * (1 + np.cos(angle / 2))


@pytest.fixture
def gas_file(tmp_path):
    lines = ["crank angle [deg], pressure [bar]"] + [
        f"{a}, {curve(a * DEG) / 1e5}" for a in range(0, 720, 2)
    ]
    path = tmp_path / "gas.csv"
    path.write_text("\n".join(lines))
    return path


@pytest.mark.parametrize(
    "change, message",
    [
        (lambda lines: lines[:200], "csv: expected a cycle of 720 deg, got 396"),
        (
            lambda lines: [*lines[:50], lines[48], *lines[50:]],
            "51: expected crank angle above 96, got 94",
        ),
        (lambda lines: ["0, x", *lines], "line 1: expected numbers, got 'x'"),
        (lambda lines: [*lines, "720, 3"], r"csv: expected pressure 1e\+06 Pa at the end"),
        (
            lambda lines: [*lines[:9], "16, abc", *lines[10:]],
            "10: expected numbers, got 'abc'",
        ),
        (
            lambda lines: [*lines[:9], "16, nan", *lines[10:]],
            "10: expected numbers, got 'nan'",
        ),
        (
            lambda lines: [*lines[:9], "16, 3, 4", *lines[10:]],
            "10: expected two numbers, crank angle and",
        ),
    ],
)
def test_bad_gas_tables_name_the_row(gas_file, change, message):
    gas_file.write_text("\n".join(change(gas_file.read_text().splitlines())))
    with pytest.raises(TableFault, match=message):
        gas_table(read_numbers(gas_file), 4 * np.pi, DEG, 1e5)


BAD_PROFILES = {
    "h,0,120,240\n0,1,2,3\n1,1,2,3\n2,2,3": "4: expected 4 numbers, a height and 3 values, got 3",
    "h,0,120,240\n0,1,2,3\n1,1,2,3\n1,1,2,3": "4: expected a height above 1, got 1",
    "h,0,240,120\n0,1,2,3": "1: expected an angle above 240, got 120",
    "h,0,360,720\n0,1,2,3": "below a full revolution, got 720 deg; remove a repeated angle",
    "h,0,120,240\n0,1,n/a,3": "2: expected numbers, got 'n/a'",
}
"""Texts of profiles, and a part of the fault."""


def test_bad_profiles_name_the_row(tmp_path):
    path = tmp_path / "skirt.csv"
    path.write_text("h,0,5,10,15\n0,1,1,1,1")
    with pytest.raises(TableFault, match="csv: expected gaps near 5 deg between"):
        profile_table(path, DEG, 1e-3, 1e-6)
    for text, message in BAD_PROFILES.items():
        path.write_text(text)
        with pytest.raises(TableFault, match=message):
            profile_table(path, DEG, 1e-3, 1e-6)


def test_a_profile_from_the_top_to_the_bottom(tmp_path):
    path = tmp_path / "skirt.csv"
    path.write_text("Skirt of today\nh,0,120,240\n2,1,2,3\n-1,4,5,6")
    table = profile_table(path, DEG, 1.0, 1.0)
    assert table.height.tolist() == [-1, 2] and table.value.tolist() == [[4, 5, 6], [1, 2, 3]]


def test_tables_in_the_case_name_their_rows():
    with pytest.raises(TableFault, match="3: expected crank angle above 2, got 1"):
        gas_table(inline_numbers("gas.points", [(0, 1), (2, 5), (1, 1)]), 4 * np.pi, 1.0, 1.0)


@pytest.mark.parametrize(
    "over, points, message",
    [
        ("time", [(0, 10), (1, -1)], "2: expected a crank speed of at least 0"),
        ("time", [(0, 10)], "1: expected at least two rows over time, got one"),
        ("angle", [(0, 10), (6, 0)], "2: expected a crank speed above 0 rad/s,"),
        (
            "angle",
            [(0, 10), (2 * np.pi, 11)],
            "speed: expected speed 10 rad/s at the end",
        ),
        ("angle", [(0, 10), (1, 10), (3, 10)], "speed: expected a cycle of 360 deg, got"),
    ],
)
def test_bad_speed_tables_name_the_row(over, points, message):
    with pytest.raises(TableFault, match=message):
        speed_table(inline_numbers("speed", points), over, 2 * np.pi, 1.0, 1.0)


@pytest.mark.parametrize(
    "over, points",
    [
        ("time", [(-1, 250), (0.002, 300), (0.005, 280), (0.006, 280)]),
        ("angle", [(-1, 300), (0.5, 310), (2, 290), (4, 290), (2 * np.pi - 1, 300)]),
    ],
)
def test_crank_follows_its_table_however_the_steps_fall(over, points):
    """One step, many steps and the solver of an ordinary differential equation agree.

    The first two agree to round-off.
    """
    table = speed_table(inline_numbers("speed", points), over, 2 * np.pi, 1.0, 1.0)
    at, speed = np.array(points, dtype=float).T

    def w(t, phi):
        return (
            np.interp(t, at, speed)
            if over == "time"
            else np.interp((phi + 1) % (2 * np.pi) - 1, at, speed)
        )

    whole = crank_motion(table, 0.4, 0.0, 0.03)
    angle, time = 0.4, 0.0
    for step in np.full(300, 1e-4):
        angle, time = crank_motion(table, angle, time, step)[0], time + step
    assert angle == pytest.approx(whole[0], rel=1e-13)
    solved = solve_ivp(w, (0.0, 0.03), [0.4], rtol=1e-10, atol=1e-12, max_step=2e-5).y[0, -1]
    assert whole[0] == pytest.approx(solved, rel=1e-7)  # what the solver loses where segments meet
    assert whole[1] == pytest.approx(w(0.03, whole[0]), rel=1e-12)
    ends = [crank_motion(table, 0.4, 0.0, 0.0035 + e) for e in (1e-7, -1e-7)]
    middle = crank_motion(table, 0.4, 0.0, 0.0035)
    assert (ends[0][0] - ends[1][0]) / 2e-7 == pytest.approx(middle[1], rel=1e-6)
    assert (ends[0][1] - ends[1][1]) / 2e-7 == pytest.approx(middle[2], rel=1e-6)


@pytest.fixture(scope="module")
def shaped(coarse, kept):
    """Return a running model of the small bodies with tables.

    They have a measured skirt, a bore that widens downwards and a gas table.
    """
    folder = coarse[0]
    (folder / "skirt.csv").write_text("h,0,90,180,270\n-16,10,0,10,0\n10,10,0,10,0\n")
    (folder / "bore.csv").write_text("h,0\n50,30\n100,5\n155,0\n")
    (folder / "gas.csv").write_text("\n".join(f"{a},{curve(a * DEG)}" for a in range(0, 721, 5)))
    units = {"angle_unit": "1 deg", "height_unit": "1 mm", "value_unit": "1 um"}
    table = coarse[1] | {
        "piston": coarse[1]["piston"] | {"profiles": [{"file": "skirt.csv", **units}]},
        "block": coarse[1]["block"]
        | {
            "profiles": [{"file": "bore.csv", **units}],
            "orders": [{"order": 4, "amplitude": "2 um", "phase": "10 deg"}],
        },
        "gas": {"file": "gas.csv", "angle_unit": "1 deg", "pressure_unit": "1 Pa"},
        "speed": {"points": [[0, 3000], [1, 3600]], "time_unit": "1 ms", "speed_unit": "1 rpm"},
    }
    options, files = prepare(table, folder, lambda text: None)
    piston, block = load(ReducedPiston, files[0]), load(ReducedBlock, files[1])
    parameters = Parameters(skirt_growth_upper=4e-6, bore_growth_lower=3e-6)
    return assemble(piston, block, BuildOptions.from_json(options), parameters)


def test_shapes_enter_the_film_and_its_work(shaped):
    """A bore of varying width does work on the moving piston: energy is still kept."""
    rng = np.random.default_rng(2)
    push, drag = rng.random((2, *shaped.film_surfaces[0].skirt.gap.shape))
    state, out = shaped.start(0.7, 0.0, 0.0, Inputs(314.0, 0.0, push, drag))
    assert out["interface_work_error"] <= 1e-13
    for _ in range(5):
        state, out = shaped.advance(state, Inputs(314.0, 0.0, push, drag), 5e-5)
        assert out["interface_work_error"] <= 1e-13


def test_speed_table_takes_the_place_of_the_input(shaped):
    nothing = np.zeros(shaped.film_surfaces[0].skirt.gap.shape)
    state, _ = shaped.start(0.2, 0.0, 0.0, Inputs(77.0, 0.0, nothing, nothing))
    for _ in range(20):
        state, out = shaped.advance(state, Inputs(77.0, 0.0, nothing, nothing), 1e-4)
    # 1 ms from 50 to 60 turns a second, then 1 ms at 60
    assert out["crank_angle"] == pytest.approx(0.2 + 2 * np.pi * (55e-3 + 60e-3), rel=1e-13)
    assert out["rotation_speed"] == pytest.approx(120 * np.pi) and state.crank_acceleration == 0.0


def test_gas_table_acts_like_the_input(shaped, monkeypatch):
    nothing = np.zeros(shaped.film_surfaces[0].skirt.gap.shape)
    tabled = [
        shaped.start(angle, 0.0, 0.0, Inputs(314.0, 0.0, nothing, nothing))[0]
        for angle in (0.5, 3.0)
    ]
    by_input = shaped.model.settings._replace(gas_source=GAS.input)
    monkeypatch.setattr(shaped, "model", shaped.model._replace(settings=by_input))
    for state, angle in zip(tabled, (0.5, 3.0)):
        given = shaped.start(angle, 0.0, 0.0, Inputs(314.0, curve(angle), nothing, nothing))[0]
        np.testing.assert_allclose(
            state.acceleration, given.acceleration, rtol=2e-3
        )  # linear between 5 deg


def test_missing_and_bad_tables_are_reported_together(coarse):
    folder, options = coarse
    units = {"angle_unit": "1 deg", "height_unit": "1 mm", "value_unit": "1 um"}
    (folder / "bad.csv").write_text("h,90\n1,2\n3\n")
    table = options | {
        "piston": options["piston"] | {"profiles": [{"file": "none.csv", **units}]},
        "gas": {"file": "gone.csv", "angle_unit": "1 deg", "pressure_unit": "1 bar"},
    }
    with pytest.raises(BadInput) as caught:
        prepare(table, folder, print)
    assert len(caught.value.faults) == 2
    with pytest.raises(BadInput, match="bad.csv, line 3"):
        prepare(
            options | {"block": options["block"] | {"profiles": [{"file": "bad.csv", **units}]}},
            folder,
            print,
        )


def test_gas_repeats_every_cycle(gas_file):
    table = gas_table(read_numbers(gas_file), 4 * np.pi, DEG, 1e5)
    for angle in (0.1, 5.0, 12.5, 12.5 + 4 * np.pi, 0.1 - 4 * np.pi):
        # linear between points 2 deg apart: (1 deg)^2/2 * 5e5/4
        assert gas_pressure(table, angle) == pytest.approx(curve(angle), abs=20)


def test_gas_of_a_two_stroke_repeats_every_revolution(coarse):
    folder, options = coarse
    points = [(0, 1.0), (120, 5.0), (240, 3.0)]
    gas = {"points": points, "angle_unit": "deg", "pressure_unit": "bar", "strokes": 2}
    table = read_tables(read_options(options | {"gas": gas}, folder)).gas
    for angle, pressure in points:
        assert gas_pressure(table, (360 + angle) * DEG) == pytest.approx(1e5 * pressure)


def test_units_in_the_header_of_a_table_agree_with_its_keys(coarse, gas_file):
    folder, options = coarse
    rows = gas_file.read_text().splitlines()[1:]
    gas = {"file": str(gas_file), "angle_unit": "1 deg", "pressure_unit": "1.1 bar"}

    def read(head):
        gas_file.write_text("\n".join([head, *rows]))
        return read_tables(read_options(options | {"gas": gas}, folder)).gas

    for head in ("angle [deg],gauge pressure [bar]", "angle,p [bar gauge]", "phi,[p]"):
        assert read(head).pressure.max() > 1e5
    for head, message in (
        (
            "angle [deg],p [MPa]",
            "pressure_unit near '1 MPa' as in the header, got '0.11 M",
        ),
        (
            "angle [rad],p [bar]",
            "angle_unit near '1 rad' as in the header, got '0.0175 ",
        ),
    ):
        with pytest.raises(BadInput, match=message):
            read(head)


@pytest.mark.parametrize("first", [0.0, 7.0])
def test_a_coarse_table_is_as_good_as_a_dense_one(first):
    """180 um of ovality by 24 angles and 20 um of barrel by 9 heights give an error of 0.01 um.

    This is the fourth derivative of 720 um / 384 x (15 deg)^4. Straight lines between the angles
    had an error of 1.5 um.
    """
    angle = np.radians(first + np.arange(0.0, 360.0, 15.0))
    height = np.linspace(-14e-3, 13e-3, 9)
    barrel = 20e-6 * (height / 13.5e-3) ** 2
    table = MeasuredShape(angle, height, barrel[:, None] + 90e-6 * np.cos(angle) ** 2)
    at, rows = np.linspace(-1.0, 7.0, 97), np.linspace(-13.9e-3, 12.9e-3, 31)
    wanted = 90e-6 * np.cos(at)[:, None] ** 2 + 20e-6 * (rows / 13.5e-3) ** 2
    np.testing.assert_allclose(table_shape(table, at, rows), wanted, atol=1e-8)
    turned = table_shape(table, at + 2.0 * np.pi, rows)
    np.testing.assert_allclose(turned, table_shape(table, at, rows), atol=1e-18)


def test_profile_file_and_interpolation(tmp_path):
    path = tmp_path / "skirt.csv"
    angles, heights = np.arange(0, 360, 5), np.linspace(-16, 8, 25)
    rows = ["height," + ",".join(str(a) for a in angles)]
    rows += [
        f"{h}," + ",".join(str(100 * np.cos(a * DEG) ** 2 + h) for a in angles) for h in heights
    ]
    path.write_text("\n".join(rows))
    table = profile_table(path, DEG, 1e-3, 1e-6)
    angle, height = np.linspace(0.01, 6.27, 33), np.linspace(-15e-3, 7e-3, 9)
    wanted = (100 * np.cos(angle) ** 2)[:, None] * 1e-6 + height * 1e-3
    # cubic over 5 deg: (5 deg)^4 / 384 * 800 um, and straight in height
    np.testing.assert_allclose(table_shape(table, angle, height), wanted, atol=2e-10)


def test_orders():
    angle = np.linspace(0, 6, 50)
    terms = [BoreOrder(0, 25e-6, 0.0), BoreOrder(2, 25e-6, 0.0)]
    np.testing.assert_allclose(fourier_bore(terms, angle), ovality(angle, 100e-6), atol=1e-18)
