"""`piston-cosim results movie`."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ...fmi.errors import BadInput
from ..common import body_skins, console, open_runs, say


def command(
    file: Path,
    *,
    field: Annotated[list[str], Parameter(negative=())] = [],
    frames: int = 90,
    times: float = 50.0,
    case: str | None = None,
    output: Path | None = None,
):
    """Draw a run in motion, by the ending of --output: fields as a moving picture (.gif, .mp4), the
    bodies as an animated model (.glb, glTF), or bodies and films for ParaView (.pvd).

    Pictures show recorded fields at instants evenly chosen among the recorded ones, colours over
    one range for all of them. The model holds every recorded instant; the series is at true scale.

    Example: piston-cosim results movie results/numerical_example/flexible.h5 --field ehd.pressure

    Example: piston-cosim results movie results/numerical_example/flexible.h5 --output piston.glb

    Parameters
    ----------
    file
        Results file.
    field
        Recorded fields, a panel each, participant.variable; by default those of the case's first
        picture of maps.
    frames
        Instants at most, 2 or more; of .glb all.
    times
        How much larger than it is a model (.glb) has deflection, motion across and tilt.
    case
        Case whose folder the paths of meshes start from (.glb, .pvd); default the case named as the
        folder of the results, or the one that comes with the tool and has the title of the run's.
    output
        The file: .gif; .mp4 with the extra "movie" or ffmpeg installed; .glb; .pvd with its files
        in a folder of that name; by default the results' name with .gif.
    """
    from ...results.movie import chosen_instants, write_movie

    described, runs = open_runs((file,))
    ((label, results),) = runs.items()
    target = output or file.with_suffix(".gif")
    if target.suffix in (".glb", ".pvd"):
        from ...engine.sections import special
        from ...engine.stands import side_by_side
        from ...engine.surfaces import films_of
        from ...results.gltf import write_gltf
        from ...results.series import write_series

        if not times > 0:
            raise BadInput(f"--times {times:g}: more than 0")
        chosen = chosen_instants(results, frames)
        solids = special(described, runs, body_skins(runs, case)).solids.get(label, [])
        if len({solid.stand for solid in solids}) < len({solid.owner for solid in solids}):
            say("no wire says where the cylinders stand: they are drawn one beside the other")
            solids = side_by_side(solids)
        target.parent.mkdir(parents=True, exist_ok=True)
        if target.suffix == ".glb":
            write_gltf(solids, results.instants, times, target)
        else:
            write_series(solids, films_of(results, solids, say), results.instants, chosen, target)
    else:
        with console.status("drawing"):
            write_movie(described, results, field, frames, target)
    console.print(f"movie    {target}", highlight=False, soft_wrap=True)
