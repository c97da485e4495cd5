# %% [markdown]
# # Two toy models coupled by Newton, IQN and Aitken
# A mass on a squeeze film is a model of a piston and its oil with one number each. The force of the
# film opposes the velocity of closing: $f = -c\,\dot h / h^3$. A plain exchange of film and force
# does not converge, because the film damps far more than the mass resists.

# %%
import matplotlib.pyplot as plt
import numpy as np

import piston_cosim as pc

STEP, DAMPING, MASS, LOAD = 1e-4, 2e-12, 1e-3, 0.1


class Film(pc.Slave):
    """f = -c (h - h_before) / (step h^3)."""

    name = "film"

    @staticmethod
    def variables(options):
        return [
            pc.variables.input_variable("thickness", "m", "Film thickness", 1e-5, 1e-5),
            pc.variables.output_variable("force", "N", "Pushes apart", 1.0),
        ]

    def start(self, values):
        return values["thickness"], {"force": 0.0}

    def advance(self, state, values, time, step):
        thickness = values["thickness"]
        return thickness, {"force": -DAMPING * (thickness - state) / step / thickness**3}


class Mass(pc.Slave):
    """m dv/dt = f - load, by the implicit Euler rule."""

    name = "mass"

    @staticmethod
    def variables(options):
        return [
            pc.variables.input_variable("force", "N", "Of the film", 0.0, 1.0),
            pc.variables.output_variable("thickness", "m", "Film thickness", 1e-5),
        ]

    def start(self, values):
        return (1e-5, 0.0), {"thickness": 1e-5}

    def advance(self, state, values, time, step):
        position, velocity = state
        velocity += step / MASS * (values["force"] - LOAD)
        position += step * velocity
        return (position, velocity), {"thickness": position}


def coupled(method, **more):
    """Return the coupled pair with one method."""
    wires = [
        {
            "from": "mass.thickness",
            "to": "film.thickness",
            "tolerance": "1 pm",
            "largest_decrease": 0.3,
        },
        "film.force -> mass.force",
    ]
    return pc.couple(
        {"film": Film, "mass": Mass}, wires, stop="5 ms", step="0.1 ms", method=method, **more
    )


# %% [markdown]
# All methods give the same answer at different cost. The classes have no derivative, so Newton uses
# differences of steps.

# %%
methods = {
    "newton": {},
    "iqn_ils": {"relaxation": 0.01, "max_iterations": 200},
    "aitken": {"relaxation": 0.01, "max_iterations": 200},
}
runs = {m: coupled(m, **more).run(f"coupling/{m}.h5") for m, more in methods.items()}
for method, run in runs.items():
    summary = run.summary
    print(
        f"{method:8s} {summary['mean_iterations']:5.2f} iterations a step, "
        f"{summary['residual_evaluations']:4d} evaluations"
    )

# %%
films = [run.series("mass.thickness").values for run in runs.values()]
assert all(np.allclose(film, films[0], atol=1e-10) for film in films)  # 1 pm a step, 50 steps

# %% [markdown]
# In a plain exchange each side uses the last value of the other side. It fails, and the master
# raises an error instead of returning a wrong answer.

# %%
try:
    coupled("constant", relaxation=1.0, advanced={"halvings": 0}).run("coupling/plain.h5")
except pc.StepFailed as failure:
    print("stopped:", str(failure).splitlines()[0])

# %%
figure, panel = plt.subplots(figsize=(6, 3), layout="constrained")
for method, run in runs.items():
    panel.step(1e3 * run.time[1:], run.series("coupling.iterations").values[1:], label=method)
panel.set(xlabel="time [ms]", ylabel="iterations", ylim=(0, None))
panel.legend(frameon=False)
figure.suptitle("Iterations of a macro step")
