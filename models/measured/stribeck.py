"""Draw the Stribeck curves of `sander_2016`, computed and published, in a minute:

python -m piston_cosim.models.measured.stribeck
"""

from pathlib import Path

import matplotlib.pyplot as plt

from piston_cosim.tests.verification.cases.measured import figures

LOADS = {"8000": ("8 kN", "#1b4f8a"), "4000": ("4 kN", "#b5442e")}
PLANES = {"0.6 um": ("-", "contact of summits"), "0 um": (":", "contact at the mean plane")}


def main() -> None:
    """Write stribeck.png to the folder of the case."""
    figure, panel = plt.subplots(layout="constrained", figsize=(7, 4.5))
    for load, (words, colour) in LOADS.items():
        for height, (style, plane) in PLANES.items():
            series = figures("sander_2016", film={"summit_height": height}, load=load)
            torques = [one for one in series if one.quantity == "friction_torque"]
            speeds = [float(one.at["speed [rpm]"]) for one in torques]
            computed = [one.computed for one in torques]
            panel.plot(speeds, computed, style, color=colour, label=f"{words}, {plane}")
        published = [one.published for one in torques]
        panel.plot(speeds, published, "o", color=colour, label=f"{words}, published")
    panel.set_xscale("log")
    panel.set_xticks([150, 200, 300, 500, 1000, 2000, 3000], minor=False)
    panel.xaxis.set_major_formatter("{x:.0f}")
    panel.xaxis.set_minor_formatter("")
    panel.set_xlabel("speed [rpm]")
    panel.set_ylabel("friction torque of three bearings [N m]")
    panel.set_ylim(0.0)
    panel.grid(alpha=0.3, which="both")
    panel.legend()
    figure.savefig(Path(__file__).parent / "sander_2016" / "stribeck.png", dpi=110)


if __name__ == "__main__":
    main()
