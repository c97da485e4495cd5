"""`piston-cosim optimise`."""

import csv
import re
import sys
from contextlib import ExitStack
from typing import Annotated

import numpy as np
from cyclopts import Parameter

from ..case.changes import whole_key
from ..case.checked import check_case
from ..engine.measures import directions
from ..fmi.cache import write_whole
from ..fmi.errors import BadInput, for_all
from ..results.words import entry_in_words, words_and_unit
from ..runs.design_space import ANGLES, DesignSpace, range_of, shapes_of, start_of
from ..runs.optimisation import LIMIT_TOLERANCE, Search, Task, known_figure, limit_of, optimise
from ..runs.pool import LocalPool
from ..runs.sensitivities import Runs, map_of, use_of
from .common import (
    Changes,
    Only,
    OutputFolder,
    Whole,
    Workers,
    changed_case,
    parse_change,
    print_compared,
    print_line,
    say,
)
from .usage import positive


def command(
    case: str,
    goal: str,
    /,
    *,
    vary: list[str] = [],
    shapes: str | None = None,
    amplitude: str = "6 um",
    limit: list[str] = [],
    at: list[str] = [],
    start: list[str] = [],
    gradients: Annotated[Whole, Parameter(validator=positive)] = 15,
    uncertainty: Annotated[bool, Parameter(negative=())] = False,
    set_: Changes = [],
    only: Only = None,
    output: OutputFolder | None = None,
    workers: Workers | None = None,
):
    """Find the best numbers and profile of a case within limits.

    The goal is a figure of the table of a sweep, lower or higher, whichever is better. With several
    operating points, the goal is the mean of its ratios to those of the case, and every limit holds
    at each point. Each gradient takes a run for every variable and point, all at the same time. The
    command compares the result with the case at every point, and writes variables, profile,
    pictures and results files. A repeated call reuses finished runs.

    Example: piston-cosim optimise numerical_example mean_friction_power_w --shapes 5x3
    --limit minimum_film_thickness_m --limit "maximum_pressure_pa<=4 MPa"

    Parameters
    ----------
    case
        Name of a case, its folder or its file. `piston-cosim list` prints the names.
    goal
        Figure to improve, such as mean_friction_power_w.
    vary
        KEY=LOW..HIGH, repeatable: number to vary. Keys joined by + have one value.
    shapes
        Shapes of the profile of the skirt, HEIGHTSxORDERS: number of B-splines in height and of
        orders around, e.g. 5x3. They keep the mean clearance.
    amplitude
        Largest amplitude of each shape.
    limit
        FIGURE (not worse than in the case), FIGURE<=VALUE or FIGURE>=VALUE, repeatable.
    at
        Operating point: changes KEY=VALUE, separated by commas; repeatable. Default: the case.
    start
        KEY=VALUE, repeatable: value of a varied number at which the search begins. The limits stay
        those of the case. Default: its value in the case.
    gradients
        Maximum number of gradients.
    uncertainty
        Compute the uncertainties of case and result from a second grid and doubled steps.
    set_
        Change of the case in all runs, KEY=VALUE; repeatable.
    only
        Variant of the case to run. Default: the case itself.
    output
        Folder. Default: results/optimise_CASE. Finished runs in it are reused.
    workers
        Number of processes. Default: the number of processors.
    """
    path, _, tree, folder = changed_case(case, set_, only, output, "optimise")
    if not vary and not shapes:
        raise BadInput("--vary: expected at least one KEY=LOW..HIGH, or --shapes")
    checked = check_case(tree, path)
    ways = directions(checked)
    known_figure(goal, ways, "GOAL")
    limits = for_all(lambda text: limit_of(text, ways), limit)
    points = for_all(_point, at) or [[]]
    ranges = for_all(lambda text: range_of(tree, text, path.parent, "--vary"), vary)
    skirt = shapes_of(checked, tree, shapes, amplitude, folder / "shapes") if shapes else None
    space = DesignSpace(tuple(number for number, *_ in ranges), skirt)
    for_all(
        lambda key: _check_point(tree, key, path.parent, space), [k for p in points for k, _ in p]
    )
    if ways[goal] == "none":
        say(f"warning: GOAL: a design wants {goal} neither lower nor higher; the search lowers it")
    count = len(space.names) - len(ranges)
    bounds = tuple((low, high) for _, low, high in ranges) + ((-1.0, 1.0),) * count
    sign = -1.0 if ways[goal] == "raise" else 1.0
    task = Task(
        goal=goal,
        sign=sign,
        limits=tuple(limits),
        points=tuple(points),
        bounds=bounds,
        gradients=gradients,
        start=(*start_of(ranges, start), *[0.0] * count),
    )

    def watch(value, slack):
        excess = "" if slack >= -LIMIT_TOLERANCE else f", {-100 * slack:.1f} % beyond a limit"
        print_line(f"design {len(search.history)}: {100 * abs(value):.2f} % of the case{excess}")

    with use_of(folder), LocalPool(workers) as executor:
        lean = tree | {"record": tree.get("record", {}) | {"fields": []}}
        search = Search(task, Runs(lean, path, space, folder, executor, keeps=False), watch)
        best = optimise(search)
        whole = Runs(tree, path, space, folder, executor)
        designs = [best.shares, np.zeros(len(bounds))]
        rows = whole.rows(designs, task.points, uncertainty)
    print_line(
        f"{best.message}: {abs(best.after / best.before) - 1.0:+.2%} of {entry_in_words(goal)}"
    )
    is_whole = _compare(rows, points)
    _say_active(best, points)
    _write(space, best, folder)
    _draw(space, best, folder, skirt)
    if best.slack < -LIMIT_TOLERANCE:
        say(f"no design keeps all limits; this one is {-100 * best.slack:.1f} % beyond one")
    if not is_whole or best.slack < -LIMIT_TOLERANCE:
        sys.exit(1)


def _point(text):
    """Return the changes of an operating point."""
    try:
        return for_all(parse_change, re.split(r",(?=[^,=]*=)", text))  # not inside a list
    except BadInput as error:
        raise BadInput([line.replace("--set", "--at") for line in error.faults]) from None


def _check_point(tree, key, folder, space):
    """Raise `BadInput` if the key of an operating point is unknown or varied."""
    try:
        whole = whole_key(tree, key, folder)
    except BadInput as error:
        raise BadInput([f"--at {line}" for line in error.faults]) from None
    if any(whole in one.keys for one in space.numbers):
        raise BadInput(f"--at {key}: expected a key that is not varied, got one of --vary")


def _compare(rows, points):
    """Print the comparison of case and result at each point; return whether all have finished."""
    from ..results.file import Results

    for k, (point, after, before) in enumerate(zip(points, rows, rows[len(points) :])):
        files = {}
        for name, row in (("result", after), ("case", before)):
            if row["status"] != "done":
                say(f"warning: {name}: {row['message']}")
                return False
            files[name] = row["results"]
        if len(points) > 1:
            print_line(
                ", ".join(f"{key} {value}" for key, value in point) or "the case", markup=False
            )
        with ExitStack() as opened:
            print_compared({n: opened.enter_context(Results(f)) for n, f in files.items()})
        for name, file in files.items():
            print_line(f"results  {name}{f', point {k + 1}' if len(points) > 1 else ''}: {file}")
    return True


def _say_active(best, points):
    """Print the limits that the result reaches."""
    for one in best.active:
        words = words_and_unit(one.limit.figure)[0]
        where = f" at point {one.point + 1}" if len(points) > 1 else ""
        gain = f"1 % of it changes the goal by {one.multiplier:.2g} %"
        print_line(f"limit    {words}{where} is reached: {gain}")


def _write(space, best, folder):
    """Write the variables, and the profile as a table."""
    with open(folder / "design.csv", "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["variable", "value", "unit"])
        for number, share in zip(space.numbers, best.shares):
            writer.writerow([number.name, number.value + share * number.scale, number.unit])
        if space.shapes:
            for name, share in zip(space.shapes.names, best.shares[len(space.numbers) :]):
                writer.writerow([name, 1e6 * space.shapes.amplitude * share, "um"])
    print_line(f"design   {folder / 'design.csv'}")
    if space.shapes:
        profile = space.shapes.profile(best.shares[len(space.numbers) :])
        write_whole(folder / "profile.csv", space.shapes.table(profile))
        print_line(f"profile  {folder / 'profile.csv'}, a further table of build.piston.profiles")


def _draw(space, best, folder, skirt):
    from ..results.design_pictures import draw_maps, draw_search

    designs = [(one.value, one.slack) for one in best.history]
    print_line(f"picture  {draw_search(designs, LIMIT_TOLERANCE, folder / 'search.png')}")
    if skirt:
        own = slice(len(space.numbers), None)
        slopes = 100.0 * best.gradient[own] / skirt.amplitude
        maps = {
            "profile, positive away from the bore [µm]": 1e6 * skirt.profile(best.shares[own]),
            "goal [% per µm on 1 % of the skirt]": 1e-8 * map_of(skirt, slopes),
        }
        print_line(f"maps     {draw_maps(maps, ANGLES, 1e3 * skirt.heights, folder / 'maps.png')}")
