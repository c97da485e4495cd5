"""Symmetry of films and their bodies about the thrust plane, found for a whole case.

A group is a body and the films that take their film thickness from it. A part finds the reasons
within its participant (`build.symmetry`). Wires and arrays that a case sets add further ones.
"""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..coupling.wiring import port_of
from ..fmi.errors import BadInput
from ..fmi.fields import base_of
from ..fmi.symmetry import FILM_SYMMETRIES, Symmetry, odd_part, rejection
from .contract import interface
from .keys import part_function


class Group(NamedTuple):
    """Body and its films.

    Parameters
    ----------
    body : str
    claims : list of str
        Keys that assume the symmetry.
    reasons : list of str
        Why the group is not its own mirror image; empty if it is, as far as known.
    unknown : list of str
        Films whose models do not report their symmetry.
    halves : list of str
        Participants that can compute one half, `Symmetry.can_halve`.
    """

    body: str
    claims: list[str]
    reasons: list[str]
    unknown: list[str]
    halves: list[str]


def groups(
    case: Any, folder: Path, declared: Any, builds: Mapping[str, Any] | None = None
) -> Iterator[Group]:
    """Yield the groups of a case with the reasons why they are not their own mirror image.

    Parameters
    ----------
    case : schema.Case
    folder : Path
        Folder of the case.
    declared : ahead.Ahead
    builds : mapping, optional
        Build options of all participants, `given.build_options`. Default: their own ones.
    """

    def symmetry(name):
        table = case.participants[name]
        build = builds[name] if builds else table.build
        return _symmetry(table.package, build, declared.parameters.get(name, {}), folder)

    sources = {name: interface(case.wires, name, "lubrication") for name in case.participants}
    films = {name: other for name, other in sources.items() if other}
    for body in case.participants:
        own = symmetry(body)
        if own is None or body in films:
            continue
        surfaces = {name: other.surface for name, other in films.items() if other.owner == body}
        reasons = [f"participants.{body}.{line}" for line in own.reasons]
        unknown, halves = [], []
        for name in surfaces:
            answer = symmetry(name)
            if answer is None:
                unknown.append(name)
            else:
                halves += [name] if answer.can_halve else []
                reasons += [f"participants.{name}.{line}" for line in answer.reasons]
        reasons += _differing(case, surfaces, own.images, {body, *surfaces})
        for name in (body, *surfaces):
            reasons += _fields_from_outside(case, declared, name, {body, *surfaces})
        claims = [f"participants.{body}.build.{one}" for one in own.claims]
        claims += ["symmetric"] if case.symmetric else []
        halves += [body] if own.can_halve and halves else []
        yield Group(body, claims, reasons, unknown, halves)


def symmetry_faults(case: Any, folder: Path, declared: Any) -> list[str]:
    """Return the faults of keys that assume a symmetry which does not exist."""
    return [
        rejection(claim, group.reasons)
        for group in groups(case, folder, declared)
        if group.reasons
        for claim in group.claims
    ]


def half_films(
    case: Any, folder: Path, declared: Any, builds: Mapping[str, Any], faults: list[str]
) -> dict[str, dict[str, str]]:
    """Return the parameters of the participants that compute one half, by participant.

    A group must be its own mirror image to round-off. If the case does not demand halves, films
    with a field input that no wire feeds are computed whole, because users of an exported FMU may
    set it to any values.

    Parameters
    ----------
    case, folder, declared, builds
        As for `groups`.
    faults : list of str
        A fault is appended if the case demands halves and has none, or chooses whole films.
    """
    if case.symmetric is False:
        return {}
    choice = "thrust_plane" if case.symmetric else "automatic"
    choices = {}
    for group in groups(case, folder, declared, builds):
        if group.unknown or not (group.halves or group.reasons):
            continue
        reasons = group.reasons
        if case.symmetric:
            reasons = reasons + _chosen_whole(case, group.halves)
        else:
            films = [name for name in group.halves if name != group.body]
            reasons = reasons + _free_fields(case, declared, films)
        odd_bodies = part_function(case.participants[group.body].package, "odd_bodies")
        if odd_bodies and not reasons:
            reasons = odd_bodies(builds[group.body], folder)
        if not reasons:
            choices |= {name: {"film_symmetry": choice} for name in group.halves}
        elif case.symmetric:
            faults.append(rejection("symmetric", reasons))
    if case.symmetric and not choices and not faults:
        faults.append(rejection("symmetric", ["no film of a known model with such a grid"]))
    return choices


def _symmetry(package, build, parameters, folder) -> Symmetry | None:
    """Return what a participant's part finds, None if it does not report it or has a fault."""
    symmetry = part_function(package, "symmetry")
    try:
        return symmetry(build, parameters, folder) if symmetry else None
    except BadInput:  # its faults are in the list of the case
        return None


def _differing(case, surfaces, images, group):
    """Return reasons of films on mirrored surfaces that differ, also in wires from outside."""
    by_surface = {surface: name for name, surface in surfaces.items()}
    differing = []

    def own(name):
        table = case.participants[name]
        wires = [wire for wire in case.wires if port_of(wire.source)[0] not in group]
        ends = [(port_of(wire.target), wire.source) for wire in wires]
        outside = {(variable, source) for (owner, variable), source in ends if owner == name}
        return table.build, table.parameters, outside

    for surface, name in by_surface.items():
        other = by_surface.get(images.get(surface, surface), name)
        if name < other and own(name) != own(other):
            differing.append(f"participants.{other} (differs from {name}, its mirror image)")
    return differing


def _chosen_whole(case, names):
    """Return the parameters of participants that choose whole films."""
    return [
        f"participants.{name}.parameters.film_symmetry (none)"
        for name in names
        if case.participants[name].parameters.get("film_symmetry") == FILM_SYMMETRIES[0]
    ]


def _free_fields(case, declared, films):
    """Return the field inputs of films that no wire feeds."""
    fed = {(owner, base_of(name)) for owner, name in (port_of(w.target) for w in case.wires)}
    return [
        f"participants.{film}.{name}"
        for film in films
        for name, field in declared.participants[film].fields.items()
        if field.causality == "input" and field.shape and (film, name) not in fed
    ]


def _fields_from_outside(case, declared, name, group):
    """Return reasons of field inputs of a participant that others set, or the case unevenly."""
    fields = declared.participants[name].fields if name in declared.participants else {}
    outside = []
    for wire in case.wires:
        owner, variable = port_of(wire.target)
        source, _ = port_of(wire.source)
        field = fields.get(base_of(variable))
        if owner == name and source not in group and field is not None and field.shape:
            outside.append(f"participants.{name}.{variable} (from {wire.source})")
    for variable, value in declared.parameters.get(name, {}).items():
        if np.ndim(value) and odd_part(np.asarray(value)).any():
            outside.append(
                f"participants.{name}.parameters.{variable} (differs from its mirror image)"
            )
    return outside
