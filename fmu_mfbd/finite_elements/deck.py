"""Contents of a mesh file of any program: nodes, tetrahedra, sets of nodes, named faces."""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

LINEAR, QUADRATIC = 4, 10
"""Numbers of nodes of a tetrahedron."""


class MeshFault(ValueError):
    """Error for a mesh that cannot be used; `faults` contains one sentence for each fault."""

    def __init__(self, faults: str | Iterable[str]):
        self.faults = [faults] if isinstance(faults, str) else list(faults)
        super().__init__("\n".join(self.faults))

    def of_file(self, path: Path | str) -> "MeshFault":
        """Return the error with the path in front of each sentence that does not name it."""
        return MeshFault(text if str(path) in text else f"{path}: {text}" for text in self.faults)


@dataclass(frozen=True)
class Deck:
    """Contents of a mesh file in its own axes and units.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
    tets : ndarray of int, shape (e, 10) or (e, 4)
        Rows of `points`: corners, then the middles of edges 01, 12, 02, 03, 13, 23.
    node_sets : dict of str to ndarray of int
        Rows of `points`.
    faces : dict of str to ndarray of int, shape (t, 3)
        Corners of the triangles of each named surface.
    labels : ndarray of int, shape (n,), optional
        Node numbers in the file; None if several nodes have the same number.
    other : Counter
        Number of elements of each other type, by their name in the file.
    """

    points: np.ndarray
    tets: np.ndarray
    node_sets: dict[str, np.ndarray] = field(default_factory=dict)
    faces: dict[str, np.ndarray] = field(default_factory=dict)
    labels: np.ndarray | None = None
    other: Counter[str] = field(default_factory=Counter)

    def known(self) -> list[str]:
        """Return the names of the surfaces."""
        return sorted(set(self.node_sets) | set(self.faces))


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
    """Return tetrahedra of one order as an array, (e, 10) or (e, 4).

    Raises
    ------
    MeshFault
        If there are both linear and quadratic tetrahedra.
    """
    kinds = Counter(map(len, elements))
    if len(kinds) > 1:
        raise MeshFault(
            f"body: expected ten-node tetrahedra only, got {kinds[LINEAR]} of "
            f"{len(elements)} with four nodes"
        )
    return np.array(elements, dtype=np.int64).reshape(-1, *(kinds or [QUADRATIC]))


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
    for line in clean(path.read_text(errors="replace")):
        name = include(line)
        if name is None:
            yield line
            continue
        inner = path.parent / name
        if not inner.is_file():
            raise MeshFault(f"{path.name}: expected to include {name!r}, got no such file {inner}")
        if inner.resolve() in above:
            raise MeshFault(f"{path.name}: expected no circular include, got {name!r}")
        yield from lines_of(inner, clean, include, above)
