"""Values computed from results files, and the conversion of units.

Each option has one number by hand.
"""

import io

import numpy as np
import pytest
from rich.console import Console

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.times import times
from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.master.fmi.quantities import (
    base_unit,
    from_si,
    registry,
    short,
    to_si,
    worth,
)
from piston_cosim.master.results.compare import (
    Measured,
    agreement,
    score,
)
from piston_cosim.master.results.instants import instant
from piston_cosim.master.results.judgement import (
    Window,
    windows,
)
from piston_cosim.master.runs.sweep import Axis, Point, parse_axis
from piston_cosim.tests.verification.cases import rows
from piston_cosim.tests.verification.cases.checks import Check

from .by_hand import InMemory, write_results

TREE = {
    "title": "Four strokes",
    "time": {"stop": "720 deg", "step": "1 deg", "angular_speed": "a.speed"},
    "participants": {"a": {"fmu": "a.fmu", "parameters": {"speed": "2 rad/s"}}},
    "wires": [],
    "coupling": {"order": ["a"]},
}
TIME = [0.0, 1.0, 2.0, 3.0, 4.0]
SERIES = {
    "a.x": ([0.0, 3.0, 3.0, 1.0, 1.0], "m"),
    "a.y": ([2.0, 4.0, -1.0, -3.0, 5.0], "N"),
    "a.z": ([1.0, 1.0, 0.0, 0.0, 1.0], "N"),
}


@pytest.fixture
def results(tmp_path):
    """Three series of five rows, by hand."""
    with write_results(tmp_path / "run.h5", TIME, SERIES, title="t", case=TREE) as opened:
        yield opened


def case_with(**tables):
    return check_case(TREE | tables, "case.toml")


@pytest.mark.parametrize("kind, value", [("min", -3.0), ("max", 5.0), ("last", 5.0)])
def test_windows_hold_their_ends(results, kind, value):
    for low, high, inside in ((0, 1, True), (-1, 0, True), (0.1, 1, False), (-1, -0.1, False)):
        limits = [f"{value + low} N", f"{value + high} N"]
        (window,) = windows(case_with(window={f"{kind} a.y": limits}), results)
        assert window == Window(f"{kind} a.y", "N", value, value + low, value + high)
        assert window.inside is inside


def test_windows_are_read_in_their_units(results):
    (window,) = windows(case_with(window={"mean a.y": ["1200 mN", "0.0015 kN"]}), results)
    read = (window.low, window.value, window.high)
    # four steps of 1 s end at 4, -1, -3 and 5 N, as in the summary
    assert read == pytest.approx((1.2, 5 / 4, 1.5), rel=1e-14)
    assert window.inside


@pytest.mark.parametrize(
    "text, time",
    [("max a.y", 4.0), ("min a.y", 3.0), ("max a.x", 1.0), ("min a.z", 2.0), ("1.5 s", 1.5)],
)
def test_instants_by_the_extreme_of_an_output(results, text, time):
    """Of equal values the first."""
    assert instant(results, text) == time


def test_an_instant_of_an_output_that_is_not_there_is_refused(results):
    with pytest.raises(BadInput, match=r"time: expected one of a\.x, a\.y, a\.z, got"):
        instant(results, "max a.xx")
    with pytest.raises(BadInput, match="time: expected a time, a crank angle or"):
        instant(results, "last a.x")


def test_scores_by_hand():
    x = np.array([0.0, 1.0, 2.0, 3.0, 4.0])
    reference = np.array([0.0, 2.0, 4.0, 2.0, 0.0])
    # twice as large: amplitude 2, differences 0, 2, 4, 2, 0: rms sqrt(24 / 5) over a range of 4
    scored = score(x, 2 * reference, x, reference)
    assert scored.amplitude == 2.0
    assert scored.rms == pytest.approx(np.sqrt(24 / 5) / 4, rel=1e-14)
    # the range is that of the reference
    scored = score(x, reference + np.array([0, 0, 4, 0, 0]), x, reference)
    assert (scored.amplitude, scored.rms) == pytest.approx((2.0, np.sqrt(16 / 5) / 4))
    # a reference beyond the curve does not count: of 0..4 only 1..3, range 2, all 1 too high
    scored = score(x[1:4], reference[1:4] + 1.0, x, reference)
    assert (scored.amplitude, scored.rms) == pytest.approx((1.0, 0.5), rel=1e-14)
    # a curve between its points is a line
    scored = score(np.array([0.0, 4.0]), np.array([0.0, 4.0]), x, np.array([0.0, 1, 2, 3, 4]))
    assert (scored.amplitude, scored.rms) == (1.0, 0.0)


@pytest.mark.parametrize("shift", [-0.0313, 0.0, 0.05])
def test_phase_is_positive_for_a_curve_that_comes_later(shift):
    x = np.linspace(0.0, 1.0, 2001)
    # offset and shape alike; linear interpolation and the parabola of the search leave 1e-5
    scored = score(x, 7.0 + np.sin(2 * np.pi * (x - shift)), x, np.sin(2 * np.pi * x))
    assert scored.phase == pytest.approx(shift, abs=1e-5)


def ramp(end):
    """y = t^2 over x = t up to an end, in s and m."""
    t = np.linspace(0.0, end, 101)
    return InMemory(t, {"a.x": (t, "s"), "a.y": (t**2, "m")})


def test_runs_against_measured_values_in_their_own_units():
    # 0, 0.5 and 1 s in ms; 0, 0.25 and 1 m in mm, 10 % too large
    measured = {
        "a.x": Measured(np.array([0.0, 500.0, 1000.0]), "ms"),
        "a.y": Measured(1.1 * np.array([0.0, 250.0, 1000.0]), "mm"),
    }
    ((label, port, scored, share),) = agreement({"run": ramp(1.0)}, measured).rows
    assert (label, port, share) == ("run", "a.y", None)
    assert scored.amplitude == pytest.approx(1 / 1.1, rel=1e-12)
    with pytest.raises(BadInput, match="measured: expected a quantity in m, got '1"):
        agreement({"run": ramp(1.0)}, measured | {"a.y": Measured(np.ones(3), "kg")})


@pytest.mark.parametrize(
    "value, unit, si",
    [
        ("25 um", "m", 25e-6),
        ("3000 rpm", "rad/s", 100 * np.pi),
        ("90 deg", "rad", np.pi / 2),
        ("80 degC", "K", 353.15),
        ("40 mPa*s", "Pa.s", 0.04),
        ("3 kg*cm^2", "kg.m2", 3e-4),
        ("2 m/s^2", "m/s2", 2.0),
        (0.3, "1", 0.3),
    ],
)
def test_units_by_hand(value, unit, si):
    assert to_si(value, unit) == pytest.approx(si, rel=1e-14)


@pytest.mark.parametrize(
    "value, unit",
    [*((value, "m") for value in (True, None, [1.0], "far", 3.0, "25 Pa")), (True, "1")],
)
def test_what_is_no_quantity_is_refused(value, unit):
    with pytest.raises(ValueError):
        to_si(value, unit)


@pytest.mark.parametrize(
    "unit, attributes",
    [
        ("Pa.s", {"kg": "1", "m": "-1", "s": "-1"}),
        ("N.m.s/rad", {"kg": "1", "m": "2", "rad": "-1", "s": "-1"}),
        ("1/K", {"K": "-1"}),
        ("mm", {"factor": "0.001", "m": "1"}),
    ],
)
def test_units_in_base_units(unit, attributes):
    assert base_unit(unit) == attributes


@pytest.mark.parametrize(
    "value, unit, text",
    [
        (5.21e-6, "m", "5.21 µm"),
        (np.pi / 2, "rad", "90.0 deg"),
        (-1e-9, "rad", "0.0 deg"),
        (0.12345, "1", "0.123"),
    ],
)
def test_short_values(value, unit, text):
    assert short(value, unit) == text


def test_angles_become_times_by_the_angular_speed():
    # 720 deg = 4 pi rad at 2 rad/s; without a smallest step it is 1/64 of the step; a revolution
    assert times(case_with(), 2.0) == pytest.approx(
        [0.0, 2 * np.pi, np.pi / 360, np.pi / 360 / 64, np.pi, 2 * np.pi], rel=1e-14
    )
    tree = TREE | {"time": TREE["time"] | {"smallest_step": "0.1 deg"}}
    assert times(check_case(tree, ""), 2.0).smallest_step == pytest.approx(np.pi / 3600, rel=1e-14)


def test_axes_of_a_sweep_by_hand():
    axis = parse_axis("speed=1rad/s..0.003rad/ms:5", TREE)
    assert axis == Axis(
        "speed",
        ("participants.a.parameters.speed",),
        ("1 rad / s", "1.5 rad / s", "2 rad / s", "2.5 rad / s", "3 rad / s"),
    )
    assert parse_axis("coupling.method=newton;explicit", TREE).values == ("newton", "explicit")
    both = parse_axis("coupling.max_iterations+coupling.order=[2,3];3", TREE)
    assert both.keys == ("coupling.max_iterations", "coupling.order") and both.values == ([2, 3], 3)


def test_a_point_is_named_by_what_bears_on_its_run():
    point = Point({}, TREE)
    assert len(point.name) == 16
    assert Point({"any": 1}, TREE | {"title": "Else", "monitor": {"x": "last a.x"}}).name == (
        point.name
    )
    assert Point({}, TREE | {"coupling": {"order": ["a"], "halvings": 5}}).name != point.name


def test_a_page_of_figures_has_a_table_a_part(tmp_path, monkeypatch):
    bad = Check("case b", "y|z [m]", 2.0, None, 1.0, "at most", "round-off", "")
    good = Check("case a", "x [-]", 1.01, 1.0, 0.1, "relative", "by hand", "")
    monkeypatch.setattr(rows, "checks", lambda parts, slow: [("ehd", good), ("mfbd", bad)])
    silent = Console(file=io.StringIO())
    assert rows.verify(["ehd", "mfbd"], False, silent, tmp_path / "figures.md") == 1
    text = (tmp_path / "figures.md").read_text()
    assert "2 figures (ehd 1, mfbd 1), and 1 of them exceed" in text
    assert "## ehd\n\n| case | quantity |" in text
    assert "| case a | x [-] | 1.01 | 1 | 0.01 | 0.1 relative | by hand |\n\n## mfbd" in text
    assert "| case b | y\\|z [m] | 2 |  | 2 | 1 at most | round-off |" in text


def test_products_and_conversions_by_hand():
    assert worth("Pa", "m3") == "energy" and worth("Pa.s", "m3/s2") == "power"
    assert worth("N", "s") not in ("energy", "power")
    assert from_si(0.0254, "m", "in") == pytest.approx(1.0, rel=1e-15)
    with pytest.raises(ValueError, match="m"):
        from_si(1.0, "m", "kg")
    assert to_si("1 in", "m") == pytest.approx(0.0254, rel=1e-15)


def test_definitions_of_units_are_kept_and_damage_heals(tmp_path, monkeypatch):
    """Cached definitions of units give the same bits as pint's own files.

    So do damaged ones, which are rebuilt, and a folder that cannot be written.
    """
    monkeypatch.setenv("PISTON_COSIM_CACHE", str(tmp_path / "cache"))
    made = registry.__wrapped__

    def rpm():
        return made().Quantity("3000 rpm").to("rad/s").magnitude

    first = rpm()
    assert first == pytest.approx(100 * np.pi, rel=1e-15)
    kept = sorted((tmp_path / "cache" / "units").glob("*.pickle"))
    assert kept
    stamps = [path.stat().st_mtime_ns for path in kept]
    assert rpm() == first and [path.stat().st_mtime_ns for path in kept] == stamps
    for path in kept:
        path.write_bytes(path.read_bytes()[:100])
    assert rpm() == first
    assert not any(path.exists() for path in kept)
    assert rpm() == first and all(path.exists() for path in kept)
    (tmp_path / "file").touch()
    monkeypatch.setenv("PISTON_COSIM_CACHE", str(tmp_path / "file"))
    assert rpm() == first


def test_angles_of_the_last_period_go_on_from_the_angle_of_the_start(tmp_path):
    """The last of three periods of 2 s is shown as the first one, from 0.3 rad on."""
    time = np.arange(0.0, 6.5, 0.5)
    series = {"a.angle": (0.3 + np.pi * time, "rad"), "a.x": (time, "m")}
    period = {"length": 2.0, "shown": 1, "turning": ["a.angle"]}
    with write_results(tmp_path / "run.h5", time, series, case=TREE, period=period) as results:
        assert results.time == pytest.approx(time[:5])
        assert results.series("a.angle").values == pytest.approx(0.3 + np.pi * time[:5])
        assert results.series("a.x").values == pytest.approx(time[8:])
