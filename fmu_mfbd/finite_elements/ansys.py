"""ANSYS archives (.cdb, as CDWRITE writes them): nodes, tetrahedra and components of nodes.

meshio 5.3.5 does not read this format.
"""

import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from .deck import Deck, MeshFault, rows_by_number, rows_of, tetrahedra

TETRAHEDRA = {"187": 10, "92": 10, "285": 4}
"""Numbers of nodes of the structural tetrahedra, by the number of the element type."""
SOLIDS = {"5", "45", "62", "70", "87", "90", "95", "96", "98", "122", "123", "148", "168"}
SOLIDS |= {"185", "186", "190", "226", "227", "232", "237", "240", "278", "279", "291"}
"""Other solid elements. The reader skips all others, for example contact, shells and springs."""


def read_ansys(path: Path) -> Deck:
    """Read nodes, tetrahedra (SOLID187, 92, 285) and components of nodes of an archive in blocks.

    Raises
    ------
    MeshFault
        If there is no block of nodes or solid elements, or a tetrahedron lacks a middle node.
    """
    lines = iter(path.read_text(errors="replace").splitlines())
    labels: list[int] = []
    points: list[list[float]] = []
    elements: list[tuple[int, str, list[int]]] = []
    components: dict[str, list[int]] = {}
    kinds: dict[str, str] = {}
    for line in lines:
        words = [word.strip() for word in line.split("!")[0].split(",")]
        command = words[0].upper()
        if command == "ET":
            _, number_of_type, name, *_ = words
            kinds[number_of_type] = re.sub(r"\D", "", name)
        elif command == "NBLOCK":
            _read_nodes(lines, labels, points)
        elif command == "EBLOCK":
            if "SOLID" not in (word.upper() for word in words):
                raise MeshFault(f"{path}: expected an EBLOCK with SOLID, got one without")
            elements += _elements(lines)
        elif command == "CMBLOCK":
            components |= _component(lines, words)
    if not labels or not elements:
        raise MeshFault(
            f"{path}: expected NBLOCK and EBLOCK, got {len(labels)} nodes and {len(elements)} "
            "elements; write them with CDWRITE,DB,name,cdb,,,,BLOCKED"
        )
    number = rows_by_number(labels, points)
    tets = []
    other: Counter[str] = Counter()
    for label, type_number, nodes in elements:
        kind = kinds.get(type_number, "")
        if kind in TETRAHEDRA:
            tets.append(rows_of(number, _nodes(kind, label, nodes), f"element {label}"))
        elif kind in SOLIDS or not kind:
            other[f"SOLID{kind}" if kind else f"type {type_number}, which no ET names"] += 1
    sets = {
        name: np.unique(rows_of(number, nodes, f"component {name}"))
        for name, nodes in components.items()
    }
    return Deck(np.array(points), tetrahedra(tets), sets, labels=np.array(labels), other=other)


def _nodes(kind, label, nodes):
    """Return the nodes of a tetrahedron; a missing middle node is 0 in the file."""
    count = TETRAHEDRA[kind]
    if len(nodes) < count or 0 in nodes[:count]:
        raise MeshFault(f"element {label}, SOLID{kind}: expected {count} nodes, got {len(nodes)}")
    return nodes[:count]


def _read_nodes(lines, labels, points):
    """Read the nodes of an NBLOCK: integers, then reals, which are 0 if omitted at the end."""
    integers, width, size = _format(r"(\d+)i(\d+)\s*,\s*\d+[a-z](\d+)", next(lines))
    first = integers * width
    for line in lines:
        if line.upper().startswith("N,") or line.split(",")[0].strip() == "-1":
            return
        labels.append(int(line[:width]))
        texts = [line[k : k + size].strip() for k in range(first, first + 3 * size, size)]
        points.append([float(text.upper().replace("D", "E")) if text else 0.0 for text in texts])


def _elements(lines: Iterator[str]) -> Iterator[tuple[int, str, list[int]]]:
    """Yield number, type and nodes of each element of an EBLOCK with SOLID.

    An element has eleven numbers, of which the ninth is the number of nodes, and then its nodes.
    """
    (width,) = _format(r"\d+i(\d+)\s*\)", next(lines))
    for line in lines:
        row = _numbers(line, width)
        if not row or row[0] == -1:
            return
        _, kind, _, _, _, _, _, _, count, _, label, *nodes = row
        while len(nodes) < count:
            nodes += _numbers(next(lines), width)
        yield label, str(kind), nodes[:count]


def _component(lines, words):
    """Return the component of a CMBLOCK of nodes, where a negative number ends a range."""
    (width,) = _format(r"\d+i(\d+)\s*\)", next(lines))
    _, name, kind, count, *_ = words
    numbers: list[int] = []
    while len(numbers) < int(count):
        numbers += _numbers(next(lines), width)
    if not kind.upper().startswith("NODE"):
        return {}
    nodes: list[int] = []
    for number in numbers:
        nodes += range(nodes[-1] + 1, 1 - number) if number < 0 else [number]
    return {name: nodes}


def _format(pattern, line):
    """Return the numbers in the format line of a block."""
    match = re.match(r"\s*\(\s*" + pattern, line, re.IGNORECASE)
    if not match:
        raise MeshFault(f"block: expected a known format, got {line.strip()!r}")
    return [int(text) for text in match.groups()]


def _numbers(line, width):
    """Return the integers of a line of columns."""
    line = line.rstrip()
    return [int(line[k : k + width]) for k in range(0, len(line), width)]
