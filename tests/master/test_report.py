"""Report: numbers of the verdict against closed forms, the page whole and alive in a browser."""

import base64
import io
import json
import re
import shutil
import zlib

import h5py
import numpy as np
import pytest
from rich.console import Console

from piston_cosim.master.case.schema import check_case
from piston_cosim.master.results.file import Results, add_to_summary
from piston_cosim.master.results.judgement import Quantity, extremes, loop_work, windows
from piston_cosim.master.results.report import cursor_of, nearest, write_report
from piston_cosim.master.runs.console import print_summary

TREE = {
    "title": "Two </script> signals",
    "time": {"stop": "1 s", "step": "10 ms"},
    "participants": {"a": {"fmu": "a.fmu"}},
    "wires": [],
    "coupling": {"order": ["a"]},
    "record": {"fields": ["a.map"]},
    "summary": {"lowest": "min a.x"},
    "monitor": {"y": "last a.y"},
    "window": {"min a.x": ["-2 mm", "0 mm"], "max a.y": ["3 N", "4 N"]},
    "report": {
        "loops": {"work": {"x": "a.x", "y": ["a.y", "a.z"], "period": "1 s", "unit": "mJ"}},
    },
    "pictures": [
        {"file": "lines.png", "title": "Lines", "kind": "lines", "x": "a.x", "y": [["a.y"]]}
    ],
}
STEPS = 400


@pytest.fixture
def case():
    return check_case(TREE, "case.toml")


@pytest.fixture
def results(tmp_path):
    """x = -1 mm sin, y = 1 N cos, z = 1 N cos over one turn in one second; a 4 x 3 field that
    moves.
    """
    path, time = tmp_path / "run.h5", np.linspace(0.0, 1.0, STEPS + 1)
    turn = 2 * np.pi * time
    signals = {"x": (-1e-3 * np.sin(turn), "m"), "y": (np.cos(turn), "N"), "z": (np.cos(turn), "N")}
    with h5py.File(path, "w") as file:
        file.attrs.update(
            {
                "title": "t",
                "case": json.dumps(TREE),
                "versions": json.dumps({"piston-cosim": "0"}),
                "summary": json.dumps({"steps": STEPS, "halved_steps": 0}),
            }
        )
        file["time"] = time
        for name, (values, unit) in signals.items():
            file[f"a/{name}"] = values
            file[f"a/{name}"].attrs.update({"unit": unit, "description": name})
        for name in ("iterations", "derivative_products", "residual"):
            file[f"coupling/{name}"] = np.full(STEPS + 1, 0.5)
            file[f"coupling/{name}"].attrs.update({"unit": "1", "description": name})
        file["fields/time"] = time[::4]
        file["fields/a/map"] = time[::4, None, None] * 100.0 + np.arange(12.0).reshape(4, 3)
        file["fields/a/map"].attrs.update({"unit": "Pa", "description": "map"})
    opened = Results(path)
    yield opened
    opened.close()


def test_loop_work_is_the_area_of_the_ellipse(case, results):
    area = np.pi * 1e-3 * 2.0 * 1e3  # semi-axes 1 mm and 1 N + 1 N, in mJ
    tolerance = 2 * (np.pi / STEPS) ** 2  # trapezia: second order
    assert loop_work(case, results, case.report.loops["work"]) == pytest.approx(area, rel=tolerance)


def test_extremes_know_their_instant(case, results):
    (lowest,) = extremes(case, results)
    assert (lowest.quantity.value, lowest.time) == (pytest.approx(-1e-3), pytest.approx(0.25))
    assert lowest.monitor["y"] == Quantity(pytest.approx(0.0, abs=1e-12), "N")


def test_windows_judge(case, results):
    assert [window.inside for window in windows(case, results)] == [True, False]


def test_page_holds_the_fields(case, results, tmp_path):
    page = write_report(case, {"run": results}, tmp_path / "report").read_text()
    data = json.loads(
        re.search(r'<script id="data" type="application/json">(.*?)</script>', page, re.S)[1]
    )
    (field,) = data["fields"]
    (run,) = field["runs"]
    bits = np.frombuffer(zlib.decompress(base64.b64decode(run["text"])), "<u2").reshape(-1, 12)
    read = bits.cumsum(axis=0, dtype="<u2").view("<f2").astype(float) * run["scale"]
    held = results.dataset("a.map")[:].reshape(-1, 12)
    assert read == pytest.approx(held, rel=2.0**-11)  # half precision: 11 bits
    assert (field["low"], field["high"], field["positive"]) == (0.0, 111.0, 1.0)
    every = data["cursor"]["frames"][0]
    assert every == list(range(len(results.instants))), "every recorded instant can be reached"
    assert len(data["words"][0]) == len(every)
    outside = re.sub(r'<script id="plotter".*?</script>', "", page, flags=re.S)
    assert not re.search("https?:", outside), "the page must need nothing else"
    assert {p.suffix for p in (tmp_path / "report").iterdir()} == {".png", ".svg", ".html"}


def test_notes_are_markdown_with_pictures_and_run_no_script(case, results, tmp_path):
    notes = tmp_path / "notes.md"
    table = "| a | b |\n|---|---|\n| 1 | 2 |"
    notes.write_text(f"# Sources\n\n{table}\n\n![map](map.png)\n\n<script>alert(1)</script>\n")
    (tmp_path / "map.png").write_bytes(b"\x89PNG")
    page = write_report(case, {"run": results}, tmp_path / "r", notes).read_text()
    assert 'src="data:image/png;base64,iVBORw=="' in page
    assert "<h1>Sources</h1>" in page and "<td>2</td>" in page
    assert "<script>alert" not in page and "&lt;script&gt;alert" in page


def test_the_cursor_stands_at_every_instant_of_every_run(results, tmp_path):
    other = tmp_path / "other.h5"
    shutil.copy(results.path, other)
    with h5py.File(other, "a") as file:  # recorded half way between the first run's instants
        file["fields/time"][:-1] = results.instants[:-1] + 0.005
    opened = Results(other)
    cursor = cursor_of({"run": results, "other": opened})
    opened.close()
    assert cursor.unit == "ms"
    assert cursor.positions == pytest.approx(np.arange(2 * len(results.instants) - 1) * 5.0)
    assert cursor.frames[0][:5].tolist() == [0, 0, 1, 1, 2]  # 5 ms is as near to 0 as to 10 ms
    assert cursor.frames[1][:5].tolist() == [0, 0, 0, 1, 1]


@pytest.mark.parametrize("wanted, index", [(-1.0, 0), (0.4, 0), (0.6, 1), (9.0, 2)])
def test_nearest(wanted, index):
    assert nearest(np.array([0.0, 1.0, 2.0]), np.array([wanted])).tolist() == [index]
    assert nearest(np.array([5.0]), np.array([wanted])).tolist() == [0]


def test_study_tables_are_shown(case, results, tmp_path):
    table = tmp_path / "study_x_grid" / "study.csv"
    table.parent.mkdir()
    table.write_text("run,rms bodies.lateral_displacement\n20 x 20,0.012345678\n")
    page = write_report(case, {"run": results}, tmp_path / "report", studies=[table]).read_text()
    assert (
        "Convergence and cost: study_x_grid" in page
        and "<td>0.01235</td>" in page
        and "<th>lateral displacement</th>" in page
    )


@pytest.mark.parametrize(
    "periodic, verdict",
    [(True, '<span class="good">Periodic</span>'), (False, '<span class="fair">Not periodic')],
)
def test_periods_are_judged(case, results, tmp_path, periodic, verdict):
    settled = {"periods": 3, "period_distance": 1.2e-4, "periodic": periodic, "settled": "in words"}
    whole = {"steps": STEPS, "halved_steps": 0} | settled
    path = tmp_path / "periods.h5"
    shutil.copy(results.path, path)
    with h5py.File(path, "a") as file:
        file.attrs["summary"] = json.dumps(whole)
    opened = Results(path)
    page = write_report(case, {"run": opened}, tmp_path / "report").read_text()
    opened.close()
    assert verdict in page
    assert "</span>: in words." in page


def test_a_run_without_a_period_is_not_judged_by_it(case, results, tmp_path):
    assert "eriodic" not in write_report(case, {"run": results}, tmp_path / "r").read_text()


@pytest.mark.parametrize(
    "entries, said",
    [
        (
            {"truncation_error_block": 0.0175, "truncation_error_block_largest": 0.031},
            "block is 1.8 % of its deflection under the film, 3.1 % at the worst recorded",
        ),
        (
            {"truncation_error_film": 0.0042},
            "The truncation error is at most 0.42 % of the local film thickness.",
        ),
        ({"truncation_error": "unknown: no forces"}, "The truncation error is unknown: no forces."),
        ({}, None),
    ],
)
def test_what_the_modes_miss_is_stated(case, results, tmp_path, entries, said):
    results.close()
    add_to_summary(results.path, entries)
    again = Results(results.path)
    page = write_report(case, {"run": again}, tmp_path / "page").read_text()
    again.close()
    text, _, _ = page.partition("<script")  # what is read, not what draws
    assert ("truncation error" in text) == (said is not None)
    assert said is None or said in " ".join(page.split())


def test_runs_with_entries_of_their_own_stand_in_one_table():
    console = Console(record=True, width=80, file=io.StringIO())
    flexible = {"steps": 3, "truncation_error_piston": 0.0175}
    print_summary(console, {"flexible": flexible, "rigid": {"steps": 4, "other": 2.0}})
    lines = [line.split() for line in console.export_text().splitlines()]
    rows = [["steps", "3", "4"], ["truncation_error_piston", "0.0175"], ["other", "2"]]
    assert lines[-3:] == rows
