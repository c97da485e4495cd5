"""Offline: a mesh and a material in, a small exact body out."""

import hashlib
import json
from pathlib import Path

import numpy as np

from .bases import (Elastic, MeanElastic, characteristic_constraint_modes, craig_bampton, expected_pressure,
                    mean_conditions, orthonormal_modes, pressure_modes, rigid_motions)
from .faces import face_load, surface_matrix
from .finite_element import consistent_mass, each_direction, stiffness
from .mesh import read_mesh
from .surface import cell_centres, interpolation, radial_and_axial
from .symmetry import symmetric_modes

VERSION = 8       # part of the cache key: raise it when the numbers in the .npz change their meaning
Z = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])     # e_z x
P = np.diag([1.0, 1.0, 0.0])                                           # projection onto the plane of motion


def floating_frame_integrals(M, position, modes):
    """Everything that the inertia of a flexible body needs in planar motion, from its consistent mass matrix.

    Eq. (I1):  m = 1^T M 1,  S = E^T M r,  I0 = r^T M P r,  T = E^T M Phi,  b = Phi^T M P r,  B = Phi^T M P Phi,
               g = Phi^T M Z r,  G = Phi^T M Z Phi          Z = e_z x,  P: projection onto x, y,  E: unit motions along x and y

    Parameters
    ----------
    M : scipy.sparse matrix, shape (3 n, 3 n)
        Mass [kg].
    position : ndarray, shape (n, 3)
        Nodes in the body frame, origin at A [m].
    modes : ndarray, shape (n, 3, k)
        Mode shapes in the body frame [kg^-1/2].

    Returns
    -------
    dict
        mass [kg], S (2,) [kg m], I0 [kg m2], T (2, k), b (k,), B (k, k), g (k,), G (k, k), in the units that follow.

    References
    ----------
    [Shabana2013] ch. 5. Checked against a differentiated Lagrangian in tests/mfbd/test_floating_frame.py.
    """
    flat = modes.reshape(3 * len(position), modes.shape[2])
    unit = np.tile(np.eye(3)[:, :2], (len(position), 1))
    turned = np.einsum("ab,nbk->nak", Z, modes).reshape(flat.shape)
    planar = np.einsum("ab,nbk->nak", P, modes).reshape(flat.shape)
    arm, turn = (position @ P).ravel(), (position @ Z.T).ravel()
    heavy, modal = M @ unit, flat.T @ M
    # Eq. (I1)
    return {"mass": float(unit[:, 0] @ heavy[:, 0]), "S": heavy.T @ position.ravel(), "I0": float(arm @ (M @ arm)),
            "T": heavy.T @ flat, "b": modal @ arm, "g": modal @ turn, "B": modal @ planar, "G": modal @ turned}


def reduce_piston(options, grid, progress=print):
    """Reduced piston: mass properties, modes and their values on the skirt grid.

    Parameters
    ----------
    options : dict
        mesh (path), mesh_unit [m], axes, origin, surfaces (see `read_mesh`), density, young, poisson, basis, modes, modes_off,
        tie, skirt_lower, skirt_upper [m above A, None: the mesh's], pin_offset [m].
    grid : (int, int)
        Cells around and along the skirt.
    progress : callable
        Takes a sentence now and then.

    Returns
    -------
    dict of ndarray
        `floating_frame_integrals` and omega (k,) [rad/s], kind (k,) (see `symmetry`), gas_force (k,) [N/Pa scaled to a unit
        total], radial, axial (grid points, k) [kg^-1/2], radius [m]; without modes, arrays of zero columns.
    """
    mesh = _mesh(options, ("skirt", "crown", "pin_bore"), progress)
    low, high = _ends(mesh, "skirt", options["skirt_lower"], options["skirt_upper"])
    M = consistent_mass(mesh.points, mesh.tets, options["density"])
    position = mesh.points - np.array([options["pin_offset"], 0.0, 0.0])
    radius = float(np.hypot(*mesh.points[mesh.nodes("skirt")][:, [0, 2]].T).mean())
    angle, height = cell_centres(*grid, low, high)
    radial, axial = radial_and_axial(interpolation(mesh.points, mesh.faces["skirt"], angle, height, radius), angle, grid[1])
    gas = face_load(mesh.points, mesh.faces["crown"])
    gas /= -gas[:, 1].sum()                                             # unit resultant along -y
    inertia = [np.tile([0.0, 1.0, 0.0], (len(position), 1)), np.tile([1.0, 0.0, 0.0], (len(position), 1)), position @ Z.T]
    loads = np.column_stack([gas.ravel()] + [M @ field.ravel() for field in inertia])
    modes, omega, kind = _modes(mesh, M, options, "pin_bore", "skirt", radial, expected_pressure(angle, grid[1]), loads, progress)
    return floating_frame_integrals(M, position, modes.reshape(len(position), 3, len(omega))) | {
        "omega": omega, "kind": kind, "gas_force": modes.T @ gas.ravel(), "radial": radial @ modes, "axial": axial @ modes,
                                                                                                 "radius": radius,
                                                                                                 "skirt_lower": low,
                                                                                                 "skirt_upper": high,
        "angles": grid[0], "points": position, "tets": mesh.tets, "shapes": modes.reshape(len(position), 3, len(omega))}


def reduce_block(options, grid, progress=print):
    """Reduced cylinder block: modes and their values on a table of the bore (angles of the film grid x `stations` heights).

    Parameters
    ----------
    options : dict
        mesh (path), mesh_unit [m], axes, origin, surfaces (see `read_mesh`), density, young, poisson, basis, modes, modes_off,
        tie, spring_stiffness [N/m], bore_lower, bore_upper [m above the crank axis, None: the mesh's], stations.
    grid : (int, int)
        Film grid; its angles are the table's.
    progress : callable

    Returns
    -------
    dict of ndarray
        omega (k,) [rad/s], kind (k,), radial, axial (angles, stations, k) [kg^-1/2], heights (stations,) [m], radius [m], mass
        [kg].
    """
    mesh = _mesh(options, ("bore", "bolts"), progress)
    M = consistent_mass(mesh.points, mesh.tets, options["density"])
    radius = float(np.hypot(*mesh.points[mesh.nodes("bore")][:, [0, 2]].T).mean())
    angle, _ = cell_centres(*grid, 0.0, 1.0)
    heights = np.linspace(*_ends(mesh, "bore", options["bore_lower"], options["bore_upper"]), options["stations"])
    radial, axial = radial_and_axial(interpolation(mesh.points, mesh.faces["bore"], angle, heights, radius), angle, len(heights))
    modes, omega, kind = _modes(mesh, M, options, "bolts", "bore", radial, expected_pressure(angle, len(heights)),
                                np.empty((3 * len(mesh.points), 0)), progress)
    table = (grid[0], len(heights), len(omega))
    return {"omega": omega, "kind": kind, "radial": (radial @ modes).reshape(table), "axial": (axial @ modes).reshape(table),
            "heights": heights, "radius": radius, "mass": float(M.sum()) / 3, "angles": grid[0], "points": mesh.points,
            "tets": mesh.tets,
            "shapes": modes.reshape(len(mesh.points), 3, len(omega))}


def _mesh(options, names, progress):
    """Mesh of a body with the named surfaces."""
    surfaces = dict.fromkeys(names) | options["surfaces"]
    return read_mesh(options["mesh"], surfaces, options["mesh_unit"], options["axes"], options["origin"], progress)


def _ends(mesh, name, low, high):
    """Lowest and highest height of a surface [m], unless given."""
    height = mesh.points[mesh.nodes(name), 1]
    return float(height.min() if low is None else low), float(height.max() if high is None else high)


def _modes(mesh, M, options, held, surface, radial, weight, loads, progress):
    """Mode shapes on all degrees of freedom, their angular frequencies and symmetry classes, by the chosen basis.

    `held` names the surface that ties the body to its frame, `surface` the one that the film touches.
    """
    count = options["modes"]
    if count == 0:
        return np.empty((3 * len(mesh.points), 0)), np.empty(0), np.empty(0, dtype=int)
    progress(f"factorising {3 * len(mesh.points)} degrees of freedom")
    K = stiffness(mesh.points, mesh.tets, options["young"], options["poisson"])
    body = _held(mesh, K, M, held, options)
    progress(f"{count} modes, basis {options['basis']}")
    if options["basis"] == "craig_bampton":
        shapes = craig_bampton(body, count)
    elif options["basis"] == "characteristic_constraint_modes":
        shapes = characteristic_constraint_modes(body, mesh.nodes(surface), count)
    else:
        shapes = pressure_modes(body, radial[:, body.free], weight, count, loads[body.free])
    modes, omega = orthonormal_modes(body, shapes)
    modes, omega, kind = symmetric_modes(body, body.full(modes), omega, mesh.points)
    kept = np.setdiff1d(np.arange(count), np.asarray(options["modes_off"], dtype=int) - 1)
    return modes[:, kept], omega[kept], kind[kept]


def _held(mesh, K, M, surface, options):
    """The body tied to its frame: rigidly, by mean motions, or on springs."""
    tie = options["tie"]
    if tie == "rbe2":
        return Elastic(K, M, mesh.nodes(surface))
    area = surface_matrix(mesh.points, mesh.faces[surface])
    if tie == "springs":
        spread = area * (options["spring_stiffness"] / area.sum())
        return Elastic(K + each_direction(spread), M, np.empty(0, dtype=int))
    share = np.asarray(area.sum(axis=1)).ravel()
    bosses = [share * (mesh.points[:, 2] > 0), share * (mesh.points[:, 2] < 0)] if tie == "rbe3_per_boss" else [share]
    return MeanElastic(K, M, mean_conditions(mesh.points, bosses), rigid_motions(mesh.points))


def cached(reduce, options, grid, folder, progress=print):
    """Path of the reduced body's .npz, made unless one of the same mesh bytes, options and code version lies in `folder`.

    The file is written under another name and moved into place, so that an interrupted run leaves nothing half-written.
    """
    content = hashlib.sha256(Path(options["mesh"]).read_bytes()).hexdigest()
    what = {k: v for k, v in options.items() if k != "mesh"} | {"grid": list(grid), "mesh": content, "version": VERSION,
                                                                "of": reduce.__name__}
    key = hashlib.sha256(json.dumps(what, sort_keys=True).encode()).hexdigest()[:24]
    path = Path(folder) / f"{reduce.__name__.removeprefix('reduce_')}-{key}.npz"
    if not path.exists():
        body = reduce(options, grid, progress)
        path.parent.mkdir(parents=True, exist_ok=True)
        _save(shapes_file(path), {name: body.pop(name) for name in ("points", "tets", "shapes")})
        _save(path, body)
    return path


def shapes_file(path):
    """The file beside a reduced body that holds its mesh and mode shapes: for pictures and recovery, not for the FMU."""
    return path.with_name(path.stem + "-shapes.npz")


def _save(path, arrays):
    partial = path.with_suffix(".partial.npz")
    np.savez(partial, **arrays)
    partial.replace(path)
