"""The command line `piston-cosim`; each command is a file of this room. Exit codes: 0 done, 1
failed honestly, 2 bad input.
"""

import gc
import os

# dense algebra here is small: a second BLAS thread costs up to a factor 7
for _threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_threads, "1")
os.environ.setdefault("MPLBACKEND", "Agg")  # pictures are files, also where there is a display

import sys
import time
from contextlib import suppress

from cyclopts import App, CycloptsError
from rich.console import Console

from ..fmi.errors import BadInput, Stopped

STARTED = time.perf_counter()
COMMANDS = {
    "list": "List the cases that come with the tool.",
    "new": "Write a case of an own engine, from a few lengths, a mesh or a STEP file.",
    "keys": "List every key of a case: unit, default, allowed values, meaning.",
    "check": "Look at a case before it runs, or at an FMU beside the contract.",
    "run": "Run a case and its variants: results file, summary, pictures.",
    "resume": "Go on with an interrupted run, with the same bits.",
    "plot": "Draw runs side by side.",
    "movie": "Draw recorded fields of a run as a moving picture.",
    "report": "Write one self-contained HTML page about runs.",
    "scalars": "Write all scalar outputs of a run as CSV.",
    "fields": "Write recorded fields as CSV, HDF5 or VTU.",
    "snapshot": "Write a participant's outputs at an instant, for another run to start from.",
    "compare": "Score curves of runs against one another or against measured ones.",
    "study": "Run a study of a case: cost, and distance from its reference run.",
    "sweep": "Run a case over values of its keys.",
    "reduce": "Reduce bodies from meshes or matrices; their modes as tables and pictures.",
    "recover": "Displacement and stress on the meshes at chosen instants of a run.",
    "noise": "What the block would radiate in a run: power by angle, frequency and side.",
    "build": "Build the FMU of one participant of a case.",
    "info": "Print what an FMU offers.",
    "pack": "Make an FMU of a slave written in one file.",
    "export": "Export a case as one FMU or as an SSP.",
    "verify": "Compute every verification figure beside its reference.",
    "bench": "Run the benchmarks of a source checkout.",
}
"""What there is, in the order of use; a command's own file is imported when it is called."""

# modules, XML and descriptions stay: looking through them for what may go costs a fifth of a start
gc.set_threshold(100_000, 20, 20)

app = App(
    name="piston-cosim",
    help="Elastohydrodynamic lubrication of flexible pistons as an FMI co-simulation.",
    version_flags=["--version"],
    # the list of commands needs no markdown, which takes a quarter of its time to import
    help_format="markdown" if sys.argv[1:2] and sys.argv[1] in COMMANDS else "plaintext",
)
for _order, (_name, _line) in enumerate(COMMANDS.items()):
    # the command called explains itself by its docstring
    _help = {} if sys.argv[1:2] == [_name] else {"help": _line}
    app.command(f"{__package__}.{_name}:command", name=_name, sort_key=_order, **_help)
app.register_install_completion_command(help="Teach this shell to complete commands and options.")


def main():
    """Run the command line; turn what users can mend into messages and exit codes."""
    separate_output()
    try:
        app(exit_on_error=False, print_error=True)
    except CycloptsError:
        sys.exit(2)
    except BadInput as error:
        say_faults(
            f"bad input[/], {len(error.faults)} fault{'s' * (len(error.faults) > 1)}:",
            [f"- {f}" for f in error.faults],
        )
        sys.exit(2)
    except Stopped as error:
        title, *lines = [*filter(None, [error.headline]), error, *getattr(error, "__notes__", ())]
        say_faults(f"stopped:[/] {title}", lines)
    else:
        return
    sys.exit(1)


def separate_output():
    """Send what FMUs print to the error stream: standard output has what the commands print."""
    out = sys.stdout
    with suppress(OSError, ValueError, AttributeError):
        if out is sys.__stdout__ and out.fileno() == 1:
            out.flush()
            buffering = 1 if out.isatty() else -1
            kept = open(os.dup(1), "w", buffering, encoding=out.encoding, errors=out.errors)
            os.dup2(2, 1)
            sys.stdout = kept


def say_faults(title, lines):
    """Print a title and lines, as they are, on the error stream."""
    errors = Console(stderr=True)
    errors.print(f"[bold red]{title}", highlight=False, soft_wrap=True)
    for line in lines:
        errors.print(f"  {line}", markup=False, highlight=False, soft_wrap=True)
