"""Reduction of a rod's small end to modes on the grid of the film in its eye.

The small end is the eye with a part of the shank. The rigid rod fixes the shank at its cut, and the
modes do not depend on the motion of the rod.
"""

from collections.abc import Callable

import numpy as np

from ..finite_elements.matrices import FullModel
from ..finite_elements.mesh import Mesh, MeshFault
from ..finite_elements.solver import Factorise, factorise
from ..geometry.grid import film_rows
from .bases import Elastic, orthonormal_modes
from .bosses import Shells, out_of_round, shell_reading, with_boss_modes, without_shell
from .interpolation import BESIDE
from .reduced_body import EyeFilm, ReducedSmallEnd

Say = Callable[[str], None]

EYE, CUT = "eye", "cut"
"""Surfaces of the mesh: the bore about z, and the section where the rod fixes the shank."""


def eye_shell(mesh: Mesh, film: EyeFilm) -> Shells:
    """Return the reading of the eye over the film's length about z = 0.

    Raises
    ------
    MeshFault
        If the bore is not round about z, or ends within the film, or the shank is not on the side
        of -y.
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


def held_at_cut(body: FullModel, factors: Factorise = factorise) -> Elastic:
    """Return the small end, with all nodes of its cut fixed to the rigid rod.

    Raises
    ------
    MeshFault
        If the nodes of the cut are on a line.
    """
    held = body.mesh.nodes(CUT)
    place = body.mesh.points[held] - body.mesh.points[held].mean(axis=0)
    if len(held) < 3 or np.linalg.matrix_rank(place, tol=1e-9) < 2:
        raise MeshFault(
            f"small end: surface '{CUT}': expected nodes off one line, got {len(held)} nodes "
            "on a line"
        )
    return Elastic(body.K, body.M, held, factors)


def reduce_small_end(
    body: FullModel, film: EyeFilm, progress: Say = print, factors: Factorise = factorise
) -> ReducedSmallEnd:
    """Reduce a small end, fixed at its cut, to shapes of Eqs. (J2) and (J24).

    Parameters
    ----------
    body : FullModel
    film : EyeFilm
    progress : callable
        Prints a sentence.
    factors : callable
        Factorises a matrix (`solver`).

    Raises
    ------
    MeshFault, ValueError
        If the mesh or the number of modes is wrong.
    """
    shell = eye_shell(body.mesh, film)
    elastic = held_at_cut(body, factors)
    progress(f"{film.modes} modes of {len(elastic.free)} degrees of freedom")
    return yielding_shell(elastic, shell, film)


def yielding_shell(elastic: Elastic, shell: Shells, film: EyeFilm) -> ReducedSmallEnd:
    """Return the modes of an elastic body on the grid of the film in its only shell."""
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
