"""Reduction of an elastic shell, such as a rod's small end, to modes on the grid of its film.

Another body holds the shell at one of its surfaces, and the modes do not depend on the motion of
this body. A small end is the eye with a part of the shank, and the rigid rod holds it at its cut.
"""

from collections.abc import Callable

import numpy as np

from ..finite_elements.materials import replacement_remarks
from ..finite_elements.matrices import FullModel
from ..finite_elements.mesh import Mesh, MeshFault
from ..finite_elements.ring import Ring, ring_mesh
from ..finite_elements.solver import Factorise, factorise
from ..geometry.grid import film_rows
from ..options import RoundShell, SmallEnd
from .bases import Elastic, orthonormal_modes
from .bosses import (
    Shells,
    cell_means,
    out_of_round,
    shell_reading,
    with_pressure_modes,
    without_shell,
)
from .interpolation import SURFACE_TOLERANCE
from .reading import read_surfaces
from .reduced_body import SMALL_END, ReducedShell, ShellFilm, ShellKind

Say = Callable[[str], None]


def film_shell(mesh: Mesh, film: ShellFilm, kind: ShellKind = SMALL_END) -> Shells:
    """Return the matrices from nodal displacements to those of the bore on the grid of the film.

    The bore is read over the length of the film about z = 0.

    Raises
    ------
    MeshFault
        If the bore is not round about z, or ends within the film, or a shank is not on the side
        of -y.
    """
    faces = mesh.faces[kind.bore]
    x, y, z = mesh.points[mesh.nodes(kind.bore)].T
    radius = float(np.hypot(x, y).mean())
    around, along = film.grid
    stations = film_rows(-film.length / 2, film.length / 2, film.grid)
    faults = []
    if fault := out_of_round(mesh.points, faces, radius):
        faults.append(f"{kind.title}: surface '{kind.bore}': {fault}")
    elif (bare := without_shell(mesh.points, faces, radius, around, stations)) or (
        film.length / 2 > (1 + SURFACE_TOLERANCE) * min(z.max(), -z.min())
    ):
        faults.append(
            f"{kind.title}: surface '{kind.bore}': expected a bore under all of {kind.length} = "
            f"{1e3 * film.length:.4g} mm about z = 0, got z = {1e3 * z.min():.4g} to "
            f"{1e3 * z.max():.4g} mm, with no bore under {bare} of {around * along} cells"
        )
    highest = float(mesh.points[mesh.nodes(kind.fixed), 1].max())
    if kind.hangs and highest > -radius:
        faults.append(
            f"{kind.title}: surface '{kind.fixed}': expected y < {-1e3 * radius:.4g} mm, below the "
            f"eye, got y = {1e3 * highest:.4g} mm"
        )
    if faults:
        raise MeshFault(faults)
    fine = around * kind.samples, along * kind.samples
    points = film_rows(-film.length / 2, film.length / 2, fine)
    reading = shell_reading(mesh.points, faces, radius, fine[0], points)
    if kind.samples > 1:
        reading = cell_means(reading, film.grid, kind.samples)
    return Shells((reading,), radius)


def held_shell(
    body: FullModel, factors: Factorise = factorise, kind: ShellKind = SMALL_END
) -> Elastic:
    """Return a shell, with all nodes of its held surface fixed.

    Raises
    ------
    MeshFault
        If these nodes are fewer than three, or on one line.
    """
    nodes = body.mesh.nodes(kind.fixed)
    place = body.mesh.points[nodes]
    if len(nodes) < 3 or np.linalg.matrix_rank(place - place.mean(axis=0), tol=1e-9) < 2:
        raise MeshFault(
            f"{kind.title}: surface '{kind.fixed}': expected at least three nodes, not all on one "
            f"line, got {len(nodes)}"
        )
    return Elastic(body.K, body.M, nodes, factors)


def reduce_shell(
    body: FullModel,
    film: ShellFilm,
    progress: Say = print,
    factors: Factorise = factorise,
    kind: ShellKind = SMALL_END,
) -> ReducedShell:
    """Reduce a shell, fixed where it is held, to shapes of Eqs. (J2) and (J24).

    Parameters
    ----------
    body : FullModel
    film : ShellFilm
    progress : callable
        Prints a sentence.
    factors : callable
        Factorises a matrix (`solver`).
    kind : ShellKind

    Raises
    ------
    MeshFault, ValueError
        If the mesh or the number of modes is wrong.
    """
    shell = film_shell(body.mesh, film, kind)
    elastic = held_shell(body, factors, kind)
    progress(f"{film.modes} modes of {len(elastic.free)} degrees of freedom")
    return elastic_shell_modes(elastic, shell, film, kind.upright)


def elastic_shell_modes(
    elastic: Elastic, shell: Shells, film: ShellFilm, upright: bool = True
) -> ReducedShell:
    """Return the modes of an elastic body, read on the grid of the film in its one shell."""
    none = np.empty((len(elastic.free), 0))
    shapes = with_pressure_modes(elastic, shell, film.grid, none, film.modes, upright)
    modes = orthonormal_modes(elastic, shapes)
    whole = elastic.full(modes.shapes)
    table = (*film.grid, film.modes)
    (side,) = shell.sides
    return ReducedShell(
        omega=modes.omega,
        outward=(side.outward @ whole).reshape(table),
        onward=(side.onward @ whole).reshape(table),
        radius=shell.radius,
    )


def shell_mesh(options: SmallEnd | RoundShell, film: ShellFilm, kind: ShellKind, say: Say) -> Mesh:
    """Return the mesh of a shell, from its file or its ring.

    Raises
    ------
    MeshFault
    """
    if isinstance(options, RoundShell) and (ring := options.ring):
        length = ring.length or film.length
        return ring_mesh(Ring(ring.inside, ring.outside, length, ring.held, ring.cells))
    mesh = read_surfaces(options, (kind.bore, kind.fixed), say)
    for sentence in replacement_remarks(
        mesh.sets, {"young": options.young, "poisson": options.poisson}
    ):
        say(f"{options.mesh}: {sentence}")
    return mesh
