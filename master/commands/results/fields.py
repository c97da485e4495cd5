"""`piston-cosim results fields`."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ...case.contract import players
from ...fmi.errors import BadInput
from ...fmi.quantities import to_si
from ...results import fields_export as exports
from ...results.instants import instant
from ..common import console, open_runs


def command(
    file: Path,
    *,
    field: Annotated[list[str], Parameter(negative=())],
    output: Path,
    time: str | None = None,
    i: int | None = None,
    j: int | None = None,
    radius: str | None = None,
    length: str | None = None,
):
    """Write recorded fields as CSV, HDF5 or VTU (for ParaView), by the ending of --output.

    Example: piston-cosim results fields results/numerical_example/flexible.h5 --field ehd.pressure
    --time "18 ms" --output p.csv

    Parameters
    ----------
    file
        Results file.
    field
        participant.field, or a sum (+) or product (*) of recorded fields; several allowed.
    output
        .csv, .h5, or .vtu; of several instants the VTU files lie in a folder beside the .pvd file
        that ParaView opens.
    time
        Only the recorded instant nearest to this time ("18 ms"), crank angle ("24 deg") or extreme
        ("max bodies.side_force").
    i
        Only the grid points at this place around (1-based); with --j one grid point.
    j
        Only the grid points at this height (1-based).
    radius
        Of the cylinder on which a VTU file shows the field; by default the run's bore, 1 m without
        one.
    length
        Of that cylinder; by default the run's skirt, 1 m without one.
    """
    case, runs = open_runs((file,))
    (results,) = runs.values()
    if output.suffix not in (".csv", ".h5", ".vtu") or (output.suffix == ".vtu" and (i or j)):
        raise BadInput(f"--output {output}: write .csv, .h5, or .vtu (whole fields)")
    try:
        size = _size(results.case, radius, length)
    except ValueError as error:
        raise BadInput(str(error)) from None
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
    """Radius and length of the cylinder [m]: as given, else those of the film's participant."""
    films = [tree["participants"][name] for name in players(tree, "lubrication")]
    known = films[0].get("parameters", {}) if films else {}
    given = (radius or known.get("bore_radius"), length or known.get("skirt_length"))
    return [to_si(text or "1 m", "m") for text in given]
