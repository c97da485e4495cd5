"""Abaqus input: nodes, tetrahedra, sets and surfaces of parts, and the instances that place them.

meshio's reader is not used: it takes nodes of a second part for the first's, leaves every instance
where its part was drawn, and loses the sets of included files.
"""

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from .deck import Deck, MeshFault, included, rows_by_number, rows_of, tetrahedra

FACES = {"S1": (0, 1, 2), "S2": (0, 3, 1), "S3": (1, 3, 2), "S4": (2, 3, 0)}
"""Corners of a tetrahedron's faces by Abaqus' labels."""
GENERATED = ("NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "PARAMETER", "SYSTEM")
"""Keywords that make or move nodes and elements."""
TRIANGLES = re.compile(r"(S3R?S?T?|STRI3|CPS3|CPE3|M3D3|R3D3|SFM3D3|STRI65|CPS6|CPE6|M3D6|SFM3D6)$")


@dataclass
class Keyword:
    """A keyword, its parameters by name, and its data lines."""

    name: str
    options: dict[str, str]
    lines: list[str]

    def numbers(self) -> list[int]:
        """All whole numbers of its data."""
        return [int(cell) for cell in self.cells()]

    def cells(self) -> list[str]:
        """All entries of its data."""
        found = (cell.strip() for line in self.lines for cell in line.split(","))
        return [cell for cell in found if cell]

    def rows(self) -> list[list[str]]:
        """Entries of each data line."""
        return [[cell.strip() for cell in line.split(",")] for line in self.lines]


@dataclass
class Part:
    """Nodes, elements and sets of one numbering."""

    labels: list[int] = field(default_factory=list)
    points: list[list[float]] = field(default_factory=list)
    elements: dict[int, list[int]] = field(default_factory=dict)
    """Nodes of tetrahedra and triangles by the element's number."""
    other: Counter[str] = field(default_factory=Counter)
    sets: list[Keyword] = field(default_factory=list)
    """*NSET, *ELSET and *SURFACE, and what *NODE and *ELEMENT put into sets."""


@dataclass(frozen=True)
class Instance:
    """A part in its place: turned by a matrix about a point after it was moved.

    Parameters
    ----------
    name : str
    part : Part
    shift, centre : ndarray, shape (3,)
    turn : ndarray, shape (3, 3)
    """

    name: str
    part: Part
    shift: np.ndarray
    centre: np.ndarray
    turn: np.ndarray

    def points(self) -> np.ndarray:
        """Its nodes in the assembly, (n, 3).

        Eq. (M17):  p' = a + R (p + t - a)      t shift, a a point of the axis of rotation
        """
        found = np.array(self.part.points, dtype=float).reshape(-1, 3)
        moved = found + self.shift
        if np.array_equal(self.turn, np.eye(3)):
            return moved
        return self.centre + (moved - self.centre) @ self.turn.T  # Eq. (M17)


def read_abaqus(path: Path) -> Deck:
    """Nodes, tetrahedra (C3D10, C3D4 and their variants), sets and surfaces of an input file.

    A set of a part is known by its name, of all instances of the part together, and as
    `INSTANCE.SET`.

    Raises
    ------
    MeshFault
        What is not read right: generated nodes or elements, instances of what is not there.
    """
    root = Part()
    parts: dict[str, Part] = {}
    instances: list[Instance] = []
    inside = root
    for keyword in _keywords(path):
        if keyword.name in GENERATED and keyword.lines:
            raise MeshFault(
                [f"{path}: expected written nodes, got *{keyword.name}; write the mesh in full"]
            )
        if keyword.name == "PART":
            inside = parts.setdefault(keyword.options["NAME"].casefold(), Part())
        elif keyword.name == "INSTANCE":
            instances.append(_instance(keyword, parts))
            inside = instances[-1].part
        elif keyword.name in ("END PART", "END INSTANCE"):
            inside = root
        else:
            _take(inside, keyword)
    if parts and not instances:
        if len(parts) > 1:
            names = ", ".join(parts)
            raise MeshFault([f"{path}: expected an *Instance of a part, got parts {names} alone"])
        instances = [_placed("", part) for part in parts.values()]
    return _Assembly([*instances, _placed("", root)]).deck()


def _placed(name, part):
    return Instance(name, part, np.zeros(3), np.zeros(3), np.eye(3))


def _instance(keyword, parts):
    """Instance of a part; its own nodes, if it has some, join those of the part."""
    name = keyword.options["NAME"]
    part = parts.get(keyword.options.get("PART", "").casefold())
    if part is None:
        raise MeshFault(
            [f"*Instance {name}: expected a known part, got {keyword.options.get('PART')!r}"]
        )
    own = Part(
        [*part.labels], [*part.points], dict(part.elements), Counter(part.other), [*part.sets]
    )
    rows = [[float(cell) for cell in row if cell] for row in keyword.rows()]
    shift = np.zeros(3)
    if rows:
        shift[: len(rows[0])] = rows[0]
    if len(rows) < 2:
        return Instance(name, own, shift, np.zeros(3), np.eye(3))
    if len(rows) > 2 or len(rows[0]) > 3 or len(rows[1]) != 7:
        raise MeshFault(
            [f"*Instance {name}: expected lines of 3 and 7 numbers, got {keyword.lines}"]
        )
    *ends, angle = rows[1]
    first, second = np.reshape(ends, (2, 3))
    return Instance(name, own, shift, first, rotation(second - first, np.radians(angle)))


def rotation(axis: np.ndarray, angle: float) -> np.ndarray:
    """Matrix that turns by an angle [rad] about a direction.

    Eq. (M18):  R = I + sin(angle) W + (1 - cos(angle)) W W,   W v = n x v,  n = axis/|axis|
    """
    if not axis.any():
        raise MeshFault(["*Instance: expected two points of its axis of rotation, got one"])
    x, y, z = axis / np.linalg.norm(axis)
    W = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * W + (1 - np.cos(angle)) * W @ W  # Eq. (M18)


def _take(part, keyword):
    """Put what a keyword says into the part that it stands in."""
    options = keyword.options
    if keyword.name == "NODE":
        if options.get("SYSTEM", "R").upper() != "R":
            raise MeshFault([f"*Node: expected nodes in x, y, z, got system={options['SYSTEM']}"])
        rows = keyword.rows()
        labels = [int(row[0]) for row in rows]
        part.labels += labels
        part.points += [_coordinates(row) for row in rows]
        if "NSET" in options:
            part.sets.append(Keyword("NSET", {"NSET": options["NSET"]}, [str(k) for k in labels]))
    elif keyword.name == "ELEMENT":
        labels = _take_elements(part, keyword)
        if "ELSET" in options:
            part.sets.append(
                Keyword("ELSET", {"ELSET": options["ELSET"]}, [str(k) for k in labels])
            )
    elif keyword.name in ("NSET", "ELSET", "SURFACE"):
        part.sets.append(keyword)


def _coordinates(row):
    """The three coordinates of a line of *NODE; what is left out is 0."""
    cells = (row[1:4] + ["", "", ""])[:3]
    return [float(cell) if cell else 0.0 for cell in cells]


def _take_elements(part, keyword):
    """Tetrahedra and triangles of an *ELEMENT; others that fill a volume are counted."""
    kind = keyword.options.get("TYPE", "").upper()
    if found := re.match(r"C3D(10|4)(?!\d)", kind):
        count = int(found[1])
    elif TRIANGLES.match(kind):
        count = 6 if kind.rstrip("RST").endswith(("6", "65")) else 3
    elif found := re.match(r"[A-Z]{0,2}C3D(\d+)", kind):
        part.other[kind] += len(keyword.cells()) // (int(found[1]) + 1)
        return []
    else:
        return []
    numbers = keyword.numbers()
    if len(numbers) % (count + 1):
        raise MeshFault(
            [
                f"*Element, type={kind}: expected a multiple of {count + 1} numbers, got "
                f"{len(numbers)}"
            ]
        )
    rows = [numbers[k : k + count + 1] for k in range(0, len(numbers), count + 1)]
    part.elements |= {label: nodes for label, *nodes in rows}
    return [row[0] for row in rows]


class _Assembly:
    """All instances together: rows of nodes, and what names stand for."""

    def __init__(self, instances):
        self.instances = [one for one in instances if one.part.labels or one.part.sets]
        self.node_sets: dict[str, list[int]] = {}
        self.element_sets: dict[str, list[tuple[int, int]]] = {}
        self.faces: dict[str, list[list[int]]] = {}
        self.numbers = []
        first = 0
        for one in self.instances:
            number = rows_by_number(one.part.labels, one.part.points)
            self.numbers.append({label: first + row for label, row in number.items()})
            first += len(one.part.labels)
        for k, one in enumerate(self.instances):
            for keyword in one.part.sets:
                self._add(k, keyword)

    def deck(self):
        """The whole as one deck."""
        labels = [label for one in self.instances for label in one.part.labels]
        points = [one.points() for one in self.instances]
        tets = []
        other: Counter[str] = Counter()
        for k, one in enumerate(self.instances):
            other += one.part.other
            other["triangle"] += sum(len(nodes) in (3, 6) for nodes in one.part.elements.values())
            tets += [
                self._nodes((k, label))
                for label, nodes in one.part.elements.items()
                if len(nodes) in (4, 10)
            ]
        for name, members in self.element_sets.items():
            shells = [member for member in members if len(self._of(member)) in (3, 6)]
            if shells and name not in self.faces:
                self.faces[name] = [self._nodes(member)[:3] for member in shells]
        return Deck(
            np.vstack(points) if points else np.zeros((0, 3)),
            tetrahedra(tets),
            {name: np.unique(rows) for name, rows in self.node_sets.items()},
            {name: np.array(rows).reshape(-1, 3) for name, rows in self.faces.items()},
            np.array(labels) if len(set(labels)) == len(labels) else None,
            +other,
        )

    def _of(self, member):
        """Nodes of an element by number; none of one that is not read."""
        k, label = member
        return self.instances[k].part.elements.get(label, [])

    def _nodes(self, member):
        """Rows of an element's nodes."""
        return rows_of(self.numbers[member[0]], self._of(member), f"element {member[1]}")

    def _add(self, k, keyword):
        """Add a set or surface, under its name and, of an instance, under INSTANCE.NAME too."""
        options = keyword.options
        name = options.get("NAME" if keyword.name == "SURFACE" else keyword.name, "")
        k = self._scope(k, options.get("INSTANCE", ""))
        scope = self.instances[k].name
        if keyword.name == "SURFACE":
            self._add_surface(k, keyword, name, scope)
            return
        into = self.node_sets if keyword.name == "NSET" else self.element_sets
        if keyword.name == "NSET" and "ELSET" in options:
            found = self._rows_of_elements(k, options["ELSET"])
        else:
            found = [one for cell in _members(keyword) for one in self._members(k, cell, into)]
        for known in {name, f"{scope}.{name}" if scope else name}:
            into[known] = [*into.get(known, []), *found]

    def _add_surface(self, k, keyword, name, scope):
        kind = keyword.options.get("TYPE", "ELEMENT").upper()
        if kind == "NODE":
            rows: list[Any] = [
                row for cell in keyword.cells() for row in self._members(k, cell, self.node_sets)
            ]
            self.node_sets[name] = [*self.node_sets.get(name, []), *rows]
            return
        if kind != "ELEMENT":
            return
        found = []
        for row in keyword.rows():
            side = row[1].upper() if len(row) > 1 else ""
            for member in self._members(k, row[0], self.element_sets):
                found += self._sides(member, side)
        for known in {name, f"{scope}.{name}" if scope else name}:
            self.faces[known] = [*self.faces.get(known, []), *found]

    def _sides(self, member, side):
        """Corners of the faces of an element that a label means."""
        nodes = self._nodes(member)
        if len(nodes) in (3, 6):
            return [nodes[:3]]
        if len(nodes) not in (4, 10):
            return []
        return [
            [nodes[corner] for corner in corners]
            for label, corners in FACES.items()
            if side in ("", label)
        ]

    def _scope(self, k, name):
        """Place of an instance by its name; k without one."""
        if not name:
            return k
        for place, one in enumerate(self.instances):
            if one.name.casefold() == name.casefold():
                return place
        raise MeshFault([f"set: expected a known instance, got {name!r}"])

    def _members(self, k, cell, sets):
        """What an entry of a set stands for: a number, a set's name, either after INSTANCE."""
        if cell.lstrip("-").isdigit():
            if sets is self.node_sets:
                return rows_of(self.numbers[k], [int(cell)], "a set")
            return [(k, int(cell))]
        scope = self.instances[k].name
        for known in (f"{scope}.{cell}", cell):
            found = next((sets[one] for one in sets if one.casefold() == known.casefold()), None)
            if found is not None:
                return found
        where, dot, rest = cell.rpartition(".")
        if dot and rest.isdigit():
            return self._members(self._scope(k, where), rest, sets)
        raise MeshFault([f"set: expected a set defined before it, got {cell!r}"])

    def _rows_of_elements(self, k, name):
        return [
            row
            for member in self._members(k, name, self.element_sets)
            for row in self._nodes(member)
        ]


def _members(keyword):
    """Entries of a set, ranges written out."""
    if "GENERATE" not in keyword.options:
        return keyword.cells()
    found = []
    for row in keyword.rows():
        first, last, *step = (int(cell) for cell in row if cell)
        found += [str(k) for k in range(first, last + 1, step[0] if step else 1)]
    return found


def _keywords(path: Path) -> Iterator[Keyword]:
    """Keywords with their data, those of included files in their places."""
    now = None
    for line in _lines(path, (path,)):
        if not line.startswith("*"):
            if now is None:
                raise MeshFault([f"{path}: expected a keyword first, got {line!r}"])
            now.lines.append(line)
            continue
        if now:
            yield now
        now = _keyword(line)
        if now.name in ("NODE", "ELEMENT") and "INPUT" in now.options:
            inner = included(path, now.options["INPUT"], (path,))
            now.lines += [line for line in _lines(inner, (inner,)) if not line.startswith("*")]
    if now:
        yield now


def _keyword(line):
    """A keyword line: names in capitals without double blanks, quotes removed from values."""
    name, *words = line[1:].split(",")
    options = {}
    for word in words:
        key, _, value = word.partition("=")
        if key.strip():
            options[re.sub(r"\s+", "", key).upper()] = value.strip().strip("\"'")
    return Keyword(" ".join(name.split()).upper(), options, [])


def _lines(path: Path, above: tuple[Path, ...]) -> Iterator[str]:
    """Lines without comments, keyword lines that go on put together, included files in their
    places.
    """
    begun = ""
    for line in path.read_text(errors="replace").splitlines():
        line = line.strip()
        if not line or line.startswith("**"):
            continue
        line = begun + line
        begun = line if line.startswith("*") and line.endswith(",") else ""
        if begun:
            continue
        if re.match(r"(?i)\*\s*include\b", line):
            inner = included(path, _keyword(line).options.get("INPUT", ""), above)
            yield from _lines(inner, (*above, inner))
        else:
            yield line
