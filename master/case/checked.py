"""Conversion of a TOML tree into a case, with all faults in one message."""

from copy import deepcopy
from itertools import takewhile
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from ..fmi.errors import BadInput
from ..fmi.option_classes import is_key, sentences, without_flags
from .ahead import faults_ahead
from .optional_wires import with_optional_wires
from .schema import Case


def check_case(tree: dict[str, Any], path: Path) -> Case:
    """Return the `Case` of a TOML tree; raise `BadInput` with every fault and its path.

    `path` is the file of the case or its folder.
    """
    tree = with_optional_wires(without_flags(tree, Case))
    try:
        return Case.model_validate(tree)
    except ValidationError as error:
        faults = sentences(error, Case)
        folder = Path(path) if Path(path).is_dir() else Path(path).parent
        deeper = _faults_below(tree, error, folder)
    raise BadInput([*faults, *(one for one in deeper if _key(one) not in map(_key, faults))])


def _key(fault: str) -> str:
    """Return the key of a fault."""
    return fault.partition(": ")[0]


MOST_ROUNDS = 4
"""Maximum number of rounds in which entries are removed, to find faults that others hide."""


def _faults_below(tree, error: ValidationError, folder: Path) -> list[str]:
    """Return the faults of a case that its first faults hide.

    The entries with a fault are removed from a copy of the case. The copy then has the next
    checks: those between keys, then those of build options, parameters and wires.
    """
    tree = deepcopy(tree)
    faults: list[str] = []
    for _ in range(MOST_ROUNDS):
        errors = sorted(error.errors(), key=lambda one: str(one["loc"]), reverse=True)
        if not all(_leave_out(tree, list(takewhile(is_key, one["loc"])), one) for one in errors):
            return faults
        try:
            case = Case.model_validate(tree)
        except ValidationError as next_error:
            error = next_error
            # a removed entry is no fault of the case
            faults += [one for one in sentences(error, Case) if "got nothing" not in one]
        else:
            return [*faults, *faults_ahead(case, folder)]
    return faults


def _leave_out(tree, place: list[str | int], fault) -> bool:
    """Remove the value of a fault from a case's tree; return whether the rest is still a case.

    For an incomplete entry of a list, the entry is removed. A number without its unit becomes a
    string.
    """
    if fault["type"] == "missing":
        place = place[:-1] if len(place) > 1 and isinstance(place[-2], int) else []
    if not place:
        return False
    *parents, last = place
    node = tree
    try:
        for part in parents:
            node = node[part]
        if isinstance(node[last], (dict, list)) and not isinstance(last, int):
            return False
        if fault["type"] == "string_type":
            node[last] = str(node[last])
        else:
            del node[last]
    except (LookupError, TypeError):
        return False
    return True
