"""The whole elastic answer of both bodies to pressure on the film: what no choice of modes has
taken anything from. Dear: one solution of the full mesh for each cell.
"""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from ..finite_elements.solver import factorise
from ..geometry.grid import cell_centres
from ..options import Build, read_options
from .bases import Elastic
from .reduce import _ends, _film_surface, full_model

AT_ONCE = 64
"""Loads solved together: bounds the memory."""


class RigidPiston(NamedTuple):
    """Mass [kg]; centre of mass x, y from A [m]; moment of inertia about A and z [kg m2]; edges of
    the skirt above A [m].
    """

    mass: float
    centre: np.ndarray
    inertia: float
    skirt_lower: float
    skirt_upper: float


class Compliance(NamedTuple):
    """Of skirt and bore; n cells of the film grid, s stations of the bore.

    Parameters
    ----------
    piston : RigidPiston
    skirt : ndarray, shape (n, n)
        Inward displacement of the skirt per nodal pressure force [m/N].
    skirt_inertia : ndarray, shape (n,)
        Inward displacement of the skirt per acceleration of A along +y [s2].
    bore : ndarray, shape (c, s, c, s)
        Outward displacement of the bore per radial force at its table [m/N].
    stations : ndarray, shape (s,)
        Heights above the crank axis [m].
    """

    piston: RigidPiston
    skirt: np.ndarray
    skirt_inertia: np.ndarray
    bore: np.ndarray
    stations: np.ndarray


def compliance(options: dict[str, Any], folder: Path, progress=print) -> Compliance:
    """Both bodies of a build table, unreduced.

    Parameters
    ----------
    options, folder
        As for `build.prepare`; pin bores and bolts are held rigidly (tie "rbe2").
    """
    build = read_options(options, folder)
    skirt, inertia, rigid = _skirt(build, progress)
    bore, stations = _bore(build, progress)
    return Compliance(rigid, skirt, inertia, bore, stations)


def _skirt(build: Build, progress):
    around, along = build.grid
    mesh, K, M = full_model(build.piston, ("skirt", "crown", "pin_bore"), progress)
    lower, upper = _ends(mesh, "skirt", build.piston.skirt_lower, build.piston.skirt_upper)
    position = mesh.points - np.array([build.piston.pin_offset, 0.0, 0.0])
    angle, height = cell_centres(around, along, lower, upper)
    radial = _film_surface(mesh, "skirt", angle, height).reading.radial
    elastic = Elastic(K, M, mesh.nodes("pin_bore"), factorise)
    upward = np.tile([0.0, 1.0, 0.0], len(position))
    across = np.tile([1.0, 0.0, 0.0], len(position))
    arm = (position * [1.0, 1.0, 0.0]).ravel()
    weight = M @ upward
    mass = float(upward @ weight)
    rigid = RigidPiston(
        mass,
        np.array([across @ (M @ position.ravel()), upward @ (M @ position.ravel())]) / mass,
        float(arm @ (M @ arm)),
        lower,
        upper,
    )
    free = radial[:, elastic.free]
    # pressure pushes inwards, and what counts is how far the skirt gives way inwards
    push = _answers(elastic, free)
    return push, free @ elastic._lu.solve(weight[elastic.free]), rigid


def _bore(build: Build, progress):
    around, _ = build.grid
    mesh, K, M = full_model(build.block, ("bore", "bolts"), progress)
    lower, upper = _ends(mesh, "bore", build.block.bore_lower, build.block.bore_upper)
    stations = np.linspace(lower, upper, build.block.stations)
    angle, _ = cell_centres(around, 1, 0.0, 1.0)
    radial = _film_surface(mesh, "bore", angle, stations).reading.radial
    elastic = Elastic(K, M, mesh.nodes("bolts"), factorise)
    table = (around, len(stations))
    return _answers(elastic, radial[:, elastic.free]).reshape(*table, *table), stations


def _answers(elastic, reading):
    """R K^-1 R^T."""
    out = np.empty((reading.shape[0],) * 2)
    for first in range(0, reading.shape[0], AT_ONCE):
        some = slice(first, first + AT_ONCE)
        out[:, some] = reading @ elastic._lu.solve(reading[some].T.toarray())
    return out


def on_the_skirt(found: Compliance, height_of_A: float, height: np.ndarray) -> np.ndarray:
    """Film thickness per nodal pressure force, skirt and bore together, the bore read by cubic
    splines at the heights that face the skirt, (n, n) [m/N].

    height : of the grid rows above A, (a,) [m].
    """
    around, stations = found.bore.shape[:2]
    reading = CubicSpline(found.stations, np.eye(stations), bc_type="natural")(height_of_A + height)
    along = len(height)
    bore = np.einsum("ar,irjs,bs->iajb", reading, found.bore, reading, optimize=True)
    return found.skirt + bore.reshape(around * along, around * along)
