"""Make the mesh block.msh.xz of this case next to this script.

It needs gmsh, which running the case does not:

python -m piston_cosim.models.flexible_twin.make_mesh
"""

from pathlib import Path

from ..meshes import TwinBlock, make

BLOCK = TwinBlock(
    bore=55.0,
    wall=9.0,
    pitch=130.0,
    ends=(98.0, 360.0),
    plate=16.0,
    half_width=90.0,
    half_length=145.0,
    floor=-60.0,
    side_wall=11.0,
    bulkhead=22.0,
    bearing=32.0,
    foot=42.0,
)

if __name__ == "__main__":
    make(Path(__file__).parent / "block.msh.xz", BLOCK, 32.0, 10)
