# %% [markdown]
# # A sweep with a response surface
# This notebook shows friction power over clearance and viscosity. It fits a quadratic surface to
# nine short runs, and checks the surface between them.

# %%
import matplotlib.pyplot as plt
import numpy as np

import piston_cosim as pc

case = pc.open_case(
    "data_sheet",
    {
        "time.stop": "20 deg",
        "participants.bodies.build.grid": [16, 8],
        "participants.ehd.build.grid": [16, 8],
        "record.fields": [],
    },
)
CLEARANCE = "participants.bodies.parameters.radial_clearance"
VISCOSITY = "participants.ehd.parameters.viscosity"
vary = {CLEARANCE: ["40 um", "50 um", "60 um"], VISCOSITY: ["4 mPa s", "7 mPa s", "10 mPa s"]}

# %% [markdown]
# Each run is a separate process. A second call finds all runs done. In a script, put the call under
# `if __name__ == "__main__":`.

# %%
if __name__ == "__main__":
    rows = pc.sweep(case, vary, "response_surface", workers=1)
    print([row["status"] for row in rows])

# %%
if __name__ == "__main__":
    clearance, viscosity = (
        np.array([float(row[key].split()[0]) for row in rows]) for key in (CLEARANCE, VISCOSITY)
    )
    power = np.array([row["mean_friction_power_w"] for row in rows])

    def terms(c, v):
        """Return the terms of a quadratic surface about the middle of the points."""
        c, v = (c - 50.0) / 10.0, (v - 7.0) / 3.0
        return np.stack([np.ones_like(c), c, v, c * c, c * v, v * v], axis=-1)

    fit, *_ = np.linalg.lstsq(terms(clearance, viscosity), power, rcond=None)
    off = np.abs(terms(clearance, viscosity) @ fit - power).max() / np.ptp(power)
    print(f"surface and runs differ by {100 * off:.1f} % of the range at most")

# %%
if __name__ == "__main__":
    c, v = np.meshgrid(np.linspace(40, 60, 41), np.linspace(4, 10, 41))
    figure, panel = plt.subplots(figsize=(5.5, 4), layout="constrained")
    drawn = panel.contourf(c, v, terms(c, v) @ fit, 12)
    panel.plot(clearance, viscosity, "k.")
    panel.set(xlabel="radial clearance [um]", ylabel="viscosity [mPa s]")
    figure.colorbar(drawn, label="mean friction power [W]")
    figure.suptitle("Dots: runs")

# %% [markdown]
# One run between the points shows the error of the surface:

# %%
if __name__ == "__main__":
    between = case.changed({CLEARANCE: "45 um", VISCOSITY: "8.5 mPa s"}).run("between.h5")
    said = float(terms(np.float64(45.0), np.float64(8.5)) @ fit)
    print(f"surface {said:.2f} W, run {between.summary['mean_friction_power_w']:.2f} W")
