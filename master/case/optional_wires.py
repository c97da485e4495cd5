"""Wires that a case has if a body offers an output, such as the oil temperature of its films."""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from ..coupling.wiring import port_of
from ..fmi.fields import base_of
from .contract import Interface, contract, interface

Tree = dict[str, Any]
KEYS = ("option", "build", "replaced_by")
"""Keys of `Role.optional_wires` that are not those of a wire."""


def with_optional_wires(tree: Tree) -> Tree:
    """Return a case's TOML tree with the optional wires of the contract, each with its input.

    Films and bodies must be built in the run. A tree with wrong tables does not change.
    """
    tables, wires = tree.get("participants"), tree.get("wires", [])
    if not isinstance(tables, dict) or not _are_wires(wires):
        return tree
    tables = dict(tables)
    added: list[Tree] = []
    for name, film in tables.items():
        role = film.get("role") if isinstance(film, dict) else None
        if not isinstance(role, str) or role not in contract():
            continue
        other = interface(wires, name, role)
        for variable, terms in contract()[role].optional_wires.items():
            port = f"{name}.{variable}"
            if (
                other
                and _is_offered(tables, film, other, terms)
                and not _is_set(film, wires, port, terms)
            ):
                keys = {key: value for key, value in terms.items() if key not in KEYS}
                source = f"{other.owner}.{other.surface}{variable}"
                added.append({"from": source, "to": port} | keys)
                tables[name] = film = _with_input(film, terms["build"], variable)
    return tree | {"participants": tables, "wires": [*wires, *added]} if added else tree


class Override(NamedTuple):
    """Input that a film does not take from its body.

    film, body, variable : names; source : wire that it comes from, empty if there is none;
    is_offered : whether the body offers it; figures : parameter -> figure of the body's part.
    """

    film: str
    body: str
    variable: str
    source: str
    is_offered: bool
    figures: dict[str, str]


def overrides(case: Any) -> Iterator[Override]:
    """Yield the optional inputs that the films of a case do not take from their bodies."""
    for name, film in case.participants.items():
        other = interface(case.wires, name, film.role) if film.role in contract() else None
        if other is None:
            continue
        for variable, terms in contract()[film.role].optional_wires.items():
            sources = [w.source for w in case.wires if base_of(w.target) == f"{name}.{variable}"]
            if not any(port_of(source)[0] == other.owner for source in sources):
                is_offered = terms["option"] in case.participants[other.owner].build
                figures = {key: one for key, one in terms["replaced_by"].items() if one}
                yield Override(
                    film=name,
                    body=other.owner,
                    variable=variable,
                    source=" and ".join(sources),
                    is_offered=is_offered,
                    figures=figures,
                )


def _are_wires(wires: Any) -> bool:
    """Return whether a list holds wires with both ends."""
    return isinstance(wires, list) and all(
        isinstance(one, dict)
        and isinstance(one.get("from"), str)
        and isinstance(one.get("to"), str)
        for one in wires
    )


def _is_offered(tables: Tree, film: Tree, other: Interface, terms: Mapping[str, Any]) -> bool:
    """Return whether both ends are built in the run, and the body offers the output."""
    body = tables.get(other.owner)
    if not isinstance(body, dict) or not all("package" in one for one in (film, body)):
        return False
    builds = [one.get("build", {}) for one in (film, body)]
    is_built = all(isinstance(one, dict) for one in builds)
    return is_built and builds[0].get("surface") != "bearing" and terms["option"] in builds[1]


def _is_set(film: Tree, wires: list[Tree], port: str, terms: Mapping[str, Any]) -> bool:
    """Return whether the case sets the input otherwise."""
    parameters = film.get("parameters", {})
    return any(key in parameters for key in terms["replaced_by"]) or any(
        base_of(wire["to"]) == port for wire in wires
    )


def _with_input(film: Tree, option: str, variable: str) -> Tree:
    """Return the table of a film whose build option lists an input."""
    build = film.get("build", {})
    listed = build.get(option, [])
    inputs = [*listed] if variable in listed else [*listed, variable]
    return film | {"build": build | {option: inputs}}
