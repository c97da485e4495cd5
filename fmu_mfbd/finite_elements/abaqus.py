"""Abaqus and CalculiX input files: nodes, tetrahedra, sets and surfaces of parts and instances.

meshio 5.3.5 is not used: it ignores instances and surfaces, and loses the sets of included files.
"""

import re
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from copy import copy
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from .deck import (
    Deck,
    MeshFault,
    first_rows,
    lines_of,
    parts_of,
    real,
    rows_by_number,
    rows_of,
    tetrahedra,
)

FACES = {"S1": (0, 1, 2), "S2": (0, 3, 1), "S3": (1, 3, 2), "S4": (2, 3, 0)}
"""Corners of a tetrahedron's faces by Abaqus' labels."""
PROPERTIES = {"ELASTIC": ("young", "poisson"), "DENSITY": ("density",), "EXPANSION": ("expansion",)}
"""Properties in the first columns of a keyword of a material."""
GENERATED = ("NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "PARAMETER", "SYSTEM")
"""Keywords that make or move nodes and elements."""
NODES = {
    r"C3D10(?!\d)": 10,
    r"C3D4(?!\d)": 4,
    r"(S3R?S?T?|STRI3|CPS3|CPE3|M3D3|R3D3|SFM3D3)$": 3,
    r"(STRI65|CPS6|CPE6|M3D6|SFM3D6)$": 6,
}
"""Numbers of nodes of the tetrahedra and triangles that are read, by element type."""
SOLIDS = r"([A-Z]{0,2}C3D|[A-Z]?COH3D|[A-Z]*SC|CSS|F3D|Q3D)(?P<nodes>\d+)"
"""Other solid elements, with their number of nodes."""


@dataclass
class Keyword:
    """Keyword with its parameters by name and its data lines."""

    name: str
    options: dict[str, str]
    lines: list[str]

    def need(self, option: str) -> str:
        """Return a parameter.

        Raises
        ------
        MeshFault
            If the keyword does not have it.
        """
        if option not in self.options:
            raise MeshFault(f"*{self.name.title()}: expected {option.lower()}=, got nothing")
        return self.options[option]

    def cells(self) -> list[str]:
        """Return all entries of the data."""
        return [cell for row in self.rows() for cell in row if cell]

    def rows(self) -> list[list[str]]:
        """Return the entries of each data line."""
        return [[cell.strip().strip("\"'") for cell in line.split(",")] for line in self.lines]


def _vector():
    return field(default_factory=lambda: np.zeros(3))


@dataclass
class Part:
    """Nodes, elements and sets of one numbering, moved and rotated if it is an instance.

    Parameters
    ----------
    part : str
        Name of the part, empty outside parts.
    name : str
        Name of the instance, empty for other parts.
    labels : list of int
    coordinates : list of list of float
    elements : dict of int to (str, list of int)
        Type and nodes of tetrahedra and triangles by the element's number; other solid elements
        without nodes.
    sets : list of Keyword
        *NSET, *ELSET, *SURFACE and *SOLID SECTION, and the sets of *NODE and *ELEMENT.
    shift, centre : ndarray, shape (3,)
    rotation : ndarray, shape (3, 3)
    """

    part: str = ""
    name: str = ""
    labels: list[int] = field(default_factory=list)
    coordinates: list[list[float]] = field(default_factory=list)
    elements: dict[int, tuple[str, list[int]]] = field(default_factory=dict)
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
                x, y, z, *_ = [real(cell) if cell else 0.0 for cell in cells] + [0.0] * 3
                self.coordinates.append([x, y, z])
            self.labels += labels
        elif keyword.name == "ELEMENT":
            labels = self._add_elements(keyword.need("TYPE").upper(), keyword.cells())
        elif keyword.name in ("NSET", "ELSET", "SURFACE", "SOLID SECTION"):
            self.sets.append(keyword)
        for name in {"NSET", "ELSET"} & set(options) if labels else ():
            self.sets.append(Keyword(name, {name: options[name]}, [str(k) for k in labels]))

    def _add_elements(self, kind, cells):
        """Add tetrahedra, triangles and the numbers of other solids; return the numbers added."""
        count = next((n for pattern, n in NODES.items() if re.match(pattern, kind)), 0)
        solid = None if count else re.match(SOLIDS, kind)
        size = 1 + (int(solid["nodes"]) if solid else count)
        if size == 1:
            return []
        if len(cells) % size:
            raise MeshFault(
                f"*Element, type={kind}: expected a multiple of {size} numbers, got {len(cells)}"
            )
        rows = np.array(cells, dtype=np.int64).reshape(-1, size).tolist()
        self.elements |= {label: (kind, [] if solid else nodes) for label, *nodes in rows}
        return [label for label, *_ in rows]


def read_abaqus(path: Path) -> Deck:
    """Read nodes, tetrahedra (C3D10, C3D4 and their variants), sets and surfaces of an input file.

    A set of a part is known by its name, for all instances of the part together, and as
    `INSTANCE.SET`. Abaqus ignores the case of names, and a set may be used before its definition.

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
    properties: dict[str, dict[str, float]] = {}
    remarks: list[str] = []
    material = ""
    for keyword in _keywords(path):
        if keyword.name in GENERATED and keyword.lines:
            raise MeshFault(
                f"{path}: expected written nodes, got *{keyword.name}; write the mesh in full"
            )
        if keyword.name == "PART":
            name = keyword.need("NAME")
            current = parts.setdefault(name.casefold(), Part(name))
        elif keyword.name == "INSTANCE":
            instances.append(_instance(keyword, parts))
            current = instances[-1]
        elif keyword.name in ("END PART", "END INSTANCE"):
            current = root
        elif keyword.name == "MATERIAL":
            material = keyword.need("NAME").upper()
            properties[material] = {}
        elif keyword.name in PROPERTIES and material:
            if keyword.options.get("TYPE", "ISO").upper().startswith("ISO"):
                rows = []
                with suppress(ValueError):  # a parameter of the program; the value is then missing
                    rows = [[real(cell) for cell in row if cell] for row in keyword.rows()]
                own, remark = first_rows(PROPERTIES[keyword.name], rows, material)
                properties[material] |= own
                remarks += remark
        else:
            current.add(keyword)
    deck = _Assembly([*(instances or parts.values()), root]).deck()
    return replace(deck, properties=properties, remarks=tuple(remarks))


def _instance(keyword, parts):
    """Return a copy of a part at the position of its instance, which may add its own nodes."""
    name = keyword.need("NAME")
    part = parts.get(keyword.options.get("PART", "").casefold())
    if part is None:
        raise MeshFault(
            f"*Instance {name}: expected a known part, got {keyword.options.get('PART')!r}"
        )
    own = Part(**{key: copy(value) for key, value in vars(part).items()})
    own.name = name
    rows = [[real(cell) for cell in row if cell] for row in keyword.rows()]
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
    """All instances as one mesh.

    Members of a set of nodes are rows of nodes, those of a set of elements are their part and
    number, those of a surface are corners of faces.
    """

    def __init__(self, parts):
        self.parts = [part for part in parts if part.labels or part.sets]
        self.numbers = []
        first = 0
        for part in self.parts:
            number = rows_by_number(part.labels, part.coordinates)
            self.numbers.append({label: first + row for label, row in number.items()})
            first += len(part.labels)
        self.names: dict[str, str] = {}
        self.definitions: dict[tuple[str, str], list] = {}
        self.sets: dict[tuple[str, str], list | MeshFault] = {}
        for k, part in enumerate(self.parts):
            for keyword in part.sets:
                self._define(k, keyword)

    def _define(self, k, keyword):
        """Add the definition of a set by its name and, for an instance, as INSTANCE.NAME."""
        options = keyword.options
        table = keyword.name
        if table == "SURFACE":
            kind = options.get("TYPE", "ELEMENT").upper()
            table = {"ELEMENT": "SURFACE", "NODE": "NSET"}.get(kind, "")
        name = options.get("NAME" if keyword.name == "SURFACE" else keyword.name, "")
        if not table or not name:
            return
        scope = options.get("INSTANCE") or self.parts[k].name
        for known in [name, f"{scope}.{name}"] if scope else [name]:
            self.names.setdefault(known.casefold(), known)
            self.definitions.setdefault((table, known.casefold()), []).append((k, keyword))

    def deck(self):
        """Return all instances as one deck."""
        labels = [label for part in self.parts for label in part.labels]
        solids: dict[tuple[int, int], int] = {}
        tets, others = [], {}
        for k, part in enumerate(self.parts):
            for label, (kind, nodes) in part.elements.items():
                if len(nodes) in (4, 10):
                    solids[k, label] = len(tets)
                    tets.append(rows_of(self.numbers[k], nodes, f"element {label}"))
                else:
                    others[k, label] = "triangle" if nodes else kind
        tables: dict[str, dict] = {"NSET": {}, "ELSET": {}, "SURFACE": {}}
        faults = {}
        for table, name in self.definitions:
            if table in tables:
                try:
                    tables[table][self.names[name]] = self._set(table, name)
                except MeshFault as fault:
                    faults[self.names[name]] = str(fault)
        faces = tables["SURFACE"]
        for name, members in tables["ELSET"].items():
            if triangles := [face for key in members for face in self._triangle(*key)]:
                faces.setdefault(name, triangles)
        instances = self._instances()  # they are first and replace sets of the same name
        return Deck(
            points=np.vstack([np.zeros((0, 3)), *(part.points() for part in self.parts)]),
            tets=tetrahedra(tets),
            node_sets={name: np.unique(rows).astype(int) for name, rows in tables["NSET"].items()},
            faces={name: np.array(rows, dtype=int).reshape(-1, 3) for name, rows in faces.items()},
            labels=np.array(labels),
            other=Counter(others.values()),
            parts=parts_of(instances | tables["ELSET"] | instances, solids, others),
            materials=self._materials(solids),
            faults=faults,
        )

    def _instances(self):
        """Return the elements of each part and of each instance."""
        out: dict[str, list] = {}
        for k, part in enumerate(self.parts):
            for name in filter(None, dict.fromkeys((part.part, part.name))):
                out.setdefault(name, []).extend((k, label) for label in part.elements)
        return out

    def _materials(self, solids):
        """Return the material of each tetrahedron by its *SOLID SECTION, "none" without one."""
        materials = ["none"] * len(solids)
        for k, part in enumerate(self.parts):
            for section in part.sets:
                name = section.options.get("ELSET", "")
                if section.name != "SOLID SECTION":
                    continue
                with suppress(MeshFault):  # a section of an unknown set has no elements
                    for key in solids.keys() & self._members(k, name, "ELSET"):
                        materials[solids[key]] = section.options.get("MATERIAL", "none").upper()
        return materials if set(materials) != {"none"} else []

    def _set(self, table, name):
        """Return the members of a set, whose definitions may be in any order.

        Raises
        ------
        MeshFault
            If the set is not defined completely.
        """
        key = table, name.casefold()
        if key not in self.definitions:
            raise MeshFault(f"set: expected a known set, got {name!r}")
        if key not in self.sets:
            self.sets[key] = MeshFault(f"set {name}: expected no circular definition")
            try:
                members = [
                    member
                    for k, keyword in self.definitions[key]
                    for member in self._defined(table, k, keyword)
                ]
            except MeshFault as fault:
                members = fault
            self.sets[key] = members
        members = self.sets[key]
        if isinstance(members, MeshFault):
            raise members
        return members

    def _defined(self, table, k, keyword):
        """Return the members that a keyword adds to a set."""
        k = self._index(k, keyword.options.get("INSTANCE", ""))
        if table == "SURFACE":
            return self._sides(k, keyword)
        if table == "NSET" and "ELSET" in keyword.options:
            elements = self._members(k, keyword.options["ELSET"], "ELSET")
            return [row for key in elements for row in self._rows(*key)]
        cells = keyword.cells()
        if "GENERATE" in keyword.options:
            cells = []
            for row in keyword.rows():
                first, *rest = [int(cell) for cell in row if cell]
                last, step = (*rest, *(first, 1)[len(rest) :])
                cells += [str(label) for label in range(first, last + 1, step)]
        elif keyword.name == "SURFACE":  # of nodes, each with an area
            cells = [row[0] for row in keyword.rows()]
        return [member for cell in cells for member in self._members(k, cell, table)]

    def _sides(self, k, keyword):
        """Return the corners of the faces of elements that a surface contains."""
        combine = keyword.options.get("COMBINE", "").upper()
        if combine == "UNION":
            return [face for name in keyword.cells() for face in self._members(k, name, "SURFACE")]
        if combine or "CROP" in keyword.options:
            raise MeshFault(f"surface: expected faces or combine=union, got {keyword.options}")
        faces = []
        for element, *side in keyword.rows():
            sides = [FACES.get(side[0].upper())] if any(side) else list(FACES.values())
            for key in self._members(k, element, "ELSET"):
                nodes = self._rows(*key)
                if len(nodes) in (4, 10) and None in sides:
                    raise MeshFault(f"surface: expected a side S1 to S4, got {side[0]!r}")
                if len(nodes) in (4, 10):
                    faces += [[nodes[corner] for corner in corners] for corners in sides if corners]
                else:
                    faces += self._triangle(*key)
        return faces

    def _rows(self, k, label):
        """Return the rows of the nodes of an element, none if its type is not read."""
        _, nodes = self.parts[k].elements.get(label, ("", []))
        return rows_of(self.numbers[k], nodes, f"element {label}")

    def _triangle(self, k, label):
        """Return the corners of an element in a list, which is empty for other elements."""
        _, nodes = self.parts[k].elements.get(label, ("", []))
        return [self._rows(k, label)[:3]] if len(nodes) in (3, 6) else []

    def _index(self, k, name):
        """Return the index of an instance by its name, and k if the name is empty."""
        if not name:
            return k
        for index, part in enumerate(self.parts):
            if part.name.casefold() == name.casefold():
                return index
        raise MeshFault(f"set: expected a known instance, got {name!r}")

    def _members(self, k: int, cell: str, table: str) -> list[Any]:
        """Return the members of an entry: a number or the name of a set, either after INSTANCE."""
        if cell.lstrip("-").isdigit() and table != "SURFACE":
            if table == "NSET":
                return rows_of(self.numbers[k], [int(cell)], "a set")
            return [(k, int(cell))]
        for known in (f"{self.parts[k].name}.{cell}", cell):
            if (table, known.casefold()) in self.definitions:
                return self._set(table, known)
        instance, dot, label = cell.rpartition(".")
        if dot and label.isdigit():
            return self._members(self._index(k, instance), label, table)
        raise MeshFault(f"set: expected a known set, got {cell!r}")


def _keywords(path: Path) -> Iterator[Keyword]:
    """Yield the keywords with their data, also those of included files."""
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
