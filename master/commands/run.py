"""`piston-cosim run`."""

import json
from contextlib import ExitStack, contextmanager
from os.path import relpath
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ..case.contract import swap_all
from ..case.schema import check_case, find_case
from ..case.system import open_system
from ..engine.truncation import state_truncation
from ..fmi.errors import BadInput
from ..results.file import Results
from ..runs.console import print_summary, watching
from ..runs.live import Live, curves, serving
from ..runs.run import run as run_system
from ..runs.working import working
from .app import STARTED
from .common import (
    Changes,
    OutputFile,
    OutputFolder,
    console,
    default_folder,
    draw_pictures,
    parse_changes,
    print_answers,
    say,
    variant_trees,
)


def command(
    case: str,
    /,
    *,
    set_: Changes = [],
    output: OutputFolder | None = None,
    only: str | None = None,
    summary_json: OutputFile | None = None,
    plots: bool = True,
    lubrication: str | None = None,
    bodies: str | None = None,
    live: bool = False,
    verbose: Annotated[bool, Parameter(negative=())] = False,
):
    """Run a case and its variants.

    The command writes a results file per variant, prints the main results and checks, and draws the
    pictures of the case.

    Example: piston-cosim run numerical_example --set viscosity="20 mPa s"

    Parameters
    ----------
    case
        Name of a case, its folder or its file. `piston-cosim list` prints the names.
    set_
        Change of the case, KEY=VALUE, e.g. `viscosity="20 mPa s"`; repeatable.
    output
        Folder for results. Default: results/CASE.
    only
        Run this variant only. The label of the case itself is its key `label`; default: base.
    summary_json
        Also write the summary to this file.
    plots
        Draw the pictures of the case.
    lubrication
        Lubrication model that replaces the model of the case: an FMU, or a model class
        FILE.py:CLASS. In a case with several films write PARTICIPANT=MODEL.
    bodies
        Model of the bodies that replaces the model of the case; same form.
    live
        Serve a page on this machine that shows curves during the run and can stop it.
    verbose
        Also print every period, all counters, the summary of the case and every check.
    """
    path = find_case(case)
    changes = parse_changes(set_)
    trees = swap_all(
        variant_trees(path, changes, only, say), {"lubrication": lubrication, "bodies": bodies}, say
    )
    cases = {label: check_case(tree, path) for label, tree in trees.items()}
    _say_ahead(cases, trees, plots, only)
    folder = output or default_folder(path)
    folder = folder.absolute()  # an FMU may change the working directory
    summary_json = summary_json and summary_json.absolute()
    begun_in = Path.cwd()
    systems = open_all(cases, path.parent)
    summaries = {}
    files = {}
    of_period = say if verbose else lambda line: None
    for label, system in systems.items():
        files[label] = folder / f"{label}.h5"
        with (
            watching(console, label) as watch,
            _shown(live, cases[label], system, watch) as (shown, told),
        ):
            summaries[label] = run_system(
                system, shown, trees[label], files[label], told, say=say, log=of_period
            )
        summaries[label] |= state_truncation(trees[label], path.parent, files[label], say)
        summaries[label]["first_step_after_s"] = (watch.first or STARTED) - STARTED
    if verbose:
        print_summary(console, summaries)
    if summary_json:
        first, *others = summaries
        whole = summaries[first] | (
            {"variants": {label: summaries[label] for label in others}} if others else {}
        )
        summary_json.write_text(json.dumps(whole, indent=2) + "\n")
    from ..engine.answer import answer  # slow to import

    with ExitStack() as opened:
        runs = {label: opened.enter_context(Results(file)) for label, file in files.items()}
        print_answers({label: answer(cases[label], runs[label]) for label in runs}, verbose)
        for file in files.values():
            shown = relpath(file, begun_in) if output is None or not output.is_absolute() else file
            console.print(f"results  {shown}", highlight=False, soft_wrap=True)
        if plots:
            draw_pictures(next(iter(cases.values())), runs, folder)


def _say_ahead(cases, trees, plots, only):
    """Report what this run omits: pictures without recorded fields, and other variants."""
    first = next(iter(cases.values()))
    for picture in first.pictures if plots else ():
        if lacking := first.unrecorded(picture):
            say(
                f"picture  {picture.file} will be omitted: record.fields lacks {', '.join(lacking)}"
            )
    others = [label for label in first.variants if label not in trees]
    if others and not only:
        say(f"variants not run: {', '.join(others)}; run one with --only LABEL")


@contextmanager
def _shown(live, case, system, watch):
    """Yield the case and the observer of its steps; `live` also serves a page of curves."""
    if not live:
        yield case, watch
        return
    page = Live(case.title, watch)
    with serving(page) as address:
        console.print(f"live     {address}", highlight=False, soft_wrap=True)
        yield case.model_copy(update={"monitor": curves(case, system)}), page


def open_all(cases, folder):
    """Return the systems of all variants; raise BadInput with the faults of all of them."""
    systems = {}
    faults = []
    for label, case in cases.items():
        try:
            # bodies are reduced here, which may take minutes
            with working(console, "preparing FMUs and bodies"):
                systems[label] = open_system(case, folder, say)
        except BadInput as error:
            faults += [fault for fault in error.faults if fault not in faults]
    if faults:
        raise BadInput(faults)
    return systems
