"""Nastran bulk data: nodes, tetrahedra and matrix entries in small, large and free fields.

meshio 5.3.5 is not used: it ignores coordinate systems and the nodes after a continuation that
begins with blanks.
"""

import re
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from .deck import Deck, MeshFault, lines_of, rows_by_number, rows_of, tetrahedra

SOLIDS = ("CHEXA", "CPENTA", "CPYRA", "CPYRAM")
SYSTEMS = ("CORD1R", "CORD1C", "CORD1S", "CORD2R", "CORD2C", "CORD2S", "CORD3G")


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
        text = self.get(index).replace("D", "E")
        try:
            return float(re.sub(r"(?<=[\d.])([+-]\d+)$", r"E\1", text)) if text else 0.0
        except ValueError:
            raise MeshFault(
                f"{self}: expected a number in field {index + 2}, got {text!r}"
            ) from None


def read_nastran(path: Path) -> Deck:
    """Read nodes and tetrahedra of a bulk data file and of the files that it includes.

    Raises
    ------
    MeshFault
        If the file contains something that this reader does not support: tetrahedra with some of
        their middle nodes, nodes in cylindrical systems, or continuations elsewhere in the file.
    """
    grids: list[Card] = []
    systems: dict[int, Card] = {}
    elements: list[Card] = []
    other: Counter[str] = Counter()
    default = 0
    for card in cards(path):
        if card.name == "GRID":
            grids.append(card)
        elif card.name == "CTETRA":
            elements.append(card)
        elif card.name == "GRDSET":
            default = card.integer(1) or 0
        elif card.name in SYSTEMS:
            systems[card.integer(0) or 0] = card
        elif card.name in SOLIDS:
            other[card.name] += 1
        elif card.name in ("CTRIA3", "CTRIA6", "CTRIAR"):
            other["triangle"] += 1
    labels = [_label(card) for card in grids]
    basic = _BasicSystem(systems)
    points = [basic.position(card, default) for card in grids]
    number = rows_by_number(labels, points)
    tets = tetrahedra([rows_of(number, _nodes(card), str(card)) for card in elements])
    return Deck(
        np.array(points, dtype=float).reshape(-1, 3), tets, labels=np.array(labels), other=other
    )


def _label(card):
    """Return the number of a node."""
    label = card.integer(0)
    if label is None:
        raise MeshFault(f"{card}: expected a number in field 2, got nothing")
    return label


def _nodes(card):
    """Return the four or ten nodes of a CTETRA."""
    nodes = [card.integer(index) for index in range(2, 12)]
    present = [node for node in nodes if node]
    if len(present) not in (4, 10) or None in nodes[:4]:
        raise MeshFault(f"{card}: expected 4 or 10 nodes, got {len(present)}")
    return present


class _BasicSystem:
    """Positions of nodes in the basic system."""

    def __init__(self, systems):
        self.systems = systems
        self.frames = {0: (np.zeros(3), np.eye(3))}

    def position(self, card, default):
        system = card.integer(1)
        system = default if system is None else system
        origin, axes = self.frame(system, card, ())
        local = [card.real(index) for index in (2, 3, 4)]
        return local if system == 0 else (origin + np.array(local) @ axes).tolist()

    def frame(self, system, user, above):
        """Return origin and axes (rows) of a rectangular system."""
        if system in self.frames:
            return self.frames[system]
        card = self.systems.get(system)
        if card is None or system in above:
            raise MeshFault(f"{user}: expected a known coordinate system, got {system}")
        if card.name != "CORD2R":
            raise MeshFault(f"{user}: expected the basic system or CORD2R, got {card}")
        origin, axes = self.frame(card.integer(1) or 0, card, (*above, system))
        local = np.reshape([card.real(index) for index in range(2, 11)], (3, 3))
        a, b, c = origin + local @ axes
        z = (b - a) / np.linalg.norm(b - a)
        y = np.cross(z, c - a)
        y /= np.linalg.norm(y)
        self.frames[system] = a, np.array([np.cross(y, z), y, z])
        return self.frames[system]


def cards(path: Path) -> Iterator[Card]:
    """Yield the entries of a bulk data file with their continuations, in capitals."""
    card = None
    for line in _bulk(lines_of(path, _clean, _include)):
        head, fields, mark = _split(line)
        if head and head[0] not in "+*":
            if card:
                yield card
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
    return parts[0], data + [""] * (width - len(data)), (rest or [""])[0].lstrip("+*")
