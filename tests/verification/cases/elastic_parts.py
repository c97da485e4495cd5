"""Elastic parts of measured bearings, made here.

diaphragm    in the shell, for `models/measured/freund_1995`: a slot along the axis bounds it at
             angle 0, and the shell is rigid elsewhere
journal      for `models/measured/sander_2016`: a ring whose hole is held
"""

from typing import Any, NamedTuple

import numpy as np

from piston_cosim.fmu_ehd.common.grid import Array
from piston_cosim.fmu_mfbd.finite_elements.connections import outer_faces
from piston_cosim.fmu_mfbd.finite_elements.matrices import assembled
from piston_cosim.fmu_mfbd.finite_elements.mesh import Mesh
from piston_cosim.fmu_mfbd.finite_elements.ring import BORE, HELD, Ring, ring_mesh
from piston_cosim.fmu_mfbd.reduction.reduced_body import ShellFilm, ShellKind
from piston_cosim.fmu_mfbd.reduction.shell import reduce_shell
from piston_cosim.fmu_mfbd.shell.build import DENSITY
from piston_cosim.master.fmi.quantities import to_si

SMALL = 1e-9


class ShellModes(NamedTuple):
    """Modes on the grid of a film, see `journal.ElasticShell`."""

    omega: Array
    outward: Array
    onward: Array


def elastic_modes(part: str, table: dict[str, Any], radius: float, film: ShellFilm) -> ShellModes:
    """Return the modes of a part of a bearing on the grid of its film.

    Parameters
    ----------
    part : {"diaphragm", "journal"}
    table : dict
        Its table in case.toml.
    radius : float
        Of the film [m].
    film : ShellFilm
    """
    is_journal = part == "journal"
    mesh = (journal_mesh if is_journal else diaphragm_mesh)(table, radius, film.length)
    body = assembled(mesh, to_si(table["young"], "Pa"), table["poisson"], DENSITY)
    reduced = reduce_shell(body, film, lambda text: None, kind=ShellKind(part))
    if is_journal:
        # inwards it opens the film, and friction on it is opposite to that on the shell
        return ShellModes(reduced.omega, -reduced.outward, -reduced.onward)
    outward = reduced.outward.copy()
    # half of the cell of the slot is on the rigid side; the oil flows in at the free edge
    outward[0] = 2.0 * outward[1] - outward[2]
    return ShellModes(reduced.omega, outward, reduced.onward)


def journal_mesh(table: dict[str, Any], radius: float, length: float) -> Mesh:
    """Return the mesh of a journal, whose own length is not that of its film."""
    hole, own = to_si(table["hole"], "m"), to_si(table["length"], "m")
    ring = ring_mesh(Ring(hole, radius, own, 2 * np.pi, tuple(table["cells"])))
    faces = outer_faces(ring.tets)
    outside = np.hypot(*ring.points[:, :2].T) > radius * (1.0 - 1e-9)
    surfaces = {BORE: faces[outside[faces].all(axis=1)], HELD: ring.faces[BORE]}
    return Mesh(ring.points, ring.tets, surfaces)


def diaphragm_mesh(table: dict[str, Any], radius: float, length: float) -> Mesh:
    """Return the mesh of a liner that is held except in its diaphragm, free at angle 0.

    The diaphragm has the middle half of the cells along the liner.
    """
    end = to_si(table["end"], "rad")
    first, last = (to_si(width, "m") for width in table["half_width"])
    outside = radius + to_si(table["thickness"], "m")
    ring = ring_mesh(Ring(radius, outside, length, 2 * np.pi, tuple(table["cells"])))
    x, y, z = ring.points.T
    angle = np.arctan2(y, x)
    inner = np.abs(z) < length / 4 - SMALL
    half = first + (last - first) * np.clip(angle / end, 0.0, 1.0)
    near = 4 * np.abs(z) / length
    moved = np.where(near < 1.0, near * half, half + (near - 1.0) * (length / 2 - half))
    points = np.stack([x, y, np.sign(z) * moved], axis=1)

    # nodes of the slot twice: the held ones, and those of the free edge
    edge = np.flatnonzero((np.abs(angle) < SMALL) & inner)
    twin = np.arange(len(points))
    twin[edge] = len(points) + np.arange(len(edge))

    def behind(cells: np.ndarray) -> np.ndarray:
        return np.where((angle[cells] > -SMALL).all(axis=1)[:, None], twin[cells], cells)

    free = np.append(inner & (angle > SMALL) & (angle < end - SMALL), np.ones(len(edge), bool))
    tets = behind(ring.tets)
    return Mesh(
        np.concatenate([points, points[edge]]),
        tets[free[tets].any(axis=1)],
        {BORE: behind(ring.faces[BORE]), HELD: ring.faces[HELD]},
        {HELD: np.flatnonzero(~free)},
    )
