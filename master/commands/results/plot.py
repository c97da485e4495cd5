"""`piston-cosim results plot`."""

from pathlib import Path

from ..common import Format, OutputFolder, draw_pictures, open_runs


def command(
    *files: Path,
    output: OutputFolder = Path("pictures"),
    format: Format | None = None,
    paper: bool = False,
):
    """Draw the pictures of results files.

    The case of the first file describes the pictures. Several files share each picture.

    Example: piston-cosim results plot results/numerical_example/flexible.h5
    results/numerical_example/rigid.h5

    Parameters
    ----------
    files
        Results files.
    output
        Folder for the pictures.
    format
        Type of the pictures. Default: the suffix of the case's file names, png.
    paper
        Draw for a publication: 179 mm wide, fonts of 8 pt, no title.
    """
    draw_pictures(*open_runs(files), output, format, paper)
