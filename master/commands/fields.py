"""`piston-cosim fields`."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ..fmi.errors import BadInput
from ..fmi.quantities import to_si
from ..results import fields_export as exports
from ..results.instants import instant
from .common import console, open_runs


def command(
    file: Path,
    *,
    field: Annotated[list[str], Parameter(negative=())],
    output: Path,
    time: str | None = None,
    i: int | None = None,
    j: int | None = None,
    radius: str = "1 m",
    length: str = "1 m",
):
    """Write recorded fields as CSV, HDF5 or VTU (for ParaView), by the ending of --output.

    Example: piston-cosim fields results/numerical_example/flexible.h5 --field ehd.pressure --time
    "18 ms" --output p.csv

    Parameters
    ----------
    file
        Results file.
    field
        participant.field, or a sum (+) or product (*) of recorded fields; several allowed.
    output
        .csv, .h5, or .vtu.
    time
        Only the recorded instant nearest to this time ("18 ms") or crank angle ("24 deg").
    i
        Only the grid points at this place around (1-based); with --j one grid point.
    j
        Only the grid points at this height (1-based).
    radius
        Of the cylinder on which a VTU file shows the field.
    length
        Of that cylinder.
    """
    case, runs = open_runs((file,))
    (results,) = runs.values()
    if output.suffix not in (".csv", ".h5", ".vtu") or (output.suffix == ".vtu" and (i or j)):
        raise BadInput(f"--output {output}: write .csv, .h5, or .vtu (whole fields)")
    try:
        size = [to_si(text, "m") for text in (radius, length)]
    except ValueError as error:
        raise BadInput(str(error)) from None
    moment = None if time is None else instant(results, time)
    blocks = [exports.chosen(exports.read_block(results, text), moment, i, j) for text in field]
    if output.suffix == ".vtu":
        *parts, collection = exports.write_vtu(blocks, output, *size)
        count = f"{len(parts)} file{'s' * (len(parts) > 1)} ({parts[0].name} ...)"
        console.print(f"fields   {collection}, of {count}", highlight=False, soft_wrap=True)
    else:
        write = exports.write_csv if output.suffix == ".csv" else exports.write_hdf5
        port = field[0].partition("+")[0].partition("*")[0].strip()
        write(blocks, output, exports.places(case, results, port, blocks[0]))
        console.print(f"fields   {output}", highlight=False, soft_wrap=True)
