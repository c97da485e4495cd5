"""Interrupted runs go on with the same bits: after SIGINT, and after kill -9 from the last
checkpoint, in a new process.
"""

import os
import signal
import subprocess
import sys
import time

import h5py
import numpy as np
import pytest

from ..command import call

WORDS = ["run", "numerical_example", "--only", "rigid", "--set", "time.stop=60 deg"]
WORDS += ["--set", "record.checkpoint_every=7", "--no-plots", "--output"]
WORK_COUNTERS = ("residual_evaluations", "jacobian_evaluations")
"""Outputs that count work done since the FMU was started; the only ones that a new process may
change.
"""


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole")
    call(*WORDS, folder).check_returncode()
    return folder / "rigid.h5"


def compare(first, second):
    """Names of datasets that differ."""
    different = []
    with h5py.File(first) as a, h5py.File(second) as b:

        def look(name, dataset):
            if (
                isinstance(dataset, h5py.Dataset)
                and not name.endswith(WORK_COUNTERS)
                and not np.array_equal(dataset[:], b[name][:])
            ):
                different.append(name)

        a.visititems(look)
    return different


@pytest.mark.parametrize(
    "kind, code",
    [
        (signal.SIGINT, 1),
        pytest.param(signal.SIGTERM, 1, marks=pytest.mark.slow),  # handled as SIGINT is
        (signal.SIGKILL, -signal.SIGKILL),
    ],
)
def test_interrupted_and_resumed_equals_uninterrupted(whole, tmp_path, kind, code):
    command = [sys.executable, "-m", "piston_cosim", *WORDS, tmp_path]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    checkpoint = tmp_path / "rigid.h5.checkpoint"
    deadline = time.monotonic() + 120
    while not checkpoint.exists() and time.monotonic() < deadline:
        time.sleep(0.002)
    os.kill(process.pid, kind)
    assert process.wait(60) == code, process.stderr.read()
    assert not (tmp_path / "rigid.h5").exists()
    resumed = subprocess.run(
        [sys.executable, "-m", "piston_cosim", "resume", str(checkpoint)],
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert resumed.returncode == 0, resumed.stderr
    assert compare(whole, tmp_path / "rigid.h5") == []
    assert not checkpoint.exists()


def test_no_checkpoint_is_bad_input(tmp_path):
    (tmp_path / "x.h5.checkpoint").write_bytes(b"nonsense")
    for name in ("x.h5.checkpoint", "missing.h5.checkpoint", "x.h5"):
        done = call("resume", tmp_path / name)
        assert done.returncode == 2, done.stderr
