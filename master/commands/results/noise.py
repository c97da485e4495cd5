"""`piston-cosim results noise`."""

from pathlib import Path

import numpy as np

from ...api.bodies import OFFLINE
from ...fmi.tree import import_part
from ..common import OutputFolder, bodies_of, case_folder, say, tell


def command(file: Path, /, *, case: str | None = None, output: OutputFolder | None = None):
    """Compute the sound power that the block radiates.

    The equivalent radiated power is rho c int v_n^2 dA over the block's outer faces in the last
    cycle. Its radiation efficiency is 1, so it is an upper bound at low frequencies. Use it to
    compare designs. The run must record the modal velocities at even intervals.

    Example: piston-cosim results noise results/fired_motorcycle/flexible.h5

    Parameters
    ----------
    file
        Results file of a run with a flexible block.
    case
        Case whose folder contains the meshes. Default: the case with the name of the results
        folder, then the shipped case with the title of the run.
    output
        Folder for tables and picture. Default: the folder of the results.
    """
    from ...engine.noise import level, noise, write_noise

    results, tables = bodies_of(file)
    folder = case_folder(results, case)
    for owner, table in tables.items():
        radiation = import_part(OFFLINE).radiation(table, folder, say)
        found = noise(results, owner, radiation)
        mean = float(found.total.mean())
        worst = int(found.total.argmax())
        loudest = 1 + int(found.total_spectrum[1:].argmax())
        tell(
            f"{owner}: {level(mean):.1f} dB re 1 pW on average ({mean:.3g} W), at most "
            f"{level(found.total[worst]):.1f} dB at {np.degrees(found.angle[worst]):.0f} deg; "
            f"strongest at {found.frequency[loudest]:.0f} Hz, resolved up to "
            f"{found.frequency[-1]:.0f} Hz"
        )
        for side, power in found.power.items():
            tell(
                f"  {side}  {level(float(power.mean())):5.1f} dB from "
                f"{1e4 * radiation.areas[side]:.0f} cm2"
            )
        name = file.stem if len(tables) == 1 else f"{file.stem}-{owner}"
        for written in write_noise(found, (output or file.parent) / name):
            tell(f"file  {written}")
