"""Bodies on their meshes for the page: surfaces, mode shapes and motion."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from .packing import Columns, packed_as, packed_frames

LEAST_SINGULAR_VALUE = 1e-4
"""Smallest singular value of the displacement on the page, relative to the largest one."""


class Stand(NamedTuple):
    """Position of a cylinder: z along the crankshaft [m], and bank angle from upright [rad]."""

    along: float = 0.0
    bank: float = 0.0

    def turned(self, vectors: np.ndarray) -> np.ndarray:
        """Rotate vectors (n, 3) of the cylinder into the engine's axes."""
        return vectors @ about_z(self.bank).T

    def placed(self, points: np.ndarray) -> np.ndarray:
        """Move points (n, 3) of the cylinder to their position in the engine [m]."""
        return self.turned(points) + [0.0, 0.0, self.along]


def about_z(angle: float) -> np.ndarray:
    """Return the matrix of a rotation about z by an angle [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def moved(points: np.ndarray, motion: np.ndarray | None) -> np.ndarray:
    """Return points (n, 3) of a body after its motion across and along [m] and about z [rad]."""
    if motion is None:
        return points
    across, along, turn = motion
    return points @ about_z(turn).T + [across, along, 0.0]


@dataclass(frozen=True)
class Solid:
    """Surface of a body in one run.

    The position of a point is R(beta) (p + Phi q) + (across, along, 0), which the page computes
    (templates/bodies.js). Its slider multiplies Phi q, across and beta.

    Parameters
    ----------
    name : str
    points : ndarray, shape (n, 3)
        p, relative to the body's origin [m].
    triangles : ndarray of int, shape (t, 3)
    modes : ndarray, shape (n, 3, k)
        Phi, displacement by coordinate; k may be 0.
    coordinates : ndarray, shape (instants, k)
        q at the run's recorded instants.
    motion : ndarray, shape (instants, 3), or None
        across, along [m] and beta about z [rad] at these instants. None: the body is fixed, and
        cut open.
    film : (float, float) or None
        Lower and upper height of the fields around the body [m].
    stress : ndarray, shape (instants, n), or None
        Equivalent stress at the points [Pa].
    fields : dict of str to (float, float)
        Heights of each field around the body [m], by port. If empty, `film` is valid for all.
    owner : str
        Participant that the body belongs to, "" if there is only one.
    held : bool
        Whether the deflection is known. False for a flexible body whose coordinates were not
        recorded.
    stand : Stand
        Position of its cylinder. The page draws every cylinder upright.
    schematic : bool
        Whether the shape is not from a mesh. The page draws its motion at true scale.
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
        """Return its name, preceded by its owner if there is one."""
        return between.join(filter(None, (self.owner, self.name)))

    def between(self, port: str) -> tuple[float, float] | None:
        """Return the heights of a field around the body [m], None if there is none."""
        return self.fields.get(port) if self.fields else self.film

    def largest_displacement(self) -> float:
        """Return the largest |Phi q| of all points and instants [m]; 0 without modes."""
        largest = 0.0
        for q in self.coordinates if self.modes.shape[2] else ():
            largest = max(largest, float(np.linalg.norm(self.modes @ q, axis=1).max()))
        return largest


def solids_data(
    runs: list[list[Solid]], columns: Columns, fields: Sequence[str] = ()
) -> dict[str, Any]:
    """Return the solids of every run for the page's script; equal meshes are stored once.

    `fields` are the ports that the script draws.
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
    all instants, without those whose singular value is below `LEAST_SINGULAR_VALUE` of the largest
    one.
    """
    count, size = len(solid.points), solid.modes.shape[2]
    if not size:
        return solid.modes, solid.coordinates
    basis, triangle = np.linalg.qr(solid.modes.reshape(3 * count, size))
    left, values, right = np.linalg.svd(solid.coordinates @ triangle.T, full_matrices=False)
    large = values > LEAST_SINGULAR_VALUE * values[0]
    shapes = basis @ right[large].T
    largest = np.abs(shapes).max(axis=0, initial=0.0)
    return (shapes / largest).reshape(count, 3, -1), left[:, large] * values[large] * largest


def _solid(solid, meshes, columns, fields):
    modes, coordinates = principal(solid)
    texts = (
        packed_as("<f4", solid.points),
        packed_as("<u4", solid.triangles),
        # one mode after the other, numbers from -1 to 1
        packed_as("<i2", np.round(32767 * np.moveaxis(modes, 2, 0))),
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
    """Return the stress in MPa as frames of a field, with its range."""
    shown = stress * 1e-6
    return packed_frames(shown) | {
        "shape": [shown.shape[1], 1],
        "low": float(shown.min()),
        "high": float(shown.max()),
    }
