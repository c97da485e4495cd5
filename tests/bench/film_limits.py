"""Print errors of the film model at its limits, see docs/measurements/limits.md.

1. Starved film: a parabolic skirt reciprocates on a thin layer of oil. The reference has 320 cells.
2. Stepped profile: contact force on lands between grooves. The reference is exact.
3. Shear thinning: load of an inclined pad. The reference is the generalised-Newtonian flow.

Run: python tests/bench/film_limits.py
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before numpy is loaded


import numpy as np

from piston_cosim.fmu_ehd.laws.oil import Oil
from piston_cosim.fmu_ehd.parameters import Parameters
from piston_cosim.tests.verification.cases import reciprocating
from piston_cosim.tests.verification.cases.motored import film_after
from piston_cosim.tests.verification.cases.thinned_pad import (
    generalised_newtonian_load,
    isotropic_load,
    model_load,
)

STARVED = ((40, 360), (40, 720), (40, 1440), (80, 360), (160, 360), (160, 720))  # cells, steps


def land_contact(cells, land=0.5e-6, groove=10e-6):
    """Return the mean contact pressure over lands and grooves of 4 of 40 units each [Pa]."""
    unit = np.floor((np.arange(cells) + 0.5) / cells * 40.0)
    film = np.where(unit % 8 < 4, land, land + groove)
    run = film_after(Parameters((4, cells), roughness_rms=1e-6), [film])
    return run.outputs["asperity_pressure"].mean()


def main():
    """Print the three tables."""
    print("starved film, axial cells / steps, mean load, rms over range")
    fine = reciprocating.model_load(320, 1440)
    for cells, steps in STARVED:
        load = reciprocating.model_load(cells, steps)
        skip = 1440 // steps
        reference = fine[skip - 1 :: skip]
        rms = np.sqrt(np.mean((load - reference) ** 2)) / np.ptp(reference)
        print(f"{cells:4d} / {steps}  {load.mean() / reference.mean() - 1.0:+8.1%}  {rms:6.1%}")
    print("stepped profile, cells, contact force")
    exact = land_contact(40, groove=0.0) / 2.0
    for cells in (40, 80, 160):
        print(f"{cells:4d}  {land_contact(cells) / exact - 1.0:+8.1%}")
    print("shear thinning, high-shear ratio, speed [m/s], load by one viscosity, of the model")
    for ratio in (0.74, 0.5, 0.3):
        oil = Oil(shear_thinning_law="cross_1965", high_shear_ratio=ratio)
        for speed in (1.0, 10.0):
            exact = generalised_newtonian_load(oil, speed)
            isotropic = isotropic_load(oil, speed) / exact - 1.0
            load = model_load(oil, speed) / exact - 1.0
            print(f"{ratio:.2f} {speed:4.0f}  {isotropic:+8.2%} {load:+8.2%}")


if __name__ == "__main__":
    main()
