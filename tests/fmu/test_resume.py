"""Interrupted runs continue in a new process with the same bits.

They do so after SIGINT, and after kill -9 from the last checkpoint.
"""

import os
import signal

import numpy as np
import pytest

from ..command import begun, call, ended
from .runs import datasets
from .waiting import wait_for

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
    one, other = datasets(first), datasets(second)
    return [
        name
        for name, values in one.items()
        if not name.endswith(WORK_COUNTERS) and not np.array_equal(values, other[name])
    ]


def goes_on(words, folder, name, whole, kind=signal.SIGKILL, code=-signal.SIGKILL):
    """Interrupt a run after its first checkpoint and resume it in a new process.

    Assert that the datasets are those of the whole run.
    """
    checkpoint = folder / f"{name}.h5.checkpoint"
    process = begun(folder, *words, folder)
    wait_for(checkpoint.exists, 200)
    os.kill(process.pid, kind)
    ended(process, code)
    assert not (folder / f"{name}.h5").exists()
    ended(begun(folder, "resume", checkpoint))
    assert compare(whole, folder / f"{name}.h5") == []
    assert not checkpoint.exists()


@pytest.mark.parametrize(
    "kind, code",
    [
        (signal.SIGINT, 1),
        pytest.param(signal.SIGTERM, 1, marks=pytest.mark.slow),  # handled as SIGINT is
        (signal.SIGKILL, -signal.SIGKILL),
    ],
)
def test_interrupted_and_resumed_equals_uninterrupted(whole, tmp_path, kind, code):
    goes_on(WORDS, tmp_path, "rigid", whole, kind, code)
