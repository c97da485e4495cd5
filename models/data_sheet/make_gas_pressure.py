"""Gas pressure of the data-sheet engine, which its paper does not tabulate: gas_pressure.csv.

Compression and expansion are polytropes of the slider-crank's volume. A Wiebe function gives the
heat release, as a factor of the polytrope. Pressure is gauge, and 0 deg is firing top dead
centre. Our own choice, which imitates no measured curve.
"""

from pathlib import Path

import numpy as np

CRANK, ROD = 72e-3, 223e-3  # [m], of the paper
COMPRESSION = 16.0  # [-]
EXPONENT = 1.33  # [-]
INTAKE = 1.0e5  # [Pa], absolute
IGNITION, DURATION = -8.0, 60.0  # [deg]
GAIN = 1.9  # factor of combustion on the polytrope [-]


def volume_ratio(degrees):
    """Return the cylinder volume relative to bottom dead centre."""
    angle = np.radians(degrees)
    height = CRANK * np.cos(angle) + np.sqrt(ROD**2 - (CRANK * np.sin(angle)) ** 2)
    below_top = CRANK + ROD - height
    clearance = 2.0 * CRANK / (COMPRESSION - 1.0)
    return (clearance + below_top) / (clearance + 2.0 * CRANK)


def gauge_pressure(degrees):
    """Return the gauge pressure over a cycle, -360 to 360 deg [Pa]."""
    closed = np.abs(degrees) < 180.0
    burnt = 1.0 - np.exp(-5.0 * (np.clip(degrees - IGNITION, 0.0, None) / DURATION) ** 1.5)
    polytrope = INTAKE * volume_ratio(degrees) ** -EXPONENT * (1.0 + GAIN * burnt)
    # valves open: the rest falls to the ambient pressure within 60 deg
    left = gauge_at_opening() * np.exp(-np.clip(degrees - 180.0, 0.0, None) / 20.0)
    return np.where(closed, polytrope - INTAKE, np.where(degrees >= 180.0, left, 0.0))


def gauge_at_opening():
    """Return the gauge pressure when the exhaust valve opens, at bottom dead centre [Pa]."""
    return INTAKE * GAIN


def main():
    degrees = np.arange(-360.0, 361.0, 2.0)
    rows = [f"{a:g},{p * 1e-6:.6g}" for a, p in zip(degrees, gauge_pressure(degrees))]
    text = "\n".join(["crank angle [deg],gauge pressure [MPa]", *rows]) + "\n"
    (Path(__file__).parent / "gas_pressure.csv").write_text(text)


if __name__ == "__main__":
    main()
