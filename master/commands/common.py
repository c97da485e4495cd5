"""Functions of several commands: read options, resolve variants, open results, print."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from ..case.changes import changes_of_variant, toml_value, value_at
from ..case.checked import check_case
from ..case.contract import players
from ..case.reading import case_names, find_case, name_of_case, read_tree
from ..case.tables import titles
from ..fmi.errors import BadInput, for_all
from ..fmi.tree import import_part
from ..runs.working import working
from .usage import new_file, new_folder, positive, whole, with_suffix

console = Console()

OutputFile = Annotated[Path, Parameter(validator=new_file)]
Whole = Annotated[int, Parameter(converter=whole)]
"""Whole number, without the rounding of cyclopts."""
Workers = Annotated[Whole, Parameter(validator=positive)]
Moment = Annotated[str, Parameter(allow_leading_hyphen=True)]
"""Time, crank angle or extreme of a run."""
PictureFile = Annotated[Path, Parameter(validator=(with_suffix(".png", ".svg", ".pdf"), new_file))]
CsvFile = Annotated[Path, Parameter(validator=(new_file, with_suffix(".csv")))]
OutputFolder = Annotated[Path, Parameter(validator=new_folder)]
Format = Literal["png", "svg", "pdf"]
"""Type of pictures."""
Changes = Annotated[list[str], Parameter(name="--set")]
"""Changes KEY=VALUE of a case."""
Only = Annotated[str | None, Parameter(name=("--only", "--variant"))]
"""Label of the variant of a case."""


NARROWEST_TABLE = 150
"""Smallest width of a wide table outside a terminal."""


def wide_console(broken=True):
    """Return the console for wide tables.

    A table in a terminal has the width of the terminal, unless its cells must not be `broken` into
    lines.
    """
    if broken and console.is_terminal:
        return console
    return Console(width=max(console.width, NARROWEST_TABLE))


def print_line(text, markup=True):
    """Print a line, which a terminal breaks and a file does not."""
    console.print(text, markup=markup, highlight=False, soft_wrap=True)


def say(text):
    """Print a message about progress."""
    console.print(f"[dim]{escape(text)}[/]", soft_wrap=True)


def parse_change(text):
    """Return dotted key and value of KEY=VALUE; a value that is not valid TOML is text."""
    key, sign, value = text.partition("=")
    if not sign or not key:
        raise BadInput(f"--set: expected KEY=VALUE, got {text!r}")
    return key.strip(), toml_value(value)


def parse_changes(texts):
    """Return the pairs of all --set; raise `BadInput` with every invalid one."""
    return for_all(parse_change, texts)


def parse_grid(text):
    """Return the numbers of circumferential and axial cells from a text like "40x40"."""
    try:
        sizes = [int(part) for part in text.split("x")]
    except ValueError:
        sizes = []
    if len(sizes) != 2:
        raise BadInput(
            f"--grid: expected CIRCUMFERENTIALxAXIAL cells, got {text!r}; write for example 40x40"
        )
    return sizes


def native_platforms(platform, native):
    """Return the platforms of a native FMU from --platform; none without --native."""
    if platform and not native:
        raise BadInput(f"--platform: expected it with --native, got {platform!r} alone")
    return (platform or "linux64").split(",") if native else ()


def default_folder(path):
    """Return the default folder for the results of a case file."""
    return Path("results") / name_of_case(path)


def variant_trees(path, changes, only, say=lambda text: None):
    """Return the resolved TOML tree of each run by label.

    The runs are the case itself and the variants of its key `beside`, or the variant `only`. A
    change overrides a variant; `say` reports it.
    """
    tree = read_tree(path, changes)
    case = check_case(tree, path)
    beside = (label for label in case.variants if label in case.beside)
    trees = {}
    for label in [only] if only else [case.label, *beside]:
        changed = changes_of_variant(tree, label)
        trees[label] = read_tree(path, [*changed.items(), *changes])
        for key, value in changed.items():
            taken = value_at(trees[label], key, path.parent)
            if taken != value:
                say(f"{label}: {key} = {taken!r} replaces the variant's value {value!r}")
    return trees


def changed_case(name, texts, only, output, purpose):
    """Return the path of a case, its changes by --only and --set, its tree, and the output folder.

    Default of the folder: results/PURPOSE_CASE.
    """
    path = find_case(name)
    changes = parse_changes(texts)
    if only:
        variant_trees(path, changes, only, say)
        changes = [*changes_of_variant(read_tree(path), only).items(), *changes]
    folder = output or Path("results") / f"{purpose}_{name_of_case(path)}"
    return path, changes, read_tree(path, changes), folder.absolute()


def warn_of_estimates(trees, folder):
    """Warn of runs, tree by label, whose uncertainties will be estimates despite --uncertainty."""
    from ..runs.uncertainty import reason_ahead  # slow to import

    for label, tree in trees.items():
        if why := reason_ahead(tree, folder):
            say(f"warning: {label}: --uncertainty will be an estimate from the run alone: {why}")


def open_runs(files):
    """Return the case of the first results file, and the results by label.

    A label is the name of a file, with its folder if several files have that name.
    """
    from ..results.file import open_results

    resolved = [file.resolve() for file in files]
    if not files:
        raise BadInput("files: expected at least one results file, got nothing")
    repeated = next((f for k, f in enumerate(files) if f.resolve() in resolved[:k]), None)
    if repeated:
        raise BadInput(f"files: expected different files, got {str(repeated)!r} twice")
    labels = [file.stem for file in files]
    for longer in (lambda f: f"{f.parent.name}/{f.stem}", lambda f: str(f.with_suffix(""))):
        if len(set(labels)) < len(files):
            labels = [
                longer(file) if labels.count(label) > 1 else label
                for file, label in zip(files, labels)
            ]
    runs = dict(zip(labels, for_all(open_results, files)))
    return check_case(next(iter(runs.values())).case, files[0]), runs


def open_run(file):
    """Return the case of a results file, and the results."""
    case, runs = open_runs((file,))
    return case, *runs.values()


def bodies_of(file):
    """Return the results of a file, and the build tables of its bodies by participant."""
    from ..api.bodies import build_tables

    _, results = open_run(file)
    tables = build_tables(results.case, results.case["participants"])
    if not tables:
        raise BadInput(f"{file}: expected a participant of bodies, got none")
    return results, tables


def body_skins(runs, case) -> dict[str, dict[str, list[Any]]]:
    """Return the surfaces of the bodies by label and participant.

    Bodies whose meshes are missing are omitted, with a message.
    """
    from ..api.bodies import OFFLINE, build_tables

    skins = {}
    for label, results in runs.items():
        folder = case_folder(results, case)
        known = {}
        skins[label] = {}
        for name, table in build_tables(results.case, players(results.case, "bodies")).items():
            key = json.dumps(table)
            try:
                if key not in known:
                    known[key] = import_part(OFFLINE).skins(table, folder, say)
                skins[label][name] = known[key]
            except BadInput as error:
                say(f"{label}: no bodies of {name} are drawn: {error}; --case names their folder")
    return {label: own for label, own in skins.items() if own}


def page_of(case, runs, folder, *, source=None, measured=None):
    """Write the report of runs with their main results, bodies and engine sections.

    Parameters
    ----------
    case : Case
        Case of the first run.
    runs : dict of str to Results
    folder : Path
    source : str, optional
        Case whose folder contains the meshes.
    measured : Agreement, optional
        Measured values.
    """
    from ..engine.answer import answer
    from ..engine.overview import overview
    from ..engine.sections import special
    from ..results.report import write_report

    answers = {label: answer(case, results) for label, results in runs.items()}
    tables = {label: one.table for label, one in answers.items()}
    own = special(case, runs, body_skins(runs, source))
    own = replace(own, overview=overview(runs, tables), measured=measured)
    return write_report(case, runs, folder, answers, own)


def case_folder(results, case=None) -> Path:
    """Return the folder that contains the meshes of a run's case.

    It is the first that exists of these: the folder of `case`, of the case with the name of the
    results folder, of the shipped case with the same title, and of the results.
    """
    if case:
        return find_case(case).parent
    own = results.path.resolve().parent
    try:
        return find_case(own.name).parent
    except BadInput:
        alike = (find_case(name) for name in case_names())
        title = results.case.get("title")
        return next((path.parent for path in alike if title in titles(read_tree(path))), own)


def print_answers(answers, verbose=False):
    """Print the main results of runs in columns, then the checks that warn or fail.

    `answers` maps labels to `engine.answer.Answer`. `verbose` prints all checks.
    """
    table = Table("", *answers, box=None, pad_edge=False)
    for name in dict.fromkeys(name for one in answers.values() for name in one.lines):
        table.add_row(name, *(one.lines.get(name, "") for one in answers.values()))
    wide_console().print(table, highlight=False)
    width = max((len(c.what) for one in answers.values() for c in one.verdicts), default=0)
    for label, one in answers.items():
        if one.uncertainty:
            say(f"{label}: {one.uncertainty}" if len(answers) > 1 else one.uncertainty)
        for check in one.verdicts:
            if check.colour == "green" and not verbose:
                continue
            colour = {"amber": "yellow"}.get(check.colour, check.colour)
            whose = f"{label}: " if len(answers) > 1 else ""
            shown = f"[{colour}]{check.outcome:7s} {check.what:{width}s}[/] {whose}{check.text}"
            print_line(shown)


def print_compared(runs):
    """Print the comparison of two runs (label -> Results), and return its headline."""
    from ..engine.answer import answer, failed_checks
    from ..engine.comparison import compared

    trees = tuple(results.case for results in runs.values())
    cases = [check_case(tree, results.path) for tree, results in zip(trees, runs.values())]
    answers = [answer(case, results) for case, results in zip(cases, runs.values())]
    comparison = compared(tuple(runs), trees, [one.table for one in answers])
    print_line(comparison.headline, markup=False)
    table = Table("", *comparison.names, "difference", box=None, pad_edge=False)
    for row in comparison.rows:
        table.add_row(row.label, row.first.figure, row.second.figure, row.text)
    if comparison.rows:
        wide_console().print(table, highlight=False)
    for name, one in zip(comparison.names, answers):
        if failed := failed_checks(one.verdicts):
            say(f"warning: {name}: the checks {', '.join(failed)} fail")
    for remark in comparison.remarks:
        say(remark)
    return comparison.headline


def draw_pictures(case, runs, folder, kind=None, paper=False):
    """Draw the pictures of a case for runs (label -> Results) and print their paths.

    `kind` and `paper` are those of `results.pictures.draw`.
    """
    from ..results.pictures import draw, left_out

    for picture, why in left_out(case, runs).items():
        say(f"picture  {picture} is omitted: {why}")
    with working(console, "drawing", len(case.pictures) * len(runs), typical=1.0):
        drawn = draw(case, runs, folder, kind, paper)
    for picture in drawn:
        print_line(f"picture  {picture}")
