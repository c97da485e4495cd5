"""Uncertainty of figures: values by hand of its parts, its text, and the trees of further runs."""

import json
from contextlib import nullcontext
from types import SimpleNamespace

import numpy as np
import pytest

from piston_cosim.master.case.ahead import faults_ahead
from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.engine.answer import uncertainty_text
from piston_cosim.master.engine.indicator import (
    Course,
    Indicator,
    carrying,
    hardest,
    of_extreme,
    of_work,
    resolution,
    thinned,
)
from piston_cosim.master.engine.measures import Measure, Measures, measures
from piston_cosim.master.engine.uncertainty import (
    DIVERGES,
    Uncertainty,
    at_least,
    combined,
)
from piston_cosim.master.fmi.errors import BadInput, Stopped
from piston_cosim.master.fmi.quantities import numbers_text
from piston_cosim.master.runs import uncertainty as further
from piston_cosim.master.runs.checkpoint import Interrupted
from piston_cosim.master.runs.second_grid import (
    coarser,
    fitting_rows,
    grid_safety,
    kept_films,
    ratio_of,
)

from .by_hand import InMemory


@pytest.mark.parametrize(
    "value, spread, text",
    [
        (2.1678, 0.0812, "2.17 +- 0.08"),
        (2.1678, 0.0354, "2.168 +- 0.035"),
        (2.1678, 0.0356, "2.17 +- 0.04"),
        (217.79, 13.4, "218 +- 13"),
        (4457.1, 152.0, "4460 +- 150"),
        (1.69, 2.81, "1.7 +- 2.8"),
        (0.5, 12.0, "0 +- 12"),
        (-0.001, 0.4, "0.0 +- 0.4"),
        (542.0, 458.0, "540 +- 460"),
        (-0.542, 0.458, "-0.54 +- 0.46"),
        (458.0, 542.0, "500 +- 500"),
        (3.14159, 0.0, "3.14"),
        (1.5, float("nan"), "1.5 +- unknown"),
    ],
)
def test_both_numbers_end_with_the_same_digit(value, spread, text):
    assert numbers_text(value, spread) == text


@pytest.mark.parametrize(
    "value, spread, unit, text",
    [
        (2.17e-6, 8e-8, "m", "2.17 +- 0.08 µm"),
        (1.3e8, 2e7, "Pa", "130 +- 20 MPa"),
        (0.04, 0.0012, "1", "4.00 +- 0.12 %"),
        (4.457e-6, 1.5e-8, "m3", "4457 +- 15 mm³"),
        (np.radians(0.1), np.radians(0.02), "rad", "0.100 +- 0.020 deg"),
        (2.1e-4, 4e-5, "1", "0.021 %"),  # an uncertainty below 0.005 %
        (0.0, None, "1", "0 %"),
    ],
)
def test_units_of_the_text(value, spread, unit, text):
    known = Uncertainty(spread)
    assert Measure("key", "label", value, unit, uncertainty=known).figure == text


def test_a_figure_below_its_uncertainty_has_a_bound_and_a_cause():
    known = combined({"grid": 1.0, "step": 900.0})
    force = Measure("side_force_n", "side force", 400.0, "N", uncertainty=known)
    assert force.figure == "400 +- 900 N (not resolved by the step; at most 1300 N)"
    assert Measure("f", "f", 0.0, "N", uncertainty=known).figure == "0 +- 900 N"


def test_parts_add_as_squares_and_the_largest_is_named():
    found = combined({"grid": 3.0, "step": -4.0})
    assert (found.value, found.contributor, found.reason) == (5.0, "step", "")
    assert combined({}).value is None and combined({}).reason


def test_a_difference_that_vanishes_by_chance_has_a_least_size():
    assert [at_least(-0.5, 2.0), at_least(0.0, 2.0), at_least(-3.0, 2.0)] == [-2.0, 2.0, -3.0]


def test_a_figure_that_diverges_says_so():
    pressure = Measure("maximum_pressure_pa", "maximum pressure", 9.28e7, "Pa")
    assert pressure.figure == "92.8 MPa"
    diverging = Uncertainty(None, "grid", DIVERGES)
    shown = Measure("p", "p", 9.28e7, "Pa", uncertainty=diverging).figure
    assert shown == "92.8 MPa (does not converge with the grid)"


def film_run(gap, pressure, time=(0.0, 1.0), period=0.0, **series):
    """Results of one film on one body, with fields at two instants."""
    participants = {
        "ehd": {"role": "lubrication", "parameters": {"skirt_length": "40 mm"}},
        "bodies": {"role": "bodies"},
    }
    wires = [{"from": "bodies.film_thickness", "to": "ehd.film_thickness"}]
    fields = {
        "bodies.film_thickness": ([np.full_like(gap, 1.0), gap], "m"),
        "ehd.pressure": ([np.zeros_like(pressure), pressure], "Pa"),
    }
    case = {"participants": participants, "wires": wires}
    found = InMemory(list(time), series, fields, case)
    found.period = period
    return found


def test_resolution_by_hand():
    """The film is 1 µm in a cell, 3 µm next to it around and 2 and 4 µm along.

    Its bend is (3 + 3)/2 - 1 + (2 + 4)/2 - 1 = 4, so the uncertainty is 0.3 x 4 µm. The pressure
    is half of its maximum next to it, which is 1 in both directions, so that it is 0.24 of it.
    """
    gap, pressure = np.full((6, 5), 9e-6), np.zeros((6, 5))
    gap[0, 2] = 1e-6
    gap[1, 2] = gap[5, 2] = 3e-6  # across the seam of the ring
    gap[0, 1], gap[0, 3] = 2e-6, 4e-6
    pressure[0, 2] = 2e6
    pressure[[1, 5, 0, 0], [2, 2, 1, 3]] = 1e6
    found = resolution(film_run(gap, pressure), "ehd")
    assert found is not None
    assert found.film == pytest.approx(1.2e-6, rel=1e-12)
    assert found.pressure == pytest.approx(0.24, rel=1e-12)
    assert (found.thickness, found.cells, found.length) == (1e-6, 30, pytest.approx(0.04))
    assert not found.narrow  # three cells have half of the maximum
    other = resolution(film_run(gap, pressure), "ehd", (0, 1))  # 9 and 9, and 1 µm on one side
    assert other is not None and other.thickness == 2e-6
    assert other.film == pytest.approx(0.3 * (9.0 / 2.0 - 1.0 + (9.0 + 1.0) / 4.0 - 1.0) * 2e-6)
    # 2 + 4 x 1 MPa: (4, 1, 1) around and along, whose squares sum to 18 of 36
    assert found.load == pytest.approx(2 * 0.5**2, rel=1e-12)


def test_a_narrow_peak_at_the_edge_does_not_converge():
    gap, pressure = np.full((6, 5), 9e-6), np.zeros((6, 5))
    pressure[2, 4] = 1e6
    found = resolution(film_run(gap, pressure), "ehd")
    assert found is not None and found.narrow


def test_cells_that_carry_a_uniform_load():
    assert carrying(np.zeros((1, 8, 4))) == 0.0
    pressure = np.zeros((2, 8, 4))
    pressure[1, :4, 1:3] = 1.0
    assert carrying(pressure) == pytest.approx(1 / 16 + 1 / 4)


def test_every_second_cell_by_hand():
    """The sum of the first column is 4 of 5, so that the mean changes by 4/2 - 5/4, of 5/4."""
    field = np.array([[[1.0, 0.5], [3.0, 0.5]]])
    assert thinned(field) == pytest.approx((2.0 - 1.25 + abs(0.75 - 1.25)) / 1.25)
    assert thinned(np.zeros((1, 4, 4))) == 0.0
    assert thinned(np.ones((3, 4, 6))) == 0.0


def test_parts_of_step_and_period_by_hand():
    """Two periods of four steps; the maximum is 5 in the first one and 7 in the second one.

    Every second row of the last one has 6 at most. The third differences are zero but for the rows
    of the extreme, which are beyond a measure without a row.
    """
    values = np.array([0.0, 5.0, 1.0, 0.0, 0.0, 7.0, 6.0, 0.0, 0.0])
    time = np.arange(9.0)
    whole = film_run(np.ones((4, 4)), np.ones((4, 4)), time, 4.0)
    last = film_run(np.ones((4, 4)), np.ones((4, 4)), time[4:], 4.0)
    last.whole = whole
    indicator = Indicator(last, ["ehd"])
    course = Course(values, of_extreme(np.max))
    found = indicator.parts(Measure("m", "m", 7.0, "1", "ehd", course=course))
    assert found == {"step": 1.0, "period": 2.0}


def test_a_run_of_one_period_has_no_part_of_the_period():
    time = np.arange(5.0)
    one = film_run(np.ones((4, 4)), np.ones((4, 4)), time, 4.0)
    course = Course(time, of_extreme(np.max))
    found = Indicator(one, ["ehd"]).parts(Measure("m", "m", 4.0, "1", "ehd", course=course))
    assert found == {"step": 0.0}


def test_reductions_by_hand():
    time, power = np.array([0.0, 1.0, 3.0]), np.array([0.0, 2.0, 4.0])
    half = of_work(10.0, time, power)
    assert half(time, power / 2) == pytest.approx(5.0)
    energy = np.array([0.0, 3.0, 1.0, 2.0, 1.5])
    assert hardest(time, energy) == pytest.approx(2.0)
    assert hardest(time, np.zeros(5)) == 0.0


def test_an_unrecorded_film_is_a_reason(tmp_path):
    run = film_run(np.ones((4, 4)), np.ones((4, 4)))
    run.fields.clear()
    run.known["ehd.minimum_film_thickness"] = ([2e-6, 1e-6], "m")
    case = SimpleNamespace(axes_of=lambda port: None)
    film = measures(case, run).of("minimum_film_thickness_m", "ehd")
    assert film.uncertainty.value is None
    assert film.uncertainty.reason == ("record.fields lacks ehd.pressure and bodies.film_thickness")


def test_differences_of_further_runs_by_hand():
    """The figure is 10, 12 on the second grid, and 13 there with doubled steps: -6 and -1.25."""

    def table(value):
        known = Uncertainty(1.0)
        return Measures(
            all=[Measure("slap_energy_j", "slap", value, "J", "bodies", uncertainty=known)]
        )

    found = further.differences(table(10.0), table(12.0), table(13.0))
    assert found == {
        "uncertainty_grid_slap_energy_j_bodies": -6.0,
        "uncertainty_step_slap_energy_j_bodies": -1.25,
    }
    found = further.differences(table(10.0), table(13.0))
    assert found == {"uncertainty_grid_slap_energy_j_bodies": -9.0}
    found = further.differences(table(10.0), table(13.0), unrefined={"bodies"})
    assert found == {"uncertainty_step_slap_energy_j_bodies": -3.75}
    found = further.differences(table(10.0), table(12.0), safety=1.5)
    assert found == {"uncertainty_grid_slap_energy_j_bodies": -3.0}


def test_trees_of_further_runs():
    tree = read_tree(find_case("data_sheet"))
    second = coarser(tree)
    third = further.longer(second)
    grids = [one["build"]["grid"] for one in third["participants"].values() if "build" in one]
    assert grids == [[28, 28], [28, 28]]
    assert third["time"]["step"] == "2 deg" and second["time"]["step"] == "1 deg"
    assert tree["participants"]["ehd"]["build"]["grid"] == [40, 40]
    del tree["participants"]["ehd"]["build"]["grid"]
    with pytest.raises(BadInput, match="expected films with build.grid, got none in ehd"):
        coarser(tree)


def test_films_of_one_body_have_the_rows_of_its_second_grid():
    """21 rows instead of 40 have their edges 0.025 rows from 19 and 21 of 40.

    One film is 10 of 21 rows instead of 19 of 40, so that its length is 82.8 mm x 10/21.
    """
    assert fitting_rows(40, [0, 19, 21, 40]) == 21
    assert fitting_rows(40, [0, 40]) == 28
    tree = read_tree(find_case("grooved_skirt"))
    made = coarser(tree)["participants"]
    bodies = made["bodies"]["build"]
    assert bodies["grid"] == [20, 21]
    assert [band["rows"] for band in bodies["film_surfaces"]] == [[1, 10], [12, 21]]
    for film in ("lower_film", "upper_film"):
        assert made[film]["build"]["grid"] == [20, 10]
        length = float(made[film]["parameters"]["skirt_length"].removesuffix(" mm"))
        assert length == pytest.approx(82.8 * 10 / 21, rel=1e-9)
    assert ratio_of(tree) == pytest.approx(40 / 21)
    assert kept_films(tree) == set()


def test_factors_of_safety_by_hand():
    """Order 2 has 3/(r^2 - 1), order 1 has 1.25/(r - 1), and their larger one is at most 3."""
    assert grid_safety(2.0) == pytest.approx(1.25)
    assert grid_safety(1.5) == pytest.approx(2.5)
    assert grid_safety(1.2) == 3.0


def test_films_of_pin_and_crank_keep_their_grid():
    tree = read_tree(find_case("crank_bearings"))
    shells = {f"{name}_film" for name in ("left", "right", "small_end", "big_end", "main")}
    assert kept_films(tree) == shells
    made = coarser(tree)["participants"]
    assert made["skirt_film"]["build"]["grid"] == made["bodies"]["build"]["grid"] == [28, 28]
    assert {tuple(made[name]["build"]["grid"]) for name in shells} == {(72, 8)}
    assert made["bodies"]["build"]["big_end"]["grid"] == [72, 8]


def test_the_output_names_what_keeps_its_grid():
    text = uncertainty_text(Measures(), {"uncertainty_kept": "left_film"})
    assert text == "These participants keep their grid: left_film."


def test_a_masked_skirt_has_no_second_grid():
    tree = read_tree(find_case("data_sheet"))
    tree["participants"]["ehd"]["build"]["mask"] = "holes.csv"
    assert kept_films(tree) == {"ehd", "bodies"}
    with pytest.raises(BadInput, match="without build.mask, got none"):
        coarser(tree)


@pytest.mark.parametrize(
    "period, step, part",
    [
        ("720 deg", "1 deg", 0.25),
        ("360 deg", "2 deg", 88 / 360),
        ("20 ms", "1 deg", 1.0),
        ("360 deg", "8 deg", 1.0),  # 45 steps
    ],
)
def test_the_lead_is_a_multiple_of_the_longer_step(period, step, part):
    assert further.lead(period, step) == pytest.approx(part, rel=1e-12)


@pytest.mark.parametrize(
    "stop, step, factor",
    [
        ("720 deg", "1 deg", 2.0),
        ("21 deg", "1 deg", 21 / 10),  # 21 steps become 10
        ("1080 deg", "8 deg", 45 / 22),  # 135 steps with a period of 45
        ("27 deg", "9 deg", 3.0),
    ],
)
def test_longer_steps_divide_run_and_period(stop, step, factor, tmp_path):
    changes = [("time.stop", stop), ("time.step", step), ("time.period", "360 deg")]
    tree = read_tree(find_case("data_sheet"), changes if stop == "1080 deg" else changes[:2])
    folder = find_case("data_sheet").parent
    assert further.longer_steps(tree, folder) == pytest.approx(factor, rel=1e-12)
    assert not further.reason_ahead(tree, folder)
    assert not faults_ahead(check_case(further.longest(tree, folder), folder), folder)


def test_a_case_without_further_runs_is_reported_before_its_run():
    folder = find_case("data_sheet").parent
    tree = read_tree(find_case("data_sheet"), [("time.stop", "9 deg"), ("time.step", "9 deg")])
    assert "got none for 1 and 80 steps" in further.reason_ahead(tree, folder)


def test_further_runs_continue_from_the_settled_state(tmp_path):
    """Three periods of a run allow one, after a quarter in which the film forgets its start."""
    names = ("crank_angle", "rotation_speed", "lateral_displacement", "rocking_angle")
    known = {f"bodies.{name}": ([0.0, float(k)], "1") for k, name in enumerate(names)}
    run = InMemory([0.0, 1.0], known)
    run.summary = {"periods": 3}
    tree = read_tree(find_case("data_sheet"), [("time.until_periodic", 1e-3)])
    made = further.continued(tree, run, tmp_path)
    assert made["time"]["stop"] == "900 deg"
    start = json.loads((tmp_path / "bodies.json").read_text())
    assert start == {name: float(k) for k, name in enumerate(names)}
    assert made["participants"]["bodies"]["build"]["start"] == str(tmp_path / "bodies.json")
    first, second = further.attempts(tree, tmp_path, run, tmp_path)
    steps = [[one["time"]["step"] for one in trees()] for trees in (first, second)]
    assert steps == [["1 deg", "2 deg"], ["2 deg"]]
    assert "start" not in second()[0]["participants"]["bodies"]["build"]
    run.summary = {"periods": 1}
    assert further.continued(tree, run, tmp_path) is tree
    assert len(further.attempts(tree, tmp_path, run, tmp_path)) == 1


def test_an_interruption_ends_further_runs_and_keeps_the_result(tmp_path, monkeypatch):
    """The first attempt stops by a signal; a second one would ignore it."""
    begun = []

    def interrupted(tree, *_):
        begun.append(tree)
        raise Interrupted(tmp_path / "scratch.h5", 0.01)

    results = SimpleNamespace(case=None)
    monkeypatch.setattr(further, "Results", lambda path: nullcontext(results))
    monkeypatch.setattr(further, "check_case", lambda tree, folder: None)
    monkeypatch.setattr(further, "measures", lambda case, results: Measures())
    monkeypatch.setattr(further, "attempts", lambda *_: [lambda: ["first"], lambda: ["second"]])
    monkeypatch.setattr(further, "_measured", interrupted)
    with pytest.raises(Stopped, match=r"a\.h5 is complete, with estimates from its run alone"):
        further.state_uncertainty({}, tmp_path, tmp_path / "a.h5", print)
    assert begun == ["first"]


def test_a_film_of_few_cells_has_no_second_grid():
    """5 cells would keep 4 of them, and 4 cells all, so that both grids hardly differ."""
    tree = read_tree(find_case("data_sheet"))
    for table in ("ehd", "bodies"):
        tree["participants"][table]["build"]["grid"] = [6, 5]
    with pytest.raises(BadInput, match=r"at least 6 cells in each direction, got \[6, 5\]"):
        coarser(tree)
