"""A run with steps by local error: where its steps lie, what refining them does, and that it goes
on with the same bits.
"""

import json

import h5py
import numpy as np
import pytest

from ..command import call

STEP, SMALLEST = 10.0, 10.0 / 64  # deg


def command(folder, *more):
    settings = (
        "time.stop=180 deg",
        f"time.step={STEP} deg",
        "participants.bodies.parameters.ovality=20 um",  # the bounds below were measured so
        "participants.bodies.build.grid=[20,16]",
        "participants.ehd.build.grid=[20,16]",
        *more,
    )
    words = ["run", "numerical_example", "--only", "rigid", "--no-plots", "--output", str(folder)]
    return words + [word for setting in settings for word in ("--set", setting)]


def outcome(file):
    """Times, lateral displacements and summary of a run."""
    with h5py.File(file) as results:
        return (
            results["time"][:],
            results["bodies/lateral_displacement"][:],
            json.loads(results.attrs["summary"]),
        )


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Runs with a local error of 10 nm and of 1 nm, and one in steps of 0.25 deg."""
    folder = tmp_path_factory.mktemp("adaptive")
    for name, setting in (
        ("10", "wires.0.local_error=10 nm"),
        ("1", "wires.0.local_error=1 nm"),
        ("fine", "time.step=0.25 deg"),
    ):
        call(*command(folder / name, setting)).check_returncode()
    return [outcome(folder / name / "rigid.h5") for name in ("10", "1", "fine")]


def test_steps_come_by_where_they_must_and_keep_their_bounds(runs):
    for times, _, summary in runs[:2]:
        degrees = times / times[-1] * 180
        lengths = np.diff(degrees)
        assert np.all(np.abs(degrees[:, None] - np.arange(0, 181, STEP)).min(axis=0) < 1e-9)
        assert (
            lengths.max() < STEP + 1e-9 and lengths.min() > SMALLEST / 2
        )  # cut at most into two at an end
        assert lengths[0] < 1.1 * SMALLEST and summary["steps"] == len(lengths)
        assert summary["inaccurate_smallest_steps"] == 0


def test_a_smaller_local_error_takes_more_steps_and_errs_less(runs):
    coarse, fine, reference = runs
    errors = [np.max(np.abs(x - np.interp(t, *reference[:2]))) for t, x, _ in (coarse, fine)]
    # of second order: ten times less error a step means 10^(1/3) times the steps and 10^(2/3) times
    # less error in all;
    # steps that must end where they must are shorter than the error asks for, more so the longer
    # ones
    assert 1.5 < fine[2]["steps"] / coarse[2]["steps"] < 10 ** (1 / 3)
    assert 2.5 < errors[0] / errors[1] < 10.0
