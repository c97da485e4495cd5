"""MED files of Salome and Code_Aster: nodes, tetrahedra and groups.

meshio 5.3.5 is not used: it inverts the elements, because MED numbers their nodes the other way
around, and rejects files where some elements have no group.
"""

from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from .deck import Deck, MeshFault, Selection, tetrahedra

TETRAHEDRA = {"TE4": [0, 2, 1, 3], "T10": [0, 2, 1, 3, 6, 5, 4, 7, 9, 8]}
"""Nodes of the tetrahedra in the order of a deck."""
FLAT = {"PO1": "vertex", "SE2": "line", "SE3": "line3", "TR3": "triangle", "TR6": "triangle6"}
FLAT |= {"QU4": "quad", "QU8": "quad8", "QU9": "quad9"}


def read_med(path: Path) -> Deck:
    """Read nodes, tetrahedra and groups of the only mesh of a file.

    Raises
    ------
    MeshFault
        If there are several meshes, or the file is no HDF5.
    """
    import h5py

    if path.is_file() and not h5py.is_hdf5(path):
        raise MeshFault("expected a MED file in HDF5, got other content")
    with h5py.File(path) as file:
        meshes: Any = file["ENS_MAA"]
        if len(meshes) != 1:
            raise MeshFault(f"expected one mesh, got {', '.join(meshes)}")
        ((name, mesh),) = meshes.items()
        families = file.get(f"FAS/{name}", {})
        if "NOE" not in mesh:
            ((_, mesh),) = mesh.items()  # the only step
        nodes = mesh["NOE"]
        points = nodes["COO"][()].reshape(3, -1).T.copy()
        labels = nodes["NUM"][()] if "NUM" in nodes else np.arange(1, len(points) + 1)
        sets = _members(_groups(families, "NOEUD"), nodes)
        groups = _groups(families, "ELEME")
        tets: list[list[int]] = []
        faces: dict[str, list] = {}
        parts: dict[str, tuple[list, Counter[str]]] = {}
        other: Counter[str] = Counter()
        for kind, elements in mesh["MAI"].items():
            count = int(elements["NOD"].attrs["NBR"])
            rows = elements["NOD"][()].reshape(-1, count).T - 1
            for name, members in _members(groups, elements).items():
                solids, others = parts.setdefault(name, ([], Counter()))
                if kind in TETRAHEDRA:
                    solids += (members + len(tets)).tolist()
                elif kind in ("TR3", "TR6"):
                    faces.setdefault(name, []).append(rows[members, :3])
                elif kind not in FLAT:
                    others[kind] += len(members)
            if kind in TETRAHEDRA:
                tets += rows[:, TETRAHEDRA[kind]].tolist()
            else:
                other[FLAT.get(kind, kind)] += count
    faces_of = {name: np.concatenate(rows) for name, rows in faces.items()}
    selections = {
        name: Selection(np.array(solids, dtype=int), others)
        for name, (solids, others) in parts.items()
        if solids or others
    }
    return Deck(
        points=points,
        tets=tetrahedra(tets),
        node_sets=sets,
        faces=faces_of,
        labels=labels,
        other=other,
        parts=selections,
    )


def _groups(families, kind):
    """Return the names of the groups of each family."""
    groups = {}
    for family in families.get(kind, {}).values():
        names = family["GRO/NOM"][()] if "GRO" in family else []
        texts = [bytes(name.tolist()).split(b"\0")[0].decode(errors="replace") for name in names]
        groups[int(family.attrs["NUM"])] = [text.strip() for text in texts]
    return groups


def _members(groups, table):
    """Return the rows of a table of nodes or elements in each group."""
    family = table["FAM"][()] if "FAM" in table else np.zeros(0, dtype=int)
    members = {}
    for number, names in groups.items():
        rows = np.flatnonzero(family == number)
        for name in names if len(rows) else ():
            members[name] = np.union1d(members.get(name, []), rows).astype(int)
    return members
