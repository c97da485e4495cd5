"""`piston-cosim results plot`."""

from pathlib import Path
from typing import Literal

from ..common import draw_pictures, open_runs


def command(
    *files: Path,
    output: Path = Path("pictures"),
    format: Literal["png", "svg", "pdf"] | None = None,
):
    """Draw the pictures of one or several results files, side by side, as the first one's case
    describes them.

    Example: piston-cosim results plot results/numerical_example/base.h5
    results/numerical_example/rigid.h5

    Parameters
    ----------
    files
        Results files.
    output
        Folder for the pictures.
    format
        Of the files; what the case's names end with, PNG, without it.
    """
    draw_pictures(*open_runs(files), output, format)
