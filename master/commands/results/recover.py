"""`piston-cosim results recover`."""

from pathlib import Path

from ...api.bodies import OFFLINE
from ...fmi.errors import BadInput
from ...fmi.tree import import_part
from ...results.instants import instant, instant_text
from ..common import Moment, OutputFolder, bodies_of, case_folder, print_line, say

PORT = "{}.modal_coordinate"


def command(
    file: Path,
    /,
    *,
    time: list[Moment],
    case: str | None = None,
    output: OutputFolder | None = None,
):
    """Write displacement and stress of the bodies as VTU.

    The command writes a VTU file per body and instant, on the mesh of the body, for ParaView.

    Example: piston-cosim results recover results/numerical_example/flexible.h5 --time "18 ms"

    Parameters
    ----------
    file
        Results file of a run with flexible bodies.
    time
        Recorded instant nearest to a time, a crank angle or an extreme, e.g. "18 ms",
        "24 deg" or "max ehd.maximum_pressure"; repeatable.
    case
        Case whose folder contains the meshes. Default: the case with the name of the results
        folder, then the shipped case with the title of the run.
    output
        Folder. Default: the folder of the results.
    """
    results, tables = bodies_of(file)
    participant, table = next(iter(tables.items()))
    port = PORT.format(participant)
    if port not in results.recorded:
        raise BadInput(
            f"{file}: expected {port} in record.fields, got none; run the case with modes"
        )
    instants = [instant(results, text) for text in time]
    folder = case_folder(results, case)
    for wanted in instants:
        recorded = results.field(port, wanted)
        begin = (output or file.parent) / f"{file.stem}-{1e6 * recorded.time:.0f}us"
        for body in import_part(OFFLINE).recover(table, folder, recorded.values, begin, say):
            stress = "" if body.largest_stress is None else stress_in_words(body.largest_stress)
            print_line(
                f"{instant_text(results, recorded.time)}  {body.name}: displacement up to "
                f"{1e6 * body.largest_displacement:.4g} \N{MICRO SIGN}m{stress}"
            )
            print_line(f"file  {body.file}")


def stress_in_words(peak) -> str:
    """Return the part of the line about the largest stress, its position and its error."""
    x, y, z = 1e3 * peak.position
    return (
        f", von Mises stress up to {peak.value / 1e6:.4g} MPa at x {x:z.1f}, y {y:z.1f}, "
        f"z {z:z.1f} mm (jump between elements {peak.jump / 1e6:.3g} MPa)"
    )
