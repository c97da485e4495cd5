"""Elastic diaphragm in the shell of a bearing, for `models/measured/freund_1995`.

A slot along the axis bounds the diaphragm at angle 0. The shell is rigid elsewhere.
"""

from typing import Any, NamedTuple

import numpy as np

from piston_cosim.fmu_ehd.balance.grid import Array
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


def diaphragm(table: dict[str, Any], radius: float, film: ShellFilm) -> ShellModes:
    """Return the modes of the diaphragm of a case on the grid of its film.

    Parameters
    ----------
    table : dict
        Table `diaphragm` of case.toml.
    radius : float
        Of the bore [m].
    film : ShellFilm
    """
    young, poisson = to_si(table["young"], "Pa"), table["poisson"]
    body = assembled(diaphragm_mesh(table, radius, film.length), young, poisson, DENSITY)
    reduced = reduce_shell(body, film, lambda text: None, kind=ShellKind("diaphragm"))
    outward = reduced.outward.copy()
    # half of the cell of the slot is on the rigid side; the oil flows in at the free edge
    outward[0] = 2.0 * outward[1] - outward[2]
    return ShellModes(reduced.omega, outward, reduced.onward)


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
    stations = np.stack([half, np.full_like(half, length / 2)])
    near = 4 * np.abs(z) / length
    moved = np.where(near < 1.0, near * half, half + (near - 1.0) * (stations[1] - half))
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
