"""Changes of a case by key, dotted or short: `--set`, `--vary`, variants and studies.

A short key must be unique.
"""

import tomllib
from collections.abc import Iterable, Iterator
from copy import deepcopy
from pathlib import Path
from typing import Any

from ..fmi.errors import BadInput, near, unknown
from ..fmi.option_classes import ANY, EACH
from .ahead import faults_ahead
from .checked import check_case
from .keys import case_keys
from .schema import Case

Tree = dict[str, Any]
ELSEWHERE = ("variants", "studies", "observers", "pictures", "axes")
"""Tables without short names of keys: those with changes, and those of pictures."""
MOST_PLACES = 4
"""Maximum number of dotted paths in a message."""


def changed(tree: Tree, changes: Iterable[tuple[str, Any]], folder: Path) -> Tree:
    """Return a copy of a case's TOML tree with `changes` (pairs of key and value).

    Raises
    ------
    BadInput
        With every change that cannot be made.
    """
    tree = deepcopy(tree)
    faults = [fault for key, value in changes if (fault := change(tree, key, value, folder))]
    if faults:
        raise BadInput([*faults, *_other_faults(tree, folder)])
    return tree


def _other_faults(tree: Tree, folder: Path) -> list[str]:
    """Return the faults of a case with those changes that can be made."""
    try:
        return faults_ahead(check_case(tree, folder / "case.toml"), folder)
    except BadInput as error:
        return error.faults


def changes_of_variant(tree: Tree, label: str, key: str = "--only") -> Tree:
    """Return the changes of a variant of a case, none for the case itself: key -> value.

    Raises `BadInput` with the fault of `key` for an unknown label.
    """
    known = {tree.get("label", "base"): {}} | tree.get("variants", {})
    if label not in known:
        raise BadInput(f"{key}: {unknown('variant', label, known)}")
    return known[label]


def value_at(tree: Tree, key: str, folder: Path) -> Any:
    """Return the value at a key of a case's tree; raise `KeyError` if there is none."""
    node: Any = tree
    try:
        for part in key_parts(tree, key, folder):
            node = node[int(part) if isinstance(node, list) else part]
    except (BadInput, KeyError, IndexError, TypeError, ValueError):
        raise KeyError(key) from None
    return node


def change(tree: Tree, key: str, value: Any, folder: Path) -> str | None:
    """Set a key of a case's TOML tree; return a fault or None.

    Missing tables that a case may have are created. Entries of lists are counted from 0.
    """
    try:
        *parents, last = key_parts(tree, key, folder)
    except BadInput as error:
        return str(error)
    node: Any = tree
    for k, part in enumerate(parents):
        if isinstance(node, list):
            inner = node[int(part)] if part.isdigit() and int(part) < len(node) else None
        else:
            inner = node.get(part)
        if (
            inner is None
            and isinstance(node, dict)
            and [*parents, last] in _possible_paths(tree, folder)
        ):
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
    """Return the dotted path of a key that may be short.

    Raises
    ------
    BadInput
        If no key or several keys match.
    """
    return ".".join(
        part if "." not in part else f'"{part}"' for part in key_parts(tree, key, folder)
    )


def whole_keys(tree: Tree, text: str, folder: Path, option: str) -> tuple[str, ...]:
    """Return the dotted paths of keys joined by "+"; `option` is named in faults."""
    try:
        return tuple(whole_key(tree, key.strip(), folder) for key in text.split("+"))
    except BadInput as error:
        raise BadInput([f"{option} {line}" for line in error.faults]) from None


def toml_value(text: str) -> Any:
    """Return the TOML value of a text, or the text without quotes if it is not valid TOML."""
    try:
        return tomllib.loads(f"v = {text}")["v"]
    except tomllib.TOMLDecodeError:
        return text.strip().strip("\"'")


def key_parts(tree: Tree, key: str, folder: Path) -> list[str]:
    """Return the parts of the dotted path of a key.

    A short key is the last part of a path, optionally with some of the parts before it:
    `viscosity`, `ehd.viscosity`, `piston.modes`. Paths that the case file uses have priority.
    """
    parts = split_key(key)
    if parts[0] in tree or parts[0] in Case.model_fields:
        return parts
    in_tree = [path for path in _paths(tree) if _ends(path, parts)]
    known = [] if in_tree else _possible_paths(tree, folder)
    matches = in_tree or [path for path in known if _ends(path, parts)]
    if len(matches) == 1 and EACH not in matches[0] and ANY not in matches[0]:
        return matches[0]
    if not matches:
        names = sorted({path[-1] for path in known})
        question = near(parts[-1], names) or "; `piston-cosim keys` lists all keys"
        raise BadInput(f"{key}: expected a key of the case, got an unknown key{question}")
    places = " or ".join(sorted(".".join(path) for path in matches)[:MOST_PLACES])
    raise BadInput(f"{key}: expected a dotted path, got a name of several keys; write {places}")


def _ends(path: list[str], parts: list[str]) -> bool:
    """Return whether a path contains the parts in their order and ends with the last one."""
    left = iter(path[:-1])
    return path[-1] == parts[-1] and all(part in left for part in parts[:-1])


def _possible_paths(tree: Tree, folder: Path) -> list[list[str]]:
    """Return the paths of all keys that the case may have, for each participant by name."""
    paths = []
    for key in case_keys(tree, folder):
        path = key.path.split(".")
        if path[0] in ELSEWHERE:
            continue
        names = tree.get("participants", {}) if path[:2] == ["participants", ANY] else ()
        paths += [["participants", name, *path[2:]] for name in names] or [path]
    return paths


def _paths(node: Tree, before: tuple[str, ...] = ()) -> Iterator[list[str]]:
    """Yield the paths of all values of the tree that are not tables or lists of tables."""
    for key, value in node.items():
        if isinstance(value, dict):
            if before or key not in ELSEWHERE:
                yield from _paths(value, (*before, key))
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            if before or key not in ELSEWHERE:
                for k, entry in enumerate(value):
                    yield from _paths(entry, (*before, key, str(k)))
        else:
            yield [*before, key]


def split_key(key: str) -> list[str]:
    """Return the parts of a dotted key; a part that contains dots is quoted, as in TOML."""
    try:
        node, parts = tomllib.loads(f"{key} = 0"), []
    except tomllib.TOMLDecodeError:
        return key.split(".")
    while isinstance(node, dict):
        ((part, node),) = node.items()
        parts.append(part)
    return parts
