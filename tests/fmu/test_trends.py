"""Trends published for clearance, ovality and speed, by a sweep of fired runs in two processes."""

import numpy as np
import pytest

from piston_cosim.master.case.schema import find_case, read_tree
from piston_cosim.master.results.file import Results
from piston_cosim.master.runs.sweep import all_points, build_all, local_executor, parse_axis, sweep

PATH = find_case("fired_motorcycle")


@pytest.fixture(scope="module")
def trends(tmp_path_factory):
    """Rows of short fired runs, rigid, 16 x 12 cells, from 30 deg before to 150 deg after firing
    top dead centre.
    """
    tree = read_tree(PATH)
    folder = tmp_path_factory.mktemp("sweep")
    changes = [
        ("participants.bodies.build.grid", [16, 12]),
        ("participants.ehd.build.grid", [16, 12]),
        ("time.stop", "180 deg"),
        ("time.step", "2 deg"),
        ("participants.bodies.parameters.start_crank_angle", "-30 deg"),
        ("record.fields", []),
        *tree["variants"]["rigid"].items(),
    ]
    axes = {
        name: parse_axis(text, tree)
        for name, text in (
            ("clearance", "radial_clearance=15um;30um;45um"),
            ("ovality", "ovality=100um;200um;400um"),
            ("speed", "crank_speed=3000rpm;5000rpm;7000rpm"),
        )
    }
    points = {name: all_points(PATH, changes, [axis]) for name, axis in axes.items()}
    build_all(points["speed"], PATH.parent, lambda text: None)
    with local_executor(2) as executor:
        rows = sweep(sum(points.values(), []), PATH.parent, folder, executor)
    assert {row["status"] for row in rows} == {"done"}
    files = iter(folder / "runs" / f"{p.name}.h5" for p in sum(points.values(), []))
    return {name: [travel(next(files)) for _ in points[name]] for name in points}


def travel(path):
    """Range of the lateral motion in the power stroke [m]."""
    results = Results(path)
    values = results.series("bodies.lateral_displacement")[0]
    results.close()
    return np.ptp(values)


def test_larger_clearance_moves_more(trends):
    assert np.all(
        np.diff(trends["clearance"]) > 1e-6
    )  # a micrometre: a thousand times the coupling tolerance


def test_larger_ovality_moves_more(trends):
    assert np.all(np.diff(trends["ovality"]) > 1e-7)


def test_higher_speed_moves_less_in_the_power_stroke(trends):
    assert np.all(np.diff(trends["speed"]) < -1e-6)
