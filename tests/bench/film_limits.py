"""Print errors of the film model at its limits, see docs/measurements/limits.md.

1. Starved film: a parabolic skirt reciprocates on a thin layer of oil. The reference has 320 cells.
2. Stepped profile: contact force on lands between grooves. The reference is exact.
3. Shear thinning: load of an inclined pad with one viscosity and with generalised-Newtonian flow.

Run: python tests/bench/film_limits.py
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is loaded

import sys
from pathlib import Path

import numpy as np
from scipy.optimize import brentq, fsolve

sys.path.insert(0, str(Path(__file__).parents[2]))
from piston_cosim.fmu_ehd.model import LubricationModel
from piston_cosim.fmu_ehd.oil import Oil, thinning
from piston_cosim.fmu_ehd.parameters import Parameters

LENGTH = 20e-3
FREQUENCY = 50.0


def reciprocating_load(cells, steps):
    """Return the load of the second revolution of a skirt on a layer of 5.5 um [N/m]."""
    parameters = Parameters(
        (2, cells),
        oil_supply="bore",
        initial_oil_layer=5.5e-6,
        initial_film_fraction=0.5,
        bore_radius=0.5 / np.pi,
        skirt_length=LENGTH,
        stroke=2.0 * LENGTH + 2e-3,
        chamfer_capacity=1e-7,
    )
    model = LubricationModel(parameters)
    y = (np.arange(cells) + 0.5) / cells
    film = np.broadcast_to(8e-6 + 20e-6 * (2.0 * y - 1.0) ** 2, (2, cells)).copy()
    state, _ = model.start(film, np.zeros((2, cells)))
    load = []
    for k in range(1, 2 * steps + 1):
        speed = -LENGTH * 2.0 * np.pi * FREQUENCY * np.sin(2.0 * np.pi * k / steps)
        velocity = np.full((2, cells), speed)
        state, out = model.advance(state, film, velocity, 1.0 / FREQUENCY / steps)
        load.append(out["nodal_pressure_force"].sum())
    return np.array(load[steps:])


def land_contact(cells, land=0.5e-6, groove=10e-6):
    """Return the mean contact pressure over lands and grooves of 4 of 40 units each [Pa]."""
    unit = np.floor((np.arange(cells) + 0.5) / cells * 40.0)
    film = np.broadcast_to(np.where(unit % 8 < 4, land, land + groove), (4, cells)).copy()
    model = LubricationModel(Parameters((4, cells), roughness_rms=1e-6))
    _, out = model.start(film, np.zeros((4, cells)))
    return out["asperity_pressure"].mean()


def pad_loads(high_shear_ratio, speed, cells=60, inlet=4e-6, outlet=2e-6, length=10e-3):
    """Return the load of an inclined pad by one viscosity and by generalised-Newtonian flow [N/m].

    The isotropic viscosity is that of the shear rate speed / h. The generalised-Newtonian flow
    solves mu(u') u' = p' z + tau for the pressure gradient and the stress at each section.
    """
    oil = Oil(shear_thinning_law="cross_1965", high_shear_ratio=high_shear_ratio)
    temperature = 373.15

    def viscosity(rate):
        return oil.viscosity * thinning(oil.thinning, np.abs(rate), temperature)[0]

    x = np.linspace(0.0, 1.0, cells + 1)
    h = inlet + (outlet - inlet) * x
    nodes, weights = np.polynomial.legendre.leggauss(16)
    z = (nodes + 1.0) / 2.0
    weights = weights / 2.0

    def isotropic(flow):
        return 12.0 * viscosity(speed / h) * (speed * h / 2.0 - flow) / h**3

    def rates(stress):
        rate = stress / oil.viscosity
        for _ in range(200):  # contracts, because the law's stress rises with the rate
            rate = stress / viscosity(rate)
        return rate

    def gradient(gap, flow):
        def residual(unknowns):
            rate = rates(unknowns[0] * scale * z + unknowns[1] * scale)
            velocity_end = gap * (weights * rate).sum()  # the moving surface is at z = 1
            passed = gap * (speed - gap * (weights * z * rate).sum())
            return velocity_end / speed - 1.0, (passed - flow) / (speed * gap)

        scale = viscosity(speed / gap) * speed / gap
        found = fsolve(residual, (0.0, 1.0))
        return found[0] * scale / gap

    def newtonian_average(flow):
        return np.array([gradient(gap, flow) for gap in h])

    loads = []
    for slope in (isotropic, newtonian_average):
        flow = brentq(
            lambda q, slope=slope: np.trapezoid(slope(q), x), 0.5 * speed * outlet, speed * inlet
        )
        steps = slope(flow)
        pressure = np.append(0.0, np.cumsum((steps[1:] + steps[:-1]) / 2.0 * np.diff(x))) * length
        loads.append(np.trapezoid(pressure, x) * length)
    return loads


def main():
    """Print the three tables."""
    print("starved film, axial cells / steps, mean load, rms over range")
    fine = reciprocating_load(320, 1440)
    for cells, steps in ((40, 360), (80, 360), (160, 360), (160, 720)):
        load = reciprocating_load(cells, steps)
        skip = 1440 // steps
        reference = fine[skip - 1 :: skip]
        rms = np.sqrt(np.mean((load - reference) ** 2)) / np.ptp(reference)
        print(f"{cells:4d} / {steps}  {load.mean() / reference.mean() - 1.0:+8.1%}  {rms:6.1%}")
    print("stepped profile, cells, contact force")
    exact = land_contact(40, groove=0.0) / 2.0
    for cells in (40, 80, 160):
        print(f"{cells:4d}  {land_contact(cells) / exact - 1.0:+8.1%}")
    print("shear thinning, high-shear ratio, speed [m/s], load by one viscosity")
    for ratio in (0.74, 0.5, 0.3):
        for speed in (1.0, 10.0):
            isotropic, exact = pad_loads(ratio, speed)
            print(f"{ratio:.2f} {speed:4.0f}  {isotropic / exact - 1.0:+8.1%}")


if __name__ == "__main__":
    main()
