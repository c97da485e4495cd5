"""gmsh files of formats 2.2 and 4.1, in text or binary: nodes, tetrahedra and physical groups.

meshio 5.3.5 is not used: it rejects files with all elements or with parametric nodes, and loses
one of two groups with the same name.
"""

from collections import Counter
from collections.abc import Iterator
from itertools import groupby
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from .deck import Deck, MeshFault, Selection, tetrahedra

ELEMENTS = {
    15: ("vertex", 1),
    1: ("line", 2),
    8: ("line3", 3),
    2: ("triangle", 3),
    9: ("triangle6", 6),
    3: ("quad", 4),
    16: ("quad8", 8),
    10: ("quad9", 9),
    4: ("tetra", 4),
    11: ("tetra10", 10),
    5: ("hexahedron", 8),
    17: ("hexahedron20", 20),
    12: ("hexahedron27", 27),
    6: ("wedge", 6),
    18: ("wedge15", 15),
    13: ("wedge18", 18),
    7: ("pyramid", 5),
    19: ("pyramid13", 13),
    14: ("pyramid14", 14),
}
"""Name and number of nodes of gmsh's element types up to order 2."""
ORDER = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]
"""Nodes of gmsh's ten-node tetrahedron in the order of a deck."""
SURFACE, VOLUME = 2, 3


class ElementBlock(NamedTuple):
    """Elements of one type.

    Parameters
    ----------
    kind : str
    groups : tuple of int
        Tags of their physical groups.
    nodes : ndarray of int, shape (m, nodes)
        Node numbers.
    """

    kind: str
    groups: tuple[int, ...]
    nodes: np.ndarray


class _Numbers:
    """Numbers of a section in the order of the file, in text or binary."""

    def __init__(self, body, binary):
        self.body = body if binary else np.fromstring(body.decode(), sep=" ")
        self.binary = binary
        self.position = 0

    def take(self, kind: str, count: Any) -> np.ndarray:
        """Return the next numbers of a type: "i4", "u8" or "f8"."""
        count = int(count)
        size = np.dtype(kind).itemsize if self.binary else 1
        first, self.position = self.position, self.position + count * size
        if self.position > len(self.body):
            raise MeshFault("expected a complete file, got one that ends too early")
        if self.binary:
            return np.frombuffer(self.body, "<" + kind, count, first)
        return self.body[first : self.position].astype(kind)


def read_gmsh(path: Path) -> Deck:
    """Read nodes, tetrahedra and physical groups; a group without a name is known by its number.

    Raises
    ------
    MeshFault
        If the format is another one, or elements are of higher order.
    """
    sections = dict(_sections(path.read_bytes()))
    version, binary, *_ = sections["MeshFormat"].split()[:3]
    version, binary = version.decode(), binary == b"1"
    unusable = {"PartitionedEntities", "ParametricNodes"} & set(sections)
    if version not in ("2.2", "4.1") or unusable:
        raise MeshFault(
            f"expected gmsh's format 2.2 or 4.1, got {version} {' '.join(unusable)}".rstrip()
            + "; write it with Mesh.MshFileVersion = 4.1, without partitions"
        )
    names = {}
    lines = sections.get("PhysicalNames", b"").decode("utf-8", "replace").split("\n")[1:]
    for line in filter(str.strip, lines):
        dimension, tag, name = line.split(maxsplit=2)
        names[int(dimension), int(tag)] = name.strip().strip('"').strip()
    if version == "2.2":
        labels, points = _nodes_22(sections["Nodes"], binary)
        blocks = list(_elements_22(sections["Elements"], binary))
    else:
        entities = _Numbers(sections.get("Entities", b""), binary)
        tags = _physical_tags(entities) if len(entities.body) else {}
        labels, points = _nodes_41(_Numbers(sections["Nodes"], binary))
        blocks = list(_elements_41(_Numbers(sections["Elements"], binary), tags))
    return _deck(labels, points, blocks, names)


def _deck(labels, points, blocks, names):
    """Return the deck of nodes and blocks of elements."""
    order = np.argsort(labels)
    tets: list[list[int]] = []
    other: Counter[str] = Counter()
    faces: dict[str, list] = {}
    parts: dict[str, list] = {}
    others: dict[str, Counter[str]] = {}
    for kind, groups, nodes in blocks:
        index = np.searchsorted(labels, nodes, sorter=order).clip(max=len(labels) - 1)
        rows = order[index]
        if not np.array_equal(labels[rows], nodes):
            raise MeshFault(f"{kind}: expected known nodes, got unknown ones")
        if kind in ("triangle", "triangle6"):
            for tag in groups:
                faces.setdefault(names.get((SURFACE, tag), str(tag)), []).append(rows[:, :3])
        solid = kind in ("tetra", "tetra10")
        if solid:
            members = range(len(tets), len(tets) + len(rows))
            tets += (rows[:, ORDER] if kind == "tetra10" else rows).tolist()
        else:
            members = ()
            other[kind] += len(rows)
        if solid or kind.startswith(("hexa", "wedge", "pyramid")):
            for tag in groups:
                name = names.get((VOLUME, tag), str(tag))
                parts.setdefault(name, []).extend(members)
                others.setdefault(name, Counter())[kind] += 0 if solid else len(rows)
    return Deck(
        points=points,
        tets=tetrahedra(tets),
        node_sets={},
        faces={name: np.concatenate(rows) for name, rows in faces.items()},
        labels=labels,
        other=other,
        parts={
            name: Selection(np.array(rows, dtype=int), +others[name])
            for name, rows in parts.items()
        },
        faults={
            name: f"group {name} has no elements; in format 2.2, gmsh needs Mesh.SaveAll = 0"
            for (dimension, _), name in names.items()
            if dimension == SURFACE and name not in faces
        },
    )


def _sections(data: bytes) -> Iterator[tuple[str, bytes]]:
    """Yield name and content of each section."""
    first = data.find(b"$")
    while first >= 0:
        begin = data.find(b"\n", first) + 1
        name = data[first + 1 : begin].strip()
        end = data.find(b"$End" + name, begin)
        if not begin or end < 0:
            raise MeshFault(f"expected $End{name.decode()}, got the end of the file")
        yield name.decode(), data[begin:end]
        first = data.find(b"$", end + 1)


def _kind(number: Any) -> tuple[str, int]:
    """Return name and number of nodes of an element type."""
    if int(number) not in ELEMENTS:
        raise MeshFault(f"expected elements up to order 2, got gmsh's element type {number}")
    return ELEMENTS[int(number)]


def _nodes_22(body, binary):
    """Return numbers and positions of the nodes of format 2.2."""
    count, _, body = body.partition(b"\n")
    if binary:
        table = np.frombuffer(body, [("label", "<i4"), ("point", "<f8", 3)], int(count))
        return table["label"].astype(int), table["point"].copy()
    table = _Numbers(body, binary).take("f8", 4 * int(count)).reshape(-1, 4)
    return table[:, 0].astype(int), table[:, 1:]


def _elements_22(body, binary):
    """Yield the elements of format 2.2, which have several tags; the first one is their group."""
    count, _, body = body.partition(b"\n")
    if not binary:
        rows = [[int(text) for text in line.split()] for line in body.splitlines() if line.strip()]
        for (number, tags, group), same in groupby(rows, _row_group):
            kind, nodes = _kind(number)
            table = np.array([row[3 + tags : 3 + tags + nodes] for row in same])
            yield ElementBlock(kind, (group,) if group else (), table)
        return
    numbers, count_read = _Numbers(body, binary), 0
    while count_read < int(count):
        number, elements, tags = numbers.take("i4", 3)
        kind, nodes = _kind(number)
        table = numbers.take("i4", elements * (1 + tags + nodes)).reshape(elements, -1)
        count_read += int(elements)
        groups = table[:, 1] if tags else np.zeros(elements, dtype=int)
        for same in np.split(table, np.flatnonzero(np.diff(groups)) + 1):
            group = int(same[0, 1]) if tags else 0
            yield ElementBlock(kind, (group,) if group else (), same[:, 1 + tags :].astype(int))


def _row_group(row):
    """Return kind, number of tags and group of an element of format 2.2."""
    _, number, tags, *others = row
    return number, tags, others[0] if tags else 0


def _physical_tags(numbers):
    """Return the tags of the physical groups of each entity, by its dimension and tag."""
    tags = {}
    for dimension, count in enumerate(numbers.take("u8", 4)):
        for _ in range(int(count)):
            (tag,) = numbers.take("i4", 1)
            numbers.take("f8", 6 if dimension else 3)
            groups = numbers.take("i4", numbers.take("u8", 1)[0])
            tags[dimension, int(tag)] = tuple(np.abs(groups).tolist())  # negative if reversed
            if dimension:
                numbers.take("i4", numbers.take("u8", 1)[0])
    return tags


def _nodes_41(numbers):
    """Return numbers and positions of the nodes of format 4.1, without their parameters."""
    blocks, *_ = numbers.take("u8", 4)
    labels, points = [np.zeros(0, dtype=int)], [np.zeros((0, 3))]
    for _ in range(int(blocks)):
        dimension, _, parametric = numbers.take("i4", 3)
        (count,) = numbers.take("u8", 1)
        labels.append(numbers.take("u8", count).astype(int))
        width = 3 + (int(dimension) if parametric else 0)
        points.append(numbers.take("f8", int(count) * width).reshape(-1, width)[:, :3])
    return np.concatenate(labels), np.concatenate(points)


def _elements_41(numbers, tags):
    """Yield the elements of format 4.1, whose entities have groups."""
    blocks, *_ = numbers.take("u8", 4)
    for _ in range(int(blocks)):
        dimension, entity, number = numbers.take("i4", 3)
        kind, nodes = _kind(number)
        (count,) = numbers.take("u8", 1)
        table = numbers.take("u8", int(count) * (1 + nodes)).reshape(int(count), -1)
        yield ElementBlock(
            kind, tags.get((int(dimension), int(entity)), ()), table[:, 1:].astype(int)
        )
