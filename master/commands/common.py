"""What several commands do: read --set and --grid, resolve variants, open results, speak."""

import json
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter
from rich.console import Console
from rich.table import Table

from ..case.changes import value_at
from ..case.contract import players
from ..case.schema import case_names, check_case, find_case, read_tree
from ..fmi.errors import BadInput
from ..fmi.tree import import_part

console = Console()

Changes = Annotated[list[str], Parameter(name="--set")]
"""Changes KEY=VALUE of a case."""


NARROWEST = 150
"""Columns of a wide table: in a pipe, and of one whose cells cannot be broken anywhere."""


def wide_console(broken=True):
    """The console for wide tables: a terminal as wide as it is, a pipe as wide as is needed; with
    cells that must not be `broken` the terminal breaks the lines.
    """
    if broken and console.is_terminal:
        return console
    return Console(width=max(console.width, NARROWEST))


def say(text):
    """Tell what is being done."""
    console.print(f"[dim]{text}[/]", soft_wrap=True)


def parse_change(text):
    """(dotted key, value) of KEY=VALUE; the value is TOML where it reads as TOML, else text."""
    key, sign, value = text.partition("=")
    if not sign or not key:
        raise BadInput(f"--set {text!r}: write KEY=VALUE")
    try:
        return key.strip(), tomllib.loads(f"v = {value}")["v"]
    except tomllib.TOMLDecodeError:
        return key.strip(), value.strip().strip("\"'")


def parse_grid(text):
    """[circumferential, axial] cells from "40x40"."""
    try:
        sizes = [int(part) for part in text.split("x")]
    except ValueError:
        sizes = []
    if len(sizes) != 2:
        raise BadInput(f"--grid {text!r}: write CIRCUMFERENTIALxAXIAL cells, e.g. 40x40")
    return sizes


def default_folder(path):
    """Folder for the results of a case file, where --output names none."""
    return Path("results") / (path.parent.name if path.name == "case.toml" else path.stem)


def variant_trees(path, changes, only, say=lambda text: None):
    """Resolved TOML tree of each run: the case itself under its label, then the variants that run
    beside it; or the one of the label `only`. A change wins over what a variant has, and `say` is
    told so.
    """
    tree = read_tree(path, changes)
    own = tree.get("label", "base")
    variants = {own: {}} | tree.get("variants", {})
    if only and only not in variants:
        raise BadInput(f"--only {only}: the case has {', '.join(variants)}")
    wanted = (only,) if only else (own, *tree.get("beside", []))
    chosen = {label: changed for label, changed in variants.items() if label in wanted}
    trees = {}
    for label, changed in chosen.items():
        trees[label] = read_tree(path, [*changed.items(), *changes])
        for key, value in changed.items():
            taken = value_at(trees[label], key, path.parent)
            if taken != value:
                say(f"{label}: {key} = {taken!r} as set, in place of the variant's {value!r}")
    return trees


def open_runs(files):
    """Case of the first results file, and label -> Results of all; files of equal names are told
    apart by their folders.
    """
    from ..results.file import Results

    missing = [f"{file}: no such file" for file in files if not file.is_file()]
    if missing or not files:
        raise BadInput(missing or "give one or more results files")
    labels = [
        file.stem
        if sum(f.stem == file.stem for f in files) == 1
        else f"{file.parent.name}/{file.stem}"
        for file in files
    ]
    try:
        runs = {label: Results(file) for label, file in zip(labels, files)}
        tree = next(iter(runs.values())).case
    except (OSError, KeyError) as error:
        raise BadInput(
            f"{', '.join(map(str, files))}: not all are results of a run: {error}"
        ) from None
    return check_case(tree, files[0]), runs


def body_skins(runs, case) -> dict[str, dict[str, list[Any]]]:
    """Label -> participant -> surfaces of its bodies; those that cannot be had are left out with a
    word.
    """
    from ..api.bodies import OFFLINE, build_tables

    found = {}
    for label, results in runs.items():
        folder = case_folder(results, case)
        known = {}
        found[label] = {}
        for name, table in build_tables(results.case, players(results.case, "bodies")).items():
            key = json.dumps(table)
            try:
                if key not in known:
                    known[key] = import_part(OFFLINE).skins(table, folder, say)
                found[label][name] = known[key]
            except BadInput as error:
                say(f"{label}: no bodies of {name} are drawn: {error}; --case names their folder")
    return {label: own for label, own in found.items() if own}


def page_of(case, runs, folder, *, source=None, notes=None, studies=(), ahead=(), figures=True):
    """Write the report of runs with their answers, bodies and all that their machine is known by.

    Parameters
    ----------
    case : Case
        Of the first run.
    runs : dict of str to Results
    folder : Path
    source : str, optional
        Case whose folder the paths of meshes start from.
    notes, studies, figures
        As `results.report.write_report` has them.
    ahead : sequence of Section
        Shown first.
    """
    from ..engine.answer import answer
    from ..engine.sections import special
    from ..results.report import write_report

    answers = {label: answer(case, results) for label, results in runs.items()}
    own = special(case, runs, body_skins(runs, source))
    own = replace(own, sections=[*ahead, *own.sections])
    return write_report(case, runs, folder, notes, studies, answers, own, figures)


def case_folder(results, case=None) -> Path:
    """Folder that the paths of a run's case start from: that of `case`, of the case named as the
    folder of the results, or of the case that comes with the tool and has its title; the results'
    own where there is none.
    """
    if case:
        return find_case(case).parent
    own = results.path.resolve().parent
    try:
        return find_case(own.name).parent
    except BadInput:
        alike = (find_case(name) for name in case_names())
        title = results.case.get("title")
        return next((path.parent for path in alike if title in _titles(read_tree(path))), own)


def _titles(tree):
    """Titles of a case and its variants."""
    return [one.get("title") for one in (tree, *tree.get("variants", {}).values())]


def print_answers(answers, verbose=False):
    """Label -> `engine.answer.Answer` of every run, side by side, then the checks of each that
    warn or fail; all checks with `verbose`.
    """
    table = Table("", *answers, box=None, pad_edge=False)
    for name in dict.fromkeys(line.name for one in answers.values() for line in one.lines):
        table.add_row(name, *(one.said(name) for one in answers.values()))
    wide_console().print(table, highlight=False)
    for label, one in answers.items():
        for check in one.verdicts:
            if check.colour == "green" and not verbose:
                continue
            colour = {"amber": "yellow"}.get(check.colour, check.colour)
            whose = f"{label}: " if len(answers) > 1 else ""
            shown = f"[{colour}]{check.outcome:7s} {check.what:14s}[/] {whose}{check.said}"
            console.print(shown, highlight=False, soft_wrap=True)


def draw_pictures(case, runs, folder, kind=None):
    """Draw a case's pictures of its runs (label -> Results) and say where they are; as files of
    another `kind` where one is given.
    """
    from ..results.pictures import draw, left_out

    for picture, why in left_out(case, runs).items():
        say(f"picture  {picture} is left out: {why}")
    with console.status("drawing"):
        drawn = draw(case, runs, folder, kind)
    for picture in drawn:
        console.print(f"picture  {picture}", highlight=False, soft_wrap=True)
