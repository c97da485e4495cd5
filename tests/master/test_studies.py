"""Studies: points from the case file, distance from the reference, faults before anything runs."""

import csv
from types import SimpleNamespace

import numpy as np
import pytest

from piston_cosim.master.case.reading import find_case
from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.master.runs.studies import (
    Cost,
    StudyRow,
    limits,
    observed_orders,
    study_points,
    study_rows,
)
from piston_cosim.master.runs.sweep import write_table

from .by_hand import InMemory

PATH = find_case("numerical_example")


def test_points_of_the_modes_study_reach_both_bodies():
    _, study, points = study_points(PATH, [("time.stop", "10 deg")], "modes")
    trees = {point.values["run"]: point.tree for point in points}
    build = trees["craig_bampton 20"]["participants"]["bodies"]["build"]
    assert (build["piston"]["modes"], build["block"]["modes"], build["block"]["basis"]) == (
        20,
        20,
        "craig_bampton",
    )
    assert trees["rigid"]["participants"]["bodies"]["build"]["piston"]["modes"] == 0
    assert {tree["time"]["stop"] for tree in trees.values()} == {
        "10 deg"
    } and study.reference in trees


def test_every_study_of_the_case_has_valid_points():
    case, _, _ = study_points(PATH, [], "modes")
    for name in case.studies:
        _, _, points = study_points(PATH, [], name)
        assert len({point.name for point in points}) == len(points), (
            "two points of a study are the same run"
        )


def test_distance_from_the_reference(tmp_path):
    case, study, points = study_points(PATH, [], "step")
    summary = dict.fromkeys((*Cost._fields, *case.summary), 1.0)
    rows = [{"run": p.values["run"], "status": "done", "message": ""} | summary for p in points]
    rows[0] = {"run": rows[0]["run"], "status": "failed", "message": "why"}
    rows[-1]["truncation_error_piston"] = 0.25
    rows[-2]["truncation_error"] = "unknown: nothing recorded"
    x, runs = np.linspace(0.0, 2 * np.pi, 200), {}
    for row in rows[1:]:
        y = np.sin(x) if row["run"] == study.reference else 1.1 * np.sin(x)
        runs[row["run"]] = InMemory(x, dict.fromkeys(study.curves, (y, "1")))
        runs[row["run"]].known["bodies.crank_angle"] = (x, "1")
    table = study_rows(study, case, rows, runs)
    assert table[0] == StudyRow(rows[0]["run"], "failed", None, {}, {})
    expected = 0.1 * np.sqrt(np.mean(np.sin(x) ** 2)) / 2
    for port in study.curves:
        # the range is read at grid points
        assert table[1].distances[port] == pytest.approx(expected, rel=1e-3)
        assert table[-1].distances[port] == 0.0
    with open(write_table([row.record() for row in table], tmp_path / "s.csv")) as file:
        written = list(csv.DictReader(file))
    assert [row["status"] for row in written] == ["failed", *["done"] * (len(rows) - 1)]
    assert written[0]["wall_time_s"] == "" and written[1]["wall_time_s"] == "1.0"
    assert written[-1][f"rms {study.curves[0]}"] == "0.0"
    assert [row["truncation_error_piston"] for row in written[-2:]] == ["", "0.25"]
    assert written[-2]["truncation_error"] == table[-2].truncation["truncation_error"]
    assert table[-2].truncation["truncation_error"] == "unknown: nothing recorded"
    del runs[study.reference]
    with pytest.raises(BadInput, match=r"reference: expected a finished run '0\.125"):
        study_rows(study, case, rows, runs)


@pytest.mark.parametrize("order", [1.0, 1.5, 2.0])
def test_observed_order_of_a_power_of_the_size(order):
    sizes = {"a": 4.0, "c": 1.0, "b": 2.5}
    study = SimpleNamespace(sizes=sizes, summary=["film", "noise"], reference="c", curves=["y"])
    cost = Cost(1.0, 1, 1, 1, 1.0)
    rows = [
        StudyRow(
            label,
            "done",
            cost,
            {"film": 3.0 - h**order, "noise": (h - 2) ** 2},
            {"y": h**order - 1.0},
        )
        for label, h in sizes.items()
    ]
    orders = observed_orders(study, rows)
    assert orders["film"] == pytest.approx(order, rel=1e-9)
    assert orders["y"] == pytest.approx(order, rel=1e-9)
    assert np.isnan(orders["noise"])
    assert observed_orders(study, rows[1:]) == {}
    # u* = 3, and the finest value is 1 below it; without an order, 4, 0.25 and 1 differ by 3.75
    found = limits(study, rows)
    assert found["film"] == pytest.approx((3.0, 1.25, order), rel=1e-9)
    assert found["noise"][:2] == pytest.approx((1.0, 3 * 3.75)) and np.isnan(found["noise"].order)
    assert {*found} == {*study.summary} and limits(study, rows[1:]) == {}
