"""Reduction of a mesh and a material, or a mesh and its matrices, to a small body."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp

from ..body_options import MOST_MODES, Block, Piston
from ..finite_elements.element import rigid_mass, rigid_motions
from ..finite_elements.faces import face_load
from ..finite_elements.matrices import FullModel
from ..finite_elements.mesh import Mesh, MeshFault
from ..finite_elements.solver import Factorise, factorise
from ..geometry.grid import cell_centres
from .bases import (
    Elastic,
    Modes,
    characteristic_constraint_modes,
    craig_bampton,
    expected_pressure,
    of_unit_energy,
    orthonormal_modes,
    pressure_modes,
    static_answers,
)
from .bosses import Shells, boss_readings, with_pressure_modes
from .film_loads import FilmLoads, Training, on_stations
from .frame_integrals import Z, floating_frame_integrals, rigid_integrals
from .geometry import block_faults, pin_bore, piston_faults
from .interpolation import SurfaceReading, covered, interpolation, radial_and_axial
from .reading import full_model, read_body
from .reduced_body import (
    Anatomy,
    MeshProperties,
    MissingShapes,
    ReducedBlock,
    ReducedBody,
    ReducedBosses,
    ReducedPiston,
    ShellFilm,
    no_modes,
    no_modes_in_motion,
)
from .smooth_prior import (
    ALONG,
    SurfaceAnswers,
    edge_patches,
    pattern_count,
    pressure_root,
    smooth_pressure_modes,
    surface_answers,
)
from .symmetry import ClassedModes, is_mirrored, symmetric_modes
from .ties import held_piston
from .training import trained_shapes
from .truncation import StaticModes, edge_error, left_out, smooth_error

NO_MASS = np.full((6, 6), np.nan)
"""Mass matrix that is not known."""
Say = Callable[[str], None]
Grid = tuple[int, int]


class Reduced(NamedTuple):
    """Reduced body with its mesh.

    left_out : what its modes leave out, None without modes. bosses : of a piston with films in its
    bosses.
    """

    body: ReducedBody
    anatomy: Anatomy
    properties: MeshProperties
    left_out: MissingShapes | None = None
    bosses: ReducedBosses | None = None


class FilmSide(NamedTuple):
    """Film surface of a body, for the choice of its modes.

    Parameters
    ----------
    surface : str
        Name in the mesh.
    reading : SurfaceReading
        Matrices that read its displacement on the grid.
    angle, height : ndarray
        Lines of the grid [rad], [m].
    along : float
        Correlation length of the pressure as a share of the surface's length, `smooth_prior.ALONG`.
    has_film : ndarray of bool, shape (points,)
        Points that have the surface under them.
    training : FilmLoads or None
        Film forces of an earlier run at the points.
    bosses, boss_films
        Bosses of a piston with films in them.
    """

    surface: str
    reading: SurfaceReading
    angle: np.ndarray
    height: np.ndarray
    along: float
    has_film: np.ndarray
    training: FilmLoads | None
    bosses: Shells | None = None
    boss_films: ShellFilm | None = None

    def root(self, parity: int) -> np.ndarray:
        """Return S of Eq. (J31)."""
        return pressure_root(self.angle, self.height, self.along, self.has_film, parity)


class Basis(NamedTuple):
    """Modes of a body and what they leave out."""

    modes: ClassedModes
    left_out: MissingShapes


class Placed(NamedTuple):
    """Body on the lines of its film grid, before it has modes.

    Parameters
    ----------
    body : ReducedPiston or ReducedBlock
        Without modes.
    position : ndarray, shape (n, 3)
        Nodes from the body's origin [m].
    angle, height : ndarray
        Lines of the grid [rad], [m].
    reading : SurfaceReading
    rigid_mass : ndarray, shape (6, 6)
        Eq. (J8); nan for matrices that are not read.
    skirt : ndarray of bool
        As of `MeshProperties`.
    """

    body: Any
    position: np.ndarray
    angle: np.ndarray
    height: np.ndarray
    reading: SurfaceReading
    rigid_mass: np.ndarray
    skirt: np.ndarray


class CylinderReading(NamedTuple):
    """Mean radius of a cylindrical surface [m], and the matrices that read it on a grid."""

    radius: float
    reading: SurfaceReading


def reduce_piston(
    options: Piston,
    grid: Grid,
    progress: Say = print,
    factors: Factorise = factorise,
    training: Training | None = None,
    bosses: ShellFilm | None = None,
) -> Reduced:
    """Reduce a piston to mass properties, modes and their values on the skirt grid.

    Pin point A is on the axis of the mesh's pin bores; `ReducedPiston.about` moves it.

    Parameters
    ----------
    options : Piston
    grid : (int, int)
        Cells around and along the skirt.
    progress : callable
        Prints a sentence.
    factors : callable
        Factorises a matrix (`solver`).
    training : Training, optional
        Forces for the basis `trained`.
    bosses : ShellFilm, optional
        Films in the bosses, for which modes are added.

    Raises
    ------
    MeshFault, ValueError
        If mesh, matrices, supports or number of modes are wrong.
    """
    mesh = read_body(options, progress)
    full = _matrices(mesh, options, progress)
    body, position, angle, height, reading, mass, has_film = placed_piston(
        mesh, options, grid, full
    )
    progress(
        f"skirt from {1e3 * body.skirt_lower:.4g} to {1e3 * body.skirt_upper:.4g} mm about the "
        f"pin, {body.mass:.4g} kg"
    )
    if not has_film.all():
        progress(
            f"{np.count_nonzero(~has_film)} of {has_film.size} cells of the film grid have no "
            "skirt under them, and no film"
        )
    properties = MeshProperties(mass, len(angle), has_film)
    if not options.modes:
        return Reduced(body, _anatomy(mesh, position), properties)
    assert full  # of a flexible body
    _, K, M = full
    gas = face_load(mesh.points, mesh.faces["crown"])
    gas /= -gas[:, 1].sum()  # unit resultant along -y
    inertia = [
        np.tile([0.0, 1.0, 0.0], (len(position), 1)),
        np.tile([1.0, 0.0, 0.0], (len(position), 1)),
        position @ Z.T,
    ]
    loads = np.column_stack([gas.ravel()] + [M @ field.ravel() for field in inertia])
    faults_of_modes(mesh, options, "pin_bore", "skirt", angle, height, bosses)
    read = boss_readings(mesh, position, bosses) if bosses else None
    elastic = held_piston(mesh, K, M, options, progress, factors, bosses is not None)
    del K  # the elastic body contains the needed part
    film_forces = training.loads.film if training else None
    film = FilmSide(
        surface="skirt",
        reading=reading,
        angle=angle,
        height=height,
        along=ALONG["skirt"],
        has_film=has_film.ravel(),
        training=film_forces,
        bosses=read,
        boss_films=bosses,
    )
    modes, left = _modes(mesh, elastic, options, film, loads, progress)
    shapes = modes.shapes.reshape(len(position), 3, len(modes.omega))
    body = replace(
        body,
        **floating_frame_integrals(M, position, shapes)._asdict(),
        omega=modes.omega,
        kind=modes.kind,
        gas_force=modes.shapes.T @ gas.ravel(),
        radial=reading.radial @ modes.shapes,
        axial=reading.axial @ modes.shapes,
    )
    anatomy = _anatomy(mesh, position, shapes)
    in_bosses = _in_bosses(read, modes.shapes, bosses.grid) if read and bosses else None
    return Reduced(body, anatomy, properties, left, in_bosses)


def placed_piston(mesh: Mesh, options: Piston, grid: Grid, full: FullModel | None) -> Placed:
    """Return a piston on its film grid, without modes.

    Raises
    ------
    MeshFault
        If position, size or density of the mesh are wrong.
    """
    mass = _rigid_mass(mesh, mesh.points, full)[0, 0]
    refuse(piston_faults(mesh, mass, options.pin_offset), options)
    axis, _ = pin_bore(mesh)
    position = mesh.points - np.array([axis.first, 0.0, 0.0])
    inertia = _rigid_mass(mesh, position, full)
    lower, upper = ends(mesh, "skirt", options.skirt_lower, options.skirt_upper)
    angle, height = cell_centres(*grid, lower, upper)
    radius, reading = film_surface(mesh, "skirt", angle, height)
    rest: dict[str, Any] = no_modes_in_motion(len(angle) * len(height))
    body = ReducedPiston(
        **rigid_integrals(inertia),
        **rest,
        radius=radius,
        skirt_lower=lower,
        skirt_upper=upper,
        pin_offset=axis.first,
    )
    skirt = covered(mesh.points, mesh.faces["skirt"], angle, height, radius)
    return Placed(
        body=body,
        position=position,
        angle=angle,
        height=height,
        reading=reading,
        rigid_mass=inertia,
        skirt=skirt,
    )


def _in_bosses(bosses: Shells, shapes: np.ndarray, grid: Grid) -> ReducedBosses:
    """Return the values of modes, (3 n, k), in both bosses."""
    table = (*grid, shapes.shape[1])
    return ReducedBosses(
        boss_outward=np.stack([(one.outward @ shapes).reshape(table) for one in bosses.sides]),
        boss_onward=np.stack([(one.onward @ shapes).reshape(table) for one in bosses.sides]),
        boss_stations=np.stack([one.stations for one in bosses.sides]),
        boss_radius=bosses.radius,
    )


def reduce_block(
    options: Block,
    grid: Grid,
    progress: Say = print,
    factors: Factorise = factorise,
    training: Training | None = None,
) -> Reduced:
    """Reduce a cylinder block to modes and their values on a table of the bore.

    The table has the angles of the film grid and `stations` heights.

    Parameters
    ----------
    options : Block
    grid : (int, int)
        Film grid with the angles of the table.
    progress, factors, training
        As for `reduce_piston`.

    Raises
    ------
    MeshFault, ValueError
        As for `reduce_piston`.
    """
    mesh = read_body(options, progress)
    full = _matrices(mesh, options, progress)
    body, _, angle, heights, reading, _, no_skirt = placed_block(mesh, options, grid)
    properties = MeshProperties(_rigid_mass(mesh, mesh.points, full), len(angle), no_skirt)
    if not options.modes:
        return Reduced(body, _anatomy(mesh, mesh.points), properties)
    assert full  # of a flexible body
    _, K, M = full
    everywhere = np.ones(len(angle) * len(heights), dtype=bool)
    faults_of_modes(mesh, options, "bolts", "bore", angle, heights)
    elastic = Elastic(K, M, mesh.nodes("bolts"), factors)
    del K
    film_forces = on_stations(training.loads, training.rows, heights) if training else None
    film = FilmSide(
        surface="bore",
        reading=reading,
        angle=angle,
        height=heights,
        along=ALONG["bore"],
        has_film=everywhere,
        training=film_forces,
    )
    no_loads = np.empty((3 * len(mesh.points), 0))
    modes, left = _modes(mesh, elastic, options, film, no_loads, progress)
    shapes = modes.shapes.reshape(len(mesh.points), 3, len(modes.omega))
    table = (len(angle), len(heights), len(modes.omega))
    body = replace(
        body,
        omega=modes.omega,
        kind=modes.kind,
        radial=(reading.radial @ modes.shapes).reshape(table),
        axial=(reading.axial @ modes.shapes).reshape(table),
    )
    return Reduced(body, _anatomy(mesh, mesh.points, shapes), properties, left)


def placed_block(mesh: Mesh, options: Block, grid: Grid) -> Placed:
    """Return a block on the table of its bore, without modes and without its mass.

    Raises
    ------
    MeshFault
        If position or size of the mesh are wrong.
    """
    refuse(block_faults(mesh), options)
    lower, upper = ends(mesh, "bore", options.bore_lower, options.bore_upper)
    angle, _ = cell_centres(*grid, 0.0, 1.0)
    heights = np.linspace(lower, upper, options.stations)
    radius, reading = film_surface(mesh, "bore", angle, heights)
    body = ReducedBlock(**no_modes(len(angle), len(heights)), heights=heights, radius=radius)
    no_skirt = np.zeros((len(angle), 0), dtype=bool)
    return Placed(
        body=body,
        position=mesh.points,
        angle=angle,
        height=heights,
        reading=reading,
        rigid_mass=NO_MASS,
        skirt=no_skirt,
    )


def refuse(faults: list[str], options: Piston | Block) -> None:
    """Raise a `MeshFault` with the faults of a body's mesh, if there are any."""
    if faults:
        raise MeshFault([f"{options.mesh}: {fault}" for fault in faults])


def _anatomy(mesh, position, shapes=None):
    """Return mesh and mode shapes, by default none, for pictures and recovery."""
    material = mesh.material
    return Anatomy(
        points=position,
        tets=mesh.tets,
        skin=mesh.skin(),
        shapes=np.empty((*position.shape, 0)) if shapes is None else shapes,
        young=material.young if material else np.nan,
        poisson=material.poisson if material else np.nan,
    )


def _matrices(mesh, options, progress):
    """Return the full model, None for a rigid body of elements, which needs no matrices."""
    return full_model(mesh, options, progress) if options.modes or options.mass else None


def _rigid_mass(mesh, position, full):
    """Return the mass matrix of the rigid motions about the origin of `position`, Eq. (J8).

    It is unknown for a body of matrices that are not read.
    """
    if full is None:
        return rigid_mass(position, mesh.tets, mesh.material.density) if mesh.material else NO_MASS
    rigid = rigid_motions(position)
    return rigid.T @ (full.M @ rigid)


def film_surface(mesh, name, angle, height):
    """Return the radius and the reading of a cylindrical surface at the points of a grid."""
    x, _, z = mesh.points[mesh.nodes(name)].T
    radius = float(np.hypot(x, z).mean())
    interpolate = interpolation(mesh.points, mesh.faces[name], angle, height, radius)
    return CylinderReading(radius, radial_and_axial(interpolate, angle, len(height)))


def ends(mesh, name, lower, upper):
    """Return lowest and highest height of a surface [m]; default: those of its nodes.

    Given heights must be on the surface, with a tolerance of a hundredth of its length.
    """
    height = mesh.points[mesh.nodes(name), 1]
    least = float(height.min())
    most = float(height.max())
    lower = least if lower is None else lower
    upper = most if upper is None else upper
    slack = (most - least) / 100
    if lower < least - slack or upper > most + slack:
        raise MeshFault(
            f"{name}_lower, {name}_upper: expected within surface '{name}', {least:g} to "
            f"{most:g} m, got {lower:g}, {upper:g} m"
        )
    return lower, upper


def _modes(
    mesh: Mesh,
    elastic: Elastic,
    options: Piston | Block,
    film: FilmSide,
    loads: np.ndarray,
    progress: Say,
) -> Basis:
    """Return the modes of a body by the chosen basis."""
    wanted = options.modes
    progress(f"modes = {wanted:.3g}, basis {options.basis}")
    reading = SurfaceReading(*(one[:, elastic.free].tocsr() for one in film.reading))
    parity = int(options.symmetric_film)
    answers = surface_answers(elastic, reading, film.root(parity))
    candidates = options.modes_from or int(wanted)
    if options.basis == "craig_bampton":
        shapes = craig_bampton(elastic, candidates)
    elif options.basis == "characteristic_constraint_modes":
        shapes = characteristic_constraint_modes(elastic, mesh.nodes(film.surface), candidates)
    else:
        more = film.boss_films.modes if film.boss_films else 0
        own = wanted - more if isinstance(wanted, int) else wanted
        shapes = _film_shapes(elastic, film, reading, answers, options, loads[elastic.free], own)
        if film.bosses and film.boss_films and more:
            count = shapes.shape[1] + more
            if count > MOST_MODES:
                raise ValueError(
                    f"modes: expected an error that {MOST_MODES} modes reach, got {wanted:g} with "
                    f"{count} modes, {more} of them for the bosses; give a larger error"
                )
            shapes = with_pressure_modes(elastic, film.bosses, film.boss_films.grid, shapes, count)
    whole = answers
    if parity:
        odd = surface_answers(elastic, reading, film.root(-parity))
        whole = SurfaceAnswers(*map(np.hstack, zip(answers, odd)))
    patches = edge_patches(
        film.angle, film.height, film.along, film.has_film, options.symmetric_film
    )
    edges = [surface_answers(elastic, reading, one) for one in patches]
    elastic.forget_factors()
    modes = orthonormal_modes(elastic, shapes)
    modes = Modes(elastic.full(modes.shapes), modes.omega)
    classed = ClassedModes(*modes, np.full(len(modes.omega), -1))
    if is_mirrored(mesh, 0) and is_mirrored(mesh, 2):
        classed = symmetric_modes(elastic, modes, mesh.points)
    if options.modes_from:
        classed = _selected(classed, film, answers.root, int(wanted))
    radial, axial = (one @ classed.shapes for one in film.reading)
    static = StaticModes(classed.omega, radial, axial)
    left = replace(
        left_out(whole, static, film.has_film),
        smooth_error=smooth_error(answers, static, film.has_film),
        edge_errors=np.array([edge_error(one, static) for one in edges]),
    )
    progress(f"{len(classed.omega)} modes: {left.errors_in_words()}")
    return Basis(classed, left)


def _selected(modes: ClassedModes, film: FilmSide, root: np.ndarray, count: int) -> ClassedModes:
    """Return the modes with the largest part of the deflection under the prior.

    Eq. (J35):  part_k = |R phi_k| |S^T R phi_k| / omega_k^2
    """
    radial = film.reading.radial @ modes.shapes
    felt = np.linalg.norm(root.T @ radial, axis=0)
    part = np.linalg.norm(radial, axis=0) * felt / modes.omega**2  # Eq. (J35)
    best = np.sort(np.argsort(-part, kind="stable")[:count])
    return ClassedModes(modes.shapes[:, best], modes.omega[best], modes.kind[best])


def _film_shapes(
    elastic: Elastic,
    film: FilmSide,
    reading: SurfaceReading,
    answers: SurfaceAnswers,
    options: Piston | Block,
    loads: np.ndarray,
    modes: int | float,
) -> np.ndarray:
    """Return shapes for film pressures, (free, k), which represent `loads`, (free, j), exactly.

    For the basis `trained`, shapes of an earlier run are added to those of the prior.
    """
    first = static_answers(elastic, loads, modes)
    if options.basis == "pressure_modes":
        weight = expected_pressure(film.angle, len(film.height))
        return pressure_modes(elastic, reading.radial, weight, int(modes), first)
    shapes = smooth_pressure_modes(elastic, reading.radial, answers, modes, first)
    if film.training is None:
        return shapes
    psi = of_unit_energy(elastic, shapes)
    spread = sp.hstack([reading.radial.T, -reading.axial.T], format="csr")
    in_bosses = film.boss_films.modes if film.boss_films else 0
    most = MOST_MODES - psi.shape[1] - in_bosses
    return np.hstack([trained_shapes(elastic, spread, film.training, psi, most), psi])


def faults_of_modes(
    mesh: Mesh,
    options: Piston | Block,
    support: str,
    surface: str,
    angle: np.ndarray,
    height: np.ndarray,
    bosses: ShellFilm | None = None,
) -> None:
    """Check supports and number of modes before the factorisation.

    Parameters
    ----------
    mesh : Mesh
    options : Piston or Block
    support, surface : str
        Names of the surface that supports the body, and of the film surface.
    angle, height : ndarray
        Lines of the film grid [rad], [m].
    bosses : ShellFilm, optional
        Films in the bosses, whose modes the film grid does not limit.

    Raises
    ------
    MeshFault
        If the supports do not prevent rigid motions, or there are not enough shapes.
    """
    count = options.modes_from or options.modes
    more = bosses.modes if bosses else 0
    patterns = more + pattern_count(angle, height, ALONG[surface], options.symmetric_film)
    faults = []
    if options.symmetric_film and (len(angle) % 2 or not is_mirrored(mesh, 2)):
        faults.append(
            "symmetric_film: expected an even number of cells around and a mesh that is its own "
            f"mirror image about the thrust plane, got {len(angle)} cells and {len(mesh.points)} "
            "nodes"
        )
    held_nodes = mesh.nodes(support)
    arms = mesh.points[held_nodes] - mesh.points.mean(axis=0)
    loose = 6 - np.linalg.matrix_rank(rigid_motions(arms), tol=1e-9)
    if loose:
        faults.append(
            f"surface '{support}': expected nodes that hold the body, got {len(held_nodes)} that "
            f"leave {loose} rigid motions"
        )
    free_on_surface = len(np.setdiff1d(mesh.nodes(surface), held_nodes))
    most = {
        "craig_bampton": 3 * (len(mesh.points) - len(held_nodes)) - 2,
        "characteristic_constraint_modes": 3 * free_on_surface - 2,
        "pressure_modes": more + len(angle) * len(height) - 2,
        "smooth_pressure_modes": patterns,
        "trained": patterns,
    }[options.basis]
    if count > most:
        faults.append(
            f"{'modes_from' if options.modes_from else 'modes'}: expected at most {most} with "
            f"{options.basis} on this grid, got {count}"
        )
    if count and faults:
        raise MeshFault(faults)
