"""`piston-cosim pack`."""

from pathlib import Path

from ..fmi.builder import build_fmu_of_file
from .common import console, parse_grid, say


def command(slave: str, *, grid: str = "40x40", output: Path):
    """Make an FMU of a slave written in one file, e.g. of the template of a lubrication model.

    Example: piston-cosim pack models/lubrication_template/axial_film.py:AxialFilm --output film.fmu

    Parameters
    ----------
    slave
        FILE.py:CLASS.
    grid
        Circumferential x axial cells.
    output
        Where to put the FMU.
    """
    output.write_bytes(build_fmu_of_file(slave, {"grid": parse_grid(grid)}, say).read_bytes())
    console.print(str(output), soft_wrap=True, highlight=False)
