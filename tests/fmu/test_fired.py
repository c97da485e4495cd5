"""The gas pressure of the fired single, and its first strokes with rigid bodies, coarse grid."""

import numpy as np
import pytest

import piston_cosim as pc
from piston_cosim.models import MODELS

from .runs import coarse, values_of

FOLDER = MODELS / "fired_motorcycle"


def test_gas_pressure_peaks_ten_degrees_after_top_dead_centre():
    angle, pressure = np.loadtxt(FOLDER / "gas_pressure.csv", delimiter=",", skiprows=1).T
    assert angle[pressure.argmax()] == 10.0
    assert (angle[0], angle[-1]) == (0.0, 720.0) and pressure[0] == pressure[-1]
    # compression from inlet closing to 680 deg, before any burning: p V^1.32 is constant (file has
    # 1 Pa digits)
    r, rod, ratio = 29.75, 108.0, 9.2
    phi = np.radians(angle)
    volume = (
        2 * r / (ratio - 1) + r * (1 - np.cos(phi)) + rod - np.sqrt(rod**2 - (r * np.sin(phi)) ** 2)
    )
    compressed = (angle >= 600) & (angle <= 680)
    constant = (pressure + 0.1013)[compressed] * volume[compressed] ** 1.32
    assert np.ptp(constant) < 1e-4 * constant.mean()


@pytest.fixture(scope="module")
def fired(tmp_path_factory):
    """Compression and expansion of the first cycle: rigid, 20 x 16 cells, 2 deg."""
    times = [("time.stop", "450 deg"), ("time.step", "2 deg"), ("time.smallest_step", "2 deg")]
    changes = dict(coarse(*times, grid=(20, 16), modes=None))
    case = pc.open_case("fired_motorcycle", changes, "rigid")
    return case.run(tmp_path_factory.mktemp("fired") / "rigid.h5")


def test_side_force_follows_the_gas(fired):
    """The side force after firing is N = (gas force - inertia) tan(rod angle), by statics."""
    ports = ("bodies.crank_angle", "bodies.side_force", "bodies.pin_force_y")
    angle, side, acting = values_of(fired, *ports)
    k = int(np.argmax(side))
    assert 10 < np.degrees(angle[k]) < 45
    rod = np.arcsin(29.75 / 108.0 * np.sin(angle[k]))
    # the pin's force on the piston holds gas and piston inertia; the rod's own mass adds the rest
    # (0.2 kg beside 18 kN of gas)
    assert side[k] == pytest.approx(acting[k] * np.tan(rod), rel=0.1)


def test_film_lies_in_the_published_window(fired):
    assert fired.summary["unconverged_steps"] == 0
    assert 2e-6 < fired.summary["minimum_film_thickness_m"] < 20e-6
