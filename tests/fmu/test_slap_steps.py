"""Accuracy and cost of slaps by the macro step, in the second revolution of the rigid main job."""

from functools import cache

import numpy as np
import pytest

import piston_cosim as pc


@cache
def revolution(step, tolerance=10.0, halvings=6):
    """Return the thinnest film at each 2 deg of the second revolution [m], and the evaluations.

    step : macro step [deg]; tolerance : of the film thickness, and resolution of impacts [nm].
    """
    changes = {
        "time.step": f"{step} deg",
        "time.stop": "720 deg",
        "wires.0.tolerance": f"{tolerance} nm",
        "wires.1.tolerance": 1e-6 * tolerance,
        "participants.bodies.parameters.impact_resolution": f"{tolerance} nm",
        "coupling.advanced.halvings": halvings,
        "record.fields": [],
    }
    with pc.open_case("numerical_example", changes, "rigid").run() as results:
        film, _, _ = results.series("ehd.minimum_film_thickness")
        degrees = results.time * 36000.0  # 6000 rpm
        grid = np.searchsorted(degrees, np.arange(2.0, 360.0, 2.0) - 1e-4)
        return film[grid], results.summary["residual_evaluations"]


def distance(run, reference):
    """Return the rms and the largest distance of two runs by step and tolerance, over the range."""
    film, other = (revolution(*one)[0] for one in (run, reference))
    apart = np.abs(film - other) / np.ptp(other)
    return np.sqrt(np.mean(apart**2)), apart.max()


@pytest.mark.slow
def test_the_shipped_step_resolves_slaps(tmp_path, monkeypatch):
    """The distance from 0.25 deg is 0.19 % rms and 0.7 % at most, for 9 % more evaluations.

    Without halvings nothing is repeated in parts, and the distance is 1.5 and 7.3 %. The reference
    has a tolerance of 1 nm: that of 10 nm is noise of 0.4 % in steps of 0.25 deg.
    """
    monkeypatch.chdir(tmp_path)
    rms, most = distance((1, 10.0), (0.25, 1.0))
    assert rms <= 0.003 and most <= 0.015
    assert revolution(1)[1] <= 1.15 * revolution(1, halvings=0)[1]


@pytest.mark.slow
def test_order_over_slaps(tmp_path, monkeypatch):
    """The order between 2 and 0.5 deg is 1.9 at a tolerance of 0.1 nm.

    It is 0.6 between 2 and 1 deg and 3.2 between 1 and 0.5 deg: rows fill at an instant.
    """
    monkeypatch.chdir(tmp_path)
    coarse, fine = (distance((step, 0.1), (0.25, 0.1))[0] for step in (2, 0.5))
    assert np.log2(coarse / fine) / 2 >= 1.5
