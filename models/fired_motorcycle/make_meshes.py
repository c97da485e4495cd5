"""Make the meshes piston.msh.xz and block.msh.xz of this case next to this script.

It needs gmsh, which running the case does not:

python -m piston_cosim.models.fired_motorcycle.make_meshes
"""

from pathlib import Path

from ..meshes import Block, Piston, make

PISTON = Piston(
    skirt_radius=36.475,
    land_radius=36.25,
    skirt=(-14.0, 13.0),
    top=28.0,
    crown=6.0,
    skirt_inside=(34.2, 33.5),
    belt_inside=30.0,
    pin=8.5,
    boss=13.0,
    boss_from=11.0,
    boss_length=28.0,
    pillar_width=18.0,
    pillar_from=13.0,
    pillar_length=26.0,
    reach=35.0,
    root=4.0,
)
BLOCK = Block(
    bore=36.5,
    wall=8.0,  # 73 mm bore
    ends=(62.70, 166.25),  # 103.55 mm inside, crown 0.5 mm below the deck at top dead centre
    flange=54.0,
    flange_thickness=11.0,
    fins=(86.0, 103.0, 120.0, 137.0),
    fin_radius=60.0,
    fin_thickness=4.0,
    stud=40.5,
    stud_hole=5.0,
    seat=10.5,
)

if __name__ == "__main__":
    make(Path(__file__).with_name("piston.msh.xz"), PISTON, 4.6, 12)
    make(Path(__file__).with_name("block.msh.xz"), BLOCK, 12.0, 10)
