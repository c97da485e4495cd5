"""Make the meshes of this case: piston.msh.gz and block.msh.gz (needs gmsh; running the case does not).

The same construction as models/numerical_example/make_meshes.py (quarter, mirrored twice; millimetres here, metres in the files),
for a larger engine: 73 mm bore, cylinder 103.55 mm long inside.

    python -m models.fired_motorcycle.make_meshes          writes both files beside this script
"""

from pathlib import Path

import gmsh
import numpy as np

from models.numerical_example.make_meshes import cylinder_y, mesh_quarter, mirror, quarter_of, write

BORE = 36.5             # bore radius: 73 mm bore
PISTON = 36.475         # skirt radius in the mesh
LANDS = 36.25           # radius of the ring belt above the skirt
SKIRT = (-14.0, 13.0)   # lower and upper edge of the skirt above pin point A
CROWN_TOP = 28.0
PIN = 8.5               # pin bore radius
BOTTOM, DECK = 62.70, 166.25    # bore ends above the crank axis: 103.55 mm, crown 0.5 mm below the deck at top dead centre
FLANGE, STUD, SEAT = 54.0, 40.5, 10.5


def piston_quarter():
    """Crown 6 mm, thick ring belt, full-round tapered skirt, two inner bosses on pillars."""
    occ = gmsh.model.occ
    low, high = SKIRT
    outer, _ = occ.fuse(cylinder_y(PISTON, low, high), cylinder_y(LANDS, high, CROWN_TOP))
    cavity, _ = occ.fuse(cylinder_y(34.2, low, high, 33.5), cylinder_y(30.0, high, CROWN_TOP - 6.0))
    shell, _ = occ.cut(outer, cavity)
    boss = [(3, occ.addCylinder(0, 0, 11.0, 0, 0, 28.0, 13.0))]
    pillar = [(3, occ.addBox(-9.0, 0.0, 13.0, 18.0, CROWN_TOP - 4.0, 26.0))]
    inner, _ = occ.intersect(occ.fuse(boss, pillar)[0], cylinder_y(35.0, low, CROWN_TOP - 4.0))
    body, _ = occ.fuse(shell, inner)
    body, _ = occ.cut(body, [(3, occ.addCylinder(0, 0, -50, 0, 0, 100, PIN))])
    return quarter_of(body)


def block_quarter():
    """Barrel with base flange, deck flange and four cooling fins; studs pass through both flanges."""
    occ = gmsh.model.occ
    wall = cylinder_y(BORE + 8.0, BOTTOM, DECK)
    plates = [(3, occ.addBox(-FLANGE, low, -FLANGE, 2 * FLANGE, thick, 2 * FLANGE))
              for low, thick in ((BOTTOM, 11.0), (DECK - 11.0, 11.0))]
    fins = [cylinder_y(60.0, low, low + 4.0)[0] for low in (86.0, 103.0, 120.0, 137.0)]
    body, _ = occ.fuse(wall, plates + fins)
    body, _ = occ.cut(body, cylinder_y(BORE, BOTTOM - 1, DECK + 1))
    body, _ = occ.cut(body, [(3, occ.addCylinder(STUD, BOTTOM - 1, STUD, 0, DECK - BOTTOM + 2, 0, 5.0))])
    body = quarter_of(body)
    seat = occ.addDisk(STUD, BOTTOM, STUD, SEAT, SEAT, zAxis=[0, 1, 0])
    return [entity for entity in occ.fragment(body, [(2, seat)])[0] if entity[0] == 3]


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
    seat = np.hypot(np.abs(x) - STUD, np.abs(z) - STUD) < SEAT + tol
    return {"bore": np.abs(np.hypot(x, z) - BORE) < tol, "bolts": (np.abs(y - BOTTOM) < tol) & seat}


def main():
    """Both meshes."""
    here = Path(__file__).parent
    for name, make, find, size, curvature in (("piston", piston_quarter, piston_sets, 4.6, 12),
                                              ("block", block_quarter, block_sets, 12.0, 10)):
        points, tets = mesh_quarter(make, size, curvature)
        for axis in (0, 2):
            points, tets = mirror(points, tets, axis)
        write(here / f"{name}.msh.gz", points, tets, find(points))


if __name__ == "__main__":
    main()
