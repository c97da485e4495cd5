"""Pictures of one or several runs side by side, as the case file describes them. Units converted
here, at the edge.
"""

from itertools import cycle
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402

from ..fmi.quantities import pint_unit, registry, to_si  # noqa: E402

PALETTE = ("#1b4f8a", "#c8553d", "#3a7d44", "#8a6d1b", "#6b4c9a", "#1f8a8a", "#b0458a", "#5b6770")
WINDOW = "#3a7d44"


def draw(case, runs, folder):
    """Draw every picture of the case.

    Parameters
    ----------
    case : Case
    runs : dict of str to Results
        Label -> results, all drawn into the same pictures.
    folder : Path

    Returns
    -------
    list of Path
        The PNG files.
    """
    Path(folder).mkdir(parents=True, exist_ok=True)
    drawn = []
    for picture, figure in figures(case, runs):
        drawn.append(Path(folder) / picture.file)
        figure.savefig(drawn[-1], dpi=130)
    return drawn


def figures(case, runs):
    """Every picture of the case with its figure, one after the other; a figure is closed when the
    next is asked for.
    """
    for picture in case.pictures:
        figure = (
            draw_lines(picture, runs, case.window)
            if picture.kind == "lines"
            else KINDS[picture.kind](picture, runs)
        )
        figure.suptitle(picture.title)
        yield picture, figure
        plt.close(figure)


def scaled(values, unit, wanted):
    """`values` from SI `unit` in the unit the picture asks for, and its label."""
    if not wanted:
        return values, "" if unit == "1" else unit
    quantity = registry().Quantity(1.0, pint_unit(unit))
    return np.asarray(values) * quantity.to(wanted).magnitude, wanted


def labelled(text, unit):
    return f"{text} [{unit}]" if unit else text


def draw_lines(picture, runs, window):
    """One panel per entry of `y`; runs differ in colour, the variables of a panel in line style;
    windows are shaded.
    """
    figure, panels = plt.subplots(
        len(picture.y),
        1,
        sharex=True,
        squeeze=False,
        layout="constrained",
        figsize=(11, 1.2 + 2.3 * len(picture.y)),
    )
    for panel, ports in zip(panels[:, 0], picture.y):
        for colour, (label, results) in zip(cycle(PALETTE), runs.items()):
            x, x_unit, x_text = results.series(picture.x)
            x, x_unit = scaled(x, x_unit, picture.units.get(picture.x))
            for style, port in zip(("-", "--", ":"), ports):
                y, unit, text = results.series(port)
                wanted = picture.units.get(port)
                y, shown = scaled(y, unit, wanted)
                name = (
                    label if len(ports) == 1 else f"{label}, {port.split('.')[1].replace('_', ' ')}"
                )
                panel.plot(x, y, style, color=colour, lw=1.2, label=name)
        _shade(
            panel,
            {
                text.split()[0]: tuple(scaled(to_si(v, unit), unit, wanted)[0] for v in limits)
                for text, limits in window.items()
                if text.split()[1] in ports
            },
        )
        heading = port.split(".")[1].replace("_", " ") if len(ports) == 1 else _common(ports)
        panel.set_ylabel(labelled(heading, shown))
        panel.grid(alpha=0.3)
        panel.margins(x=0)
        panel.legend(fontsize="small", frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    panels[-1, 0].set_xlabel(labelled(picture.x.split(".")[1].replace("_", " "), x_unit))
    return figure


def _shade(panel, windows):
    """The ranges where a curve's lowest, highest, mean or last values are expected; equal ranges
    are shaded once.
    """
    words = {"min": "lowest", "max": "highest", "mean": "mean", "last": "last"}
    for limits in dict.fromkeys(windows.values()):
        kinds = " and ".join(words[kind] for kind, other in windows.items() if other == limits)
        panel.axhspan(
            *limits, color=WINDOW, alpha=0.16, lw=0, label=f"expected for the {kinds} value"
        )


def _common(ports):
    """Longest common beginning of the variables' names, at a word's end."""
    words = [port.split(".")[1].split("_") for port in ports]
    shared = [column[0] for column in zip(*words) if len(set(column)) == 1]
    return " ".join(shared) or ", ".join(port.split(".")[1].replace("_", " ") for port in ports)


def draw_maps(picture, runs):
    """One row per field, one column per run, one colour scale per row; axes are the field's two
    indices as fractions.
    """
    figure, panels = plt.subplots(
        len(picture.fields),
        len(runs),
        squeeze=False,
        layout="constrained",
        figsize=(1.5 + 4.6 * len(runs), 1 + 3.1 * len(picture.fields)),
    )
    instant = to_si(picture.time, "s")
    for row, port in zip(panels, picture.fields):
        found = [results.field(port, instant) for results in runs.values()]
        images = [scaled(f[0], f[2], picture.units.get(port)) for f in found]
        low, high = min(i.min() for i, _ in images), max(i.max() for i, _ in images)
        for panel, label, (image, unit), (_, time, _, _) in zip(row, runs, images, found):
            shown = panel.imshow(
                image.T,
                origin="lower",
                aspect="auto",
                extent=(0, 360, 0, 1),
                vmin=low,
                vmax=high,
                cmap="viridis",
                interpolation="nearest",
            )
            centres = [(np.arange(n) + 0.5) / n for n in image.shape]
            if low < high:
                panel.contour(
                    360 * centres[0],
                    centres[1],
                    image.T,
                    np.linspace(low, high, 10)[1:-1],
                    colors="white",
                    linewidths=0.4,
                )
            panel.set_title(f"{label}, t = {time * 1e3:.2f} ms", fontsize="medium")
            panel.set_xticks(
                [0, 90, 180, 270, 360], ["0", "90\nthrust", "180", "270\nanti-thrust", "360"]
            )
            panel.set_xlabel("angle from the pin axis [deg]")
            panel.set_ylabel("height / skirt length")
        figure.colorbar(
            shown, ax=list(row), label=labelled(port.split(".")[1].replace("_", " "), unit)
        )
    return figure


def draw_sections(picture, runs):
    """One panel per field, runs in one panel: the field along the circumference at one height and
    instant.
    """
    figure, panels = plt.subplots(
        len(picture.fields),
        1,
        sharex=True,
        squeeze=False,
        layout="constrained",
        figsize=(9, 1.2 + 2.6 * len(picture.fields)),
    )
    instant, span = (
        to_si(picture.time, "s"),
        [np.degrees(to_si(text, "rad")) for text in picture.angles],
    )
    for panel, port in zip(panels[:, 0], picture.fields):
        for colour, (label, results) in zip(cycle(PALETTE), runs.items()):
            values, time, unit, _ = results.field(port, instant)
            line, shown = scaled(
                values[:, min(int(picture.height * values.shape[1]), values.shape[1] - 1)],
                unit,
                picture.units.get(port),
            )
            angle = 360 * (np.arange(line.size) + 0.5) / line.size
            inside = (angle >= span[0]) & (angle <= span[1])
            panel.plot(
                angle[inside],
                line[inside],
                ".-",
                color=colour,
                lw=1.2,
                ms=4,
                label=f"{label}, t = {time * 1e3:.2f} ms",
            )
        panel.set_ylabel(labelled(port.split(".")[1].replace("_", " "), shown))
        panel.grid(alpha=0.3)
    panels[0, 0].legend(fontsize="small", frameon=False)
    panels[-1, 0].set_xlabel("angle from the pin axis [deg]; thrust side 90, anti-thrust side 270")
    return figure


KINDS = {"map": draw_maps, "section": draw_sections}
