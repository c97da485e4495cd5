"""Variants that run side by side give the same bits as one after the other.

The tests also check what happens if one of them fails, dies or is interrupted.
"""

import json
import os
import signal
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

from piston_cosim.master.runs import kernels

from .. import command
from ..command import ended
from .counter import LOOP, case_text
from .test_resume import compare
from .waiting import wait_for

MORE = """
[variants.other]
"participants.b.parameters.trouble" = {value}
"participants.b.parameters.trouble_at" = {at}
"""


@pytest.fixture
def write_case(folder):
    """Return a function that writes the base case, and a variant with other parameters of `b`."""

    def write(value=0, at=-1):
        text = case_text(LOOP, b="trouble = 0\ntrouble_at = -1\nk = 1.0")
        text = 'beside = ["other"]\n' + text + MORE.format(value=value, at=at)
        (folder / "case.toml").write_text(text)

    return write


def begun(folder, *words, jobs=2, case="case.toml"):
    """Start a run in its own session, so that its processes can be found."""
    run = ("run", case, "--no-plots", "--output", "o", "--jobs", jobs)
    return command.begun(folder, *run, *words, start_new_session=True)


def is_left(process):
    """Whether any process of the session lives."""
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            state, _, _, session, *_ = stat.read_text().rpartition(") ")[2].split()
        except OSError:
            continue
        if int(session) == process.pid and state != "Z":
            return True
    return False


def test_side_by_side_the_bits_are_those_of_one_after_the_other(tmp_path):
    changes = ["--set", "time.stop=4 deg"]
    files = []
    for jobs in (1, 3):
        folder = tmp_path / str(jobs)
        folder.mkdir()
        ended(begun(folder, *changes, jobs=jobs, case="numerical_example"))
        files.append(sorted((folder / "o").glob("*.h5")))
    assert len(files[0]) == len(files[1]) >= 2
    for one, other in zip(*files):
        assert compare(one, other) == []


def test_one_that_dies_leaves_the_results_of_the_other(tmp_path, write_case):
    write_case(value=1, at=3)
    process = begun(tmp_path)
    wait_for((tmp_path / "o/other.h5.partial").exists)
    wait_for((tmp_path / "o/base.h5").exists)
    os.kill(json.loads((tmp_path / "o/other.h5.lock").read_text())["process"], signal.SIGKILL)
    _, errors = ended(process, 1)
    assert "other: the process ended (by SIGKILL)" in errors and "Traceback" not in errors
    assert (tmp_path / "o/base.h5").exists() and not (tmp_path / "o/other.h5").exists()
    wait_for(lambda: not is_left(process))


def test_one_that_stops_is_named(tmp_path, write_case):
    write_case(value=2, at=3)  # its FMU discards all steps
    process = begun(tmp_path)
    _, errors = ended(process, 1)
    told = errors.partition("stopped:")[2]
    assert "other: " in told and "checkpoint" in told and "base: " not in told
    assert (tmp_path / "o/base.h5").exists() and (tmp_path / "o/other.h5.partial").exists()
    wait_for(lambda: not is_left(process))


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_interrupts_all_after_a_checkpoint(tmp_path, write_case, number):
    """As Ctrl-C does, SIGINT goes to all processes of the run."""
    write_case()
    process = begun(tmp_path, "--set", "time.stop=100000 s")
    partial = [tmp_path / f"o/{name}.h5.partial" for name in ("base", "other")]
    wait_for(lambda: all(path.exists() for path in partial))
    time.sleep(1.0)
    os.killpg(process.pid, number) if number == signal.SIGINT else process.send_signal(number)
    _, errors = ended(process, 1)
    for name in ("base", "other"):
        assert f"{name}: interrupted at t = " in errors
        assert (tmp_path / f"o/{name}.h5.checkpoint").exists()
    assert errors.count("stopping after this macro step") == 1
    wait_for(lambda: not is_left(process))


def test_a_second_signal_ends_all_processes(tmp_path, write_case):
    write_case(value=1, at=3)
    process = begun(tmp_path)
    wait_for((tmp_path / "o/base.h5").exists)
    wait_for((tmp_path / "o/other.h5.partial").exists)
    time.sleep(1.0)  # until it hangs
    process.send_signal(signal.SIGTERM)
    time.sleep(0.5)
    assert process.poll() is None
    process.send_signal(signal.SIGTERM)
    _, errors = ended(process, 128 + signal.SIGTERM, 10)
    assert "stopped immediately" in errors
    wait_for(lambda: not is_left(process))


def test_bad_input_of_one_has_its_exit_code(tmp_path, write_case):
    """The results of the other one exist; a run writes the results of this one already."""
    write_case(value=1, at=3)
    first = begun(tmp_path, "--only", "other")
    wait_for((tmp_path / "o/other.h5.partial").exists)
    _, errors = ended(begun(tmp_path), 2)
    assert f"other.h5, written by process {first.pid}" in errors
    assert (tmp_path / "o/base.h5").exists()
    first.kill()
    first.communicate()


def test_a_participant_without_wires_needs_no_rehearsal_of_its_derivative(monkeypatch):
    """Derivatives by nothing have no values that could be joined."""
    calls = []

    class Alone:
        fields, has_derivatives = {}, True

        def __init__(self, name, path):
            pass

        def derivative(self, seeds, products):
            calls.append("derivative")

        def __getattr__(self, name):
            return lambda *arguments: calls.append(name)

    monkeypatch.setattr(kernels, "FmuParticipant", Alone)
    for wires, derivatives in (((), 0), (("h",), 1)):
        calls.clear()
        Alone.fields = {name: SimpleNamespace(shape=(2,)) for name in wires}
        one = kernels.Rehearsal(Path("a.fmu"), "a", {}, 0.0, 1.0, wires, wires)
        kernels._rehearse(lambda told: None, one)
        assert calls == ["start", "step", *["derivative"] * derivatives, "close"]
