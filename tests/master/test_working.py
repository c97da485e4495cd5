"""Phases that take long: what they print, and how signals end them."""

import fcntl
import os
import signal
import subprocess
import sys
import threading
import time
from types import SimpleNamespace

import pytest
from rich.console import Console

from piston_cosim.master.fmi.builder_native import sole_compiler
from piston_cosim.master.runs import working as module
from piston_cosim.master.runs.working import Compilation, Phase, working

RUN = [sys.executable, "-m", "piston_cosim", "run", "numerical_example", "--no-plots"]
RUN += ["--only", "rigid", "--set", "time.stop=1 deg"]


def test_outside_a_terminal_a_phase_prints_a_line_each_period(capsys, monkeypatch):
    monkeypatch.setattr(module, "QUIET", 0.1)
    with working(Console(force_terminal=False), "reducing") as phase:
        time.sleep(0.35)
        phase.update("packing")
        time.sleep(0.25)
    lines = capsys.readouterr().err.splitlines()
    assert 4 <= len(lines) <= 6
    assert lines[0].startswith("reducing  0 s") and lines[-1].startswith("packing  ")


def test_the_share_of_kernels_is_that_of_the_last_complete_compilation(tmp_path, monkeypatch):
    monkeypatch.setenv("PISTON_COSIM_CACHE", str(tmp_path))
    count = SimpleNamespace(value=0)
    monkeypatch.setattr(Compilation, "count", property(lambda self: count.value))
    phase = Phase("starting")
    assert phase.text() == "starting  0 s"
    count.value = module.TYPICAL // 2
    assert "compiling: 50 %" in phase.text()
    count.value = 4 * module.TYPICAL
    assert "compiling: 99 %" in phase.text()
    phase.compilation.finish()
    assert Compilation().expected == 4 * module.TYPICAL
    count.value = module.COMPLETE - 1  # most kernels came from the cache
    Compilation().finish()
    assert Compilation().expected == 4 * module.TYPICAL


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


@pytest.fixture
def first_start(tmp_path):
    """A command with an empty cache that has begun to compile."""
    folder = str(tmp_path / "cache")
    environment = os.environ | {"PISTON_COSIM_CACHE": folder, "NUMBA_CACHE_DIR": folder}
    process = subprocess.Popen(
        [*RUN, "--output", str(tmp_path / "o")],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        env=environment,
    )
    lines = []
    assert process.stderr
    for line in process.stderr:
        lines.append(line)
        if "compiling: " in line:
            break
    yield process, lines, environment
    process.kill()
    process.communicate()


@pytest.mark.parametrize(
    "number", [signal.SIGTERM, pytest.param(signal.SIGINT, marks=pytest.mark.slow)]
)
def test_a_signal_ends_a_first_compilation_within_a_second(first_start, tmp_path, number):
    process, lines, _ = first_start
    assert "compiling: " in lines[-1] and " %" in lines[-1], lines
    begin = time.monotonic()
    process.send_signal(number)
    assert process.wait(10) == 1
    assert time.monotonic() - begin < 1.0
    assert process.stderr.read().endswith(f"\nstopped: by {number.name}\n")
    assert not list(tmp_path.rglob("*.h5.lock"))


@pytest.mark.slow
def test_the_cache_of_a_stopped_compilation_is_usable(first_start, tmp_path):
    process, _, environment = first_start
    process.terminate()
    process.wait(10)
    again = subprocess.run(
        [*RUN, "--output", str(tmp_path / "o")], capture_output=True, text=True, env=environment
    )
    assert again.returncode == 0, again.stderr
