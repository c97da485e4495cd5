"""Make gas_pressure.csv: a cylinder pressure from a Wiebe heat release, not a measurement.

Single zone, constant ratio of specific heats, net heat release (after wall heat losses):
Eq. (U10):  dp/dphi = -kappa p V'/V + (kappa - 1) Q x_b'/V
Eq. (U11):  x_b = 1 - exp(-6.908 s^(m+1)),  s = (phi - phi_0)/duration,
            Wiebe's: 99.9 % burnt at s = 1

They hold from inlet closing to exhaust opening. phi_0 is such that the peak is 10 deg after firing
top dead centre. Blow-down, exhaust and intake follow at constant pressures with smooth transitions.
Crank angle 0 is firing top dead centre. Pressure is gauge.

The script writes gas_pressure.csv next to it, and prints the peak:

python make_gas_pressure.py
"""

from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

BORE, STROKE, ROD = 73.0e-3, 59.5e-3, 108.0e-3  # [m], as in case.toml
COMPRESSION_RATIO = 9.2
KAPPA = 1.32
AMBIENT, INTAKE, EXHAUST = 1.013e5, 0.90e5, 1.10e5  # absolute [Pa]
RELEASED = 570.0  # net heat per cycle [J], see README
DURATION, SHAPE = np.radians(55.0), 2.0
CLOSING, OPENING = np.radians(-140.0), np.radians(130.0)
PEAK = np.radians(10.0)


def volume(angle):
    """Return cylinder volume [m3] and its slope [m3/rad] at a crank angle [rad]."""
    r, area = STROKE / 2, np.pi / 4 * BORE**2
    root = np.sqrt(ROD**2 - (r * np.sin(angle)) ** 2)
    travel = r * (1 - np.cos(angle)) + ROD - root
    slope = r * np.sin(angle) + r**2 * np.sin(angle) * np.cos(angle) / root
    return area * (STROKE / (COMPRESSION_RATIO - 1) + travel), area * slope


def burning(angle, start):
    """Return the rate of burning x_b' [1/rad]."""
    s = (angle - start) / DURATION
    if not 0.0 < s < 1.0:
        return 0.0
    # the derivative of Eq. (U11)
    return 6.908 * (SHAPE + 1) * s**SHAPE * np.exp(-6.908 * s ** (SHAPE + 1)) / DURATION


def closed_cycle(start):
    """Return the absolute pressure [Pa] of the closed cycle, as a function of angle.

    It begins at inlet closing and ends at exhaust opening. `start` is the start of burning [rad].
    """

    def slope(angle, p):
        v, dv = volume(angle)
        return -KAPPA * p * dv / v + (KAPPA - 1) * RELEASED * burning(angle, start) / v  # Eq. (U10)

    solved = solve_ivp(
        slope,
        (CLOSING, OPENING),
        [INTAKE],
        dense_output=True,
        rtol=1e-9,
        atol=1.0,
        max_step=np.radians(0.5),
    )
    return lambda angle: solved.sol(angle)[0]


def peak_angle(start):
    """Return the crank angle of the highest pressure [rad]."""
    angle = np.radians(np.arange(-20.0, 60.0, 0.01))
    return angle[np.argmax(closed_cycle(start)(angle))]


def blend(angle, low, high):
    """Return 0 below `low`, 1 above `high`, with a smooth transition; angles in rad."""
    s = np.clip((angle - low) / (high - low), 0.0, 1.0)
    return s * s * (3 - 2 * s)


def trace(degrees):
    """Return absolute pressure [Pa] at crank angles 0..720 [deg], and start of burning [rad].

    0 is firing top dead centre.
    """
    start = brentq(
        lambda s: peak_angle(s) - PEAK, np.radians(-40.0), np.radians(-5.0), xtol=np.radians(0.01)
    )
    pressure = closed_cycle(start)
    angle = np.radians(degrees)
    wrapped = np.where(degrees > 360.0, angle - 4 * np.pi, angle)  # -360..360
    inside = pressure(np.clip(wrapped, CLOSING, OPENING))
    opened = EXHAUST + (inside - EXHAUST) * (
        1 - blend(wrapped, OPENING, OPENING + np.radians(60.0))
    )
    filling = INTAKE + (EXHAUST - INTAKE) * (
        1 - blend(wrapped, np.radians(-360.0), np.radians(-340.0))
    )
    swapped = np.where(wrapped < 0, filling, opened)
    return np.where((wrapped >= CLOSING) & (wrapped < OPENING), inside, swapped), start


def main():
    degrees = np.arange(0.0, 721.0)
    absolute, start = trace(degrees)
    rows = "".join(f"{d:.0f},{(p - AMBIENT) / 1e6:.6f}\n" for d, p in zip(degrees, absolute))
    path = Path(__file__).parent / "gas_pressure.csv"
    path.write_text("crank angle [deg],gas pressure [MPa gauge]\n" + rows)
    print(
        f"{path.name}: peak {absolute.max() / 1e6:.3f} MPa absolute "
        f"at {degrees[absolute.argmax()]:.0f} deg, burning starts at {np.degrees(start):.1f} deg"
    )


if __name__ == "__main__":
    main()
