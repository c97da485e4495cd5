"""Changes of a case by key: dotted, or as short as one place alone has it; the same in `--set`,
`--vary`, variants and studies.
"""

import tomllib
from collections.abc import Iterable, Iterator
from copy import deepcopy
from pathlib import Path
from typing import Any

from ..fmi.errors import BadInput, near
from ..fmi.option_classes import ANY, EACH
from .ahead import faults_ahead
from .checked import check_case
from .keys import case_keys
from .schema import Case

Tree = dict[str, Any]
ELSEWHERE = ("variants", "studies", "observers", "pictures", "axes")
"""Tables whose keys are no short names: changes themselves, and how things are shown."""
MOST_PLACES = 4
"""Dotted paths that a message lists."""


def changed(tree: Tree, changes: Iterable[tuple[str, Any]], folder: Path) -> Tree:
    """The TOML tree of a case with `changes` (pairs of key and value) made in it; the tree given
    stays as it is.

    Raises
    ------
    BadInput
        For every change that cannot be made.
    """
    tree = deepcopy(tree)
    faults = [fault for key, value in changes if (fault := change(tree, key, value, folder))]
    if faults:
        raise BadInput([*faults, *_other_faults(tree, folder)])
    return tree


def _other_faults(tree: Tree, folder: Path) -> list[str]:
    """Return the faults of a case that holds the changes that can be made."""
    try:
        return faults_ahead(check_case(tree, folder / "case.toml"), folder)
    except BadInput as error:
        return error.faults


def value_at(tree: Tree, key: str, folder: Path) -> Any:
    """Value at a key of a case's tree; KeyError with the key where there is none."""
    node: Any = tree
    try:
        for part in place(tree, key, folder):
            node = node[int(part) if isinstance(node, list) else part]
    except (BadInput, KeyError, IndexError, TypeError, ValueError):
        raise KeyError(key) from None
    return node


def change(tree: Tree, key: str, value: Any, folder: Path) -> str | None:
    """Set a key of a case's TOML tree. Tables on its way that a case may have are made; entries of
    lists are counted from 0. Returns a fault or None.
    """
    try:
        *parents, last = place(tree, key, folder)
    except BadInput as error:
        return str(error)
    node: Any = tree
    for k, part in enumerate(parents):
        if isinstance(node, list):
            inner = node[int(part)] if part.isdigit() and int(part) < len(node) else None
        else:
            inner = node.get(part)
        if inner is None and isinstance(node, dict) and _is_known(tree, [*parents, last], folder):
            inner = node[part] = {}
        if not isinstance(inner, (dict, list)):
            known = node if isinstance(node, dict) else map(str, range(len(node)))
            where = ".".join(parents[: k + 1])
            return f"{key}: expected a table {where} in the case, got nothing{near(part, known)}"
        node = inner
    if isinstance(node, list):
        return f"{key}: expected a key in an entry of a list, got the entry; count from 0"
    node[last] = value
    return None


def whole_key(tree: Tree, key: str, folder: Path) -> str:
    """The dotted path of a key that may be short.

    Raises
    ------
    BadInput
        If it is nowhere in a case, or in several places.
    """
    return ".".join(part if "." not in part else f'"{part}"' for part in place(tree, key, folder))


def place(tree: Tree, key: str, folder: Path) -> list[str]:
    """Parts of the dotted path of a key.

    A short one is its last part alone, or with some of those before it: `viscosity`,
    `ehd.viscosity`, `piston.modes`. Among several places one that the case file uses goes first.
    """
    parts = _parts(key)
    if parts[0] in tree or parts[0] in Case.model_fields:
        return parts
    there = [path for path in _paths(tree) if _ends(path, parts)]
    known = [] if there else _known(tree, folder)
    found = there or [path for path in known if _ends(path, parts)]
    if len(found) == 1 and EACH not in found[0] and ANY not in found[0]:
        return found[0]
    if not found:
        names = sorted({path[-1] for path in known})
        question = near(parts[-1], names) or "; `piston-cosim keys` lists all keys"
        raise BadInput(f"{key}: expected a key of the case, got an unknown key{question}")
    places = " or ".join(sorted(".".join(path) for path in found)[:MOST_PLACES])
    raise BadInput(f"{key}: expected a dotted path, got a name of several keys; write {places}")


def _ends(path: list[str], parts: list[str]) -> bool:
    """Whether parts stand in a path in their order, the last at its end."""
    left = iter(path[:-1])
    return path[-1] == parts[-1] and all(part in left for part in parts[:-1])


def _known(tree: Tree, folder: Path) -> list[list[str]]:
    """Paths of all keys that the case may have, those of any participant under its name."""
    paths = []
    for key in case_keys(tree, folder):
        path = key.path.split(".")
        if path[0] in ELSEWHERE:
            continue
        names = tree.get("participants", {}) if path[:2] == ["participants", ANY] else ()
        paths += [["participants", name, *path[2:]] for name in names] or [path]
    return paths


def _is_known(tree: Tree, path: list[str], folder: Path) -> bool:
    return path in _known(tree, folder)


def _paths(node: Tree, before: tuple[str, ...] = ()) -> Iterator[list[str]]:
    """Paths of all values of the tree that are no tables."""
    for key, value in node.items():
        if isinstance(value, dict):
            if before or key not in ELSEWHERE:
                yield from _paths(value, (*before, key))
        else:
            yield [*before, key]


def _parts(key: str) -> list[str]:
    """Parts of a dotted key; a part with dots of its own is quoted, as in TOML."""
    try:
        node, parts = tomllib.loads(f"{key} = 0"), []
    except tomllib.TOMLDecodeError:
        return key.split(".")
    while isinstance(node, dict):
        ((part, node),) = node.items()
        parts.append(part)
    return parts
