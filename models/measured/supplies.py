"""Compare `plain_bearing` under its assumed oil supplies, in a minute:

python -m piston_cosim.models.measured.supplies
"""

import matplotlib.pyplot as plt
import numpy as np

from piston_cosim.tests.verification.cases.measured import FOLDER, Figure, bands, figures

CASE = FOLDER / "plain_bearing"
SIDES = (2, 4, 6, 10, 20)
"""Pressures at both sides [kPa]."""
SPEEDS = ("250", "650")
"""Lowest and highest speed [rpm]."""


def row(series: list[Figure]) -> str:
    """Return mean and rms of the differences, and the change of pressure with speed by load."""
    differences = np.array([one.difference for one in series])
    by_row = {(one.at["load [N]"], one.at["speed [rpm]"]): one.computed for one in series}
    trends = [
        by_row[load, SPEEDS[1]] / by_row[load, SPEEDS[0]] - 1 for load in ("150", "300", "450")
    ]
    numbers = (differences.mean(), np.sqrt((differences**2).mean()), *trends)
    return " | ".join(f"{number:+.0%}" for number in numbers)


def main() -> None:
    """Print a table of all supplies, and write supplies.png to the folder of the case."""
    heads = "mean difference | rms | 250 to 650 rpm at 150 N | at 300 N | at 450 N"
    print(f"| supply | cavitation model | {heads} |\n|---|---|---|---|---|---|---|")
    results = bands(CASE.name)
    first = next(iter(results.values()))
    measured = [one._replace(computed=one.published) for one in first]
    print(f"| measured | | {row(measured)} |")
    for supply, series in results.items():
        print(f"| {supply} | jfo | {row(series)} |")
    for model in ("reynolds", "gumbel"):
        for supply, series in bands(CASE.name, {"cavitation_model": model}).items():
            print(f"| {supply} | {model} | {row(series)} |")
    for side in SIDES:
        names = ("pressure_lower_edge", "pressure_upper_edge")
        supply = {"conditions": dict.fromkeys(names, f"{side} kPa")}
        print(f"| sides at {side} kPa | jfo | {row(list(figures(CASE.name, None, supply)))} |")
    draw(results)


def draw(results: dict[str, list[Figure]]) -> None:
    """Draw measured pressures and the band over all supplies at each load."""
    figure, panel = plt.subplots(layout="constrained", figsize=(7, 4))
    for load, colour in (("150", "#4f86c0"), ("300", "#1b4f8a"), ("450", "#b5442e")):
        rows = [
            [one for one in series if one.at["load [N]"] == load] for series in results.values()
        ]
        speed = [float(one.at["speed [rpm]"]) for one in rows[0]]
        computed = np.array([[one.computed for one in series] for series in rows])
        panel.fill_between(speed, computed.min(0), computed.max(0), color=colour, alpha=0.35)
        panel.plot(speed, [one.published for one in rows[0]], "o", color=colour, label=f"{load} N")
    panel.set_xlabel("speed [rpm]")
    panel.set_ylabel("highest pressure in the middle [kPa]")
    panel.set_ylim(0.0)
    panel.grid(alpha=0.3)
    title = "points: measured; bands: computed with four supplies"
    figure.legend(title=title, loc="outside upper center", ncols=3)
    figure.savefig(CASE / "supplies.png", dpi=110)


if __name__ == "__main__":
    main()
