"""What a mesh file of any program holds: nodes, tetrahedra, sets of nodes, named faces."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

LINEAR, QUADRATIC = 4, 10
"""Nodes of a tetrahedron."""


class MeshFault(ValueError):
    """A mesh that cannot be used; `faults` holds one sentence each."""

    def __init__(self, faults: Iterable[str]):
        self.faults = list(faults)
        super().__init__("\n".join(self.faults))


@dataclass(frozen=True)
class Deck:
    """A mesh file as it is, in its own axes and units.

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
        The file's numbers of its nodes; None where one number stands for several.
    other : Counter
        How many elements it holds of each other kind, by the file's word.
    """

    points: np.ndarray
    tets: np.ndarray
    node_sets: dict[str, np.ndarray] = field(default_factory=dict)
    faces: dict[str, np.ndarray] = field(default_factory=dict)
    labels: np.ndarray | None = None
    other: Counter[str] = field(default_factory=Counter)

    def known(self) -> list[str]:
        """Names of its surfaces."""
        return sorted(set(self.node_sets) | set(self.faces))


def rows_of(number: Mapping[int, int], nodes: Iterable[int], what: str) -> list[int]:
    """Rows of nodes that the file names by number.

    Raises
    ------
    MeshFault
        At a number that no node has.
    """
    try:
        return [number[node] for node in nodes]
    except KeyError as error:
        raise MeshFault([f"{what}: expected a known node, got {error.args[0]}"]) from None


def rows_by_number(labels: Sequence[int], points: Sequence[Sequence[float]]) -> dict[int, int]:
    """First row of each node by its number.

    Raises
    ------
    MeshFault
        Where a number stands for two places.
    """
    number: dict[int, int] = {}
    for row, label in enumerate(labels):
        first = number.setdefault(label, row)
        if tuple(points[first]) != tuple(points[row]):
            raise MeshFault([f"node {label}: expected one position, got two"])
    return number


def tetrahedra(found: Sequence[Sequence[int]], first: int = 0) -> np.ndarray:
    """Tetrahedra of one order, (e, 10) or (e, 4), rows counted from `first` on.

    Raises
    ------
    MeshFault
        Where linear and quadratic ones stand side by side.
    """
    kinds = Counter(len(one) for one in found)
    if len(kinds) > 1:
        raise MeshFault(
            [
                f"body: expected ten-node tetrahedra only, got {kinds[LINEAR]} of "
                f"{kinds[LINEAR] + kinds[QUADRATIC]} with four nodes"
            ]
        )
    shape = (-1, 10) if not found else (len(found), len(found[0]))
    return np.array(found, dtype=np.int64).reshape(shape) + first


def included(path: Path, name: str, above: Sequence[Path]) -> Path:
    """File that a deck includes, beside the deck that names it.

    Parameters
    ----------
    path : Path
        The including deck.
    name : str
        As the deck gives it.
    above : sequence of Path
        Decks that are being read.

    Raises
    ------
    MeshFault
        If it is not there, or includes itself.
    """
    found = path.parent / name
    if not found.is_file():
        raise MeshFault([f"{path.name}: expected to include {name!r}, got no such file {found}"])
    if found.resolve() in [one.resolve() for one in above]:
        raise MeshFault([f"{path.name}: expected no circular include, got {name!r}"])
    return found
