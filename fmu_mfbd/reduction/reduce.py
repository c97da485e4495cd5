"""Offline: a mesh and a material in, or a mesh and its matrices, a small exact body out."""

import hashlib
import json
import resource
import time
from pathlib import Path

import numpy as np
import scipy.sparse as sp

from ..finite_elements.element import consistent_mass, each_direction, rigid_motions, stiffness
from ..finite_elements.faces import face_load, surface_matrix
from ..finite_elements.matrices import matrix_faults, node_labels, read_matrix
from ..finite_elements.mesh import MeshFault, read_mesh, turn_of
from ..finite_elements.point_cloud import read_nodes
from ..finite_elements.solver import Remembering, factorise
from ..geometry.grid import cell_centres
from .bases import (
    Elastic,
    MeanElastic,
    characteristic_constraint_modes,
    craig_bampton,
    expected_pressure,
    mean_conditions,
    orthonormal_modes,
    pressure_modes,
)
from .interpolation import interpolation, radial_and_axial
from .symmetry import symmetric_modes

VERSION = 9  # part of the cache key: raise it when the numbers in the .npz change their meaning
Z = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])  # e_z x
P = np.diag([1.0, 1.0, 0.0])  # projection onto the plane of motion


def floating_frame_integrals(M, position, modes):
    """Everything that the inertia of a flexible body needs in planar motion, from its consistent
    mass matrix.

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
        mass [kg], S (2,) [kg m], I0 [kg m2], T (2, k), b (k,), B (k, k), g (k,), G (k, k), in the
        units that follow.

    References ---------- [Shabana2013] ch. 5. Checked against a differentiated Lagrangian in
    tests/mfbd/test_floating_frame.py.
    """
    flat = modes.reshape(3 * len(position), modes.shape[2])
    unit = np.tile(np.eye(3)[:, :2], (len(position), 1))
    turned = np.einsum("ab,nbk->nak", Z, modes).reshape(flat.shape)
    planar = np.einsum("ab,nbk->nak", P, modes).reshape(flat.shape)
    arm, turn = (position @ P).ravel(), (position @ Z.T).ravel()
    heavy, modal = M @ unit, flat.T @ M
    # Eq. (I1)
    return {
        "mass": float(unit[:, 0] @ heavy[:, 0]),
        "S": heavy.T @ position.ravel(),
        "I0": float(arm @ (M @ arm)),
        "T": heavy.T @ flat,
        "b": modal @ arm,
        "g": modal @ turn,
        "B": modal @ planar,
        "G": modal @ turned,
    }


FILES = ("mesh", "stiffness", "mass")
"""Options that name a file."""


def reduce_piston(options, grid, progress=print, factors=factorise):
    """Reduced piston: mass properties, modes and their values on the skirt grid.

    Parameters
    ----------
    options : dict
        mesh (path), mesh_unit [m], axes, origin, surfaces (see `read_mesh`), density, young,
        poisson, or stiffness, mass (paths), stiffness_unit [N/m], mass_unit [kg]; basis, modes,
        modes_off, tie, skirt_lower, skirt_upper [m above A, None: the mesh's], pin_offset [m].
    grid : (int, int)
        Cells around and along the skirt.
    progress : callable
        Takes a sentence now and then.
    factors : callable
        Factorises a matrix (`solver`).

    Returns
    -------
    dict of ndarray
        `floating_frame_integrals` and omega (k,) [rad/s], kind (k,) (see `symmetry`), gas_force
        (k,) [N/Pa scaled to a unit total], radial, axial (grid points, k) [kg^-1/2], radius [m];
        without modes, arrays of zero columns. And `anatomy`.
    """
    mesh, K, M = full_model(options, ("skirt", "crown", "pin_bore"), progress)
    low, high = _ends(mesh, "skirt", options["skirt_lower"], options["skirt_upper"])
    position = mesh.points - np.array([options["pin_offset"], 0.0, 0.0])
    angle, height = cell_centres(*grid, low, high)
    radius, radial, axial = _film_surface(mesh, "skirt", angle, height)
    gas = face_load(mesh.points, mesh.faces["crown"])
    gas /= -gas[:, 1].sum()  # unit resultant along -y
    inertia = [
        np.tile([0.0, 1.0, 0.0], (len(position), 1)),
        np.tile([1.0, 0.0, 0.0], (len(position), 1)),
        position @ Z.T,
    ]
    loads = np.column_stack([gas.ravel()] + [M @ field.ravel() for field in inertia])
    faults_of_modes(mesh, options, "pin_bore", "skirt", len(angle) * len(height))
    body = _held(mesh, K, M, "pin_bore", options, factors)
    del K  # the body holds what of it is needed
    modes, omega, kind = _modes(
        mesh, body, options, "skirt", radial, expected_pressure(angle, grid[1]), loads, progress
    )
    shapes = modes.reshape(len(position), 3, len(omega))
    return (
        floating_frame_integrals(M, position, shapes)
        | {
            "omega": omega,
            "kind": kind,
            "gas_force": modes.T @ gas.ravel(),
            "radial": radial @ modes,
            "axial": axial @ modes,
            "radius": radius,
            "skirt_lower": low,
            "skirt_upper": high,
        }
        | anatomy(mesh, position, M, shapes, options, grid)
    )


def reduce_block(options, grid, progress=print, factors=factorise):
    """Reduced cylinder block: modes and their values on a table of the bore (angles of the film
    grid x `stations` heights).

    Parameters
    ----------
    options : dict
        As for `reduce_piston`, but spring_stiffness [N/m], bore_lower, bore_upper [m above the
        crank axis, None: the mesh's], stations.
    grid : (int, int)
        Film grid; its angles are the table's.
    progress, factors : callable

    Returns
    -------
    dict of ndarray
        omega (k,) [rad/s], kind (k,), radial, axial (angles, stations, k) [kg^-1/2], heights
        (stations,) [m], radius [m]. And `anatomy`.
    """
    mesh, K, M = full_model(options, ("bore", "bolts"), progress)
    angle, _ = cell_centres(*grid, 0.0, 1.0)
    heights = np.linspace(
        *_ends(mesh, "bore", options["bore_lower"], options["bore_upper"]), options["stations"]
    )
    radius, radial, axial = _film_surface(mesh, "bore", angle, heights)
    faults_of_modes(mesh, options, "bolts", "bore", len(angle) * len(heights))
    body = _held(mesh, K, M, "bolts", options, factors)
    del K
    modes, omega, kind = _modes(
        mesh,
        body,
        options,
        "bore",
        radial,
        expected_pressure(angle, len(heights)),
        np.empty((3 * len(mesh.points), 0)),
        progress,
    )
    table, shapes = (
        (grid[0], len(heights), len(omega)),
        modes.reshape(len(mesh.points), 3, len(omega)),
    )
    return {
        "omega": omega,
        "kind": kind,
        "radial": (radial @ modes).reshape(table),
        "axial": (axial @ modes).reshape(table),
        "heights": heights,
        "radius": radius,
    } | anatomy(mesh, mesh.points, M, shapes, options, grid)


def anatomy(mesh, position, M, shapes, options, grid):
    """What a reduced body keeps for reports, pictures and recovery; no FMU carries it.

    Eq. (I2):  rigid_mass = R^T M R      R the six rigid motions about the body's origin
    """
    rigid = rigid_motions(position)
    return {
        "rigid_mass": rigid.T @ (M @ rigid),
        "angles": grid[0],
        "points": position,
        "tets": mesh.tets,  # Eq. (I2)
        "skin": mesh.skin(),
        "shapes": shapes,
        "young": options["young"] or np.nan,
        "poisson": np.nan if options["poisson"] is None else options["poisson"],
    }


def full_model(options, names, progress):
    """Mesh of a body with the named surfaces, its stiffness and its mass, from elements or from
    files.

    Returns
    -------
    Mesh, K, M
        [m], [N/m], [kg], matrices of shape (3 n, 3 n).

    Raises
    ------
    MeshFault
        What is wrong with mesh or matrices.
    """
    surfaces, path = dict.fromkeys(names) | options["surfaces"], Path(options["mesh"])
    where = options["mesh_unit"], options["axes"], options["origin"]
    if path.suffix == ".csv":
        mesh, labels = read_nodes(path, surfaces, *where)
    else:
        mesh = read_mesh(path, surfaces, *where, progress)
        labels = None
    if options["stiffness"] is None:
        progress(f"assembling {3 * len(mesh.points)} degrees of freedom")
        return (
            mesh,
            stiffness(mesh.points, mesh.tets, options["young"], options["poisson"]),
            consistent_mass(mesh.points, mesh.tets, options["density"]),
        )
    if labels is None:
        if mesh.row is None:
            raise MeshFault(
                [f"{path}: matrices need the nodes they belong to; this mesh has linear tetrahedra"]
            )
        labels = node_labels(path, mesh.row.max() + 1)[mesh.row]
    progress(f"reading matrices of {3 * len(mesh.points)} degrees of freedom")
    turn = sp.kron(sp.identity(len(mesh.points)), turn_of(options["axes"]), format="csr")
    K, M = (
        turn @ (read_matrix(options[name], labels) * options[f"{name}_unit"]) @ turn.T
        for name in ("stiffness", "mass")
    )
    if faults := matrix_faults(mesh, K, M, Path(options["stiffness"]).name):
        raise MeshFault(faults)
    return mesh, K, M


def _film_surface(mesh, name, angle, height):
    """Mean radius of a cylindrical surface [m], and the operators that read it on a grid
    (`radial_and_axial`).
    """
    radius = float(np.hypot(*mesh.points[mesh.nodes(name)][:, [0, 2]].T).mean())
    return radius, *radial_and_axial(
        interpolation(mesh.points, mesh.faces[name], angle, height, radius), angle, len(height)
    )


def _ends(mesh, name, low, high):
    """Lowest and highest height of a surface [m], unless given; those must lie on it, but for a
    hundredth of its length.
    """
    height = mesh.points[mesh.nodes(name), 1]
    least, most = float(height.min()), float(height.max())
    low, high, slack = (
        least if low is None else low,
        most if high is None else high,
        (most - least) / 100,
    )
    if low < least - slack or high > most + slack:
        raise MeshFault(
            [
                f"{name}_lower, {name}_upper = {low:g}, {high:g} m: surface '{name}' reaches from {least:g} to "
                f"{most:g} m"
            ]
        )
    return low, high


def _modes(mesh, body, options, surface, radial, weight, loads, progress):
    """Mode shapes on all degrees of freedom, their angular frequencies and symmetry classes, by the
    chosen basis.

    `surface` names the one that the film touches.
    """
    count = options["modes"]
    if count == 0:
        return np.empty((3 * len(mesh.points), 0)), np.empty(0), np.empty(0, dtype=int)
    progress(f"{count} modes, basis {options['basis']}")
    if options["basis"] == "craig_bampton":
        shapes = craig_bampton(body, count)
    elif options["basis"] == "characteristic_constraint_modes":
        shapes = characteristic_constraint_modes(body, mesh.nodes(surface), count)
    else:
        shapes = pressure_modes(body, radial[:, body.free], weight, count, loads[body.free])
    body.forget_factors()
    modes, omega = orthonormal_modes(body, shapes)
    modes, omega, kind = symmetric_modes(body, body.full(modes), omega, mesh.points)
    kept = np.setdiff1d(np.arange(count), np.asarray(options["modes_off"], dtype=int) - 1)
    return modes[:, kept], omega[kept], kind[kept]


def faults_of_modes(mesh, options, held, surface, grid_points):
    """Refuse, before anything is factorised, supports that let the body move and more modes than
    there are shapes.

    Raises
    ------
    MeshFault
        Names the surface, or the number of modes that can be.
    """
    count, faults = options["modes"], []
    loose = 6 - np.linalg.matrix_rank(
        rigid_motions(mesh.points[mesh.nodes(held)] - mesh.points.mean(axis=0)), tol=1e-9
    )
    if loose:
        faults.append(
            f"surface '{held}' has {len(mesh.nodes(held))} nodes that leave the body {loose} rigid motions"
        )
    most = {
        "craig_bampton": 3 * (len(mesh.points) - len(mesh.nodes(held))) - 2,
        "characteristic_constraint_modes": 3
        * len(np.setdiff1d(mesh.nodes(surface), mesh.nodes(held)))
        - 2,
        "pressure_modes": grid_points - 2,
    }[options["basis"]]
    if count > most:
        faults.append(
            f"modes = {count}: {options['basis']} of this body on this grid gives at most {most}"
        )
    if count and faults:
        raise MeshFault(faults)


def _held(mesh, K, M, surface, options, factors):
    """The body tied to its frame by the named surface: rigidly, by mean motions, or on springs;
    None for a rigid body.
    """
    tie = options["tie"]
    if not options["modes"]:
        return None
    if tie == "rbe2":
        return Elastic(K, M, mesh.nodes(surface), factors)
    area = surface_matrix(mesh.points, mesh.faces[surface])
    if tie == "springs":
        spread = area * (options["spring_stiffness"] / area.sum())
        return Elastic(K + each_direction(spread), M, np.empty(0, dtype=int), factors)
    share = np.asarray(area.sum(axis=1)).ravel()
    bosses = (
        [share * (mesh.points[:, 2] > 0), share * (mesh.points[:, 2] < 0)]
        if tie == "rbe3_per_boss"
        else [share]
    )
    return MeanElastic(
        K, M, mean_conditions(mesh.points, bosses), rigid_motions(mesh.points), factors
    )


def cached(reduce, options, grid, folder, progress=print):
    """Path of the reduced body's .npz, made unless one of the same file contents, options and code
    version lies in `folder`.

    The file is written under another name and moved into place, so that an interrupted run leaves
    nothing half-written; the solutions it had found wait in `folder` for the next try. It also
    holds what making it cost: seconds, peak_memory [bytes] of the process.
    """
    content = {
        key: hashlib.sha256(Path(options[key]).read_bytes()).hexdigest()
        for key in FILES
        if options[key]
    }
    what = options | content | {"grid": list(grid), "version": VERSION, "of": reduce.__name__}
    key = hashlib.sha256(json.dumps(what, sort_keys=True).encode()).hexdigest()[:24]
    path = Path(folder) / f"{reduce.__name__.removeprefix('reduce_')}-{key}.npz"
    if not path.exists():
        begin, factors = time.perf_counter(), Remembering(Path(folder) / "unfinished", progress)
        body = reduce(options, grid, progress, factors)
        save(
            path,
            body
            | {
                "seconds": time.perf_counter() - begin,
                "peak_memory": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024,
            },
        )
        factors.forget()
    return path


def save(path, arrays):
    """Write an .npz in one go."""
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_suffix(".partial.npz")
    np.savez(partial, **arrays)
    partial.replace(path)
