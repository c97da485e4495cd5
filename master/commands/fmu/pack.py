"""`piston-cosim fmu pack`."""

from ...api.fmus import build_fmu
from ..common import OutputFile, parse_grid, say, tell


def command(slave: str, /, *, grid: str = "40x40", output: OutputFile):
    """Build an FMU from a single-file model class.

    Example: piston-cosim fmu pack models/lubrication_template/axial_film.py:AxialFilm
    --output film.fmu

    Parameters
    ----------
    slave
        Model class, FILE.py:CLASS.
    grid
        Number of cells, CIRCUMFERENTIALxAXIAL.
    output
        File to write.
    """
    fmu = build_fmu(slave, output=output, options={"grid": parse_grid(grid)}, say=say)
    tell(str(fmu))
