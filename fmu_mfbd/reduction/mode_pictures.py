"""Pictures of a body: mode shapes on its surface, and cells with a skirt."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib import colormaps
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from ..geometry.grid import cell_centres
from .mode_tables import ModeRow
from .reduced_body import Anatomy

COLUMNS, ROWS = 4, 3
DRAWN_DISPLACEMENT = 0.08  # displacement drawn, of the body's size
LIGHT = np.array([0.6, 0.75, 0.28])


def draw_modes(anatomy: Anatomy, table: Sequence[ModeRow], path: Path | str) -> None:
    """Write a PNG of the modes with the largest effect on film thickness, by ascending frequency.

    Red parts move out of the body, blue parts into it. The thrust side is at the front right, the
    pin's axis at the front left, and the head at the top.

    Parameters
    ----------
    anatomy : Anatomy
    table : sequence of ModeRow
        Result of `mode_tables.mode_table` for the body.
    path : Path
    """
    largest = sorted(table, key=lambda row: -row.film_share)[: COLUMNS * ROWS]
    corners = anatomy.skin[:, :3]
    figure = Figure(figsize=(3.2 * COLUMNS, 3.4 * ROWS), layout="constrained")
    for k, row in enumerate(sorted(largest, key=lambda row: row.number)):
        axes = figure.add_subplot(ROWS, COLUMNS, k + 1, projection="3d", proj_type="ortho")
        _draw(axes, anatomy.points, corners, anatomy.shapes[:, :, row.number - 1])
        axes.set_title(
            f"mode {row.number}   {row.frequency / 1e3:.2f} kHz\n"
            f"{row.film_share:.1%} of the film's share",
            fontsize=9,
        )
    figure.savefig(path, dpi=110)


def _draw(axes, points, corners, shape):
    """Draw the deformed surface."""
    size = np.ptp(points, axis=0).max()
    deformed = points + shape * (DRAWN_DISPLACEMENT * size / np.linalg.norm(shape, axis=1).max())
    normal = _normals(deformed[corners])
    outwards = np.einsum("ta,ta->t", shape[corners].mean(axis=1), _normals(points[corners]))
    colour = colormaps["RdBu_r"](0.5 + 0.5 * outwards / np.abs(outwards).max())
    colour[:, :3] *= (0.55 + 0.45 * np.abs(normal @ LIGHT) / np.linalg.norm(LIGHT))[:, None]
    turned = deformed[corners][:, :, [2, 0, 1]]  # y, towards the head, upwards on paper
    axes.add_collection3d(
        Poly3DCollection(turned, facecolors=colour, edgecolors=colour, linewidths=0.2)
    )
    low = turned.reshape(-1, 3).min(axis=0)
    high = turned.reshape(-1, 3).max(axis=0)
    x, y, z = zip(low, high)
    axes.set(xlim=x, ylim=y, zlim=z)
    axes.set_box_aspect(high - low, zoom=1.2)
    axes.view_init(elev=22, azim=40)
    axes.set_axis_off()


def _normals(corner):
    """Return the unit normals of triangles (t, 3, 3)."""
    first, second, third = corner.swapaxes(0, 1)
    normal = np.cross(second - first, third - first)
    return normal / np.linalg.norm(normal, axis=1)[:, None]


def draw_skirt(skirt: np.ndarray, path: Path | str) -> None:
    """Write a PNG of the developed film grid, where cells with a skirt are dark.

    Parameters
    ----------
    skirt : ndarray of bool, shape (angles, rows)
    path : Path
    """
    angles, rows = skirt.shape
    theta, _ = cell_centres(angles, rows, 0.0, 1.0)
    first = np.degrees(theta[0]) - 180.0 / angles
    figure = Figure(figsize=(8, 3), layout="constrained")
    axes = figure.subplots()
    extent = (first, first + 360.0, 0.0, 1.0)
    axes.imshow(skirt.T, origin="lower", aspect="auto", extent=extent, cmap="Greys", vmin=0, vmax=1)
    axes.set_xticks([0, 90, 180, 270], ["0", "90\nthrust", "180", "270\nanti-thrust"])
    axes.set(xlabel="angle from the pin axis [deg]", ylabel="height / film length")
    axes.set_title(f"{skirt.mean():.0%} of the film grid has the skirt under it")
    figure.savefig(path, dpi=110)
