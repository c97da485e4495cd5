"""Make the mesh small_end.msh.xz of the rod's small end next to this script.

It needs gmsh, which running the case does not:

python -m piston_cosim.models.yielding_bosses.make_mesh
"""

from pathlib import Path

from ..meshes import SmallEnd, make

SMALL_END = SmallEnd(bore=8.5, outside=12.5, length=20.0, shank=(16.0, 9.0), cut=34.0)

if __name__ == "__main__":
    make(Path(__file__).parent / "small_end.msh.xz", SMALL_END, size=3.5, curvature=36)
