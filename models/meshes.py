"""Parametric meshes of pistons, blocks and a rod's small end, by gmsh.

One quarter of a body (x >= 0, z >= 0) is meshed with 10-node tetrahedra and mirrored twice. The
mesh is therefore exactly symmetric about the thrust plane z = 0 and about x = 0. Lengths are
in millimetres here, in metres in the files. Axes: x thrust, y towards the head, z along the pin.
The origin of a piston is pin point A. That of a block is on the crank axis, that of a small end
on the axis of its eye.
"""

import lzma
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import gmsh  # pyright: ignore[reportMissingImports]
import meshio
import numpy as np

MM = 1e-3
Entities = list[tuple[int, int]]
"""Dimension and tag of each entity, in gmsh's form."""
NEAR = 1e-4  # distance from a surface below which a node belongs to it [mm]


@dataclass(frozen=True)
class Piston:
    """Piston with crown, ring belt, tapered skirt, bosses on pillars and optional box walls [mm].

    It has no ring grooves.

    Parameters
    ----------
    skirt_radius, land_radius : float
        Outer radii of skirt and ring belt.
    skirt : (float, float)
        Heights of its lower and upper edge above pin point A.
    top, crown : float
        Height of the crown's flat top above A; its thickness.
    skirt_inside : (float, float)
        Inner radius of the skirt at its lower and its upper edge.
    belt_inside : float
        Inner radius of the ring belt.
    pin : float
        Radius of the pin bore, which passes through the skirt.
    boss, boss_from, boss_length : float
        Outer radius of the bosses, their beginning along z, their length before they are cut.
    pillar_width, pillar_from, pillar_length : float
        Box that carries a boss from the crown: width along x, beginning along z, and length before
        it is cut.
    reach, root : float
        Radius at which bosses, pillars and walls end inside the skirt; depth below the top at which
        they end in the crown.
    box_wall : (float, float), optional
        Thickness, and distance from z = 0, of two flat walls that join both thrust sides of the
        skirt.
    cut_beyond : float, optional
        Distance from z = 0 beyond which nothing exists below the ring belt: a slipper, whose skirt
        is two panels on the thrust sides.
    """

    skirt_radius: float
    land_radius: float
    skirt: tuple[float, float]
    top: float
    crown: float
    skirt_inside: tuple[float, float]
    belt_inside: float
    pin: float
    boss: float
    boss_from: float
    boss_length: float
    pillar_width: float
    pillar_from: float
    pillar_length: float
    reach: float
    root: float
    box_wall: tuple[float, float] | None = None
    cut_beyond: float | None = None

    def quarter(self) -> Entities:
        """Return the solid of one quarter in gmsh."""
        occ = gmsh.model.occ
        low, high = self.skirt
        outer, _ = occ.fuse(
            cylinder_y(self.skirt_radius, low, high), cylinder_y(self.land_radius, high, self.top)
        )
        inside_low, inside_high = self.skirt_inside
        cavity, _ = occ.fuse(
            cylinder_y(inside_low, low, high, inside_high),
            cylinder_y(self.belt_inside, high, self.top - self.crown),
        )
        shell, _ = occ.cut(outer, cavity)
        boss = occ.addCylinder(0, 0, self.boss_from, 0, 0, self.boss_length, self.boss)
        pillar = occ.addBox(
            -self.pillar_width / 2,
            0.0,
            self.pillar_from,
            self.pillar_width,
            self.top - self.root,
            self.pillar_length,
        )
        carriers = [(3, pillar)]
        if self.box_wall:
            thickness, distance = self.box_wall
            height = self.top - self.root - low
            wall = occ.addBox(-self.reach, low, distance, 2 * self.reach, height, thickness)
            carriers.append((3, wall))
        joined, _ = occ.fuse([(3, boss)], carriers)
        inner, _ = occ.intersect(joined, cylinder_y(self.reach, low, self.top - self.root))
        body, _ = occ.fuse(shell, inner)
        far = 4 * self.skirt_radius
        if self.cut_beyond is not None:
            side_box = occ.addBox(-far, low - far, self.cut_beyond, 2 * far, high - low + far, far)
            body, _ = occ.cut(body, [(3, side_box)])
        body, _ = occ.cut(body, [(3, occ.addCylinder(0, 0, -far, 0, 0, 2 * far, self.pin))])
        return quarter_of(body)

    def sets(self, points: np.ndarray) -> dict[str, np.ndarray]:
        """Return masks of nodes by name."""
        x, y, z = points.T
        low, high = self.skirt
        return {
            "skirt": (np.abs(np.hypot(x, z) - self.skirt_radius) < NEAR)
            & (y > low - NEAR)
            & (y < high + NEAR),
            "crown": np.abs(y - self.top) < NEAR,
            "pin_bore": np.abs(np.hypot(x, y) - self.pin) < NEAR,
        }


@dataclass(frozen=True)
class Block:
    """Barrel with base and deck flange, cooling fins, four studs and round seats [mm].

    Parameters
    ----------
    bore, wall : float
        Radius of the bore, thickness of the barrel.
    ends : (float, float)
        Heights of base and deck above the crank axis.
    flange, flange_thickness : float
        Half the side of the square flanges; their thickness.
    fins : tuple of float
        Heights of their lower faces.
    fin_radius, fin_thickness : float
    stud, stud_hole, seat : float
        Distance of the studs from x = 0 and from z = 0; radii of their holes and of the seats.
    """

    bore: float
    wall: float
    ends: tuple[float, float]
    flange: float
    flange_thickness: float
    fins: tuple[float, ...]
    fin_radius: float
    fin_thickness: float
    stud: float
    stud_hole: float
    seat: float

    def quarter(self) -> Entities:
        """Return the solid of one quarter in gmsh."""
        occ = gmsh.model.occ
        low, high = self.ends
        side = 2 * self.flange
        plates = [
            (3, occ.addBox(-self.flange, at, -self.flange, side, self.flange_thickness, side))
            for at in (low, high - self.flange_thickness)
        ]
        fins = [cylinder_y(self.fin_radius, at, at + self.fin_thickness)[0] for at in self.fins]
        body, _ = occ.fuse(cylinder_y(self.bore + self.wall, low, high), plates + fins)
        body, _ = occ.cut(body, cylinder_y(self.bore, low - 1, high + 1))
        hole = occ.addCylinder(self.stud, low - 1, self.stud, 0, high - low + 2, 0, self.stud_hole)
        body, _ = occ.cut(body, [(3, hole)])
        body = quarter_of(body)
        seat = occ.addDisk(self.stud, low, self.stud, self.seat, self.seat, zAxis=[0, 1, 0])
        fragments, _ = occ.fragment(body, [(2, seat)])
        return [(dimension, tag) for dimension, tag in fragments if dimension == 3]

    def sets(self, points: np.ndarray) -> dict[str, np.ndarray]:
        """Return masks of nodes by name."""
        x, y, z = points.T
        seat = np.hypot(np.abs(x) - self.stud, np.abs(z) - self.stud) < self.seat + NEAR
        return {
            "bore": np.abs(np.hypot(x, z) - self.bore) < NEAR,
            "bolts": (np.abs(y - self.ends[0]) < NEAR) & seat,
        }


@dataclass(frozen=True)
class TwinBlock:
    """Two joined barrels in line, between a deck and a crankcase that is open below [mm].

    The crankcase has a flange, two side walls, three bulkheads with the main bearings, and four
    feet.

    Parameters
    ----------
    bore, wall : float
        Radius of the bores, thickness of the barrels.
    pitch : float
        Distance of the bores' axes, x = 0, z = -pitch/2 and pitch/2.
    ends : (float, float)
        Heights of the barrels' lower end and of the deck above the crank axis.
    plate : float
        Thickness of deck and flange.
    half_width, half_length : float
        Half the size of deck, flange and crankcase, along x and z.
    floor : float
        Height of the feet's soles, below the crank axis.
    side_wall, bulkhead : float
        Thicknesses. One bulkhead is in the middle and one at each end.
    bearing : float
        Radius of the main bearings.
    foot : float
        Side of the square feet, outside the side walls at their ends; their height is `plate`.
    """

    bore: float
    wall: float
    pitch: float
    ends: tuple[float, float]
    plate: float
    half_width: float
    half_length: float
    floor: float
    side_wall: float
    bulkhead: float
    bearing: float
    foot: float

    def quarter(self) -> Entities:
        """Return the solid of one quarter in gmsh."""
        occ = gmsh.model.occ
        low, high = self.ends
        wide, long = self.half_width, self.half_length
        outer = self.bore + self.wall

        def box(x, y, z, dx, dy, dz):
            return 3, occ.addBox(x, y, z, dx, dy, dz)

        def barrel(radius, from_, to):
            tag = occ.addCylinder(0, from_, self.pitch / 2, 0, to - from_, 0, radius)
            return 3, tag

        height = low + self.plate - self.floor
        half = self.bulkhead / 2
        parts = [
            box(0, high - self.plate, 0, wide, self.plate, long),
            box(0, low, 0, wide, self.plate, long),
            box(wide - self.side_wall, self.floor, 0, self.side_wall, height, long),
            box(0, self.floor, 0, wide, height, half),
            box(0, self.floor, long - self.bulkhead, wide, height, self.bulkhead),
            box(wide, self.floor, long - self.foot, self.foot, self.plate, self.foot),
        ]
        body, _ = occ.fuse([barrel(outer, low, high)], parts)
        holes = [
            barrel(self.bore, low - 1, high + 1),
            (3, occ.addCylinder(0, 0, -long, 0, 0, 3 * long, self.bearing)),
        ]
        body, _ = occ.cut(body, holes)
        return quarter_of(body, 2 * high)

    def sets(self, points: np.ndarray) -> dict[str, np.ndarray]:
        """Return masks of nodes by name: bores and bearings along z, feet by z, then by x."""
        x, y, z = points.T
        low, high = self.ends
        long = self.half_length
        inside = (y > low - NEAR) & (y < high + NEAR)
        round_crank = np.abs(np.hypot(x, y) - self.bearing) < NEAR
        middles = (-long + self.bulkhead / 2, 0.0, long - self.bulkhead / 2)
        sole = np.abs(y - self.floor) < NEAR
        outer = np.abs(x) > self.half_width - NEAR
        near_end = np.abs(z) > long - self.foot - NEAR
        corners = [(sign_x, sign_z) for sign_z in (-1, 1) for sign_x in (-1, 1)]
        return {
            **{
                f"bore_{k}": inside & (np.abs(np.hypot(x, z - at) - self.bore) < NEAR)
                for k, at in enumerate((-self.pitch / 2, self.pitch / 2), 1)
            },
            "deck": np.abs(y - high) < NEAR,
            **{
                f"bearing_{k}": round_crank & (np.abs(z - at) < self.bulkhead / 2 + NEAR)
                for k, at in enumerate(middles, 1)
            },
            **{
                f"mount_{k}": sole & outer & near_end & (sign_x * x > 0) & (sign_z * z > 0)
                for k, (sign_x, sign_z) in enumerate(corners, 1)
            },
        }


@dataclass(frozen=True)
class SmallEnd:
    """Eye of a rod on a piece of its shank with flat sides; the crank is towards -y [mm].

    Parameters
    ----------
    bore, outside : float
        Inner and outer radius of the eye.
    length : float
        Length of the eye along the pin.
    shank : (float, float)
        Size of the shank's section along x and z.
    cut : float
        Distance of the shank's cut from the eye's axis.
    """

    bore: float
    outside: float
    length: float
    shank: tuple[float, float]
    cut: float

    def quarter(self) -> Entities:
        """Return the solid of one quarter in gmsh."""
        occ = gmsh.model.occ
        wide, thick = self.shank
        half = self.length / 2
        eye = occ.addCylinder(0, 0, -half, 0, 0, self.length, self.outside)
        shank = occ.addBox(-wide / 2, -self.cut, -thick / 2, wide, self.cut, thick)
        body, _ = occ.fuse([(3, eye)], [(3, shank)])
        body, _ = occ.cut(body, [(3, occ.addCylinder(0, 0, -half, 0, 0, self.length, self.bore))])
        return quarter_of(body)

    def sets(self, points: np.ndarray) -> dict[str, np.ndarray]:
        """Return masks of nodes by name."""
        x, y, _ = points.T
        return {
            "eye": np.abs(np.hypot(x, y) - self.bore) < NEAR,
            "cut": np.abs(y + self.cut) < NEAR,
        }


class Shape(Protocol):
    """Body that can be meshed: Piston, Block, TwinBlock or SmallEnd."""

    def quarter(self) -> Entities:
        """Return the solid of one quarter in gmsh."""
        ...

    def sets(self, points: np.ndarray) -> dict[str, np.ndarray]:
        """Return masks of nodes by name."""
        ...


def cylinder_y(radius: float, low: float, high: float, top_radius: float | None = None) -> Entities:
    """Return a quarter of a solid of revolution about y (x >= 0, z >= 0)."""
    occ = gmsh.model.occ
    if top_radius is None:
        tag = occ.addCylinder(0, low, 0, 0, high - low, 0, radius)
    else:
        tag = occ.addCone(0, low, 0, 0, high - low, 0, radius, top_radius)
    return [(3, tag)]


def quarter_of(solid: Entities, reach: float = 300.0) -> Entities:
    """Return the part x >= 0, z >= 0 of a solid within a reach in all directions [mm]."""
    occ = gmsh.model.occ
    quarter, _ = occ.intersect(solid, [(3, occ.addBox(0, -reach, 0, reach, 2 * reach, reach))])
    return quarter


def mesh_quarter(
    make: Callable[[], Entities], size: float, curvature: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes [mm] and 10-node tetrahedra of one quarter."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    make()
    gmsh.model.occ.synchronize()
    loose = set(gmsh.model.getEntities(2)) - {
        (2, abs(t)) for _, t in gmsh.model.getBoundary(gmsh.model.getEntities(3))
    }
    gmsh.model.removeEntities(sorted(loose), recursive=True)
    for name, value in (
        ("MeshSizeMax", size),
        ("MeshSizeMin", 0.35 * size),
        ("MeshSizeFromCurvature", curvature),
        ("Algorithm3D", 1),
        ("Optimize", 1),
        ("RandomSeed", 1),
    ):
        gmsh.option.setNumber("Mesh." + name, value)
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.setOrder(2)
    gmsh.model.mesh.optimize("HighOrder")
    tags, points, _ = gmsh.model.mesh.getNodes()
    kinds, _, nodes = gmsh.model.mesh.getElements(3)
    tets = np.asarray(nodes[list(kinds).index(11)], dtype=np.int64).reshape(-1, 10)
    gmsh.finalize()
    used, tets = np.unique(tets, return_inverse=True)
    number = {tag: k for k, tag in enumerate(tags)}
    points = points.reshape(-1, 3)[[number[tag] for tag in used]]
    # gmsh swaps the last two edge nodes
    tets = tets.reshape(-1, 10)[:, [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]]
    return np.where(np.abs(points) < 1e-7, 0.0, points), tets


def mirror(points: np.ndarray, tets: np.ndarray, axis: int) -> tuple[np.ndarray, np.ndarray]:
    """Add the mirror image about the plane axis = 0.

    Nodes on the plane are shared, and the orientation remains positive.
    """
    image = np.arange(len(points)) + len(points)
    on_plane = points[:, axis] == 0.0
    image[on_plane] = np.flatnonzero(on_plane)
    image[~on_plane] = len(points) + np.arange((~on_plane).sum())
    flipped = points[~on_plane].copy()
    flipped[:, axis] *= -1.0
    swapped = image[tets][:, [1, 0, 2, 3, 4, 6, 5, 8, 7, 9]]
    return np.vstack([points, flipped]), np.vstack([tets, swapped])


def outer_faces(tets: np.ndarray) -> np.ndarray:
    """Return the 6-node triangles that belong to only one tetrahedron."""
    local = np.array(
        [[0, 2, 1, 6, 5, 4], [0, 1, 3, 4, 8, 7], [1, 2, 3, 5, 9, 8], [0, 3, 2, 7, 9, 6]]
    )
    faces = tets[:, local].reshape(-1, 6)
    key = np.sort(faces[:, :3], axis=1)
    _, first, count = np.unique(key, axis=0, return_index=True, return_counts=True)
    return faces[first[count == 1]]


def write(path: Path, points: np.ndarray, tets: np.ndarray, sets: dict[str, np.ndarray]) -> None:
    """Write an xz-compressed gmsh 2.2 file with the volume group "all" and the surfaces of `sets`.

    Equal input gives equal bytes.
    """
    faces = outer_faces(tets)
    groups = [(name, faces[mask[faces].all(axis=1)]) for name, mask in sets.items()]
    cells: list[Any] = [("tetra10", tets)] + [("triangle6", group) for _, group in groups]
    tags: list[Any] = [np.full(len(block), k) for k, (_, block) in enumerate(cells, 1)]
    field_data = {name: np.array([k, 2]) for k, (name, _) in enumerate(groups, 2)}
    field_data["all"] = np.array([1, 3])
    mesh = meshio.Mesh(
        points * MM,
        cells,
        cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags},
        field_data=field_data,
    )
    with tempfile.TemporaryDirectory() as folder:
        plain = Path(folder) / "mesh.msh"
        meshio.write(plain, mesh, file_format="gmsh22", binary=True)
        path.write_bytes(lzma.compress(plain.read_bytes(), preset=9 | lzma.PRESET_EXTREME))
    surfaces = ", ".join(f"{name} {len(group)} faces" for name, group in groups)
    print(
        f"{path.name}: {len(points)} nodes, {len(tets)} tetrahedra, "
        f"{path.stat().st_size / 1e6:.2f} MB, {surfaces}"
    )


def make(path: Path, shape: Shape, size: float, curvature: int) -> None:
    """Write the mesh file of a body.

    Parameters
    ----------
    path : Path
        With suffix .msh.xz.
    shape : Piston, Block, TwinBlock or SmallEnd
    size : float
        Largest edge of an element [mm].
    curvature : int
        Minimum number of elements around a full circle.
    """
    points, tets = mesh_quarter(shape.quarter, size, curvature)
    for axis in (0, 2):
        points, tets = mirror(points, tets, axis)
    write(path, points, tets, shape.sets(points))
