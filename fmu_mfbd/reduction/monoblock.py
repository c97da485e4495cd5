"""Reduction of a block with several cylinders to rigid motion and modes of all its bores.

The block is free in space. The modes have no momentum: the rigid motion is that of the mean frame,
and only the mounts couple rigid motion and modes.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from ..finite_elements.element import Sparse, each_direction, rigid_motions
from ..finite_elements.faces import surface_matrix
from ..finite_elements.matrices import FullModel, assembled
from ..finite_elements.mesh import Mesh, MeshFault
from ..geometry.grid import cell_centres
from .bases import (
    MeanElastic,
    craig_bampton,
    expected_pressure,
    of_unit_energy,
    orthonormal_modes,
    pressure_modes,
)
from .interpolation import SurfaceReading
from .reduce import film_surface
from .reduced_body import ReducedMonoblock

Say = Callable[[str], None]
BORE_TOLERANCE = 1e-3
"""Largest error of the bores' position and length in the mesh, relative to the radius."""


class Plan(NamedTuple):
    """Options of the reduction of a block with several cylinders.

    Parameters
    ----------
    cylinder_z : sequence of float
        z of each bore's axis at x = 0 from the middle of the crank axis [m].
    bearings, mounts : int
        Numbers of surfaces bearing_1, ... and mount_1, ...
    grid : (int, int)
        Angles and heights of every bore's fields.
    lower, upper : float
        Ends of the bores above the crank axis [m].
    free_modes, modes : int
        Number of lowest free modes in the basis, and of all modes.
    """

    cylinder_z: Sequence[float]
    bearings: int
    mounts: int
    grid: tuple[int, int]
    lower: float
    upper: float
    free_modes: int
    modes: int

    def surfaces(self) -> list[str]:
        """Return the names of all surfaces that the mesh must have."""
        counts = (len(self.cylinder_z), "bore"), (self.bearings, "bearing"), (self.mounts, "mount")
        numbered = [f"{name}_{k}" for count, name in counts for k in range(1, count + 1)]
        return [*numbered, "deck"]


class Readings(NamedTuple):
    """Matrices with 3 n columns that read displacements and distribute forces.

    Parameters
    ----------
    bores : sequence of SurfaceReading
    deck : ndarray, shape (cylinders, 3 n)
        Mean motion along y of the deck around each cylinder.
    bearing : ndarray, shape (cylinders, 2, 3 n)
        Motion along x and y of the bearings of the crank at each cylinder.
    mount : ndarray, shape (mounts, 3, 3 n)
    mount_place : ndarray, shape (mounts, 3)
        Position of each mount [m].
    radius : float
        Radius of the bores [m].
    """

    bores: list[SurfaceReading]
    deck: np.ndarray
    bearing: np.ndarray
    mount: np.ndarray
    mount_place: np.ndarray
    radius: float


def free_block(
    mesh: Mesh, material: tuple[float, float, float], head_mass: float, crank_mass: float
) -> FullModel:
    """Return the matrices of a block with the masses of head and crank, which have no stiffness.

    Eq. (J40):  M = M_block + sum_s (m_s/A_s) int N_i N_j dA,   s: deck, all bearings

    Parameters
    ----------
    mesh : Mesh
    material : (float, float, float)
        Young's modulus [Pa], Poisson's ratio [-], density [kg/m3].
    head_mass, crank_mass : float
        [kg]
    """
    _, K, M = assembled(mesh, *material)
    bearings = [faces for name, faces in mesh.faces.items() if name.startswith("bearing")]
    for faces, mass in ((mesh.faces["deck"], head_mass), (np.vstack(bearings), crank_mass)):
        area = surface_matrix(mesh.points, faces)
        M = M + each_direction(area * (mass / area.sum()))  # Eq. (J40)
    return FullModel(mesh, K, M)


def inertia_relief(body: FullModel) -> MeanElastic:
    """Return the body free in space, whose deflections have no momentum.

    Eq. (J41):  K u + M R lambda = f,   R^T M u = 0       R its rigid motions: Eq. (J5), C = R^T M
    """
    rigid = rigid_motions(body.mesh.points)
    return MeanElastic(body.K, body.M, (body.M @ rigid).T, rigid)  # Eq. (J41)


def readings(mesh: Mesh, plan: Plan) -> Readings:
    """Return the matrices of all forces and fields.

    Raises
    ------
    MeshFault
        If bores are not at the positions of the plan.
    """
    angle, _ = cell_centres(plan.grid[0], 1, 0.0, 1.0)
    heights = np.linspace(plan.lower, plan.upper, plan.grid[1])
    bores, radii, faults = [], [], []
    for k, z in enumerate(plan.cylinder_z, 1):
        shifted = replace(mesh, points=mesh.points - np.array([0.0, 0.0, z]))
        name = f"bore_{k}"
        faults += _bore_faults(shifted, name, plan)
        surface = film_surface(shifted, name, angle, heights)
        bores.append(surface.reading)
        radii.append(surface.radius)
    if np.ptp(radii) > BORE_TOLERANCE * radii[0]:
        faults.append(f"bores: expected equal radii, got {', '.join(f'{r:g} m' for r in radii)}")
    if faults:
        raise MeshFault(faults)
    along = np.array([_mean(mesh, f"bearing_{k}") for k in range(1, plan.bearings + 1)])
    bearing_z = along @ mesh.points[:, 2]
    share = np.array([bearing_shares(z, bearing_z) for z in plan.cylinder_z])
    mounts = np.array([_mean(mesh, f"mount_{k}") for k in range(1, plan.mounts + 1)])
    return Readings(
        bores=bores,
        deck=_directed(_deck_parts(mesh, plan.cylinder_z))[:, 1],
        bearing=_directed(share @ along)[:, :2],
        mount=_directed(mounts),
        mount_place=mounts @ mesh.points,
        radius=float(np.mean(radii)),
    )


def _bore_faults(mesh: Mesh, name: str, plan: Plan) -> list[str]:
    """Return the faults of a bore whose axis is at z = 0."""
    x, y, z = mesh.points[mesh.nodes(name)].T
    radius = np.hypot(x, z)
    slack = BORE_TOLERANCE * radius.mean()
    if np.ptp(radius) > slack:
        return [
            f"{name}: expected a cylinder about the axis of cylinder_z, got radii of "
            f"{radius.min():g} to {radius.max():g} m"
        ]
    if plan.lower < y.min() - slack or plan.upper > y.max() + slack:
        return [
            f"bore_lower, bore_upper: expected within {name}, {y.min():g} to {y.max():g} m, got "
            f"{plan.lower:g}, {plan.upper:g} m"
        ]
    return []


def bearing_shares(z: float, bearing_z: np.ndarray) -> np.ndarray:
    """Return the shares of the bearings at `bearing_z` in a force at z.

    The two adjacent bearings share it by the lever rule. Beyond the last bearing, the nearest one
    carries it.

    Returns
    -------
    ndarray, shape (bearings,)
        Sum 1 [-].
    """
    order = np.argsort(bearing_z)
    unit = np.eye(len(bearing_z))[order]
    return np.array([np.interp(z, bearing_z[order], column) for column in unit.T])


def _mean(mesh: Mesh, name: str) -> np.ndarray:
    """Return the weights of the nodes in the mean over a surface, (n,), sum 1."""
    return _weights(mesh, mesh.faces[name])


def _weights(mesh: Mesh, faces: np.ndarray) -> np.ndarray:
    area = np.asarray(surface_matrix(mesh.points, faces).sum(axis=1)).ravel()
    return area / area.sum()


def _deck_parts(mesh: Mesh, cylinder_z: Sequence[float]) -> np.ndarray:
    """Return the weights of the mean over the deck nearest to each cylinder, (cylinders, n)."""
    faces = mesh.faces["deck"]
    middle = mesh.points[faces[:, :3], 2].mean(axis=1)
    nearest = np.abs(middle[:, None] - np.array(cylinder_z)).argmin(axis=1)
    return np.array([_weights(mesh, faces[nearest == k]) for k in range(len(cylinder_z))])


def _directed(weights: np.ndarray) -> np.ndarray:
    """Return rows that read x, y and z by weights of the nodes, (.., n) -> (.., 3, 3 n)."""
    return np.einsum("sn,ab->sanb", weights, np.eye(3)).reshape(len(weights), 3, -1)


def reduce_monoblock(body: FullModel, plan: Plan, progress: Say = print) -> ReducedMonoblock:
    """Reduce a block.

    Its shapes are the lowest free modes, deflections with inertia relief by forces on deck,
    bearings and mounts, and deflections by the pressures on the bores of the largest compliance.

    Parameters
    ----------
    body : FullModel
    plan : Plan
    progress : callable
        Prints a sentence.

    Raises
    ------
    MeshFault, ValueError
        If the mesh or the number of modes is wrong.
    """
    read = readings(body.mesh, plan)
    rigid = rigid_motions(body.mesh.points)
    size = body.K.shape[0]
    pushed = [one.reshape(-1, size) for one in (read.deck, read.bearing, read.mount)]
    rows = np.concatenate(pushed)
    progress(f"{plan.modes} modes of {size} degrees of freedom, free in space")
    elastic = inertia_relief(body)
    first = np.hstack([craig_bampton(elastic, plan.free_modes), elastic.solve(rows.T)])
    psi = of_unit_energy(elastic, first)
    radial: Sparse = sp.vstack([one.radial for one in read.bores], format="csr")
    angle, _ = cell_centres(plan.grid[0], 1, 0.0, 1.0)
    weight = np.tile(expected_pressure(angle, plan.grid[1]), len(read.bores))
    modes = orthonormal_modes(
        elastic, pressure_modes(elastic, radial, weight, plan.modes, psi, psi)
    )
    shapes, count = modes.shapes, plan.modes
    table = (len(read.bores), *plan.grid, count)
    return ReducedMonoblock(
        omega=modes.omega,
        radial=(radial @ shapes).reshape(table),
        deck=read.deck @ shapes,
        bearing=read.bearing @ shapes,
        mount=read.mount @ shapes,
        mount_place=read.mount_place,
        cylinder_z=np.array(plan.cylinder_z, dtype=float),
        rigid_mass=rigid.T @ (body.M @ rigid),  # Eq. (J8)
        heights=np.linspace(plan.lower, plan.upper, plan.grid[1]),
        radius=read.radius,
    )
