"""Draw pressure and deflection of `freund_1995`, computed and published, in half a minute:

python -m piston_cosim.models.measured.diaphragm
"""

import tomllib

import matplotlib.pyplot as plt
import numpy as np

from piston_cosim.tests.verification.cases.measured import FOLDER, bearing, figures

CASE = FOLDER / "freund_1995"
SHELLS = {"elastic": ("-", "elastic diaphragm"), "rigid": ("--", "rigid shell")}
QUANTITIES = {
    "pressure": ("pressure in the middle [kPa]", 1e3),
    "deflection": ("deflection in the middle [um]", 1e-6),
}


def main() -> None:
    """Write diaphragm.png to the folder of the case."""
    tree = tomllib.loads((CASE / "case.toml").read_text())
    one = tree["bearings"][0]
    points = list(figures(CASE.name, shell="elastic"))
    speed = {"speed [rpm]": points[0].at["speed [rpm]"]}
    fields = {shell: bearing(tree, one, speed | {"shell": shell}).outputs for shell in SHELLS}
    around, along = one["grid"]
    angle = 360.0 / around * np.arange(around)
    figure, panels = plt.subplots(
        2, 2, layout="constrained", figsize=(11, 6), sharex="all", width_ratios=[1, 1.2]
    )
    for (quantity, (label, unit)), (lines, plane) in zip(QUANTITIES.items(), panels):
        for shell, (style, words) in SHELLS.items():
            middle = fields[shell][quantity][:, along // 2] / unit
            lines.plot(angle, middle, style, color="#1b4f8a", label=words)
        published = [point for point in points if point.quantity == quantity]
        lines.plot(
            [float(point.at["angle [deg]"]) for point in published],
            [point.published for point in published],
            "o",
            color="#b5442e",
            label="published",
        )
        lines.set_ylabel(label)
        lines.grid(alpha=0.3)
        field = fields["elastic"][quantity].T / unit
        extent = (-0.5 * angle[1], angle[-1] + 0.5 * angle[1], -100.0, 100.0)
        shown = plane.imshow(field, extent=extent, aspect="auto", origin="lower")
        plane.set_ylabel("height [mm]")
        figure.colorbar(shown, label=label.replace(" in the middle", ""))
    panels[0, 0].legend()
    panels[0, 0].set_xlim(0.0, 240.0)
    panels[0, 0].set_xticks(range(0, 241, 30))
    for panel in panels[1]:
        panel.set_xlabel("angle from the slot [deg]")
    figure.savefig(CASE / "diaphragm.png", dpi=110)


if __name__ == "__main__":
    main()
