"""Contents of a reduced body's .npz file, for runs, reports, pictures and recovery."""

import zipfile
from dataclasses import dataclass, field, fields, replace
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np

from ..geometry.profile import HotShape

FARTHEST_PIN = 0.05
"""Largest distance of pin point A from the mesh's pin bores, as a share of the skirt's radius."""


def offset_faults(bore: float, radius: float, pin_offset: float) -> list[str]:
    """Return a sentence if pin point A is too far from the pin bores of a mesh.

    Parameters
    ----------
    bore, radius, pin_offset : float
        x of the bores' axis, radius of the skirt, x of A, all from the skirt's axis [m].
    """
    largest = FARTHEST_PIN * radius
    if abs(bore - pin_offset) <= largest:
        return []
    return [
        f"surface 'pin_bore': expected an axis within {1e3 * largest:.3g} mm of pin_offset = "
        f"{1e3 * pin_offset:.3g} mm, got x = {1e3 * bore:.3g} mm"
    ]


class ShellFilm(NamedTuple):
    """Film in a shell, such as the eye of the rod, or films in both bosses.

    grid : cells around and along it. length : along its axis [m]. modes : number of modes for it.
    """

    grid: tuple[int, int]
    length: float
    modes: int


@dataclass(frozen=True)
class ReducedPiston:
    """Mass properties, modes and their values on the skirt; k modes, which may be none.

    Parameters
    ----------
    mass : float
        [kg]
    S, I0, T, b, B, g, G
        Inertia in planar motion, Eq. (J7).
    omega : ndarray, shape (k,)
        Ascending angular eigenfrequencies [rad/s].
    kind : ndarray of int, shape (k,)
        Symmetry class of each mode, -1 without symmetry (`symmetry`).
    gas_force : ndarray, shape (k,)
        Modal force of a gas force of 1 N on the crown [kg^-1/2].
    radial, axial : ndarray, shape (grid points, k)
        Displacement of the skirt, outwards and along y, at the cells of the film grid [kg^-1/2].
    radius : float
        Radius of the skirt [m].
    skirt_lower, skirt_upper : float
        Edges of the skirt above A [m].
    pin_offset : float
        x of A from the skirt's axis [m].
    """

    mass: float
    S: np.ndarray
    I0: float
    T: np.ndarray
    b: np.ndarray
    B: np.ndarray
    g: np.ndarray
    G: np.ndarray
    omega: np.ndarray
    kind: np.ndarray
    gas_force: np.ndarray
    radial: np.ndarray
    axial: np.ndarray
    radius: float
    skirt_lower: float
    skirt_upper: float
    pin_offset: float

    def about(self, pin_offset: float) -> "ReducedPiston":
        """Return the same piston with pin point A at another x, the pin bores where they are.

        Eq. (J45):  with d the change of pin_offset and T_x, T_y the rows of T
                    S' = S - m d e_x,   I0' = I0 - 2 d S_x + m d^2,   b' = b - d T_x,
                    g' = g - d T_y

        This is exact for mass and modes of the given mesh. The approximation is the mesh: its
        bosses and pin bores stay where they are while the rod acts at A.

        Parameters
        ----------
        pin_offset : float
            x of A from the skirt's axis, positive towards the thrust side [m].
        """
        d = pin_offset - self.pin_offset
        S_x, S_y = self.S
        T_x, T_y = self.T
        # Eq. (J45)
        return replace(
            self,
            S=np.array([S_x - self.mass * d, S_y]),
            I0=self.I0 - 2.0 * d * S_x + self.mass * d**2,
            b=self.b - d * T_x,
            g=self.g - d * T_y,
            pin_offset=pin_offset,
        )


@dataclass(frozen=True)
class ReducedBlock:
    """Modes and their values on a table of the bore; k modes, which may be none.

    Parameters
    ----------
    omega, kind
        As of `ReducedPiston`.
    radial, axial : ndarray, shape (angles, stations, k)
        Displacement of the bore, outwards and along y [kg^-1/2].
    heights : ndarray, shape (stations,)
        Above the crank axis, equally spaced [m].
    radius : float
        Radius of the bore [m].
    """

    omega: np.ndarray
    kind: np.ndarray
    radial: np.ndarray
    axial: np.ndarray
    heights: np.ndarray
    radius: float


@dataclass(frozen=True)
class ReducedMonoblock:
    """Block of n cylinders in line, free in space, with k modes that have no momentum.

    Its rigid motion is about O, the middle of the crank axis.

    Parameters
    ----------
    omega : ndarray, shape (k,)
        Ascending angular eigenfrequencies [rad/s].
    radial : ndarray, shape (n, angles, stations, k)
        Displacement of each bore outwards from its axis [kg^-1/2].
    deck : ndarray, shape (n, k)
        Displacement of the deck at each cylinder along y [kg^-1/2].
    bearing : ndarray, shape (n, 2, k)
        Displacement of the crank's bearings at each cylinder along x and y [kg^-1/2].
    mount : ndarray, shape (m, 3, k)
        [kg^-1/2]
    mount_place : ndarray, shape (m, 3)
        Position from O [m].
    cylinder_z : ndarray, shape (n,)
        [m]
    rigid_mass : ndarray, shape (6, 6)
        Eq. (J8), about O [kg], [kg m], [kg m2].
    heights : ndarray, shape (stations,)
        Above the crank axis [m].
    radius : float
        Radius of the bores [m].
    """

    omega: np.ndarray
    radial: np.ndarray
    deck: np.ndarray
    bearing: np.ndarray
    mount: np.ndarray
    mount_place: np.ndarray
    cylinder_z: np.ndarray
    rigid_mass: np.ndarray
    heights: np.ndarray
    radius: float


@dataclass(frozen=True)
class ReducedBosses:
    """Values of a piston's k modes in its two pin bosses, that at z < 0 first.

    The grids of the films have (c, a) cells each.

    Parameters
    ----------
    boss_outward, boss_onward : ndarray, shape (2, c, a, k)
        Displacement of the shell away from the pin's axis, and around it towards ascending i
        [kg^-1/2].
    boss_stations : ndarray, shape (2, a)
        z of the grid's rows [m].
    boss_radius : float
        Mean radius of the bores [m].
    """

    boss_outward: np.ndarray
    boss_onward: np.ndarray
    boss_stations: np.ndarray
    boss_radius: float


@dataclass(frozen=True)
class ReducedShell:
    """Values of a shell's k modes on the (c, a) cells of its film.

    Parameters
    ----------
    omega : ndarray, shape (k,)
        Ascending angular eigenfrequencies of the shell, fixed where it is held [rad/s].
    outward, onward : ndarray, shape (c, a, k)
        Displacement of the bore away from its axis, and around it towards ascending i [kg^-1/2].
    radius : float
        Radius of the bore [m].
    """

    omega: np.ndarray
    outward: np.ndarray
    onward: np.ndarray
    radius: float


class ShellKind(NamedTuple):
    """Names of a shell, and where its bore bears.

    Parameters
    ----------
    title : str
        In messages.
    bore, fixed : str
        Surfaces of the mesh: the bore about z, and the surface that another body holds.
    length : str
        Option with the length of its film.
    hangs : bool
        Whether all of `fixed` is below the bore, as the cut of a shank.
    upright : bool
        Whether the film mainly bears along y.
    samples : int
        Odd number of points around and along each cell at which its displacement is read.
    """

    title: str
    bore: str = "bore"
    fixed: str = "held"
    length: str = "length"
    hangs: bool = False
    upright: bool = False
    samples: int = 5


SMALL_END = ShellKind(
    title="small end",
    bore="eye",
    fixed="cut",
    length="small_end_length",
    hangs=True,
    upright=True,
    samples=1,
)


@dataclass(frozen=True)
class Anatomy:
    """Mesh and mode shapes of a reduced body, for pictures and recovery.

    Neither FMUs nor shipped files contain them.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Nodes from the body's origin [m].
    tets : ndarray of int, shape (e, 10)
        None (e = 0) for a body of matrices.
    skin : ndarray of int, shape (t, 6 or 3)
        Outer faces.
    shapes : ndarray, shape (n, 3, k)
        Modes [kg^-1/2].
    young, poisson : float or ndarray, shape (e,)
        [Pa], [-], of the body or of each element; nan for a body of matrices.
    """

    points: np.ndarray
    tets: np.ndarray
    skin: np.ndarray
    shapes: np.ndarray
    young: float | np.ndarray
    poisson: float | np.ndarray


@dataclass(frozen=True)
class MeshProperties:
    """Properties of the full model of a reduced body, for builds and reports. No FMU contains them.

    Eq. (J8):  rigid_mass = R^T M R      R the six rigid motions about the body's origin

    Parameters
    ----------
    rigid_mass : ndarray, shape (6, 6)
        [kg], [kg m], [kg m2]
    angles : int
        Number of angles of the film grid.
    skirt : ndarray of bool, shape (angles, rows)
        Which cells of the film grid have the skirt under them; empty for a block.
    seconds : float
        Time of the reduction [s].
    peak_memory : int
        Peak memory of the process [bytes].
    """

    rigid_mass: np.ndarray
    angles: int
    skirt: np.ndarray
    seconds: float = 0.0
    peak_memory: int = 0


@dataclass(frozen=True)
class MissingShapes:
    """Static shapes that the modes of a body leave out, for `truncation`. No FMU contains them.

    Parameters
    ----------
    left_radial, left_axial : ndarray of float32, shape (points, n)
        R X and A X of Eq. (J16): outward radial and axial displacement at the points of the film
        surface, 0 where it has no film [m/J^0.5].
    smooth_error : float
        Largest missing share of the deflection under a smooth pressure patch, Eq. (J33) [-].
    edge_errors : ndarray, shape (2,)
        The same under a narrow patch at the lower and at the upper edge of the surface, Eq. (J46)
        [-].
    """

    left_radial: np.ndarray
    left_axial: np.ndarray
    smooth_error: float = np.nan
    edge_errors: np.ndarray = field(default_factory=lambda: np.full(2, np.nan))

    def errors_in_words(self) -> str:
        """Return both errors as a sentence without a subject."""
        lower, upper = self.edge_errors
        return (
            f"miss up to {100 * self.smooth_error:.2g} % of the deflection under a smooth "
            f"pressure, {100 * lower:.2g} % under a narrow patch at the lower edge and "
            f"{100 * upper:.2g} % at the upper edge"
        )


def no_modes(*points: int) -> dict[str, np.ndarray]:
    """Return the fields of a body without modes, on a surface of these numbers of points."""
    none, table = np.zeros(0), np.zeros((*points, 0))
    return dict(omega=none, kind=none.astype(int), radial=table, axial=table)


def no_modes_in_motion(points: int) -> dict[str, np.ndarray]:
    """Return the fields of a piston without modes, on a skirt of this number of points."""
    none, square = np.zeros(0), np.zeros((0, 0))
    moving = dict(T=np.zeros((2, 0)), b=none, B=square, g=none, G=square, gas_force=none)
    return moving | no_modes(points)


ReducedBody = ReducedPiston | ReducedBlock


AnyPart = (
    ReducedBody
    | ReducedMonoblock
    | ReducedBosses
    | ReducedShell
    | Anatomy
    | MeshProperties
    | MissingShapes
    | HotShape
)
"""Part of a reduced body's file."""
Part = TypeVar("Part", bound=AnyPart)


def mode_classes(body: ReducedBody) -> np.ndarray | None:
    """Return the symmetry classes of a body's modes, None without two planes of symmetry."""
    known = body.kind.size == body.omega.size and body.kind.min(initial=0) >= 0
    return body.kind if known else None


def load(part: type[Part], path: Path) -> Part:
    """Read one part of a reduced body, whose arrays are read-only.

    A part that was read before, and whose file is the same, is returned again: a run asks for each
    about four times, and a second is spent on decompression.

    Parameters
    ----------
    part : type
        ReducedPiston, ReducedBlock, ReducedMonoblock, ReducedBosses, ReducedShell, Anatomy,
        MeshProperties, MissingShapes or HotShape.
    path : Path
        .npz

    Raises
    ------
    ValueError
        If the file lacks a field.
    """
    if not zipfile.is_zipfile(path):
        raise ValueError(f"reduced: expected an .npz file, got {path.name}")
    state = path.stat()
    return _load(part, path.resolve(), state.st_mtime_ns, state.st_size)


@lru_cache(maxsize=16)
def _load(part: Any, path: Path, time: int, size: int) -> Any:
    """Return `load`; time [ns] and size are those of the file."""
    names = [one.name for one in fields(part)]
    with np.load(path) as stored:
        missing = [name for name in names if name not in stored]
        if missing:
            raise ValueError(f"reduced: expected {', '.join(missing)} in {path.name}, got nothing")
        arrays = {name: stored[name] for name in names}
    for array in arrays.values():
        array.flags.writeable = False
    return part(**{name: v if v.ndim else v.item() for name, v in arrays.items()})


def save(path: Path, *parts: AnyPart) -> None:
    """Write parts of a reduced body into one .npz file."""
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_suffix(".partial.npz")
    np.savez(partial, **{name: value for part in parts for name, value in vars(part).items()})
    partial.replace(path)
