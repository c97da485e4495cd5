"""Pin bosses of a piston as film surfaces: how the mesh is read on grids about the pin's axis, and
what the bosses' films ask of the modes.
"""

from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from ..finite_elements.element import Sparse
from ..finite_elements.mesh import Mesh, MeshFault
from ..geometry.pin import shell_angles
from .bases import Elastic, of_unit_energy, pressure_modes
from .geometry import OUT_OF_ROUND
from .interpolation import covered, interpolation
from .reduced_body import BossFilms

SURFACE = "pin_bore"
"""Surface of the mesh that both bosses are."""

SIDES = {"boss_left": -1.0, "boss_right": 1.0}
"""Where each boss lies along z."""


class ShellReading(NamedTuple):
    """Matrices (grid points, 3 n) that read how a shell about the pin's axis moves outwards and
    around it, and z of the grid's rows, (a,) [m].

    Eq. (I11):  u_e = u_x cos a + u_y sin a,   u_t = u_y cos a - u_x sin a
    """

    outward: Sparse
    onward: Sparse
    stations: np.ndarray


class Shells(NamedTuple):
    """Readings of shells about the pin's axis, both bosses, that at z < 0 first, or the eye; their
    mean radius [m].
    """

    sides: tuple[ShellReading, ...]
    radius: float

    def outward(self) -> Sparse:
        """Outward readings of all, one below the other."""
        return sp.vstack([side.outward for side in self.sides], format="csr")


def boss_readings(mesh: Mesh, position: np.ndarray, films: BossFilms) -> Shells:
    """Both bosses of a mesh, read where their films lie: from where a boss begins, seen from z = 0,
    over the films' length.

    Parameters
    ----------
    mesh : Mesh
        With a surface `pin_bore`.
    position : ndarray, shape (n, 3)
        Its nodes from pin point A, the pin's axis along z [m].
    films : BossFilms

    Raises
    ------
    MeshFault
        Where there is no boss on a side, or its bore is not round, or ends within the film.
    """
    faces = mesh.faces[SURFACE]
    middle = position[faces[:, :3], 2].mean(axis=1)
    radius = float(np.hypot(*position[mesh.nodes(SURFACE)][:, :2].T).mean())
    faults = []
    sides = []
    for name, sign in SIDES.items():
        own = faces[sign * middle > 0]
        if not len(own):
            faults.append(
                f"surface '{SURFACE}': expected faces at z {'>' if sign > 0 else '<'} 0, got none"
            )
            continue
        found, fault = _read(position, own, sign, radius, films)
        if fault:
            faults.append(f"surface '{SURFACE}', {name}: {fault}")
        sides.append(found)
    if faults:
        raise MeshFault(faults)
    return Shells(tuple(sides), radius)


def _read(position, faces, sign, radius, films):
    """A boss's reading, and a sentence if its film does not lie on it."""
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
    """A sentence if a bore's nodes lie beside a cylinder about the pin's axis."""
    x, y, _ = position[np.unique(faces)].T
    scatter = float(np.abs(np.hypot(x, y) - radius).max())
    if scatter <= OUT_OF_ROUND * radius:
        return ""
    return f"nodes lie up to {1e3 * scatter:.3g} mm beside a cylinder about the pin's axis"


def without_shell(
    position: np.ndarray, faces: np.ndarray, radius: float, around: int, stations: np.ndarray
) -> int:
    """How many cells of a film have no bore under them; arguments as of `shell_reading`."""
    there = covered(_about_y(position), faces, shell_angles(around), stations, radius)
    return int(np.count_nonzero(~there))


def _about_y(position):
    """About the pin's axis as the skirt lies about the cylinder's: theta from +z towards +x."""
    return position[:, [1, 2, 0]]


def shell_reading(
    position: np.ndarray, faces: np.ndarray, radius: float, around: int, stations: np.ndarray
) -> ShellReading:
    """A bore about z, read at the cells of a film (Eq. (I11)).

    Parameters
    ----------
    position : ndarray, shape (n, 3)
        Nodes, z the pin's axis [m].
    faces : ndarray of int, shape (t, 3 or 6)
    radius : float
        Of the bore [m].
    around : int
        Cells around.
    stations : ndarray, shape (a,)
        z of the rows [m].
    """
    angle = shell_angles(around)
    at = interpolation(_about_y(position), faces, angle, stations, radius)
    a = np.repeat(angle, len(stations))
    identity = sp.identity(len(position), format="csr")
    x_of, y_of = (sp.kron(identity, row[None, :], format="csr") for row in np.eye(3)[:2])
    cosine = sp.diags(np.cos(a))
    sine = sp.diags(np.sin(a))
    # Eq. (I11)
    outward = cosine @ at @ x_of + sine @ at @ y_of
    onward = cosine @ at @ y_of - sine @ at @ x_of
    return ShellReading(outward.tocsr(), onward.tocsr(), stations)


def with_boss_modes(
    elastic: Elastic, bosses: Shells, grid: tuple[int, int], shapes: np.ndarray, modes: int
) -> np.ndarray:
    """Shapes of a basis and, after them, those under the smooth pressures to which all shells
    yield most beside what these answer: Eq. (J2) with D S in place of D, `modes` in all.

    Eq. (J24):  D = 0.1 + sin^2 a,   S: normal distribution, 10 deg around and a quarter of the
                film's length along, rows adding up to 1

    A single cell's force dents the bore, films press over tens of degrees. The error of the
    deflection under half a turn of even pressure and under a cosine over +-30 deg that falls along
    the pin, 60 of them: with S 1.6 and 1.3 %, without 12 and 1.6 %.

    Parameters
    ----------
    elastic : Elastic
    bosses : Shells
        Both bosses, or the eye alone.
    grid : (int, int)
        Cells around and along each.
    shapes : ndarray, shape (free, k)
        k < modes.
    modes : int
    """
    psi = of_unit_energy(elastic, shapes)
    around, along = grid
    one = np.kron(_smoothing(around, SPREAD_AROUND, True), _smoothing(along, SPREAD_ALONG, False))
    smooth = sp.block_diag([one] * len(bosses.sides), format="csr")
    reading = smooth @ bosses.outward()[:, elastic.free]
    weight = np.repeat(0.1 + np.sin(shell_angles(around)) ** 2, along)
    weight = np.tile(weight, len(bosses.sides))  # Eq. (J24)
    return pressure_modes(elastic, reading.tocsr(), weight, modes, psi, psi)


SPREAD_AROUND, SPREAD_ALONG = 1 / 36, 1 / 4
"""Standard deviations of Eq. (J24), of a turn and of the film's length."""


def _smoothing(cells, spread, ring):
    """Matrix (cells, cells) that spreads each value over its neighbours."""
    apart = np.arange(cells)[:, None] - np.arange(cells)
    if ring:
        apart = (apart + cells // 2) % cells - cells // 2
    weight = np.exp(-((apart / (spread * cells)) ** 2) / 2)
    return weight / weight.sum(axis=1, keepdims=True)
