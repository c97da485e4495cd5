"""The live page of a run: curves as the run goes on, pause, stop with a checkpoint, on this machine
alone.
"""

import json
import re
import subprocess
import sys
import time
import urllib.error
import urllib.request

import pytest

from piston_cosim.master.results.file import Results

from .counter import case_text, library, make

__all__ = ["library"]
STEPS = 200000  # more than are taken before the page stops the run


def ask(address, method="GET", **headers):
    with answer(address, method, **headers) as answered:
        return answered.read()


def answer(address, method="GET", **headers):
    request = urllib.request.Request(address, method=method, headers=headers)
    return urllib.request.urlopen(request, timeout=20)


def state(address, known="0,0"):
    return json.loads(ask(f"{address}state?{known}"))


@pytest.fixture
def running(tmp_path, library):
    """A run with its page: process and address."""
    for name in "ab":
        make(tmp_path / f"{name}.fmu", library)
    (tmp_path / "case.toml").write_text(case_text([], stop=f"{STEPS} s", step="1 s"))
    command = [sys.executable, "-m", "piston_cosim", "run", "case.toml", "--live", "--no-plots"]
    process = subprocess.Popen(
        command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    assert process.stdout
    address = None
    while not address:
        line = process.stdout.readline()
        assert line, "it ended before it served"
        found = re.search(r"http://127\.0\.0\.1:\d+/\S+/", line)
        address = found and found[0]
    yield process, address
    process.kill()
    process.wait()


def test_curves_pause_and_stop_with_a_checkpoint(running, tmp_path):
    process, address = running
    assert b"canvas" in ask(address)
    end = time.monotonic() + 60
    while not (first := state(address))["rows"]:
        assert time.monotonic() < end
    assert first["names"][:2] == ["iterations", "a.x [1]"] and first["stop"] == STEPS
    row = first["rows"][0]
    assert row[2] == pytest.approx(2.0 ** -row[0], rel=1e-12)  # (1 + H k)^-n with H = k = 1
    ask(f"{address}pause", "POST")
    time.sleep(1.0)
    before = state(address)["time"]
    time.sleep(1.0)
    assert state(address)["time"] == before and state(address)["paused"]
    ask(f"{address}go", "POST")
    while state(address)["time"] == before:
        assert time.monotonic() < end
    ask(f"{address}stop", "POST")
    said, _ = process.communicate(timeout=60)
    assert process.returncode == 1 and "piston-cosim resume" in said
    folder = tmp_path / "results" / tmp_path.name
    assert (folder / "base.h5.checkpoint").exists()
    assert Results(folder / "base.h5.partial").time[-1] > before


def test_nobody_without_the_secret_is_heard(running):
    _, address = running
    root = address.rsplit("/", 2)[0]
    for method, place in (("GET", "/"), ("GET", "/state"), ("POST", "/stop"), ("POST", "/x/stop")):
        with pytest.raises(urllib.error.HTTPError):
            ask(root + place, method)
    with pytest.raises(urllib.error.HTTPError):
        ask(f"{address}explode", "POST")


def test_other_hosts_and_origins_are_rejected_and_the_page_is_sealed(running):
    _, address = running
    port = address.split(":")[2].split("/")[0]
    own = {"Host": f"localhost:{port}", "Origin": f"http://localhost:{port}"}
    with answer(f"{address}pause", "POST", **own) as answered:
        headers = answered.headers
    assert headers["X-Content-Type-Options"] == "nosniff"
    assert "default-src 'none'; script-src 'sha256-" in headers["Content-Security-Policy"]
    for other in ({"Host": "evil.example"}, {"Origin": "http://evil.example"}, {"Origin": "null"}):
        for method, wish in (("GET", "state"), ("POST", "go")):
            with pytest.raises(urllib.error.HTTPError, match="403"):
                ask(address + wish, method, **(own | other))
    assert state(address)["paused"]
