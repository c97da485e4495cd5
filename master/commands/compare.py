"""`piston-cosim compare`."""

from pathlib import Path

from .common import open_runs, print_compared


def command(first: Path, second: Path, /):
    """Compare the main results of two runs.

    The command names what differs between their cases, and prints the difference of each result
    with its uncertainty. Runs with the option `--uncertainty` on equal grids share most of their
    errors, so that smaller differences are distinguishable.

    Example: piston-cosim compare results/numerical_example/flexible.h5
    results/numerical_example/rigid.h5

    Parameters
    ----------
    first
        Results file.
    second
        Results file to compare it with.
    """
    _, runs = open_runs((first, second))
    print_compared(runs)
