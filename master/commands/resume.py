"""`piston-cosim resume`."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ..case.checked import check_case
from ..case.system import open_system
from ..engine.answer import answer
from ..fmi.errors import BadInput
from ..results.file import Results
from ..runs.checkpoint import Checkpoint, check_code
from ..runs.completed import complete_run
from ..runs.console import print_summary, watching
from .common import console, print_answers, print_line, say


def command(checkpoint: Path, /, *, verbose: Annotated[bool, Parameter(negative=())] = False):
    """Continue an interrupted run from its checkpoint.

    The results are bit for bit the results of an uninterrupted run.

    Example: piston-cosim resume results/numerical_example/flexible.h5.checkpoint

    Parameters
    ----------
    checkpoint
        File NAME.h5.checkpoint that the interrupted run wrote.
    verbose
        Also print every period, all counters, the summary of the case and every check.
    """
    if not checkpoint.name.endswith(".h5.checkpoint"):
        raise BadInput(f"CHECKPOINT: expected a file *.h5.checkpoint, got {str(checkpoint)!r}")
    shown = checkpoint.with_suffix("")
    checkpoint = checkpoint.absolute()  # an FMU may change the working directory
    saved = Checkpoint.read(checkpoint)
    output = checkpoint.with_suffix("")
    check_code(saved, say)
    case = check_case(saved.tree, checkpoint)
    system = open_system(case, Path(saved.folder), say)
    log = say if verbose else lambda line: None
    with watching(console, output.stem) as watch:
        summary = complete_run(system, case, saved.tree, output, watch, saved, say=say, log=log)
    if verbose:
        print_summary(console, {output.stem: summary})
    with Results(output) as results:
        print_answers({output.stem: answer(case, results)}, verbose)
    print_line(f"results  {shown}")
