"""Ansys archives (CDWRITE, Workbench's ds.dat): nodes, tetrahedra and components.

meshio 5.3.5 does not read this format. mapdl-archive 0.4.2 is not used: it loses components of
elements and the names of bodies, and needs a compiled library.
"""

import re
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np

from .deck import (
    OMITTED,
    Deck,
    MeshFault,
    first_rows,
    parts_of,
    real,
    rows_by_number,
    rows_of,
    tetrahedra,
    text_of,
)

TETRAHEDRA = {"187": 10, "92": 10, "285": 4}
"""Numbers of nodes of the structural tetrahedra, by the number of the element type."""
SOLIDS = {"5", "45", "62", "70", "87", "90", "95", "96", "98", "122", "123", "148", "168"}
SOLIDS |= {"185", "186", "190", "226", "227", "232", "237", "240", "278", "279", "291"}
"""Other solid elements. The reader skips all others, for example contact, shells and springs."""


BRICKS = {"45": 8, "185": 8, "95": 20, "186": 20}
"""Numbers of nodes of the structural bricks, which repeat nodes to become tetrahedra."""
OF_BRICK = (0, 1, 2, 4, 8, 9, 11, 16, 17, 18)
"""Nodes of a ten-node tetrahedron in a brick: I, J, K, M, and Q, R, T, Y, Z, A."""


PROPERTIES = {
    "EX": "young",
    "NUXY": "poisson",
    "PRXY": "poisson",
    "DENS": "density",
    "ALPX": "expansion",
}
"""Properties by their label in MP and MPDATA."""


class Element(NamedTuple):
    """Element of an EBLOCK.

    Parameters
    ----------
    label : int
    kind : str
        Number of its type.
    material : int
    nodes : list of int
        0 for omitted middle nodes.
    solid : bool
        Whether its block has solid elements.
    body : str
        Name of the body in the comment that Workbench writes before the block.
    """

    label: int
    kind: str
    material: int
    nodes: list[int]
    solid: bool
    body: str


class _Archive:
    """Blocks of an archive."""

    def __init__(self, text):
        self.labels: list[int] = []
        self.points: list[list[float]] = []
        self.elements: list[Element] = []
        self.nodes: dict[str, list[int]] = {}
        self.components: dict[str, list[int]] = {}
        self.kinds: dict[str, str] = {}
        self.properties: dict[tuple[str, str], list[float]] = {}
        body = ""
        lines = iter(text.splitlines())
        for line in lines:
            words = [word.strip() for word in line.split("!")[0].split(",")]
            command = words[0].upper()
            if name := re.match(r"(?i)/com,.*elements for body \d+\s+[\"'](.*?)[\"']", line):
                body = name[1]
            elif command == "ET":
                _, number_of_type, name, *_ = words
                self.kinds[number_of_type] = re.sub(r"\D", "", name)
            elif command in ("MP", "MPDATA"):
                self._add_property(command, words[1:])
            elif command == "ETBLOCK":
                (width,) = _format(r"\d*i(\d+)", next(lines))
                rows = _rows(lines, width, 2)  # key options follow
                self.kinds |= {str(number): str(kind) for number, kind in rows}
            elif command == "NBLOCK":
                _read_nodes(lines, self.labels, self.points)
            elif command == "EBLOCK":
                solid = "SOLID" in (word.upper() for word in words)
                self.elements += _elements(lines, solid, body)
                body = ""
            elif command == "CMBLOCK":
                _, name, kind, count, *_ = words
                nodes = kind.upper().startswith("NODE")
                members = _component(lines, int(count))
                (self.nodes if nodes else self.components)[name] = members

    def _add_property(self, command, words):
        """Add a property of a material: MP, label, material, values, or MPDATA with their index.

        MPDATA may have a release and the number of values in front of the label.
        """
        if words[0].upper().startswith("R") and words[0].upper() not in PROPERTIES:
            words = words[2:]
        label, material, *values = words
        first = 1 if command == "MPDATA" else 0
        if label.upper() in PROPERTIES and material.isdigit():
            key = f"MAT {material}", PROPERTIES[label.upper()]
            numbers = []
            with suppress(ValueError):  # a parameter of the program; the value is then missing
                numbers = [real(text) for text in values[first:] if text]
            if command == "MP":
                numbers = numbers[:1] + [one for one in numbers[1:] if one]
            if command == "MPDATA" and values[:1] and values[0] not in ("", "1"):
                self.properties.setdefault(key, []).extend(numbers)
            else:
                self.properties[key] = numbers

    def materials(self) -> tuple[dict[str, dict[str, float]], list[str]]:
        """Return the properties of each material, and remarks on those that are not constant."""
        table: dict[str, dict[str, float]] = {}
        remarks = []
        for (material, name), values in self.properties.items():
            own, remark = first_rows([name], [[value] for value in values], material)
            table.setdefault(material, {}).update(own)
            remarks += remark
        return table, remarks


def read_ansys(path: Path) -> Deck:
    """Read nodes, tetrahedra (SOLID187, 92, 285) and components of an archive in blocks.

    Parts are components of elements and the bodies of Workbench.

    Raises
    ------
    MeshFault
        If there is no block of nodes or elements.
    """
    archive = _Archive(text_of(path))
    if not archive.labels or not archive.elements:
        raise MeshFault(
            f"{path}: expected NBLOCK and EBLOCK, got {len(archive.labels)} nodes and "
            f"{len(archive.elements)} elements; write them with CDWRITE,DB,name,cdb,,,,BLOCKED"
        )
    number = rows_by_number(archive.labels, archive.points)
    rows = number | OMITTED
    tets: dict[int, list[int]] = {}
    materials: list[str] = []
    others: dict[int, str] = {}
    groups = dict(archive.components)
    for label, type_number, material, nodes, solid, body in archive.elements:
        kind = archive.kinds.get(type_number, "")
        if (brick := BRICKS.get(kind)) and is_tetrahedron(nodes):
            kind, nodes = "187", [([*nodes, *[0] * 12])[k] for k in OF_BRICK if k < brick]
        if kind in TETRAHEDRA:
            owner = f"element {label}, SOLID{kind}"
            tets[label] = rows_of(rows, _nodes(nodes, TETRAHEDRA[kind], owner), owner)
            materials.append(f"MAT {material}")
        elif kind in SOLIDS or (solid and not kind):
            others[label] = f"SOLID{kind}" if kind else f"type {type_number}, which no ET names"
        if body:
            groups.setdefault(body, []).append(label)
    row = {label: row for row, label in enumerate(tets)}

    properties, remarks = archive.materials()
    return Deck(
        np.array(archive.points),
        tetrahedra(list(tets.values())),
        {
            name: np.unique(rows_of(number, nodes, f"component {name}"))
            for name, nodes in archive.nodes.items()
        },
        labels=np.array(archive.labels),
        other=Counter(others.values()),
        parts=parts_of(groups, row, others),
        materials=materials,
        properties=properties,
        remarks=tuple(remarks),
    )


def is_tetrahedron(nodes: list[int]) -> bool:
    """Return whether a brick repeats its corners, K = L and M = N = O = P, as a tetrahedron."""
    return nodes[2:3] == nodes[3:4] and len(nodes) >= 8 and len({*nodes[4:8]}) == 1


def _nodes(nodes, count, owner):
    """Return the nodes of a tetrahedron, 0 for omitted middle nodes."""
    if len(nodes) < 4:
        raise MeshFault(f"{owner}: expected {count} nodes, got {len(nodes)}")
    return [*nodes[:count], *[0] * (count - len(nodes))]


def _read_nodes(lines, labels, points):
    """Read the nodes of an NBLOCK: integers, then reals, which are 0 if omitted at the end."""
    integers, width, size = _format(r"(\d*)i(\d+)\s*,\s*\d*[a-z](\d+)", next(lines))
    first = integers * width
    for line in lines:
        if line.upper().startswith("N,") or line.split(",")[0].strip() == "-1":
            return
        labels.append(int(line[:width]))
        texts = [line[k : k + size].strip() for k in range(first, first + 3 * size, size)]
        points.append([real(text) if text else 0.0 for text in texts])


def _elements(lines: Iterator[str], solid: bool, body: str) -> Iterator[Element]:
    """Yield the elements of an EBLOCK.

    With SOLID an element has eleven numbers, of which the ninth is the number of nodes, and then
    its nodes. Otherwise a line has number, type, constants, material, system and nodes.
    """
    (width,) = _format(r"\d*i(\d+)\s*\)", next(lines))
    rows = _rows(lines, width)
    for row in rows:
        if not solid:
            label, kind, _, material, _, *nodes = row
            yield Element(
                label=label, kind=str(kind), material=material, nodes=nodes, solid=solid, body=body
            )
            continue
        material, kind, _, _, _, _, _, _, count, _, label, *nodes = row
        while len(nodes) < count:
            nodes += next(rows)
        yield Element(
            label=label,
            kind=str(kind),
            material=material,
            nodes=nodes[:count],
            solid=solid,
            body=body,
        )


def _rows(lines: Iterator[str], width: int, most: int | None = None) -> Iterator[list[int]]:
    """Yield the integers of each line of a block up to -1, at most so many of each line."""
    for line in lines:
        row = _numbers(line, width, most)
        if row[:1] == [-1] or not row:
            return
        yield row


def _component(lines, count):
    """Return the members of a CMBLOCK of `count` numbers, where a negative number ends a range."""
    (width,) = _format(r"\d*i(\d+)\s*\)", next(lines))
    numbers: list[int] = []
    while len(numbers) < count:
        numbers += _numbers(next(lines), width)
    nodes: list[int] = []
    for number in numbers:
        nodes += range(nodes[-1] + 1, 1 - number) if number < 0 else [number]
    return nodes


def _format(pattern, line):
    """Return the numbers in the format line of a block."""
    match = re.match(r"\s*\(\s*" + pattern, line, re.IGNORECASE)
    if not match:
        raise MeshFault(f"block: expected a known format, got {line.strip()!r}")
    return [int(text or 1) for text in match.groups()]


def _numbers(line, width, most=None):
    """Return the integers of a line of columns, at most so many."""
    line = line.rstrip()[: most and most * width]
    return [int(line[k : k + width]) for k in range(0, len(line), width)]
