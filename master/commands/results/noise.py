"""`piston-cosim results noise`."""

from pathlib import Path

import numpy as np

from ...api.bodies import OFFLINE, build_tables
from ...case.contract import players
from ...fmi.errors import BadInput
from ...fmi.tree import import_part
from ..common import case_folder, console, open_runs, say


def command(file: Path, *, case: str | None = None, output: Path | None = None):
    """What the block's outer faces would radiate: power over the crank angle, by frequency and by
    side, as tables and a picture.

    Equivalent radiated power rho c int v_n^2 dA of the last cycle, of the block's elastic motion,
    with radiation efficiency 1 in air: an upper bound at low frequencies, made to compare designs.
    The run must have recorded the modal velocities, evenly.

    Example: piston-cosim results noise results/fired_motorcycle/flexible.h5

    Parameters
    ----------
    file
        Results file of a run with a flexible block.
    case
        Case whose folder the paths of meshes start from; default the case named as the folder of
        the results, or the one that comes with the tool and has the title of the run's.
    output
        Folder for the files; default the folder of the results.
    """
    from ...engine.noise import level, noise, write_noise

    _, runs = open_runs((file,))
    (results,) = runs.values()
    folder = case_folder(results, case)
    tables = build_tables(results.case, players(results.case, "bodies"))
    if not tables:
        raise BadInput(f"{file}: no participant of it is made of bodies")
    for owner, table in tables.items():
        radiation = import_part(OFFLINE).radiation(table, folder, say)
        found = noise(results, owner, radiation)
        mean = float(found.total.mean())
        worst = int(found.total.argmax())
        loudest = 1 + int(found.total_spectrum[1:].argmax())
        console.print(
            f"{owner}: {level(mean):.1f} dB re 1 pW on average ({mean:.3g} W), at most "
            f"{level(found.total[worst]):.1f} dB at {np.degrees(found.angle[worst]):.0f} deg; "
            f"strongest at {found.frequency[loudest]:.0f} Hz, told up to "
            f"{found.frequency[-1]:.0f} Hz",
            highlight=False,
            soft_wrap=True,
        )
        for side, power in found.power.items():
            console.print(
                f"  {side}  {level(float(power.mean())):5.1f} dB from "
                f"{1e4 * radiation.areas[side]:.0f} cm2",
                highlight=False,
                soft_wrap=True,
            )
        name = file.stem if len(tables) == 1 else f"{file.stem}-{owner}"
        for written in write_noise(found, (output or file.parent) / name):
            console.print(f"file  {written}", highlight=False, soft_wrap=True)
