"""Commands `reduce` and `results recover`, also as a library.

They write everything about reduced bodies into a folder, and recover displacement and stress on
their meshes.
"""

import csv
import shutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..master.fmi.errors import BadInput
from .build import reduced_bodies
from .finite_elements.element import corner_stress, mass_properties, nodal_stress, von_mises
from .options import Bodies, read_options
from .reduction.mode_tables import ModeRow, StressPeak, mode_table, write_modes
from .reduction.mode_tables import recover as recovered
from .reduction.reduce import Reduced
from .reduction.reduced_body import (
    Anatomy,
    MeshProperties,
    MissingShapes,
    ReducedBlock,
    ReducedPiston,
    load,
)

Say = Callable[[str], None]

AROUND = 96
ALONG = 32
"""Faces of a drawn cylinder."""


@dataclass(frozen=True, repr=False)
class BodyReport:
    """Report on a reduced body.

    Parameters
    ----------
    name : str
        piston or block.
    files : list of Path
        Written.
    nodes, elements, degrees_of_freedom : int
        Numbers of the full model.
    mass : float
        [kg]
    centre : ndarray, shape (3,)
        Centre of mass, from the body's origin [m].
    inertia : ndarray, shape (3, 3)
        About it [kg m2].
    seconds : float
        The reduction took [s].
    peak_memory : int
        Peak memory of the whole process [bytes].
    modes : list of ModeRow
    errors : str
        Missing share of the deflection under smooth and narrow pressures, as a sentence without a
        subject; empty for a rigid body, and for a file of an earlier version.
    """

    name: str
    files: list[Path]
    nodes: int
    elements: int
    degrees_of_freedom: int
    mass: float
    centre: np.ndarray
    inertia: np.ndarray
    seconds: float
    peak_memory: int
    modes: list[ModeRow]
    errors: str = ""

    def __repr__(self) -> str:
        return f"<BodyReport {self.name}: {self.mass:.4g} kg, {len(self.modes)} modes>"


@dataclass(frozen=True)
class Recovery:
    """Recovered fields of a body, and the file that contains them.

    Parameters
    ----------
    name : str
        piston or block.
    file : Path
    largest_displacement : float
        [m]
    largest_stress : StressPeak or None
        von Mises; None for a body of matrices.
    """

    name: str
    file: Path
    largest_displacement: float
    largest_stress: StressPeak | None


@dataclass(frozen=True)
class Skin:
    """Outer surface of a reduced body, by the corners of its faces.

    Parameters
    ----------
    name : str
        piston or block.
    points : ndarray, shape (n, 3)
        From the body's origin: pin point A, or the crank's axis [m].
    triangles : ndarray of int, shape (t, 3)
    modes : ndarray, shape (n, 3, k)
        Mode shapes there [kg^-1/2].
    skirt : (float, float) or None
        Heights of the skirt's edges above A [m]; None of a block.
    stress : ndarray, shape (n, 6, k), or None
        S, stress there by modal coordinate [Pa kg^-1/2 m^-1]; None of a block, and of a body of
        matrices or without modes.
    """

    name: str
    points: np.ndarray
    triangles: np.ndarray
    modes: np.ndarray
    skirt: tuple[float, float] | None
    stress: np.ndarray | None = None

    def von_mises(self, coordinates: np.ndarray) -> np.ndarray | None:
        """Return the equivalent stress at the points [Pa], (instants, n); None without stress.

        The modal coordinates are (instants, k).

        Eq. (J23):  sigma = S q,   then Eq. (M5); that of `recover`, as stress is linear in q
        """
        if self.stress is None:
            return None
        return np.stack([von_mises(self.stress @ q) for q in coordinates])  # Eq. (J23)


def skins(options: dict[str, Any], folder: Path, progress: Say = print) -> list[Skin]:
    """Return the surfaces of the bodies with their modes, for drawings.

    A body of a data sheet is the cylinder that is known of it: the skirt, closed at its top; the
    bore.

    Parameters, errors: as of `reduce`.
    """
    files = reduced_bodies(options, folder, progress, shapes=True)
    sheets = vars(read_options(options, folder, Bodies))
    return [
        _cylinder(name, file) if sheets[name].rigid else _skin(name, _whole(name, file))
        for name, file in files.items()
    ]


def _cylinder(name: str, file: Path) -> Skin:
    if name == "piston":
        body = load(ReducedPiston, file)
        return cylinder(name, body.radius, (body.skirt_lower, body.skirt_upper), top=True)
    body = load(ReducedBlock, file)
    low, *_, high = body.heights
    return cylinder(name, body.radius, (low, high), top=False)


def cylinder(name: str, radius: float, ends: tuple[float, float], top: bool) -> Skin:
    """Return a cylinder about the y axis, without modes.

    Parameters
    ----------
    name : str
    radius : float
        [m]
    ends : (float, float)
        Heights of its lower and upper edge [m].
    top : bool
        A flat one at the upper edge; it is a piston's skirt then.
    """
    angle = 2 * np.pi * np.arange(AROUND) / AROUND
    heights = np.linspace(*ends, ALONG + 1)
    ring = np.column_stack([radius * np.sin(angle), np.zeros(AROUND), radius * np.cos(angle)])
    points = [ring + [0.0, height, 0.0] for height in heights]
    here = np.arange(AROUND)
    following = np.roll(here, -1)
    quads = [(k * AROUND, (k + 1) * AROUND) for k in range(ALONG)]
    triangles = [
        np.column_stack(corners)
        for low, high in quads
        for corners in (
            (low + here, low + following, high + following),
            (low + here, high + following, high + here),
        )
    ]
    if top:
        last = ALONG * AROUND
        centre = np.full(AROUND, last + AROUND)
        triangles.append(np.column_stack([last + here, last + following, centre]))
        points.append(np.array([[0.0, ends[1], 0.0]]))
    whole = np.concatenate(points)
    no_modes = np.zeros((len(whole), 3, 0))
    return Skin(name, whole, np.concatenate(triangles), no_modes, ends if top else None)


def _skin(name, whole):
    body, anatomy = whole.body, whole.anatomy
    corners, triangles = np.unique(anatomy.skin[:, :3], return_inverse=True)
    skirt = (body.skirt_lower, body.skirt_upper) if isinstance(body, ReducedPiston) else None
    return Skin(
        name=name,
        points=anatomy.points[corners],
        triangles=triangles.reshape(-1, 3),
        modes=anatomy.shapes[corners],
        skirt=skirt,
        stress=_stress_at(anatomy, corners) if skirt else None,
    )


def _stress_at(anatomy: Anatomy, nodes: np.ndarray) -> np.ndarray | None:
    """Return the stress at some nodes by modal coordinate, from the elements around them."""
    if not (len(anatomy.tets) and np.isfinite(anatomy.young).all() and anatomy.shapes.shape[2]):
        return None
    rows = np.isin(anatomy.tets, nodes).any(axis=1)
    young, poisson = (
        one[rows] if isinstance(one, np.ndarray) and one.ndim else one
        for one in (anatomy.young, anatomy.poisson)
    )
    used, tets = np.unique(anatomy.tets[rows], return_inverse=True)
    tets = tets.reshape(-1, anatomy.tets.shape[1])
    stress = corner_stress(anatomy.points[used], tets, anatomy.shapes[used], young, poisson)
    return nodal_stress(tets, stress, young)[np.searchsorted(used, nodes)]


def reduce(
    options: dict[str, Any], folder: Path, output: Path, progress: Say = print
) -> list[BodyReport]:
    """Reduce the bodies of a build table, or find them in the cache, and write their data.

    Into `output`, for each body: `NAME.npz`, which a case file may name as `reduced`;
    `NAME-modes.csv`, the table of modes; `NAME-modes.vtu`, all mode shapes; `NAME-modes.png`, the
    twelve with the largest share in film thickness; of a piston `piston-skirt.csv`, where the film
    grid has the skirt under it (1) and where not (0), and `piston-skirt.png`, the same developed.

    Parameters
    ----------
    options : dict
        As in a case's `[participants.X.build]`, units as text; piston or block may be left out.
    folder : Path
        Folder in which relative paths start.
    output : Path
    progress : callable
        Takes a sentence now and then.

    Raises
    ------
    BadInput
        Every fault of the table, then of meshes and matrices.
    """
    bodies = _flexible(options, folder, progress)
    return [_written(name, path, Path(output)) for name, path in bodies.items()]


def recover(
    options: dict[str, Any],
    folder: Path,
    modal_coordinate: np.ndarray,
    path: Path,
    progress: Say = print,
) -> list[Recovery]:
    """Write displacement and stress of the bodies at an instant, as VTU files on their meshes.

    Parameters
    ----------
    options, folder, progress
        As for `reduce`.
    modal_coordinate : ndarray, shape (k,)
        Modal coordinates of piston, then block [kg^1/2 m], as the FMU's output of that name.
    path : Path
        The files' names begin with it.

    Raises
    ------
    BadInput
        As `reduce`, and if the bodies have other numbers of modes.
    """
    files = _flexible(options, folder, progress)
    bodies = {name: _whole(name, file) for name, file in files.items()}
    modes = [len(whole.body.omega) for whole in bodies.values()]
    if sum(modes) != len(modal_coordinate):
        raise BadInput(
            f"modal_coordinate: expected {' + '.join(map(str, modes))} values, one per mode, "
            f"got {len(modal_coordinate)}"
        )
    path.parent.mkdir(parents=True, exist_ok=True)
    out = []
    parts = np.split(np.asarray(modal_coordinate), np.cumsum(modes)[:-1])
    for (name, whole), part in zip(bodies.items(), parts):
        file = path.with_name(f"{path.name}-{name}.vtu")
        fields = recovered(whole.anatomy, part, file)
        displacement = float(np.linalg.norm(fields.displacement, axis=1).max())
        out.append(Recovery(name, file, displacement, fields.peak))
    return out


def _flexible(options: dict[str, Any], folder: Path, progress: Say) -> dict[str, Path]:
    """Return the reduced bodies except data sheets, which have neither mesh nor modes."""
    files = reduced_bodies(options, folder, progress, shapes=True)
    for name, body in vars(read_options(options, folder, Bodies)).items():
        if name in files and body.rigid:
            progress(f"{name}: rigid, of a data sheet; there is nothing to reduce or to recover")
            del files[name]
    return files


def _written(name: str, path: Path, output: Path) -> BodyReport:
    """Write the files of one body, and return its remarks."""
    # slow to import, and runs ask this module too
    from .reduction.mode_pictures import draw_modes, draw_skirt

    body, anatomy, properties, *_ = _whole(name, path)
    reduced = output / f"{name}.npz"
    table_file = output / f"{name}-modes.csv"
    shapes_file = output / f"{name}-modes.vtu"
    picture = output / f"{name}-modes.png"
    output.mkdir(parents=True, exist_ok=True)
    if path != reduced.resolve():
        shutil.copyfile(path, reduced)
    table = mode_table(body, properties.angles)
    _write_table(table, table_file)
    if table:
        write_modes(anatomy, shapes_file)
        draw_modes(anatomy, table, picture)
    mask_file = output / f"{name}-skirt.csv"
    developed = output / f"{name}-skirt.png"
    if properties.skirt.size:
        np.savetxt(mask_file, properties.skirt, "%d", ",")
        draw_skirt(properties.skirt, developed)
    mass, centre, inertia = mass_properties(properties.rigid_mass)
    files = [reduced, table_file, shapes_file, picture, mask_file, developed]
    return BodyReport(
        name=name,
        files=[file for file in files if file.exists()],
        nodes=len(anatomy.points),
        elements=len(anatomy.tets),
        degrees_of_freedom=3 * len(anatomy.points),
        mass=mass,
        centre=centre,
        inertia=inertia,
        seconds=properties.seconds,
        peak_memory=properties.peak_memory,
        modes=table,
        errors=_errors(path) if table else "",
    )


def _errors(path: Path) -> str:
    """Return the errors of the modes in words; empty for a file of an earlier version."""
    try:
        return load(MissingShapes, path).errors_in_words()
    except ValueError:
        return ""


def _write_table(table: Sequence[ModeRow], path: Path) -> None:
    with open(path, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["mode", "frequency [Hz]", "modal_mass [kg]", "film_share [-]", "class"])
        for row in table:
            writer.writerow(
                [row.number, row.frequency, row.modal_mass, row.film_share, row.kind_in_words]
            )


def _whole(name: str, path: Path) -> Reduced:
    """Read a reduced body with its mesh and mode shapes."""
    body = load(ReducedPiston if name == "piston" else ReducedBlock, path)
    try:
        return Reduced(body, load(Anatomy, path), load(MeshProperties, path))
    except ValueError as error:
        raise BadInput(
            f"{error}; an FMU can be built of it, pictures and recovery cannot"
        ) from None
