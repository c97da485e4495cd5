"""Make the meshes of this case: piston.msh.gz and block.msh.gz (needs gmsh; running the case does not).

One quarter of each body (x >= 0, z >= 0) is meshed with 10-node tetrahedra and mirrored twice, so that both meshes are
symmetric to the last bit about the thrust plane z = 0 and about x = 0. All lengths in millimetres inside gmsh, metres in the
files. Axes: x thrust, y towards the head, z along the pin; the piston's origin is pin point A, the block's lies on the crank
axis.

    python make_meshes.py            writes both files beside this script
"""

import gzip
import tempfile
from pathlib import Path

import gmsh
import meshio
import numpy as np

MM = 1e-3
BORE = 28.25            # bore radius: 56.5 mm bore, the published 124 cm3 single
PISTON = 28.225         # skirt radius (25 um nominal radial clearance)
LANDS = 28.05           # radius of the ring belt above the skirt
SKIRT = (-16.0, 11.0)   # lower and upper edge of the skirt above pin point A
CROWN_TOP = 26.0
PIN = 7.0               # pin bore radius
BOTTOM, DECK = 56.25, 151.25    # bore ends above the crank axis: 95 mm, crown 0.5 mm below the deck at top dead centre
FLANGE, STUD = 43.0, (31.5, 31.5)


def cylinder_y(radius, low, high, top_radius=None):
    """Solid of revolution about y, a quarter of it (x >= 0, z >= 0)."""
    occ = gmsh.model.occ
    if top_radius is None:
        tag = occ.addCylinder(0, low, 0, 0, high - low, 0, radius)
    else:
        tag = occ.addCone(0, low, 0, 0, high - low, 0, radius, top_radius)
    return [(3, tag)]


def quarter_of(solid):
    """Keep x >= 0, z >= 0."""
    occ = gmsh.model.occ
    return occ.intersect(solid, [(3, occ.addBox(0, -300, 0, 300, 600, 300))])[0]


def piston_quarter():
    """Crown 5 mm, thick ring belt, full-round tapered skirt, two inner bosses on pillars."""
    occ = gmsh.model.occ
    low, high = SKIRT
    outer, _ = occ.fuse(cylinder_y(PISTON, low, high), cylinder_y(LANDS, high, CROWN_TOP))
    cavity, _ = occ.fuse(cylinder_y(26.5, low, high, 26.0), cylinder_y(23.0, high, CROWN_TOP - 5.0))
    shell, _ = occ.cut(outer, cavity)
    boss = [(3, occ.addCylinder(0, 0, 9.0, 0, 0, 22.0, 11.5))]
    pillar = [(3, occ.addBox(-7.5, 0.0, 11.0, 15.0, CROWN_TOP - 3.0, 20.0))]
    inner, _ = occ.intersect(occ.fuse(boss, pillar)[0], cylinder_y(27.0, low, CROWN_TOP - 3.0))
    body, _ = occ.fuse(shell, inner)
    body, _ = occ.cut(body, [(3, occ.addCylinder(0, 0, -40, 0, 0, 80, PIN))])
    return quarter_of(body)


def block_quarter():
    """Barrel with base flange, deck flange and three cooling fins; studs pass through both flanges."""
    occ = gmsh.model.occ
    wall = cylinder_y(BORE + 7.0, BOTTOM, DECK)
    plates = [(3, occ.addBox(-FLANGE, low, -FLANGE, 2 * FLANGE, thick, 2 * FLANGE))
              for low, thick in ((BOTTOM, 10.0), (DECK - 10.0, 10.0))]
    fins = [cylinder_y(47.0, low, low + 4.0)[0] for low in (82.0, 102.0, 122.0)]
    body, _ = occ.fuse(wall, plates + fins)
    body, _ = occ.cut(body, cylinder_y(BORE, BOTTOM - 1, DECK + 1))
    body, _ = occ.cut(body, [(3, occ.addCylinder(STUD[0], BOTTOM - 1, STUD[1], 0, DECK - BOTTOM + 2, 0, 4.5))])
    body = quarter_of(body)
    seat = occ.addDisk(STUD[0], BOTTOM, STUD[1], 9.0, 9.0, zAxis=[0, 1, 0])
    return [entity for entity in occ.fragment(body, [(2, seat)])[0] if entity[0] == 3]


def mesh_quarter(make, size, curvature):
    """Nodes [mm] and 10-node tetrahedra of one quarter."""
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    make()
    gmsh.model.occ.synchronize()
    loose = set(gmsh.model.getEntities(2)) - {(2, abs(t)) for _, t in gmsh.model.getBoundary(gmsh.model.getEntities(3))}
    gmsh.model.removeEntities(sorted(loose), recursive=True)
    for name, value in (("MeshSizeMax", size), ("MeshSizeMin", 0.35 * size), ("MeshSizeFromCurvature", curvature),
                        ("Algorithm3D", 1), ("Optimize", 1), ("RandomSeed", 1)):
        gmsh.option.setNumber("Mesh." + name, value)
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.setOrder(2)
    gmsh.model.mesh.optimize("HighOrder")
    tags, points, _ = gmsh.model.mesh.getNodes()
    kinds, _, nodes = gmsh.model.mesh.getElements(3)
    tets = np.asarray(nodes[list(kinds).index(11)], dtype=np.int64).reshape(-1, 10)
    gmsh.finalize()
    used, tets = np.unique(tets, return_inverse=True)
    place = {tag: k for k, tag in enumerate(tags)}
    points = points.reshape(-1, 3)[[place[tag] for tag in used]]
    tets = tets.reshape(-1, 10)[:, [0, 1, 2, 3, 4, 5, 6, 7, 9, 8]]      # gmsh swaps the last two edge nodes
    return np.where(np.abs(points) < 1e-7, 0.0, points), tets


def mirror(points, tets, axis):
    """Add the mirror image about the plane axis = 0; nodes on the plane are shared, orientation stays positive."""
    image = np.arange(len(points)) + len(points)
    on_plane = points[:, axis] == 0.0
    image[on_plane] = np.flatnonzero(on_plane)
    image[~on_plane] = len(points) + np.arange((~on_plane).sum())
    flipped = points[~on_plane].copy()
    flipped[:, axis] *= -1.0
    swapped = image[tets][:, [1, 0, 2, 3, 4, 6, 5, 8, 7, 9]]
    return np.vstack([points, flipped]), np.vstack([tets, swapped])


def outer_faces(tets):
    """6-node triangles that belong to one tetrahedron only."""
    local = np.array([[0, 2, 1, 6, 5, 4], [0, 1, 3, 4, 8, 7], [1, 2, 3, 5, 9, 8], [0, 3, 2, 7, 9, 6]])
    faces = tets[:, local].reshape(-1, 6)
    key = np.sort(faces[:, :3], axis=1)
    _, first, count = np.unique(key, axis=0, return_index=True, return_counts=True)
    return faces[first[count == 1]]


def piston_sets(points):
    """Named node masks of the piston."""
    x, y, z = points.T
    tol = 1e-4
    return {"skirt": (np.abs(np.hypot(x, z) - PISTON) < tol) & (y > SKIRT[0] - tol) & (y < SKIRT[1] + tol),
            "crown": np.abs(y - CROWN_TOP) < tol, "pin_bore": np.abs(np.hypot(x, y) - PIN) < tol}


def block_sets(points):
    """Named node masks of the block."""
    x, y, z = points.T
    tol = 1e-4
    seat = np.hypot(np.abs(x) - STUD[0], np.abs(z) - STUD[1]) < 9.0 + tol
    return {"bore": np.abs(np.hypot(x, z) - BORE) < tol, "bolts": (np.abs(y - BOTTOM) < tol) & seat}


def write(path, points, tets, sets):
    """gzip-packed gmsh 2.2 file with the volume group "all" and the surface groups of `sets`; same bytes every time."""
    faces = outer_faces(tets)
    groups = [(name, faces[mask[faces].all(axis=1)]) for name, mask in sets.items()]
    cells = [("tetra10", tets)] + [("triangle6", group) for _, group in groups]
    tags = [np.full(len(c[1]), k + 1) for k, c in enumerate(cells)]
    field_data = {name: np.array([k + 2, 2]) for k, (name, _) in enumerate(groups)} | {"all": np.array([1, 3])}
    mesh = meshio.Mesh(points * MM, cells, cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags}, field_data=field_data)
    with tempfile.TemporaryDirectory() as folder:
        plain = Path(folder) / "mesh.msh"
        meshio.write(plain, mesh, file_format="gmsh22", binary=True)
        path.write_bytes(gzip.compress(plain.read_bytes(), mtime=0))
    print(f"{path.name}: {len(points)} nodes, {len(tets)} tetrahedra, {path.stat().st_size / 1e6:.2f} MB, "
          + ", ".join(f"{name} {len(group)} faces" for name, group in groups))


def main():
    """Both meshes."""
    here = Path(__file__).parent
    for name, make, find, size, curvature in (("piston", piston_quarter, piston_sets, 3.9, 12),
                                              ("block", block_quarter, block_sets, 9.0, 10)):
        points, tets = mesh_quarter(make, size, curvature)
        for axis in (0, 2):
            points, tets = mirror(points, tets, axis)
        write(here / f"{name}.msh.gz", points, tets, find(points))


if __name__ == "__main__":
    main()
