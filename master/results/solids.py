"""Bodies on their meshes, for the page: surfaces, mode shapes, and where they are at each
instant.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from .packing import Columns, packed_counts, packed_frames, packed_shorts, packed_singles

LEAST = 1e-4
"""Smallest singular value of the displacement on the page, relative to the largest one."""


class Stand(NamedTuple):
    """Where a cylinder stands in its engine: along the crankshaft, z [m], and turned about it from
    upright, its bank angle [rad].
    """

    along: float = 0.0
    bank: float = 0.0

    def turned(self, vectors: np.ndarray) -> np.ndarray:
        """Vectors (n, 3) of the cylinder in the engine's axes."""
        return vectors @ about_z(self.bank).T

    def placed(self, points: np.ndarray) -> np.ndarray:
        """Points (n, 3) of the cylinder in the engine [m]."""
        return self.turned(points) + [0.0, 0.0, self.along]


def about_z(angle: float) -> np.ndarray:
    """Matrix that turns by an angle about z [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def moved(points: np.ndarray, motion: np.ndarray | None) -> np.ndarray:
    """Points (n, 3) of a body that has gone across and along [m] and turned about z [rad]."""
    if motion is None:
        return points
    across, along, turn = motion
    return points @ about_z(turn).T + [across, along, 0.0]


@dataclass(frozen=True)
class Solid:
    """The surface of a body of one run.

    A point is at R(beta) (p + Phi q) + (across, along, 0), which the page computes
    (templates/bodies.js); its slider multiplies Phi q, across and beta.

    Parameters
    ----------
    name : str
    points : ndarray, shape (n, 3)
        p, from the body's origin [m].
    triangles : ndarray of int, shape (t, 3)
    modes : ndarray, shape (n, 3, k)
        Phi, displacement by coordinate; k may be 0.
    coordinates : ndarray, shape (instants, k)
        q at the run's recorded instants.
    motion : ndarray, shape (instants, 3), or None
        across, along [m] and beta about z [rad] at them; None: the body rests, and is cut open.
    film : (float, float) or None
        Heights of the points between which fields lie around the body [m].
    stress : ndarray, shape (instants, n), or None
        Equivalent stress at the points [Pa].
    fields : dict of str to (float, float)
        Ports of fields that lie around the body, and between which of its heights each does [m];
        a body with `film` and none named has all of them there.
    owner : str
        Participant whose body it is, "" where there is one alone.
    held : bool
        Whether what the body does is known: of one without coordinates False says that it deflects,
        but that its coordinates were not recorded.
    stand : Stand
        Of its cylinder; the page draws every cylinder upright.
    schematic : bool
        Whether the shape is none of a mesh. The page draws its motion at true scale.
    """

    name: str
    points: np.ndarray
    triangles: np.ndarray
    modes: np.ndarray
    coordinates: np.ndarray
    motion: np.ndarray | None = None
    film: tuple[float, float] | None = None
    stress: np.ndarray | None = None
    fields: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    owner: str = ""
    held: bool = True
    stand: Stand = Stand()
    schematic: bool = False

    def title(self, between: str = " ") -> str:
        """Its name, after that of its owner where it has one."""
        return between.join(filter(None, (self.owner, self.name)))

    def between(self, port: str) -> tuple[float, float] | None:
        """Heights between which a field lies around the body [m], None where it does not."""
        return self.fields.get(port) if self.fields else self.film

    def largest_displacement(self) -> float:
        """Of all points at all instants, |Phi q| [m]; 0 without modes."""
        found = 0.0
        for q in self.coordinates if self.modes.shape[2] else ():
            found = max(found, float(np.linalg.norm(self.modes @ q, axis=1).max()))
        return found


def solids_data(
    runs: list[list[Solid]], columns: Columns, fields: Sequence[str] = ()
) -> dict[str, Any]:
    """Solids of every run for the page's script, which numbers the `fields` (ports) it draws;
    meshes and modes of equal bodies are kept once.
    """
    meshes: dict[tuple[str, str, str], int] = {}
    return {
        "runs": [[_solid(solid, meshes, columns, fields) for solid in solids] for solids in runs],
        "meshes": [
            {"points": points, "triangles": triangles, "modes": modes}
            for points, triangles, modes in meshes
        ],
    }


def principal(solid: Solid) -> tuple[np.ndarray, np.ndarray]:
    """Return fewer modes (n, 3, r) and coordinates (instants, r) with the displacement of a body.

    The largest component of a mode is 1. The modes are the singular vectors of the displacement at
    all instants, without those whose singular value is below `LEAST` of the largest one.
    """
    count, size = len(solid.points), solid.modes.shape[2]
    if not size:
        return solid.modes, solid.coordinates
    basis, triangle = np.linalg.qr(solid.modes.reshape(3 * count, size))
    left, values, right = np.linalg.svd(solid.coordinates @ triangle.T, full_matrices=False)
    kept = values > LEAST * values[0]
    shapes = basis @ right[kept].T
    largest = np.abs(shapes).max(axis=0, initial=0.0)
    return (shapes / largest).reshape(count, 3, -1), left[:, kept] * values[kept] * largest


def _solid(solid, meshes, columns, fields):
    modes, coordinates = principal(solid)
    texts = (
        packed_singles(solid.points),
        packed_counts(solid.triangles),
        packed_shorts(np.moveaxis(modes, 2, 0)),  # one mode after the other
    )
    return {
        "name": solid.name,
        "mesh": meshes.setdefault(texts, len(meshes)),
        "count": modes.shape[2],
        "coordinates": columns.add(coordinates),
        "motion": None if solid.motion is None else columns.add(solid.motion),
        "over": [solid.between(port) for port in fields],
        "owner": solid.owner,
        "held": solid.held,
        "schematic": solid.schematic,
        "largest": solid.largest_displacement(),
        "stress": None if solid.stress is None else _stress_data(solid.stress),
    }


def _stress_data(stress):
    """Stress in MPa as frames of a field, with its range."""
    shown = stress * 1e-6
    return packed_frames(shown) | {
        "shape": [shown.shape[1], 1],
        "low": float(shown.min()),
        "high": float(shown.max()),
    }
