# %% [markdown]
# # A first piston
# This notebook runs a rigid piston from the data sheet of an open paper. The film is coarse and
# the run is a short part of the cycle, so it takes seconds. `pc.open_case("data_sheet").run()`
# runs all.

# %%
import numpy as np

import piston_cosim as pc

case = pc.open_case(
    "data_sheet",
    {
        "time.stop": "60 deg",
        "participants.bodies.build.grid": [24, 12],
        "participants.ehd.build.grid": [24, 12],
    },
)
case

# %% [markdown]
# The values of a case are text with units. `changed` returns another case and does not change the
# first one.

# %%
thick = case.changed({"participants.ehd.parameters.viscosity": "12 mPa s"})
case["participants.ehd.parameters.viscosity"], thick["participants.ehd.parameters.viscosity"]

# %%
thin_run = case.run("first_piston/thin.h5")
thick_run = thick.run("first_piston/thick.h5")
{
    name: run.summary["mean_friction_power_w"]
    for name, run in (("thin", thin_run), ("thick", thick_run))
}

# %% [markdown]
# Scalars are arrays in SI units. Pictures accept units, and other runs to draw in the same axes.

# %%
film, unit, meaning = thin_run.series("ehd.minimum_film_thickness")
print(f"{meaning}: {1e6 * film[1:].min():.2f} um")
units = {"ehd.minimum_film_thickness": "um", "bodies.crank_angle": "deg"}
thin_run.plot.lines(
    "ehd.minimum_film_thickness", "ehd.friction_power", units=units, beside={"thick": thick_run}
)

# %%
thin_run.plot.map("bodies.film_thickness", time="5 ms", units={"bodies.film_thickness": "um"})

# %% [markdown]
# The thrust side is the column of the grid at 90 deg from the pin axis:

# %%
field = thin_run.field("bodies.film_thickness", 5e-3)
thrust = field.values[24 // 4]
print(f"t = {1e3 * field.time:.2f} ms, on the thrust line {1e6 * thrust.min():.1f} um at least")
assert np.isfinite(field.values).all()
