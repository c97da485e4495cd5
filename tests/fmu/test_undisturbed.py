"""What must not break a run: an FMU that hangs or changes the working directory, a second run in the
same folder, a point of a sweep that never ends.
"""

import csv
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from piston_cosim.master.results.file import Results

from .counter import case_text, library, make

__all__ = ["library"]

COMMAND = [sys.executable, "-m", "piston_cosim"]
LOOP = (("a.x", "b.u", ""), ("b.x", "a.u", "tolerance = 1e-12"))


@pytest.fixture
def folder(tmp_path, library):
    for name in "ab":
        make(tmp_path / f"{name}.fmu", library)
    (tmp_path / "case.toml").write_text(case_text(LOOP))
    return tmp_path


def begun(folder, *words):
    return subprocess.Popen(
        [*COMMAND, *words], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


def hangs(folder, step):
    """The case with an FMU that hangs at a step."""
    text = case_text(LOOP, b=f"trouble = 1\ntrouble_at = {step}")
    (folder / "case.toml").write_text(text)


def waited(path):
    """Wait for a file."""
    end = time.monotonic() + 60
    while not path.exists() and time.monotonic() < end:
        time.sleep(0.02)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_the_second_signal_ends_a_run_whose_fmu_hangs(folder, number):
    hangs(folder, 3)
    process = begun(folder, "run", "case.toml", "--no-plots", "--output", "o")
    waited(folder / "o" / "base.h5.partial")
    time.sleep(0.5)  # it may still be on the way to the fourth step
    process.send_signal(number)
    time.sleep(0.5)
    assert process.poll() is None  # one signal waits for the macro step
    process.send_signal(number)
    _, told = process.communicate(timeout=10)
    assert process.returncode == 128 + number
    assert "once more ends at once" in told and "Traceback" not in told
    # and what it has left is in nobody's way
    (folder / "case.toml").write_text(case_text(LOOP))
    process = begun(folder, "run", "case.toml", "--no-plots", "--output", "o")
    assert process.wait(60) == 0


def test_an_fmu_that_changes_the_working_directory_does_not_matter(folder):
    words = ("--no-plots", "--output", "here/o", "--summary-json", "here.json")
    process = begun(folder, "run", "case.toml", *words)
    told = process.communicate(timeout=60)
    assert process.returncode == 0, told
    assert "results  here/o/base.h5" in told[0]
    assert (folder / "here/o/base.h5").exists() and (folder / "here.json").exists()


def test_a_second_run_into_the_same_results_is_refused_and_the_first_ends_well(folder):
    hangs(folder, 5)
    first = begun(folder, "run", "case.toml", "--no-plots", "--output", "o")
    waited(folder / "o" / "base.h5.partial")
    second = begun(folder, "run", "case.toml", "--no-plots", "--output", "o")
    _, told = second.communicate(timeout=60)
    assert second.returncode == 2
    assert f"base.h5: is being written by process {first.pid}" in told
    first.kill()
    first.communicate()


def test_points_that_hang_or_cannot_run_are_rows_and_the_rest_is_done(folder):
    hangs(folder, -1)
    words = [
        "sweep",
        "case.toml",
        "--vary",
        "participants.b.parameters.trouble_at=-1;3;-2",
        "--workers",
        "1",
        "--time-limit",
        "8 s",
        "--output",
        "s",
    ]
    for _ in range(2):
        process = begun(folder, *words)
        told = process.communicate(timeout=120)
        assert process.returncode == 1, told
        with open(folder / "s" / "sweep.csv") as file:
            rows = list(csv.DictReader(file))
        assert [row["status"] for row in rows] == ["done", "failed", "done"]
        assert "not done within 8 s" in rows[1]["message"]
    assert "1 of 3 points failed" in told[1]
    times = [Results(folder / "s" / row["results"]).time for row in rows if row["status"] == "done"]
    assert np.array_equal(times[0], times[1]) and times[0][-1] == 1.0


@pytest.mark.parametrize("limit", ["8 m", "-1 s", "x"])
def test_a_time_limit_is_a_time(folder, limit):
    words = ("--vary", "participants.b.parameters.k=1;2", f"--time-limit={limit}")
    process = begun(folder, "sweep", "case.toml", *words)
    _, told = process.communicate(timeout=60)
    assert process.returncode == 2 and "--time-limit" in told
