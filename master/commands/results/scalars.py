"""`piston-cosim results scalars`."""

import csv
from pathlib import Path

from ..common import CsvFile, open_run, print_line


def command(file: Path, /, *, output: CsvFile):
    """Write all scalar outputs as CSV.

    Values are in SI units. FMPy and the FMI cross-check read the same format. Texts are in quotes.

    Example: piston-cosim results scalars results/numerical_example/flexible.h5
    --output flexible.csv

    Parameters
    ----------
    file
        Results file.
    output
        CSV file: a column `time` and a column for every PARTICIPANT.VARIABLE.
    """
    _, results = open_run(file)
    columns = {port: results.series(port).values for port in (*results.ports, *results.texts)}
    with output.open("w", newline="", encoding="utf-8", errors="surrogateescape") as target:
        rows = csv.writer(target, quoting=csv.QUOTE_NONNUMERIC, lineterminator="\n")
        rows.writerow(["time", *columns])
        rows.writerows(zip(*(values.tolist() for values in (results.time, *columns.values()))))
    print_line(f"scalars  {output}")
