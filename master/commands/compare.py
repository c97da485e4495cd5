"""`piston-cosim compare`."""

from pathlib import Path

from rich.markup import escape
from rich.table import Column, Table

from ..fmi.errors import BadInput
from .common import Changes, OutputFolder, console, draw_pictures, parse_changes, say, tell


def command(
    case: str,
    /,
    *,
    lubrication: list[str],
    set_: Changes = [],
    output: OutputFolder | None = None,
):
    """Compare lubrication models on a case.

    The command runs the case with each model and compares film, load, friction and cost. The first
    model is the reference. The command also draws pictures of all models.

    Example: piston-cosim compare numerical_example --lubrication jfo --lubrication gumbel
    --lubrication film.fmu

    Parameters
    ----------
    case
        Name of a case, its folder or its file.
    lubrication
        An FMU, a model class FILE.py:CLASS, or a cavitation model of the case; give two or more.
        In a case with several films write PARTICIPANT=MODEL.
    set_
        Change of the case, KEY=VALUE; repeatable.
    output
        Folder for results; default: results/CASE_models.
    """
    from ..case.checked import check_case
    from ..case.reading import find_case, read_tree
    from ..results.file import Results
    from ..results.rivals import draw_rivals, exchange, measures, rivals_of, rows_of
    from ..runs.console import watching
    from ..runs.run import run
    from .run import open_all

    role = "lubrication"
    faults = [
        f"--{role}: expected an FMU, got no such file {model!r}"
        for model in lubrication
        if model.endswith(".fmu")
        and not Path(model).is_file()
        and not Path(model.partition("=")[2]).is_file()
    ]
    if len(lubrication) < 2:
        faults.append(f"--{role}: expected at least two, got {len(lubrication)}")
    if faults:
        raise BadInput(faults)
    path = find_case(case)
    rivals = rivals_of(read_tree(path, parse_changes(set_)), role, lubrication, say)
    for label, keys in rivals.left_out.items():
        if keys:
            say(f"{label} lacks the variables of these keys: {', '.join(keys)}")
    cases = {label: check_case(tree, path) for label, tree in rivals.trees.items()}
    folder = output or Path("results") / f"{path.parent.name}_models"
    summaries = {}
    runs = {}
    for label, system in open_all(cases, path.parent).items():
        file = folder / f"{label}.h5"
        with watching(console, label) as watch:
            summaries[label] = run(system, cases[label], rivals.trees[label], file, watch)
        runs[label] = Results(file)
    exchanged = {label: exchange(results, rivals.ports) for label, results in runs.items()}
    print_measures(rows_of(role), measures(role, exchanged, summaries))
    iterations = {
        label: (results.time, results.series("coupling.iterations").values)
        for label, results in runs.items()
    }
    draw_rivals(role, exchanged, iterations, folder / "models.png")
    tell(f"picture  {folder / 'models.png'}")
    draw_pictures(check_case(rivals.common, path), runs, folder)


def print_measures(names, values):
    """Print the measures of the models, one column each, with the difference from the first."""
    table = Table(Column(no_wrap=True), *values, box=None)
    first = next(iter(values.values()))
    for k, (name, unit) in enumerate(names.items()):
        cells = [f"{first[k]:.5g}"]
        for row in list(values.values())[1:]:
            cells.append(
                f"{row[k]:.5g}"
                + (f"  ({100 * (row[k] / first[k] - 1):+.1f} %)" if first[k] else "")
            )
        table.add_row(escape(f"{name} [{unit}]" if unit else name), *cells)
    console.print(table)
