"""A run with steps by local error: where its steps lie, what refining them does, and that it goes
on with the same bits.
"""

import numpy as np
import pytest

import piston_cosim as pc

from .runs import coarse, values_of

STEP, SMALLEST = 10.0, 10.0 / 64  # deg


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Times, lateral displacements and summaries of runs with a local error of 10 nm and of 1 nm,
    and of one in steps of 0.25 deg.
    """
    folder = tmp_path_factory.mktemp("adaptive")
    settings = coarse(
        ("time.stop", "180 deg"),
        ("time.step", f"{STEP} deg"),
        ("participants.bodies.parameters.ovality", "20 um"),  # the bounds below were measured so
        grid=(20, 16),
        modes=None,
    )
    found = []
    for key, value in (
        ("wires.0.local_error", "10 nm"),
        ("wires.0.local_error", "1 nm"),
        ("time.step", "0.25 deg"),
    ):
        case = pc.open_case("numerical_example", dict(settings) | {key: value}, "rigid")
        results = case.run(folder / f"{len(found)}.h5")
        lateral = values_of(results, "bodies.lateral_displacement")
        found.append((results.time, lateral, results.summary))
    return found


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
