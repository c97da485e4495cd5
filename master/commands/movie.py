"""`piston-cosim movie`."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from .common import console, open_runs


def command(
    file: Path,
    *,
    field: Annotated[list[str], Parameter(negative=())] = [],
    frames: int = 90,
    output: Path | None = None,
):
    """Draw recorded fields of a run as a moving picture, at instants evenly chosen among the
    recorded ones, colours over one range for all of them.

    Example: piston-cosim movie results/numerical_example/flexible.h5 --field ehd.pressure

    Parameters
    ----------
    file
        Results file.
    field
        Recorded fields, a panel each, participant.variable; by default those of the case's first
        picture of maps.
    frames
        Instants at most, 2 or more.
    output
        The file: .gif, or .mp4 where ffmpeg is installed; by default the results' name with .gif.
    """
    from ..results.movie import write_movie

    case, runs = open_runs((file,))
    (results,) = runs.values()
    target = output or file.with_suffix(".gif")
    with console.status("drawing"):
        write_movie(case, results, field, frames, target)
    console.print(f"movie    {target}", highlight=False, soft_wrap=True)
