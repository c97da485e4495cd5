"""`piston-cosim fmu pack`."""

from pathlib import Path

from ...api.fmus import build_fmu
from ..common import console, parse_grid, say


def command(slave: str, *, grid: str = "40x40", output: Path):
    """Make an FMU of a slave written in one file, e.g. of the template of a lubrication model.

    Example: piston-cosim fmu pack models/lubrication_template/axial_film.py:AxialFilm
    --output film.fmu

    Parameters
    ----------
    slave
        FILE.py:CLASS.
    grid
        Circumferential x axial cells.
    output
        Where to put the FMU.
    """
    fmu = build_fmu(slave, output=output, options={"grid": parse_grid(grid)}, say=say)
    console.print(str(fmu), soft_wrap=True, highlight=False)
