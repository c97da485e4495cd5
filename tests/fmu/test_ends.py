"""FMUs that end the process or print, and scripts that start worker processes.

The tests check exit codes, streams, and how often a script's body runs.
"""

import subprocess
import sys

import pytest

from .counter import case_text


def python(folder, *arguments):
    """Run Python in a folder and return the finished process."""
    return subprocess.run(
        [sys.executable, *arguments], cwd=folder, capture_output=True, text=True, timeout=120
    )


def run(folder, text):
    """Run a case with `piston-cosim run` and return the finished process."""
    (folder / "case.toml").write_text(text)
    return python(folder, "-m", "piston_cosim", "run", "case.toml", "--output", "out", "--no-plots")


@pytest.mark.parametrize("isolated", [False, True])
def test_exit_inside_an_fmu_is_no_success(folder, isolated):
    text = case_text([("a.x", "b.u", "")], b="trouble = 3\ntrouble_at = 3")
    done = run(folder, text.replace('"b.fmu"', '"b.fmu"\nisolated = true') if isolated else text)
    assert done.returncode == 1
    assert "stopped: b: the FMU called exit()" in done.stderr
    assert ("its process has ended (exit code 1)" in done.stderr) == isolated
    assert not (folder / "out" / "base.h5").exists()


def test_a_script_that_ends_itself_keeps_its_exit_code(folder):
    script = "import sys, piston_cosim as pc\none = pc.open_fmu('a.fmu')\none.start({}, 0.0, 1.0)\n"
    for code in (0, 7):
        (folder / "script.py").write_text(f"{script}sys.exit({code})")
        done = python(folder, "script.py")
        assert (done.returncode, done.stderr) == (code, "")


def test_what_an_fmu_prints_is_not_in_the_standard_output(folder):
    calm = run(folder, case_text([]))
    loud = run(folder, case_text([], a="trouble = 4\ntrouble_at = 3"))
    assert "a banner of the FMU" in loud.stderr
    assert "banner" not in loud.stdout
    assert len(loud.stdout.splitlines()) == len(calm.stdout.splitlines()) > 0


SCRIPT = """
import piston_cosim as pc
open("ran.txt", "a").write("x")
case = pc.couple({"a": "a.fmu"}, [], stop="1 s", step="0.1 s")
apart = case.changed({"participants.a.isolated": True})
print(apart.run("r.h5").series("a.x")[0][-1])
rows = pc.sweep(case, {"participants.a.parameters.k": [1.0, 2.0]}, output="sweep")
print([row["status"] for row in rows])
"""


def test_a_script_without_a_guard_runs_once(folder):
    (folder / "script.py").write_text(SCRIPT)
    done = python(folder, "script.py")
    assert (folder / "ran.txt").read_text() == "x"
    end, states = done.stdout.splitlines()
    assert float(end) == pytest.approx(1.1**-10, rel=1e-14)  # backward Euler, 10 steps of 0.1 s
    assert states == "['done', 'done']"
    assert (done.returncode, done.stderr) == (0, "")
