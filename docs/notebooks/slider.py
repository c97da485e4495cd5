# %% [markdown]
# # A slider with plain arrays
# `pc.Film` is the film alone. It takes film thickness and velocity and returns pressure and forces.
# The load of an inclined pad has a closed form. The film thickness falls along the pad,
# $h = h_0 (1 + K (1 - y/L))$, and the load per width is
# $W = 6 \mu U (L/h_0)^2 \left(\ln(1 + K) - 2 K/(2 + K)\right) / K^2$.

# %%
import matplotlib.pyplot as plt
import numpy as np

import piston_cosim as pc

LENGTH, RADIUS, VISCOSITY, SPEED, LEAST = 27e-3, 28.25e-3, 0.02, 8.0, 10e-6


def pad(cells, ratio=1.0):
    """Return height and pressure along an inclined pad, and its load per width."""
    film = pc.Film((4, cells), bore_radius=RADIUS, skirt_length=LENGTH, viscosity=VISCOSITY)
    y = (np.arange(cells) + 0.5) / cells
    thickness = np.broadcast_to(LEAST * (1.0 + ratio * (1.0 - y)), (4, cells))
    film.start(thickness, sliding_velocity=-SPEED)
    # nothing moves apart: the film is steady at once
    outputs = film.step(thickness, 1e-3, sliding_velocity=-SPEED)
    return y, outputs["pressure"][0], outputs["nodal_pressure_force"].sum() / (2 * np.pi * RADIUS)


def exact(ratio=1.0):
    """Return the load per width in closed form."""
    scale = 6 * VISCOSITY * SPEED * (LENGTH / LEAST) ** 2
    return scale * (np.log(1 + ratio) - 2 * ratio / (2 + ratio)) / ratio**2


# %%
cells = [20, 40, 80, 160]
errors = [abs(pad(n)[2] / exact() - 1) for n in cells]
orders = np.log2(np.array(errors[:-1]) / errors[1:])
print("errors", [f"{error:.1e}" for error in errors], "orders", np.round(orders, 2))
assert np.allclose(orders, 2.0, atol=0.1)

# %% [markdown]
# The next figure shows the load over the inclination, and the pressure at the maximum load:

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.2), layout="constrained")
ratios = np.linspace(0.3, 3.0, 10)
left.plot(ratios, [pad(60, ratio)[2] / 1e3 for ratio in ratios], "o", label="film")
left.plot(ratios, [exact(ratio) / 1e3 for ratio in ratios], label="closed form")
left.set(xlabel="inclination K [-]", ylabel="load per width [kN/m]")
left.legend(frameon=False)
y, pressure, _ = pad(160, 1.189)
right.plot(1e3 * LENGTH * y, pressure / 1e6)
right.set(xlabel="along the pad [mm]", ylabel="pressure [MPa]")
figure.suptitle("Inclined pad")

# %% [markdown]
# On rough surfaces, asperities carry a part of the load. A film that opens again cavitates. Both
# effects are parameters of the same model, and `pc.Film.parameters()` lists all of them.

# %%
film = pc.Film(
    (4, 40), viscosity="20 mPa s", roughness_rms="0.5 um", flow_factors="patir_cheng_1978"
)
film.start(1e-5, sliding_velocity=0.0)
for thickness in (8e-6, 9e-6, 11e-6):
    outputs = film.step(thickness, 1e-2, sliding_velocity=0.0)
    filled = outputs["film_fraction"].mean()
    print(
        f"h = {1e6 * thickness:.0f} um: {filled:.3f} filled, "
        f"highest pressure {outputs['maximum_pressure'] / 1e3:7.1f} kPa"
    )
