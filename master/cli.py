"""The command line `piston-cosim`: list, build, info, run, plot. Exit codes: 0 done, 1 failed honestly, 2 bad input."""

import os

for _threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_threads, "1")  # dense algebra here is small: a second BLAS thread costs up to a factor 7

import json  # noqa: E402
import sys  # noqa: E402
import tomllib  # noqa: E402
from pathlib import Path  # noqa: E402
from typing import Annotated  # noqa: E402

from cyclopts import App, CycloptsError, Parameter  # noqa: E402
from rich.console import Console  # noqa: E402
from rich.table import Table  # noqa: E402

from .case import case_names, check_case, find_case, read_tree  # noqa: E402
from .fmi.errors import BadInput  # noqa: E402

app = App(name="piston-cosim", help="Elastohydrodynamic lubrication of flexible pistons as an FMI co-simulation.",
          version_flags=["--version"])
console = Console()
errors = Console(stderr=True)

Changes = Annotated[list[str], Parameter(name="--set", negative=())]
"""KEY=VALUE pairs; several allowed."""


def main():
    """Run the command line; turn what users can mend into messages and exit codes."""
    from .participant import ParticipantFault
    from .stepping import StepFailed

    try:
        app(exit_on_error=False, print_error=True)
    except CycloptsError:
        sys.exit(2)
    except BadInput as error:
        errors.print(f"[bold red]bad input[/], {len(error.faults)} fault{'s' * (len(error.faults) > 1)}:")
        for fault in error.faults:
            errors.print(f"  - {fault}", markup=False, highlight=False, soft_wrap=True)
        sys.exit(2)
    except StepFailed as error:
        errors.print("[bold red]stopped:[/] a macro step did not converge, and no halving is left")
        errors.print(f"  {error}", markup=False, highlight=False, soft_wrap=True)
        sys.exit(1)
    except ParticipantFault as error:
        errors.print("[bold red]stopped:[/] an FMU reports a fault of its own")
        errors.print(f"  {error}", markup=False, highlight=False, soft_wrap=True)
        sys.exit(1)


@app.command(name="list")
def list_cases():
    """List the cases that come with the tool."""
    table = Table("case", "title", "variants", box=None)
    for name in case_names():
        tree = tomllib.loads(find_case(name).read_text())
        table.add_row(name, tree.get("title", ""), ", ".join(tree.get("variants", {})))
    console.print(table)


@app.command
def build(participant: str, *, case: str = "numerical_example", grid: str | None = None, output: Path | None = None):
    """Build the FMU of one participant of a case.

    Example: piston-cosim build ehd --grid 60x30 --output film.fmu

    Parameters
    ----------
    participant
        Its name in the case: ehd or bodies.
    case
        Case whose build options are used.
    grid
        Circumferential x axial cells, instead of the case's.
    output
        Where to put the FMU; without it the path in the cache is printed.
    """
    from .fmi.builder import build_fmu

    path = find_case(case)
    checked = check_case(read_tree(path), path)
    name = {"mfbd": "bodies"}.get(participant, participant)
    if name not in checked.participants or not checked.participants[name].package:
        raise BadInput(f"participant {participant!r}: the case builds {', '.join(checked.participants)}")
    table = checked.participants[name]
    if grid:
        table.build["grid"] = parse_grid(grid)
    fmu = build_fmu(table.package, table.build, path.parent, _say)
    if output:
        output.write_bytes(fmu.read_bytes())
    console.print(str(output or fmu), soft_wrap=True, highlight=False)


def parse_grid(text):
    """[circumferential, axial] cells from "40x40"."""
    try:
        sizes = [int(part) for part in text.split("x")]
    except ValueError:
        sizes = []
    if len(sizes) != 2:
        raise BadInput(f"--grid {text!r}: write CIRCUMFERENTIALxAXIAL cells, e.g. 40x40")
    return sizes


@app.command
def info(fmu: Path):
    """Print what an FMU offers: capabilities, parameters with ranges, inputs, outputs.

    Example: piston-cosim info film.fmu
    """
    from .participant import FmuParticipant

    if not fmu.is_file():
        raise BadInput(f"{fmu}: no such file")
    participant = FmuParticipant("fmu", fmu)
    model = participant.description
    console.print(f"[bold]{model.modelName}[/]  FMI {model.fmiVersion}  {model.description or ''}")
    console.print(f"save and restore state: {participant.can_redo}   serialise: "
                  f"{bool(model.coSimulation.canSerializeFMUstate)}   directional derivative: {participant.has_derivatives}")
    table = Table("causality", "name", "shape", "unit", "start", "allowed", "nominal", "description", box=None)
    for field in sorted(participant.fields.values(), key=lambda f: ("parameter", "input", "output", "local").index(f.causality)):
        limits = "" if field.minimum is None and field.maximum is None else \
            f"{'' if field.minimum is None else f'{field.minimum:g}'}..{'' if field.maximum is None else f'{field.maximum:g}'}"
        table.add_row(field.causality, field.name, "x".join(map(str, field.shape)), field.unit, field.start or "", limits,
                      "" if field.nominal is None else f"{field.nominal:g}", field.description)
    console.print(table)


@app.command
def run(case: str, *, set_: Changes = [], output: Path | None = None, only: str | None = None,
        summary_json: Path | None = None, plots: bool = True):
    """Run a case and its variants: results file, summary, pictures.

    Example: piston-cosim run numerical_example --set participants.ehd.parameters.viscosity="20 mPa s"

    Parameters
    ----------
    case
        Name of a case (see list), its folder, or a case file.
    set_
        Change of the case, KEY=VALUE with the key's dotted path; TOML values or plain text.
    output
        Folder for results; default results/<case>.
    only
        Run this variant alone; the label of the case itself (default base) for the case without variants.
    summary_json
        Also write the summary there.
    plots
        Draw the case's pictures at the end.
    """
    from .report import print_summary, watching
    from .run import run as run_system
    from .system import open_system

    path = find_case(case)
    changes = [parse_change(text) for text in set_]
    trees = variant_trees(path, changes, only)
    cases = {label: check_case(tree, path) for label, tree in trees.items()}
    folder = output or Path("results") / (path.parent.name if path.name == "case.toml" else path.stem)
    systems = open_all(cases, path.parent, open_system)
    summaries, files = {}, {}
    for label, system in systems.items():
        files[label] = folder / f"{label}.h5"
        with watching(console, label) as watch:
            summaries[label] = run_system(system, cases[label], trees[label], files[label], watch)
    print_summary(console, summaries)
    if summary_json:
        first, *others = summaries
        whole = summaries[first] | ({"variants": {label: summaries[label] for label in others}} if others else {})
        summary_json.write_text(json.dumps(whole, indent=2) + "\n")
    for label, file in files.items():
        console.print(f"results  {file}", highlight=False, soft_wrap=True)
    if plots:
        _draw(next(iter(cases.values())), files, folder)


def open_all(cases, folder, open_system):
    """Systems of all variants; the faults of all of them in one message."""
    systems, faults = {}, []
    for label, case in cases.items():
        try:
            systems[label] = open_system(case, folder, _say)
        except BadInput as error:
            faults += [fault for fault in error.faults if fault not in faults]
    if faults:
        raise BadInput(faults)
    return systems


def variant_trees(path, changes, only):
    """Resolved TOML tree of each run: the case itself under its label, then its variants."""
    tree = read_tree(path, changes)
    variants = {tree.get("label", "base"): {}} | tree.get("variants", {})
    if only and only not in variants:
        raise BadInput(f"--only {only}: the case has {', '.join(variants)}")
    chosen = {label: changed for label, changed in variants.items() if only in (None, label)}
    return {label: read_tree(path, [*changes, *changed.items()]) for label, changed in chosen.items()}


def parse_change(text):
    """(dotted key, value) of KEY=VALUE; the value is TOML where it reads as TOML, else text."""
    key, sign, value = text.partition("=")
    if not sign or not key:
        raise BadInput(f"--set {text!r}: write KEY=VALUE")
    try:
        return key.strip(), tomllib.loads(f"v = {value}")["v"]
    except tomllib.TOMLDecodeError:
        return key.strip(), value.strip().strip("\"'")


@app.command
def plot(*files: Path, output: Path = Path("pictures")):
    """Draw the pictures of one or several results files, side by side, as the first one's case describes them.

    Example: piston-cosim plot results/numerical_example/base.h5 results/numerical_example/rigid.h5
    """
    missing = [f"{file}: no such file" for file in files if not file.is_file()]
    if missing or not files:
        raise BadInput(missing or "give one or more results files")
    from .recorder import Results

    case = check_case(Results(files[0]).case, files[0])
    _draw(case, {file.stem: file for file in files}, output)


def _draw(case, files, folder):
    from .pictures import draw
    from .recorder import Results

    for picture in draw(case, {label: Results(file) for label, file in files.items()}, folder):
        console.print(f"picture  {picture}", highlight=False, soft_wrap=True)


def _say(text):
    console.print(f"[dim]{text}[/]", soft_wrap=True)
