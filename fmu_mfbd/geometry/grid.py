"""Regular grid of angles and heights on the developed cylinder."""

import numpy as np


def cell_centres(
    n_circumferential: int, n_axial: int, low: float, high: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return angles [rad] from +z towards +x and heights [m] of the film grid's cell centres.

    Eq. (I10):  theta_i = pi/2 + (i - floor(n/4)) 2 pi/n,   i = 0 .. n - 1

    The shapes are (n_circumferential,) and (n_axial,). One cell's centre is on the thrust line,
    where the film is thinnest.
    """
    cell = 2 * np.pi / n_circumferential
    angle = np.pi / 2 + (np.arange(n_circumferential) - n_circumferential // 4) * cell  # Eq. (I10)
    height = low + (np.arange(n_axial) + 0.5) * (high - low) / n_axial
    return angle, height


def film_rows(skirt_lower: float, skirt_upper: float, grid: tuple[int, int]) -> np.ndarray:
    """Return the heights of the film grid's rows above A [m], for a skirt between two heights."""
    return cell_centres(*grid, skirt_lower, skirt_upper)[1]
