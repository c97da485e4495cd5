"""Reader of one measured profile: figures, findings, a picture, and a smooth or turned table."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure as Picture

from ..master.fmi.errors import BadInput
from ..master.fmi.preview import Figure, Message
from .dynamics.tables import TableFault, profile_table
from .geometry.profile import MeasuredShape, table_shape
from .preview_picture import (
    COLOURS,
    HEIGHTS,
    LEGEND_POSITION,
    MM,
    SIDES,
    UM,
    draw_developed,
    mark_angles,
)
from .profile_judgement import (
    FEWEST_ANGLES,
    FEWEST_HEIGHTS,
    SMALLEST_FORM,
    SmoothShape,
    covered_share,
    form_of,
    judge_profile,
    place_of,
    smooth_shape,
)

UNITS = np.pi / 180, 1e-3, 1e-6
"""Units of a table that is written: deg, mm, um."""


class ProfileReport(NamedTuple):
    """Figures and messages of a profile, and the sentences of what was changed."""

    figures: list[Figure]
    messages: list[Message]
    changes: list[str]


class Reading(NamedTuple):
    """Units of 1 in a table [rad], [m], [m], its turn [rad], and the ends of the skirt [m].

    Without ends, the skirt is as long as the table. `radius` is its nominal radius [m].
    """

    units: Sequence[float] = UNITS
    turn: float = 0.0
    lower: float | None = None
    upper: float | None = None
    radius: float = np.inf


def read_profile(
    path: Path, reading: Reading, picture: Path, smooth: bool, output: Path | None
) -> ProfileReport:
    """Read a profile of a skirt, judge and draw it, and write the table after all changes.

    Parameters
    ----------
    path : Path
        CSV file, see `tables.profile_table`.
    reading : Reading
    picture : Path
    smooth : bool
        Write the smooth table.
    output : Path, optional
        Table in deg, mm and um.

    Raises
    ------
    BadInput
        If the table cannot be read, or is too small to be smoothed.
    """
    try:
        table = profile_table(path, *reading.units)
    except TableFault as error:
        raise BadInput(str(error)) from None
    shape = _turned(table, reading.turn)
    changes = [f"{np.degrees(reading.turn):g} deg added to all angles"] if reading.turn else []
    ends = float(shape.height[0]), float(shape.height[-1])
    lower = ends[0] if reading.lower is None else reading.lower
    upper = ends[1] if reading.upper is None else reading.upper
    if lower > upper or (lower == upper and shape.height.size > 1):
        raise BadInput(
            f"--skirt-upper: expected more than {MM * lower:g} mm, the lower end, got "
            f"{MM * upper:g} mm"
        )
    smoothed = smooth_shape(shape)
    if smooth and smoothed is None:
        count = f"{shape.height.size} heights and {shape.angle.size} angles"
        raise BadInput(
            f"--smooth: expected {FEWEST_HEIGHTS} heights or {FEWEST_ANGLES} angles, got {count}"
        )
    messages = judge_profile(shape, lower, upper, reading.radius)
    result = shape
    if smooth and smoothed:
        changes += _removed(shape, smoothed)
        result = smoothed.shape
    _draw(shape, result, smoothed, picture)
    if output:
        _write(result, output)
    share = covered_share(shape, lower, upper)
    covered = Figure("table", "covered_share", share, "1", "of the skirt")
    return ProfileReport([*_figures(shape, smoothed), covered], messages, changes)


def _turned(shape: MeasuredShape, turn: float) -> MeasuredShape:
    """Return a shape with `turn` added to its angles, which stay in 0 to 2 pi."""
    if not turn:
        return shape
    angle = (shape.angle + turn) % (2 * np.pi)
    first = int(angle.argmin())
    return replace(shape, angle=np.roll(angle, -first), value=np.roll(shape.value, -first, axis=1))


def _figures(shape: MeasuredShape, smoothed: SmoothShape | None) -> list[Figure]:
    """Return the figures of a table."""
    height, value = shape.height, shape.value
    form = form_of(shape, float(height[0]), float(height[-1]))
    figures = [
        Figure("table", "heights", height.size, "1"),
        Figure("table", "angles", shape.angle.size, "1"),
        Figure("table", "lowest", height[0], "m"),
        Figure("table", "highest", height[-1], "m"),
        Figure("values", "smallest", float(value.min()), "m"),
        Figure("values", "largest", float(value.max()), "m", "positive inwards"),
        Figure("form", "drop_of_the_ends", form.barrel, "m", "mean over the angles"),
    ]
    if form.ovality > SMALLEST_FORM:
        oval = Figure("form", "ovality", form.ovality, "m", "in diameter, mean over the heights")
        figures.append(oval)
        figures.append(Figure("form", "smallest_diameter_at", form.turn, "rad"))
    if smoothed:
        figures.append(Figure("surface", "noise", smoothed.noise, "m", "rms"))
    return figures


def _removed(shape: MeasuredShape, smoothed: SmoothShape) -> list[str]:
    """Return the sentences of what the smoothing did."""
    off = shape.value - smoothed.shape.value
    lines = []
    for grain in smoothed.grains:
        lines.append(f"removed a value {UM * grain.gap:+.3g} um at {place_of(shape, grain)}")
        off[grain.row, grain.column] = 0.0
    row, column = np.unravel_index(np.abs(off).argmax(), off.shape)
    largest = off[row, column]
    around = (
        f"Fourier orders 0 to {smoothed.order} around" if shape.angle.size >= FEWEST_ANGLES else ""
    )
    along = "a smoothing spline along" if shape.height.size >= FEWEST_HEIGHTS else ""
    return [
        *lines,
        f"smoothed by {' and '.join(filter(None, (around, along)))}: changed by "
        f"{UM * smoothed.noise:.3g} um rms, at most {UM * largest:+.3g} um",
    ]


def _write(shape: MeasuredShape, path: Path) -> None:
    """Write a table in deg, mm and um."""
    angle, height, value = UNITS
    lines = ["height," + ",".join(f"{one:.6g}" for one in shape.angle / angle)]
    for at, row in zip(shape.height / height, shape.value / value):
        lines.append(f"{at:.6g}," + ",".join(f"{one:z.4f}" for one in row))
    path.write_text("\n".join(lines) + "\n")


def _draw(
    shape: MeasuredShape, result: MeasuredShape, smoothed: SmoothShape | None, path: Path
) -> None:
    """Draw a table: developed as a film has it, differences, and sections around and along.

    Dots are the values of the table, lines are those of the result between them.
    """
    figure = Picture(figsize=(12, 8))
    FigureCanvasAgg(figure)
    (developed, rest), (around, along) = figure.subplots(2, 2)
    figure.subplots_adjust(0.06, 0.14, 0.98, 0.95, wspace=0.2, hspace=0.35)
    angle = np.arange(120) * (np.pi / 60)
    height = np.linspace(shape.height[0], shape.height[-1] + 1e-9, 61)
    film = table_shape(result, angle, height)
    draw_developed(figure, developed, angle, height, film)
    developed.set(title="distance inside the nominal radius")
    if smoothed:
        off = MeasuredShape(shape.angle, shape.height, shape.value - smoothed.shape.value)
        _differences(figure, rest, off, max(smoothed.noise, 1e-9))
        for grain in smoothed.grains:
            at = np.degrees(shape.angle[grain.column]), MM * shape.height[grain.row]
            rest.plot(*at, "o", ms=14, mfc="none", mec="#d55e00", mew=2)
        rest.set(title=f"difference from a smooth shape, {UM * smoothed.noise:.2g} um rms")
    else:
        rest.set(title="too few values for a smooth shape")
        rest.set_axis_off()
    degrees = np.degrees(shape.angle)
    for share, colour in HEIGHTS.items():
        row = min(int(share * shape.height.size), shape.height.size - 1)
        line = table_shape(result, angle, shape.height[row : row + 1])[:, 0]
        label = f"{MM * shape.height[row]:.3g} mm above the pin"
        around.plot(np.degrees(angle), UM * line, color=colour, label=label)
        around.plot(degrees, UM * shape.value[row], ".", color=colour)
    around.set(title="section around (dots: table)", ylabel="inside the radius [\N{MICRO SIGN}m]")
    mark_angles(around)
    for side, where in SIDES.items():
        line = table_shape(result, np.radians([where]), height)[0]
        along.plot(UM * line, MM * height, color=COLOURS[side], label=side)
        if len(column := np.flatnonzero(np.abs(degrees - where) < 1e-6)):
            dots = UM * shape.value[:, column[0]]
            along.plot(dots, MM * shape.height, ".", color=COLOURS[side])
    along.set(title="section along (dots: table)", xlabel="inside the radius [\N{MICRO SIGN}m]")
    for panel in (developed, rest, along):
        panel.set_ylabel("height above the pin [mm]")
    for panel in (around, along):
        panel.grid(alpha=0.3)
        panel.legend(
            fontsize="small",
            frameon=False,
            ncols=3,
            loc="upper center",
            bbox_to_anchor=LEGEND_POSITION,
        )
    figure.savefig(path, dpi=110 if path.suffix == ".png" else 72)


def _differences(figure: Picture, panel, off: MeasuredShape, noise: float) -> None:
    """Draw the differences of a table's values from a smooth shape, one rectangle for each."""
    degrees = np.append(np.degrees(off.angle), np.degrees(off.angle[0]) + 360.0)
    height, value = MM * off.height, UM * np.hstack([off.value, off.value[:, :1]])
    if height.size == 1:
        height, value = np.append(height, height + 1.0), np.vstack([value, value])
    usual = 5.0 * UM * noise  # grains are far above it
    image = panel.pcolormesh(
        degrees,
        height,
        value,
        cmap="RdBu_r",
        vmin=-usual,
        vmax=usual,
        shading="nearest",
    )
    figure.colorbar(image, ax=panel, label="\N{MICRO SIGN}m", extend="both")
    mark_angles(panel)
