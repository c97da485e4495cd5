# %% [markdown]
# # Use your lubrication model
# The template `models/lubrication_template/axial_film.py` is a complete lubrication FMU of less
# than 60 lines. It solves the Reynolds equation along the axis alone. Here it replaces the film
# of the project under the same piston.

# %%
from pathlib import Path

import piston_cosim as pc

GRID = [16, 8]
case = pc.open_case(
    "data_sheet",
    {
        "time.stop": "30 deg",
        "participants.bodies.build.grid": GRID,
        "participants.ehd.build.grid": GRID,
        "participants.ehd.parameters.roughness_rms": "0 um",
    },
)
template = case.path.parents[1] / "lubrication_template" / "axial_film.py"
print("\n".join(template.read_text().split("\n")[48:]))

# %% [markdown]
# `build_fmu` makes an FMU of the model. The case uses this FMU instead of the shipped one, with
# the parameters of the new model. The case must not record or show outputs that the model does
# not have.

# %%
own = pc.build_fmu(f"{template}:AxialFilm", options={"grid": GRID}, output="axial_film.fmu")
swapped = case.changed(
    {
        "participants.ehd": {
            "fmu": str(Path(own).resolve()),
            "parameters": {
                "bore_radius": "55 mm",
                "skirt_length": "82.8 mm",
                "viscosity": "5.6 mPa s",
            },
        },
        "record.fields": ["bodies.film_thickness", "ehd.pressure"],
        "summary": {},
        "monitor": {},
        "pictures": [],
    }
)

# %%
shipped_run = case.run("own_film/shipped.h5")
own_run = swapped.run("own_film/own.h5")
for name, run in (("shipped", shipped_run), ("own", own_run)):
    film = run.series("ehd.minimum_film_thickness").values
    print(
        f"{name}: thinnest film {1e6 * film.min():.2f} um, "
        f"{run.summary['mean_iterations']:.1f} iterations a step"
    )

# %%
units = {
    "ehd.minimum_film_thickness": "um",
    "bodies.crank_angle": "deg",
    "bodies.lateral_displacement": "um",
}
shipped_run.plot.lines(
    "bodies.lateral_displacement",
    "ehd.minimum_film_thickness",
    units=units,
    beside={"axial film": own_run},
)

# %% [markdown]
# On the command line, `piston-cosim run CASE --lubrication own.fmu` replaces the model.
# `piston-cosim run CASE --lubrication jfo --lubrication own.fmu` compares models.
