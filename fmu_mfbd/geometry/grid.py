"""The regular grid on the developed cylinder (angle x height)."""

import numpy as np


def cell_centres(
    n_circumferential: int, n_axial: int, low: float, high: float
) -> tuple[np.ndarray, np.ndarray]:
    """Angles [rad] from +z towards +x and heights [m] of the film grid's cell centres, shapes
    (n_circumferential,), (n_axial,).
    """
    angle = (np.arange(n_circumferential) + 0.5) * 2 * np.pi / n_circumferential
    height = low + (np.arange(n_axial) + 0.5) * (high - low) / n_axial
    return angle, height
