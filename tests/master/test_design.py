"""Sensitivities and optimisation against closed forms, with runs that are formulas."""

import csv
import signal
import subprocess
import sys
from concurrent.futures import Executor, Future
from pathlib import Path

import numpy as np
import pytest

import piston_cosim as pc
from piston_cosim.fmu_mfbd.dynamics.tables import profile_table
from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.fmi.cache import cache_folder, passing_fmus
from piston_cosim.master.fmi.errors import BadInput, Stopped
from piston_cosim.master.fmi.quantities import to_si
from piston_cosim.master.results.compare import Measured, deviations, have_bands, outside_text
from piston_cosim.master.results.recorded import Series
from piston_cosim.master.runs import sweep as sweeps
from piston_cosim.master.runs.calibration import calibrate
from piston_cosim.master.runs.design_space import (
    ANGLES,
    DesignSpace,
    number_of,
    range_of,
    shapes_of,
    start_of,
)
from piston_cosim.master.runs.optimisation import (
    FAILED_OBJECTIVE,
    Limit,
    Search,
    Task,
    differences,
    limit_of,
    optimise,
)
from piston_cosim.master.runs.sensitivities import Runs, map_of, sensitivities, use_of
from tests.command import call

PATH = find_case("numerical_example")
TREE = read_tree(PATH)
RANGES = [range_of(TREE, "radial_clearance=8um..14um", PATH.parent, "--vary")]
FRICTION, FILM = "mean_friction_power_w", "minimum_film_thickness_m"


def clearance_and_viscosity(tree):
    """Return both as numbers in um and mPa s."""
    bodies, film = (tree["participants"][name]["parameters"] for name in ("bodies", "ehd"))
    return tuple(float(text.split()[0]) for text in (bodies["radial_clearance"], film["viscosity"]))


class Formulas(Executor):
    """Executor whose runs are formulas of the resolved case; it fails above `highest` um."""

    def __init__(self, highest=np.inf, **formulas):
        self.formulas, self.highest, self.count = formulas, highest, 0

    def submit(self, fn, tree, *others):
        self.count += 1
        future, (clearance, viscosity) = Future(), clearance_and_viscosity(tree)
        row = {"status": "done", "message": ""}
        if clearance > self.highest:
            row = {"status": "failed", "message": "no step"}
        else:
            row |= {name: float(f(clearance, viscosity)) for name, f in self.formulas.items()}
            Path(others[1]).touch()  # the results file
        future.set_result(row)
        return future


@pytest.fixture
def runs(monkeypatch, tmp_path):
    """Maker of `Runs` of two numbers without FMUs."""
    monkeypatch.setattr(sweeps, "build_all", lambda *arguments: None)

    def made(executor, space, folder="a"):
        return Runs(TREE, PATH, space, tmp_path / folder, executor)

    return made


def numbers(*texts):
    return tuple(number_of(TREE, text, PATH.parent, "--by") for text in texts)


def test_change_and_spread_of_a_quadratic_are_those_by_hand(runs):
    # 10 um, 6 mPa s: f = c^2 has 9^2, 10^2, 11^2, so change 20 and spread 1; g = 3 v by 0.12 mPa s
    executor = Formulas(**{FRICTION: lambda c, v: c * c, FILM: lambda c, v: 3.0 * v})
    space = DesignSpace(numbers("radial_clearance=1um", "viscosity"))
    known, failed = sensitivities(runs(executor, space), [FRICTION, FILM])
    shown = {(one.variable, one.figure): (one.change, one.spread) for one in known}
    assert shown["radial_clearance", FRICTION] == pytest.approx((20.0, 1.0), abs=1e-12)
    assert shown["viscosity", FILM] == pytest.approx((0.36, 0.0), abs=1e-12)  # 2 % of 6, times 3
    assert shown["viscosity", FRICTION] == (0.0, 0.0) and not failed
    assert [one.is_resolved for one in known] == [True, False, False, True]
    assert [one.step_text for one in space.numbers] == ["+1um", "+0.12 mPa s"]
    before = executor.count  # finished runs are reused
    sensitivities(runs(executor, space), [FRICTION])
    assert executor.count == before


def test_a_variable_whose_run_fails_has_no_sensitivity(runs):
    executor = Formulas(10.5, **{FRICTION: lambda c, v: c + v})
    space = DesignSpace(numbers("radial_clearance=1um", "viscosity"))
    known, failed = sensitivities(runs(executor, space), [FRICTION])
    assert [one.variable for one in known] == ["viscosity"] and failed[0]["message"] == "no step"
    with pytest.raises(BadInput, match="the case itself: no step"):
        sensitivities(runs(Formulas(9.0), space, "b"), [FRICTION])


def test_the_optimum_is_the_constrained_one_with_its_multiplier(runs):
    # least f = 200 + (c - 14)^2 + (v - 5)^2 with c <= 11.5: c = 11.5, v = 5. Multiplier of the
    # relative limit: -df/dc 11.5 / f(10, 6) = 5 11.5 / 217
    executor = Formulas(
        **{FRICTION: lambda c, v: 200 + (c - 14) ** 2 + (v - 5) ** 2, FILM: lambda c, v: c}
    )
    texts = "radial_clearance=8um..13um", "viscosity=4 mPa s..8 mPa s"
    ranges = [range_of(TREE, text, PATH.parent, "--vary") for text in texts]
    space = DesignSpace(tuple(number for number, *_ in ranges))
    bounds = tuple((low, high) for _, low, high in ranges)
    task = Task(FRICTION, 1.0, (Limit(FILM, 1.0, 11.5),), ([],), bounds)
    best = optimise(Search(task, runs(executor, space)))
    clearance, viscosity = (n.value + x * n.scale for n, x in zip(space.numbers, best.shares))
    # forward differences over 0.05 shares of 2.5 um and 2 mPa s shift v by half of 0.1 mPa s
    assert clearance == pytest.approx(11.5, rel=2e-3)
    assert viscosity == pytest.approx(5.0, abs=0.06)
    assert best.after == pytest.approx((200 + 2.5**2) / 217, rel=2e-4)
    (active,) = best.active
    assert active.limit.figure == FILM
    assert active.multiplier == pytest.approx(5 * 11.5 / 217, rel=0.03)  # of the same difference


def test_a_search_from_another_start_finds_another_minimum_and_compares_with_the_case(runs):
    # f = (c - 10)^2 (c - 13)^2 + 100 - c has a minimum on each side of c = 11.5
    executor = Formulas(**{FRICTION: lambda c, v: 100.0 - c + ((c - 10) * (c - 13)) ** 2})
    number, *bounds = RANGES[0]
    assert start_of(RANGES, []).tolist() == [0.0]
    start = tuple(start_of(RANGES, ["radial_clearance = 0.0125 mm"]))
    assert start == pytest.approx((2.5 / 3.0,))
    ends = []
    for first in ((), start):
        task = Task(FRICTION, 1.0, (), ([],), (tuple(bounds),), start=first)
        best = optimise(Search(task, runs(executor, DesignSpace((number,)), str(len(first)))))
        assert best.before == 1.0 and best.history[0].shares.tolist() == [0.0]
        ends.append(number.value + best.shares[0] * number.scale)
    # 1 = 2 (c - 10)(c - 13)(2 c - 23) next to 10 and 13, less half of the difference of 0.15 um
    assert ends == pytest.approx([10.06, 13.05], abs=0.09)


def test_limits_of_the_case_hold_at_each_point_and_failed_designs_are_bad(runs):
    # more film: f = c; at most as much friction as in the case: v c <= 60, 5 c at the second point
    executor = Formulas(12.0, **{FILM: lambda c, v: c, FRICTION: lambda c, v: v * c})
    ranges = [range_of(TREE, "radial_clearance=9um..14um", PATH.parent, "--vary")]
    points = ([], [("participants.ehd.parameters.viscosity", "5 mPa s")])
    limits = Limit(FRICTION, 1.0), Limit(FRICTION, 1.0, 52.0)
    task = Task(FILM, -1.0, limits, points, (ranges[0][1:],))
    search = Search(task, runs(executor, DesignSpace((ranges[0][0],))))
    best = optimise(search)
    # no design has 52 W: at 9 um it is 54 W, which is closest
    assert best.shares == pytest.approx([-0.4]) and best.after == pytest.approx(-0.9)
    # g of both limits at both points, 10 % above the case: 60, 50 W become 66, 55 W
    value, *slack = search.at(np.array([1.0 / 2.5]))
    assert value == pytest.approx(-1.1)
    assert slack == pytest.approx([-0.1, -0.1, (52 - 66) / 52, (52 - 55) / 52])
    assert search.at(np.array([1.0]))[0] == FAILED_OBJECTIVE


def test_differences_stay_within_bounds_and_omit_failed_runs():
    # f = x0^2 and 3 x1; at the upper end of x0 the step is down, and the run of x2 fails
    def values(designs):
        return [np.array([x[0] ** 2, 3.0 * x[1]]) if x[2] == 0.0 else None for x in designs]

    x = np.array([1.0, 0.0, 0.0])
    slopes = differences(values, x, np.array([1.0, 0.0]), [(-1.0, 1.0)] * 3)
    assert slopes == pytest.approx(np.array([[1.95, 0.0, 0.0], [0.0, 3.0, 0.0]]))


def test_shapes_keep_the_mean_are_symmetric_and_survive_their_table(tmp_path):
    case = check_case(TREE, PATH)
    shapes = shapes_of(case, TREE, "5x3", "4 um", tmp_path)
    assert len(shapes.names) == 14 and np.linalg.matrix_rank(shapes.values.reshape(14, -1)) == 14
    assert np.abs(shapes.values.mean(axis=(1, 2))).max() < 1e-15
    mirrored = [np.flatnonzero((180.0 - angle) % 360.0 == ANGLES)[0] for angle in ANGLES]
    assert np.abs(shapes.values - shapes.values[:, :, mirrored]).max() < 1e-14
    assert (1e3 * shapes.heights[[0, -1]]).tolist() == [-16.0, 11.0]
    rng = np.random.default_rng(3)
    shares = rng.uniform(-1.0, 1.0, 14)
    ((key, (table,)),) = shapes.changes(shares)
    assert key == "participants.bodies.build.piston.profiles" and shapes.changes(0 * shares) == []
    read = profile_table(table["file"], np.pi / 180, 1e-3, 1e-6)
    # the table has 1e-5 um
    assert np.abs(read.value - shapes.profile(shares)).max() < 6e-12
    slopes = rng.standard_normal(14)
    product = (map_of(shapes, slopes) * shapes.values).mean(axis=(1, 2))
    assert product == pytest.approx(slopes)


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda: numbers("clearence"), "--by clearence: expected a key"),
        (lambda: numbers("radial_clearance=1 s"), "radial_clearance: expected a quantity in um"),
        (lambda: numbers("crank_offset"), "crank_offset: expected a step, because the value is z"),
        (lambda: numbers("radial_clearance=0 um"), "radial_clearance: expected a step, got 0 um"),
        (lambda: numbers("package"), "expected a dotted path"),
        (lambda: numbers("coupling.method"), "expected a key whose value is a number"),
        (lambda: numbers("max_iterations=5"), "coupling.max_iterations: .* whole number, got 20"),
        (lambda: numbers("participants.ehd.build.grid.0"), "grid.0: expected a key in an entry"),
        (
            lambda: range_of(TREE, "piston.modes=5..90", PATH.parent, "--vary"),
            "participants.bodies.build.piston.modes: expected a key that is not a whole number",
        ),
        (
            lambda: range_of(TREE, "radial_clearance=11um..12um", PATH.parent, "--vary"),
            "expected a range that contains 10.* um",
        ),
        (
            lambda: range_of(TREE, "radial_clearance=12um..9um", PATH.parent, "--vary"),
            "expected LOW below HIGH, got 12um..9um",
        ),
        (lambda: range_of(TREE, "viscosity=3", PATH.parent, "--vary"), "expected KEY=LOW..HIGH"),
        (
            lambda: start_of(RANGES, ["viscosity=5 mPa s"]),
            "--start viscosity: expected a number of",
        ),
        (lambda: start_of(RANGES, ["radial_clearance=9"]), "--start radial_clearance: .* in um"),
        (lambda: start_of(RANGES, ["radial_clearance=15um"]), "the range of --vary, got 15um"),
        (lambda: shapes_of(check_case(TREE, PATH), TREE, "3x1", "1 um", PATH), "4x1 to 12x8"),
        (lambda: limit_of("film", {FILM: "raise"}), "unknown figure 'film'"),
        (lambda: limit_of(f"{FILM}<=1 s", {FILM: "raise"}), "expected a quantity in m"),
        (lambda: limit_of("x", {"x": "none"}), "expected FIGURE<=VALUE"),
        (lambda: limit_of(f"{FILM}<1 um", {FILM: "raise"}), "expected FIGURE, FIGURE<=VALUE or F"),
        (lambda: numbers("radial_clearance+pin_offset"), "keys of one value, got 10 um and 0"),
        (lambda: numbers("radial_clearance+viscosity"), "keys of one value, got 10 um and 6 mPa s"),
        (lambda: numbers("crank_speed=5 Hz"), "expected a quantity in rpm"),
        (lambda: numbers("crank_speed=5"), "expected a quantity in rpm"),
        (
            lambda: DesignSpace(numbers("viscosity", "ehd.viscosity=1 mPa s")),
            "viscosity: expected the key in one variable",
        ),
    ],
)
def test_wrong_input_is_named(ask, message):
    with pytest.raises(BadInput, match=message):
        ask()


def test_limits_have_signs_and_units():
    ways = {FILM: "raise", "maximum_pressure_pa": "lower"}
    assert limit_of(FILM, ways) == Limit(FILM, -1.0)
    assert limit_of("maximum_pressure_pa <= 4 MPa", ways) == Limit("maximum_pressure_pa", 1.0, 4e6)
    assert limit_of(f"{FILM}>=3um", ways) == Limit(FILM, -1.0, pytest.approx(3e-6))
    ways = {"oil_flow_m3_s": "none", "mount_moment_nm": "none", "contact_share": "none"}
    for text, value in (
        ("oil_flow_m3_s<=6 l/min", 1e-4),
        ("mount_moment_nm<=2 kN.m", 2e3),
        ("contact_share<=1 %", 0.01),
    ):
        assert limit_of(text, ways).value == pytest.approx(value)


@pytest.mark.parametrize("step", ["5 K", "5 degC", "9 degF"])
def test_steps_of_temperatures_are_differences(step):
    key = "participants.ehd.parameters.oil_temperature_lower_edge"
    tree = read_tree(PATH, [(key, "133 degC")])
    number = number_of(tree, f"{key}={step}", PATH.parent, "--by")
    assert number.scale == pytest.approx(5.0)
    ((_, text),) = number.changes(1.0)
    assert to_si(text, "K") == pytest.approx(138.0 + 273.15)


def test_a_goal_or_limit_that_the_case_lacks_is_named(runs):
    number, *bounds = range_of(TREE, "radial_clearance=8um..13um", PATH.parent, "--vary")
    space = DesignSpace((number,))

    def search(goal, limit, folder):
        task = Task(goal, 1.0, (Limit(limit, 1.0),), ([],), (tuple(bounds),))
        executor = Formulas(**{FRICTION: lambda c, v: c, FILM: lambda c, v: 0.0})
        return Search(task, runs(executor, space, folder))

    for goal, limit in ((FRICTION, "contact_share"), ("contact_share", FRICTION)):
        with pytest.raises(BadInput, match="contact_share: expected a figure of this case"):
            optimise(search(goal, limit, "a"))
    with pytest.raises(BadInput, match=f"{FILM}: expected a goal that is not 0"):
        optimise(search(FILM, FRICTION, "b"))
    assert optimise(search(FRICTION, FILM, "c")).after == pytest.approx(0.8)  # 0 <= 0 holds


def test_without_a_design_that_keeps_the_limits_the_closest_one_is_the_result(runs):
    executor = Formulas(**{FRICTION: lambda c, v: 100.0 - c, FILM: lambda c, v: c})
    number, *bounds = range_of(TREE, "radial_clearance=8um..13um", PATH.parent, "--vary")
    task = Task(FRICTION, 1.0, (Limit(FILM, 1.0, 4.0),), ([],), (tuple(bounds),))
    best = optimise(Search(task, runs(executor, DesignSpace((number,)))))
    assert number.value + best.shares[0] * number.scale == pytest.approx(8.0)
    assert best.slack == pytest.approx(-1.0)


def test_a_finished_run_without_its_results_file_is_repeated(runs):
    executor = Formulas(**{FRICTION: lambda c, v: c})
    made = runs(executor, DesignSpace(numbers("viscosity")))
    (row,) = made.rows([np.zeros(1)])
    made.rows([np.zeros(1)])
    assert executor.count == 1
    row["results"].unlink()
    made.rows([np.zeros(1)])
    assert executor.count == 2 and row["results"].exists()


def test_a_folder_of_designs_has_one_user_and_keeps_other_files(tmp_path):
    (tmp_path / "cache").mkdir()
    with use_of(tmp_path), pytest.raises(BadInput, match="written by process"):
        with use_of(tmp_path):
            pass
    assert [one.name for one in tmp_path.iterdir()] == ["cache"]


def test_fmus_of_designs_do_not_remain_in_the_cache(tmp_path):
    (cache_folder("code") / "x").touch()
    before = cache_folder("fmus")
    with passing_fmus(tmp_path / "cache"):
        assert cache_folder("fmus").parent == tmp_path / "cache"
        assert (cache_folder("code") / "x").exists()
    assert cache_folder("fmus") == before and not (tmp_path / "cache").exists()
    assert (cache_folder("code") / "x").exists()


def test_fmus_of_a_killed_process_do_not_remain(tmp_path):
    code = (
        "import os, signal, sys\nfrom pathlib import Path\n"
        "from piston_cosim.master.fmi.cache import passing_fmus\n"
        "with passing_fmus(Path(sys.argv[1])):\n    os.kill(os.getpid(), signal.SIGKILL)"
    )
    folder = tmp_path / "a folder"
    # the shell that deletes the folder has the same pipe, which ends with the last of both
    done = subprocess.run([sys.executable, "-c", code, folder], stdout=subprocess.PIPE)
    assert done.returncode == -signal.SIGKILL
    assert not folder.exists()


def test_a_linear_system_has_the_sensitivity_by_proportion(tmp_path):
    """The displacements of two masses on springs are proportional to the one at the start."""
    step = "0.1 m"
    words = ["--by", f"start_displacement={step}", "--set", "time.stop=0.1 s", "--workers", "1"]
    case = "two_mass_oscillator"
    done = call("sensitivities", case, *words, "--output", tmp_path / "a", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    with open(tmp_path / "a" / "sensitivities.csv") as file:
        rows = list(csv.DictReader(file))
    assert [row["step"] for row in rows] == ["+0.1 m"] * 2
    for row in rows:
        value, change, spread = (float(row[key]) for key in ("value", "change", "spread"))
        # the tolerance of the wires is 1e-12 m
        assert change == pytest.approx(0.1 * value, abs=1e-11) and spread < 1e-11
    assert (tmp_path / "a" / "sensitivities.png").is_file()
    known = pc.sensitivities(
        pc.open_case(case, {"time.stop": "0.1 s"}),
        {"participants.left.parameters.start_displacement": step},
        tmp_path / "a",
        workers=1,
    )
    assert [one.figure for one in known] == [row["figure"] for row in rows]
    assert [one.change for one in known] == [float(row["change"]) for row in rows]


PLACES = np.linspace(0.0, 3.0, 40)
BOX = [(-1.0, 1.0)] * 2


def measured_by(truth, noise, curve):
    """Return the residuals of designs against a curve with normal noise, over its deviation."""
    values = curve(truth) + noise
    return lambda designs: [(curve(x) - values) / 0.05 for x in designs]


def bent(x):
    """Return a curve of two parameters, not linear in the first."""
    return np.exp(0.5 * x[0]) * np.sin(PLACES) + x[1] * np.cos(PLACES)


def test_intervals_cover_the_truth_of_synthetic_measurements():
    rng = np.random.default_rng(11)
    covered = 0
    for _ in range(20):
        truth = rng.uniform(-0.8, 0.8, 2)
        noise = 0.05 * rng.standard_normal(PLACES.size)
        fit = calibrate(measured_by(truth, noise, bent), BOX, True)
        covered += int((np.abs(fit.shares - truth) <= fit.half_widths).sum())
        assert fit.after < 1.4 and not fit.alike  # 1 + 2.8 / sqrt(2 38)
    assert covered >= 36  # 38 of 40 expected; 36 is one standard deviation and a half below


def test_the_interval_is_that_of_linear_regression():
    rng = np.random.default_rng(5)
    columns = np.array([PLACES, np.ones(PLACES.size)]).T
    noise = 0.05 * rng.standard_normal(PLACES.size)
    truth = np.array([0.3, -0.2])
    fit = calibrate(measured_by(truth, noise, lambda x: columns @ x), BOX, False)
    right, (squares,), *_ = np.linalg.lstsq(columns, columns @ truth + noise, rcond=None)
    variance = squares / (PLACES.size - 2) * np.linalg.inv(columns.T @ columns)
    assert fit.shares == pytest.approx(right, abs=1e-4)  # the search ends there
    # 2.0244: quantile of Student for 38 degrees of freedom
    assert fit.half_widths == pytest.approx(2.0244 * np.sqrt(np.diag(variance)), rel=1e-4)


def test_parameters_that_act_alike_are_named():
    noise = 0.05 * np.random.default_rng(2).standard_normal(PLACES.size)
    nearly = calibrate(
        measured_by(
            np.zeros(2), noise, lambda x: x[0] * PLACES + x[1] * (PLACES + 0.1 * PLACES**2)
        ),
        BOX,
        True,
    )
    assert [pair[:2] for pair in nearly.alike] == [(0, 1)] and nearly.alike[0][2] < -0.95
    same = calibrate(measured_by(np.zeros(2), noise, lambda x: (x[0] + x[1]) * PLACES), BOX, True)
    assert np.isinf(same.half_widths).all()
    with pytest.raises(BadInput, match="more than 2 values within the run, got 1"):
        calibrate(lambda designs: [np.zeros(1)], BOX, True)


class Recorded:
    """Results of a run whose curve is twice its abscissa."""

    ports = ("a.angle", "a.height", "a.fall")

    def series(self, port):
        x = np.radians(np.linspace(0.0, 90.0, 10))
        if port == "a.angle":
            return Series(x, "rad", "")
        if port == "a.fall":
            return Series(-x, "m", "")
        return Series(2e-3 * np.degrees(x), "m", "")


def test_deviations_are_in_quarters_of_the_band():
    # at 45 and 90 deg the run has 90 and 180 mm; 400 deg is outside of it
    angle, height = np.array([45.0, 90.0, 400.0]), np.array([88.0, 190.0, 0.0])
    columns = {"a.angle": Measured(angle, "deg"), "a.height": Measured(height, "mm")}
    assert deviations(Recorded(), columns) == pytest.approx([2.0 / 190.0, -10.0 / 190.0])
    text = "warning: 1 of 3 measured values are outside the run, 0 to 90 deg, and are ignored"
    assert outside_text(Recorded(), columns) == text
    within = {"a.angle": Measured(np.array([-0.01, 90.05]), "deg")}  # a digit of the file
    assert outside_text(Recorded(), within) == ""
    banded = Measured(height, "mm", height - 4.0, height + 4.0)
    assert deviations(Recorded(), columns | {"a.height": banded}) == pytest.approx([1.0, -5.0])
    narrow = Measured(height, "mm", height, height)
    with pytest.raises(BadInput, match="a.height: expected a band wider than 0"):
        deviations(Recorded(), columns | {"a.height": narrow})


def test_only_some_curves_with_a_band_are_rejected():
    x = np.ones(3)
    bare, banded = Measured(x, "mm"), Measured(x, "mm", x - 1.0, x + 1.0)
    assert have_bands({"a.angle": bare, "a.height": banded, "a.fall": banded})
    assert not have_bands({"a.angle": bare, "a.height": bare, "a.fall": bare})
    with pytest.raises(BadInput, match="measured a.fall: expected a band, as other curves"):
        have_bands({"a.angle": bare, "a.height": banded, "a.fall": bare})


def test_an_abscissa_that_falls_in_the_run_is_refused():
    columns = {"a.fall": Measured(np.ones(1), "m"), "a.height": Measured(np.ones(1), "m")}
    with pytest.raises(BadInput, match="a.fall: expected a first column that rises in the run"):
        deviations(Recorded(), columns)


def test_a_run_that_fails_in_a_calibration_is_named():
    with pytest.raises(BadInput, match="the case itself: its run fails"):
        calibrate(lambda designs: [None], BOX, True)
    with pytest.raises(Stopped, match=r"a run fails at the shares \[0.05, 0.0\] of the ranges"):
        calibrate(lambda designs: [None if x.any() else np.ones(3) for x in designs], BOX, True)


def test_runs_that_cover_other_numbers_of_values_are_refused():
    sizes = iter([5, 5, 4])
    with pytest.raises(BadInput, match="got 5 within the case and 4 within another run"):
        calibrate(lambda designs: [np.ones(next(sizes)) for _ in designs], [(-1.0, 1.0)], True)
