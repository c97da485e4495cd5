"""Icon of the project and of its FMUs: two surfaces, the oil between them, and its pressure.

Run: python docs/icon.py    (writes master/fmi/icon.png)
"""

from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("agg")
import matplotlib.pyplot as plt

SIZE = 128
"""Width and height of the picture [pixels]."""
STEEL, OIL, PRESSURE = "#3b4754", "#e0a526", "#b3261e"


def main():
    figure = plt.figure(figsize=(1, 1), dpi=SIZE)
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set(xlim=(0, 1), ylim=(0, 1))
    axes.axis("off")
    x = np.linspace(0.06, 0.94, 200)
    s = (x - x[0]) / (x[-1] - x[0])
    skirt = 0.40 + 0.16 * (2.0 * s - 0.9) ** 2
    axes.fill_between(x, 0.08, 0.30, color=STEEL)
    axes.fill_between(x, 0.30, skirt, color=OIL)
    axes.fill_between(x, skirt, 0.66, color=STEEL)
    axes.plot(x, 0.70 + 0.95 * s**2 * (1.0 - s), color=PRESSURE, linewidth=3)
    target = Path(__file__).parents[1] / "master" / "fmi" / "icon.png"
    figure.savefig(target, transparent=True, metadata={"Software": None})


if __name__ == "__main__":
    main()
