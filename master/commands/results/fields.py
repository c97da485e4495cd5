"""`piston-cosim results fields`."""

from pathlib import Path

from ...case.contract import players
from ...fmi.errors import BadInput
from ...fmi.quantities import to_si
from ...results import fields_export as exports
from ...results.instants import instant
from ..common import OutputFile, console, open_runs


def command(
    file: Path,
    /,
    *,
    field: list[str],
    output: OutputFile,
    time: str | None = None,
    i: int | None = None,
    j: int | None = None,
    radius: str | None = None,
    length: str | None = None,
):
    """Write recorded fields as CSV, HDF5 or VTU.

    Example: piston-cosim results fields results/numerical_example/flexible.h5 --field ehd.pressure
    --time "18 ms" --output p.csv

    Parameters
    ----------
    file
        Results file.
    field
        PARTICIPANT.FIELD, or a sum (+) or product of recorded fields; repeatable.
    output
        File .csv, .h5 or .vtu. For several instants the command writes a folder of VTU files and
        the .pvd file that ParaView opens.
    time
        Recorded instant nearest to a time, a crank angle or an extreme, e.g. "18 ms",
        "24 deg" or "max ehd.maximum_pressure". Default: all instants.
    i
        Index in circumferential direction, 1 or more. With --j it selects one grid point.
    j
        Index in axial direction, 1 or more.
    radius
        Radius of the cylinder in a VTU file. Default: the bore radius of the run, else 1 m.
    length
        Length of that cylinder. Default: the skirt length of the run, else 1 m.
    """
    case, runs = open_runs((file,))
    (results,) = runs.values()
    if output.suffix not in (".csv", ".h5", ".vtu") or (output.suffix == ".vtu" and (i or j)):
        raise BadInput(f"--output: expected .csv, .h5 or .vtu of whole fields, got {str(output)!r}")
    try:
        size = _size(results.case, radius, length)
    except ValueError as error:
        raise BadInput(f"--radius, --length: {error}") from None
    moment = None if time is None else instant(results, time)
    blocks = [exports.chosen(exports.read_block(results, text), moment, i, j) for text in field]
    if output.suffix == ".vtu":
        written = exports.write_vtu(blocks, output, *size)
        count = len(blocks[0].times)
        of = f", of {count} instants in {written.with_suffix('')}" if count > 1 else ""
        console.print(f"fields   {written}{of}", highlight=False, soft_wrap=True)
    else:
        write = exports.write_csv if output.suffix == ".csv" else exports.write_hdf5
        port = field[0].partition("+")[0].partition("*")[0].strip()
        write(blocks, output, exports.places(case, results, port, blocks[0]))
        console.print(f"fields   {output}", highlight=False, soft_wrap=True)


def _size(tree, radius, length):
    """Return radius and length of the cylinder [m]; default: those of the film."""
    films = [tree["participants"][name] for name in players(tree, "lubrication")]
    known = films[0].get("parameters", {}) if films else {}
    given = (radius or known.get("bore_radius"), length or known.get("skirt_length"))
    return [to_si(text or "1 m", "m") for text in given]
