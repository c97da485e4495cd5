"""Make crown_land.csv next to this script: the piston from the skirt's lower edge to the crown.

python -m piston_cosim.models.grooved_skirt.make_profile
"""

from pathlib import Path

import numpy as np

LOWER, UPPER, LAND, CROWN = -45.5, 37.3, 62.14, 74.56
"""Heights above the pin [mm]: edges of the skirt, lower edge of the crown land, crown."""
BARREL = 40.0
"""Barrel of the skirt, as in data_sheet [um]."""
SMALLER = 250.0
"""Radius of the skirt minus that of the land [um]."""


def gap(height: np.ndarray) -> np.ndarray:
    """Return the radial gap [um] at heights [mm]: barrel of the skirt, land, half a wave between.

    Between them are the rings, without a film.
    """
    barrel = BARREL * ((2 * height - LOWER - UPPER) / (UPPER - LOWER)) ** 2  # as Eq. (I6)
    share = np.clip((height - UPPER) / (LAND - UPPER), 0.0, 1.0)
    rising = BARREL + (SMALLER - BARREL) * (1 - np.cos(np.pi * share)) / 2
    return np.where(height <= UPPER, barrel, rising)


if __name__ == "__main__":
    heights = np.linspace(LOWER, CROWN, 117)
    lines = [f"{y:.4f},{value:.4f}" for y, value in zip(heights, gap(heights))]
    text = "height [mm] / angle [deg],0\n" + "\n".join(lines) + "\n"
    (Path(__file__).parent / "crown_land.csv").write_text(text)
