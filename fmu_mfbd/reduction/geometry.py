"""Checks of a mesh's position and direction in this project's axes.

x is thrust, y towards the head, z along the pin. The origin of a piston is on the skirt's axis at
the height of the pin, that of a block on the bore's axis at the height of the crank. The surfaces
show swapped axes, a wrong origin, or a wrong unit.
"""

from typing import NamedTuple

import numpy as np

from ..finite_elements.mesh import Mesh
from .reduced_body import offset_faults

SMALLEST_RADIUS, LARGEST_RADIUS = 5e-3, 0.6  # [m], from models to ships
LEAST_DENSITY, MOST_DENSITY = 100.0, 9000.0  # of a piston's mass in the cylinder around it [kg/m3]
OFF_AXIS = 0.01  # of the radius: how far a cylinder's axis may lie beside y
OUT_OF_ROUND = 0.02  # of the radius: profiles belong into the film
TILTED = np.radians(1.0)
TILTED_PATCHES = np.radians(5.0)  # of a pin on patches, whose nodes need not be symmetric
PIN_HEIGHT = 0.02  # of the skirt's radius: of the pin bore's axis above the origin
PIN_BY_CENTROID = 0.1  # likewise where the pin bore is no cylinder


class Circle(NamedTuple):
    """Circle through points of a plane: its centre, radius, and largest distance of a point [m]."""

    first: float
    second: float
    radius: float
    scatter: float


def circle_through(first: np.ndarray, second: np.ndarray) -> Circle:
    """Return the circle of least squares through points, in the squares of their distances.

    Eq. (M12):  u^2 + v^2 = 2 a u + 2 b v + c,   R^2 = c + a^2 + b^2
    """
    matrix = np.column_stack([2 * first, 2 * second, np.ones_like(first)])
    (a, b, c), *_ = np.linalg.lstsq(matrix, first**2 + second**2, rcond=None)  # Eq. (M12)
    radius = np.sqrt(c + a**2 + b**2)
    scatter = np.abs(np.hypot(first - a, second - b) - radius).max()
    return Circle(float(a), float(b), float(radius), float(scatter))


def area_normals(mesh: Mesh, name: str) -> np.ndarray:
    """Return the outward normals of a surface's faces with their areas as lengths [m2], (t, 3)."""
    corner = mesh.points[mesh.faces[name][:, :3]].swapaxes(0, 1)
    first, second, third = corner
    return np.cross(second - first, third - first) / 2


def axis_of(mesh: Mesh, name: str) -> np.ndarray:
    """Return the unit vector that is perpendicular to the normals of a cylinder, (3,)."""
    normal = area_normals(mesh, name)
    spread = (normal / np.linalg.norm(normal, axis=1)[:, None]).T @ normal
    _, directions = np.linalg.eigh(spread)
    return directions[:, 0]


def cylinder_faults(mesh: Mesh, name: str) -> list[str]:
    """Return the faults of skirt or bore as a cylinder about y."""
    axis = axis_of(mesh, name)
    if abs(axis[1]) < np.cos(TILTED):
        along = ", ".join(f"{part:.2f}" for part in axis)
        return [
            f"surface '{name}': expected an axis along y, got ({along}); set axes to the file's "
            "directions of thrust, head and pin"
        ]
    x, y, z = mesh.points[mesh.nodes(name)].T
    circle = circle_through(x, z)
    radius = circle.radius
    faults = []
    if np.hypot(circle.first, circle.second) > OFF_AXIS * radius:
        faults.append(
            f"surface '{name}': expected an axis at x = z = 0, got x = {1e3 * circle.first:.3g} "
            f"mm, z = {1e3 * circle.second:.3g} mm; set origin to a point of it"
        )
    if circle.scatter > OUT_OF_ROUND * radius:
        faults.append(
            f"surface '{name}': expected a cylinder, got nodes {1e3 * circle.scatter:.3g} mm off "
            f"a radius of {1e3 * radius:.4g} mm"
        )
    if not SMALLEST_RADIUS <= radius <= LARGEST_RADIUS:
        faults.append(
            f"surface '{name}': expected a radius of {SMALLEST_RADIUS:g} to {LARGEST_RADIUS:g} m, "
            f"got {radius:.3g} m; set mesh_unit, for example '1 mm'"
        )
    return faults


def axis_of_nodes(points: np.ndarray) -> np.ndarray:
    """Return the direction of a cylinder near z through nodes, of length 1, (3,).

    Eq. (M21):  x^2 + y^2 = 2 a z x + 2 b z y + 2 x_0 x + 2 y_0 y + c z^2 + d z + e
                axis along (a, b, 1)

    It is the circle about (x_0 + a z, y_0 + b z) at each z, which a tilted cylinder is to first
    order.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        [m]
    """
    x, y, z = (points / np.ptp(points, axis=0).max()).T
    columns = np.column_stack([2 * x * z, 2 * y * z, x, y, z**2, z, np.ones_like(z)])
    (a, b, *_), *_ = np.linalg.lstsq(columns, x**2 + y**2, rcond=None)  # Eq. (M21)
    return np.array([a, b, 1.0]) / np.sqrt(a**2 + b**2 + 1.0)


def pin_direction(mesh: Mesh) -> tuple[np.ndarray, float]:
    """Return the direction of a piston's pin and how far it may be off z [rad].

    It is that of the bores, or of the line between patches of the skirt's inside. The triangles of
    a body known by its nodes alone are too coarse for normals, so that its nodes count.
    """
    if not len(mesh.tets):
        return axis_of_nodes(mesh.points[mesh.nodes("pin_bore")]), TILTED
    axis, tilt = axis_of(mesh, "pin_bore"), TILTED
    if abs(axis[1]) > np.cos(TILTED):  # patches inside the skirt: from one to the other
        points = mesh.points[mesh.nodes("pin_bore")]
        _, _, lines = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
        axis, tilt = lines[0], TILTED_PATCHES
    return axis, tilt


def pin_bore(mesh: Mesh) -> tuple[Circle, bool]:
    """Return where the pin's axis crosses z = 0, and whether the pin bores are a cylinder.

    Bores that are no cylinder have their nodes' mean as axis. Its x is rounded to the nanometre.
    """
    x, y, z = mesh.points[mesh.nodes("pin_bore")].T
    (along_x, along_y, along_z), _ = pin_direction(mesh)
    x, y = x - z * along_x / along_z, y - z * along_y / along_z
    circle = circle_through(x, y)
    round_enough = circle.scatter <= 0.1 * circle.radius
    if not round_enough:
        circle = circle._replace(first=float(x.mean()), second=float(y.mean()))
    return circle._replace(first=round(circle.first, 9)), round_enough


def pin_faults(mesh: Mesh, radius: float, pin_offset: float) -> list[str]:
    """Return the faults of a piston's pin bores, whose axis may be off z by `TILTED`.

    radius : of the skirt [m].
    """
    axis, tilt = pin_direction(mesh)
    across, up, along = axis * np.copysign(1.0, axis[-1])
    if along < np.cos(tilt):
        degrees = np.degrees(np.arccos(along))
        return [
            f"surface 'pin_bore': expected an axis along z, got ({across:.3f}, {up:.3f}, "
            f"{along:.3f}), {degrees:.3g} deg off; set axes to thrust, head and pin"
        ]
    circle, round_enough = pin_bore(mesh)
    height = PIN_HEIGHT if round_enough else PIN_BY_CENTROID
    faults = []
    if abs(circle.second) > height * radius:
        faults.append(
            f"surface 'pin_bore': expected an axis at y = 0, got y = {1e3 * circle.second:.3g} "
            "mm; set origin to the height of the pin"
        )
    return faults + offset_faults(circle.first, radius, pin_offset)


def piston_faults(mesh: Mesh, mass: float, pin_offset: float) -> list[str]:
    """Return a sentence for each fault in position, direction and mass [kg] of a piston.

    A mass that is not a number is not checked.
    """
    faults = cylinder_faults(mesh, "skirt")
    radius = circle_through(*mesh.points[mesh.nodes("skirt")][:, [0, 2]].T).radius
    _, up, _ = area_normals(mesh, "crown").sum(axis=0)
    crown = float(mesh.points[mesh.nodes("crown"), 1].mean())
    skirt = float(mesh.points[mesh.nodes("skirt"), 1].mean())
    if up <= 0.0 or crown <= skirt:
        faults.append(
            "surface 'crown': expected it above the skirt and facing up, got y = "
            f"{1e3 * crown:.3g} mm over {1e3 * skirt:.3g} mm; let y point to the head"
        )
    faults += pin_faults(mesh, radius, pin_offset)
    density = mass / (np.pi * radius**2 * np.ptp(mesh.points[:, 1]))
    if density < LEAST_DENSITY or density > MOST_DENSITY:
        faults.append(
            f"density: expected {LEAST_DENSITY:g} to {MOST_DENSITY:g} kg/m^3 of the cylinder "
            f"around the piston, got {density:.3g} kg/m^3 and {mass:.4g} kg"
        )
    return faults


def block_faults(mesh: Mesh) -> list[str]:
    """Return a sentence for each fault in position and direction of a block."""
    faults = cylinder_faults(mesh, "bore")
    lowest = float(mesh.points[mesh.nodes("bore"), 1].min())
    if lowest <= 0.0:
        faults.append(
            "surface 'bore': expected it above the crank axis at y = 0, got y = "
            f"{1e3 * lowest:.3g} mm; let y point to the head"
        )
    return faults
