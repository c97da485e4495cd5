# %% [markdown]
# # A first piston
# This notebook runs a rigid piston from the data sheet of an open paper over whole cycles, until
# two cycles in a row agree within 1 %. The film and the steps are coarse, so a run takes seconds.
# `pc.open_case("data_sheet").run()` has a finer film and shorter steps.

# %%
import numpy as np

import piston_cosim as pc

case = pc.open_case(
    "data_sheet",
    {
        "time.step": "4 deg",
        "time.stop": "7200 deg",
        "time.until_periodic": 0.01,
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
runs = {"thin": thin_run, "thick": thick_run}
for name, run in runs.items():
    assert run.summary["periodic"]
    print(f"{name}: {run.summary['mean_friction_power_w']:.0f} W. {run.summary['settled']}")

# %% [markdown]
# Scalars are arrays in SI units. They are those of the last cycle, which begins with the intake
# stroke at -360 deg. Pictures accept units, and other runs to draw in the same axes.

# %%
film, unit, meaning = thin_run.series("ehd.minimum_film_thickness")
angle = np.degrees(thin_run.crank_angle)
assert np.ptp(angle) > 719.0
print(f"{meaning}: {1e6 * film.min():.1f} um at {angle[film.argmin()]:.0f} deg")
units = {
    "bodies.crank_angle": "deg",
    "bodies.lateral_displacement": "um",
    "ehd.minimum_film_thickness": "um",
    "ehd.maximum_pressure": "MPa",
}
ports = [
    "bodies.lateral_displacement",
    "ehd.minimum_film_thickness",
    "ehd.maximum_pressure",
    "ehd.friction_power",
]
thin_run.plot.lines(*ports, units=units, beside={"thick": thick_run})

# %% [markdown]
# Maps show recorded fields at one instant, here at the highest pressure of the cycle. Lines are
# contours of the film thickness. The film is ruptured beyond the dashed line.

# %%
fields = {"ehd.pressure": "MPa", "bodies.film_thickness": "um"}
thin_run.plot.map(*fields, time="max ehd.maximum_pressure", units=fields)

# %% [markdown]
# The thrust side is the column of the grid at 90 deg from the pin axis:

# %%
pressure, _, _ = thin_run.series("ehd.maximum_pressure")
field = thin_run.field("bodies.film_thickness", thin_run.time[pressure.argmax()])
thrust = field.values[24 // 4]
print(f"t = {1e3 * field.time:.2f} ms, on the thrust line {1e6 * thrust.min():.1f} um at least")
assert np.isfinite(field.values).all()
