"""Faults injected into a run of 200 steps.

The run recovers and ends converged, or stops with exit code 1, a message and a checkpoint. From
the checkpoint it continues to the same bits as a run without the fault.
"""

import resource
import subprocess
from functools import partial
from pathlib import Path
from unittest.mock import MagicMock

import numpy as np
import pytest

from piston_cosim.master.participants import isolated

from ..command import begun, call
from .runs import datasets
from .waiting import wait_for

CASE = """
title = "Two cells"
[time]
stop = "2 s"
step = "0.01 s"
[participants.good]
file = "{home}/faulty.py:Cell"
[participants.good.parameters]
u = 0.0
[participants.bad]
file = "{home}/faulty.py:Cell"
isolated = {isolated}
timeout = "3 s"
[participants.bad.parameters]
fault = "{fault}"
at = "1.233 s"
marker = "{folder}/marker"
[[wires]]
from = "good.x"
to = "bad.u"
tolerance = 1e-9
[[wires]]
from = "bad.x"
to = "good.u"
tolerance = 1e-9
[coupling]
method = "aitken"
order = ["good", "bad"]
[record]
fields = ["good.x", "bad.x"]
checkpoint_every = 30
"""


def call_apart(*words, **settings):
    """Run the command in its own process group, in which it may be interrupted."""
    process = begun(".", *words, start_new_session=True, **settings)
    out, errors = process.communicate(timeout=120)
    return subprocess.CompletedProcess(words, process.returncode, out, errors)


def write_case(folder, fault, isolated=False):
    text = CASE.format(
        home=Path(__file__).parent, folder=folder, fault=fault, isolated=str(isolated).lower()
    )
    (folder / "case.toml").write_text(text)


def run(folder, fault, isolated=False, changes=(), **settings):
    write_case(folder, fault, isolated)
    command = partial(call_apart, **settings) if settings or fault == "interrupt" else call
    changes = [f"--set={change}" for change in changes]
    return command("run", folder / "case.toml", "--output", folder, "--no-plots", *changes)


def logs(folder):
    return {
        kind: (folder / f"base-{kind}.log").read_text() for kind in ("iterations", "convergence")
    }


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Results of the run in which nothing goes wrong."""
    folder = tmp_path_factory.mktemp("whole")
    done = run(folder, "")
    assert done.returncode == 0, done.stderr
    return datasets(folder / "base.h5") | logs(folder)


@pytest.mark.parametrize(
    "fault, isolated", [("discard", False), ("nan", False), ("discard", True), ("nan", True)]
)
def test_recovers(whole, tmp_path, fault, isolated):
    done = run(tmp_path, fault, isolated)
    assert done.returncode == 0, done.stderr
    results = datasets(tmp_path / "base.h5")
    assert results["time"].size == whole["time"].size + 1  # one step was taken as two halves
    # backward Euler with one step of 200 halved: its error there, H^2 |x''|/4 < 1e-4 * 40 / 4, is
    # all that differs
    np.testing.assert_allclose(results["fields/bad/x"][-1], whole["fields/bad/x"][-1], atol=1e-3)
    assert results["coupling/residual"].max() <= 1
    lines = logs(tmp_path)["iterations"].splitlines()[1:]
    failed = [line for line in lines if line.split()[5] == "0"]
    words = "expected a finite output" if fault == "nan" else "refused on purpose"
    assert len(failed) == 1 and words in failed[0]


@pytest.mark.parametrize(
    "fault, isolated, words",
    [
        ("exception", False, "KeyError: 'bug'"),
        ("exception", True, "KeyError: 'bug'"),
        ("hang", True, "no answer to step within 3 s"),
        ("kill", True, "its process has ended (by SIGKILL)"),
        ("crash", True, "its process has ended (by SIGSEGV)"),
        ("interrupt", False, "interrupted at t = 1.24 s"),
        ("interrupt", True, "interrupted at t = 1.24 s"),
    ],
)
def test_stops_and_goes_on_with_the_same_bits(whole, tmp_path, fault, isolated, words):
    done = run(tmp_path, fault, isolated)
    assert done.returncode == 1, done.stderr
    assert words in done.stderr and ("bad" in done.stderr or fault == "interrupt")
    goes_on_as_if_nothing_had_happened(done, tmp_path, whole)


def goes_on_as_if_nothing_had_happened(done, folder, whole):
    checkpoint = folder / "base.h5.checkpoint"
    assert f"piston-cosim resume {checkpoint}" in done.stderr
    resumed = call("resume", checkpoint)
    assert resumed.returncode == 0, resumed.stderr
    results = datasets(folder / "base.h5") | logs(folder)
    assert [name for name in whole if not np.array_equal(whole[name], results[name])] == []
    assert not checkpoint.exists()


def test_full_disk(whole, tmp_path):
    """The write that meets the limit of a file's size fails as on a full disk.

    No file may grow beyond 1.2 MB. Files of the whole run do.
    """

    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (1_200_000, resource.RLIM_INFINITY))

    done = run(tmp_path, "", preexec_fn=limit)
    assert done.returncode == 1, done.stderr
    assert "cannot be written" in done.stderr and "base.h5" in done.stderr
    # the disk is still full: nothing is lost
    again = call_apart("resume", tmp_path / "base.h5.checkpoint", preexec_fn=limit)
    assert again.returncode == 1 and "cannot be written" in again.stderr
    goes_on_as_if_nothing_had_happened(done, tmp_path, whole)


@pytest.mark.parametrize("isolated", ["false", "true"])
def test_a_state_that_is_not_restored_is_reported_before_anything_is_written(tmp_path, isolated):
    """One cannot be repeated: with steps by local error nothing runs, else the loop is explicit."""
    (tmp_path / "marker").touch()
    changes = [f"participants.bad.isolated={isolated}", "time.stop=0.05 s"]
    done = run(tmp_path, "forgetful", changes=[*changes, "wires.0.local_error=0.1"])
    assert done.returncode == 2
    words = "participants.bad: expected a restored state with local_error, got x differs by "
    assert words in done.stderr
    assert not (tmp_path / "base.h5.partial").exists()
    done = run(tmp_path, "forgetful", changes=changes)
    assert done.returncode == 0
    assert "bad: x differs by " in done.stdout
    assert "explicit   good, bad  (bad cannot restore a saved state)" in done.stdout


def test_fault_before_the_first_checkpoint_says_so(tmp_path):
    (tmp_path / "base.h5.checkpoint").write_bytes(b"of an older run")
    done = run(tmp_path, "exception", changes=["participants.bad.parameters.at=0.1 s"])
    assert done.returncode == 1
    assert "no checkpoint was written" in done.stderr
    assert not (tmp_path / "base.h5.checkpoint").exists()


def children(pid):
    return [int(child) for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


def test_a_killed_master_leaves_no_process_behind(tmp_path):
    """Its FMU hangs at that moment."""
    write_case(tmp_path, "hang", isolated=True)
    words = ("run", tmp_path / "case.toml", "--output", tmp_path, "--no-plots")
    process = begun(".", *words, "--set", "participants.bad.timeout=100 s")
    wait_for((tmp_path / "marker").exists)
    left = children(process.pid)
    assert left
    process.kill()
    process.wait()
    stats = [Path(f"/proc/{pid}/stat") for pid in left]
    wait_for(lambda: not any(one.exists() and ") Z" not in one.read_text() for one in stats))


@pytest.mark.parametrize("gone", [EOFError, ConnectionResetError])
def test_a_served_fmu_ends_in_silence_where_its_master_is_gone(monkeypatch, gone):
    # a master killed before it has read an answer resets the pipe; found by `test_chaos.py`
    monkeypatch.setattr(isolated, "open_fmu", lambda *recipe: None)
    monkeypatch.setattr(isolated, "Server", MagicMock())
    pipe = MagicMock()
    pipe.recv.side_effect = gone
    isolated._serve(pipe, ())
    assert pipe.recv.call_count == 1
