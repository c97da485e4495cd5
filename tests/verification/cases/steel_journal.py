"""Elastic journal for `models/measured/sander_2016`: a ring whose hole is held."""

from typing import Any

import numpy as np

from piston_cosim.fmu_mfbd.finite_elements.connections import outer_faces
from piston_cosim.fmu_mfbd.finite_elements.matrices import assembled
from piston_cosim.fmu_mfbd.finite_elements.mesh import Mesh
from piston_cosim.fmu_mfbd.finite_elements.ring import BORE, HELD, Ring, ring_mesh
from piston_cosim.fmu_mfbd.reduction.reduced_body import ShellFilm, ShellKind
from piston_cosim.fmu_mfbd.reduction.shell import reduce_shell
from piston_cosim.fmu_mfbd.shell.build import DENSITY
from piston_cosim.master.fmi.quantities import to_si
from piston_cosim.tests.verification.cases.diaphragm import ShellModes


def steel_journal(table: dict[str, Any], radius: float, film: ShellFilm) -> ShellModes:
    """Return the modes of a journal on the grid of its film.

    A displacement of the journal inwards opens the film, and friction on it is opposite to that on
    the shell.

    Parameters
    ----------
    table : dict
        Table `journal` of case.toml.
    radius : float
        Of the journal [m].
    film : ShellFilm
    """
    hole, length = to_si(table["hole"], "m"), to_si(table["length"], "m")
    ring = ring_mesh(Ring(hole, radius, length, 2 * np.pi, tuple(table["cells"])))
    faces = outer_faces(ring.tets)
    outside = np.hypot(*ring.points[:, :2].T) > radius * (1.0 - 1e-9)
    surfaces = {BORE: faces[outside[faces].all(axis=1)], HELD: ring.faces[BORE]}
    mesh = Mesh(ring.points, ring.tets, surfaces)
    body = assembled(mesh, to_si(table["young"], "Pa"), table["poisson"], DENSITY)
    reduced = reduce_shell(body, film, lambda text: None, kind=ShellKind("journal"))
    return ShellModes(reduced.omega, -reduced.outward, -reduced.onward)
