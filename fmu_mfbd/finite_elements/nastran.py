"""Nastran bulk data: nodes and tetrahedra, in small, large and free fields.

meshio's reader is not used: it loses nodes of a CTETRA whose continuation begins with blanks, and
passes over coordinate systems.
"""

import re
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from .deck import Deck, MeshFault, included, rows_by_number, rows_of, tetrahedra

SOLIDS = ("CHEXA", "CPENTA", "CPYRA", "CPYRAM")
SYSTEMS = ("CORD1R", "CORD1C", "CORD1S", "CORD2R", "CORD2C", "CORD2S", "CORD3G")


@dataclass
class Card:
    """A bulk data entry: its name and data fields, eight a line (four of a large line), and the
    mark that its last line ends with.
    """

    name: str
    fields: list[str] = field(default_factory=list)
    mark: str = ""

    def get(self, place: int) -> str:
        """Data field, counted from 0; blank beyond the last."""
        return self.fields[place] if place < len(self.fields) else ""


def read_nastran(path: Path) -> Deck:
    """Nodes and tetrahedra of a bulk data file, the files it includes among it.

    Raises
    ------
    MeshFault
        What is not read right: hexahedra, tetrahedra with some of their middle nodes, nodes in
        cylindrical systems, continuations elsewhere in the file.
    """
    grids: list[Card] = []
    systems: dict[int, Card] = {}
    elements: list[Card] = []
    other: Counter[str] = Counter()
    default = 0
    for card in _cards(_bulk(_lines(path, (path,)))):
        if card.name == "GRID":
            grids.append(card)
        elif card.name == "CTETRA":
            elements.append(card)
        elif card.name == "GRDSET":
            default = _integer(card, 1) or 0
        elif card.name in SYSTEMS:
            systems[_integer(card, 0) or 0] = card
        elif card.name in SOLIDS:
            other[card.name] += 1
        elif card.name in ("CTRIA3", "CTRIA6", "CTRIAR"):
            other["triangle"] += 1
    labels = [_needed(card, 0) for card in grids]
    basic = _Basic(systems)
    points = [basic.place(card, default) for card in grids]
    number = rows_by_number(labels, points)
    tets = tetrahedra([rows_of(number, _corners(card), _what(card)) for card in elements])
    return Deck(
        np.array(points, dtype=float).reshape(-1, 3), tets, labels=np.array(labels), other=other
    )


def _what(card):
    return f"{card.name} {card.get(0)}"


def _corners(card):
    """The four or ten nodes of a CTETRA."""
    nodes = [_integer(card, place) for place in range(2, 12)]
    there = [node for node in nodes if node]
    if len(there) not in (4, 10) or None in nodes[:4]:
        raise MeshFault([f"{_what(card)}: expected 4 or 10 nodes, got {len(there)}"])
    return there


class _Basic:
    """Places of nodes in the basic system."""

    def __init__(self, systems):
        self.systems = systems
        self.known = {0: (np.zeros(3), np.eye(3))}

    def place(self, card, default):
        system = _integer(card, 1)
        system = default if system is None else system
        origin, axes = self.frame(system, _what(card), ())
        local = [_real(card, place) for place in (2, 3, 4)]
        return local if system == 0 else (origin + np.array(local) @ axes).tolist()

    def frame(self, system, what, above):
        """Origin and axes (rows) of a rectangular system."""
        if system in self.known:
            return self.known[system]
        card = self.systems.get(system)
        if card is None or system in above:
            raise MeshFault([f"{what}: expected a known coordinate system, got {system}"])
        if card.name != "CORD2R":
            raise MeshFault(
                [f"{what}: expected the basic system or CORD2R, got {card.name} {system}"]
            )
        origin, axes = self.frame(_integer(card, 1) or 0, _what(card), (*above, system))
        a, b, c = (
            origin + np.array([_real(card, first + k) for k in range(3)]) @ axes
            for first in (2, 5, 8)
        )
        z = (b - a) / np.linalg.norm(b - a)
        y = np.cross(z, c - a)
        y /= np.linalg.norm(y)
        self.known[system] = a, np.array([np.cross(y, z), y, z])
        return self.known[system]


def _lines(path: Path, above: tuple[Path, ...]) -> Iterator[str]:
    """Lines without comments, included files in their places."""
    for line in path.read_text(errors="replace").splitlines():
        line = line.split("$", 1)[0].rstrip().expandtabs(8)
        found = re.match(r"(?i)include\s+['\"]?([^'\"]+)['\"]?\s*$", line)
        if found:
            inner = included(path, found[1].strip(), above)
            yield from _lines(inner, (*above, inner))
        elif re.match(r"(?i)include\b", line):
            raise MeshFault([f"{path.name}: expected an include in one line, got {line.strip()!r}"])
        elif line.strip():
            yield line


def _bulk(lines: Iterable[str]) -> list[str]:
    """Lines after BEGIN BULK, which some programs leave out, up to ENDDATA."""
    found = list(lines)
    for k, line in enumerate(found):
        if re.match(r"(?i)begin(\s+bulk)?\b", line):
            found = found[k + 1 :]
            break
    for k, line in enumerate(found):
        if re.match(r"(?i)enddata\b", line):
            return found[:k]
    return found


def _cards(lines: list[str]) -> Iterator[Card]:
    """Entries with their continuations."""
    card = None
    for line in lines:
        head, fields, mark = _split(line)
        if head and head[0] not in "+*":
            if card:
                yield card
            card = Card(head.rstrip("*"), fields, mark)
            continue
        begins = head.lstrip("+*")
        if card is None or (begins and card.mark and begins != card.mark):
            before = _what(card) if card else "no entry"
            raise MeshFault(
                [f"{before}: expected its continuations right behind it, got {line[:24].strip()!r}"]
            )
        card.fields += fields
        card.mark = mark
    if card:
        yield card


def _split(line):
    """First field, data fields and mark of the continuation of a line."""
    if "," in line:
        parts = [part.strip().upper() for part in line.split(",")]
        width = 4 if "*" in parts[0] else 8
        data, rest = parts[1 : 1 + width], parts[1 + width :]
    else:
        line = line.upper()
        parts = [line[:8].strip()]
        size = 16 if "*" in parts[0] else 8
        width = 64 // size
        data = [line[k : k + size].strip() for k in range(8, min(72, len(line)), size)]
        rest = [line[72:].strip()]
    return parts[0], data + [""] * (width - len(data)), (rest or [""])[0].lstrip("+*")


def _integer(card, place):
    """Whole number of a field; None where it is blank."""
    text = card.get(place)
    try:
        return int(text) if text else None
    except ValueError:
        raise MeshFault(
            [f"{_what(card)}: expected a whole number in field {place + 2}, got {text!r}"]
        ) from None


def _needed(card, place):
    found = _integer(card, place)
    if found is None:
        raise MeshFault([f"{_what(card)}: expected a number in field {place + 2}, got nothing"])
    return found


def _real(card, place):
    """A Nastran real of a field, 0 where it is blank: 1.5+3 and 1.5D+3 are 1.5e3."""
    text = card.get(place).replace("D", "E")
    try:
        return float(re.sub(r"(?<=[\d.])([+-]\d+)$", r"E\1", text)) if text else 0.0
    except ValueError:
        raise MeshFault(
            [f"{_what(card)}: expected a number in field {place + 2}, got {text!r}"]
        ) from None
