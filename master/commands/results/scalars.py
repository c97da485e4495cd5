"""`piston-cosim results scalars`."""

from pathlib import Path

from fmpy.util import write_csv

from ..common import OutputFile, open_run, tell


def command(file: Path, /, *, output: OutputFile):
    """Write all scalar outputs as CSV.

    Values are in SI units. FMPy and the FMI cross-check read the same format.

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
    write_csv(output, results.structured())
    tell(f"scalars  {output}")
