# %% [markdown]
# # A journal bearing
# `pc.bearing` computes a bearing under a constant load. Values are text with a unit, and the oil
# has a viscosity or a name and a temperature. Each figure has its uncertainty by the grid.

# %%
import matplotlib.pyplot as plt
import numpy as np

import piston_cosim as pc

DESIGN = dict(radius="25 mm", clearance="25 um")
first = pc.bearing(
    **DESIGN, length="25 mm", speed="3000 rpm", load="2 kN", oil="SAE 5W-30 at 90 degC"
)
print(first)
figure = first.plot()
figure

# %% [markdown]
# ## A chart of Raimondi and Boyd
# The Sommerfeld number $S = \mu N D L / W \, (R/C)^2$ and the length over the diameter determine
# the position of the journal. The points are from the table that Raimondi and Boyd published in
# 1958. The default oil supply is theirs: the film begins full where it is thickest.

# %%
NUMBERS = np.geomspace(0.04, 2.0, 6)
PUBLISHED = {  # length over diameter -> eccentricity ratios, Sommerfeld numbers, attitude angles
    1.0: ((0.4, 0.6, 0.8), (0.264, 0.121, 0.0446), (63.10, 50.58, 36.24)),
    0.5: ((0.4, 0.6, 0.8), (0.779, 0.319, 0.0923), (61.45, 48.14, 33.31)),
}


def at_number(number, ratio):
    """Return the bearing of a Sommerfeld number and a length over the diameter."""
    # S = mu N D L / W (R/C)^2 with mu = 10 mPa s, N = 50 1/s, D = 50 mm, R/C = 1000
    load = 0.01 * 50.0 * 0.05 * (0.05 * ratio) / number * 1e6
    length = f"{50 * ratio} mm"
    return pc.bearing(
        **DESIGN, length=length, speed="3000 rpm", load=f"{load:.12g} N", oil="10 mPa s"
    )


figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
for (ratio, (eccentricities, numbers, attitudes)), colour in zip(
    PUBLISHED.items(), ("#1b4f8a", "#b5442e")
):
    bearings = [at_number(number, ratio) for number in NUMBERS]
    assert np.allclose([one.sommerfeld_number for one in bearings], NUMBERS)
    label = f"L/D = {ratio:g}"
    left.plot(NUMBERS, [one.eccentricity_ratio for one in bearings], color=colour, label=label)
    left.plot(numbers, eccentricities, "o", color=colour)
    angles = [np.degrees(one.attitude_angle) for one in bearings]
    right.plot(NUMBERS, angles, color=colour, label=label)
    right.plot(numbers, attitudes, "o", color=colour)
    at_the_point = at_number(numbers[1], ratio)
    assert abs(at_the_point.eccentricity_ratio - 0.6) < 0.005
    assert abs(np.degrees(at_the_point.attitude_angle) - attitudes[1]) < 1.0
for panel, name in ((left, "eccentricity ratio [-]"), (right, "attitude angle [deg]")):
    panel.set(xscale="log", xlabel="Sommerfeld number S [-]", ylabel=name)
    panel.grid(alpha=0.3, which="both")
left.legend(frameon=False)
figure.suptitle("lines: computed; points: Raimondi and Boyd (1958)")
figure

# %% [markdown]
# ## A Stribeck curve
# Asperities carry a part of the load when the journal is slow. `roughness_rms` and other parameters
# of the film add their contact. Without them, the friction falls with the speed as long as a film
# carries the load.

# %%
SPEEDS = np.geomspace(20, 2000, 8)
ROUGH = dict(roughness_rms="0.3 um", summit_height="0.6 um")


def friction(speed, **surface):
    """Return the friction coefficient at a speed in revolutions per minute, and its uncertainty."""
    one = pc.bearing(
        **DESIGN,
        length="25 mm",
        speed=f"{speed} rpm",
        load="2 kN",
        oil="SAE 5W-30 at 90 degC",
        **surface,
    )
    return one.friction_coefficient, one.uncertainty["friction_coefficient"]


rough = np.array([friction(speed, **ROUGH) for speed in SPEEDS]).T
smooth = np.array([friction(speed) for speed in SPEEDS[3:]]).T
lowest = SPEEDS[rough[0].argmin()]
print(f"lowest friction of the rough bearing at about {lowest:.0f} rpm")
assert rough[0, 0] > 2.0 * rough[0].min() and SPEEDS[0] < lowest < SPEEDS[-1]
assert abs(rough[0, -1] / smooth[0, -1] - 1.0) < 0.02  # no contact at 2000 rpm

# %%
figure, panel = plt.subplots(figsize=(6.5, 3.8), layout="constrained")
panel.errorbar(SPEEDS, *rough, fmt="o-", color="#b5442e", capsize=3, label="rough, 0.3 um rms")
panel.errorbar(SPEEDS[3:], *smooth, fmt="s--", color="#1b4f8a", capsize=3, label="smooth")
panel.set(xscale="log", yscale="log", xlabel="speed [rpm]", ylabel="friction coefficient [-]")
panel.grid(alpha=0.3, which="both")
panel.legend(frameon=False)
figure.suptitle("Stribeck curve of a bearing under 2 kN")
figure
