"""What axial cells are worth in the flexible numerical example: motion, and factorisations of the
film, over the first half turn on 42 x 42, 42 x 82 and 42 x 164 cells.

    python tests/bench/slow/axial_grid.py [KEY=VALUE ...]

Changes of the case as for `piston-cosim run --set`. Some minutes; prints a table.
"""

import sys
import tempfile
from pathlib import Path

import numpy as np

from piston_cosim.master.results.file import Results
from piston_cosim.tests.verification.cases.coupling import run_of

AROUND = 42
AXIAL = (42, 82, 164)
LOOKED_AT = 120  # deg
SHOWN = {"rocking_angle": ("urad", 1e6), "lateral_displacement": ("nm", 1e9)}


def half_turn(folder, axial, changes):
    """Results on so many axial cells."""
    grid = [AROUND, axial]
    ours = [
        ("time.stop", "180 deg"),
        ("record.fields", []),
        ("participants.bodies.build.grid", grid),
        ("participants.ehd.build.grid", grid),
    ]
    output = Path(folder) / f"{axial}.h5"
    run_of("numerical_example", [*ours, *changes], output)
    return Results(output)


def main(arguments):
    changes = [tuple(text.split("=", 1)) for text in arguments]
    with tempfile.TemporaryDirectory() as folder:
        runs = {axial: half_turn(folder, axial, changes) for axial in AXIAL}
        angle = np.degrees(runs[AXIAL[-1]].series("bodies.crank_angle").values)
        print("cells    factorisations of the film   from the finest: rms, largest, at 120 deg")
        for axial, results in runs.items():
            counted = results.series("ehd.solver_iterations").values.sum()
            told = [f"{AROUND} x {axial:3d}  {counted:6.0f}"]
            for name, (unit, scale) in SHOWN.items():
                finest = runs[AXIAL[-1]].series(f"bodies.{name}").values
                apart = scale * (results.series(f"bodies.{name}").values - finest)
                at = np.interp(LOOKED_AT, angle, apart)
                rms = np.sqrt(np.mean(apart**2))
                told.append(f"{name} {rms:.2f}, {np.abs(apart).max():.2f}, {at:.2f} {unit}")
            print("   ".join(told))


if __name__ == "__main__":
    main(sys.argv[1:])
