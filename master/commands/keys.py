"""`piston-cosim keys`."""

import json
from dataclasses import replace
from typing import Annotated

from cyclopts import Parameter
from rich.table import Table

from ..case.keys import case_keys, chosen_keys, json_schema, library_oils, matching_oils
from ..case.reading import find_case, read_tree
from ..fmi.errors import BadInput
from ..fmi.option_classes import Key
from .common import console, say, wide_console


def command(
    word: str | None = None,
    /,
    *,
    case: str = "data_sheet",
    advanced: Annotated[bool, Parameter(negative=())] = False,
    json_schema_: Annotated[bool, Parameter(name="--json-schema")] = False,
):
    """List the keys of a case file.

    The list shows unit, default, allowed values and meaning. It includes the parameters of the FMUs
    and, for the word oil or the name of an oil, the oil library.

    Example: piston-cosim keys clearance

    Example: piston-cosim keys participants.ehd.parameters

    Example: piston-cosim keys oil

    Parameters
    ----------
    word
        Print only the table of this dotted path, or the keys whose name, meaning or synonym
        contains this word. Default: all keys.
    case
        Case whose participants are listed.
    advanced
        Print also the keys that few cases need. A word that selects no other key prints them too.
    json_schema_
        Print a JSON schema of such a case for editors.
    """
    path = find_case(case)
    tree = read_tree(path)
    if json_schema_:
        print(json.dumps(json_schema(tree, path.parent), indent=1))
        return
    all_keys = case_keys(tree, path.parent)
    oils = matching_oils(library_oils(tree), word) if word else []
    try:
        chosen, is_table = chosen_keys(all_keys, word) if word else (all_keys, True)
    except BadInput:
        if not oils:
            raise
        chosen, is_table = [], False
    usual = [key for key in chosen if advanced or not key.advanced] or chosen
    if is_table:
        print_tables(usual)
    elif usual:
        _print(usual, "path")
    if omitted := len(chosen) - len(usual):
        say(f"keys that few cases need: {omitted} more, see --advanced")
    if oils:
        print_oils(oils)


def print_tables(keys: list[Key]):
    """Print keys by the table of the case file that they are in, tables with the same keys once."""
    tables: dict[str, list[Key]] = {}
    for key in keys:
        table = key.path.rpartition(".")[0] or "case"
        tables.setdefault(table, []).append(replace(key, path=key.name))
    names: dict[tuple[Key, ...], list[str]] = {}
    for name, group in tables.items():
        names.setdefault(tuple(group), []).append(name)
    for group, heads in names.items():
        console.print("", *(f"[bold]{name}[/]" for name in heads), sep="\n", highlight=False)
        _print(group, "name")


def _print(keys, column):
    table = Table("key", "unit", "default", "allowed", "meaning", box=None, padding=(0, 1))
    table.columns[0].no_wrap = True
    for key in keys:
        default = "(required)" if key.required else key.default
        table.add_row(getattr(key, column), key.unit, default, key.allowed, key.meaning)
    wide_console().print(table, markup=False)


def print_oils(oils):
    """Print oils of the library; `oil = "NAME"` in the build table of the film selects one."""
    heads = ("oil", "at 40 C \\[mPa s]", "at 100 C \\[mPa s]", "title", "source")
    table = Table(*heads, box=None, padding=(0, 1))
    table.columns[0].no_wrap = True
    for oil in oils:
        cold, hot = (f"{1e3 * viscosity:.3g}" for viscosity in oil.viscosity)
        table.add_row(oil.name, cold, hot, oil.title, oil.source)
    console.print('\n[bold]oil library[/]: select with oil = "NAME"', highlight=False)
    wide_console().print(table)
