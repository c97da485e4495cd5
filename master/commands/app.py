"""The command line `piston-cosim`: one file per command, one folder per group.

Exit codes: 0 success, 1 a run that failed or was stopped, 2 bad input.
"""

import errno
import gc
import os
import sys
import time
from contextlib import suppress

from cyclopts import App, CycloptsError, Parameter
from rich.console import Console

from ..fmi.errors import BadInput, Stopped
from ..runs.signals import ending_soon
from .usage import check_values, faults_of, is_damaged

STARTED = time.perf_counter()
SUMMARY = "Simulate the elastohydrodynamic lubrication of flexible pistons as an FMI co-simulation."
GROUPS = {
    "results": "Draw, report and export results files.",
    "fmu": "Build, export and inspect FMUs.",
}
COMMANDS = {
    "run": "Run a case and its variants.",
    "resume": "Continue an interrupted run from its checkpoint.",
    "new": "Write a case of your own engine.",
    "check": "Check a case without a run.",
    "profile": "Read a measured profile of a skirt, judge and draw it.",
    "bearing": "Compute a journal bearing under a constant load.",
    "keys": "List the keys of a case file.",
    "list": "List the shipped cases.",
    "compare": "Compare the main results of two runs.",
    "sweep": "Run a case over values of its keys.",
    "sensitivities": "Compute how the main results change with numbers and profile.",
    "optimise": "Find the best numbers and profile of a case within limits.",
    "calibrate": "Fit numbers of a case to measured curves.",
    "study": "Run a study of a case.",
    "reduce": "Reduce flexible bodies and list their modes.",
    "verify": "Compute the verification figures next to their references.",
    "results plot": "Draw the pictures of results files.",
    "results report": "Write an HTML report about results files.",
    "results movie": "Write an animation of a results file.",
    "results scalars": "Write all scalar outputs as CSV.",
    "results fields": "Write recorded fields as CSV.",
    "results snapshot": "Write the state of a participant at one instant.",
    "results recover": "Write displacement and stress of the bodies as VTU.",
    "fmu build": "Build the FMU of one participant of a case, or of a single-file model class.",
    "fmu export": "Export a case as one FMU or as an SSP.",
    "fmu info": "Print the interface of an FMU.",
    "fmu check": "Compare an FMU with the contract of its role.",
}
"""Words of a command -> the summary of its docstring. A call imports only its own command."""


def _shown(default):
    """Return a default as --help shows it; None for an option that is off or empty by default."""
    return None if default in (None, False, []) else str(default)


app = App(
    name="piston-cosim",
    help=SUMMARY,
    version_flags=["--version"],
    help_format="markdown",
    version_format="plaintext",
    default_parameter=Parameter(negative_iterable=(), show_default=_shown),
    suppress_keyboard_interrupt=False,
)
_PACKAGE = __name__.rpartition(".")[0]
_apps = {"": app} | {name: App(name=name, help=text) for name, text in GROUPS.items()}
for _order, _words in enumerate(COMMANDS):
    _group, _, _name = _words.rpartition(" ")
    _module = ".".join([_PACKAGE, *_words.split()])
    _apps[_group].command(f"{_module}:command", name=_name, sort_key=_order)
for _order, _name in enumerate(GROUPS):
    _apps[_name].sort_key = len(COMMANDS) + _order
    app.command(_apps[_name])
app.register_install_completion_command(help="Teach this shell to complete commands and options.")


def main():
    """Run the command line; print errors of the user's input and set the exit code."""
    # PARDISO uses the user's number of threads, not the default below
    os.environ.setdefault("PISTON_COSIM_THREADS", os.environ.get("OMP_NUM_THREADS", "all"))
    # dense algebra here is small: a second BLAS thread makes it up to 7 times slower
    for threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(threads, "1")
    # modules, XML and descriptions are permanent: scanning them takes a fifth of a start
    gc.set_threshold(100_000, 20, 20)
    separate_output()
    words = sys.argv[1:]
    try:
        if (listed := overview(words)) is not None:
            print(listed)
            return
        check_values(words)
        with ending_soon():
            app(words, exit_on_error=False, print_error=False)
        sys.stdout.flush()
    except KeyboardInterrupt as error:
        say_faults(f"\nstopped:[/] by {str(error) or 'SIGINT'}", [])
    except BrokenPipeError:  # the reader of standard output has ended, such as `head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except (CycloptsError, BadInput, OSError) as error:
        if isinstance(error, OSError) and not (error.filename or is_damaged(error)):
            if error.errno != errno.ENOSPC:
                raise  # not a file of the user
            say_faults(f"stopped:[/] {error.strerror}", [])
            sys.exit(1)
        faults = faults_of(error)
        title = f"bad input[/], {len(faults)} fault{'s' * (len(faults) > 1)}:"
        say_faults(title, [f"- {fault}" for fault in faults])
        sys.exit(2)
    except Stopped as error:
        title, *lines = [*filter(None, [error.headline]), error, *getattr(error, "__notes__", ())]
        say_faults(f"stopped:[/] {title}", lines)
    else:
        return
    sys.exit(1)


def overview(words):
    """Return the list of all commands, or of a group, if `words` ask for one; None otherwise."""
    asked = [word for word in words if word not in ("--help", "-h")]
    if asked and (asked[0] not in GROUPS or len(asked) > 1):
        return None
    groups = {asked[0]: GROUPS[asked[0]]} if asked else {"": "Run cases."} | GROUPS
    lines = [
        f"Usage: {' '.join(['piston-cosim', *asked])} COMMAND",
        *([] if asked else ["", SUMMARY]),
    ]
    width = max(map(len, COMMANDS))
    for group, title in groups.items():
        lines += ["", title]
        for command, summary in COMMANDS.items():
            if command.partition(" ")[0] == group or not (group or " " in command):
                lines.append(f"  {command:{width}s}  {summary}")
    lines += ["", "Type `piston-cosim COMMAND --help` for the options of a command."]
    if not asked:
        lines += [
            "Type `piston-cosim --version` for the version.",
            "Type `piston-cosim --install-completion` to complete commands in your shell.",
        ]
    return "\n".join(lines)


def separate_output():
    """Send the output of FMUs to the error stream; standard output is for the commands."""
    out = sys.stdout
    with suppress(OSError, ValueError, AttributeError):
        if out is sys.__stdout__ and out.fileno() == 1:
            out.flush()
            buffering = 1 if out.isatty() else -1
            original = open(os.dup(1), "w", buffering, encoding=out.encoding, errors=out.errors)
            os.dup2(2, 1)
            sys.stdout = original


def say_faults(title, lines):
    """Print a title and lines, as they are, on the error stream."""
    errors = Console(stderr=True)
    errors.print(f"[bold red]{title}", highlight=False, soft_wrap=True)
    for line in lines:
        errors.print(f"  {line}", markup=False, highlight=False, soft_wrap=True)
