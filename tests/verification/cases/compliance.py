"""Compliance of both unreduced bodies for pressure on the film.

It requires one solution of the full mesh for each pair of mirrored cells.
"""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from piston_cosim.fmu_mfbd.finite_elements.faces import face_load
from piston_cosim.fmu_mfbd.geometry.grid import cell_centres
from piston_cosim.fmu_mfbd.options import Build, read_options
from piston_cosim.fmu_mfbd.reduction.bases import Elastic
from piston_cosim.fmu_mfbd.reduction.reduce import ends, film_surface, full_model, read_body

from .monolithic import mirrored

AT_ONCE = 64
"""Number of loads for each solution, which limits the memory."""


class RigidPiston(NamedTuple):
    """Mass properties of a piston about A, and the edges of its skirt.

    piston_mass [kg]; piston_centre : x, y from A [m]; piston_inertia : about A and z [kg m2];
    edges above A [m].
    """

    piston_mass: float
    piston_centre: np.ndarray
    piston_inertia: float
    skirt_lower: float
    skirt_upper: float


class Compliance(NamedTuple):
    """Compliance of skirt and bore for n cells of the film grid.

    m cells and k columns are on one side of the plane of motion (`mirrored`). The bore has s
    stations.

    Parameters
    ----------
    piston : RigidPiston
    skirt : ndarray, shape (m, m)
        Inward displacement of the skirt per nodal pressure force on both sides [m/N].
    skirt_inertia : ndarray, shape (n,)
        Inward displacement of the skirt per acceleration of A along +y [s2].
    skirt_gas : ndarray, shape (n,)
        Inward displacement of the skirt per force of the gas on the crown [m/N].
    bore : ndarray, shape (k, s, k, s)
        Outward displacement of the bore per radial force on both sides [m/N].
    stations : ndarray, shape (s,)
        Heights above the crank axis [m].
    """

    piston: RigidPiston
    skirt: np.ndarray
    skirt_inertia: np.ndarray
    skirt_gas: np.ndarray
    bore: np.ndarray
    stations: np.ndarray


def compliance(options: dict[str, Any], folder: Path) -> Compliance:
    """Return the compliance of both bodies of a build table.

    Parameters
    ----------
    options, folder
        As for `build.prepare`; pin bores and bolts are fixed rigidly (tie "rbe2").
    """
    build = read_options(options, folder)
    model, position = _piston(build)
    piston = _rigid(build, model, position)
    around, along = build.grid
    angle, height = cell_centres(around, along, piston.skirt_lower, piston.skirt_upper)
    radial = film_surface(model.mesh, "skirt", angle, height).reading.radial
    elastic = Elastic(model.K, model.M, model.mesh.nodes("pin_bore"))
    upward = np.tile([0.0, 1.0, 0.0], len(position))
    weight = (model.M @ upward)[elastic.free]
    gas = face_load(model.mesh.points, model.mesh.faces["crown"])
    gas = (gas / gas[:, 1].sum()).ravel()[elastic.free]  # 1 N along +y
    reading = radial[:, elastic.free]
    bore, stations = _bore(build)
    return Compliance(
        piston,
        _answers(elastic, reading, around),
        reading @ elastic.solve(weight),
        reading @ elastic.solve(gas),
        bore,
        stations,
    )


def rigid_piston(options: dict[str, Any], folder: Path) -> RigidPiston:
    """Return the mass properties of a build table's piston; arguments as for `compliance`."""
    build = read_options(options, folder)
    return _rigid(build, *_piston(build))


def _piston(build):
    """Return the full model of the piston, and its nodes from A."""
    mesh = read_body(build.piston, _say_nothing)
    model = full_model(mesh, build.piston, _say_nothing)
    return model, model.mesh.points - np.array([build.piston.pin_offset, 0.0, 0.0])


def _rigid(build, model, position):
    lower, upper = ends(model.mesh, "skirt", build.piston.skirt_lower, build.piston.skirt_upper)
    weight = model.M @ np.tile([1.0, 1.0, 1.0], len(position))
    weight = weight.reshape(-1, 3)
    mass = float(weight[:, 1].sum())
    centre = (weight * position).sum(axis=0)[:2] / mass
    arm = (position * [1.0, 1.0, 0.0]).ravel()
    return RigidPiston(mass, centre, float(arm @ (model.M @ arm)), lower, upper)


def _say_nothing(text):
    pass


def _bore(build: Build):
    around, _ = build.grid
    mesh = read_body(build.block, _say_nothing)
    _, K, M = full_model(mesh, build.block, _say_nothing)
    lower, upper = ends(mesh, "bore", build.block.bore_lower, build.block.bore_upper)
    stations = np.linspace(lower, upper, build.block.stations)
    angle, _ = cell_centres(around, 1, 0.0, 1.0)
    radial = film_surface(mesh, "bore", angle, stations).reading.radial
    elastic = Elastic(K, M, mesh.nodes("bolts"))
    of_half = _answers(elastic, radial[:, elastic.free], around)
    columns = len(of_half) // len(stations)
    return of_half.reshape((columns, len(stations)) * 2), stations


def _answers(elastic, reading, around):
    """Return R K^-1 R^T of loads with their mirror images."""
    orbits, chosen = mirrored(around, reading.shape[0] // around)
    loads = reading.T @ orbits
    out = np.empty((len(chosen),) * 2)
    for first in range(0, len(chosen), AT_ONCE):
        some = slice(first, first + AT_ONCE)
        out[:, some] = reading[chosen] @ elastic.solve(loads[:, some].toarray())
    return out
