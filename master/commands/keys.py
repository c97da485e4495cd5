"""`piston-cosim keys`."""

import json
from typing import Annotated

from cyclopts import Parameter
from rich.table import Table

from ..case.keys import case_keys, chosen_keys, json_schema
from ..case.schema import find_case, read_tree
from ..fmi.option_classes import Key
from .common import console, wide_console


def command(
    part: str | None = None,
    *,
    case: str = "data_sheet",
    json_schema_: Annotated[bool, Parameter(name="--json-schema", negative=())] = False,
):
    """List every key of a case file, parameters of the FMUs included: unit, default, allowed
    values, meaning.

    Example: piston-cosim keys piston; piston-cosim keys ehd.parameters; piston-cosim keys viscosity

    Parameters
    ----------
    part
        Only keys whose dotted path holds this; all without it.
    case
        Case whose participants are listed.
    json_schema_
        Print a JSON schema of such a case in place of the list, for editors.
    """
    path = find_case(case)
    tree = read_tree(path)
    if json_schema_:
        print(json.dumps(json_schema(tree, path.parent), indent=1))
        return
    found = case_keys(tree, path.parent)
    chosen = chosen_keys(found, part) if part else found
    wide = wide_console()
    tables: dict[str, list[Key]] = {}
    for key in chosen:
        tables.setdefault(key.path.rpartition(".")[0], []).append(key)
    for place, group in tables.items():
        console.print(f"\n[bold]{place or 'case'}[/]", highlight=False)
        table = Table("key", "unit", "default", "allowed", "meaning", box=None, padding=(0, 1))
        table.columns[0].no_wrap = True
        for key in group:
            default = "(required)" if key.required else key.default
            table.add_row(key.name, key.unit, default, key.allowed, key.meaning)
        wide.print(table, markup=False)
