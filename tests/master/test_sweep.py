"""Sweeps: axes, resuming, failures as rows."""

import csv
import errno
import os
from concurrent.futures import Executor, Future
from types import SimpleNamespace

import pytest

from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.master.runs.recorder import CannotWrite
from piston_cosim.master.runs.sweep import (
    all_points,
    build_all,
    parse_axis,
    run_point,
    sweep,
    table_for,
    unfinished,
)

PATH = find_case("fired_motorcycle")


@pytest.fixture(scope="module")
def tree():
    return read_tree(PATH)


class Answering(Executor):
    """Executor that answers without processes.

    It counts the calls, fails for one value and dies for another.
    """

    def __init__(self):
        self.asked = 0

    def submit(self, function, tree, case_folder, output):
        self.asked += 1
        future, speed = Future(), tree["participants"]["bodies"]["parameters"]["crank_speed"]
        if speed == "2000 rpm":
            future.set_exception(RuntimeError("process died"))
        else:
            done, failed = (
                {"status": "done", "message": "", "x": 1.0},
                {"status": "failed", "message": "no step"},
            )
            future.set_result(failed if speed == "3000 rpm" else done)
        return future


def test_failures_are_rows_and_a_second_start_tries_them_again(tree, tmp_path):
    points = all_points(PATH, [], [parse_axis("crank_speed=1000rpm..3000rpm:3", tree)])
    first = Answering()
    rows = sweep(points, PATH.parent, tmp_path, first)
    assert [row["status"] for row in rows] == ["done", "failed", "failed"]
    assert "process died" in rows[1]["message"]
    with open(tmp_path / "sweep.csv") as file:
        table = list(csv.DictReader(file))
    assert [row["crank_speed"] for row in table] == ["1000 rpm", "2000 rpm", "3000 rpm"]
    assert (table[0]["x"], table[2]["message"]) == ("1.0", "no step")
    assert unfinished(points, tmp_path) == points[1:]
    assert unfinished(points, tmp_path, uncertainty=True) == points  # no row has computed ones
    again = Answering()
    assert sweep(points, PATH.parent, tmp_path, again) == rows
    assert (first.asked, again.asked) == (3, 2)


def test_a_wrong_point_does_not_blame_the_files_of_its_case(tree, tmp_path):
    wrong = tree | {"coupling": tree["coupling"] | {"method": "newtonn"}}
    row = run_point(wrong, PATH.parent, tmp_path / "run.h5")
    assert row["status"] == "bad input"
    assert "newtonn" in row["message"] and "file" not in row["message"]


def test_points_of_one_case_are_one_run_with_a_row_each(tree, tmp_path):
    """A label does not affect the results, and two processes cannot write one file."""
    axes = [parse_axis(text, tree) for text in ("crank_speed=1000rpm;1500rpm", "label=a;b")]
    points, executor, seen = all_points(PATH, [], axes), Answering(), []
    watch = lambda row, done, total: seen.append((row["label"], done, total))  # noqa: E731
    rows = sweep(points, PATH.parent, tmp_path, executor, watch)
    assert executor.asked == 2
    assert [(row["label"], row["status"]) for row in rows] == [("a", "done"), ("b", "done")] * 2
    assert sorted(done for _, done, _ in seen) == [1, 2, 3, 4]


def test_fmus_are_built_once_and_as_the_runs_use_them(tree, monkeypatch):
    built = []

    def path_of_fmu(table, build, folder, progress, is_native):
        built.append((table.package, build["grid"], is_native))

    monkeypatch.setattr("piston_cosim.master.case.opening.path_of_fmu", path_of_fmu)
    axes = [parse_axis(f"{key};9 um", tree) for key in ("barrel=8 um", "roughness_rms=8 um")]
    points = all_points(PATH, [("native", ["ehd"])], axes)
    build_all(points, PATH.parent, lambda text: None)
    assert len(points) == 4
    assert built == [("fmu_mfbd", [40, 40], False), ("fmu_ehd", [40, 40], True)]


class Here(Executor):
    """Runs in this process."""

    def submit(self, function, *arguments):
        future = Future()
        future.set_result(function(*arguments))
        return future


def nothing(*given, **options):
    return {}


def opened(*given):
    return SimpleNamespace(folder=str(PATH.parent))


def replace(monkeypatch, run, truncation=nothing, measures=nothing):
    """Let points run so, and nothing be built."""
    others = {"runs.completed.run": run, "runs.completed.state_truncation": truncation}
    others |= {"engine.answer.row_of": measures, "case.system.open_system": opened}
    for name, function in others.items():
        monkeypatch.setattr(f"piston_cosim.master.{name}", function)


def test_a_full_disk_fails_its_point_and_a_second_start_tries_it_again(tree, tmp_path, monkeypatch):
    """Once the disk has no room for one of two points, and then for the sweep's own rows."""
    points = all_points(PATH, [], [parse_axis("crank_speed=1000rpm;2000rpm", tree)])
    full = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    def run(system, case, tree, path, **options):
        if path.stem == points[1].name and not freed:
            raise CannotWrite.of(path, full)
        return {"steps": 3}

    freed = []
    replace(monkeypatch, run)
    first, second = sweep(points, PATH.parent, tmp_path, Here())
    assert (first["status"], second["status"]) == ("done", "failed")
    path = tmp_path / "runs" / f"{points[1].name}.h5"
    assert second["message"] == f"{path} cannot be written: No space left on device"
    assert unfinished(points, tmp_path) == points[1:]
    freed.append(True)
    with monkeypatch.context() as patch:

        def refused(*given):
            raise full

        patch.setattr("pathlib.Path.write_bytes", refused)
        with pytest.raises(CannotWrite, match="sweep.csv cannot be written: No space left"):
            sweep(points, PATH.parent, tmp_path, Here())
    assert unfinished(points, tmp_path) == points[1:]
    assert [row["status"] for row in sweep(points, PATH.parent, tmp_path, Here())] == ["done"] * 2


def test_a_point_states_what_its_modes_leave_out(tree, tmp_path, monkeypatch):
    """As a run of its own does; nothing is built here."""
    asked = []

    def truncation(*given):
        asked.append(given[:3])
        return {"truncation_error_piston": 0.1}

    measured = {"slap_energy_j": 2}
    run = lambda *given, **how: {"steps": 3}  # noqa: E731
    replace(monkeypatch, run, truncation, lambda *given: measured)
    row = run_point(tree, str(PATH.parent), str(tmp_path / "run.h5"))
    expected = {"slap_energy_j": 2, "steps": 3, "truncation_error_piston": 0.1}
    assert row == {"status": "done", "message": ""} | expected
    assert asked == [(tree, PATH.parent, tmp_path / "run.h5")]


def test_a_point_states_why_it_has_estimates_only(tree, tmp_path, monkeypatch):
    """The parts of uncertainties are not in the table, the reason is."""
    added = {"uncertainty_reason": "few cells", "uncertainty_grid_slap_energy_j": 1.0}
    replace(monkeypatch, nothing)
    monkeypatch.setattr("piston_cosim.master.runs.uncertainty.state_uncertainty", lambda *_: added)
    row = run_point(tree, str(PATH.parent), str(tmp_path / "run.h5"), True)
    assert row["uncertainty_reason"] == "few cells" and "uncertainty_grid_slap_energy_j" not in row


@pytest.mark.parametrize("text", ["", "{", "[]", '{"status": "failed"}', '{"x": 1.0}'])
def test_a_row_that_is_damaged_or_failed_is_no_row(tree, tmp_path, text):
    points = all_points(PATH, [], [parse_axis("crank_speed=1000rpm;2000rpm", tree)])
    (tmp_path / "runs").mkdir()
    (tmp_path / "runs" / f"{points[0].name}.json").write_text(text)
    assert unfinished(points, tmp_path) == points


def test_a_second_sweep_in_the_same_folder_is_refused(tree, tmp_path):
    points = all_points(PATH, [], [parse_axis("crank_speed=1000rpm;1500rpm", tree)])

    def watch(row, done, total):
        with pytest.raises(BadInput, match=f"written by process {os.getpid()}"):
            sweep(points, PATH.parent, tmp_path, Answering())

    sweep(points, PATH.parent, tmp_path, Answering(), watch)
    sweep(points, PATH.parent, tmp_path, Answering())


def test_the_table_of_another_sweep_stays(tree, tmp_path):
    """A sweep that grows continues its table.

    Fewer values, other keys or a change of the case give a separate table.
    """

    def points(text, changes=()):
        return all_points(PATH, changes, [parse_axis(text, tree)])

    def run(chosen):
        sweep(chosen, PATH.parent, tmp_path, Answering())

    few, more = points("crank_speed=1000rpm;1500rpm"), points("crank_speed=1000rpm;1500rpm;1800rpm")
    run(few)
    first = (tmp_path / "sweep.csv").read_text()
    assert table_for(tmp_path, few) == table_for(tmp_path, more) == tmp_path / "sweep.csv"
    others = [
        points("crank_speed=1000rpm;1800rpm"),
        points("ovality=100um;200um"),
        points("crank_speed=1000rpm;1500rpm", [("viscosity", "20 mPa s")]),
    ]
    for number, other in enumerate(others, 2):
        assert table_for(tmp_path, other).name == f"sweep_{number}.csv"
        run(other)
        assert table_for(tmp_path, other).name == f"sweep_{number}.csv"  # and goes on there
    assert (tmp_path / "sweep.csv").read_text() == first
    run(more)
    assert (tmp_path / "sweep.csv").read_text().startswith(first.rstrip())
    (tmp_path / "sweep.csv").write_text("mine")
    assert table_for(tmp_path, few).name == "sweep_5.csv"
