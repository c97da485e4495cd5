"""The regular grid on the developed cylinder (angle x height)."""

import numpy as np


def cell_centres(
    n_circumferential: int, n_axial: int, low: float, high: float
) -> tuple[np.ndarray, np.ndarray]:
    """Angles [rad] from +z towards +x and heights [m] of the film grid's cell centres, shapes
    (n_circumferential,), (n_axial,).

    Eq. (I10):  theta_i = pi/2 + (i - floor(n/4)) 2 pi/n,   i = 0 .. n - 1

    A cell's centre lies on the thrust line, where the film is thinnest: its neighbours miss it by
    the ovality of half a cell, as much as the roughness.
    """
    cell = 2 * np.pi / n_circumferential
    angle = np.pi / 2 + (np.arange(n_circumferential) - n_circumferential // 4) * cell  # Eq. (I10)
    height = low + (np.arange(n_axial) + 0.5) * (high - low) / n_axial
    return angle, height


def film_rows(skirt_lower: float, skirt_upper: float, grid: tuple[int, int]) -> np.ndarray:
    """Heights of the film grid's rows above A [m], for a skirt between these heights above A."""
    return cell_centres(*grid, skirt_lower, skirt_upper)[1]
