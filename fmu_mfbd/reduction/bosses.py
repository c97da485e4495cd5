"""Pin bosses of a piston as film surfaces: readings of the mesh on their grids, and modes."""

from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from ..finite_elements.element import Sparse
from ..finite_elements.mesh import Mesh, MeshFault
from ..geometry.pin import shell_angles
from .bases import Elastic, of_unit_energy, pressure_modes
from .geometry import OUT_OF_ROUND
from .interpolation import covered, directed, interpolation
from .reduced_body import ShellFilm

SURFACE = "pin_bore"
"""Surface of the mesh that contains both bosses."""

SIDES = {"boss_left": -1.0, "boss_right": 1.0}
"""Side of each boss along z."""


class ShellReading(NamedTuple):
    """Matrices (grid points, 3 n) for the displacements of a shell, and z of its rows, (a,) [m].

    Eq. (I11):  u_e = u_x cos a + u_y sin a,   u_t = u_y cos a - u_x sin a

    `outward` reads u_e away from the pin's axis, and `onward` reads u_t around it.
    """

    outward: Sparse
    onward: Sparse
    stations: np.ndarray


class Shells(NamedTuple):
    """Readings of both bosses, that at z < 0 first, or of the eye, and mean radius [m]."""

    sides: tuple[ShellReading, ...]
    radius: float

    def outward(self) -> Sparse:
        """Return the outward readings of all shells in one matrix."""
        return sp.vstack([side.outward for side in self.sides], format="csr")


def boss_readings(mesh: Mesh, position: np.ndarray, films: ShellFilm) -> Shells:
    """Return the readings of both bosses of a mesh on the grids of their films.

    A film begins where its boss begins, seen from z = 0.

    Parameters
    ----------
    mesh : Mesh
        With a surface `pin_bore`.
    position : ndarray, shape (n, 3)
        Its nodes from pin point A, with the pin's axis along z [m].
    films : ShellFilm

    Raises
    ------
    MeshFault
        If there is no boss on a side, or its bore is not round, or ends within the film.
    """
    radius = float(np.hypot(*position[mesh.nodes(SURFACE)][:, :2].T).mean())
    faults = []
    sides = []
    for name, own in faces_of_boss(mesh, position).items():
        side, fault = _read(position, own, SIDES[name], radius, films)
        if fault:
            faults.append(f"surface '{SURFACE}', {name}: {fault}")
        sides.append(side)
    if faults:
        raise MeshFault(faults)
    return Shells(tuple(sides), radius)


def faces_of_boss(mesh: Mesh, position: np.ndarray) -> dict[str, np.ndarray]:
    """Return the faces of each boss; arguments and error are those of `boss_readings`."""
    faces = mesh.faces[SURFACE]
    middle = position[faces[:, :3], 2].mean(axis=1)
    bosses = {name: faces[sign * middle > 0] for name, sign in SIDES.items()}
    missing = ["<" if SIDES[name] < 0 else ">" for name, own in bosses.items() if not len(own)]
    if missing:
        raise MeshFault(
            [f"surface '{SURFACE}': expected faces at z {side} 0, got none" for side in missing]
        )
    return bosses


def _read(position, faces, sign, radius, films):
    """Return the reading of a boss, and a sentence if its film is not completely on it."""
    z = position[np.unique(faces), 2]
    around, along = films.grid
    begin = float(np.abs(z).min())
    reach = float(np.abs(z).max())
    cell = films.length / along
    stations = sign * (begin + (np.arange(along) + 0.5) * cell)
    stations = np.sort(stations)
    fault = out_of_round(position, faces, radius)
    bare = without_shell(position, faces, radius, around, stations)
    if bare and not fault:
        fault = (
            f"{bare} of {around * along} cells of its film have no bore under "
            f"them; it reaches from {1e3 * begin:.4g} to {1e3 * reach:.4g} mm beside z = 0, the "
            f"film of boss_length = {1e3 * films.length:.4g} mm begins where it does"
        )
    return shell_reading(position, faces, radius, around, stations), fault


def out_of_round(position: np.ndarray, faces: np.ndarray, radius: float) -> str:
    """Return a sentence if a bore's nodes are not on a cylinder about the pin's axis."""
    x, y, _ = position[np.unique(faces)].T
    scatter = float(np.abs(np.hypot(x, y) - radius).max())
    if scatter <= OUT_OF_ROUND * radius:
        return ""
    return f"nodes lie up to {1e3 * scatter:.3g} mm beside a cylinder about the pin's axis"


def without_shell(
    position: np.ndarray, faces: np.ndarray, radius: float, around: int, stations: np.ndarray
) -> int:
    """Return how many cells of a film have no bore under them; arguments as for `shell_reading`."""
    has_bore = covered(about_y(position), faces, shell_angles(around), stations, radius)
    return int(np.count_nonzero(~has_bore))


def about_y(position):
    """Return positions in axes with the pin along y, as the skirt's axis: theta from +z to +x."""
    return position[:, [1, 2, 0]]


def shell_reading(
    position: np.ndarray, faces: np.ndarray, radius: float, around: int, stations: np.ndarray
) -> ShellReading:
    """Return the reading of a bore about z at the cells of a film, Eq. (I11).

    Parameters
    ----------
    position : ndarray, shape (n, 3)
        Nodes, with z along the pin's axis [m].
    faces : ndarray of int, shape (t, 3 or 6)
    radius : float
        Radius of the bore [m].
    around : int
        Number of cells around.
    stations : ndarray, shape (a,)
        z of the rows [m].
    """
    angle = shell_angles(around)
    at = interpolation(about_y(position), faces, angle, stations, radius)
    a = np.repeat(angle, len(stations))
    cosine, sine, zero = np.cos(a), np.sin(a), np.zeros_like(a)
    outward = directed(at, [cosine, sine, zero])  # Eq. (I11)
    return ShellReading(outward, directed(at, [-sine, cosine, zero]), stations)


def cell_means(reading: ShellReading, grid: tuple[int, int], samples: int) -> ShellReading:
    """Return the mean displacements of cells from those at several points of each.

    A force on a cell is then a pressure that is constant over the cell. A force at a point of a
    thin liner would make a dent that depends on the position of the point in its element.

    Parameters
    ----------
    reading : ShellReading
        On a grid with `samples` times as many cells around and along.
    grid : (int, int)
        Cells around and along.
    samples : int
        Odd, so that a point is in the centre of each cell.
    """
    around, along = grid
    each = np.full((1, samples), 1 / samples)
    ring = np.roll(np.kron(np.eye(around), each), -(samples // 2), axis=1)
    mean = sp.kron(ring, np.kron(np.eye(along), each), format="csr")
    stations = reading.stations.reshape(along, samples).mean(axis=1)
    return ShellReading(mean @ reading.outward, mean @ reading.onward, stations)


def with_pressure_modes(
    elastic: Elastic,
    bosses: Shells,
    grid: tuple[int, int],
    shapes: np.ndarray,
    modes: int,
    upright: bool = True,
) -> np.ndarray:
    """Return shapes of a basis, and shapes under the smooth pressures of the largest compliance.

    The additional shapes are those of Eq. (J2) with D S instead of D.

    Eq. (J24):  D = 0.1 + sin^2 a,   S: normal distribution, 10 deg around and a quarter of the
                film's length along, sum of a row 1

    S excludes the local dents by the force on a single cell, because films extend over tens of
    degrees.

    Parameters
    ----------
    elastic : Elastic
    bosses : Shells
        Both bosses, or one shell.
    grid : (int, int)
        Cells around and along each shell.
    shapes : ndarray, shape (free, k)
        Shapes of the basis, k < modes.
    modes : int
        Number of all shapes.
    upright : bool
        Whether the films mainly bear along y. If not, D is 1.
    """
    psi = of_unit_energy(elastic, shapes)
    around, along = grid
    one = np.kron(_smoothing(around, SPREAD_AROUND, True), _smoothing(along, SPREAD_ALONG, False))
    smooth = sp.block_diag([one] * len(bosses.sides), format="csr")
    reading = smooth @ bosses.outward()[:, elastic.free]
    each = 0.1 + np.sin(shell_angles(around)) ** 2 if upright else np.ones(around)
    weight = np.repeat(each, along)
    weight = np.tile(weight, len(bosses.sides))  # Eq. (J24)
    return pressure_modes(elastic, reading.tocsr(), weight, modes, psi, psi)


SPREAD_AROUND, SPREAD_ALONG = 1 / 36, 1 / 4
"""Standard deviations of Eq. (J24) as fractions of a revolution and of the film's length."""


def _smoothing(cells, spread, ring):
    """Return the matrix (cells, cells) that distributes each value over its neighbours."""
    distance = np.arange(cells)[:, None] - np.arange(cells)
    if ring:
        distance = (distance + cells // 2) % cells - cells // 2
    weight = np.exp(-((distance / (spread * cells)) ** 2) / 2)
    return weight / weight.sum(axis=1, keepdims=True)
