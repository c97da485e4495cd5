"""`piston-cosim results movie`."""

from pathlib import Path

from ...runs.working import working
from ..common import OutputFile, Whole, body_skins, console, open_runs, print_line, say


def command(
    file: Path,
    /,
    *,
    field: list[str] = [],
    frames: Whole = 90,
    case: str | None = None,
    output: OutputFile | None = None,
):
    """Write an animation of a results file.

    The suffix of --output selects the kind: .gif shows fields, and .pvd is a series of bodies and
    films for ParaView.

    Example: piston-cosim results movie results/numerical_example/flexible.h5 --field ehd.pressure

    Example: piston-cosim results movie results/numerical_example/flexible.h5 --output piston.pvd

    Parameters
    ----------
    file
        Results file.
    field
        Recorded field, PARTICIPANT.VARIABLE; repeatable. Default: the fields of the case's first
        map.
    frames
        Maximum number of instants, 2 or more.
    case
        Case whose folder contains the meshes. Default: the case with the name of the results
        folder, then the shipped case with the title of the run.
    output
        File to write. Default: the name of the results file with .gif.
    """
    from ...results.movie import chosen_instants, write_movie

    described, runs = open_runs((file,))
    ((label, results),) = runs.items()
    target = output or file.with_suffix(".gif")
    if target.suffix == ".pvd":
        from ...engine.sections import special
        from ...engine.stands import side_by_side
        from ...engine.surfaces import films_of
        from ...results.series import write_series

        chosen = chosen_instants(results, frames)
        shown = special(described, runs, body_skins(runs, case)).solids.get(label, [])
        solids = [solid for solid in shown if not solid.schematic]
        if len({solid.stand for solid in solids}) < len({solid.owner for solid in solids}):
            say("positions of the cylinders unknown: they are drawn next to each other")
            solids = side_by_side(solids)
        write_series(solids, films_of(results, solids, say), results.instants, chosen, target)
    else:
        with working(console, "drawing frames", frames, typical=0.1):
            write_movie(described, results, field, frames, target)
    print_line(f"movie    {target}")
