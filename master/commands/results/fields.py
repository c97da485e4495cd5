"""`piston-cosim results fields`."""

from pathlib import Path

from ...results import fields_export as exports
from ...results.instants import instant, instant_text
from ..common import CsvFile, Moment, Whole, open_run, print_line


def command(
    file: Path,
    /,
    *,
    field: list[str],
    output: CsvFile,
    time: Moment | None = None,
    i: Whole | None = None,
    j: Whole | None = None,
):
    """Write recorded fields as CSV.

    Example: piston-cosim results fields results/numerical_example/flexible.h5 --field ehd.pressure
    --time "18 ms" --output p.csv

    Parameters
    ----------
    file
        Results file.
    field
        Recorded field, PARTICIPANT.VARIABLE; repeatable, a column each.
    output
        File .csv. `results movie` writes fields for ParaView.
    time
        Recorded instant nearest to a time, a crank angle or an extreme, e.g. "18 ms",
        "24 deg" or "max ehd.maximum_pressure". Default: all instants.
    i
        Index in circumferential direction, 1 or more. With --j it selects one grid point.
    j
        Index in axial direction, 1 or more.
    """
    case, results = open_run(file)
    moment = None if time is None else instant(results, time)
    blocks = [exports.chosen(exports.read_block(results, text), moment, i, j) for text in field]
    exports.write_csv(blocks, output, exports.grid_positions(case, results, blocks[0]))
    at = "" if moment is None else f"   t = {instant_text(results, blocks[0].times[0])}"
    print_line(f"fields   {output}{at}")
