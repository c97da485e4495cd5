"""Abaqus input files: nodes, tetrahedra, sets and surfaces of parts and their instances.

meshio 5.3.5 is not used: it ignores instances and surfaces, and loses the sets of included files.
"""

import re
from collections import Counter
from collections.abc import Iterator
from copy import copy
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from .deck import Deck, MeshFault, lines_of, rows_by_number, rows_of, tetrahedra

FACES = {"S1": (0, 1, 2), "S2": (0, 3, 1), "S3": (1, 3, 2), "S4": (2, 3, 0)}
"""Corners of a tetrahedron's faces by Abaqus' labels."""
GENERATED = ("NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "PARAMETER", "SYSTEM")
"""Keywords that make or move nodes and elements."""
NODES = {
    r"C3D10(?!\d)": 10,
    r"C3D4(?!\d)": 4,
    r"(S3R?S?T?|STRI3|CPS3|CPE3|M3D3|R3D3|SFM3D3)$": 3,
    r"(STRI65|CPS6|CPE6|M3D6|SFM3D6)$": 6,
}
"""Numbers of nodes of the tetrahedra and triangles that are read, by element type."""


@dataclass
class Keyword:
    """Keyword with its parameters by name and its data lines."""

    name: str
    options: dict[str, str]
    lines: list[str]

    def cells(self) -> list[str]:
        """Return all entries of the data."""
        return [cell for row in self.rows() for cell in row if cell]

    def rows(self) -> list[list[str]]:
        """Return the entries of each data line."""
        return [[cell.strip() for cell in line.split(",")] for line in self.lines]


def _vector():
    return field(default_factory=lambda: np.zeros(3))


@dataclass
class Part:
    """Nodes, elements and sets of one numbering, moved and rotated if it is an instance.

    Parameters
    ----------
    name : str
        Name of the instance, empty for other parts.
    labels : list of int
    coordinates : list of list of float
    elements : dict of int to list of int
        Nodes of tetrahedra and triangles by the element's number.
    other : Counter
        Number of other solid elements by type.
    sets : list of Keyword
        *NSET, *ELSET and *SURFACE, and the sets of *NODE and *ELEMENT.
    shift, centre : ndarray, shape (3,)
    rotation : ndarray, shape (3, 3)
    """

    name: str = ""
    labels: list[int] = field(default_factory=list)
    coordinates: list[list[float]] = field(default_factory=list)
    elements: dict[int, list[int]] = field(default_factory=dict)
    other: Counter[str] = field(default_factory=Counter)
    sets: list[Keyword] = field(default_factory=list)
    shift: np.ndarray = _vector()
    centre: np.ndarray = _vector()
    rotation: np.ndarray = field(default_factory=lambda: np.eye(3))

    def points(self) -> np.ndarray:
        """Return the nodes in the assembly, (n, 3).

        Eq. (M17):  p' = a + R (p + t - a)      t shift, a a point of the axis of rotation
        """
        moved = np.array(self.coordinates, dtype=float).reshape(-1, 3) + self.shift
        if np.array_equal(self.rotation, np.eye(3)):
            return moved
        return self.centre + (moved - self.centre) @ self.rotation.T  # Eq. (M17)

    def add(self, keyword: Keyword) -> None:
        """Add nodes, elements or a set.

        Raises
        ------
        MeshFault
            If nodes are not in x, y, z, or an element does not have all its nodes.
        """
        options = keyword.options
        labels: list[int] = []
        if keyword.name == "NODE":
            if options.get("SYSTEM", "R").upper() != "R":
                raise MeshFault(f"*Node: expected nodes in x, y, z, got system={options['SYSTEM']}")
            for label, *cells in keyword.rows():
                labels.append(int(label))
                x, y, z, *_ = [float(cell) if cell else 0.0 for cell in cells] + [0.0] * 3
                self.coordinates.append([x, y, z])
            self.labels += labels
        elif keyword.name == "ELEMENT":
            labels = self._add_elements(options.get("TYPE", "").upper(), keyword.cells())
        elif keyword.name in ("NSET", "ELSET", "SURFACE"):
            self.sets.append(keyword)
        for name in {"NSET", "ELSET"} & set(options) if labels else ():
            self.sets.append(Keyword(name, {name: options[name]}, [str(k) for k in labels]))

    def _add_elements(self, kind, cells):
        """Add tetrahedra and triangles, count other solid elements; return the numbers added."""
        count = next((n for pattern, n in NODES.items() if re.match(pattern, kind)), 0)
        if not count:
            if solid := re.match(r"[A-Z]{0,2}C3D(\d+)", kind):
                self.other[kind] += len(cells) // (int(solid[1]) + 1)
            return []
        if len(cells) % (count + 1):
            raise MeshFault(
                f"*Element, type={kind}: expected a multiple of {count + 1} numbers, got "
                f"{len(cells)}"
            )
        rows = np.array(cells, dtype=np.int64).reshape(-1, count + 1).tolist()
        self.elements |= {label: nodes for label, *nodes in rows}
        return [label for label, *_ in rows]


def read_abaqus(path: Path) -> Deck:
    """Read nodes, tetrahedra (C3D10, C3D4 and their variants), sets and surfaces of an input file.

    A set of a part is known by its name, for all instances of the part together, and as
    `INSTANCE.SET`.

    Raises
    ------
    MeshFault
        If the file contains something that this reader does not support, for example generated
        nodes, or an instance of an unknown part.
    """
    root = Part()
    parts: dict[str, Part] = {}
    instances: list[Part] = []
    current = root
    for keyword in _keywords(path):
        if keyword.name in GENERATED and keyword.lines:
            raise MeshFault(
                f"{path}: expected written nodes, got *{keyword.name}; write the mesh in full"
            )
        if keyword.name == "PART":
            current = parts.setdefault(keyword.options["NAME"].casefold(), Part())
        elif keyword.name == "INSTANCE":
            instances.append(_instance(keyword, parts))
            current = instances[-1]
        elif keyword.name in ("END PART", "END INSTANCE"):
            current = root
        else:
            current.add(keyword)
    if parts and not instances:
        if len(parts) > 1:
            names = ", ".join(parts)
            raise MeshFault(f"{path}: expected an *Instance of a part, got parts {names} alone")
        instances = list(parts.values())
    return _Assembly([*instances, root]).deck()


def _instance(keyword, parts):
    """Return a copy of a part at the position of its instance, which may add its own nodes."""
    name = keyword.options["NAME"]
    part = parts.get(keyword.options.get("PART", "").casefold())
    if part is None:
        raise MeshFault(
            f"*Instance {name}: expected a known part, got {keyword.options.get('PART')!r}"
        )
    own = Part(**{key: copy(value) for key, value in vars(part).items()})
    own.name = name
    rows = [[float(cell) for cell in row if cell] for row in keyword.rows()]
    lengths = [len(row) for row in rows]
    if max(lengths[:1], default=0) > 3 or lengths[1:] not in ([], [7]):
        raise MeshFault(f"*Instance {name}: expected lines of 3 and 7 numbers, got {keyword.lines}")
    if rows:
        own.shift[: len(rows[0])] = rows[0]
    if len(rows) > 1:
        *ends, angle = rows[1]
        own.centre, second = np.reshape(ends, (2, 3))
        own.rotation = rotation(second - own.centre, np.radians(angle))
    return own


def rotation(axis: np.ndarray, angle: float) -> np.ndarray:
    """Return the matrix of a rotation by an angle [rad] about a direction.

    Eq. (M18):  R = I + sin(angle) W + (1 - cos(angle)) W W,   W v = n x v,  n = axis/|axis|
    """
    if not axis.any():
        raise MeshFault("*Instance: expected two points of its axis of rotation, got one")
    x, y, z = axis / np.linalg.norm(axis)
    W = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * W + (1 - np.cos(angle)) * W @ W  # Eq. (M18)


class _Assembly:
    """All instances together; sets contain rows of nodes, or the rows of each element's nodes."""

    def __init__(self, parts):
        self.parts = [part for part in parts if part.labels or part.sets]
        self.node_sets: dict[str, list] = {}
        self.element_sets: dict[str, list] = {}
        self.faces: dict[str, list] = {}
        self.numbers = []
        self.elements = []
        first = 0
        for part in self.parts:
            number = rows_by_number(part.labels, part.coordinates)
            number = {label: first + row for label, row in number.items()}
            self.numbers.append(number)
            self.elements.append(
                {
                    label: rows_of(number, nodes, f"element {label}")
                    for label, nodes in part.elements.items()
                }
            )
            first += len(part.labels)
        for k, part in enumerate(self.parts):
            for keyword in part.sets:
                self._add(k, keyword)

    def deck(self):
        """Return all instances as one deck."""
        labels = [label for part in self.parts for label in part.labels]
        elements = [nodes for part in self.elements for nodes in part.values()]
        solids = [nodes for nodes in elements if len(nodes) in (4, 10)]
        other = sum((part.other for part in self.parts), Counter())
        other["triangle"] += len(elements) - len(solids)
        for name, members in self.element_sets.items():
            triangles = [nodes[:3] for nodes in members if len(nodes) in (3, 6)]
            if triangles:
                self.faces.setdefault(name, triangles)
        return Deck(
            np.vstack([np.zeros((0, 3)), *(part.points() for part in self.parts)]),
            tetrahedra(solids),
            {name: np.unique(rows) for name, rows in self.node_sets.items()},
            {name: np.array(rows).reshape(-1, 3) for name, rows in self.faces.items()},
            np.array(labels) if len(set(labels)) == len(labels) else None,
            +other,
        )

    def _add(self, k, keyword):
        """Add a set or surface by its name and, for an instance, as INSTANCE.NAME."""
        options = keyword.options
        name = options.get("NAME" if keyword.name == "SURFACE" else keyword.name, "")
        k = self._index(k, options.get("INSTANCE", ""))
        kind = options.get("TYPE", "ELEMENT").upper() if keyword.name == "SURFACE" else ""
        if kind == "ELEMENT":
            into, members = self.faces, self._sides(k, keyword.rows())
        elif keyword.name == "ELSET":
            into, members = self.element_sets, self._all(k, keyword, self.element_sets)
        elif kind in ("", "NODE"):
            into, members = self.node_sets, self._all(k, keyword, self.node_sets)
        else:
            return
        scope = self.parts[k].name
        for known in {name, f"{scope}.{name}" if scope else name}:
            into[known] = [*into.get(known, []), *members]

    def _all(self, k, keyword, sets):
        """Return the members of a set; one of nodes may be given by a set of elements."""
        if keyword.name == "NSET" and "ELSET" in keyword.options:
            elements = self._members(k, keyword.options["ELSET"], self.element_sets)
            return [row for nodes in elements for row in nodes]
        cells = keyword.cells()
        if "GENERATE" in keyword.options:
            cells = []
            for row in keyword.rows():
                first, last, *step = (int(cell) for cell in row if cell)
                cells += [str(label) for label in range(first, last + 1, *step)]
        return [member for cell in cells for member in self._members(k, cell, sets)]

    def _sides(self, k, rows):
        """Return the corners of the faces of elements that a surface contains."""
        faces = []
        for element, *side in rows:
            for nodes in self._members(k, element, self.element_sets):
                if len(nodes) in (3, 6):
                    faces.append(nodes[:3])
                elif nodes:
                    faces += [
                        [nodes[corner] for corner in corners]
                        for label, corners in FACES.items()
                        if not any(side) or side[0].upper() == label
                    ]
        return faces

    def _index(self, k, name):
        """Return the index of an instance by its name, and k if the name is empty."""
        if not name:
            return k
        for index, part in enumerate(self.parts):
            if part.name.casefold() == name.casefold():
                return index
        raise MeshFault(f"set: expected a known instance, got {name!r}")

    def _members(self, k: int, cell: str, sets: dict[str, list]) -> list[Any]:
        """Return the members of an entry: a number or the name of a set, either after INSTANCE."""
        if cell.lstrip("-").isdigit():
            if sets is self.node_sets:
                return rows_of(self.numbers[k], [int(cell)], "a set")
            return [self.elements[k].get(int(cell), [])]
        for known in (f"{self.parts[k].name}.{cell}", cell):
            for name, members in sets.items():
                if name.casefold() == known.casefold():
                    return members
        instance, dot, label = cell.rpartition(".")
        if dot and label.isdigit():
            return self._members(self._index(k, instance), label, sets)
        raise MeshFault(f"set: expected a set defined before it, got {cell!r}")


def _keywords(path: Path) -> Iterator[Keyword]:
    """Yield the keywords with their data, those of included files included."""
    keyword = None
    for line in lines_of(path, _clean, _include):
        if line.startswith("*"):
            if keyword:
                yield keyword
            keyword = _keyword(line)
        elif keyword is None:
            raise MeshFault(f"{path}: expected a keyword first, got {line!r}")
        else:
            keyword.lines.append(line)
    if keyword:
        yield keyword


def _clean(text):
    """Yield the lines without comments, with continued keyword lines joined.

    The data of another file, `*Node, input=FILE`, are included after their keyword.
    """
    lines = (line.strip() for line in text.splitlines())
    text = "\n".join(line for line in lines if line and not line.startswith("**"))
    text = re.sub(r"(?m)^\*(.*,\n)+", lambda match: match[0].replace("\n", ""), text)
    for line in text.splitlines():
        yield line
        if re.match(r"(?i)\*\s*(node|element)\s*,", line):
            if name := _keyword(line).options.get("INPUT"):
                yield f"*INCLUDE, INPUT={name}"


def _include(line):
    """Return the file name of an *INCLUDE, and None for other lines."""
    keyword = _keyword(line) if line.startswith("*") else None
    return keyword.options.get("INPUT", "") if keyword and keyword.name == "INCLUDE" else None


def _keyword(line):
    """Return the keyword of a line, names in capitals, without quotes around values."""
    name, *words = line[1:].split(",")
    options = {}
    for word in words:
        key, _, value = word.partition("=")
        if key.strip():
            options[re.sub(r"\s+", "", key).upper()] = value.strip().strip("\"'")
    return Keyword(" ".join(name.split()).upper(), options, [])
