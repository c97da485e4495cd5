"""Phases that take long: what they print, and how signals end them."""

import fcntl
import os
import re
import signal
import subprocess
import sys
import threading
import time
from types import SimpleNamespace

import pytest
from rich.console import Console

from piston_cosim.master.fmi.builder_native import sole_compiler
from piston_cosim.master.fmi.phases import LONGEST_SHARE, UNDER_WAY, Phase, phase
from piston_cosim.master.runs import working as module
from piston_cosim.master.runs.console import Watch
from piston_cosim.master.runs.working import Compilation, working

from ..command import begun, ended

RUN = "run numerical_example --no-plots --output o --only rigid --set".split()
RUN += ["time.stop=1 deg"]


def test_outside_a_terminal_phases_print_a_line_each_period(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(module, "REFRESH_INTERVAL", 0.02)
    monkeypatch.setattr(module, "QUIET_INTERVAL", 0.2)
    monkeypatch.setenv("PISTON_COSIM_CACHE", str(tmp_path))
    with working(Console(force_terminal=False), "preparing", work=2, typical=5.0):
        time.sleep(0.25)
        with phase("reducing", typical=100.0), phase("packing", typical=0.01):
            time.sleep(0.2)
    printed = capsys.readouterr().err
    wanted = r"preparing:  [12] %  \d+ s left\nreducing:  .* s left\npacking:  99 %\n"
    assert re.fullmatch(wanted, printed)  # 0.2 of 10 s; no second line at 4 %
    assert 0.2 < float((tmp_path / "durations/preparing").read_text()) < 0.3


def test_a_line_for_each_tenth_and_for_each_tenth_of_the_kernels():
    states = [(0.11, ""), (0.19, ""), (0.2, ""), (0.99, "compiling: 9 % (1 of about 11 kernels)")]
    states += [(0.99, "compiling: 10 % (11 of about 110 kernels)"), (0.99, "residual 1e-3")]
    bars = [SimpleNamespace(completed=share, fields={"state": text}) for share, text in states]
    tenths = [(1, None), (1, None), (2, None), (9, 0), (9, 1), (9, None)]
    assert [module._tenths(bar) for bar in bars] == tenths


def test_the_expected_time_is_that_of_the_last_phase_of_this_name(tmp_path, monkeypatch):
    monkeypatch.setenv("PISTON_COSIM_CACHE", str(tmp_path))
    with pytest.raises(ValueError), phase("drawing", work=4) as failed:
        raise ValueError
    assert failed.expected == Phase("drawing", work=4).expected == 20.0
    with phase("drawing", work=2, typical=1.0) as last:
        last.begin -= 30.0
        assert last.share == LONGEST_SHARE
    assert Phase("drawing", work=4).expected == pytest.approx(60.0, rel=1e-2)
    assert not UNDER_WAY


def test_the_start_of_a_run_has_the_remaining_time_of_the_last_one(tmp_path, monkeypatch):
    monkeypatch.setenv("PISTON_COSIM_CACHE", str(tmp_path))
    shown = []
    watch = Watch(lambda share, state: shown.append(state))
    watch.start.begin -= 60.0
    watch.tick()
    watch(1e-3, 1.0, SimpleNamespace(iterations=2, history=[0.5]), {})
    Watch(lambda share, state: shown.append(state)).tick()
    assert shown == ["starting", "iterations 2  residual 5e-01", "starting, 60 s left"]


def test_the_share_of_kernels_is_that_of_the_last_complete_compilation(tmp_path, monkeypatch):
    monkeypatch.setenv("PISTON_COSIM_CACHE", str(tmp_path))
    count = SimpleNamespace(value=0)
    monkeypatch.setattr(Compilation, "count", property(lambda self: count.value))
    compilation = Compilation()
    assert compilation.text() == ""
    count.value = module.TYPICAL_KERNELS // 2
    assert "compiling: 50 %" in compilation.text()
    count.value = 4 * module.TYPICAL_KERNELS
    assert "compiling: 99 %" in compilation.text()
    compilation.finish()
    assert Compilation().expected == 4 * module.TYPICAL_KERNELS
    count.value = module.COMPLETE_KERNELS - 1  # most kernels came from the cache
    Compilation().finish()
    assert Compilation().expected == 4 * module.TYPICAL_KERNELS


def test_kernels_are_counted():
    import numba

    compilation = Compilation()
    before = compilation.count
    numba.njit(lambda x: x + 1)(1)
    assert compilation.count == before + 1


def test_waiting_for_another_process_names_it(tmp_path):
    path, said = tmp_path / "film.lock", []
    with open(path, "w") as other:
        other.write("process 123 on there\n")
        other.flush()
        fcntl.flock(other, fcntl.LOCK_EX)
        release = threading.Timer(0.3, fcntl.flock, (other, fcntl.LOCK_UN))
        release.start()
        with sole_compiler(path, "film", said.append):
            release.join()
            assert path.read_text().startswith(f"process {os.getpid()} on ")
    assert said == ["waiting for process 123 on there, which compiles film: 0 s"]
    said.clear()
    with sole_compiler(path, "film", said.append):
        assert said == []


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_ends_a_first_compilation_within_a_second_and_its_cache_is_usable(
    tmp_path, monkeypatch, number
):
    for name in ("PISTON_COSIM_CACHE", "NUMBA_CACHE_DIR"):
        monkeypatch.setenv(name, str(tmp_path / "cache"))
    with begun(tmp_path, *RUN) as process:
        lines = iter(process.stderr.readline, "")
        assert re.search(r"compiling: .* %", next(line for line in lines if "compiling" in line))
        begin = time.monotonic()
        process.send_signal(number)
        assert process.wait(10) == 1
        assert time.monotonic() - begin < 1.0
        assert process.stderr.read().endswith(f"\nstopped: by {number.name}\n")
    assert not list(tmp_path.rglob("*.h5.lock"))
    ended(begun(tmp_path, *RUN))


INTERRUPTED = """
import os, signal, sys

signal.signal(signal.SIGINT, signal.default_int_handler)  # a job in the background ignores it

class Finder:
    def find_spec(self, name, path=None, target=None):
        if name == "piston_cosim.master.commands.app":
            os.kill(os.getpid(), signal.SIGINT)

sys.meta_path.insert(0, Finder())
from piston_cosim.__main__ import main
main()
"""
"""Command line that receives SIGINT while it imports its modules."""


def test_files_of_the_folder_hide_no_module(tmp_path):
    (tmp_path / "math.py").write_text("raise SystemExit('wrong file')")
    command = [sys.executable, "-m", "piston_cosim", "--version"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")


def test_an_interrupted_import_ends_with_a_message():
    ended = subprocess.run([sys.executable, "-c", INTERRUPTED], capture_output=True, text=True)
    assert (ended.returncode, ended.stderr) == (1, "\nstopped: by SIGINT\n")
