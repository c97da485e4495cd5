"""Compare this case with the figures of the source paper: rigid bodies and 20, 40 and 60 modes.

Reads a study of this case and prints its findings. From the study of the modes it also draws the
two pictures of PAPER.md next to this script. From a run it also prints how alike its variants are:

piston-cosim study numerical_example modes
python -m piston_cosim.models.numerical_example.paper results/study_numerical_example_modes
python -m piston_cosim.models.numerical_example.paper results/numerical_example
"""

import csv
import sys
from pathlib import Path
from typing import NamedTuple

import matplotlib.pyplot as plt
import numpy as np

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.engine.peaks import side_peaks
from piston_cosim.master.results.file import Results

SHOWN = {
    "rigid": "rigid",
    "20 modes": "smooth_pressure_modes 20",
    "40 modes": "smooth_pressure_modes 40",
    "60 modes": "smooth_pressure_modes 60",
    "reference": "smooth_pressure_modes 200",
}
"""Name in the pictures -> run of the study."""
COLOURS = ("#b5442e", "#8fb4d9", "#4f86c0", "#1b4f8a", "#000000")
FACES = {"thrust": 90.0, "anti-thrust": 270.0}
"""Angles of the thrust lines [deg]."""


class Findings(NamedTuple):
    """Results of one run that the paper discusses, over the last period.

    Parameters
    ----------
    film : float
        Minimum film thickness [m].
    pressure : float
        Maximum film pressure [Pa].
    friction : float
        Mean friction force on the upstroke [N].
    power : float
        Mean friction power [W].
    bend : float
        Largest opening of the gap on the thrust lines by deflection [m].
    peaks : list of SidePeak
    """

    film: float
    pressure: float
    friction: float
    power: float
    bend: float
    peaks: list


def deflection(results: Results) -> np.ndarray:
    """Return the gap opened by deflection of both bodies, (instants, around, along) [m].

    It is the film thickness minus that of undeformed bodies. The run starts with undeformed,
    concentric bodies, so its first field is clearance and profile. Lateral displacement x and
    tilt b of the piston change the gap of undeformed bodies by -(x - b y) sin(theta).
    """
    port = "bodies.film_thickness"
    profile = results.whole.dataset(port)[0]
    gap = results.dataset(port)[:]
    rows = np.searchsorted(results.time, results.instants - 1e-12)
    x, tilt = (
        results.series(f"bodies.{name}").values[rows]
        for name in ("lateral_displacement", "rocking_angle")
    )
    _, around, along = gap.shape
    length = results.case["participants"]["ehd"]["parameters"]["skirt_length"]
    height = 1e-3 * float(length.split()[0]) * (np.arange(along) + 0.5) / along - 16e-3
    sine = np.sin(2 * np.pi * np.arange(around) / around)
    shift = x[:, None] - tilt[:, None] * height
    return gap - profile + sine[None, :, None] * shift[:, None, :]


def at_whole_steps(results: Results, port: str) -> np.ndarray:
    """Return an output at whole degrees: the parts of steps that repeat slaps are left out.

    The crank speed is constant, so that their mean is that over time.
    """
    degrees = np.degrees(results.crank_angle)
    return results.series(port).values[np.abs(degrees - np.round(degrees)) < 1e-6]


def findings(results: Results) -> Findings:
    """Return the results that the paper discusses."""
    axis = check_case(results.case, results.path).axes_of("ehd.pressure").first
    friction = sum(
        at_whole_steps(results, f"ehd.friction_force_{kind}")
        for kind in ("hydrodynamic", "asperity")
    )
    up = at_whole_steps(results, "bodies.piston_velocity") > 0.0
    bend = deflection(results)
    lines = [int(bend.shape[1] * angle / 360) for angle in FACES.values()]
    return Findings(
        film=results.series("ehd.minimum_film_thickness").values.min(),
        pressure=results.series("ehd.maximum_pressure").values.max(),
        friction=np.abs(friction[up]).mean(),
        power=at_whole_steps(results, "ehd.friction_power")[1:].mean(),
        bend=bend[:, lines].max(),
        peaks=side_peaks(axis, results.dataset("ehd.pressure")[:]),
    )


def table(findings: dict[str, Findings]) -> str:
    """Return the table of the findings in Markdown."""
    heads = [
        "run",
        "thinnest film [um]",
        "highest pressure [MPa]",
        "upstroke friction [N]",
        "friction power [W]",
        "gap opened on the thrust lines [um]",
        *(f"{side}: peak beside the line [deg], above it, share of instants" for side in FACES),
    ]
    lines = [f"| {' | '.join(heads)} |", "|---" * len(heads) + "|"]
    for run, one in findings.items():
        peaks = [
            f"{peak.distance:.0f}, {peak.excess:.0%}, {peak.share:.0%} of {peak.instants}"
            for peak in one.peaks
        ]
        numbers = [
            f"{1e6 * one.film:.2f}",
            f"{1e-6 * one.pressure:.2f}",
            f"{one.friction:.2f}",
            f"{one.power:.1f}",
            f"{1e6 * one.bend:.2f}",
        ]
        lines.append(f"| {' | '.join([run, *numbers, *peaks])} |")
    return "\n".join(lines)


CURVES = {
    "lateral displacement": "bodies.lateral_displacement",
    "tilt": "bodies.rocking_angle",
    "minimum film thickness": "ehd.minimum_film_thickness",
}
"""Head of the table of tendencies -> output."""


def tendency_table(runs: dict[str, Results]) -> str:
    """Return the correlations of each flexible run with `rigid` over the last period in Markdown.

    A correlation of 1 means the same course over the crank angle, apart from size and mean.
    """
    lines = [f"| run | {' | '.join(CURVES)} |", "|---" * (1 + len(CURVES)) + "|"]
    for run, results in runs.items():
        pairs = [
            [at_whole_steps(one, port) for one in (results, runs["rigid"])]
            for port in CURVES.values()
        ]
        cells = [f"{np.corrcoef(*pair)[0, 1]:.2f}" for pair in pairs]
        lines.append(f"| {run} | {' | '.join(cells)} |")
    return "\n".join(lines)


def cost_table(rows: list[dict[str, str]]) -> str:
    """Return the counts of each run over one period in Markdown, as the paper counts them.

    A Jacobian by finite differences over the 2 + 2 n coordinates of both bodies, n modes each,
    costs 2 + 2 n residuals (the paper's way, counted here and not run).
    """
    heads = ["run", "NRES", "NJAC", "derivative products", "NRES by differences"]
    lines = [f"| {' | '.join(heads)} |", "|---" * len(heads) + "|"]
    for row in rows:
        periods = max(int(row.get("periods") or 1), 1)
        sweeps, jacobians, products = (
            float(row[key]) / periods
            for key in ("residual_evaluations", "jacobian_evaluations", "derivative_products")
        )
        last = row["run"].split()[-1]
        coordinates = 2 + 2 * (int(last) if last.isdecimal() else 0)
        whole = sweeps + jacobians * coordinates
        numbers = (sweeps, jacobians, products, whole)
        lines.append(f"| {row['run']} | {' | '.join(f'{number:.0f}' for number in numbers)} |")
    return "\n".join(lines)


def draw_curves(runs: dict[str, Results], path: Path) -> None:
    """Draw motion, film and friction of all runs over the last period."""
    rows = {
        "bodies.lateral_displacement": ("lateral displacement [µm]", 1e6),
        "bodies.rocking_angle": ("tilt [mrad]", 1e3),
        "ehd.minimum_film_thickness": ("thinnest film [µm]", 1e6),
        "ehd.friction_force_hydrodynamic": ("friction on the skirt [N]", 1.0),
    }
    figure, panels = plt.subplots(2, 2, sharex=True, layout="constrained", figsize=(10, 6))
    for panel, (port, (words, factor)) in zip(panels.flat, rows.items()):
        for (label, results), colour in zip(runs.items(), COLOURS):
            angle = np.degrees(results.crank_angle)
            style = ":" if label == "reference" else "-"
            values = factor * results.series(port).values
            panel.plot(angle, values, style, color=colour, lw=1.3, label=label)
        panel.set_ylabel(words)
        panel.grid(alpha=0.3)
        panel.set_xlim(angle[0], angle[-1])
        panel.xaxis.set_major_locator(plt.MultipleLocator(90))
    for panel in panels[1]:
        panel.set_xlabel("crank angle [deg]")
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=5)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def draw_sides(runs: dict[str, Results], path: Path) -> None:
    """Draw pressure, gap and deflection around both sides at the height of the pressure peak."""
    figure, panels = plt.subplots(
        3, 2, sharex="col", sharey="row", layout="constrained", figsize=(10, 8)
    )
    for (label, results), colour in zip(runs.items(), COLOURS):
        pressure = results.dataset("ehd.pressure")[:]
        fields = {
            "pressure [MPa]": 1e-6 * pressure,
            "film thickness [µm]": 1e6 * results.dataset("bodies.film_thickness")[:],
            "gap opened by deflection [µm]": 1e6 * deflection(results),
        }
        angle = 360.0 * np.arange(pressure.shape[1]) / pressure.shape[1]
        for column, (side, line) in enumerate(FACES.items()):
            mine = np.abs(angle - line) <= 85
            on_side = pressure[:, mine]
            instant, _, height = np.unravel_index(on_side.argmax(), on_side.shape)
            for panel, (words, field) in zip(panels[:, column], fields.items()):
                style = ":" if label == "reference" else "-"
                values = field[instant, mine, height]
                panel.plot(angle[mine] - line, values, style, color=colour, lw=1.3, label=label)
                panel.grid(alpha=0.3)
                if not column:
                    panel.set_ylabel(words)
            panels[0, column].set_title(f"{side} side", fontsize="medium")
            panels[2, column].set_xlabel(f"angle from the {side} line [deg]")
            panels[2, column].xaxis.set_major_locator(plt.MultipleLocator(30))
    figure.legend(*panels[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=5)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def main(folder: Path) -> None:
    """Print the tables of a finished study or run; draw the pictures of the study of the modes."""
    if not (folder / "sweep.csv").exists():
        variants = {path.stem: Results(path) for path in sorted(folder.glob("*.h5"))}
        print(table({name: findings(results) for name, results in variants.items()}), end="\n\n")
        print(tendency_table(variants))
        return
    with open(folder / "sweep.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    paths = {row["run"]: folder / row["results"] for row in rows}
    print(table({name: findings(Results(path)) for name, path in paths.items()}), end="\n\n")
    if not {*SHOWN.values()} <= {*paths}:
        return
    print(cost_table(rows))
    runs = {label: Results(paths[run]) for label, run in SHOWN.items()}
    here = Path(__file__).parent
    draw_curves(runs, here / "paper_curves.png")
    draw_sides(runs, here / "paper_sides.png")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
