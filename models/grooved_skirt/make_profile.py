"""Make the shape of the piston from the skirt's lower edge to its crown: crown_land.csv. Writes it
beside this script:

python -m piston_cosim.models.grooved_skirt.make_profile
"""

from pathlib import Path

import numpy as np

LOWER, UPPER, LAND, CROWN = -45.5, 37.3, 62.14, 74.56
"""Heights above the pin [mm]: edges of the skirt, lower edge of the crown land, crown."""
BARREL = 40.0
"""Of the skirt, that of data_sheet [um]."""
SMALLER = 250.0
"""By which the land's radius is smaller than the skirt's largest [um]."""


def gap(height: np.ndarray) -> np.ndarray:
    """Radial gap [um] at heights [mm]: the skirt's barrel, the land, and between them, where rings
    are and no film is, half a wave.
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
