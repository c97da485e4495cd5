"""`piston-cosim results scalars`."""

from pathlib import Path

from fmpy.util import write_csv

from ..common import console, open_runs


def command(file: Path, *, output: Path):
    """Write all scalar outputs of a run as CSV, in SI, as FMPy and the FMI cross-check read them.

    Example: piston-cosim results scalars results/numerical_example/flexible.h5
    --output flexible.csv

    Parameters
    ----------
    file
        Results file.
    output
        CSV file: "time" and a column for every participant.variable.
    """
    _, runs = open_runs((file,))
    (results,) = runs.values()
    write_csv(output, results.structured())
    console.print(f"scalars  {output}", highlight=False, soft_wrap=True)
