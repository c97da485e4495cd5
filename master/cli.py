"""The command line `piston-cosim`: one function a command. Exit codes: 0 done, 1 failed honestly, 2 bad input."""

import os

for _threads in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_threads, "1")  # dense algebra here is small: a second BLAS thread costs up to a factor 7

import json  # noqa: E402
import sys  # noqa: E402
import time  # noqa: E402
import tomllib  # noqa: E402
from pathlib import Path  # noqa: E402
from typing import Annotated, Literal  # noqa: E402

from cyclopts import App, CycloptsError, Parameter  # noqa: E402
from rich.console import Console  # noqa: E402
from rich.table import Table  # noqa: E402

from .case import case_names, check_case, find_case, read_tree  # noqa: E402
from .fmi.errors import BadInput  # noqa: E402

app = App(name="piston-cosim", help="Elastohydrodynamic lubrication of flexible pistons as an FMI co-simulation.",
          version_flags=["--version"])
STARTED = time.perf_counter()
console = Console()
errors = Console(stderr=True)

Changes = Annotated[list[str], Parameter(name="--set", negative=())]
"""KEY=VALUE pairs; several allowed."""


def main():
    """Run the command line; turn what users can mend into messages and exit codes."""
    from .checkpoint import Interrupted
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
    except Interrupted as error:
        errors.print(f"[bold red]stopped:[/] {error}", highlight=False, soft_wrap=True)
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
def build(participant: str, *, case: str = "numerical_example", grid: str | None = None, output: Path | None = None,
          fmi: Literal["2.0", "3.0"] = "2.0"):
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
    fmi
        Version of the standard.
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
    fmu = build_fmu(table.package, table.build, path.parent, _say, fmi)
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
    from .participant import open_fmu

    if not fmu.is_file():
        raise BadInput(f"{fmu}: no such file")
    participant = open_fmu("fmu", fmu)
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
        summary_json: Path | None = None, plots: bool = True, lubrication: Path | None = None, bodies: Path | None = None):
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
    lubrication, bodies
        FMU to take instead of the case's own; what the case says of variables it does not have is left out and named.
    """
    from .check import swap_all
    from .report import print_summary, watching
    from .run import run as run_system
    from .system import open_system

    path = find_case(case)
    changes = [parse_change(text) for text in set_]
    trees = swap_all(variant_trees(path, changes, only), {"lubrication": lubrication, "bodies": bodies}, _say)
    cases = {label: check_case(tree, path) for label, tree in trees.items()}
    folder = output or Path("results") / (path.parent.name if path.name == "case.toml" else path.stem)
    systems = open_all(cases, path.parent, open_system)
    summaries, files = {}, {}
    for label, system in systems.items():
        files[label] = folder / f"{label}.h5"
        with watching(console, label) as watch:
            summaries[label] = run_system(system, cases[label], trees[label], files[label], watch)
        summaries[label]["first_step_after_s"] = watch.first - STARTED
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
def resume(checkpoint: Path):
    """Go on with an interrupted run from its checkpoint, with the same bits as if nothing had happened.

    Example: piston-cosim resume results/numerical_example/flexible.h5.checkpoint
    """
    from .checkpoint import Checkpoint
    from .report import print_summary, watching
    from .run import run as run_system
    from .system import open_system

    if not checkpoint.name.endswith(".h5.checkpoint"):
        raise BadInput(f"{checkpoint}: give the file <results>.h5.checkpoint")
    found = Checkpoint.read(checkpoint)
    output = checkpoint.with_suffix("")
    case = check_case(found.tree, checkpoint)
    system = open_system(case, Path(found.folder), _say)
    with watching(console, output.stem) as watch:
        summary = run_system(system, case, found.tree, output, watch, found)
    print_summary(console, {output.stem: summary})
    console.print(f"results  {output}", highlight=False, soft_wrap=True)


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


@app.command
def verify(*parts: str, all_: Annotated[bool, Parameter(name="--all", negative=())] = False):
    """Compute every verification figure and print it beside its reference and its error.

    Example: piston-cosim verify ehd

    Parameters
    ----------
    parts
        ehd, mfbd, master; all of them by default.
    all_
        The slow studies too (minutes).
    """
    from .verify import PARTS
    from .verify import verify as compute

    unknown = [part for part in parts if part not in PARTS]
    if unknown:
        raise BadInput(f"no part {', '.join(unknown)}: there are {', '.join(PARTS)}")
    if compute(parts or tuple(PARTS), all_, Console(width=max(console.width, 190))):
        sys.exit(1)


@app.command
def bench(*names: str):
    """Run the benchmarks of a source checkout: ratios measured side by side, one thread.

    Example: piston-cosim bench mfbd_step

    Parameters
    ----------
    names
        Scripts in tests/bench without their ending; all of them by default.
    """
    import subprocess

    folder = Path(__file__).resolve().parents[1] / "tests" / "bench"
    known = sorted(path.stem for path in folder.glob("*.py"))
    unknown = [name for name in names if name not in known]
    if unknown or not known:
        raise BadInput(f"no benchmark {', '.join(unknown)}: there are {', '.join(known)}" if known else
                       "benchmarks are in the source checkout, not in the installed package")
    for name in names or known:
        console.print(f"[bold]{name}[/]")
        subprocess.run([sys.executable, str(folder / f"{name}.py")], check=True)


def _draw(case, files, folder):
    from .pictures import draw
    from .recorder import Results

    for picture in draw(case, {label: Results(file) for label, file in files.items()}, folder):
        console.print(f"picture  {picture}", highlight=False, soft_wrap=True)


def _say(text):
    console.print(f"[dim]{text}[/]", soft_wrap=True)


@app.command
def check(fmu: Path):
    """Compare an FMU with the lubrication contract: names, units, shapes, capabilities.

    Example: piston-cosim check film.fmu
    """
    from .check import check_fmu

    if not fmu.is_file():
        raise BadInput(f"{fmu}: no such file")
    role, breaches, remarks = check_fmu(fmu)
    for line in remarks:
        console.print(f"remark: {line}", markup=False, highlight=False, soft_wrap=True)
    if breaches:
        raise BadInput([f"{fmu}, as {role}: {line}" for line in breaches])
    console.print(f"[green]{fmu} can take part as {role}[/]", highlight=False, soft_wrap=True)


@app.command
def pack(slave: str, *, grid: str = "40x40", output: Path):
    """Make an FMU of a slave written in one file, e.g. of the template of a lubrication model.

    Example: piston-cosim pack models/lubrication_template/axial_film.py:AxialFilm --output film.fmu

    Parameters
    ----------
    slave
        FILE.py:CLASS.
    grid
        Circumferential x axial cells.
    output
        Where to put the FMU.
    """
    from .fmi.builder import build_fmu_of_file

    output.write_bytes(build_fmu_of_file(slave, {"grid": parse_grid(grid)}, _say).read_bytes())
    console.print(str(output), soft_wrap=True, highlight=False)


@app.command
def export(kind: Literal["fmu", "ssp"], case: str, *, set_: Changes = [], output: Path):
    """Export a case: as one FMU with the iteration inside, for tools that cannot repeat a step, or as an SSP.

    Example: piston-cosim export fmu numerical_example --output engine.fmu

    Parameters
    ----------
    kind
        fmu or ssp.
    case
        Name of a case (see list), its folder, or a case file.
    set_
        Change of the case, KEY=VALUE.
    output
        Where to put it.
    """
    from .export import export_fmu
    from .ssp import export_ssp
    from .system import open_system

    path = find_case(case)
    tree = read_tree(path, [parse_change(text) for text in set_])
    checked = check_case(tree, path)
    if kind == "fmu":
        output.write_bytes(export_fmu(checked, path.parent, _say).read_bytes())
    else:
        export_ssp(tree, open_system(checked, path.parent, _say), output)
    console.print(str(output), soft_wrap=True, highlight=False)


@app.command
def report(*files: Path, output: Path = Path("report"), notes: Path | None = None):
    """Write one self-contained HTML page about one or several runs, and its figures as PNG and SVG.

    Example: piston-cosim report results/fired_motorcycle/flexible.h5 results/fired_motorcycle/rigid.h5 --output report

    Parameters
    ----------
    files
        Results files; the first one's case says what is shown.
    output
        Folder for report.html and the figures.
    notes
        Text file shown on the page, for example the case's README with the sources of its numbers.
    """
    from .html_report import write_report

    case, runs = open_runs(files)
    page = write_report(case, runs, output, notes.read_text() if notes else "")
    console.print(f"report   {page}", highlight=False, soft_wrap=True)


def open_runs(files):
    """Case of the first results file, and label -> Results of all; files of equal names are told apart by their folders."""
    from .recorder import Results

    missing = [f"{file}: no such file" for file in files if not file.is_file()]
    if missing or not files:
        raise BadInput(missing or "give one or more results files")
    labels = [file.stem if sum(f.stem == file.stem for f in files) == 1 else f"{file.parent.name}/{file.stem}" for file in files]
    runs = {label: Results(file) for label, file in zip(labels, files)}
    return check_case(next(iter(runs.values())).case, files[0]), runs


@app.command
def compare(*files: Path, x: str | None = None, y: list[str] = [], period: str | None = None, measured: Path | None = None,
            output: Path = Path("measured.png")):
    """Score curves: runs against the first, the last cycle against the one before, or runs against a measured file.

    Printed are the ratio of ranges (amplitude), the shift (phase, in SI, positive = later) and the rms difference over the
    reference's range.

    Example: piston-cosim compare results/fired_motorcycle/flexible.h5 --period "720 deg"

    Parameters
    ----------
    files
        Results files.
    x, y
        Abscissa and curves, participant.variable; by default those of the case's first picture.
    period
        Hold each run's last period against the one before it.
    measured
        CSV file headed "participant.variable [unit]", the abscissa first; the runs are scored against it and drawn with it.
    output
        Picture of runs and measured points.
    """
    from . import compare as curves

    case, runs = open_runs(files)
    lines = [picture for picture in case.pictures if picture.kind == "lines"]
    if not lines and not (x and y):
        raise BadInput("the case has no picture with lines: give --x and --y")
    x, y = x or lines[0].x, y or [port for panel in lines[0].y for port in panel]
    if measured:
        table = curves.read_measured(measured)
        rows = curves.against_measured(runs, table)
        console.print(f"picture  {curves.draw_measured(runs, table, output)}", highlight=False, soft_wrap=True)
    elif period:
        rows = curves.against_last_cycle(case, runs, x, y, period)
    elif len(runs) > 1:
        rows = curves.against_first(runs, x, y)
    else:
        raise BadInput("one run alone: give --period or --measured, or a second run")
    table = Table("run", "curve", "amplitude [-]", "phase", "rms [-]", box=None)
    for label, port, found in rows:
        table.add_row(label, port, f"{found['amplitude']:.4f}", f"{found['phase']:+.4g}", f"{found['rms']:.4f}")
    console.print(table)


@app.command
def sweep(case: str, *, vary: Annotated[list[str], Parameter(negative=())], set_: Changes = [], only: str | None = None,
          output: Path | None = None, workers: int | None = None, dask: str | None = None):
    """Run a case many times over values of its keys: one row a run in sweep.csv, and a picture.

    Stopped and started again, it goes on where it was. Points that fail stay as rows with their reason.

    Example: piston-cosim sweep fired_motorcycle --vary radial_clearance=10um..60um:6 --vary ovality=100um;200um

    Parameters
    ----------
    case
        Name of a case, its folder, or a case file.
    vary
        KEY=LOW..HIGH:COUNT or KEY=VALUE;VALUE, the key's dotted path or its last part; keys joined by + go together.
    set_
        Change of the case in all runs, KEY=VALUE.
    only
        This variant of the case instead of the case itself.
    output
        Folder; default results/sweep_<case>.
    workers
        Local processes, by default one a processor.
    dask
        Address of a Dask scheduler whose workers see the same folders, in place of local processes.
    """
    from . import sweep as sweeps
    from .sweep_pictures import draw_sweep

    path = find_case(case)
    changes = [parse_change(text) for text in set_]
    tree = read_tree(path, changes)
    if only:
        variant_trees(path, changes, only)
        changes += list(tree.get("variants", {}).get(only, {}).items())
    axes = [sweeps.parse_axis(text, tree) for text in vary]
    found = sweeps.points(path, changes, axes)
    folder = output or Path("results") / f"sweep_{path.parent.name if path.name == 'case.toml' else path.stem}"
    sweeps.build_all(found, path.parent, _say)

    def watch(row, done, total):
        shown = "  ".join(f"{axis.name.split('.')[-1]} {row[axis.name]}" for axis in axes)
        console.print(f"{done}/{total}  {row['status']:9s}  {shown}  {row['message']}", markup=False, highlight=False, soft_wrap=True)

    with (sweeps.dask_executor(dask) if dask else sweeps.local_executor(workers)) as executor:
        rows = sweeps.sweep(found, path.parent, folder, executor, watch)
    console.print(f"table    {folder / 'sweep.csv'}", highlight=False, soft_wrap=True)
    console.print(f"picture  {draw_sweep(rows, axes, tree.get('summary', {}), folder / 'sweep.png')}", highlight=False, soft_wrap=True)
    if not any(row["status"] == "done" for row in rows):
        sys.exit(2 if all(row["status"] == "bad input" for row in rows) else 1)


@app.command
def study(case: str, name: str, *, set_: Changes = [], output: Path | None = None, workers: int = 1):
    """Run a study of a case: a table of cost and of distance from its reference run, and pictures.

    Example: piston-cosim study numerical_example modes

    Parameters
    ----------
    case
        Name of a case, its folder, or a case file.
    name
        Of the study in the case file ([studies.NAME]).
    set_
        Change of the case in all runs, KEY=VALUE; it overrides the study.
    output
        Folder; default results/study_<case>_<name>. What is there from an earlier start is not run again.
    workers
        Processes; more than one disturbs the wall times.
    """
    from . import studies
    from . import sweep as sweeps
    from .pictures import draw

    path = find_case(case)
    checked, chosen, found = studies.study_points(path, [parse_change(text) for text in set_], name)
    folder = output or Path("results") / f"study_{path.parent.name}_{name}"
    sweeps.build_all(found, path.parent, _say)

    def watch(row, done, total):
        console.print(f"{done}/{total}  {row['status']:9s}  {row['run']}  {row['message']}", markup=False, highlight=False, soft_wrap=True)

    with sweeps.local_executor(workers) as executor:
        rows = sweeps.sweep(found, path.parent, folder, executor, watch)
    runs = studies.open_points(found, rows, folder)
    table = studies.study_table(chosen, checked, rows, runs)
    shown = Table("", *(row["run"] for row in table), box=None, title=chosen.title)
    for key in dict.fromkeys(key for row in table for key in row if key != "run"):
        shown.add_row(key, *(f"{v:.4g}" if isinstance(v := row.get(key, ""), float) else str(v) for row in table))
    console.print(shown)
    console.print(f"table    {studies.write_table(table, folder / 'study.csv')}", highlight=False, soft_wrap=True)
    console.print(f"picture  {studies.draw_study(chosen, checked, table, runs, folder / 'study.png')}", highlight=False, soft_wrap=True)
    for picture in draw(checked, runs, folder):
        console.print(f"picture  {picture}", highlight=False, soft_wrap=True)


@app.command
def fields(file: Path, *, field: Annotated[list[str], Parameter(negative=())], output: Path, time: str | None = None, i: int | None = None,
           j: int | None = None, radius: str = "1 m", length: str = "1 m"):
    """Write recorded fields as CSV, HDF5 or VTU (for ParaView), by the ending of --output.

    Example: piston-cosim fields results/numerical_example/flexible.h5 --field ehd.pressure+ehd.asperity_pressure --time "18 ms" --output p.csv

    Parameters
    ----------
    file
        Results file.
    field
        participant.field, or a sum (+) or product (*) of recorded fields; several allowed.
    output
        .csv, .h5, or .vtu.
    time
        Only the recorded instant nearest to this time.
    i, j
        Only this line of grid points (1-based); both: one grid point.
    radius, length
        Of the cylinder on which a VTU file shows the field.
    """
    from . import fields_export as exports
    from .fmi.quantities import to_si

    _, runs = open_runs((file,))
    (results,) = runs.values()
    if output.suffix not in (".csv", ".h5", ".vtu") or (output.suffix == ".vtu" and (i or j)):
        raise BadInput(f"--output {output}: write .csv, .h5, or .vtu (whole fields)")
    try:
        instant, size = None if time is None else to_si(time, "s"), [to_si(text, "m") for text in (radius, length)]
    except ValueError as error:
        raise BadInput(str(error)) from None
    blocks = [exports.chosen(exports.read_block(results, text), instant, i, j) for text in field]
    if output.suffix == ".vtu":
        console.print(f"{len(exports.write_vtu(blocks, output, *size))} files beside {output}", highlight=False, soft_wrap=True)
    else:
        (exports.write_csv if output.suffix == ".csv" else exports.write_hdf5)(blocks, output)
        console.print(f"fields   {output}", highlight=False, soft_wrap=True)
