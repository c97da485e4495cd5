"""Offline: the small end of a rod, its eye on a piece of shank, to modes on the grid of the film in
the eye. The shank is held at its cut by the rigid rod, whose motion the modes know nothing of.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ..finite_elements.element import Sparse, consistent_mass, stiffness
from ..finite_elements.mesh import Mesh, MeshFault, read_mesh
from ..finite_elements.regions import Region
from ..finite_elements.solver import Factorise, factorise
from ..geometry.grid import film_rows
from .bases import Elastic, orthonormal_modes
from .bosses import Shells, out_of_round, shell_reading, with_boss_modes, without_shell
from .interpolation import BESIDE
from .reduced_body import EyeFilm, ReducedSmallEnd

Say = Callable[[str], None]

EYE, CUT = "eye", "cut"
"""Surfaces of the mesh: the bore, about z, and the section at which the rod holds the shank."""


class SmallEndBody(NamedTuple):
    """Mesh [m], stiffness [N/m] and mass [kg] of the small end, (3 n, 3 n)."""

    mesh: Mesh
    K: Sparse
    M: Sparse


def read_small_end(
    path: str,
    regions: Mapping[str, Region],
    unit: float,
    axes: Sequence[str],
    origin: Sequence[float],
    say: Say,
) -> Mesh:
    """The small end's mesh with its two surfaces; arguments as of `read_mesh`.

    Raises
    ------
    MeshFault
    """
    surfaces: dict[str, Region | None] = dict.fromkeys((EYE, CUT))
    return read_mesh(path, surfaces | dict(regions), unit, axes, origin, say)


def small_end_body(mesh: Mesh, material: tuple[float, float, float]) -> SmallEndBody:
    """A small end of one material: Young's modulus [Pa], Poisson's ratio [-], density [kg/m3]."""
    young, poisson, density = material
    return SmallEndBody(
        mesh,
        stiffness(mesh.points, mesh.tets, young, poisson),
        consistent_mass(mesh.points, mesh.tets, density),
    )


def eye_shell(mesh: Mesh, film: EyeFilm) -> Shells:
    """The eye of a mesh, read where its film lies: over the film's length about z = 0.

    Raises
    ------
    MeshFault
        Where the bore is not round about the origin's z, or ends within the film, or the shank
        does not leave the eye towards -y.
    """
    faces = mesh.faces[EYE]
    x, y, z = mesh.points[mesh.nodes(EYE)].T
    radius = float(np.hypot(x, y).mean())
    around, along = film.grid
    stations = film_rows(-film.length / 2, film.length / 2, film.grid)
    faults = []
    if fault := out_of_round(mesh.points, faces, radius):
        faults.append(f"small end: surface '{EYE}': {fault}")
    elif (bare := without_shell(mesh.points, faces, radius, around, stations)) or (
        film.length / 2 > (1 + BESIDE) * min(z.max(), -z.min())
    ):
        faults.append(
            f"small end: surface '{EYE}': expected a bore under all of small_end_length = "
            f"{1e3 * film.length:.4g} mm about z = 0, got z = {1e3 * z.min():.4g} to "
            f"{1e3 * z.max():.4g} mm, with no bore under {bare} of {around * along} cells"
        )
    highest = float(mesh.points[mesh.nodes(CUT), 1].max())
    if highest > -radius:
        faults.append(
            f"small end: surface '{CUT}': expected y < {-1e3 * radius:.4g} mm, below the eye, got "
            f"y = {1e3 * highest:.4g} mm"
        )
    if faults:
        raise MeshFault(faults)
    return Shells((shell_reading(mesh.points, faces, radius, around, stations),), radius)


def held_at_cut(body: SmallEndBody, factors: Factorise = factorise) -> Elastic:
    """The small end, every node of its cut moving with the rigid rod.

    Raises
    ------
    MeshFault
        A cut that holds nothing.
    """
    held = body.mesh.nodes(CUT)
    place = body.mesh.points[held] - body.mesh.points[held].mean(axis=0)
    if len(held) < 3 or np.linalg.matrix_rank(place, tol=1e-9) < 2:
        raise MeshFault(
            [
                f"small end: surface '{CUT}': expected nodes off one line, got {len(held)} nodes "
                "on a line"
            ]
        )
    return Elastic(body.K, body.M, held, factors)


def reduce_small_end(
    body: SmallEndBody, film: EyeFilm, progress: Say = print, factors: Factorise = factorise
) -> ReducedSmallEnd:
    """The small end by the shapes it takes under the smooth pressures to which it yields most (Eqs.
    (J2), (J24)), held at its cut.

    Parameters
    ----------
    body : SmallEndBody
    film : EyeFilm
    progress : callable
        Takes a sentence now and then.
    factors : callable
        Factorises a matrix (`solver`).

    Raises
    ------
    MeshFault, ValueError
        What is wrong with mesh or number of modes.
    """
    shell = eye_shell(body.mesh, film)
    elastic = held_at_cut(body, factors)
    progress(f"{film.modes} modes of {len(elastic.free)} degrees of freedom")
    return yielding_shell(elastic, shell, film)


def yielding_shell(elastic: Elastic, shell: Shells, film: EyeFilm) -> ReducedSmallEnd:
    """Modes of a body, held somehow, on the grid of the film in its one shell."""
    none = np.empty((len(elastic.free), 0))
    shapes = with_boss_modes(elastic, shell, film.grid, none, film.modes)
    modes = orthonormal_modes(elastic, shapes)
    whole = elastic.full(modes.shapes)
    table = (*film.grid, film.modes)
    (side,) = shell.sides
    return ReducedSmallEnd(
        eye_omega=modes.omega,
        eye_outward=(side.outward @ whole).reshape(table),
        eye_onward=(side.onward @ whole).reshape(table),
        eye_radius=shell.radius,
    )
