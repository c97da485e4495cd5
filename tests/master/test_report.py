"""Report: numbers against closed forms, the frames in the page, notes, checks and studies."""

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

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.engine.answer import Answer
from piston_cosim.master.engine.verdicts import Verdict
from piston_cosim.master.results.file import Results
from piston_cosim.master.results.report import checks, cursor_of, nearest, write_report
from piston_cosim.master.runs.console import print_summary

from .by_hand import coupling, write_results

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
    """Write x = -1 mm sin, y = 1 N cos, z = 1 N cos over one revolution in 1 s.

    A 4 x 3 field changes with time.
    """
    path, time = tmp_path / "run.h5", np.linspace(0.0, 1.0, STEPS + 1)
    turn = 2 * np.pi * time
    signals = {"x": (-1e-3 * np.sin(turn), "m"), "y": (np.cos(turn), "N"), "z": (np.cos(turn), "N")}
    moving = time[::4, None, None] * 100.0 + np.arange(12.0).reshape(4, 3)
    said = {"versions": {"piston-cosim": "0"}, "summary": {"steps": STEPS, "halved_steps": 0}}
    with write_results(
        path,
        time,
        {f"a.{name}": one for name, one in signals.items()} | coupling(STEPS + 1),
        {"a.map": (moving, "Pa")},
        time[::4],
        title="t",
        case=TREE,
        **said,
    ) as opened:
        yield opened


def test_page_holds_the_fields(case, results, tmp_path):
    page = write_report(case, {"run": results}, tmp_path / "report").read_text()
    data = json.loads(
        re.search(r'<script id="data" type="application/json">(.*?)</script>', page, re.S)[1]
    )
    (film,) = data["films"]
    (run,) = film["layers"]["field"]["runs"]
    low, high = np.frombuffer(zlib.decompress(base64.b64decode(run["text"])), "u1").reshape(2, -1)
    small = low.astype("<u2") | high.astype("<u2") << 8
    steps = (small >> 1) ^ -(small & 1).astype("<i2").view("<u2")
    bits = steps.reshape(-1, 12).cumsum(axis=0, dtype="<u2").cumsum(axis=0, dtype="<u2")
    read = run["low"] + bits / 65535 * (run["high"] - run["low"])
    held = results.dataset("a.map")[:].reshape(-1, 12)
    assert read == pytest.approx(held, abs=111 * 2.0**-17)  # 16 bits of the range
    layer = film["layers"]["field"]
    assert (layer["low"], layer["high"]) == (0.0, 111.0)
    every = data["cursor"]["frames"][0]
    assert every == list(range(len(results.instants))), "every recorded instant can be reached"
    outside = re.sub(r'<script id="libraries".*?</script>', "", page, flags=re.S)
    assert not re.search("https?:", outside), "the page must need nothing else"


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


def test_checks_are_listed_worst_first_and_shared_by_runs():
    """A check with the same outcome in several runs is one entry."""
    judged = {
        "a": [Verdict("green", "film", "A1."), Verdict("amber", "grid", "A2.")],
        "b": [Verdict("green", "film", "B1."), Verdict("red", "grid", "B2.")],
    }
    assert checks(judged) == [
        ("red", "fail", "grid", {"b": "B2."}),
        ("amber", "warning", "grid", {"a": "A2."}),
        ("green", "pass", "film", {"a": "A1.", "b": "B1."}),
    ]


def test_warnings_are_shown_whole_and_passes_shortened(case, results, tmp_path):
    judged = [
        Verdict("amber", "grid", "Coarse. Refine it."),
        Verdict("green", "film", "1 µm. At 2."),
    ]
    answers = {"run": Answer({}, judged)}
    page = write_report(case, {"run": results}, tmp_path / "r", answers=answers).read_text()
    assert "1 of 2 checks need attention" in page
    assert "Coarse. Refine it." in page and "1 µm." in page and "At 2." not in page


def test_a_run_that_has_not_finished_is_reported(case, results, tmp_path):
    results.close()
    with h5py.File(results.path, "a") as file:
        del file.attrs["summary"]
    again = Results(results.path)
    page = write_report(case, {"run": again}, tmp_path / "r").read_text()
    again.close()
    assert f"<b>run has not finished.</b> The file holds {STEPS} macro steps." in page


def test_runs_with_entries_of_their_own_stand_in_one_table():
    console = Console(record=True, width=80, file=io.StringIO())
    flexible = {"steps": 3, "truncation_error_piston": 0.0175}
    print_summary(console, {"flexible": flexible, "rigid": {"steps": 4, "other": 2.0}})
    lines = [line.split() for line in console.export_text().splitlines()]
    rows = [["steps", "3", "4"], ["truncation_error_piston", "0.0175"], ["other", "2"]]
    assert lines[-3:] == rows
