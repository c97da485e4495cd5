"""`piston-cosim sensitivities`."""

import csv
import sys

from rich.table import Table

from ..case.checked import check_case
from ..engine.measures import directions
from ..fmi.errors import BadInput, for_all
from ..fmi.quantities import numbers_text
from ..results.words import entry_shown, words_and_unit
from ..runs.design_space import ANGLES, DesignSpace, number_of, shapes_of
from ..runs.forward import by_differences, forward_or_differences
from ..runs.pool import LocalPool
from ..runs.sensitivities import Runs, map_of, use_of
from .common import (
    Changes,
    Only,
    OutputFolder,
    Workers,
    changed_case,
    print_line,
    say,
    wide_console,
)


def command(
    case: str,
    /,
    *,
    by: list[str] = [],
    shapes: str | None = None,
    amplitude: str = "1 um",
    set_: Changes = [],
    only: Only = None,
    output: OutputFolder | None = None,
    workers: Workers | None = None,
    forward: bool = False,
):
    """Compute how the main results change with numbers and profile.

    Every variable has two runs, with a step up and a step down. The table has half of the
    difference, and the spread: half of the difference of both one-sided changes. A change below
    its spread is in brackets. The command also writes sensitivities.csv and a picture, and with
    shapes a map of the skirt.

    Example: piston-cosim sensitivities data_sheet --by radial_clearance=1um --by viscosity

    Parameters
    ----------
    case
        Name of a case, its folder or its file. `piston-cosim list` prints the names.
    by
        KEY or KEY=STEP, repeatable. KEY is a dotted path or its last part. Keys joined by + change
        together. Default of a step: 2 % of the value.
    shapes
        Shapes of the profile of the skirt, HEIGHTSxORDERS: number of B-splines in height and of
        orders around, e.g. 5x3. They keep the mean clearance.
    amplitude
        Step of the shapes.
    set_
        Change of the case in all runs, KEY=VALUE; repeatable.
    only
        Variant of the case to run. Default: the case itself.
    output
        Folder. Default: results/sensitivities_CASE. Finished runs in it are reused.
    workers
        Number of processes. Default: the number of processors.
    forward
        Use the derivative of one run instead of two runs for each variable, where the case allows
        it. The command prints its accuracy and what it holds, or why the case has runs instead.
    """
    path, _, tree, folder = changed_case(case, set_, only, output, "sensitivities")
    if not by and not shapes:
        raise BadInput("--by: expected at least one KEY, or --shapes")
    checked = check_case(tree, path)
    numbers = for_all(lambda text: number_of(tree, text, path.parent, "--by"), by)
    skirt = shapes_of(checked, tree, shapes, amplitude, folder / "shapes") if shapes else None
    space = DesignSpace(tuple(numbers), skirt)

    def watch(done, total, row):
        print_line(f"{done}/{total}  {row['status']:9s}  {row['message']}", markup=False)

    with use_of(folder), LocalPool(workers) as executor:
        runs = Runs(tree, path, space, folder, executor, watch=watch)
        find = forward_or_differences if forward else by_differences
        effects, failed, notes = find(runs, [*directions(checked)])
    for note in notes:
        say(note)
    steps = dict.fromkeys(space.names, f"+{amplitude}") | {n.name: n.step_text for n in numbers}
    _print(effects, steps)
    _write(effects, steps, folder / "sensitivities.csv")
    _draw(effects, steps, folder)
    if skirt:
        _draw_maps(effects, skirt, folder)
    if failed:
        say(f"{len(failed)} runs failed: {failed[0]['message']}; call again to try them again")
        sys.exit(1)


def _print(effects, steps):
    """Print a row for each figure, and a column for each variable that is a number."""
    names = [name for name in steps if not name.startswith("shape ")][:MOST_COLUMNS]
    if not names:
        return
    table = Table("", "value", *(f"{n}, {steps[n]}" for n in names), box=None, pad_edge=False)
    for figure in dict.fromkeys(one.figure for one in effects):
        own = {one.variable: one for one in effects if one.figure == figure}
        if not any(one.change or one.spread for one in own.values()):
            continue
        cells = []
        value = next(iter(own.values())).value
        for name in names:
            one = own.get(name)
            if one is None:
                cells.append("failed")
                continue
            shown = entry_shown(figure, [one.change, one.spread])
            text = f"{numbers_text(*shown.values)} {shown.unit}".strip()
            cells.append(text if one.is_resolved else f"({text})")
        shown = entry_shown(figure, [value])
        table.add_row(shown.words, f"{shown.values[0]:.4g} {shown.unit}".strip(), *cells)
    wide_console().print(table, highlight=False, markup=False)


MOST_COLUMNS = 6
"""Number of variables in the printed table; the file has all of them."""


def _write(effects, steps, path):
    """Write all sensitivities, in SI units."""
    with open(path, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["figure", "variable", "step", "value", "change", "spread"])
        for one in effects:
            writer.writerow(
                [one.figure, one.variable, steps[one.variable], one.value, one.change, one.spread]
            )
    print_line(f"table    {path}")


def _draw(effects, steps, folder):
    from ..results.design_pictures import draw_effects

    percents = {}
    for one in effects:
        if one.value and (one.change or one.spread):
            words, _ = words_and_unit(one.figure)
            percent = 100.0 * one.change / abs(one.value), 100.0 * one.spread / abs(one.value)
            percents.setdefault(words, {})[one.variable] = percent
    if percents:
        print_line(f"picture  {draw_effects(percents, steps, folder / 'sensitivities.png')}")


def _draw_maps(effects, skirt, folder):
    from ..results.design_pictures import draw_maps

    maps = {}
    for figure in dict.fromkeys(one.figure for one in effects):
        slopes = {
            one.variable: one.change / skirt.amplitude for one in effects if one.figure == figure
        }
        if all(name in slopes for name in skirt.names) and any(slopes[n] for n in skirt.names):
            values = map_of(skirt, [slopes[name] for name in skirt.names])
            shown = entry_shown(figure, (1e-8 * values).ravel().tolist())
            title = f"{shown.words} [{shown.unit or '1'} per µm on 1 % of the skirt]"
            maps[title] = shown.values.reshape(values.shape)
    if maps:
        picture = draw_maps(maps, ANGLES, 1e3 * skirt.heights, folder / "maps.png")
        print_line(f"maps     {picture}")
