"""`piston-cosim run`."""

import json
import os
from contextlib import ExitStack
from os.path import relpath
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ..case.checked import check_case
from ..case.contract import swap_all
from ..case.reading import find_case
from ..case.system import open_system
from ..fmi.errors import for_all
from ..fmi.jobs import VARIABLE as JOBS
from ..fmi.jobs import jobs as count_jobs
from ..results.file import Results
from ..runs.completed import complete_run
from ..runs.console import print_summary, watching
from ..runs.kernels import compile_kernels
from ..runs.pool import LocalPool
from ..runs.variants import Outcome, Variant, run_variants, start_processes
from ..runs.working import working
from .app import STARTED
from .common import (
    Changes,
    Only,
    OutputFile,
    OutputFolder,
    Workers,
    console,
    default_folder,
    draw_pictures,
    parse_changes,
    print_answers,
    print_line,
    say,
    variant_trees,
    warn_of_estimates,
)


def command(
    case: str,
    /,
    *,
    set_: Changes = [],
    output: OutputFolder | None = None,
    only: Only = None,
    summary_json: OutputFile | None = None,
    plots: bool = True,
    lubrication: list[str] = [],
    bodies: list[str] = [],
    jobs: Workers | None = None,
    uncertainty: Annotated[bool, Parameter(negative=())] = False,
    verbose: Annotated[bool, Parameter(negative=())] = False,
):
    """Run a case and its variants.

    The command writes a results file per variant, prints the main results and checks, and draws the
    pictures of the case.

    Example: piston-cosim run numerical_example --set viscosity="20 mPa s"

    Example: piston-cosim run data_sheet --lubrication jfo --lubrication film.fmu

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
        Lubrication model that replaces the model of the case: an FMU, a model class FILE.py:CLASS,
        or a cavitation model. If repeated, each model has a run. In a case with several films write
        PARTICIPANT=MODEL.
    bodies
        FMU or model class of the bodies that replaces the model of the case; repeatable.
    jobs
        Number of processes that compile and run variants at the same time. 1 does one thing after
        the other. Default: the number of processors.
    uncertainty
        Compute the uncertainty of the main results from a second grid and doubled steps. It takes
        up to 0.8 of the time of the run. Default: an estimate from the run alone.
    verbose
        Also print every period, all counters, the summary of the case and every check.
    """
    path = find_case(case)
    changes = parse_changes(set_)
    variants = variant_trees(path, changes, only, say)
    trees = swap_all(variants, {"lubrication": lubrication, "bodies": bodies}, say)
    cases = {label: check_case(tree, path) for label, tree in trees.items()}
    _say_ahead(cases, variants, plots, only)
    if uncertainty:
        warn_of_estimates(trees, path.parent)
    folder = output or default_folder(path)
    folder = folder.absolute()  # an FMU may change the working directory
    summary_json = summary_json and summary_json.absolute()
    begun_in = Path.cwd()
    if jobs:
        os.environ[JOBS] = str(jobs)
    files = {label: folder / f"{label}.h5" for label in cases}
    of_period = say if verbose else lambda line: None
    with LocalPool(count_jobs() - 1) as pool:
        side_by_side = len(cases) > 1 and count_jobs() > 1
        if side_by_side:  # the processes start while bodies are reduced
            start_processes(pool, len(cases) - 1)
        systems = open_all(cases, path.parent)
        if count_jobs() > 1:
            compile_kernels(systems.values(), pool, console)
        asked = {x: Variant(trees[x], path.parent, files[x], uncertainty) for x in cases}
        if side_by_side:
            outcomes = run_variants(asked, pool, console, say, of_period)
        else:
            outcomes = {
                label: _run(label, system, cases[label], asked[label], of_period)
                for label, system in systems.items()
            }
    summaries = {
        label: one.summary | {"first_step_after_s": (one.first or STARTED) - STARTED}
        for label, one in outcomes.items()
    }
    if verbose:
        print_summary(console, summaries)
    if summary_json:
        first, *others = summaries
        whole = summaries[first] | (
            {"variants": {label: summaries[label] for label in others}} if others else {}
        )
        summary_json.write_text(json.dumps(whole, indent=2) + "\n")
    with ExitStack() as opened:
        with working(console, "evaluating results"):
            from ..engine.answer import answer  # slow to import

            runs = {label: opened.enter_context(Results(file)) for label, file in files.items()}
            answers = {label: answer(cases[label], runs[label]) for label in runs}
        print_answers(answers, verbose)
        for file in files.values():
            shown = relpath(file, begun_in) if output is None or not output.is_absolute() else file
            print_line(f"results  {shown}")
        if plots:
            draw_pictures(next(iter(cases.values())), runs, folder)


def _say_ahead(cases, variants, plots, only):
    """Report what this run omits: pictures without recorded fields, and other variants."""
    first = next(iter(cases.values()))
    for picture in first.pictures if plots else ():
        if lacking := [port for port in picture.fields if port not in first.record.fields]:
            say(
                f"picture  {picture.file} will be omitted: record.fields lacks {', '.join(lacking)}"
            )
    others = [label for label in first.variants if label not in variants]
    if others and not only:
        say(f"variants not run: {', '.join(others)}; run one with --only LABEL")


def _run(label, system, case, variant, log):
    """Run a variant in this process."""
    options = {"say": say, "log": log, "uncertainty": variant.uncertainty}
    with watching(console, label) as watch:
        summary = complete_run(system, case, variant.tree, variant.output, watch, **options)
    return Outcome(summary, watch.first)


def open_all(cases, folder):
    """Return the systems of all variants; raise BadInput with the faults of all of them."""

    def opened(case):
        with working(console, "preparing FMUs and bodies"):  # which may take minutes
            return open_system(case, folder, say)

    return dict(zip(cases, for_all(opened, cases.values())))
