"""Nastran bulk data: nodes, tetrahedra and matrix entries in small, large and free fields.

meshio 5.3.5 is not used: it ignores coordinate systems and the nodes after a continuation that
begins with blanks. pyNastran 1.4.1 is not used: it needs numpy 1.
"""

import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from .deck import OMITTED, Deck, MeshFault, lines_of, parts_of, real, rows_of, tetrahedra

SOLIDS = ("CHEXA", "CPENTA", "CPYRA", "CPYRAM")
SYSTEMS = ("CORD1R", "CORD1C", "CORD1S", "CORD2R", "CORD2C", "CORD2S")


@dataclass
class Card:
    """Bulk data entry.

    Parameters
    ----------
    name : str
    fields : list of str
        Data fields, eight for each line, or four for a line with large fields.
    mark : str
        Mark at the end of the last line.
    """

    name: str
    fields: list[str] = field(default_factory=list)
    mark: str = ""

    def __str__(self):
        return f"{self.name} {self.get(0)}"

    def get(self, index: int) -> str:
        """Return a data field, counted from 0; it is blank after the last one."""
        return self.fields[index] if index < len(self.fields) else ""

    def integer(self, index: int) -> int | None:
        """Return the integer of a field, None if it is blank."""
        text = self.get(index)
        try:
            return int(text) if text else None
        except ValueError:
            raise MeshFault(
                f"{self}: expected a whole number in field {index + 2}, got {text!r}"
            ) from None

    def real(self, index: int) -> float:
        """Return the real number of a field, 0 if it is blank; 1.5+3 and 1.5D+3 are 1.5e3."""
        text = self.get(index)
        try:
            return real(text) if text else 0.0
        except ValueError:
            raise MeshFault(
                f"{self}: expected a number in field {index + 2}, got {text!r}"
            ) from None


def read_nastran(path: Path) -> Deck:
    """Read nodes and tetrahedra of a bulk data file and of the files that it includes.

    A part has the number of its property. The material is that of PSOLID, with the properties of
    its MAT1, and WTMASS multiplies the density.

    Raises
    ------
    MeshFault
        If the file contains something that this reader does not support: nodes in unknown
        systems, or continuations elsewhere in the file.
    """
    grids: dict[int, Card] = {}
    systems: dict[int, Card] = {}
    elements: list[Card] = []
    solids: list[Card] = []
    materials: dict[int | None, str] = {}
    properties: dict[str, dict[str, float]] = {}
    weight = 1.0
    fluids: set[int | None] = set()
    other: Counter[str] = Counter()
    default = 0
    for card in cards(path):
        if card.name == "GRID":
            label = _label(card)
            first = grids.setdefault(label, card)
            if first is not card and _coordinates_of(first) != _coordinates_of(card):
                raise MeshFault(f"node {label}: expected one position, got two")
        elif card.name == "CTETRA":
            elements.append(card)
        elif card.name == "GRDSET":
            default = card.integer(1) or 0
        elif card.name in SYSTEMS:
            _add_systems(systems, card)
        elif card.name == "PSOLID":
            materials[card.integer(0)] = f"MAT {card.get(1)}"
            if "FLUID" in card.get(6):
                fluids.add(card.integer(0))
        elif card.name == "MAT1":
            properties[f"MAT {card.get(0)}"] = _properties(card)
        elif card.name == "PARAM" and card.get(0) == "WTMASS":
            weight = card.real(1)
        elif card.name in SOLIDS:
            solids.append(card)
        elif card.name in ("CTRIA3", "CTRIA6", "CTRIAR"):
            other["triangle"] += 1
    wet = [card for card in elements if _property(card) in fluids]
    solids += [Card("CTETRA of a fluid", card.fields) for card in wet]
    elements = [card for card in elements if _property(card) not in fluids]
    tets = [_nodes(card) for card in elements]
    used = {node for nodes in tets for node in nodes}
    basic = _BasicSystem(systems, grids, default)
    points = {}
    for label, card in grids.items():
        _coordinates_of(card)
        try:
            points[label] = basic.position(label, ())
        except MeshFault:  # of the system
            if label in used:
                raise
    number = {label: row for row, label in enumerate(points)} | OMITTED
    others = {len(elements) + k: card.name for k, card in enumerate(solids)}
    groups: dict[str, list[int]] = defaultdict(list)
    for k, card in enumerate(elements + solids):
        groups[str(_property(card))].append(k)
    known = [materials.get(_property(card), "") for card in elements]
    return Deck(
        np.array(list(points.values()), dtype=float).reshape(-1, 3),
        tetrahedra([rows_of(number, nodes, str(card)) for nodes, card in zip(tets, elements)]),
        labels=np.array(list(points), dtype=int),
        other=other + Counter(others.values()),
        parts=parts_of(groups, {k: k for k in range(len(elements))}, others),
        materials=known if any(known) else (),
        properties={
            name: own | {key: weight * own[key] for key in ("density",) if key in own}
            for name, own in properties.items()
        },
    )


def _properties(card):
    """Return the properties of a MAT1: two of E, G and nu, rho and the expansion.

    Eq. (M24):  G = E/(2 (1 + nu))
    """
    young, shear, poisson, density, expansion = (
        card.real(index) if card.get(index) else None for index in (1, 2, 3, 4, 5)
    )
    # Eq. (M24)
    if poisson is None and young and shear:
        poisson = young / (2 * shear) - 1
    elif young is None and shear and poisson is not None:
        young = 2 * shear * (1 + poisson)
    own = {"young": young, "poisson": poisson, "density": density, "expansion": expansion}
    return {key: value for key, value in own.items() if value is not None}


def _coordinates_of(card):
    """Return system and coordinates of a node as its card states them."""
    return card.integer(1), [card.real(index) for index in (2, 3, 4)]


def _property(card):
    """Return the number of an element's property, which is that of the element if omitted."""
    number = card.integer(1)
    return card.integer(0) or 0 if number is None else number


def _add_systems(systems, card):
    """Add the coordinate systems of a card; CORD1 may define two of them by three nodes each."""
    half = 4 if card.name.startswith("CORD1") else len(card.fields)
    for first in range(0, len(card.fields), half):
        part = Card(card.name, card.fields[first : first + half])
        if part.integer(0) is not None:
            systems[part.integer(0)] = part


def _label(card):
    """Return the number of a node."""
    label = card.integer(0)
    if label is None:
        raise MeshFault(f"{card}: expected a number in field 2, got nothing")
    return label


def _nodes(card):
    """Return the four or ten nodes of a CTETRA, 0 for omitted middle nodes."""
    nodes = [card.integer(index) or 0 for index in range(2, 12)]
    present = nodes[: 10 if any(nodes[4:]) else 4]
    if 0 in nodes[:4] or len(card.fields) > 12 and any(card.fields[12:]):
        raise MeshFault(f"{card}: expected 4 corners and up to 6 middle nodes, got {present}")
    return present


class _BasicSystem:
    """Positions of nodes in the basic system.

    Parameters
    ----------
    systems : dict of int to Card
    grids : dict of int to Card
    default : int
        System of nodes that state none.
    """

    def __init__(self, systems, grids, default):
        self.systems = systems
        self.grids = grids
        self.default = default
        self.frames: dict[int, Any] = {0: ("R", np.zeros(3), np.eye(3))}

    def position(self, label, above):
        """Return the position of a node; `above` contains the systems that depend on it."""
        card = self.grids.get(label)
        if card is None:
            raise MeshFault(f"CORD1: expected a known node, got {label}")
        system, local = _coordinates_of(card)
        return self._basic(self.default if system is None else system, local, card, above)

    def _basic(self, system, local, user, above):
        """Return a position in the basic system.

        Eq. (M22):  p = o + A^T (x, y, z)
                    cylindrical x, y, z = r cos t, r sin t, z           local = (r, t, z)
                    spherical x, y, z = r sin t cos f, r sin t sin f, r cos t   local = (r, t, f)
        """
        kind, origin, axes = self.frame(system, user, above)
        if system == 0:
            return local
        if kind == "C":
            r, degrees, z = local
            t = np.radians(degrees)
            local = r * np.cos(t), r * np.sin(t), z  # Eq. (M22)
        elif kind == "S":
            r, *degrees = local
            t, f = np.radians(degrees)
            local = r * np.sin(t) * np.cos(f), r * np.sin(t) * np.sin(f), r * np.cos(t)
        return (origin + np.array(local) @ axes).tolist()

    def frame(self, system, user, above):
        """Return kind (R, C or S), origin and axes (rows) of a system."""
        if system in self.frames:
            return self.frames[system]
        card = self.systems.get(system)
        if card is None or system in above:
            circular = ", which depends on itself" if card else ""
            raise MeshFault(f"{user}: expected a known coordinate system, got {system}{circular}")
        above = (*above, system)
        if card.name.startswith("CORD1"):
            points = [self.position(card.integer(index), above) for index in (1, 2, 3)]
        else:
            values = np.reshape([card.real(index) for index in range(2, 11)], (3, 3)).tolist()
            points = [self._basic(card.integer(1) or 0, value, card, above) for value in values]
        a, b, c = np.array(points)
        z = b - a
        y = np.cross(z, c - a)
        if np.linalg.norm(y) <= 1e-9 * np.linalg.norm(z) * np.linalg.norm(c - a):
            raise MeshFault(f"{card}: expected three points that are not in line, got {points}")
        z, y = z / np.linalg.norm(z), y / np.linalg.norm(y)
        self.frames[system] = card.name[-1], a, np.array([np.cross(y, z), y, z])
        return self.frames[system]


def cards(path: Path) -> Iterator[Card]:
    """Yield the entries of a bulk data file with their continuations, in capitals."""
    card = None
    for line in _bulk(lines_of(path, _clean, _include)):
        head, fields, mark = _split(line)
        if head and head[0] not in "+*":
            if card:
                yield card
            if head[0] == "=":
                raise MeshFault(
                    "expected written entries, got replication by =; write the mesh in full"
                )
            card = Card(head.rstrip("*"), fields, mark)
            continue
        begins = head.lstrip("+*")
        if card is None or (begins and card.mark and begins != card.mark):
            raise MeshFault(
                f"{card or 'no entry'}: expected its continuations right behind it, got "
                f"{line[:24].strip()!r}"
            )
        card.fields += fields
        card.mark = mark
    if card:
        yield card


def _clean(text):
    """Return the lines without comments."""
    lines = (line.split("$", 1)[0].rstrip().expandtabs(8) for line in text.splitlines())
    return [line for line in lines if line]


def _include(line):
    """Return the file name of an INCLUDE, and None for other lines."""
    if not re.match(r"(?i)include\b", line):
        return None
    name = re.match(r"(?i)include\s+['\"]?([^'\"]+)['\"]?\s*$", line)
    if not name:
        raise MeshFault(f"expected an include in one line, got {line.strip()!r}")
    return name[1].strip()


def _bulk(lines: Iterable[str]) -> list[str]:
    """Return the lines after BEGIN BULK, which some programs leave out, up to ENDDATA."""
    lines = list(lines)
    first = [k + 1 for k, line in enumerate(lines) if re.match(r"(?i)begin(\s+bulk)?\b", line)]
    lines = lines[first[0] if first else 0 :]
    last = [k for k, line in enumerate(lines) if re.match(r"(?i)enddata\b", line)]
    return lines[: last[0] if last else None]


def _split(line):
    """Return the first field, the data fields and the mark of the continuation of a line."""
    line = line.upper()
    if "," in line:
        parts = [part.strip() for part in line.split(",")]
        width = 4 if "*" in parts[0] else 8
        data, rest = parts[1 : 1 + width], parts[1 + width :]
    else:
        parts = [line[:8].strip()]
        size = 16 if "*" in parts[0] else 8
        width = 64 // size
        data = [line[k : k + size].strip() for k in range(8, min(72, len(line)), size)]
        rest = [line[72:].strip()]
        if any(" " in text for text in (*parts, *data)):  # free fields between blanks
            parts = line.split() if line[:1].strip() else ["", *line.split()]
            data, rest = parts[1 : 1 + width], parts[1 + width :]
    if len(rest) > 1 and any(rest[1:]):
        got = f"got {width + len(rest)}; continue it on a line that begins with +"
        raise MeshFault(f"{parts[0] or 'line'}: expected at most {width} fields and a mark, {got}")
    return parts[0], data + [""] * (width - len(data)), (rest or [""])[0].lstrip("+*")
