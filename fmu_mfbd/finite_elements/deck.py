"""Contents of a mesh file of any program: nodes, tetrahedra, sets of nodes, named faces."""

import re
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

CORNERS, NODES = 4, 10
"""Numbers of nodes of a tetrahedron."""
OMITTED = {0: -1}
"""Row of the number 0, by which decks omit a middle node."""
FLAT = ("vertex", "line", "line3", "triangle", "triangle6", "quad", "quad8", "quad9")
"""Elements without volume."""


class MeshFault(ValueError):
    """Error for a mesh that cannot be used; `faults` contains one sentence for each fault."""

    def __init__(self, faults: str | Iterable[str]):
        self.faults = [faults] if isinstance(faults, str) else list(faults)
        super().__init__("\n".join(self.faults))

    def of_file(self, path: Path | str) -> "MeshFault":
        """Return the error with the path in front of each sentence that does not name it."""
        return MeshFault(text if str(path) in text else f"{path}: {text}" for text in self.faults)


class Selection(NamedTuple):
    """Solid elements of a part, an instance, or a named set of elements.

    Parameters
    ----------
    tets : ndarray of int
        Rows of the deck's tetrahedra.
    other : Counter
        Number of other solid elements by type.
    """

    tets: np.ndarray
    other: Counter[str] = Counter()


@dataclass(frozen=True)
class Deck:
    """Contents of a mesh file in its own axes and units.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    tets : ndarray of int, shape (e, 10)
        Rows of `points`: corners, then the middles of edges 01, 12, 02, 03, 13, 23; -1 if the file
        omits a middle node.
    node_sets : dict of str to ndarray of int
        Rows of `points`.
    faces : dict of str to ndarray of int, shape (t, 3)
        Corners of the triangles of each named surface.
    labels : ndarray of int, shape (n,), optional
        Node numbers in the file; None if several nodes have the same number.
    other : Counter
        Number of elements of each other type, by their name in the file.
    parts : dict of str to Selection
        Parts of the mesh by name.
    materials : sequence of str
        Material of each tetrahedron, empty if the file does not state it.
    properties : dict of str to dict of str to float
        young, poisson, density and expansion of each material, as far as the file has them.
    faults : dict of str to str
        Sets that the file does not define completely, with the reason.
    remarks : tuple of str
        Warnings.
    """

    points: np.ndarray
    tets: np.ndarray
    node_sets: dict[str, np.ndarray] = field(default_factory=dict)
    faces: dict[str, np.ndarray] = field(default_factory=dict)
    labels: np.ndarray | None = None
    other: Counter[str] = field(default_factory=Counter)
    parts: dict[str, Selection] = field(default_factory=dict)
    materials: Sequence[str] = ()
    properties: dict[str, dict[str, float]] = field(default_factory=dict)
    faults: dict[str, str] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()

    def known(self) -> list[str]:
        """Return the names of the surfaces."""
        return sorted(set(self.node_sets) | set(self.faces))

    def choice(self) -> list[str]:
        """Return a sentence about the option part, if the file has several parts."""
        names = list(self.parts)[:8]
        return [f"the option part selects one of {', '.join(names)}"] if len(names) > 1 else []

    def only(self, name: str) -> "Deck":
        """Return the deck with the solid elements of a part alone.

        Raises
        ------
        MeshFault
            If the file has no such part.
        """
        part = entry(self.parts, name)
        if part is None:
            names = ", ".join(self.parts) or "none"
            raise MeshFault(f"part: expected a part of the file ({names}), got {name!r}")
        rows = np.unique(part.tets)
        materials = [self.materials[row] for row in rows] if self.materials else ()
        number = np.full(len(self.tets), -1)
        number[rows] = np.arange(len(rows))
        parts = {
            key: one._replace(tets=number[one.tets][number[one.tets] >= 0])
            for key, one in self.parts.items()
        }
        tets = self.tets[rows]
        return replace(self, tets=tets, other=part.other, materials=materials, parts=parts)

    def completed(self) -> "Deck":
        """Return the deck with all middle nodes, and with remarks about nodes.

        Raises
        ------
        MeshFault
            If the deck has other solid elements than tetrahedra, linear and quadratic ones, or an
            element without a corner, or a coordinate that is not finite.
        """
        self._check()
        omitted = self.tets < 0
        remarks = list(self.remarks)
        if omitted[:, CORNERS:].all():
            remarks.append(
                "linear tetrahedra; edge nodes added at straight edges, curved walls stay polygons"
            )
        elif omitted.any():
            remarks.append(
                f"{omitted.sum()} midside nodes omitted in elements; each becomes that of a "
                "neighbour or the middle of its straight edge"
            )
        labels = self.labels
        used = np.unique(self.tets[~omitted])
        if labels is not None and (omitted.any() or len(np.unique(labels[used])) < len(used)):
            labels = None
        points, tets = self.points, self.tets
        if omitted.any():
            points, tets = with_middles(points, tets)
        return replace(self, points=points, tets=tets, labels=labels, remarks=tuple(remarks))

    def _check(self) -> None:
        """Raise MeshFault if there are elements that are not supported, or none."""
        present = ", ".join(f"{count} {kind}" for kind, count in self.other.items()) or "nothing"
        if not len(self.tets):
            raise MeshFault(f"expected 10-node tetrahedra, got {present}; {ELEMENTS}")
        if solids := {kind: n for kind, n in self.other.items() if kind not in FLAT}:
            present = ", ".join(f"{count} {kind}" for kind, count in solids.items())
            fault = f"expected 10-node tetrahedra only, got also {present}; {ELEMENTS}"
            raise MeshFault([fault, *self.choice()])
        linear = (self.tets[:, CORNERS:] < 0).all(axis=1).sum()
        if 0 < linear < len(self.tets):
            raise MeshFault(
                f"body: expected ten-node tetrahedra only, got {linear} of {len(self.tets)} with "
                "four nodes"
            )
        used = np.unique(self.tets[self.tets >= 0])
        if len(wrong := used[~np.isfinite(self.points[used]).all(axis=1)]):
            label = wrong[0] + 1 if self.labels is None else self.labels[wrong[0]]
            raise MeshFault(
                f"node {label}: expected finite coordinates, got {self.points[wrong[0]].tolist()}"
            )
        if bad := int((self.tets[:, :CORNERS] < 0).any(axis=1).sum()):
            raise MeshFault(f"expected four corners of each element, got {bad} elements with less")


ELEMENTS = (
    "only structural tetrahedra of 10 or 4 nodes are read; hexahedra, wedges, pyramids and "
    "superelements (CMS matrices) are not supported"
)


def entry(table: Mapping[str, Any], name: str) -> Any:
    """Return the entry of a name, or of the only name that differs in case alone, else None.

    ANSYS writes all names in capitals, and Abaqus ignores case.
    """
    if name in table:
        return table[name]
    same = [known for known in table if known.casefold() == name.casefold()]
    return table[same[0]] if len(same) == 1 else None


def with_middles(points: np.ndarray, tets: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Replace missing middle nodes (-1) of tetrahedra, (e, 10); return points and tetrahedra.

    An element gets the middle node of a neighbour on the same edge, else a new one at the middle of
    the straight edge.
    """
    from .element import EDGES  # slow to import

    ends = np.sort(tets[:, EDGES], axis=2).reshape(-1, 2)
    edges, number = np.unique(ends, axis=0, return_inverse=True)
    number = number.reshape(-1)
    middles = tets[:, CORNERS:].ravel()
    node = np.full(len(edges), -1)
    node[number[middles >= 0]] = middles[middles >= 0]
    new = np.flatnonzero(node < 0)
    node[new] = len(points) + np.arange(len(new))
    middles = np.where(middles < 0, node[number], middles).reshape(len(tets), -1)
    added = points[edges[new]].mean(axis=1)
    return np.vstack([points, added]), np.hstack([tets[:, :CORNERS], middles])


def real(text: str) -> float:
    """Return a real number of a deck; 1.5D3, 1.5d+3 and 1.5+3 are 1.5e3."""
    text = text.strip().upper().replace("D", "E")
    return float(re.sub(r"(?<=[\d.])([+-]\d+)$", r"E\1", text))


def text_of(path: Path) -> str:
    """Return the text of a deck in UTF-8 or UTF-16, without a byte-order mark."""
    data = path.read_bytes()
    wide = data.startswith((b"\xff\xfe", b"\xfe\xff"))
    return data.decode("utf-16" if wide else "utf-8-sig", errors="replace")


def rows_of(number: Mapping[int, int], nodes: Iterable[int], owner: str) -> list[int]:
    """Return the rows of nodes with the given numbers.

    Raises
    ------
    MeshFault
        If no node has the number; the message begins with `owner`.
    """
    try:
        return [number[node] for node in nodes]
    except KeyError as error:
        raise MeshFault(f"{owner}: expected a known node, got {error.args[0]}") from None


def rows_by_number(labels: Sequence[int], points: Sequence[Sequence[float]]) -> dict[int, int]:
    """Return the first row of each node number.

    Raises
    ------
    MeshFault
        If two nodes at different positions have the same number.
    """
    number: dict[int, int] = {}
    for row, label in enumerate(labels):
        first = number.setdefault(label, row)
        if tuple(points[first]) != tuple(points[row]):
            raise MeshFault(f"node {label}: expected one position, got two")
    return number


def tetrahedra(elements: Sequence[Sequence[int]]) -> np.ndarray:
    """Return tetrahedra of four or ten nodes as an array, (e, 10), with -1 for omitted nodes."""
    rows = [[*nodes, *[-1] * (NODES - len(nodes))] for nodes in elements]
    return np.array(rows, dtype=np.int64).reshape(-1, NODES)


def parts_of(
    groups: Mapping[str, Collection[Any]], solids: Mapping[Any, int], others: Mapping[Any, str]
) -> dict[str, Selection]:
    """Return the parts of a file: the groups of elements that contain solid elements.

    Parameters
    ----------
    groups : mapping of str to collection
        Keys of the elements of each group.
    solids : mapping
        Row of each tetrahedron among those of the deck, by the key of the element.
    others : mapping
        Type of each other element by its key.
    """
    parts: dict[str, Selection] = {}
    for name, keys in groups.items():
        tets = [solids[key] for key in keys if key in solids]
        other = Counter(others[key] for key in keys if key in others)
        if tets or other.keys() - {*FLAT}:
            parts[name] = Selection(np.array(tets, dtype=int), other)
    return parts


def first_rows(
    names: Sequence[str], rows: Sequence[Sequence[float]], material: str
) -> tuple[dict[str, float], list[str]]:
    """Return the properties in the first row of a table, and a remark if they are not constant.

    Parameters
    ----------
    names : sequence of str
        Properties in the first columns; others follow, for example the temperature.
    rows : sequence of sequence of float
    material : str
    """
    if not rows:
        return {}, []
    count = len(names)
    values = dict(zip(names, rows[0]))
    if all(list(row[:count]) == list(rows[0][:count]) for row in rows):
        return values, []
    names_of = " and ".join(names)
    return values, [
        f"material {material}: {names_of} depend on temperature; the first of {len(rows)} rows "
        "is used"
    ]


def lines_of(
    path: Path,
    clean: Callable[[str], Iterable[str]],
    include: Callable[[str], str | None],
    above: tuple[Path, ...] = (),
) -> Iterator[str]:
    """Yield the lines of a deck, with those of included files instead of the include lines.

    Parameters
    ----------
    path : Path
    clean : callable
        Splits the text of a file into lines without comments.
    include : callable
        Returns the file name in an include line, relative to the including file, and None for other
        lines.
    above : tuple of Path
        Decks that include this one.

    Raises
    ------
    MeshFault
        If an included file does not exist, or includes itself.
    """
    above = (*above, path.resolve())
    for line in clean(text_of(path)):
        name = include(line)
        if name is None:
            yield line
            continue
        inner = path.parent / name
        if not inner.is_file():
            inner = path.parent / name.replace("\\", "/")  # written on Windows
        if not inner.is_file():
            raise MeshFault(f"{path.name}: expected to include {name!r}, got no such file {inner}")
        if inner.resolve() in above:
            raise MeshFault(f"{path.name}: expected no circular include, got {name!r}")
        yield from lines_of(inner, clean, include, above)
