"""A case from parts: tables of an extended case, copies of participants, wires of films."""

from copy import deepcopy
from os.path import isfile, join, normpath
from pathlib import Path
from typing import Any, TypeGuard

from ..fmi.errors import BadInput, unknown
from .changes import Tree, split_key
from .contract import contract

ENTRIES = {"wires": "to", "axes": "participants", "pictures": "file"}
"""Lists of tables whose entries are added to those of the extended case, and the key that
identifies an entry."""
WITH_FILES = ("participants", "variants", "studies")
"""Tables whose texts may name files."""


def extended(base: Tree, tree: Tree, place: str, folder: Path) -> Tree:
    """Return the tree of a case that extends another one.

    Parameters
    ----------
    base : dict
        Tree of the extended case.
    tree : dict
        Own tree, with the keys `extends` and `without`.
    place : str
        Folder of the extended case, relative to the own `folder`.
    folder : Path

    Raises
    ------
    BadInput
        If `without` names a key that the extended case does not have.
    """
    for key in tree.pop("without", []):
        *parents, last = split_key(key)
        node: Any = base
        for part in parents:
            node = node.get(part) if isinstance(node, dict) else None
        if not isinstance(node, dict) or last not in node:
            raise BadInput(f"without: expected a key of {tree['extends']}, got {key!r}")
        del node[last]
    del tree["extends"]
    moved = {key: _moved(base[key], place, folder) for key in WITH_FILES if key in base}
    return _merged(base | moved, tree)


def _moved(node: Any, place: str, folder: Path) -> Any:
    """Return a part of a tree whose names of files in `place` are relative to `folder`."""
    if isinstance(node, dict):
        return {key: _moved(value, place, folder) for key, value in node.items()}
    if isinstance(node, list):
        return [_moved(value, place, folder) for value in node]
    if not isinstance(node, str):
        return node
    path = normpath(join(place, node))
    file = path.partition(":")[0]  # FILE.py:CLASS
    return path if isfile(join(folder, file)) else node


def _merged(base: Tree, tree: Tree) -> Tree:
    """Return the tables of `base` with those of `tree`; entries of `ENTRIES` are added."""
    merged = dict(base)
    for key, value in tree.items():
        old = merged.get(key)
        if isinstance(old, dict) and isinstance(value, dict):
            merged[key] = _merged(old, value)
        elif key in ENTRIES and _are_tables(old) and _are_tables(value):
            merged[key] = _with_entries(old, value, ENTRIES[key])
        else:
            merged[key] = value
    return merged


def _with_entries(old: list[Tree], new: list[Tree], key: str) -> list[Tree]:
    """Return a list of tables with others; one with a known value of `key` changes the old one."""
    entries = list(old)
    known = {str(one.get(key)): k for k, one in enumerate(old)}
    for one in new:
        k = known.get(str(one.get(key)))
        if k is None:
            entries.append(one)
        else:
            entries[k] = _merged(entries[k], one)
    return entries


def _are_tables(value: Any) -> TypeGuard[list[Tree]]:
    return isinstance(value, list) and all(isinstance(one, dict) for one in value)


def expanded(tree: Tree) -> Tree:
    """Return a tree without the keys `like` and `body` of participants.

    A participant `like` another one has the keys of that one as well. One that names its `body` has
    the contract's wires. The keys of an own wire to the same input replace those of the contract.
    """
    tables = tree.get("participants")
    if not isinstance(tables, dict):
        return tree
    composed: Tree = {}
    wires: list[Tree] = []
    for name, table in tables.items():
        if not isinstance(table, dict):
            return tree
        own = {key: value for key, value in table.items() if key != "like"}
        if "like" in table:
            if table["like"] not in composed:
                fault = unknown("participant", str(table["like"]), composed)
                raise BadInput(f"participants.{name}.like: {fault}")
            own = _merged(deepcopy(composed[table["like"]]), own)
        composed[name] = own
    for name, table in composed.items():
        if body := table.get("body"):
            wires += _film_wires(name, str(body), table.get("build"))
    bare = {
        name: {key: value for key, value in table.items() if key != "body"}
        for name, table in composed.items()
    }
    return _merged({"wires": wires} if wires else {}, tree | {"participants": bare})


def _film_wires(film: str, body: str, build: Any) -> list[Tree]:
    """Return the wires between a film and its body."""
    terms = contract()["lubrication"]
    bearing = isinstance(build, dict) and build.get("surface") == "bearing"
    names = terms.around if bearing else {}

    def wire(source: str, target: str, field: str) -> Tree:
        name = names.get(field, field)
        return {"from": f"{source}.{name}", "to": f"{target}.{name}"}

    wires = []
    for field, keys in terms.wires.items():
        conjugate = names.get(keys["conjugate"], keys["conjugate"])
        wires.append(wire(body, film, field) | keys | {"conjugate": f"{film}.{conjugate}"})
    return wires + [wire(film, body, field) for field in terms.outputs["field"]]
