"""Every quick figure of `piston-cosim verify master`."""

import numpy as np
import pytest

from piston_cosim.tests.verification.cases.coupling import checks, distances, plain_converges


def test_figures():
    assert [str(check) for check in checks() if not check.passed] == []


def test_plain_iteration_fails_on_the_tube():
    assert plain_converges() == 0


def test_distance_of_a_run_from_a_finer_one():
    fine = {"time": np.linspace(0.0, 4.0, 9), "curves": {"y": 3.0 * np.linspace(0.0, 4.0, 9)}}
    times = np.array([0.0, 1.0, 1.25, 2.75, 4.0])
    run = {"time": times, "curves": {"y": 3.0 * times + np.array([50.0, 2.0, 2.0, -2.0, 2.0])}}
    # what lies before the beginning does not count; the mean is over time, so uneven steps change
    # nothing
    assert distances(run, fine, 1.0)["y"] == pytest.approx((2.0, 2.0))
    run["curves"]["y"] = 3.0 * times + np.array([0.0, 0.0, 0.0, 0.0, 4.0])
    assert distances(run, fine, 1.0)["y"] == pytest.approx((4.0, np.sqrt(16.0 * 1.25 / 2 / 3.0)))
