"""The gas pressure of the fired single."""

import numpy as np

from piston_cosim.models import MODELS

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
